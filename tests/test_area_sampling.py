# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of area lights against the density that they claim, and against integrals over the light in double precision.

Near, far, from the side, of long and wide lights, with and without a spread. Pictures are test_area_lights.py's.
"""

from __future__ import annotations

import ctypes
import functools
import math
from dataclasses import dataclass

import numpy as np
import pytest

import kernel_source as kernels
from chi_square import p_value, sidak
from native_build import build

COUNT = 1 << 16


@dataclass(frozen=True)
class Case:
    """A light of half widths u and v that shines down from the origin, seen from (x, y, -h)."""

    u: float
    v: float
    x: float
    y: float
    h: float
    spread: float = math.pi
    ellipse: bool = False


CASES = {
    'square, above': Case(0.5, 0.5, 0, 0, 2),
    'square, aside': Case(0.5, 0.5, 2, 1, 0.5),
    'square, touching': Case(0.5, 0.5, 0.1, -0.2, 0.01),
    'square, at its corner': Case(0.5, 0.5, 0.499, 0.499, 0.001),
    'square, flat': Case(0.5, 0.5, 3, 0, 0.01),
    'square, far': Case(0.5, 0.5, 10, 4, 50),
    'tube': Case(5, 0.01, 3, 2, 1),
    'tube, flat': Case(5, 0.01, 7, 1, 0.1),
    'huge': Case(1e4, 1e4, 0, 0, 1),
    'square, spread': Case(0.5, 0.25, 0.2, 0.1, 1, 1.0),
    'square, narrow': Case(0.5, 0.25, 0.2, 0.1, 1, 0.05),
    'square, spread and far': Case(0.5, 0.25, 1, 1, 20, 1.5),
    'disk, touching': Case(0.5, 0.5, 0, 0, 0.02, ellipse=True),
    'disk, beside': Case(0.5, 0.5, 0.7, 0.7, 0.02, ellipse=True),
    'ellipse': Case(0.5, 0.25, 1, 0.3, 0.5, ellipse=True),
    'ellipse, far': Case(0.5, 0.25, 0.2, 0.1, 5, ellipse=True),
    'ellipse, spread': Case(0.5, 0.25, 0.2, 0.1, 1, 1.0, ellipse=True),
}
EACH = pytest.mark.parametrize('name', CASES)


@functools.cache
def library() -> ctypes.CDLL:
    return build('area_test', ['tests/native/area_test.cpp'])


def record(case: Case) -> np.ndarray:
    light = np.zeros(1, kernels.dtype_of('Light'))
    known = kernels.constants()
    light['type'] = known['LIGHT_AREA']
    light['flags'] = known['LIGHT_ELLIPSE'] if case.ellipse else 0
    light['axis'], light['local_x'], light['local_y'] = (0, 0, -1), (1, 0, 0), (0, 1, 0)
    light['half_u'], light['half_v'], light['radius'] = case.u, case.v, math.hypot(case.u, case.v)
    light['radiance'] = 1.0
    half = case.spread / 2
    open_wide = case.spread == math.pi
    light['tan_spread'] = 1e18 if open_wide else math.tan(half)
    light['spread_scale'] = 1e-18 if open_wide else 1.0 / (math.tan(half) - half)
    return light


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def place(case: Case) -> np.ndarray:
    return np.array((case.x, case.y, -case.h), np.float32)


def samples(case: Case) -> np.ndarray:
    """COUNT samples, of stratified numbers."""
    side = int(math.sqrt(COUNT))
    rng = np.random.default_rng(7)
    u = ((np.stack(np.meshgrid(*[np.arange(side)] * 2), -1).reshape(-1, 2) + rng.random((COUNT, 2))) / side).astype('f')
    u = np.minimum(u, np.float32(1 - 2**-24))
    found = np.zeros(COUNT, kernels.dtype_of('LightSample'))
    library().test_samples(
        pointer(record(case)), pointer(place(case)), pointer(u), ctypes.c_size_t(COUNT), pointer(found)
    )
    return found


def rays(case: Case, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    d = np.ascontiguousarray(d, np.float32)
    radiance, pdf = np.zeros((len(d), 3), np.float32), np.zeros(len(d), np.float32)
    library().test_rays(
        pointer(record(case)),
        pointer(place(case)),
        pointer(d),
        ctypes.c_size_t(len(d)),
        pointer(radiance),
        pointer(pdf),
    )
    return radiance[:, 0].astype(np.float64), pdf.astype(np.float64)


def grid(case: Case, cells: int, inner: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions to cells² × inner² points of the light, more where it is near; and the solid angle of each."""
    axes = []
    for half, foot in ((case.u, case.x), (case.v, case.y)):
        ends = np.arcsinh((np.array((-half, half)) - foot) / case.h)
        t = ends[0] + (ends[1] - ends[0]) * (np.arange(cells * inner) + 0.5) / (cells * inner)
        axes.append((case.h * np.sinh(t), case.h * np.cosh(t) * (ends[1] - ends[0]) / (cells * inner)))
    (a, da), (b, db) = axes
    a, b = np.meshgrid(a, b, indexing='ij')
    d = np.sqrt(a * a + b * b + case.h**2)
    return np.stack([a, b, np.full_like(a, case.h)], -1) / d[..., None], da[:, None] * db * case.h / d**3


