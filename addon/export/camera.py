# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera, and the part of its picture that is rendered, exactly as Blender and Cycles place them.

Panoramas and depth of field are reported and left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..log import Log
from . import bounds
from .buffers import F32, Camera

# What a lens may say at most: with all of them there, a ray through the picture still has a length and a direction.
LARGEST = {'shift_x': 1e4, 'shift_y': 1e4, 'ortho_scale': 1e9, 'lens': 1e6, 'sensor_width': 1e6, 'sensor_height': 1e6}


@dataclass(frozen=True, slots=True)
class Lens:
    """What `Camera` data say; the defaults are what Cycles takes for an object that is no camera."""

    orthographic: bool = False
    ortho_scale: float = 1.0
    focal_length: float = 50.0
    sensor_fit: str = 'AUTO'
    sensor_width: float = 36.0
    sensor_height: float = 24.0
    shift: tuple[float, float] = (0.0, 0.0)
    clip: tuple[float, float] = (1e-5, 1e5)


def read_camera(
    scene: bpy.types.Scene, obj: bpy.types.Object, log: Log, region: tuple[int, int, int, int] | None
) -> Camera | None:
    """The camera `obj` in `scene`; None, with an error in the log, where its transform gives no view."""

    def warn(text: str) -> None:
        log.warning(f'Camera "{obj.name}": {text}')

    transform = _without_scale(np.array(obj.matrix_world, np.float64))
    if transform is None:
        log.error(f'Camera "{obj.name}": its transform is not invertible or not finite')
        return None
    transform[:, 3] = bounds.color(transform[:, 3], (0.0, 0.0, 0.0), 'its place', warn)
    render = scene.render
    width, height = resolution(render)
    aspect_x, aspect_y = (_number(render, name, warn) for name in ('pixel_aspect_x', 'pixel_aspect_y'))
    lens = _read_lens(obj, warn)
    return Camera(
        kind='ORTHO' if lens.orthographic else 'PERSP',
        transform=transform,
        window=view_window(lens, width * aspect_x, height * aspect_y),
        clip=lens.clip,
        resolution=(width, height),
        region=region if region is not None else border_region(render),
        **pixel_filter(scene, log),
    )


def resolution(render: bpy.types.RenderSettings) -> tuple[int, int]:
    """Width and height of the whole picture in pixels, as Blender rounds them."""
    percentage = render.resolution_percentage
    return max(render.resolution_x * percentage // 100, 1), max(render.resolution_y * percentage // 100, 1)


def border_region(render: bpy.types.RenderSettings) -> tuple[int, int, int, int]:
    """x0, y0, width and height of the render border, truncated in single precision, as Blender does."""
    width, height = resolution(render)
    if not render.use_border:
        return 0, 0, width, height
    x0, x1 = (int(np.float32(x) * np.float32(width)) for x in (render.border_min_x, render.border_max_x))
    y0, y1 = (int(np.float32(y) * np.float32(height)) for y in (render.border_min_y, render.border_max_y))
    return x0, y0, max(x1 - x0, 1), max(y1 - y0, 1)


def view_window(lens: Lens, width: float, height: float) -> tuple[float, float, float, float]:
    """left, right, bottom, top on the plane z = -1, or in metres if orthographic.

    The sensor spans the side that `sensor_fit` says (AUTO: the longer one, always with sensor_width); shift counts in
    that side's whole length. width and height are in pixels times pixel aspect.
    """
    horizontal = width > height if lens.sensor_fit == 'AUTO' else lens.sensor_fit == 'HORIZONTAL'
    if lens.orthographic:
        half = 0.5 * lens.ortho_scale
    else:
        half = 0.5 * (lens.sensor_height if lens.sensor_fit == 'VERTICAL' else lens.sensor_width) / lens.focal_length
    half_x, half_y = (half, half * height / width) if horizontal else (half * width / height, half)
    x, y = 2.0 * half * lens.shift[0], 2.0 * half * lens.shift[1]
    return x - half_x, x + half_x, y - half_y, y + half_y


def _read_lens(obj: bpy.types.Object, warn: bounds.Warn) -> Lens:
    data = obj.data
    if isinstance(data, bpy.types.SpotLight):
        # One can look through a spot light: its cone is the field of view of a 32 mm sensor.
        return Lens(focal_length=16.0 / math.tan(0.5 * _number(data, 'spot_size', warn)))
    if not isinstance(data, bpy.types.Camera):
        return Lens()
    if data.type not in ('PERSP', 'ORTHO'):
        warn(f'type {data.type} is not supported yet: rendered as perspective')
    if data.dof.use_dof:
        warn('depth of field is not supported yet: everything is in focus')
    return Lens(
        orthographic=data.type == 'ORTHO',
        ortho_scale=_number(data, 'ortho_scale', warn),
        focal_length=_number(data, 'lens', warn),
        sensor_fit=data.sensor_fit,
        sensor_width=_number(data, 'sensor_width', warn),
        sensor_height=_number(data, 'sensor_height', warn),
        shift=(_number(data, 'shift_x', warn), _number(data, 'shift_y', warn)),
        clip=_clip(_number(data, 'clip_start', warn), _number(data, 'clip_end', warn), warn),
    )


def _number(owner: bpy.types.bpy_struct, name: str, warn: bounds.Warn) -> float:
    most = LARGEST.get(name, bounds.LARGEST)
    return bounds.of_property(owner, name, warn, -most, most)


def _clip(start: float, end: float, warn: bounds.Warn) -> tuple[float, float]:
    if start < end:
        return start, end
    warn(f'clip start {start:g} is not before clip end {end:g}: nothing is seen')
    return start, float(np.nextafter(np.float32(start), np.float32(np.inf)))


def _without_scale(matrix: np.ndarray) -> F32 | None:
    """The matrix with axes of unit length: a camera's scale does not zoom. None where it has not three axes."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.isfinite(matrix).all() or (lengths == 0.0).any():
        return None
    unscaled = matrix[:3].copy()
    unscaled[:, :3] /= lengths
    if np.linalg.det(unscaled[:, :3]) == 0.0:
        return None
    return unscaled.astype(np.float32)


def pixel_filter(scene: bpy.types.Scene, log: Log) -> dict[str, Any]:
    """`filter` and `filter_width` of a Camera: Cycles', for its scenes to look the same; else the scene's width."""
    cycles = getattr(scene, 'cycles', None)  # absent where the Cycles add-on is disabled
    if cycles is None:
        return {'filter_width': scene.render.filter_size}
    if cycles.pixel_filter_type == 'BOX':  # a pixel wide, whatever the width
        return {'filter': 'BOX', 'filter_width': 1.0}
    width = bounds.of_property(cycles, 'filter_width', lambda text: log.warning(f'Scene "{scene.name}": {text}'))
    return {'filter': cycles.pixel_filter_type, 'filter_width': width}
