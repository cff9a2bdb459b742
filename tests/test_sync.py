# SPDX-License-Identifier: GPL-3.0-or-later
"""What is exported again after an edit in Blender, and what is not: each kind of edit changes its own records alone.

Blender's own updates are used, as a viewport gets them; what native code makes of it is test_editable_scene.py's.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat, export
from cotorra.export import geometry
from cotorra.export.buffers import SceneBuffers
from cotorra.log import Log
from cotorra.sync import changes, stores
from cotorra.sync.kept import Kept

from scenes import build
from scenes.depsgraphs import exported

pytestmark = pytest.mark.usefixtures('engine')


class Watched:
    """Exports as a viewport makes them: told of updates, with what earlier ones kept."""

    def __init__(self) -> None:
        self.kept = Kept()
        self.read: list[str] = []
        self.log = Log()
        self.last: SceneBuffers | None = None

    def note(self, _scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        self.kept.note(depsgraph.updates)

    def export(self) -> SceneBuffers:
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.read.clear()
        self.log = Log()
        scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        self.last = export.export_scene(depsgraph, scene, layer, self.log, kept=self.kept)
        return self.last


@pytest.fixture
def watched(monkeypatch: pytest.MonkeyPatch) -> Iterator[Watched]:
    found = Watched()
    read_mesh, read_shader = geometry.read_mesh, export.shaders.shader.shaders_of

    def note_mesh(mesh: bpy.types.Mesh, *arguments: object) -> object:
        found.read.append(mesh.original.name if mesh.original else mesh.name)
        return read_mesh(mesh, *arguments)

    def note_shader(owner: bpy.types.ID, *arguments: object) -> object:
        found.read.append(owner.name)
        return read_shader(owner, *arguments)

    monkeypatch.setattr(geometry, 'read_mesh', note_mesh)
    monkeypatch.setattr(export.shaders.shader, 'shaders_of', note_shader)
    made()
    bpy.app.handlers.depsgraph_update_post.append(found.note)
    bpy.app.handlers.frame_change_post.append(found.note)
    yield found
    bpy.app.handlers.depsgraph_update_post.remove(found.note)
    bpy.app.handlers.frame_change_post.remove(found.note)


def made() -> None:
    scene = build.new_scene()
    build.camera(scene)
    for name in ('A', 'B'):
        obj = build.mesh_object(scene, name)
        material = bpy.data.materials.new(f'of {name}')
        compat.principled(material).inputs['Roughness'].default_value = 0.4 if name == 'A' else 0.6
        obj.data.materials.append(material)
    lamp = build.link(scene, 'Lamp', bpy.data.lights.new('Lamp', 'POINT'))
    lamp.location = (0.0, 0.0, 3.0)
    scene.world = bpy.data.worlds.new('World')
    compat.background(scene.world).inputs['Color'].default_value = (0.2, 0.3, 0.4, 1.0)


def move() -> None:
    bpy.data.objects['A'].location.x += 1.0


def vertex() -> None:
    mesh = bpy.data.meshes['A']
    mesh.vertices[0].co.z += 1.0
    mesh.update()


def modifier() -> None:
    bpy.data.objects['B'].modifiers.new('Subdivision', 'SUBSURF').levels = 2


def roughness() -> None:
    compat.principled(bpy.data.materials['of A']).inputs['Roughness'].default_value = 0.9


def energy() -> None:
    bpy.data.lights['Lamp'].energy *= 2.0


def lamp_moved() -> None:
    bpy.data.objects['Lamp'].location.x += 1.0


def world() -> None:
    compat.background(bpy.data.worlds['World']).inputs['Strength'].default_value = 3.0


def hide() -> None:
    bpy.data.objects['A'].hide_viewport = True


def delete() -> None:
    bpy.data.objects.remove(bpy.data.objects['A'])


def add() -> None:
    build.mesh_object(bpy.context.scene, 'C')


def slot() -> None:
    bpy.data.meshes['B'].materials[0] = bpy.data.materials['of A']


def own_setting() -> None:
    bpy.data.materials['of A'].cotorra.model = 'LAMBERT'


def rename() -> None:
    bpy.data.objects['A'].name = 'Renamed'


def select() -> None:
    bpy.data.objects['A'].select_set(True)


def camera_moved() -> None:
    bpy.context.scene.camera.location.x += 1.0


# The edit; what is read again; which of the arrays change.
EDITS = {
    'move': (move, [], {'instances'}),
    'vertex': (vertex, ['A'], {'meshes'}),
    'modifier': (modifier, ['B'], {'meshes'}),
    'roughness': (roughness, ['of A'], {'shaders'}),
    'energy': (energy, ['Lamp'], {'lights'}),
    'lamp moved': (lamp_moved, [], {'lights'}),
    'world': (world, ['World'], {'shaders'}),
    'hide': (hide, [], {'meshes', 'instances', 'materials', 'material_slots', 'shaders', 'world', 'lights'}),
    'delete': (delete, [], {'meshes', 'instances', 'materials', 'material_slots', 'shaders', 'world', 'lights'}),
    'add': (add, ['C'], {'meshes', 'instances', 'material_slots'}),
    'slot': (slot, ['B'], {'meshes', 'instances', 'materials', 'material_slots', 'shaders', 'world', 'lights'}),
    'own setting': (own_setting, ['of A'], {'materials'}),
    'rename': (rename, [], {'instances'}),
    'select': (select, [], set()),
    'camera moved': (camera_moved, [], set()),
}


@pytest.mark.parametrize('name', EDITS)
def test_an_edit_reads_again_what_it_changed(watched: Watched, name: str) -> None:
    edit, read, arrays = EDITS[name]
    before = watched.export()
    assert sorted(watched.read) == ['A', 'B', 'Lamp', 'World', 'of A', 'of B']
    again = watched.export()
    assert watched.read == [] and changes.equal(before, again)
    edit()
    after = watched.export()
    # Reading too much is slow, too little is wrong.
    assert watched.read == read
    names = [field.name for field in fields(SceneBuffers)]
    different = {name for name in names if not changes._equal(getattr(before, name), getattr(after, name))}
    assert different <= arrays and bool(different) == bool(arrays)
    assert changes.equal(before, after) == (not arrays)
    # It is what an export without a memory gives.
    assert contents(after) == contents(exported(bpy.context.scene))


def contents(value: object) -> object:
    """For comparisons of what is in arrays, those of meshes and images included."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, tuple):
        return tuple(map(contents, value))
    if hasattr(value, '__dataclass_fields__'):
        return type(value).__name__, tuple(contents(getattr(value, f.name)) for f in fields(value))
    return value


