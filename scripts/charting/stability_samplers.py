# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of what draws: the sampler's points, the world's table and the light tree, against what they must add up to.

Integrals are exact; chi-square compares frequencies with the probabilities that a method claims, for seeds that are
fixed: its statistic over what one in a million sound methods exceeds.
"""

from __future__ import annotations

import ctypes
import functools
import math
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from charting.stability import Axis, Map, steps

sys.path.append(str(Path(__file__).resolve().parents[2] / 'tests'))
from native_build import build
from test_area_sampling import pointer
from test_sampler import points as sampler_points

F64 = NDArray[np.float64]
CHI_SQUARE = 'chi-square over its bound'
SURE = 4.753  # standard deviations that one in a million normal numbers exceeds
SEEDS = 8
STEP = np.array([0.37, 0.61])


def maps(count: int) -> list[Map]:
    return [
        *integrals(count),
        *world(count),
        *light_tree(count),
    ]


@functools.cache
def library() -> ctypes.CDLL:
    lib = build('atlas_test', ['tests/native/atlas_test.cpp', 'native/light_tree.cpp'])
    lib.test_light_tree.restype = ctypes.c_double
    return lib


def chi_square(found: F64, expected: F64) -> float:
    """Pearson's statistic over its bound; cells that expect less than 25 are one. By Wilson & Hilferty 1931."""
    order = np.argsort(expected)
    found, expected = found[order], expected[order]
    pool = min(int(np.searchsorted(np.cumsum(expected), 25.0)) + 1, len(expected))
    found = np.append(found[pool:], found[:pool].sum())
    expected = np.append(expected[pool:], max(expected[:pool].sum(), 1e-9))
    freedom = max(len(expected) - 1, 1)
    bound = freedom * (1.0 - 2.0 / (9.0 * freedom) + SURE * math.sqrt(2.0 / (9.0 * freedom))) ** 3
    return float(((found - expected) ** 2 / expected).sum()) / bound


# ---- The sampler


def integrals(count: int) -> list[Map]:
    """What points of a pair make of a smooth integrand, of an edge, and of two pairs together: spread over seeds."""
    most = 16
    powers = np.unique(np.linspace(0, most, count).astype(int))
    x = Axis('samples of a pixel', 2.0**powers, (1.0, 2.0**most))
    y = Axis('pair of dimensions', np.unique(np.append(np.geomspace(1, 1e5, count).astype(int), 255) * 1.0), (1.0, 1e5))
    kinds = ('smooth', 'edge', 'two pairs')
    worst = {kind: np.zeros((len(y.values), len(x.values))) for kind in kinds}
    smooth_truth, edge_truth = 1.0 + (2.0 / np.pi) ** 2, float(STEP.prod())
    deviation = {'smooth': _deviation_smooth(), 'edge': math.sqrt(edge_truth * (1.0 - edge_truth)), 'two pairs': 0.5}
    for j, pair in enumerate(y.values.astype(int)):
        found = {kind: np.zeros((SEEDS, len(x.values))) for kind in kinds}
        for seed in range(SEEDS):
            p, q = (sampler_points(2**most, int(k), bits=most, seed=seed) for k in (pair, pair + 1))
            values = {
                'smooth': 1.0 + np.sin(np.pi * p[:, 0]) * np.sin(np.pi * p[:, 1]) - smooth_truth,
                'edge': ((p < STEP).all(axis=1)) - edge_truth,
                # A plane across the first of both: it is in neither pair's nets.
                'two pairs': (p[:, 0] + q[:, 0] < 1.0) - 0.5,
            }
            for kind, of in values.items():
                found[kind][seed] = np.cumsum(of)[(2**powers) - 1] / 2.0**powers
        for kind, of in found.items():
            # As a share of what independent points leave.
            worst[kind][j] = np.sqrt((of**2).mean(axis=0)) / (deviation[kind] / np.sqrt(2.0**powers))
    told = 'nothing is promised of the first few samples but that they are as good as independent ones'
    return [
        Map(f'Sampler, {kind}', x, y, worst[kind], told, measure='error over that of random points', limit=2.0)
        for kind in kinds
    ]


def _deviation_smooth() -> float:
    """Of 1 + sin(pi x) sin(pi y): sqrt(1/4 - (2/pi)^4)."""
    return math.sqrt(0.25 - (2.0 / math.pi) ** 4)


# ---- The world


def sky(width: int, peak: float) -> NDArray[np.float32]:
    """A horizon brighter than its poles, and one cell so many times as bright as they are."""
    height = width // 2
    latitude = np.linspace(-1.0, 1.0, height)[:, None]
    cells = np.broadcast_to(1.0 - 0.7 * latitude**2, (height, width)).astype(np.float32).copy()
    cells[int(0.8 * height), int(0.3 * width)] = peak
    return np.ascontiguousarray(cells)


