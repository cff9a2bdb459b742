# SPDX-License-Identifier: GPL-3.0-or-later
"""Values that shader inputs take: constants, and images behind an affine map; their algebra, and their arrays.

It knows no node and no Blender: texture_nodes.py reads the trees, images.py the images.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .buffers import (
    CHANNEL_LUMINANCE,
    CHANNEL_R,
    CHANNEL_RGB,
    COORDINATES_UV,
    EXTENSION_REPEAT,
    INTERPOLATION_LINEAR,
    NORMAL_TANGENT,
    TEXTURE_SLOT,
    TEXTURE_UNASSOCIATE,
)

Color = tuple[float, ...]  # three, scene-linear
Row = tuple[float, float, float, float]

BLACK = (0.0, 0.0, 0.0)
WHITE = (1.0, 1.0, 1.0)

# Luminance of linear Rec.709, Blender's default working space: what a colour is where a number is asked for.
LUMINANCE = (0.2126390, 0.7151687, 0.0721923)


class NotAffineError(Exception):
    """A value that is no affine function of one channel of one image."""


@dataclass(frozen=True, slots=True)
class Lookup:
    """Where an image is read, and how. uv_map: '' = the active render one. mapping: the rows that give s and t."""

    image: int
    coordinates: int = COORDINATES_UV
    uv_map: str = ''
    mapping: tuple[Row, Row] = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))
    interpolation: int = INTERPOLATION_LINEAR
    extension: int = EXTENSION_REPEAT
    unassociate: bool = False


@dataclass(frozen=True, slots=True)
class Texture:
    """scale × channel + offset by components; a constant (its offset) where there is no lookup.

    Numbers are three components alike.
    threshold: the channel is 1 from there on and 0 below, if it is not None.
    bounded:   the channel lies within 0 and 1, as the texels of integer images do.
    """

    lookup: Lookup | None
    channel: int = CHANNEL_RGB
    scale: Color = WHITE
    offset: Color = BLACK
    threshold: float | None = None
    bounded: bool = False

    def bounds(self) -> tuple[float, float]:
        """The least and the greatest value of all components."""
        if self.lookup is None:
            return min(self.offset), max(self.offset)
        if not (self.bounded or self.threshold is not None):
            return -math.inf, math.inf
        ends = [*self.offset, *(o + s for o, s in zip(self.offset, self.scale, strict=True))]
        return min(ends), max(ends)

    def typical(self) -> Color:
        """The value where the image is mid-grey: what stands for a texture where a constant is asked for."""
        return _combine(lambda s, o: 0.5 * s + o, self.scale, self.offset)


@dataclass(frozen=True, slots=True)
class NormalMap:
    """Normals from an image. space: NORMAL_*; uv_map: whose tangents, '' = the active render one's."""

    texture: Texture
    strength: float = 1.0
    space: int = NORMAL_TANGENT
    uv_map: str = ''


def constant(value: float | Color) -> Texture:
    return Texture(None, scale=BLACK, offset=value if isinstance(value, tuple) else (float(value),) * 3)


# ---- Algebra. What leaves it raises NotAffineError.


def multiply(a: Texture, b: Texture) -> Texture:
    if b.lookup is not None:
        a, b = b, a
    if b.lookup is not None:
        raise NotAffineError
    return _simple(replace(a, scale=_times(a.scale, b.offset), offset=_times(a.offset, b.offset)))


def add(a: Texture, b: Texture) -> Texture:
    if a.lookup is None:
        a, b = b, a
    if b.lookup is not None and replace(b, scale=a.scale, offset=a.offset) != a:
        raise NotAffineError
    scale = _combine(lambda x, y: x + y, a.scale, b.scale)
    return _simple(replace(a, scale=scale, offset=_combine(lambda x, y: x + y, a.offset, b.offset)))


def affine(a: Texture, scale: float, offset: float) -> Texture:
    return add(multiply(a, constant(scale)), constant(offset))


def mix(a: Texture, b: Texture, factor: Texture) -> Texture:
    """a × (1 - factor) + b × factor."""
    return add(multiply(a, affine(factor, -1.0, 1.0)), multiply(b, factor))


