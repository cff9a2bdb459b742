# SPDX-License-Identifier: GPL-3.0-or-later
"""The studio light of a Rendered viewport, which shows it in place of the scene's world: an image, turned about Z.

It is as Cycles has it: rays that are no camera's see the image; the camera's see it as far as its opacity says, else
the world's color. Blur of the background is EEVEE's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from .. import shader
from ..shader.tree import VECTOR_ADD, Builder, Draft
from .buffers import EXTENSION_REPEAT, INTERPOLATION_LINEAR
from .images import ImageTable
from .sockets import Color

CAMERA_RAY = 0  # of the op light_path


@dataclass(frozen=True, slots=True)
class Studio:
    """path: of its image, '' for none. rotation: radians. alpha: its opacity as a background."""

    path: str
    rotation: float
    intensity: float
    alpha: float


def read_studio(space: bpy.types.SpaceView3D | None) -> Studio | None:
    """The studio light that a viewport shows; None where it shows the scene's world."""
    if space is None or space.shading.use_scene_world_render:
        return None
    shading = space.shading
    light = shading.selected_studio_light
    return Studio(
        path=light.path if light is not None else '',
        rotation=shading.studiolight_rotate_z,
        intensity=shading.studiolight_intensity,
        alpha=shading.studiolight_background_alpha,
    )


def studio_shader(studio: Studio, color: Color, images: ImageTable, warn: Callable[[str], None]) -> Draft:
    """color: of the world. Where its image cannot be read, that color is all there is, and `warn` takes the reason."""
    builder = Builder(shader.tables())
    plain = builder.constant(tuple(map(float, color)))
    loaded = images.load_file(studio.path)
    if isinstance(loaded, str):
        warn(loaded)
        builder.closure('emission', builder.constant(1.0), plain)
        return builder.draft('studio light')
    at = builder.emit('position')
    c, s = math.cos(studio.rotation), math.sin(studio.rotation)
    turned = np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))
    rows = [builder.constant(tuple(map(float, row))) for row in turned]
    at = builder.emit('affine', at, *rows, builder.constant(0.0))
    mode = INTERPOLATION_LINEAR | EXTENSION_REPEAT << 2
    light = builder.emit('environment_v', at, builder.constant(float(loaded.index)), mode=mode)
    light = builder.scale(light, builder.constant(studio.intensity))
    if studio.alpha < 1.0:
        hidden = builder.multiply(builder.emit('light_path', mode=CAMERA_RAY), builder.constant(1.0 - studio.alpha))
        zero = builder.constant(0.0)
        seen = builder.scale(light, builder.one_minus(hidden))
        light = builder.emit('vector_math_v', seen, builder.scale(plain, hidden), zero, zero, mode=VECTOR_ADD)
    builder.closure('emission', builder.constant(1.0), light)
    return builder.draft('studio light')
