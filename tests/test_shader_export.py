# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes bring what their shaders look up: attributes, properties, object and particle info, tiles; Cycles says what.

Each value is constant over a square that both read: Cycles renders it, here the shader is evaluated with the arrays.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import shader
from cotorra.export import attributes
from cotorra.export.buffers import SceneBuffers
from cotorra.log import Log

from beside_cycles import in_halves
from flat_scenes import Flat, flat, shining, shown
from scenes import build
from scenes.depsgraphs import exported
from shader_reading import Read, Values

pytestmark = pytest.mark.usefixtures('engine')


def evaluated(buffers: SceneBuffers, instance: int = 0) -> np.ndarray:
    """What the first triangle of an instance emits at its first corner."""
    objects = buffers.instances
    mesh = buffers.meshes[objects.mesh[instance]]
    material = buffers.material_slots[objects.material_base[instance]]
    made = buffers.shaders[buffers.materials.shader[material]]
    values = Values(Read(shader.Draft(made, (), frozenset()), [], Log()), given(buffers, mesh, instance))
    return values.emission()


def given(buffers: SceneBuffers, mesh: object, instance: int) -> dict[str, object]:
    def at(layer: float) -> tuple[np.ndarray, int]:
        """Its four numbers, and how many of them are its own."""
        layer = int(layer)
        if layer < len(buffers.uv_layers):
            corners = len(mesh.uv) // max(len(buffers.uv_layers), 1)
            uv = mesh.uv[layer * corners + mesh.corners[0, 0]]
            return np.array((*uv, 0.0, 1.0)), 2
        if layer in buffers.instance_layers:
            return buffers.instances.attributes[buffers.instance_layers.index(layer), instance], 3
        for attribute in mesh.attributes:
            if attribute.layer == layer:
                of = {'POINT': mesh.triangles, 'CORNER': mesh.corners}.get(attribute.domain)
                return attribute.values[0 if of is None else of[0, 0]], attribute.components
        return np.array((0.0, 0.0, 0.0, 1.0)), 1

    def number(shift: int, layer: float) -> float:
        found, components = at(layer)
        return found[0] if components == 2 else found[:3].mean()

    info = buffers.instances.info
    found = {
        'attribute': lambda shift, layer: at(layer)[0][:3],
        'attribute_alpha': lambda shift, layer: at(layer)[0][3],
        'attribute_fac': number,
        'position': (0.0, 0.0, 0.0),
    }
    if info is not None:
        found['object_info_v'] = info.color[instance][:3]
        found['object_info_f'] = info.random[instance]
    return found


def assert_as_cycles(folder: Path, tolerance: float = 1e-3) -> np.ndarray:
    theirs, _ = shown('CYCLES', folder)
    mine = evaluated(exported(bpy.context.scene))
    np.testing.assert_allclose(mine, theirs, rtol=tolerance, atol=tolerance)
    return mine


def with_attributes() -> Flat:
    made = flat()
    data = made.obj.data
    for name, kind, domain, member, value in (
        ('number', 'FLOAT', 'POINT', 'value', 0.3),
        ('whole', 'INT', 'FACE', 'value', 3),
        ('switch', 'BOOLEAN', 'POINT', 'value', True),
        ('edge', 'FLOAT', 'EDGE', 'value', 0.7),
        ('two', 'FLOAT2', 'POINT', 'vector', (0.1, 0.5)),
        ('vector', 'FLOAT_VECTOR', 'POINT', 'vector', (0.1, 0.2, 0.6)),
        ('bytes', 'BYTE_COLOR', 'CORNER', 'color', (0.1, 0.2, 0.6, 0.5)),
        ('floats', 'FLOAT_COLOR', 'POINT', 'color', (0.1, 0.2, 0.6, 0.5)),
    ):
        found = data.attributes.new(name, kind, domain).data
        found.foreach_set(member, np.tile(np.array(value), len(found)))
    other = data.uv_layers.new(name='Other').uv
    for entry in other:
        entry.vector = (0.2, 0.7)
    made.obj.color = (0.1, 0.2, 0.3, 0.4)
    made.obj.pass_index = 7
    made.obj['pair'], made.obj['one'] = (0.1, 0.2), 0.5
    bpy.context.scene['one'] = 0.25
    bpy.context.view_layer['four'] = (0.1, 0.2, 0.3, 0.4)
    return made


