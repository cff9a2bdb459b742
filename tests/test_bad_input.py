# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes, settings and files that are wrong: each gets a message that names what is wrong, and renders what it can.

Everything runs through Blender and the real native module; arrays of broken data are test_export_*.py's.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import stats, terminal

from render_calls import read_exr, render_to, run_cli
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

NAN, INF = math.nan, math.inf


@pytest.fixture
def scene() -> bpy.types.Scene:
    """A white square under a sun that fills the picture of an orthographic camera above it."""
    made = build.new_scene()
    camera = build.camera(made, type='ORTHO', ortho_scale=1.0)
    camera.location = (0.0, 0.0, 5.0)
    build.light(made, 'SUN', energy=3.0)
    build.mesh_object(made, 'Square').data.materials.append(build.material('White', Base_Color=(1, 1, 1, 1)))
    made.render.engine = 'COTORRA'
    made.render.resolution_x = made.render.resolution_y = 8
    made.render.film_transparent = True
    made.cotorra.samples = 4
    return made


def rendered(scene: bpy.types.Scene, path: Path) -> tuple[dict[str, np.ndarray], list[str]]:
    """Channels of Combined, and the warnings."""
    found = read_exr(render_to(scene, path / 'image.exr'))['']
    assert all(np.isfinite(pixels).all() for pixels in found.values())
    return found, stats.last(scene.name)[0].warnings


def assert_square_is_rendered(scene: bpy.types.Scene, path: Path) -> list[str]:
    """The square, which is in order, is there whatever else is not."""
    found, warnings = rendered(scene, path)
    assert found['A'].min() > 0.99 and 0.5 < found['R'].mean() < 1.5
    return warnings


def test_the_scene_itself_is_in_order(scene, tmp_path):
    assert assert_square_is_rendered(scene, tmp_path) == []


def test_no_camera(scene):
    scene.camera = None
    with pytest.raises(RuntimeError, match='no camera'):
        bpy.ops.render.render()


def test_no_lights_is_black_but_there(scene, tmp_path):
    bpy.data.objects.remove(bpy.data.objects['Sun'])
    found, warnings = rendered(scene, tmp_path)
    assert found['R'].max() == 0.0 and found['A'].min() > 0.99
    assert warnings == []


def test_no_objects_at_all(scene, tmp_path):
    for item in list(scene.objects):
        if item.type != 'CAMERA':
            bpy.data.objects.remove(item)
    found, _ = rendered(scene, tmp_path)
    assert found['A'].max() == 0.0


def test_meshes_without_vertices_or_faces(scene, tmp_path):
    build.mesh_object(scene, 'Empty', vertices=[], faces=[])
    build.mesh_object(scene, 'Points', faces=[])
    edges = bpy.data.meshes.new('Edges')
    edges.from_pydata(build.QUAD, [(0, 1), (1, 2)], [])
    build.link(scene, 'Edges', edges)
    assert_square_is_rendered(scene, tmp_path)


@pytest.mark.parametrize('value', [NAN, INF, -INF, 3e38])
def test_vertices_that_are_not_finite(scene, tmp_path, value):
    build.mesh_object(scene, 'Broken', vertices=[(0, 0, -1), (1, 0, -1), (0, value, -1)], faces=[(0, 1, 2)])
    warnings = assert_square_is_rendered(scene, tmp_path)
    if not abs(value) < INF:
        assert any('Broken' in text for text in warnings)


def test_triangles_without_area(scene, tmp_path):
    build.mesh_object(scene, 'Line', vertices=[(0, 0, 1), (1, 0, 1), (2, 0, 1)], faces=[(0, 1, 2)])
    build.mesh_object(scene, 'Point', vertices=[(0, 0, 1)] * 3, faces=[(0, 1, 2)], smooth=True)
    assert_square_is_rendered(scene, tmp_path)