def test_a_group_and_an_object_that_a_tree_asks_make_its_shader_new(watched: Watched) -> None:
    """Blender says so of the material; that it does is what is relied upon."""
    tree = bpy.data.node_groups.new('Group', 'ShaderNodeTree')
    tree.interface.new_socket('Value', in_out='OUTPUT', socket_type='NodeSocketFloat')
    inside = tree.nodes.new('NodeGroupOutput')
    material = bpy.data.materials['of A']
    nodes, node = material.node_tree, compat.principled(material)
    group = nodes.nodes.new('ShaderNodeGroup')
    group.node_tree = tree
    nodes.links.new(group.outputs[0], node.inputs['Roughness'])
    at = nodes.nodes.new('ShaderNodeTexCoord')
    at.object = build.link(bpy.context.scene, 'Where', None)
    nodes.links.new(at.outputs['Object'], node.inputs['Base Color'])
    watched.export()
    for edit in (
        lambda: setattr(inside.inputs[0], 'default_value', 0.7),
        lambda: setattr(bpy.data.objects['Where'].location, 'x', 2.0),
    ):
        edit()
        watched.export()
        assert watched.read == ['of A']


def textured(path: Path) -> bpy.types.Image:
    image = bpy.data.images.new('Saved', 4, 4)
    image.filepath_raw, image.file_format = str(path), 'PNG'
    image.save()
    loaded = bpy.data.images.load(str(path))
    material = bpy.data.materials['of A']
    node = material.node_tree.nodes.new('ShaderNodeTexImage')
    node.image = loaded
    material.node_tree.links.new(node.outputs['Color'], compat.principled(material).inputs['Base Color'])
    return loaded