NAMES = ('number', 'whole', 'switch', 'edge', 'two', 'vector', 'bytes', 'floats', 'Other', 'missing', '')
LOOKUPS = [('GEOMETRY', name) for name in NAMES]
LOOKUPS += [('OBJECT', name) for name in ('pair', 'one', 'missing', 'pass_index', 'color', 'color[1]', 'pair[1]')]
LOOKUPS += [('INSTANCER', 'pair'), ('VIEW_LAYER', 'four'), ('VIEW_LAYER', 'one'), ('VIEW_LAYER', 'missing')]


@pytest.mark.parametrize('output', ['Color', 'Fac', 'Alpha'])
@pytest.mark.parametrize(('kind', 'name'), LOOKUPS)
def test_attributes(kind: str, name: str, output: str, tmp_path: Path) -> None:
    made = with_attributes()
    found = made.node('Attribute', attribute_type=kind, attribute_name=name)
    made.link(next(out for out in found.outputs if out.identifier == output), made.emission.inputs['Color'])
    assert_as_cycles(tmp_path)


@pytest.mark.parametrize(
    ('kind', 'member', 'values'),
    [
        ('FLOAT', 'value', (0.2, 0.7)),
        ('BOOLEAN', 'value', (False, True)),
        ('INT', 'value', (1, 2)),
        ('INT8', 'value', (0, 3)),
        ('BYTE_COLOR', 'color', ((0.01, 0.9, 0.3, 0.2), (0.8, 0.02, 0.3, 0.9))),
    ],
)
@pytest.mark.parametrize('output', ['Color', 'Fac', 'Alpha'])
def test_edges_that_differ_at_a_vertex(kind: str, member: str, values: tuple, output: str, tmp_path: Path) -> None:
    """Each vertex of the square has an edge of either value."""
    made = flat()
    data = made.obj.data
    of_edges = [values[sorted(edge.vertices) in ([0, 3], [1, 2])] for edge in data.edges]
    data.attributes.new('mixed', kind, 'EDGE').data.foreach_set(member, np.ravel(of_edges))
    found = made.node('Attribute', attribute_name='mixed')
    made.link(next(out for out in found.outputs if out.identifier == output), made.emission.inputs['Color'])
    assert assert_as_cycles(tmp_path).any()


@pytest.mark.parametrize('output', ['Color', 'Fac', 'Alpha'])
def test_vertex_groups_are_attributes(output: str, tmp_path: Path) -> None:
    made = flat()
    made.obj.vertex_groups.new(name='Other').add([0, 1, 2, 3], 0.9, 'REPLACE')
    group = made.obj.vertex_groups.new(name='Group')
    group.add([0, 1, 2, 3], 0.4, 'REPLACE')
    found = made.node('Attribute', attribute_name='Group')
    made.link(next(out for out in found.outputs if out.identifier == output), made.emission.inputs['Color'])
    # Weights are float32, and their mean of three components rounds.
    np.testing.assert_allclose(assert_as_cycles(tmp_path), 1.0 if output == 'Alpha' else 0.4, rtol=1e-6)
    for index in (1, 3):
        group.add([index], 0.1 * index, 'REPLACE')
    group.remove([2])
    (layer,) = exported(bpy.context.scene).meshes[0].attributes
    np.testing.assert_allclose(layer.values[:, 0], (0.4, 0.1, 0.0, 0.3), rtol=1e-6)  # float32


@pytest.mark.parametrize('output', ['Color', 'Fac'])
def test_pairs_of_integers_are_no_attributes(output: str, tmp_path: Path) -> None:
    made = flat()
    made.obj.data.attributes.new('pair', 'INT32_2D', 'POINT').data.foreach_set('value', [1, 2] * 4)
    found = made.node('Attribute', attribute_name='pair')
    made.link(next(out for out in found.outputs if out.identifier == output), made.emission.inputs['Color'])
    assert not assert_as_cycles(tmp_path).any()


@pytest.mark.parametrize('output', ['Color', 'Fac', 'Alpha'])
def test_uv_is_the_active_uv_map(output: str, tmp_path: Path) -> None:
    """Whatever that is called: 'uv' is what Cycles calls it."""
    made = with_attributes()
    made.obj.data.uv_layers['Other'].active_render = True
    found = made.node('Attribute', attribute_name='uv')
    made.link(next(out for out in found.outputs if out.identifier == output), made.emission.inputs['Color'])
    assert assert_as_cycles(tmp_path).any()