def test_faces_of_removed_materials(scene, tmp_path):
    mesh = bpy.data.objects['Square'].data
    mesh.polygons[0].material_index = 7
    mesh.materials.clear()
    assert_square_is_rendered(scene, tmp_path)
    mesh.materials.append(None)
    assert_square_is_rendered(scene, tmp_path)


def test_a_missing_image(scene, tmp_path):
    material = build.material('Textured')
    image = bpy.data.images.new('Lost', 4, 4)
    image.source, image.filepath = 'FILE', str(tmp_path / 'lost.png')
    node = build.node(material.node_tree, 'TexImage')
    node.image = image
    build.connect(material.node_tree, node.outputs['Color'], build.principled(material).inputs['Base Color'])
    item = build.mesh_object(scene, 'Textured square')
    item.location.z = 0.5
    item.data.materials.append(material)
    found, warnings = rendered(scene, tmp_path)
    assert found['A'].min() > 0.99
    assert any('Textured' in text for text in warnings)


@pytest.mark.parametrize('wrong, used', [(0, 1), (-3, 1), (2**31 - 1, 2**24)])
def test_samples_are_held_within_limits(scene, wrong, used):
    scene.cotorra.samples = wrong
    assert scene.cotorra.samples == used


def test_samples_beyond_an_integer_are_refused_by_name(scene):
    with pytest.raises(ValueError, match='samples'):
        scene.cotorra.samples = 2**31


def test_one_pixel(scene, tmp_path):
    scene.render.resolution_x = scene.render.resolution_y = 4  # Blender's smallest
    scene.render.resolution_percentage = 25
    found, _ = rendered(scene, tmp_path)
    assert found['R'].shape == (1, 1) and found['A'][0, 0] > 0.99


@pytest.mark.parametrize('width, height', [(16384, 4), (4, 16384)])
def test_sixteen_thousand_pixels_in_a_row(scene, tmp_path, width, height):
    scene.render.resolution_x, scene.render.resolution_y = width, height
    found, _ = rendered(scene, tmp_path)
    assert found['R'].shape == (height, width)


def test_a_border_in_a_16k_picture(scene, tmp_path):
    render = scene.render
    render.resolution_x = render.resolution_y = 16384
    render.use_border = render.use_crop_to_border = True
    render.border_min_x = render.border_min_y = 0.5
    render.border_max_x = render.border_max_y = 0.5 + 8 / 16384
    found, _ = rendered(scene, tmp_path)
    assert found['A'].shape == (8, 8) and found['A'].min() > 0.99


@pytest.mark.parametrize(
    'scale', [(0, 0, 0), (0, 1, 1), (1, 1, 0), (1e-30, 1, 1), (1e30, 1e30, 1e30), (NAN, 1, 1), (1, INF, 1)]
)
def test_transforms_that_cannot_be_inverted(scene, tmp_path, scale):
    item = build.mesh_object(scene, 'Flat')
    item.location.z = -1.0
    item.scale = scale
    assert_square_is_rendered(scene, tmp_path)


@pytest.mark.parametrize('kind', ['POINT', 'SPOT', 'SUN'])
@pytest.mark.parametrize('scale', [(0, 0, 0), (1, 1, 0), (NAN, 1, 1)])
def test_lights_with_transforms_that_cannot_be_inverted(scene, tmp_path, kind, scale):
    lamp = build.light(scene, kind)
    lamp.name = 'Squeezed'
    lamp.location.z = 3.0
    lamp.scale = scale
    assert_square_is_rendered(scene, tmp_path)


@pytest.mark.parametrize('strength', [NAN, INF])
def test_lights_of_no_finite_strength(scene, tmp_path, strength):
    build.light(scene, 'POINT', energy=strength).name = 'Blinding'
    warnings = assert_square_is_rendered(scene, tmp_path)
    assert any('Blinding' in text for text in warnings)


def test_a_camera_that_cannot_be_used_is_named(scene, tmp_path):
    scene.camera.scale = (0, 0, 0)
    scene.camera.location = (NAN, 0, 0)
    with pytest.raises(RuntimeError, match='Camera "Camera"'):
        render_to(scene, tmp_path / 'image.exr')
    assert not (tmp_path / 'image.exr').exists()


