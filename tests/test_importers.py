# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of other programs at the command line: they are read, framed and lit, and what cannot be read is named.

The files are made by Blender's exporters; how their materials look is not judged here.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from bpy_extras.object_utils import world_to_camera_view
from cotorra import choices, importers, terminal
from mathutils import Vector

from render_calls import run_cli
from scenes import build

EXPORTERS = {
    'glb': lambda path: bpy.ops.export_scene.gltf(filepath=path, export_lights=True, export_cameras=True),
    'gltf': lambda path: bpy.ops.export_scene.gltf(filepath=path, export_format='GLTF_SEPARATE'),
    'usd': lambda path: bpy.ops.wm.usd_export(filepath=path),
    'usda': lambda path: bpy.ops.wm.usd_export(filepath=path),
    'usdc': lambda path: bpy.ops.wm.usd_export(filepath=path),
    'usdz': lambda path: bpy.ops.wm.usd_export(filepath=path),
    'obj': lambda path: bpy.ops.wm.obj_export(filepath=path),
    'stl': lambda path: bpy.ops.wm.stl_export(filepath=path),
    'ply': lambda path: bpy.ops.wm.ply_export(filepath=path),
    'fbx': lambda path: bpy.ops.export_scene.fbx(filepath=path),
}
SMALL = ('--size', '48x32', '--samples', 16)


@pytest.fixture(scope='module')
def files(engine, tmp_path_factory) -> Path:
    """A folder with a tall box, far from the origin, in each format."""
    folder = tmp_path_factory.mktemp('files')
    build.new_scene()
    bpy.ops.mesh.primitive_cube_add(location=(100, 200, 300), scale=(2, 1, 5))
    bpy.context.object.data.materials.append(build.material('White'))
    for suffix, export in EXPORTERS.items():
        export(str(folder / f'box.{suffix}'))
    return folder


def pixels(path: Path) -> np.ndarray:
    return oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)[..., :3]


def test_every_format_that_is_offered_is_tested():
    assert sorted(choices.IMPORTERS) == sorted(f'.{suffix}' for suffix in EXPORTERS)


@pytest.mark.parametrize('suffix', EXPORTERS)
def test_a_file_is_framed_and_lit(files, tmp_path, suffix):
    code, told = run_cli('render', files / f'box.{suffix}', '-o', tmp_path / 'o.exr', *SMALL)
    assert code == 0, told
    assert 'Warning' not in told
    image = pixels(tmp_path / 'o.exr')
    assert image.shape[:2] == (32, 48)
    # All edges of the picture show the sky, its middle the box; the box has a bright side and a dark one.
    sky = image[0, 0]
    box = np.abs(image - sky).max(axis=2) > 0.02
    assert not (box[0].any() or box[-1].any() or box[:, 0].any() or box[:, -1].any())
    assert box[14:18, 22:26].all() and box.sum() > 100
    assert image[box].max() > 2.0 * image[box].min() > 0.0
    # It fills the picture as far as a margin allows.
    assert box.any(axis=1).sum() > 20


@pytest.mark.parametrize('size', ['40x10', '10x40', '20x20'])
@pytest.mark.parametrize('scale', [(1, 1, 1), (1e-4, 1e-4, 1e-4), (1e4, 1e4, 1e4), (1, 0, 0), (5, 0.1, 0.1), (1, 1, 9)])
def test_everything_is_in_the_picture_and_fills_it(engine, size, scale):
    scene = build.new_scene()
    bpy.ops.mesh.primitive_cube_add(size=1.0, scale=scale, location=(3, -4, 5))
    width, height = (int(side) for side in size.split('x'))
    scene.render.resolution_x, scene.render.resolution_y = width, height
    importers.complete(scene)
    bpy.context.view_layer.update()
    item = next(item for item in scene.objects if item.type == 'MESH')
    seen = [world_to_camera_view(scene, scene.camera, item.matrix_world @ Vector(corner)) for corner in item.bound_box]
    across = np.array([(place.x, place.y) for place in seen])
    assert across.min() > 0.0 and across.max() < 1.0
    assert np.ptp(across, axis=0).max() > 0.4  # of one side of the picture
    depth = np.array([place.z for place in seen])
    assert scene.camera.data.clip_start < depth.min() and depth.max() < scene.camera.data.clip_end


def test_camera_and_light_of_the_file_are_kept(engine, tmp_path):
    scene = build.new_scene()
    build.mesh_object(scene).data.materials.append(build.material('White'))
    build.camera(scene).location = (0, 0, 4)
    build.light(scene, 'POINT', energy=100.0).location = (0, 0, 3)
    for suffix in ('glb', 'usd', 'fbx'):
        path = tmp_path / f'scene.{suffix}'
        EXPORTERS[suffix](str(path))
    for suffix in ('glb', 'usd', 'fbx'):
        found = importers.load(tmp_path / f'scene.{suffix}')
        importers.complete(found)
        assert [item.type for item in found.objects].count('CAMERA') == 1
        assert [light.type for light in bpy.data.lights] == ['POINT']
        bpy.context.view_layer.update()
        assert found.camera.matrix_world.translation[:] == pytest.approx((0, 0, 4), abs=1e-4)