def world(count: int) -> list[Map]:
    x = Axis('peak over the rest', steps(1.0, 1e8, count, 1e6), (1.0, 1e6))
    # The largest takes eight million cells, which a coarse map does not wait for.
    widths = 2.0 ** np.unique(np.linspace(2, 12 if count > 9 else 9, count).astype(int))
    y = Axis('cells around', widths, (4.0, 4096.0))
    whole, told_pdf, frequencies = (np.zeros((len(y.values), len(x.values))) for _ in range(3))
    random = np.random.default_rng(3)
    samples = 1 << 17
    u = np.minimum(random.random((samples, 2), np.float32), np.float32(1.0 - 2.0**-24))
    for j, width in enumerate(map(int, widths)):
        height = width // 2
        for i, peak in enumerate(x.values):
            cells = sky(width, float(peak))
            directions, drawn, told = np.zeros((samples, 3), 'f'), np.zeros(samples, 'f'), np.zeros(samples, 'f')
            library().test_world(
                pointer(cells), width, height, pointer(u), ctypes.c_size_t(samples), pointer(directions),
                pointer(drawn), pointer(told),
            )  # fmt: skip
            with np.errstate(all='ignore'):
                told_pdf[j, i] = np.abs(told.astype(np.float64) / drawn - 1.0).mean()
            # The density over the sphere: by the middle of each cell.
            longitude = (0.5 - (np.arange(width) + 0.5) / width) * 2.0 * np.pi
            across = np.cos(np.pi * ((np.arange(height) + 0.5) / height - 0.5))
            middle = np.sin(np.pi * ((np.arange(height) + 0.5) / height - 0.5))
            d = np.stack(
                [
                    across[:, None] * np.cos(longitude),
                    across[:, None] * np.sin(longitude),
                    np.broadcast_to(middle[:, None], (height, width)),
                ],
                -1,
            ).reshape(-1, 3)
            d = np.ascontiguousarray(d, np.float32)
            pdf = np.zeros(len(d), np.float32)
            library().test_world_pdf(pointer(cells), width, height, pointer(d), ctypes.c_size_t(len(d)), pointer(pdf))
            # The pdf falls with 1 / cos of the latitude inside a cell: its integral is by the square's own measure.
            share = pdf.reshape(height, width).astype(np.float64) * across[:, None] * 2.0 * np.pi**2 / (width * height)
            whole[j, i] = abs(share.sum() - 1.0)
            turn = np.floor((0.5 - np.arctan2(directions[:, 1], directions[:, 0]) / (2.0 * np.pi)) * width).astype(int)
            lift = np.arctan2(directions[:, 2], np.hypot(directions[:, 0], directions[:, 1])) / np.pi + 0.5
            row = np.clip(np.floor(lift * height).astype(int), 0, height - 1)
            found = np.bincount(row * width + np.clip(turn, 0, width - 1), minlength=width * height)
            frequencies[j, i] = coarse_chi_square(found.reshape(height, width), share, samples)
    said = 'at a peak of 1e8 the rest of its row has shares below 2^-24, which 24 bits of a number never draw'
    return [
        Map("World's table: density over the sphere", x, y, whole, said),
        Map("World's table: density told to rays", x, y, told_pdf, said, measure='mean relative error'),
        Map("World's table: frequencies", x, y, frequencies, said, measure=CHI_SQUARE, limit=1.0),
    ]


def coarse_chi_square(found: NDArray[np.int64], share: F64, samples: int) -> float:
    """Over at most 32 x 64 cells."""
    height, width = share.shape
    down, across = max(height // 32, 1), max(width // 64, 1)
    blocks = (height // down, down, width // across, across)
    observed, expected = (a.reshape(blocks).sum(axis=(1, 3)).ravel() for a in (found.astype(np.float64), share))
    return chi_square(observed, expected * samples)


# ---- The light tree


def light_tree(count: int) -> list[Map]:
    x = Axis('scale', steps(1e-6, 1e6, count, 1e-4, 1e5), (1e-6, 1e6))
    y = Axis('distance over the extent of the lights', steps(1e-3, 1e5, count), (1e-3, 1e5))
    lights, samples = 200, 20_000
    whole, same, frequencies = (np.zeros((len(y.values), len(x.values))) for _ in range(3))
    for j, away in enumerate(y.values):
        for i, scale in enumerate(x.values):
            p = np.ascontiguousarray(np.array([0.48, -0.6, 0.64]) * away * scale, np.float32)
            chance, found = np.zeros(lights), np.zeros(lights + 1)
            same[j, i] = library().test_light_tree(
                ctypes.c_size_t(lights), ctypes.c_float(scale), pointer(p), ctypes.c_size_t(samples),
                ctypes.c_uint32(7), pointer(chance), pointer(found),
            )  # fmt: skip
            total = chance.sum()
            # Less than one where a child of which too much was hoped has none that shines: nothing is drawn there.
            whole[j, i] = max(total - 1.0, 0.0) + abs(found[-1] / samples - max(1.0 - total, 0.0)) * (
                total > 1.0 - 1e-4
            )
            expected = np.append(chance, max(1.0 - total, 0.0)) * samples
            frequencies[j, i] = chi_square(found, expected)
    said = 'beyond, squares of distances leave the range of a float'
    return [
        Map('Light tree: probabilities add up', x, y, whole, said, measure='above one'),
        Map('Light tree: told when picked and when met', x, y, same, said),
        Map('Light tree: frequencies', x, y, frequencies, said, measure=CHI_SQUARE, limit=1.0),
    ]
