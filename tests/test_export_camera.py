# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's picture is Blender's own: `calc_matrix_camera` and the sizes of real renders say so."""

from __future__ import annotations

import itertools
import math

import bpy
import numpy as np
import pytest
from cotorra.export import export_camera
from cotorra.export.camera import border_region, resolution
from cotorra.log import Log
from mathutils import Euler, Matrix

from scenes import build
from scenes.depsgraphs import exported_camera, in_render

FITS = ('AUTO', 'HORIZONTAL', 'VERTICAL')
SIZES = ((640, 360), (360, 640), (100, 100))
ASPECTS = ((1.0, 1.0), (2.0, 1.0), (1.0, 1.5))
SHIFTS = ((0.0, 0.0), (0.25, -0.125))


def blender_window(scene: bpy.types.Scene) -> tuple[float, float, float, float]:
    """left, right, bottom, top on the plane z = -1 (or in metres), out of Blender's projection matrix."""
    render, camera = scene.render, scene.camera
    matrix = camera.calc_matrix_camera(
        bpy.context.evaluated_depsgraph_get(),
        x=render.resolution_x,
        y=render.resolution_y,
        scale_x=render.pixel_aspect_x,
        scale_y=render.pixel_aspect_y,
    )
    # Clip x = (m00 x + m02 z + m03) / w is -1 at the left and 1 at the right; w = -z, or 1 if orthographic.
    window = []
    for row in (0, 1):
        offset = matrix[row][3] if camera.data.type == 'ORTHO' else -matrix[row][2]
        window += [(-1.0 - offset) / matrix[row][row], (1.0 - offset) / matrix[row][row]]
    return tuple(window)


@pytest.mark.parametrize('kind', ['PERSP', 'ORTHO'])
@pytest.mark.parametrize('fit', FITS)
def test_window_is_blenders(kind: str, fit: str) -> None:
    scene = build.new_scene()
    camera = build.camera(scene, type=kind, lens=35, ortho_scale=7, sensor_fit=fit, sensor_width=32, sensor_height=20)
    for size, aspect, shift in itertools.product(SIZES, ASPECTS, SHIFTS):
        scene.render.resolution_x, scene.render.resolution_y = size
        scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = aspect
        camera.data.shift_x, camera.data.shift_y = shift
        found = exported_camera(scene)
        assert found.kind == kind and found.resolution == size
        # The projection matrix is in single precision.
        assert found.window == pytest.approx(blender_window(scene), rel=1e-5, abs=1e-6), (size, aspect, shift)


def test_transform_has_no_scale() -> None:
    scene = build.new_scene()
    camera = build.camera(scene)
    camera.matrix_world = Matrix.LocRotScale((1, 2, 3), Euler((0.1, 0.2, 0.3)), (2, 2, 5))
    expected = np.array(Matrix.LocRotScale((1, 2, 3), Euler((0.1, 0.2, 0.3)), None), np.float32)[:3]
    found = exported_camera(scene).transform
    assert found.dtype == np.float32 and found.flags['C_CONTIGUOUS']
    assert np.allclose(found, expected, atol=1e-6)


def test_parent_and_animation_count() -> None:
    """The evaluated camera is exported, not the original."""
    scene = build.new_scene()
    camera = build.camera(scene)
    camera.parent = build.link(scene, 'Parent', None)
    camera.parent.location.x = 1.0
    camera.parent.keyframe_insert('location', frame=1)
    camera.parent.location.x = 3.0
    camera.parent.keyframe_insert('location', frame=11)
    scene.frame_set(11)
    assert exported_camera(scene).transform[:, 3].tolist() == [3, 0, 0]


def test_clip_and_filter() -> None:
    scene = build.new_scene()
    build.camera(scene, clip_start=0.25, clip_end=64)
    scene.cycles.filter_width = 2.5
    found = exported_camera(scene)
    assert found.clip == (0.25, 64) and found.filter_width == 2.5


@pytest.mark.parametrize(('kind', 'width'), [('BLACKMAN_HARRIS', 2.5), ('GAUSSIAN', 2.5), ('BOX', 1.0)])
def test_pixel_filters(kind: str, width: float) -> None:
    scene = build.new_scene()
    build.camera(scene)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = kind, 2.5
    log = Log()
    found = exported_camera(scene, log)
    assert (found.filter, found.filter_width) == (kind, width) and not log.texts('WARNING')