@pytest.mark.parametrize('brought', ['nothing', 'a light', 'a world'])
def test_light_is_added_where_there_is_none(engine, brought):
    scene = build.new_scene()
    build.mesh_object(scene)
    if brought == 'a light':
        build.light(scene, 'POINT')
    if brought == 'a world':
        build.world(scene)
    importers.complete(scene)
    lights = [light.type for light in bpy.data.lights]
    assert lights == {'nothing': ['SUN'], 'a light': ['POINT'], 'a world': []}[brought]
    assert (scene.world is None) == (brought == 'a light')


@pytest.mark.parametrize('content', ['empty', 'text', 'half'])
@pytest.mark.parametrize('suffix', EXPORTERS)
def test_a_broken_file_is_named_and_leaves_no_image(files, tmp_path, suffix, content):
    whole = (files / f'box.{suffix}').read_bytes()
    path = tmp_path / f'broken.{suffix}'
    path.write_bytes({'empty': b'', 'text': b'hello world\n' * 9, 'half': whole[: len(whole) // 2]}[content])
    code, told = run_cli('render', path, '-o', tmp_path / 'o.png', *SMALL)
    assert code == terminal.FAILED and f'cotorra: {path}: ' in told, told
    assert list(tmp_path.iterdir()) == [path]


def test_what_an_importer_leaves_out_is_named(files, tmp_path):
    path, figures = tmp_path / 'box.obj', tmp_path / 's.json'
    path.write_text((files / 'box.obj').read_text() + 'frobnicate 1\n')  # and without its box.mtl
    code, told = run_cli('render', path, '-o', tmp_path / 'o.png', *SMALL, '--stats', figures)
    assert code == 0, told
    warnings = json.loads(figures.read_text(encoding='utf-8'))['warnings']
    for words in ('frobnicate', 'box.mtl'):
        assert f'{words}' in told and any(words in text and str(path) in text for text in warnings)


def test_a_glTF_that_needs_an_extension_that_is_not_known_names_it(files, tmp_path):
    content = json.loads((files / 'box.gltf').read_text())
    content['extensionsRequired'] = content['extensionsUsed'] = ['ACME_holograms']
    path = tmp_path / 'box.gltf'
    path.write_text(json.dumps(content))
    (tmp_path / 'box.bin').write_bytes((files / 'box.bin').read_bytes())
    code, told = run_cli('render', path, '-o', tmp_path / 'o.png', *SMALL)
    assert code == terminal.FAILED and str(path) in told and 'ACME_holograms' in told


def test_points_without_faces_are_named(tmp_path):
    path = tmp_path / 'cloud.ply'
    path.write_text(
        'ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n'
        '0 0 0\n1 1 1\n'
    )
    code, told = run_cli('render', path, '-o', tmp_path / 'o.png', *SMALL)
    assert code == terminal.FAILED and 'meshes without faces are not seen: cloud' in told


@pytest.mark.parametrize('suffix', ['usd', 'obj', 'gltf'])
@pytest.mark.parametrize('place', ['back\\slash/back\\slash', 'ba\udcffd/ba\udcffd', '{x} #/%d'])
def test_odd_names_of_files(files, tmp_path, suffix, place):
    path = tmp_path / f'{place}.{suffix}'
    path.parent.mkdir()
    for neighbour in files.glob('box.*'):
        (path.parent / neighbour.name).write_bytes(neighbour.read_bytes())
    (path.parent / f'box.{suffix}').rename(path)
    code, told = run_cli('render', path, '-o', tmp_path / 'o.png', *SMALL)
    assert code == 0 and 'Warning' not in told, told


def test_a_blend_file_by_any_name(engine, tmp_path):
    build.camera(build.new_scene())
    for compress in (False, True):
        path = tmp_path / 'scene.blend'
        bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=compress)
        for name in ('scene.blend1', 'scene', 'odd\\na\udcffme.blend'):
            content = path.read_bytes()
            (tmp_path / name).write_bytes(content)
            code, told = run_cli('render', tmp_path / name, '-o', tmp_path / 'o.png', '--size', '8x8', fake='')
            assert code == 0, told


def test_what_is_no_file_of_a_known_kind_is_named(tmp_path):
    (tmp_path / 'x.abc').write_bytes(b'Ogawa')
    pipe = tmp_path / 'pipe.blend'
    os.mkfifo(pipe)
    for name, words in (
        ('x.abc', 'is none of .blend, .glb, .gltf, .usd'),
        ('.', 'is a directory'),
        ('pipe.blend', 'is a device or pipe'),
        ('x.abc/y.blend', 'Not a directory'),
        ('nothing.glb', 'there is no such file'),
    ):
        code, told = run_cli('render', tmp_path / name, '-o', tmp_path / 'o.png')
        assert code in (terminal.FAILED, terminal.WRONG_ARGUMENTS) and words in told, told