def test_things_not_rendered_yet_are_named(scene, tmp_path):
    build.link(scene, 'Smoke', bpy.data.volumes.new('Smoke'))
    warnings = assert_square_is_rendered(scene, tmp_path)
    assert any('Smoke' in text for text in warnings)


@pytest.mark.parametrize('size', [0.0, 1e-30, 1e6, 1e30, NAN])
@pytest.mark.parametrize('shape', ['SQUARE', 'ELLIPSE'])
def test_area_lights_of_any_size(size, shape, scene, tmp_path):
    lamp = build.light(scene, 'AREA', shape=shape, size=size, size_y=1.0, energy=1e-3)
    lamp.name, lamp.location.z, lamp.scale = 'Panel', 3.0, (-1.0, 2.0, 1.0)
    warnings = assert_square_is_rendered(scene, tmp_path)
    assert bool(warnings) == (size in (0.0, 1e30) or size != size)
    assert all('Panel' in text for text in warnings)


# At the command line.


def save(tmp_path: Path) -> Path:
    path = tmp_path / 'scene.blend'
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_cli_no_camera(scene, tmp_path):
    scene.camera = None
    code, told = run_cli('render', save(tmp_path), '-o', tmp_path / 'o.exr')
    assert code == terminal.FAILED
    assert 'no camera' in told and 'scene "Scene"' in told and 'o.exr' in told
    assert not (tmp_path / 'o.exr').exists()


def test_cli_exception_in_the_engine_is_a_failure_and_no_crash(tmp_path):
    """EXR on purpose: an exception that reaches Blender crashes it there."""
    code, told = run_cli(
        'render', '--demo', 'box_room', '-o', tmp_path / 'o.exr', '--size', '8x8', fake='fail_in=render'
    )
    assert code == terminal.FAILED, code
    assert 'a worker failed' in told and 'o.exr' in told
    assert not (tmp_path / 'o.exr').exists()


def test_cli_file_that_is_not_there(tmp_path):
    code, told = run_cli('render', tmp_path / 'nothing.blend', '-o', tmp_path / 'o.png')
    assert code == terminal.FAILED and 'nothing.blend: there is no such file' in told


def test_cli_file_that_is_no_blend(tmp_path):
    path = tmp_path / 'text.blend'
    path.write_text('hello')
    code, told = run_cli('render', path, '-o', tmp_path / 'o.png')
    assert code == terminal.FAILED and 'text.blend' in told and not (tmp_path / 'o.png').exists()


def test_cli_output_that_cannot_be_written_is_found_before_rendering(scene, tmp_path):
    """Before Blender is loaded even. (Folder and file stand in each other's place: root may write anywhere else.)"""
    blend = save(tmp_path)
    (tmp_path / 'folder.png').mkdir()
    (tmp_path / 'file').touch()
    for output in (tmp_path / 'folder.png', tmp_path / 'file' / 'o.png'):
        code, told = run_cli('render', blend, '-o', output)
        assert code == terminal.FAILED and str(output) in told and 'Synchronizing' not in told
    code, told = run_cli('render', blend, '-o', tmp_path / 'o.png', '--stats', tmp_path / 'file' / 's.json')
    assert code == terminal.FAILED and 's.json' in told and 'Synchronizing' not in told
    assert not (tmp_path / 'o.png').exists()


def test_cli_scripts_in_a_file_are_not_run_and_that_is_said(scene, tmp_path):
    text = bpy.data.texts.new('evil.py')
    text.use_module = True
    text.write(f'open({str(tmp_path / "ran")!r}, "w")')
    code, told = run_cli('render', save(tmp_path), '-o', tmp_path / 'o.png', '--samples', 1)
    assert code == 0 and not (tmp_path / 'ran').exists()
    assert 'scripts were not run' in told
