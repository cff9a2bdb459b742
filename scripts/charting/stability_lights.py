# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of light samples: cones, spreads, sizes and falloffs, from the records that the native module makes of lamps.

Samples are drawn by the kernels from the same random numbers, and with the same formulas in double precision. That they
follow their density is test_light_sampling.py's and test_area_sampling.py's.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from charting.stability import Axis, Map, relative, steps

sys.path.append(str(Path(__file__).resolve().parents[2] / 'tests'))
import kernel_source as kernels
from test_area_sampling import library, pointer

F64 = NDArray[np.float64]
NUMBERS = 64  # samples of a light; the worst of them counts
TILTED = np.array([0.48, -0.6, 0.64])  # where lights lie: no axis of the world


def maps(count: int) -> list[Map]:
    return [
        *spot_edges(count),
        *(shaped_edge(kind, count) for kind in ('LINEAR', 'SQUARED')),
        ranged(count),
        polynomial(count),
        sun(count),
        ball(count, disk=False),
        ball(count, disk=True),
        area_size(count),
        area_spread(count),
    ]


def single(values: F64 | float) -> F64:
    return np.asarray(values, np.float32).astype(np.float64)


def unit(v: F64) -> F64:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def frame(axis: F64) -> F64:
    """Rows: two vectors across, and the axis; in single precision."""
    x = unit(np.cross((0.0, 1.0, 0.0), axis))
    return single(np.stack([x, np.cross(axis, x), axis]))


def record(**members: Any) -> NDArray[Any]:
    light = np.zeros(1, kernels.dtype_of('Light'))
    for name, value in members.items():
        light[name] = kernels.constants()[value] if isinstance(value, str) else value
    light['radiance'] = 1.0
    return light


def numbers() -> NDArray[np.float32]:
    """(NUMBERS, 2) in [0, 1), stratified, the corners among them."""
    side = int(NUMBERS**0.5)
    cells = np.stack(np.meshgrid(*[np.arange(side)] * 2), -1).reshape(-1, 2)
    u = ((cells + np.random.default_rng(5).random(cells.shape)) / side).astype(np.float32)
    u[0], u[-1] = 0.0, 1.0 - 2.0**-24
    return u


def sampled(light: NDArray[Any], points: F64, u: NDArray[np.float32]) -> NDArray[Any]:
    """A LightSample for each point and pair of numbers."""
    p = np.ascontiguousarray(points, np.float32)
    found = np.zeros(len(p), kernels.dtype_of('LightSample'))
    library().test_samples_at(pointer(light), pointer(p), pointer(u), ctypes.c_size_t(len(p)), pointer(found))
    return found


def disk_from_square(u: F64) -> F64:
    """Shirley & Chiu 1997, as kernels/sampling.h has it."""
    a, b = 2.0 * u[:, 0] - 1.0, 2.0 * u[:, 1] - 1.0
    wide = np.abs(a) > np.abs(b)
    r, q = np.where(wide, a, b), np.where(wide, b, a)
    phi = 0.25 * np.pi * q / np.where(r == 0.0, 1.0, r)
    c, s = r * np.cos(phi), r * np.sin(phi)
    return np.stack([np.where(wide, c, s), np.where(wide, s, c)], -1)


# ---- Edges of spots


def spot_points(angles: F64, axes: F64) -> F64:
    """Points a metre from a spot at the origin, so far from its axis (rows of `axes`: x, y, away from its beam)."""
    return single(np.stack([np.sin(angles), 0.0 * angles, -np.cos(angles)], -1) @ axes)


