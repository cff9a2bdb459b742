# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour ramps and curves as look-up tables of 257 entries, as Cycles bakes them.

How tables are read, and what lies outside of a curve, is in the kernels.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..export.buffers import F32

SIZE = 257


@dataclass(frozen=True, slots=True)
class Ramp:
    """table: (257, 4) RGBA. is_constant: steps, which are not to be interpolated."""

    table: F32
    is_constant: bool


@dataclass(frozen=True, slots=True)
class Curves:
    """table: (257, channels) values of inputs from `first` to `last`. extrapolates: straight on outside of them."""

    table: F32
    first: float
    last: float
    extrapolates: bool


_ramps: dict[tuple, Ramp] = {}
_curves: dict[tuple, Curves] = {}
CACHED_MAX = 4096  # tables that are kept between two materials


def ramp(band: bpy.types.ColorRamp) -> Ramp:
    """A colour ramp; without a stop it is black and clear."""
    stops = tuple((stop.position, *stop.color) for stop in band.elements)
    key = (band.interpolation, band.color_mode, band.hue_interpolation, stops)
    found = _ramps.get(key)
    if found is None:
        table = np.zeros((SIZE, 4), np.float32)
        if stops:
            places = [index / (SIZE - 1) for index in range(SIZE)]
            table[:] = [tuple(band.evaluate(place)) for place in places]
        found = _kept(_ramps, key, Ramp(np.nan_to_num(table), band.interpolation == 'CONSTANT'))
    return found


def curves(mapping: bpy.types.CurveMapping, channels: int, is_color: bool) -> Curves:
    """The curves of a node: one, three, or those of three colours and the one for all of them."""
    every = list(mapping.curves)[:channels]
    points = tuple(tuple((*point.location, point.handle_type) for point in curve.points) for curve in every)
    clip = (mapping.use_clip, mapping.clip_min_x, mapping.clip_max_x, mapping.clip_min_y, mapping.clip_max_y)
    key = (channels, mapping.extend, clip, points)
    found = _curves.get(key)
    if found is None:
        found = _kept(_curves, key, _baked(mapping, every, points, is_color))
    return found


def _baked(mapping: bpy.types.CurveMapping, every: list, points: tuple, is_color: bool) -> Curves:
    ends = [(curve[0][0], curve[-1][0]) for curve in points if curve]
    first, last = (min(low for low, _ in ends), max(high for _, high in ends)) if ends else (0.0, 1.0)
    mapping.initialize()
    places = [first + index / (SIZE - 1) * (last - first) for index in range(SIZE)]
    channels = every[:3] if is_color else every
    table = np.zeros((SIZE, len(channels)), np.float32)
    for row, place in zip(table, places, strict=True):
        at = _evaluated(mapping, every[3], place) if is_color else place
        row[:] = [_evaluated(mapping, curve, at) for curve in channels]
    return Curves(np.nan_to_num(table), first, last, mapping.extend == 'EXTRAPOLATED')


def _evaluated(mapping: bpy.types.CurveMapping, curve: bpy.types.CurveMap, place: float) -> float:
    return mapping.evaluate(curve, place) if len(curve.points) else place


def _kept(cache: dict, key: tuple, found: object) -> object:
    if len(cache) >= CACHED_MAX:
        cache.clear()
    cache[key] = found
    return found