def test_images_are_kept_until_one_changes(watched: Watched, tmp_path: Path) -> None:
    image = textured(tmp_path / 'image.png')
    before = watched.export()
    move()
    after = watched.export()
    assert watched.read == [] and after.images[0] is before.images[0]
    # Another material is read beside it, and its image stays.
    roughness_of_b = compat.principled(bpy.data.materials['of B']).inputs['Roughness']
    roughness_of_b.default_value = 0.1
    assert watched.export().images[0] is before.images[0]
    assert watched.read == ['of B']
    other = bpy.data.images.new('Other', 4, 4, float_buffer=False)
    other.generated_color = (1.0, 0.0, 0.0, 1.0)
    other.filepath_raw, other.file_format = image.filepath, 'PNG'
    other.save()
    image.reload()
    image.update_tag()
    found = watched.export()
    assert watched.read == ['of A'] and found.images[0].pixels[0, 0, 0] == 255


def test_pixels_in_blender_are_read_each_time(watched: Watched, tmp_path: Path) -> None:
    """They may be painted on without a word; what is in files is not decoded again for it."""
    textured(tmp_path / 'image.png')
    material = bpy.data.materials['of B']
    node = material.node_tree.nodes.new('ShaderNodeTexImage')
    node.image = bpy.data.images.new('Painted', 2, 2)
    material.node_tree.links.new(node.outputs['Color'], compat.principled(material).inputs['Base Color'])
    before = {image.name: image for image in watched.export().images}
    for value in (255, 0):
        node.image.pixels = [value / 255.0] * 16
        found = {image.name: image for image in watched.export().images}
        assert found.keys() == before.keys() and len(found) == 2
        assert found['Painted'].pixels.min() == found['Painted'].pixels.max() == value
        assert found['image.png'] is before['image.png']
    # A shader that is read has the numbers that the table has now.
    assert contents(watched.last) == contents(exported(bpy.context.scene))


def test_a_sequence_is_read_each_time(watched: Watched, tmp_path: Path) -> None:
    image = textured(tmp_path / 'image_0001.png')
    image.source = 'SEQUENCE'
    watched.export()
    watched.export()
    assert watched.read == ['of A']


def test_edit_mode_shows_what_is_edited(watched: Watched) -> None:
    obj = bpy.data.objects['A']
    bpy.context.view_layer.objects.active = obj
    watched.export()
    bpy.ops.object.mode_set(mode='EDIT')
    try:
        for _ in range(2):
            watched.export()
            assert 'A' in watched.read  # nothing is kept of what may change in place
    finally:
        bpy.ops.object.mode_set(mode='OBJECT')


def test_frames_read_what_moves_alone(watched: Watched) -> None:
    obj = bpy.data.objects['A']
    for frame, x in ((1, 0.0), (10, 3.0)):
        obj.location.x = x
        obj.keyframe_insert('location', frame=frame)
    bpy.context.scene.frame_set(1)
    first = watched.export()
    bpy.context.scene.frame_set(5)
    second = watched.export()
    assert watched.read == []
    assert [a is b for a, b in zip(first.meshes, second.meshes, strict=True)] == [True, True]
    assert (first.instances.transform != second.instances.transform).any()


def test_messages_are_said_with_what_is_kept(watched: Watched) -> None:
    mesh = bpy.data.meshes['A']
    mesh.vertices[0].co.x = float('nan')
    mesh.update()
    watched.export()
    said = watched.log.texts('WARNING')
    assert any('NaN' in text for text in said)
    watched.export()
    assert watched.read == [] and watched.log.texts('WARNING') == said


def test_what_is_deleted_is_not_kept(watched: Watched) -> None:
    watched.export()
    assert len(watched.kept._meshes) == 2 and len(watched.kept._shaders) == 4
    delete()
    watched.export()
    assert len(watched.kept._meshes) == 1 and len(watched.kept._shaders) == 3


def test_viewports_of_one_view_layer_share_a_store() -> None:
    made()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    store = stores.store_of(depsgraph)
    assert stores.store_of(depsgraph) is store
    count = len(stores._stores)
    del store
    assert len(stores._stores) == count - 1


def test_undo_makes_shaders_out_of_date(watched: Watched) -> None:
    """What loads or undoes calls the handler, as Blender calls it."""
    store = stores.store_of(bpy.context.evaluated_depsgraph_get())
    store.kept = watched.kept
    watched.export()
    for name in stores.HANDLERS:
        assert stores._forget in getattr(bpy.app.handlers, name)
    stores._forget()
    watched.export()
    assert sorted(watched.read) == ['Lamp', 'World', 'of A', 'of B']