def spot_error(size: float, blend: float, places: F64) -> F64:
    """Of a spot's brightness at `places`, parts of the half cone, as a share of that in the middle of its beam."""
    axes = frame(-TILTED)
    half = 0.5 * float(np.float32(size))
    ramp = 2.0 * np.sin(0.5 * half) ** 2 * float(np.float32(blend))
    light = record(type='LIGHT_SPOT', axis=-axes[2], local_x=axes[0], local_y=axes[1], local_z=axes[2])
    set_cone(light, half, ramp)
    points = spot_points(places * half, axes)
    found = sampled(light, points, np.zeros((len(points), 2), np.float32))
    d2 = (points**2).sum(axis=1)
    # The direction is that of the rounded point; 1 - cos of its angle without a cancellation.
    local = unit(-points) @ np.linalg.inv(axes)
    local = unit(local)
    versine = 0.5 * ((local - (0.0, 0.0, 1.0)) ** 2).sum(axis=1)
    t = np.clip((2.0 * np.sin(0.5 * half) ** 2 - versine) / ramp, 0.0, 1.0)
    return np.abs(found['weight'][:, 0].astype(np.float64) * d2 - t * t * (3.0 - 2.0 * t))


def set_cone(light: NDArray[Any], half: float, ramp: float) -> None:
    """As native/scene.cpp does."""
    light['spot_versine'] = 2.0 * np.sin(0.5 * half) ** 2
    light['spot_scale'] = 1.0 / max(ramp, 1e-9)


def spot_edges(count: int) -> list[Map]:
    places = np.linspace(0.0, 1.2, 2 * count + 1)
    blends = Axis('blend', steps(1e-6, 1.0, count), (1e-2, 1.0))
    size = np.radians(45.0)
    error = np.stack([spot_error(size, blend, places) for blend in blends.values], axis=1)
    y = Axis('place in the cone, its edge at 1', places, (0.0, 1.2), log=False)
    told = 'an edge narrower than a hundredth of the cone is a step of few values: rounding of the cosine moves it'
    edge = Map('Spot of 45 degrees', blends, y, error, told, measure='error over the middle of the beam')
    sizes = Axis('full angle of the spot (degrees)', steps(1e-2, 180.0, count, 1.0), (1.0, 180.0))
    worst = [[spot_error(np.radians(s), b, places).max() for s in sizes.values] for b in blends.values]
    told = 'below 1 degree, the least that Blender offers, 1 - cos of the cone has few digits; blends as beside'
    cone = Map(
        'Spot, worst of its cone', sizes, Axis('blend', blends.values, (1e-2, 1.0)), np.array(worst), told,
        measure='error over the middle of the beam',
    )  # fmt: skip
    return [edge, cone]


def shaped(light: NDArray[Any], shape: NDArray[Any], points: F64) -> F64:
    p = np.ascontiguousarray(points, np.float32)
    wi = np.ascontiguousarray(unit(light['position'] - points), np.float32)
    out = np.zeros(len(p), np.float32)
    count = ctypes.c_size_t(len(p))
    library().test_shapes(pointer(shape), pointer(light), pointer(p), pointer(wi), count, pointer(out))
    return out.astype(np.float64)


def shape_record(**members: Any) -> NDArray[Any]:
    shape = np.zeros(1, kernels.dtype_of('LightShape'))
    for name, value in members.items():
        shape[name] = kernels.constants()[value] if isinstance(value, str) else value
    return shape


def shaped_edge(kind: str, count: int) -> Map:
    """The edges of the founding systems, from half the outer angle to all of it."""
    x = Axis('outer angle (degrees)', steps(1e-2, 90.0, count, 1.0), (0.1, 90.0))
    y = Axis('place in the cone, its edge at 1', np.linspace(0.0, 1.2, count), (0.0, 1.2), log=False)
    axes = frame(-TILTED)
    light = record(type='LIGHT_SPOT', axis=-axes[2], local_x=axes[0], local_y=axes[1], local_z=axes[2])
    error = np.zeros((len(y.values), len(x.values)))
    linear = kind == 'LINEAR'
    for i, degrees in enumerate(x.values):
        outer = np.radians(degrees)
        ends = [
            outer if linear else 2.0 * np.sin(0.5 * outer) ** 2,
            0.5 * outer if linear else 2.0 * np.sin(0.25 * outer) ** 2,
        ]
        shape = shape_record(edge=f'SPOT_EDGE_{kind}', edge_end=ends[0], edge_scale=1.0 / (ends[0] - ends[1]))
        points = spot_points(y.values * outer, axes)
        local = unit(unit(-points) @ np.linalg.inv(axes))
        versine = 0.5 * ((local - (0.0, 0.0, 1.0)) ** 2).sum(axis=1)
        at = 2.0 * np.arcsin(np.sqrt(np.clip(0.5 * versine, 0.0, 1.0))) if linear else versine
        ramp = np.clip((ends[0] - at) / (ends[0] - ends[1]), 0.0, 1.0)
        truth = np.where(versine < 1.0, ramp if linear else ramp**2, 0.0)
        error[:, i] = np.abs(shaped(light, shape, points) - truth)
    told = 'of a cone of seconds of arc a direction has no digits left'
    return Map(f'Spot edge {kind}', x, y, error, told, measure='error over the middle of the beam')