@EACH
def test_samples_bring_what_the_light_sends(name: str) -> None:
    """The irradiance of a plane that faces the light, and the mean of its samples."""
    case = CASES[name]
    d, solid = grid(case, 1, 500)
    radiance, _ = rays(case, d.reshape(-1, 3))
    expected = (radiance * (solid * d[..., 2]).ravel()).sum()
    found = samples(case)
    brought = found['weight'][:, 0].astype(np.float64) * found['wi'][:, 2]
    noise = brought.std() / math.sqrt(COUNT)  # more than of stratified numbers
    # Beside noise: edges of the grid, and cuts of a light seen edge on.
    assert brought.mean() == pytest.approx(expected, rel=5e-3, abs=4 * noise)


@pytest.mark.every(4)
@EACH
def test_samples_have_the_density_that_rays_are_told(name: str) -> None:
    case = CASES[name]
    found = samples(case)
    lit = found['pdf'] > 0
    radiance, pdf = rays(case, found['wi'][lit])
    seen = pdf > 0  # on the very edge a ray may miss
    assert seen.mean() > 0.99 or case.spread < math.pi
    # Edge on, the distance of a ray has few digits.
    assert pdf[seen] == pytest.approx(found['pdf'][lit][seen].astype(np.float64), rel=2e-3)
    both = seen & (radiance > 1e-3)
    weight = found['weight'][lit][:, 0].astype(np.float64)
    assert weight[both] * pdf[both] == pytest.approx(radiance[both], rel=1e-2)


@EACH
def test_the_density_is_that_of_the_samples(name: str) -> None:
    """Chi-square over cells of the light."""
    case = CASES[name]
    cells, inner = 8, 24 if case.spread > 0.1 else 96
    d, solid = grid(case, cells, inner)
    _, pdf = rays(case, d.reshape(-1, 3))
    share = (pdf * solid.ravel()).reshape(cells, inner, cells, inner).sum(axis=(1, 3)).ravel()
    found = samples(case)
    wi = found['wi'][found['weight'][:, 0] > 0].astype(np.float64)
    place_of = []
    for axis, half, foot in ((0, case.u, case.x), (1, case.v, case.y)):
        ends = np.arcsinh((np.array((-half, half)) - foot) / case.h)
        t = (np.arcsinh(wi[:, axis] / wi[:, 2]) - ends[0]) / (ends[1] - ends[0])
        place_of.append(np.clip((t * cells).astype(int), 0, cells - 1))
    observed = np.bincount(place_of[0] * cells + place_of[1], minlength=cells * cells).astype(float)
    if case.ellipse or case.spread < math.pi:
        # Cells on the edge are known to the fineness of the grid.
        assert observed / COUNT == pytest.approx(share, abs=4e-3)
    else:
        # Stratified numbers agree better than chance.
        assert p_value(observed, share * COUNT) > sidak(1e-3, len(CASES))


@EACH
def test_nothing_is_sent_to_what_lies_behind(name: str) -> None:
    case = CASES[name]
    behind = Case(case.u, case.v, case.x, case.y, -case.h, case.spread, case.ellipse)
    found = samples(behind)
    assert not found['weight'].any() and not found['pdf'].any() and np.isfinite(found['wi']).all()
    toward = np.array([(-case.x, -case.y, -case.h)])
    assert not rays(behind, toward / np.linalg.norm(toward))[1].any()
