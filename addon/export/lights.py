# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps to arrays, in Blender's units.

Radiance is derived in the native module. Emissive meshes are materials, the world is world.py's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..lamps import pass_names, pass_numbers
from ..log import Log
from . import bounds
from .beams import Beam, beam_arrays, read_beam
from .buffers import F32, I32, LIGHT_AREA, LIGHT_POINT, LIGHT_SPOT, LIGHT_SUN, Lights
from .shaders import ShaderTable
from .sockets import Color

TYPES = {'POINT': LIGHT_POINT, 'SUN': LIGHT_SUN, 'SPOT': LIGHT_SPOT, 'AREA': LIGHT_AREA}
SIZES = {'SUN': 'angle', 'AREA': 'size'}  # of the others shadow_soft_size
BLACK: Color = (0.0, 0.0, 0.0)
MAX_BOUNCES = 1024  # Cycles' default, where its settings do not exist
SHEAR = 1e-3  # cosine of the angle between two axes: below, rounding made it


@dataclass(frozen=True, slots=True)
class Lamp:
    """One entry of the Lights arrays, without what differs between the instances of one lamp."""

    name: str
    type: int
    strength: Color
    size: float
    spot_size: float
    spot_blend: float
    soft_falloff: bool
    normalize: bool
    cast_shadow: bool
    use_mis: bool
    max_bounces: int
    visibility: int
    light_group: int
    beam: Beam
    shader: int
    size_y: float = 0.0
    spread: float = math.pi
    ellipse: bool = False


def read_lamp(
    obj: bpy.types.Object,
    visibility: int,
    light_group: int,
    log: Log,
    shaders: ShaderTable,
) -> Lamp | None:
    """The lamp of a light object, or None where it gives no light."""
    light = obj.data
    settings = getattr(light, 'cycles', None)  # absent where the Cycles add-on is disabled
    if light.type == 'AREA' and getattr(settings, 'is_portal', False):
        return None  # it shows where the world's light comes in, and gives none itself

    def warn(text: str) -> None:
        log.warning(f'Light "{obj.name}": {text}')

    strength = _strength(light, warn)
    if not any(strength) or not visibility:
        return None
    beam = read_beam(light, obj.name, log)
    if beam is None:
        return None
    spot = light.type == 'SPOT'
    size = bounds.of_property(light, SIZES.get(light.type, 'shadow_soft_size'), warn, 0.0)
    area = _area(light, size, warn) if light.type == 'AREA' else {}
    if area and not (size > 0.0 and area['size_y'] > 0.0):
        warn('its size is 0: it lights nothing')
        return None
    return Lamp(
        name=obj.name,
        type=TYPES[light.type],
        strength=strength,
        size=size,
        spot_size=bounds.of_property(light, 'spot_size', warn, 0.0) if spot else 0.0,
        spot_blend=bounds.of_property(light, 'spot_blend', warn, 0.0, 1.0) if spot else 0.0,
        soft_falloff=light.type in {'POINT', 'SPOT'} and light.use_soft_falloff,
        normalize=light.normalize,
        cast_shadow=light.use_shadow and getattr(settings, 'cast_shadow', True),
        use_mis=getattr(settings, 'use_multiple_importance_sampling', True),
        max_bounces=getattr(settings, 'max_bounces', MAX_BOUNCES),
        visibility=visibility,
        light_group=light_group,
        beam=beam,
        shader=shaders.index(light, warn),
        **area,
    )


def _area(light: bpy.types.AreaLight, size: float, warn: bounds.Warn) -> dict[str, Any]:
    """What an area light has beside a width."""
    two = light.shape in {'RECTANGLE', 'ELLIPSE'}
    return {
        'size_y': bounds.of_property(light, 'size_y', warn, 0.0) if two else size,
        'spread': bounds.of_property(light, 'spread', warn, 0.0),
        'ellipse': light.shape in {'DISK', 'ELLIPSE'},
    }