# ---- Falloffs


def ranged(count: int) -> Map:
    """(1 - (d / range)^4), which Blender's 1 / d^2 is multiplied by."""
    x = Axis('1 - distance / range', steps(1e-6, 0.999, count, 2e-4), (2e-4, 0.999))
    y = Axis('range', steps(1e-6, 1e6, count, 1e-4, 1e5), (1e-4, 1e5))
    error = np.zeros((len(y.values), len(x.values)))
    for j, reach in enumerate(y.values):
        points = single((1.0 - x.values)[:, None] * reach * TILTED)
        light, shape = record(type='LIGHT_POINT'), shape_record(falloff='FALLOFF_RANGED', inverse_range=1.0 / reach)
        away = np.linalg.norm(points, axis=1) / reach
        truth = (1.0 - away) * (1.0 + away) * (1.0 + away**2)
        found = shaped(light, shape, points)
        # Points that rounding puts beyond the range see nothing in either.
        error[j] = np.where(truth > 0.0, relative(found, np.maximum(truth, 1e-300)), np.nan)
    told = 'where the light ends, at its range: a distance has 24 bits, of which what is left to the end takes few'
    return Map('Falloff RANGED', x, y, error, told)


def polynomial(count: int) -> Map:
    """d^2 / (c0 + c1 d + c2 d^2), over the distance and over c1."""
    x = Axis('distance', steps(1e-6, 1e6, count, 1e-4, 1e5), (1e-4, 1e5))
    y = Axis('factor c1 beside c0 = c2 = 1', steps(1e-6, 1e6, count), (1e-6, 1e6))
    error = np.zeros((len(y.values), len(x.values)))
    points = single(x.values[:, None] * TILTED)
    d = np.linalg.norm(points, axis=1)
    for j, c1 in enumerate(single(y.values)):
        shape = shape_record(falloff='FALLOFF_POLYNOMIAL', c0=1.0, c1=c1, c2=1.0)
        error[j] = relative(shaped(record(type='LIGHT_POINT'), shape, points), d**2 / (1.0 + d * (c1 + d)))
    return Map('Falloff POLYNOMIAL', x, y, error, 'nothing fails')


# ---- Lights of size


