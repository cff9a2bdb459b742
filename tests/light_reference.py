# SPDX-License-Identifier: GPL-3.0-or-later
"""Hard lights in double precision, straight from their formulas: what arrives at a point, and from where.

It reads Blender's light objects and shares no code with the kernels. Sizes above 0 are not covered.
"""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]


def arriving(lamp: bpy.types.Object, points: F64) -> tuple[F64, F64]:
    """Unit directions (N, 3) from the points to the lamp, and the irradiance (N, 3) on surfaces that face it."""
    light = lamp.data
    world = np.array(lamp.matrix_world, np.float64)
    strength = np.array(light.color, np.float64) * light.energy * 2.0**light.exposure
    backward = world[:3, 2] / np.linalg.norm(world[:3, 2])  # a lamp shines along its own -Z
    if light.type == 'SUN':
        return np.broadcast_to(backward, points.shape), np.broadcast_to(strength, points.shape)
    away = world[:3, 3] - points
    d = np.linalg.norm(away, axis=-1, keepdims=True)
    wi = away / d
    amount = attenuation(light.cotorra, d)
    if light.type == 'SPOT':
        amount = amount * cone(light, np.clip(wi @ backward, -1.0, 1.0))[:, None]
    return wi, strength / (4.0 * np.pi) * amount


def attenuation(settings: bpy.types.PropertyGroup, d: F64) -> F64:
    """By the distance d in metres."""
    if settings.falloff == 'RANGED':
        return np.clip(1.0 - (d / settings.range) ** 4, 0.0, 1.0) / d**2
    if settings.falloff == 'POLYNOMIAL':
        return 1.0 / (settings.c0 + settings.c1 * d + settings.c2 * d**2)
    return 1.0 / d**2


def cone(light: bpy.types.SpotLight, cosine: F64) -> F64:
    """By the cosine between the spot's axis and the direction to the point."""
    settings = light.cotorra
    inner, outer = settings.inner_angle, settings.outer_angle
    if settings.spot_edge == 'LINEAR':
        return np.clip((outer - np.arccos(cosine)) / (outer - inner), 0.0, 1.0)
    if settings.spot_edge == 'SQUARED':
        return np.clip((cosine - np.cos(outer)) / (np.cos(inner) - np.cos(outer)), 0.0, 1.0) ** 2
    edge = np.cos(light.spot_size / 2.0)
    x = np.clip((cosine - edge) / ((1.0 - edge) * light.spot_blend), 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)