def luminance(a: Texture) -> Texture:
    """A colour as a number."""
    offset = (_dot(LUMINANCE, a.offset),) * 3
    if a.lookup is None or a.channel != CHANNEL_RGB:
        return replace(a, scale=(_dot(LUMINANCE, a.scale),) * 3, offset=offset)
    if max(a.scale) - min(a.scale) > 1e-6:
        raise NotAffineError
    return replace(a, channel=CHANNEL_LUMINANCE, offset=offset)


def separate(a: Texture, index: int) -> Texture:
    """One component of a colour, 0 to 2."""
    channel = CHANNEL_R + index if a.channel == CHANNEL_RGB else a.channel
    return replace(a, channel=channel, scale=(a.scale[index],) * 3, offset=(a.offset[index],) * 3)


def combine(parts: tuple[Texture, Texture, Texture]) -> Texture:
    """A colour of three numbers: R, G and B of one lookup each in its place, or one channel in all places."""
    scale, offset = tuple(part.scale[0] for part in parts), tuple(part.offset[0] for part in parts)
    used = [(index, part) for index, part in enumerate(parts) if part.lookup is not None]
    if not used:
        return constant(offset)
    first = used[0][1]
    if any((p.lookup, p.threshold) != (first.lookup, first.threshold) for _, p in used):
        raise NotAffineError
    if all(part.channel == CHANNEL_R + index for index, part in used) and first.threshold is None:
        return replace(first, channel=CHANNEL_RGB, scale=scale, offset=offset)
    if any(part.channel != first.channel for _, part in used):
        raise NotAffineError
    return replace(first, scale=scale, offset=offset)


def less(a: Texture, limit: float) -> Texture:
    """1 where the number a is below the limit, else 0."""
    scale, offset = a.scale[0], a.offset[0]
    if a.lookup is None:
        return constant(float(offset < limit))
    if a.threshold is not None:
        low, high = float(offset < limit), float(scale + offset < limit)
        return _simple(replace(a, scale=(high - low,) * 3, offset=(low,) * 3))
    at = (limit - offset) / scale
    if scale > 0.0:
        return replace(a, scale=(-1.0,) * 3, offset=WHITE, threshold=at)
    return replace(a, scale=WHITE, offset=BLACK, threshold=_above(at))


def greater(a: Texture, limit: float) -> Texture:
    """1 where the number a is above the limit, else 0."""
    return less(affine(a, -1.0, 0.0), -limit)


def clamp(a: Texture, low: float, high: float) -> Texture:
    """Clamped, where that is a constant or changes nothing."""
    if a.lookup is None:
        return constant(tuple(min(max(part, low), high) for part in a.offset))
    least, greatest = a.bounds()
    # A little beyond is rounding.
    if least < low - 1e-6 or greatest > high + 1e-6:
        raise NotAffineError
    return a


def _simple(a: Texture) -> Texture:
    return constant(a.offset) if a.lookup is not None and a.scale == BLACK else a


def _times(a: Color, b: Color) -> Color:
    return _combine(lambda x, y: x * y, a, b)


def _combine(function: Callable[[float, float], float], a: Color, b: Color) -> Color:
    return tuple(map(function, a, b))


def _dot(a: Color, b: Color) -> float:
    return sum(_times(a, b))


def _above(limit: float) -> float:
    """The next number of single precision: "above" as "from there on"."""
    with np.errstate(over='ignore'):
        return float(np.nextafter(np.float32(limit), np.float32(np.inf)))


# ---- Arrays.


def slot_array(textures: Iterable[Texture], uv_layers: tuple[str, ...]) -> NDArray[np.void]:
    """One TEXTURE_SLOT a texture."""
    found = list(textures)
    slots = np.zeros(len(found), TEXTURE_SLOT)
    for slot, texture in zip(slots, found, strict=True):
        lookup = texture.lookup
        assert lookup is not None  # constants have no slot
        slot['mapping_s'], slot['mapping_t'] = lookup.mapping
        slot['scale'], slot['offset'] = texture.scale, texture.offset
        slot['threshold'] = math.nan if texture.threshold is None else texture.threshold
        slot['image'], slot['channel'], slot['coordinates'] = lookup.image, texture.channel, lookup.coordinates
        slot['uv_layer'] = uv_layers.index(lookup.uv_map) if lookup.coordinates == COORDINATES_UV else 0
        slot['interpolation'], slot['extension'] = lookup.interpolation, lookup.extension
        slot['flags'] = TEXTURE_UNASSOCIATE if lookup.unassociate else 0
    return slots