@pytest.mark.parametrize('turn', [0.0, 0.7])
def test_tangent_is_that_of_the_active_uv_map(turn: float, tmp_path: Path) -> None:
    """In the space of the object, which is turned and scaled."""
    made = flat()
    made.obj.rotation_euler.z, made.obj.scale = turn, (2.0, 3.0, 1.0)
    size = made.node('VectorMath', operation='ABSOLUTE')
    made.link(made.node('Attribute', attribute_name='tangent').outputs['Vector'], size.inputs[0])
    made.link(size.outputs[0], made.emission.inputs['Color'])
    (theirs, _), (ours, warnings) = (shown(engine, tmp_path) for engine in ('CYCLES', 'COTORRA'))
    assert not warnings
    np.testing.assert_allclose(theirs, (1.0, 0.0, 0.0), atol=1e-3)
    np.testing.assert_allclose(ours, theirs, atol=1e-3)


@pytest.mark.parametrize('name', ['N', 'tangent_sign'])
def test_what_is_not_derived_yet_is_named(name: str, tmp_path: Path) -> None:
    made = flat()
    made.link(made.node('Attribute', attribute_name=name).outputs['Vector'], made.emission.inputs['Color'])
    _, warnings = shown('COTORRA', tmp_path)
    assert [text for text in warnings if f'attribute "{name}" is not supported yet' in text]


@pytest.mark.parametrize('output', ['Color', 'Alpha'])
@pytest.mark.parametrize('name', ['', 'floats'])
def test_color_attributes(name: str, output: str, tmp_path: Path) -> None:
    made = with_attributes()
    made.link(made.node('VertexColor', layer_name=name).outputs[output], made.emission.inputs['Color'])
    assert assert_as_cycles(tmp_path).any()


@pytest.mark.parametrize('output', ['Color', 'Alpha', 'Random'])
def test_object_info(output: str, tmp_path: Path) -> None:
    made = with_attributes()
    made.obj.name = 'An object of any name'
    made.link(made.node('ObjectInfo').outputs[output], made.emission.inputs['Color'])
    if output != 'Alpha':
        assert assert_as_cycles(tmp_path).any()
    else:
        assert exported(bpy.context.scene).instances.info.color[0, 3] == np.float32(0.4)


@pytest.mark.parametrize('source', ['Object Info', 'color'])
def test_instances_have_the_color_of_what_made_them(source: str, tmp_path: Path) -> None:
    made = with_attributes()
    if source == 'Object Info':
        made.link(made.node('ObjectInfo').outputs['Color'], made.emission.inputs['Color'])
    else:
        asked = made.node('Attribute', attribute_type='OBJECT', attribute_name='color')
        made.link(asked.outputs['Color'], made.emission.inputs['Color'])
    shared = bpy.data.collections.new('Shared')
    made.scene.collection.objects.unlink(made.obj)
    shared.objects.link(made.obj)
    holder = build.link(made.scene, 'Holder', None)
    holder.instance_type, holder.instance_collection, holder.color = 'COLLECTION', shared, (0.7, 0.2, 0.5, 1.0)
    np.testing.assert_allclose(assert_as_cycles(tmp_path), (0.7, 0.2, 0.5), rtol=1e-5)


def test_nothing_is_brought_that_no_shader_asks_for() -> None:
    with_attributes()
    buffers = exported(bpy.context.scene)
    assert buffers.attribute_layers == ('',) and buffers.instance_layers == ()
    assert buffers.meshes[0].attributes == () and buffers.meshes[0].generated is None
    assert buffers.instances.info is None and buffers.instances.attributes is None
    assert buffers.instances.attributes is None


def test_two_meshes_with_a_name_for_different_things() -> None:
    """What is a UV map here and an attribute there is an attribute for both."""
    made = with_attributes()
    data = build.mesh('Second')
    data.attributes.new('Other', 'FLOAT_VECTOR', 'POINT').data.foreach_set('vector', [0.5, 0.6, 0.7] * 4)
    data.materials.append(bpy.data.materials['Material'])
    build.link(bpy.context.scene, 'Second', data)
    made.link(made.node('Attribute', attribute_name='Other').outputs['Vector'], made.emission.inputs['Color'])
    buffers = exported(bpy.context.scene)
    assert buffers.uv_layers == ('',) and 'Other' in buffers.attribute_layers
    by_name = {name: evaluated(buffers, index) for index, name in enumerate(buffers.instances.names)}
    np.testing.assert_allclose(by_name['Square'], (0.2, 0.7, 0.0), rtol=1e-6)
    np.testing.assert_allclose(by_name['Second'], (0.5, 0.6, 0.7), rtol=1e-6)