def light_arrays(
    lamps: list[Lamp], transforms: F32, lamp_of: I32, view_layer: bpy.types.ViewLayer, alone: str | None = None
) -> Lights:
    """One light for each transform (N, 3, 4), with the properties of its lamp. alone: the one that 'light:0' shows."""

    def column(name: str, dtype: type, *shape: int) -> np.ndarray:
        values = np.array([getattr(lamp, name) for lamp in lamps], dtype).reshape(len(lamps), *shape)
        return values[lamp_of]

    area_arrays = {}
    if any(lamp.type == LIGHT_AREA for lamp in lamps):
        kinds = {'size_y': np.float32, 'spread': np.float32, 'ellipse': np.uint32}
        area_arrays = {name: column(name, kind) for name, kind in kinds.items()}
    return Lights(
        type=column('type', np.uint32),
        strength=column('strength', np.float32, 3),
        transform=np.ascontiguousarray(transforms),
        size=column('size', np.float32),
        spot_size=column('spot_size', np.float32),
        spot_blend=column('spot_blend', np.float32),
        soft_falloff=column('soft_falloff', np.uint32),
        normalize=column('normalize', np.uint32),
        cast_shadow=column('cast_shadow', np.uint32),
        use_mis=column('use_mis', np.uint32),
        max_bounces=column('max_bounces', np.uint32),
        visibility=column('visibility', np.uint32),
        light_group=column('light_group', np.int32),
        names=tuple(lamps[index].name for index in lamp_of),
        pass_index=_pass_indices([lamps[index].name for index in lamp_of], view_layer, alone),
        shader=column('shader', np.int32),
        **area_arrays,
        **beam_arrays([lamps[index].beam for index in lamp_of]),
    )


def _pass_indices(names: list[str], view_layer: bpy.types.ViewLayer, alone: str | None) -> I32 | None:
    """The pass that shows each lamp alone, where the view layer asks for such passes, or a viewport for one."""
    if alone is not None and names:
        return np.array([-(name != alone) for name in names], np.int32)
    pass_of, numbers = pass_names(view_layer), pass_numbers(view_layer)
    if not pass_of or not names:
        return None
    return np.array([numbers.get(pass_of.get(name, ''), -1) for name in names], np.int32)


def _strength(light: bpy.types.Light, warn: Callable[[str], None]) -> Color:
    """Colour × temperature colour × energy × 2^exposure; black where it is no number."""
    with np.errstate(all='ignore'):
        color = np.array(light.color, np.float64) * light.energy * np.exp2(np.float64(light.exposure))
    if light.use_temperature:
        color *= light.temperature_color
    if not np.isfinite(color).all():
        warn('its strength is not a finite number: left out')
        return BLACK
    return bounds.color(color, BLACK, 'its strength', warn)


def usable(lamps: list[Lamp], transforms: F32, lit: I32, lamp_of: I32, log: Log) -> tuple[I32, I32]:
    """Of the instances `lit` of the lamps `lamp_of`, those whose transform (N, 3, 4) a lamp can have."""
    good = _usable(transforms[lit])
    for index in sorted(set(lamp_of[~good].tolist())):
        log.warning(f'Light "{lamps[index].name}": its transform is not invertible or not finite: left out')
    lit, lamp_of = lit[good], lamp_of[good]
    directed = np.array([lamp.type in (LIGHT_AREA, LIGHT_SPOT) for lamp in lamps], bool)
    for index in sorted(set(lamp_of[directed[lamp_of] & _sheared(transforms[lit])].tolist())):
        log.warning(f'Light "{lamps[index].name}": its transform shears it: Cycles lights otherwise there')
    return lit, lamp_of


def _sheared(transforms: F32) -> np.ndarray:
    """Which transforms, invertible ones, have axes that are not perpendicular, beyond what rounding does."""
    axes = transforms[:, :, :3] / np.linalg.norm(transforms[:, :, :3], axis=1, keepdims=True)
    cosines = np.einsum('nij,nik->njk', axes, axes) - np.eye(3)
    return np.abs(cosines).max(axis=(1, 2), initial=0.0) > SHEAR


def _usable(transforms: F32) -> np.ndarray:
    """Which transforms are finite and invertible: a lamp needs all its axes for its direction and its cone."""
    finite = (np.abs(transforms) <= bounds.LARGEST).all(axis=(1, 2))
    linear = np.where(finite[:, None, None], transforms[:, :, :3], 0.0).astype(np.float64)
    return finite & (np.linalg.det(linear) != 0.0)