def sun(count: int) -> Map:
    """Irradiance of single samples on a floor; where the sun stands below its horizon they bring nothing."""
    x = Axis('angle of the sun (radians)', np.unique(np.append(steps(1e-6, np.pi, count), 0.00918)), (1e-6, np.pi))
    y = Axis('degrees above the horizon', steps(1e-2, 90.0, count, 0.1), (0.1, 90.0))
    u = numbers()
    error = np.zeros((len(y.values), len(x.values)))
    for i, angle in enumerate(x.values):
        for j, height in enumerate(np.radians(y.values)):
            towards = single(np.array([np.cos(height), 0.0, np.sin(height)]))
            cap = 2.0 * np.sin(0.25 * angle) ** 2
            light = record(type='LIGHT_SUN', axis=-towards, radius=cap)
            found = sampled(light, np.zeros((len(u), 3)), u)
            wi = found['wi'].astype(np.float64)
            disk = disk_from_square(u.astype(np.float64))
            z = cap * (disk**2).sum(axis=1)
            s = np.sqrt(np.maximum(cap * (2.0 - z), 0.0))
            t, b = basis(towards)
            truth = disk[:, :1] * s[:, None] * t + disk[:, 1:] * s[:, None] * b + (1.0 - z)[:, None] * towards
            whole = 2.0 * np.pi * cap
            brought = found['weight'][:, 0].astype(np.float64) * np.maximum(wi[:, 2], 0.0)
            # All samples together: one alone may graze the floor.
            expected = (whole * np.maximum(truth[:, 2], 0.0)).sum()
            error[j, i] = np.abs(brought - whole * np.maximum(truth[:, 2], 0.0)).sum() / expected
    told = "next to the horizon the rounding of the sun's own direction, 6e-8, is a share of its height"
    return Map('Sun, light on a floor', x, y, error, told)


def basis(n: F64) -> tuple[F64, F64]:
    """Duff et al. 2017, as kernels/math.h has it."""
    sign = 1.0 if n[2] >= -0.0617 else -1.0
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    return np.array([1.0 + sign * n[0] ** 2 * a, sign * b, -sign * n[0]]), np.array([b, sign + n[1] ** 2 * a, -n[1]])


def ball(count: int, disk: bool) -> Map:
    """What samples of a light of size bring: their weight, which is its solid angle."""
    x = Axis('distance over radius', steps(1e-3, 1e6, count, 1.5, 1e5), (1e-3 if disk else 1.001, 1e5))
    y = Axis('radius', steps(1e-6, 1e3, count, 1e-4), (1e-4, 1e3))
    u = numbers()
    error = np.zeros((len(y.values), len(x.values)))
    for j, radius in enumerate(single(y.values)):
        light = record(type='LIGHT_POINT', radius=radius, flags='LIGHT_SOFT_FALLOFF' if disk else 0)
        for i, far in enumerate(x.values):
            if not disk and far <= 1.0:
                error[j, i] = np.nan  # inside: all directions
                continue
            p = single(-far * radius * TILTED)
            found = sampled(light, np.tile(p, (len(u), 1)), u)
            d2 = float(p @ p)
            sine2 = radius**2 / (d2 + (radius**2 if disk else 0.0))
            truth = 2.0 * np.pi * sine2 / (1.0 + np.sqrt(max(1.0 - sine2, 0.0)))
            error[j, i] = relative(found['weight'][:, 0], truth).max()
    told = (
        'a radius and a distance whose square is below 1e-20 are held there' if disk else 'touching, 1 - sin² cancels'
    )
    return Map('Point light as a disk' if disk else 'Point light as a ball', x, y, error, told)


def area_record(u: float, v: float, spread: float) -> NDArray[Any]:
    """A light at the origin that shines along -z."""
    half, wide = 0.5 * spread, spread >= np.pi - 2e-6
    rest = np.tan(half) - half if half > 1e-3 else half**3 / 3.0
    return record(
        type='LIGHT_AREA', axis=(0, 0, -1), local_x=(1, 0, 0), local_y=(0, 1, 0), half_u=u, half_v=v,
        radius=np.hypot(u, v), tan_spread=1e18 if wide else np.tan(half), spread_scale=1e-18 if wide else 1.0 / rest,
    )  # fmt: skip


