# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D viewport looks from is Blender's own projection, and its borders lie where Blender draws them.

There is no window here: stand-ins have what a region has, with matrices that Blender computed for a camera.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from cotorra.log import Log
from cotorra.viewport import view

import viewports
from scenes import build
from scenes.depsgraphs import exported_camera

SIZE = (320, 180)


def made(kind: str = 'PERSP') -> bpy.types.Object:
    scene = build.new_scene()
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    camera = build.camera(scene, type=kind, lens=35, ortho_scale=7, shift_x=0.1, shift_y=-0.2)
    camera.location, camera.rotation_euler, camera.scale = (1.0, -8.0, 3.0), (1.2, 0.1, 0.3), (2.0, 2.0, 2.0)
    bpy.context.view_layer.update()
    return camera


def read(camera: bpy.types.Object | None, region_view, space=None, size=SIZE):
    scene = bpy.context.evaluated_depsgraph_get().scene_eval
    return view.read_view(scene, space or viewports.space(), region_view, size, camera, Log())


@pytest.mark.parametrize('kind', ['PERSP', 'ORTHO'])
def test_a_camera_view_is_the_cameras_own(kind: str) -> None:
    """Where its frame fills the region, all is as in a final render: lens, shift, place and clipping."""
    camera = made(kind)
    found = read(camera, viewports.looking_through(camera, SIZE))
    expected = exported_camera(bpy.context.scene)
    assert found.kind == expected.kind and found.clip == expected.clip
    assert found.resolution == expected.resolution and found.region == expected.region
    assert found.window == pytest.approx(expected.window, abs=2e-6)
    assert found.transform == pytest.approx(expected.transform, abs=2e-6)


def test_zoom_shows_more_around_the_frame() -> None:
    camera = made()
    whole = read(camera, viewports.looking_through(camera, SIZE))
    found = read(camera, viewports.looking_through(camera, SIZE, 0.5))
    # Blender's projection has the shift in the third column, which is scaled with it: about the same middle.
    widths = [right - left for left, right, _, _ in (found.window, whole.window)]
    assert widths[0] == pytest.approx(2.0 * widths[1])


def test_the_cameras_border_lies_in_its_frame() -> None:
    camera = made()
    render = bpy.context.scene.render
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
    camera.data.shift_x = camera.data.shift_y = 0.0
    found = read(camera, viewports.looking_through(camera, SIZE, 0.5))
    # The frame is half as wide and high as the region and in its middle: from 80 to 240, and from 45 to 135.
    assert found.region == (120, 90, 80, 45)
    assert read(camera, viewports.looking_through(camera, SIZE)).region == (80, 90, 160, 90)
    # A view that is no camera's has a border of its own.
    free = viewports.looking_through(camera, SIZE, view_perspective='PERSP')
    assert read(camera, free).region == (0, 0, *SIZE)


def test_the_viewports_own_border() -> None:
    camera = made()
    free = viewports.looking_through(camera, SIZE, view_perspective='PERSP')
    border = {'use_render_border': True, 'render_border_min_x': 0.5, 'render_border_max_y': 0.25}
    assert read(None, free, viewports.space(**border)).region == (160, 0, 160, 45)
    # One of no extent still has a pixel, within the region.
    empty = {'use_render_border': True, 'render_border_min_x': 1.0, 'render_border_max_y': 0.0}
    assert read(None, free, viewports.space(**empty)).region == (319, 0, 1, 1)


def test_an_orthographic_view_sees_what_is_behind_the_viewer() -> None:
    camera = made('ORTHO')
    free = viewports.looking_through(camera, SIZE, view_perspective='ORTHO')
    found = read(camera, free, viewports.space(clip_end=100.0))
    own = read(camera, viewports.looking_through(camera, SIZE))
    assert found.clip == (0.0, 100.0)
    back = found.transform[:, 3] - own.transform[:, 3]
    assert back == pytest.approx(50.0 * own.transform[:, 2], abs=1e-4)


def test_a_free_view_has_the_clipping_of_its_space() -> None:
    free = viewports.looking_through(made(), SIZE, view_perspective='PERSP')
    assert read(None, free, viewports.space(clip_start=0.5, clip_end=20.0)).clip == (0.5, 20.0)
    start, end = read(None, free, viewports.space(clip_start=2.0, clip_end=1.0)).clip
    assert start == 2.0 and start < end


@pytest.mark.parametrize('broken', ['view_matrix', 'window_matrix'])
@pytest.mark.parametrize('value', [0.0, np.nan, np.inf])
def test_matrices_without_a_view_give_none(broken: str, value: float) -> None:
    free = viewports.looking_through(made(), SIZE, **{broken: np.full((4, 4), value)})
    assert read(None, free) is None


@pytest.mark.parametrize('size', [(320, 180), (321, 179), (1, 1), (3, 500)])
def test_large_pixels_lie_on_the_small_ones(size: tuple[int, int]) -> None:
    """A corner of a large pixel is one of a small pixel, and together they cover what is rendered."""
    camera = read(None, viewports.looking_through(made(), size, view_perspective='PERSP'), size=size)
    for divisor in (1, 2, 8):
        found = view.coarser(camera, divisor)
        for axis in (0, 1):
            low, high = found.window[2 * axis], found.window[2 * axis + 1]
            fine = (camera.window[2 * axis + 1] - camera.window[2 * axis]) / size[axis]
            assert (high - low) / found.resolution[axis] == pytest.approx(divisor * fine)
            assert low == camera.window[2 * axis]
            first, count = found.region[axis], found.region[2 + axis]
            assert first * divisor <= camera.region[axis]
            assert (first + count) * divisor >= camera.region[axis] + camera.region[2 + axis]
            assert first + count <= found.resolution[axis]