def test_resolution_and_border_are_those_of_real_renders() -> None:
    """The size that Blender gives a render result, over borders that fall between pixels."""
    scene = build.new_scene()
    build.camera(scene)
    render = scene.render
    random = np.random.default_rng(3)
    for index in range(24):
        render.resolution_x, render.resolution_y = (int(value) for value in random.integers(8, 200, 2))
        render.resolution_percentage = int(random.integers(40, 130))
        render.use_border, render.use_crop_to_border = index > 3, bool(index % 2)
        low = random.integers(0, 50, 2) / 100
        high = low + random.integers(20, 50, 2) / 100
        render.border_min_x, render.border_min_y = low
        render.border_max_x, render.border_max_y = high

        def look(engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> tuple:
            result = engine.begin_result(0, 0, engine.resolution_x, engine.resolution_y)
            size = result.resolution_x, result.resolution_y
            engine.end_result(result)
            whole = engine.resolution_x, engine.resolution_y
            return size, whole, border_region(depsgraph.scene_eval.render), resolution(depsgraph.scene_eval.render)

        [(size, whole, region, found)] = in_render(scene, look)
        assert found == whole and region[2:] == size
        assert region[0] == (int(np.float32(low[0]) * np.float32(whole[0])) if render.use_border else 0)


def test_border_is_the_default_region() -> None:
    scene = build.new_scene()
    camera = build.camera(scene)
    render = scene.render
    render.resolution_x, render.resolution_y = 200, 100
    assert exported_camera(scene).region == (0, 0, 200, 100)
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.5, 0.5, 0.75
    assert exported_camera(scene).region == (50, 50, 50, 25)
    assert exported_camera(scene).resolution == (200, 100)
    assert export_camera(scene, camera, Log(), region=(1, 2, 3, 4)).region == (1, 2, 3, 4)


def test_picture_of_one_pixel() -> None:
    scene = build.new_scene()
    build.camera(scene)
    scene.render.resolution_x = scene.render.resolution_y = 4  # Blender's smallest
    scene.render.resolution_percentage = 25
    found = exported_camera(scene)
    assert found.resolution == (1, 1) and found.region == (0, 0, 1, 1)


def test_looking_through_a_spot_light() -> None:
    scene = build.new_scene()
    scene.camera = build.light(scene, 'SPOT', spot_size=math.radians(90))
    scene.render.resolution_x = scene.render.resolution_y = 64
    found = exported_camera(scene)
    # Cycles: a lens of 16 / tan(spot_size / 2) before a sensor of 36.
    assert found.window == pytest.approx((-1.125, 1.125, -1.125, 1.125))


# ---- Bad input.


def test_no_camera() -> None:
    scene = build.new_scene()
    log = Log()
    assert exported_camera(scene, log) is None
    assert log.texts('ERROR') == ['Scene "Scene" has no camera']


def test_camera_without_a_view() -> None:
    scene = build.new_scene()
    build.camera(scene).scale = (1, 0, 1)
    log = Log()
    assert exported_camera(scene, log) is None
    assert log.texts('ERROR') == ['Camera "Camera": its transform is not invertible or not finite']


def test_panorama_and_depth_of_field_are_reported() -> None:
    scene = build.new_scene()
    build.camera(scene, type='PANO').data.dof.use_dof = True
    log = Log()
    assert exported_camera(scene, log).kind == 'PERSP'
    assert log.texts('WARNING') == [
        'Camera "Camera": type PANO is not supported yet: rendered as perspective',
        'Camera "Camera": depth of field is not supported yet: everything is in focus',
    ]


def test_clipping_that_shows_nothing() -> None:
    scene = build.new_scene()
    build.camera(scene, clip_start=10, clip_end=1)
    log = Log()
    near, far = exported_camera(scene, log).clip
    assert np.float32(near) == 10 and np.float32(far) > np.float32(near)
    assert log.texts('WARNING') == ['Camera "Camera": clip start 10 is not before clip end 1: nothing is seen']