def solid_angle(u: float, v: float, p: F64) -> float:
    """Of a rectangle of these half widths about the origin, from p below it, in extended precision.

    Two triangles, each by Van Oosterom & Strackee 1983: nothing cancels, however flat it is seen.
    """
    long = np.longdouble
    a, b = np.array([-u, u], long) - long(p[0]), np.array([-v, v], long) - long(p[1])
    h = long(-p[2])
    r = [np.array([a[i], b[j], h], long) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    total = long(0.0)
    for one, two, three in ((r[0], r[1], r[2]), (r[0], r[2], r[3])):
        x, y, z = (np.sqrt((side**2).sum()) for side in (one, two, three))
        volume = (a[1] - a[0]) * (b[1] - b[0]) * h
        denominator = x * y * z + (one @ two) * z + (one @ three) * y + (two @ three) * x
        total += 2.0 * np.arctan2(volume, denominator)
    return float(total)


def area_size(count: int) -> Map:
    """The solid angle by which samples of a rectangle are weighted; its planar samples by their mean."""
    x = Axis('width over distance', steps(1e-6, 1e3, count, 2e-4), (2e-4, 1e3))
    y = Axis('degrees above the plane of the light', steps(1e-2, 90.0, count, 0.1), (0.1, 90.0))
    error = np.zeros((len(y.values), len(x.values)))
    u = numbers()
    for i, width in enumerate(single(x.values)):
        light = area_record(0.5 * width, 0.25 * width, np.pi)
        for j, height in enumerate(np.radians(y.values)):
            p = single(np.array([np.cos(height), 0.0, -np.sin(height)]))
            found = sampled(light, np.tile(p, (len(u), 1)), u)
            lit = found['pdf'] > 0.0
            if not lit.any():
                error[j, i] = np.inf
                continue
            weight = found['weight'][lit][:, 0].astype(np.float64)
            d = found['distance'][lit].astype(np.float64)
            curved = 16.0 * 1.25 * width**2 >= nearest2(0.5 * width, 0.25 * width, p)
            if curved:
                error[j, i] = relative(weight, solid_angle(0.5 * width, 0.25 * width, p)).max()
            else:
                wi = found['wi'][lit].astype(np.float64)
                at = p + wi * d[:, None]
                at[:, 2] = 0.0
                exact = -p[2] * 0.5 * width**2 / ((at - p) ** 2).sum(axis=1) ** 1.5
                error[j, i] = relative(weight, exact).max()
    told = 'of a light narrower than 1e-4 of its distance the width is a difference of two coordinates'
    return Map('Area light: solid angle', x, y, error, told)


def nearest2(u: float, v: float, p: F64) -> float:
    a, b = max(abs(p[0]) - u, 0.0), max(abs(p[1]) - v, 0.0)
    return float(a * a + b * b + p[2] ** 2)


def area_spread(count: int) -> Map:
    """Radiance along rays, by their angle to the light's axis."""
    x = Axis('spread (radians)', steps(1e-6, np.pi, count, 1e-3), (1e-3, np.pi))
    y = Axis('angle of the ray over half the spread', np.linspace(0.0, 0.98, count), (0.0, 0.9), log=False)
    error = np.zeros((len(y.values), len(x.values)))
    for i, spread in enumerate(single(x.values)):
        light = area_record(0.5, 0.5, float(spread))
        angle = y.values * 0.5 * spread
        d = np.ascontiguousarray(np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], -1), np.float32)
        # So near below the light's middle that all rays meet it; the ray is told by its rounded direction.
        p = np.array([0.0, 0.0, -0.01], np.float32)
        radiance, pdf = np.zeros((len(d), 3), np.float32), np.zeros(len(d), np.float32)
        size = ctypes.c_size_t(len(d))
        library().test_rays(pointer(light), pointer(p), pointer(d), size, pointer(radiance), pointer(pdf))
        exact = d.astype(np.float64)
        half = 0.5 * float(spread)
        tangent = np.hypot(exact[:, 0], exact[:, 1]) / exact[:, 2]
        rest = np.tan(half) - half if half > 1e-3 else half**3 / 3.0 + 2.0 * half**5 / 15.0
        truth = np.where(spread >= np.pi - 2e-6, 1.0, (np.tan(half) - tangent) / rest)
        error[:, i] = relative(radiance[:, 0], truth)
    told = 'next to the edge of the spread, where the light goes out; a spread of half a right angle less 1e-6 is open'
    return Map('Area light: spread', x, y, error, told)