def test_equal_materials_share_a_shader() -> None:
    made = flat()
    made.obj.data.materials.append(shining('Other material'))
    made.obj.data.materials.append(None)
    buffers = exported(bpy.context.scene)
    assert len(buffers.shaders) == 1
    assert sorted(buffers.materials.shader.tolist()) == [-1, 0, 0]


def test_worlds_and_lamps_have_shaders() -> None:
    flat()
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new('World')
    build.light(scene, 'POINT', energy=5.0)
    buffers = exported(scene)
    assert buffers.world.shader >= 0
    assert buffers.lights.shader.tolist() == [buffers.lights.shader[0]] and buffers.lights.shader[0] >= 0
    assert buffers.lights.strength.tolist() == [[5.0, 5.0, 5.0]]


# ---- What Cycles derives of meshes.


def test_random_per_island(tmp_path: Path) -> None:
    made = flat()
    made.link(made.node('NewGeometry').outputs['Random Per Island'], made.emission.inputs['Color'])
    assert_as_cycles(tmp_path)


def test_islands_are_told_apart() -> None:
    data = build.mesh(vertices=[*build.QUAD, (5, 0, 0), (6, 0, 0), (5, 1, 0)], faces=[(0, 1, 2, 3), (4, 5, 6)])
    random = attributes.random_per_island(data)
    assert random[0] == random[1] != random[2]


@pytest.mark.parametrize('height', [1.0, -0.5])
def test_pointiness(height: float, tmp_path: Path) -> None:
    """A camera that sees nothing but the place around one vertex of a bumpy grid."""
    made = flat()
    grid = build.grid(4)
    positions = np.empty(len(grid.vertices) * 3, np.float32)
    grid.vertices.foreach_get('co', positions)
    places = positions.reshape(-1, 3)
    places[:, 2] = np.sin(3.0 * places[:, 0]) * np.cos(2.0 * places[:, 1])
    places[12, 2] += height
    grid.vertices.foreach_set('co', positions)
    grid.update()
    grid.materials.append(bpy.data.materials['Material'])
    made.obj.data = grid
    camera = bpy.context.scene.camera
    camera.location = (*places[12, :2], 5.0)
    camera.data.type, camera.data.ortho_scale = 'ORTHO', 1e-3
    made.link(made.node('NewGeometry').outputs['Pointiness'], made.emission.inputs['Color'])
    theirs, _ = shown('CYCLES', tmp_path)
    assert attributes.pointiness(grid)[12] == pytest.approx(theirs[0], abs=2e-3)


# ---- Particles and instances.


def test_particles(tmp_path: Path) -> None:
    """Squares at particles: the numbers that the depsgraph's particles have, and Cycles' random ones."""
    made = flat()
    made.link(made.node('ParticleInfo').outputs['Random'], made.emission.inputs['Color'])
    emitter = build.mesh_object(bpy.context.scene, 'Emitter')
    system = emitter.modifiers.new('Particles', 'PARTICLE_SYSTEM').particle_system.settings
    system.count, system.frame_start, system.frame_end = 3, 1, 1
    system.render_type, system.instance_object, system.particle_size = 'OBJECT', made.obj, 1.0
    bpy.context.scene.frame_set(2)
    buffers = exported(bpy.context.scene)
    numbers = buffers.instances.attributes[0]
    of_particles = numbers[:, 3] > 0.0
    assert of_particles.sum() == 3 and sorted(numbers[of_particles, 0]) == [0.0, 1.0, 2.0]
    assert (numbers[of_particles, 2] == 1.0).all()
    expected = attributes.unit_hash(numbers[:, 0].astype(np.uint32), 0)  # what no particle made is number 0, too
    assert numbers[:, 1].tolist() == expected.tolist()


