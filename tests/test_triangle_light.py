# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a triangle that shines against the density that they claim, near and far, in double precision."""

from __future__ import annotations

import ctypes
import functools
import math

import numpy as np
import pytest

from chi_square import p_value, sidak
from native_build import build

COUNT = 1 << 16
# Three corners, from the point that it lights.
NEAR = {
    'above': ((-1, -1, 0.5), (1, -1, 0.5), (0, 1, 0.5)),
    'touching': ((-1, -1, 1e-3), (1, -1, 1e-3), (0, 1, 1e-3)),
    'all but touching': ((-1, -1, 1e-5), (1, -1, 1e-5), (0, 1, 1e-5)),
    'all around': ((-50, -40, 0.1), (60, -40, 0.1), (0, 70, 0.1)),
    'at a corner': ((1e-3, 1e-3, 1e-3), (1, 0, 0.2), (0, 1, 0.2)),
    'aside': ((0.2, 0, 0.1), (2.2, 0, 0.1), (0.2, 2, 0.1)),
    'needle': ((-5, 0.1, 0.2), (5, 0.1, 0.2), (5, 0.2, 0.2)),
    'turned': ((-1, -1, 0.2), (1, -0.5, 0.9), (0.3, 1, 0.6)),
    'large': ((-1e4, -1e4, 3e3), (1e4, -1e4, 3e3), (0, 1e4, 3e3)),
    'small': ((-1e-4, -1e-4, 3e-5), (1e-4, -1e-4, 3e-5), (0, 1e-4, 3e-5)),
}
FAR = {
    'far': ((-1, -1, 30), (1, -1, 30), (0, 1, 30)),
    'edge on': ((0.1, -1, 1e-5), (2, 0, 1e-5), (0.1, 1, 1e-5)),
    'in its plane': ((-1, -1, 0), (1, -1, 0), (0, 1, 0)),
}
EACH = pytest.mark.parametrize('name', NEAR | FAR)


@functools.cache
def library() -> ctypes.CDLL:
    made = build('area_test', ['tests/native/area_test.cpp'])
    made.test_triangle.restype = ctypes.c_float
    return made


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def samples(name: str) -> tuple[np.ndarray, np.ndarray, float]:
    """Barycentric coordinates and densities of stratified samples, and the solid angle of the near."""
    side = int(math.sqrt(COUNT))
    cells = np.stack(np.meshgrid(*[np.arange(side)] * 2), -1).reshape(-1, 2)
    u = np.minimum((cells + np.random.default_rng(3).random((COUNT, 2))) / side, 1 - 2**-24).astype(np.float32)
    b, pdf = np.zeros((COUNT, 2), np.float32), np.zeros(COUNT, np.float32)
    corners = np.array((NEAR | FAR)[name], np.float32)
    shown = library().test_triangle(pointer(corners), pointer(u), ctypes.c_size_t(COUNT), pointer(b), pointer(pdf))
    return b.astype(float), pdf.astype(float), shown


def solid_angle(corners: np.ndarray) -> np.ndarray:
    """Of (..., 3, 3) triangles; Van Oosterom & Strackee 1983."""
    a, b, c = np.moveaxis(corners / np.linalg.norm(corners, axis=-1, keepdims=True), -2, 0)
    volume = np.abs(np.sum(a * np.cross(b, c), -1))
    return 2 * np.arctan2(volume, 1 + np.sum(a * b + b * c + c * a, -1))


def parts(name: str, n: int) -> np.ndarray:
    """(n², 3, 3): the triangle in n² like ones, numbered by their row and column as `part_of` does."""
    corners = np.array((NEAR | FAR)[name], float)
    found = []
    for row in range(n):
        for column in range(2 * (n - row) - 1):
            x, down = divmod(column, 2)
            places = [(x + 1, row), (x, row + 1), (x + down, row + down)]
            found.append([corners[0] + (corners[1] - corners[0]) * i / n + (corners[2] - corners[0]) * j / n
                          for i, j in places])  # fmt: skip
    return np.array(found)


def part_of(b: np.ndarray, n: int) -> np.ndarray:
    x, y = np.minimum((b * n).T, n - 1e-9)
    row, column = y.astype(int), x.astype(int)
    down = (x - column) + (y - row) > 1.0
    starts = np.cumsum([0] + [2 * (n - k) - 1 for k in range(n)])
    return np.minimum(starts[row] + 2 * column + down, starts[row + 1] - 1)


@EACH
def test_the_density_is_that_of_the_samples(name: str) -> None:
    """Chi-square over parts of the triangle; from near by the solid angle that each shows."""
    b, _, shown = samples(name)
    n = 6
    assert (shown > 0) == (name in NEAR)
    share = solid_angle(parts(name, n)) / solid_angle(parts(name, n)).sum() if shown else np.full(n * n, 1 / n**2)
    assert (b >= 0).all() and (b.sum(axis=1) <= 1 + 1e-6).all()
    observed = np.bincount(part_of(b, n), minlength=n * n).astype(float)
    # What single precision makes of the smallest parts is no fault of the method.
    kept = share * COUNT > 5
    assert observed[~kept].sum() <= 5 * COUNT * share[~kept].sum() + 20
    # Stratified numbers agree better than chance.
    assert p_value(observed[kept], share[kept] * COUNT) > sidak(1e-3, len(NEAR | FAR))


@pytest.mark.parametrize('name', [name for name in NEAR | FAR if name != 'in its plane'])  # it sends nothing there
def test_samples_bring_what_the_triangle_sends(name: str) -> None:
    """Irradiance of a plane that faces up, by Lambert's formula of a polygon, above the horizon."""
    b, pdf, _ = samples(name)
    corners = np.array((NEAR | FAR)[name], float)
    ways = corners / np.linalg.norm(corners, axis=-1, keepdims=True)
    after = np.roll(ways, -1, axis=0)
    edges = np.cross(ways, after)
    angles = np.arctan2(np.linalg.norm(edges, axis=-1), (ways * after).sum(-1))
    expected = abs((angles * edges[:, 2] / np.linalg.norm(edges, axis=-1)).sum()) / 2
    points = corners[0] + b[:, :1] * (corners[1] - corners[0]) + b[:, 1:] * (corners[2] - corners[0])
    cosine = points[:, 2] / np.linalg.norm(points, axis=1)
    brought = cosine / pdf
    assert brought.mean() == pytest.approx(expected, rel=2e-3, abs=3 * brought.std() / math.sqrt(COUNT))


@pytest.mark.parametrize('name', NEAR)
def test_the_solid_angle_is_right(name: str) -> None:
    _, _, shown = samples(name)
    assert shown == pytest.approx(float(solid_angle(np.array(NEAR[name], float))), rel=2e-4)
