# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a 3D viewport looks from: its region's matrices as a `Camera`, and the part of the region that is rendered.

Blender's own projection is taken apart, not computed again: zoom, offset, shift and sensor of a camera view are in it,
and overlays lie on the picture. What a camera is like beyond that is export/camera.py's.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import bpy
import numpy as np

from ..export import camera as export_camera
from ..export.buffers import Camera
from ..log import Log

Region = tuple[int, int, int, int]

CAMERA_VIEW = 'CAMERA'


def read_view(
    scene: bpy.types.Scene,
    space: bpy.types.SpaceView3D,
    view: bpy.types.RegionView3D,
    size: tuple[int, int],
    camera_object: bpy.types.Object | None,
    log: Log,
) -> Camera | None:
    """The view of a region of `size` pixels; None, with an error in the log, where its matrices give none.

    scene and camera_object are the evaluated ones. The camera object is looked through where the view is a camera's;
    the viewport then has its clipping, else that of the space.
    """
    projection = np.array(view.window_matrix, np.float64)
    transform = _inverse(np.array(view.view_matrix, np.float64))
    if transform is None or not np.isfinite(projection).all() or projection[0, 0] == 0.0 or projection[1, 1] == 0.0:
        log.error('The view has no direction that can be rendered')
        return None
    orthographic = projection[3, 3] != 0.0
    through = camera_object if view.view_perspective == CAMERA_VIEW else None
    clip = _clip(space, through)
    if orthographic and through is None:
        # Such a view goes on behind the viewer for as far as before; rays begin there.
        half = 0.5 * clip[1]
        transform[:, 3] += half * transform[:, 2]
        clip = (0.0, 2.0 * half)
    camera = Camera(
        kind='ORTHO' if orthographic else 'PERSP',
        transform=np.ascontiguousarray(transform, np.float32),
        window=window_of(projection),
        clip=clip,
        resolution=size,
        region=(0, 0, *size),
        **export_camera.pixel_filter(scene, log),
    )
    return replace(camera, region=rendered_region(scene, space, camera, through, log))


def window_of(projection: np.ndarray) -> tuple[float, float, float, float]:
    """left, right, bottom, top of a projection matrix (OpenGL's, 4 x 4): see `Camera.window`."""
    (sx, _, ax, bx), (_, sy, ay, by) = projection[:2]
    if projection[3, 3] != 0.0:
        return (-1.0 - bx) / sx, (1.0 - bx) / sx, (-1.0 - by) / sy, (1.0 - by) / sy
    return (ax - 1.0) / sx, (ax + 1.0) / sx, (ay - 1.0) / sy, (ay + 1.0) / sy


def rendered_region(
    scene: bpy.types.Scene, space: bpy.types.SpaceView3D, camera: Camera, through: bpy.types.Object | None, log: Log
) -> Region:
    """The border, within the region: of the camera's picture in its view, else the viewport's own."""
    width, height = camera.resolution
    whole = (0, 0, width, height)
    if through is not None:
        if not scene.render.use_border:
            return whole
        frame = frame_in(scene, through, camera, log)
        border = scene.render
        names = ('border_min_x', 'border_max_x', 'border_min_y', 'border_max_y')
    else:
        if not space.use_render_border:
            return whole
        frame, border = (0.0, float(width), 0.0, float(height)), space
        names = ('render_border_min_x', 'render_border_max_x', 'render_border_min_y', 'render_border_max_y')
    x0, x1, y0, y1 = (getattr(border, name) for name in names)
    left, right, bottom, top = frame
    a, b = _pixels(left + x0 * (right - left), left + x1 * (right - left), width)
    c, d = _pixels(bottom + y0 * (top - bottom), bottom + y1 * (top - bottom), height)
    return a, c, b - a, d - c


def frame_in(
    scene: bpy.types.Scene, camera_object: bpy.types.Object, camera: Camera, log: Log
) -> tuple[float, float, float, float]:
    """left, right, bottom, top of a camera's picture in pixels of the region that shows it."""
    width, height = camera.resolution
    own = export_camera.read_camera(scene, camera_object, log, (0, 0, 1, 1))
    if own is None:
        return 0.0, float(width), 0.0, float(height)
    left, right, bottom, top = camera.window
    x, y = width / (right - left), height / (top - bottom)
    a, b, c, d = own.window
    return (a - left) * x, (b - left) * x, (c - bottom) * y, (d - bottom) * y


def coarser(camera: Camera, divisor: int) -> Camera:
    """The same view with pixels that are `divisor` times as wide and high; those at the right and top reach beyond."""
    if divisor == 1:
        return camera
    width, height = camera.resolution
    left, right, bottom, top = camera.window
    columns, rows = -(-width // divisor), -(-height // divisor)
    x0, y0, w, h = camera.region
    x, y = x0 // divisor, y0 // divisor
    return replace(
        camera,
        window=(
            left,
            left + (right - left) * columns * divisor / width,
            bottom,
            bottom + (top - bottom) * rows * divisor / height,
        ),
        resolution=(columns, rows),
        region=(x, y, -(-(x0 + w) // divisor) - x, -(-(y0 + h) // divisor) - y),
    )


def same(a: Camera | None, b: Camera | None) -> bool:
    """Whether two views show the same."""
    return a is b or (a is not None and b is not None and _values(a) == _values(b))


def _values(camera: Camera) -> tuple:
    lens = (camera.kind, camera.window, camera.clip, camera.filter, camera.filter_width)
    return camera.transform.tobytes(), *lens, camera.resolution, camera.region


def _clip(space: Any, camera_object: bpy.types.Object | None) -> tuple[float, float]:
    data = camera_object.data if camera_object is not None else None
    owner = data if isinstance(data, bpy.types.Camera) else space
    start, end = owner.clip_start, owner.clip_end
    return (start, end) if start < end else (start, float(np.nextafter(np.float32(start), np.float32(np.inf))))


def _inverse(matrix: np.ndarray) -> np.ndarray | None:
    if not np.isfinite(matrix).all() or np.linalg.det(matrix) == 0.0:
        return None
    return np.linalg.inv(matrix)[:3].copy()


def _pixels(low: float, high: float, count: int) -> tuple[int, int]:
    """Whole pixels between two places, within the region, at least one."""
    first = min(max(round(low), 0), count - 1)
    return first, max(min(round(high), count), first + 1)
