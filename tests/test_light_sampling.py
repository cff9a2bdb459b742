# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of point and sun lights of size: Pearson's chi-square against the density that rays are told.

Area lights are test_area_sampling.py's, whose library this uses.
"""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass

import numpy as np
import pytest

import kernel_source as kernels
from chi_square import p_value, sidak
from test_area_sampling import library, pointer

COUNT, CELLS, FINE = 200_000, (16, 24), 8
NORMAL = np.array([0.0, 0.0, 1.0])  # what the library tells the kernels


@dataclass(frozen=True)
class Case:
    """A light along `towards`. distance 0: a sun of this angle; else a ball, or a disk that faces the point."""

    towards: tuple[float, float, float]
    distance: float = 0.0
    radius: float = 0.0
    angle: float = 0.0
    disk: bool = False


CASES = {
    'sun, 0.5 degrees': Case((0.3, -0.4, 0.8), angle=math.radians(0.526)),
    'sun, 10 seconds': Case((0.0, 0.0, 1.0), angle=math.radians(10 / 3600)),
    'sun, 60 degrees': Case((-0.8, 0.1, 0.6), angle=math.radians(60)),
    'sun, half the sky': Case((0.0, 0.0, 1.0), angle=math.pi),
    'ball, far': Case((0.5, 0.1, 0.9), 100.0, 0.1),
    'ball, very far': Case((0.5, 0.1, 0.9), 1e3, 0.1),  # a direction is rounded by 6e-8: at 1e5, 0.8 % of rays miss
    'ball, near': Case((0.0, 0.6, 0.8), 1.5, 1.0),
    'ball, touching': Case((0.0, 0.0, 1.0), 1.001, 1.0),
    'ball around the point': Case((0.0, 0.0, 1.0), 0.5, 1.0),
    'disk': Case((0.3, 0.3, 0.9), 3.0, 1.0, disk=True),
    'disk, wide': Case((0.0, 0.0, 1.0), 0.5, 1.0, disk=True),
}


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def record(case: Case) -> np.ndarray:
    light, known = np.zeros(1, kernels.dtype_of('Light')), kernels.constants()
    towards = unit(np.array(case.towards))
    light['radiance'] = 1.0
    if case.distance == 0.0:
        light['type'], light['axis'] = known['LIGHT_SUN'], -towards
        light['radius'] = 2.0 * math.sin(case.angle / 4.0) ** 2  # 1 - cos(angle / 2)
    else:
        light['type'], light['position'] = known['LIGHT_POINT'], case.distance * towards
        light['radius'] = case.radius
        light['flags'] = known['LIGHT_SOFT_FALLOFF'] if case.disk else 0
    return light


def cap(case: Case) -> tuple[np.ndarray, float]:
    """Axis and height, 1 - cos, of the cone that holds the light."""
    towards = unit(np.array(case.towards))
    if case.distance == 0.0:
        return towards, 2.0 * math.sin(case.angle / 4.0) ** 2
    if case.disk:
        return towards, 1.0 - 1.0 / math.hypot(1.0, case.radius / case.distance)
    if case.distance <= case.radius:
        return NORMAL, 1.0
    sine2 = (case.radius / case.distance) ** 2
    return towards, sine2 / (1.0 + math.sqrt(1.0 - sine2))


def frame(axis: np.ndarray) -> np.ndarray:
    x = unit(np.cross((0.0, 1.0, 0.0) if abs(axis[1]) < 0.9 else (1.0, 0.0, 0.0), axis))
    return np.stack([x, np.cross(axis, x), axis])


@pytest.mark.parametrize('name', CASES)
def test_samples_follow_the_density(name: str) -> None:
    case, point = CASES[name], np.zeros(3, np.float32)
    axis, height = cap(case)
    light, basis = record(case), frame(axis)
    u = np.minimum(np.random.default_rng(3).random((COUNT, 2), np.float32), np.float32(1 - 2**-24))
    found = np.zeros(COUNT, kernels.dtype_of('LightSample'))
    library().test_samples(pointer(light), pointer(point), pointer(u), ctypes.c_size_t(COUNT), pointer(found))
    assert (found['pdf'] > 0).all() and np.isfinite(found['weight']).all()

    # Cells of equal solid angle about the axis; a narrow cone's height is told by the sine, which has the digits.
    local = found['wi'].astype(float) @ basis.T
    sine2 = np.minimum(local[:, 0] ** 2 + local[:, 1] ** 2, 1.0)
    lift = np.where(local[:, 2] > 0.5, sine2 / (1.0 + np.sqrt(1.0 - sine2)), 1.0 - local[:, 2])
    turn = np.arctan2(local[:, 1], local[:, 0]) % (2.0 * np.pi)
    observed = np.histogram2d(np.minimum(lift / height, 1.0), turn, CELLS, [(0, 1), (0, 2 * np.pi)])[0]

    h, phi = ((np.arange(k * FINE) + 0.5) / (k * FINE) for k in CELLS)
    h, phi = (grid.ravel() for grid in np.meshgrid(height * h, 2.0 * np.pi * phi, indexing='ij'))
    sine = np.sqrt(h * (2.0 - h))
    towards = np.stack([sine * np.cos(phi), sine * np.sin(phi), 1.0 - h], -1) @ basis
    towards = np.ascontiguousarray(towards, np.float32)
    radiance, pdf = np.zeros((len(towards), 3), np.float32), np.zeros(len(towards), np.float32)
    count = ctypes.c_size_t(len(towards))
    library().test_rays(pointer(light), pointer(point), pointer(towards), count, pointer(radiance), pointer(pdf))
    mass = pdf.astype(float) * 2.0 * np.pi * height / len(towards)
    expected = mass.reshape(CELLS[0], FINE, CELLS[1], FINE).sum(axis=(1, 3)) * COUNT

    # A direction is rounded by 6e-8: of the narrowest cones the outermost rays miss.
    assert expected.sum() == pytest.approx(COUNT, rel=5e-3)
    assert p_value(observed.ravel(), expected.ravel()) > sidak(0.01, len(CASES))