@pytest.mark.every(3)
@pytest.mark.parametrize(
    'output',
    ['Index', 'Random', 'Age', 'Lifetime', 'Size', 'Location', 'Velocity', 'Angular Velocity'],
)
def test_particles_are_as_cycles_shows_them(output: str, tmp_path: Path) -> None:
    """Squares that fall and turn, seen from above, and the one that they are copies of."""
    made = flat()
    scene = bpy.context.scene
    size = made.node('VectorMath', operation='ABSOLUTE')
    made.link(made.node('ParticleInfo').outputs[output], size.inputs[0])
    made.link(size.outputs[0], made.emission.inputs['Color'])
    made.obj.location.x = 20.0
    emitter = build.mesh_object(scene, 'Emitter', vertices=[(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    emitter.show_instancer_for_render = False
    settings = emitter.modifiers.new('Particles', 'PARTICLE_SYSTEM').particle_system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.particle_size = 9, 1, 3, 0.05
    settings.render_type, settings.instance_object, settings.size_random = 'OBJECT', made.obj, 0.5
    settings.use_rotations, settings.angular_velocity_mode, settings.angular_velocity_factor = True, 'GLOBAL_Z', 2.0
    for frame in range(1, 6):
        scene.frame_set(frame)
    ours, theirs = (in_halves(scene, engine, tmp_path, 0, (48, 48), 128).image for engine in ('COTORRA', 'CYCLES'))
    assert theirs.mean() > 0.0
    means = (image.reshape(4, 12, 4, 12, 3).mean((1, 3)) for image in (ours, theirs))
    np.testing.assert_allclose(*means, rtol=0.05, atol=0.02 * theirs.mean())


# ---- UDIM tiles.

COLORS = {1001: (1.0, 0.0, 0.0), 1002: (0.0, 1.0, 0.0), 1012: (0.0, 0.0, 1.0)}


def tiled(folder: Path) -> bpy.types.Image:
    for number, color in COLORS.items():
        image = bpy.data.images.new(f'Tile {number}', 4, 4)
        image.generated_color = (*color, 1.0)
        image.filepath_raw, image.file_format = str(folder / f'tile.{number}.png'), 'PNG'
        image.save()
    image = bpy.data.images.load(str(folder / 'tile.1001.png'))
    image.source = 'TILED'
    image.filepath = str(folder / 'tile.<UDIM>.png')
    for number in list(COLORS)[1:]:
        image.tiles.new(number)
    return image


@pytest.mark.parametrize(
    'place',
    [(0.5, 0.5), (1.5, 0.5), (1.25, 1.5), (0.5, 1.5), (9.5, 0.5), (10.5, 0.5), (-0.5, 0.5), (-1.5, 0.5), (3.0, 40.5)],
)
def test_tiles(place: tuple[float, float], tmp_path: Path) -> None:
    made = flat()
    for entry in made.obj.data.uv_layers[0].uv:
        entry.vector = place
    found = made.node('TexImage', image=tiled(tmp_path), interpolation='Closest')
    made.link(found.outputs['Color'], made.emission.inputs['Color'])
    theirs, _ = shown('CYCLES', tmp_path)
    buffers = exported(bpy.context.scene)
    mesh = buffers.meshes[0]

    def texel(shift: int, vector: np.ndarray, image: float, blend: float, normal: np.ndarray) -> np.ndarray:
        pixels = buffers.images[int(image)].pixels
        return pixels[0, 0, :3] / 255.0

    ops = given(buffers, mesh, 0) | {'image_v': texel}
    made_shader = buffers.shaders[buffers.materials.shader[1]]
    mine = Values(Read(shader.Draft(made_shader, (), frozenset()), [], Log()), ops).emission()
    np.testing.assert_allclose(mine, theirs, atol=1e-3)


@pytest.mark.parametrize('place', [(0.5, 0.5), (0.999, 0.5), (2.3, 0.9), (-0.2, 0.5)])
@pytest.mark.parametrize('output', ['Color', 'Alpha'])
def test_tiles_that_are_not_there_have_no_edge(output: str, place: tuple[float, float], tmp_path: Path) -> None:
    """With extension Clip, too, which shows nothing beyond the edges of tiles that are."""
    made = flat()
    for entry in made.obj.data.uv_layers[0].uv:
        entry.vector = place
    found = made.node('TexImage', image=tiled(tmp_path), extension='CLIP')
    made.link(found.outputs[output], made.emission.inputs['Color'])
    (mine, _), (theirs, _) = (shown(engine, tmp_path) for engine in ('COTORRA', 'CYCLES'))
    assert mine == pytest.approx(theirs, abs=1e-3)
