# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders with Persistent Data: what did not change is not exported or built again, and what did is seen.

Pictures are compared with those of renders that keep nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat, stats
from cotorra.export import geometry
from cotorra.sync import stores

from scenes import build

pytestmark = pytest.mark.usefixtures('engine')


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> bpy.types.Scene:
    made = build.new_scene()
    made.render.engine = 'COTORRA'
    made.render.resolution_x, made.render.resolution_y = 24, 16
    made.cycles.samples = 4
    camera = build.camera(made)
    camera.location = (0.0, 0.0, 6.0)
    for number, name in enumerate(('A', 'B')):
        obj = build.mesh_object(made, name)
        obj.location.x = 2.2 * number - 1.1
        material = bpy.data.materials.new(f'of {name}')
        compat.principled(material).inputs['Base Color'].default_value = (0.8, 0.3 + 0.4 * number, 0.2, 1.0)
        obj.data.materials.append(material)
    lamp = build.link(made, 'Lamp', bpy.data.lights.new('Lamp', 'POINT'))
    lamp.location, lamp.data.energy = (0.0, 1.0, 3.0), 200.0
    compat.set_image_format(made.render.image_settings, 'OPEN_EXR')
    made.render.image_settings.color_depth = '32'
    return made


def rendered(scene: bpy.types.Scene, path: Path, persistent: bool = True) -> np.ndarray:
    scene.render.use_persistent_data = persistent
    scene.render.filepath = str(path / f'{persistent}.exr')
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    try:
        pixels = np.array(image.pixels[:], np.float32)
    finally:
        bpy.data.images.remove(image)
    return pixels


def color() -> None:
    compat.principled(bpy.data.materials['of A']).inputs['Base Color'].default_value = (0.1, 0.1, 0.9, 1.0)


def energy() -> None:
    bpy.data.lights['Lamp'].energy = 900.0


def move() -> None:
    bpy.data.objects['A'].location.z = -1.5


def vertices() -> None:
    mesh = bpy.data.meshes['B']
    mesh.vertices[0].co.z = 1.0
    mesh.update()


def camera() -> None:
    bpy.context.scene.camera.location.x = 1.0


def delete() -> None:
    bpy.data.objects.remove(bpy.data.objects['A'])


def setting() -> None:
    bpy.context.scene.cycles.samples = 9


@pytest.mark.parametrize(
    'edit', [color, energy, move, vertices, camera, delete, setting], ids=lambda edit: edit.__name__
)
def test_an_edit_between_two_renders_is_seen(scene: bpy.types.Scene, tmp_path: Path, edit: Callable[[], None]) -> None:
    before = rendered(scene, tmp_path)
    assert len(stores._of_renders) == 1
    assert (rendered(scene, tmp_path) == before).all()
    edit()
    after = rendered(scene, tmp_path)
    expected = rendered(scene, tmp_path, persistent=False)
    assert not stores._of_renders
    # In spaces of their own, objects round otherwise: a few rays at edges may differ.
    assert np.abs(after - expected).mean() < 1e-3 * np.abs(expected).mean()
    assert np.abs(after - before).mean() > 1e-2 * np.abs(before).mean()


def test_frames_read_and_build_what_changed_alone(scene: bpy.types.Scene, tmp_path: Path, monkeypatch) -> None:
    read: list[str] = []
    read_mesh = geometry.read_mesh

    def note(mesh: bpy.types.Mesh, *arguments: object) -> object:
        read.append(mesh.name)
        return read_mesh(mesh, *arguments)

    monkeypatch.setattr(geometry, 'read_mesh', note)
    obj = bpy.data.objects['A']
    for frame, z in ((1, 0.0), (3, -2.0)):
        obj.location.z = z
        obj.keyframe_insert('location', frame=frame)
    scene.frame_start, scene.frame_end = 1, 3
    scene.render.use_persistent_data = True
    scene.render.filepath = str(tmp_path / 'frame_')
    bpy.ops.render.render(animation=True)
    assert sorted(read) == ['A', 'B']
    assert stats.last(scene.name)[0].progress == 1.0


def test_loading_a_file_lets_go_of_it(scene: bpy.types.Scene, tmp_path: Path) -> None:
    rendered(scene, tmp_path)
    assert stores._of_renders
    build.new_scene()
    assert not stores._of_renders
