# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces as arrays: wood, plaster, cloth, tiles, copper, iron, a leaf, drawn with NumPy from fixed seeds.

All but the leaf repeat without a seam. How they become Blender's images and nodes is told in textures.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
SIZE = 512  # pixels on a side


@dataclass(frozen=True, slots=True)
class Surface:
    """Maps of one square piece of a surface, row 0 at the bottom; None where one value serves for all of it.

    albedo:    (SIZE, SIZE, 3) scene-linear.
    roughness, metallic, alpha: (SIZE, SIZE), 0 to 1.
    height:    (SIZE, SIZE), in units of the side of the square.
    """

    albedo: F64
    roughness: F64
    metallic: F64 | None = None
    height: F64 | None = None
    alpha: F64 | None = None

    def normals(self) -> F64:
        """(SIZE, SIZE, 3) unit normals of the height field in tangent space, +Y along v."""
        across = (np.roll(self.height, -1, axis=1) - np.roll(self.height, 1, axis=1)) * (SIZE / 2)
        along = (np.roll(self.height, -1, axis=0) - np.roll(self.height, 1, axis=0)) * (SIZE / 2)
        normal = np.stack((-across, -along, np.ones_like(across)), axis=-1)
        return normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def plane() -> tuple[F64, F64]:
    """u and v of each pixel's centre."""
    centres = (np.arange(SIZE) + 0.5) / SIZE
    u, v = np.meshgrid(centres, centres)
    return u, v


def smooth(x: F64) -> F64:
    """Smoothstep from 0 to 1."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def blend(share: F64, first: Sequence[float], second: Sequence[float]) -> F64:
    """From the first colour (share 0) to the second (share 1)."""
    return np.asarray(first) + share[..., None] * (np.asarray(second) - np.asarray(first))


def joining(number: int) -> F64:
    """(SIZE, number) weights that join values smoothly along an axis, the last with the first."""
    place = (np.arange(SIZE) + 0.5) / SIZE * number
    before = np.floor(place).astype(int)
    share = smooth(place - before)
    weights = np.zeros((SIZE, number))
    weights[np.arange(SIZE), before] = 1.0 - share
    weights[np.arange(SIZE), (before + 1) % number] += share
    return weights


def noise(columns: int, rows: int, seed: int) -> F64:
    """Value noise from 0 to 1: columns × rows random values, smoothly joined, the last with the first."""
    values = np.random.default_rng(seed).random((rows, columns))
    return joining(rows) @ values @ joining(columns).T


def fractal(columns: int, rows: int, seed: int, octaves: int = 5) -> F64:
    """Noise, and half as much of it at twice the frequency, and so on; 0 to 1."""
    weights = 0.5 ** np.arange(octaves)
    layers = (weight * noise(columns << k, rows << k, seed + k) for k, weight in enumerate(weights))
    return sum(layers) / weights.sum()


def cells(number: int, seed: int) -> F64:
    """Distance to the nearest of number × number scattered points (Worley 1996), in units of a cell."""
    random = np.random.default_rng(seed)
    points = (np.stack(np.mgrid[:number, :number], axis=-1) + random.random((number, number, 2))).reshape(-1, 2)
    u, v = plane()
    nearest = np.full(u.shape, np.inf)
    for y, x in points / number:
        across, along = np.abs(u - x), np.abs(v - y)
        nearest = np.minimum(nearest, np.minimum(across, 1 - across) ** 2 + np.minimum(along, 1 - along) ** 2)
    return number * np.sqrt(nearest)


def boards(number: int, dark: Sequence[float], light: Sequence[float], seed: int, roughness: float) -> Surface:
    """Planed boards along v, with grain, pores and a groove between them."""
    u, _ = plane()
    board = np.floor(u * number).astype(int)
    tint = np.random.default_rng(seed).random(number)[board]
    # Growth rings are cut lengthwise: a slow wave across the board, bent by noise that is longer than wide.
    bent = fractal(2 * number, 1, seed + 1, octaves=3) + tint
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * (4.0 * u * number + 3.0 * bent))
    pores = smooth((fractal(32 * number, 4, seed + 2, octaves=2) - 0.55) * 5.0)
    edge = np.abs(u * number - board - 0.5) * 2.0
    groove = smooth((edge - 0.97) / 0.03)
    share = np.clip(0.55 * rings + 0.35 * tint - 0.35 * pores, 0.0, 1.0)
    return Surface(
        albedo=blend(share, dark, light) * (1.0 - 0.8 * groove[..., None]),
        roughness=np.clip(roughness + 0.18 * pores - 0.08 * rings + 0.4 * groove, 0.0, 1.0),
        height=-0.0008 * pores - 0.004 * groove,
    )


def plaster(color: Sequence[float], seed: int) -> Surface:
    """Rough plaster, put on with a trowel."""
    strokes = fractal(5, 9, seed)
    grain = fractal(64, 64, seed + 10, octaves=2)
    share = np.clip(0.7 * strokes + 0.3 * grain, 0.0, 1.0)
    return Surface(
        albedo=blend(share, 0.82 * np.asarray(color), color),
        roughness=0.82 + 0.14 * grain,
        height=0.012 * strokes + 0.0012 * grain,
    )


def cloth(warp: Sequence[float], weft: Sequence[float], threads: int, seed: int) -> Surface:
    """Plain weave: threads along u and v go over each other by turns. `threads` must be even to repeat."""
    u, v = plane()
    over = (np.floor(u * threads) + np.floor(v * threads)) % 2 == 0
    ridge_u, ridge_v = (np.abs(np.sin(np.pi * x * threads)) for x in (u, v))
    height = np.where(over, ridge_u, ridge_v)
    color = np.where(over[..., None], np.asarray(warp), np.asarray(weft))
    worn = 0.85 + 0.3 * fractal(8, 8, seed)
    return Surface(
        albedo=np.clip(color * (0.45 + 0.55 * height[..., None]) * worn[..., None], 0.0, 1.0),
        roughness=0.95 - 0.1 * height,
        height=0.35 / threads * height,
    )


def tiles(number: int, glaze: Sequence[float], grout: Sequence[float], seed: int) -> Surface:
    """Glazed tiles with rounded edges, each of a slightly other shade, in rough grout."""
    u, v = plane()
    column, row = np.floor(u * number).astype(int), np.floor(v * number).astype(int)
    shade = 0.7 + 0.5 * np.random.default_rng(seed).random((number, number))[row, column]
    edge = np.maximum(np.abs(u * number - column - 0.5), np.abs(v * number - row - 0.5)) * 2.0
    tile = 1.0 - smooth((edge - 0.86) / 0.08)
    wavy = fractal(6, 6, seed + 1, octaves=2)
    rough = fractal(48, 48, seed + 2, octaves=2)
    return Surface(
        albedo=np.clip(blend(tile, grout, glaze) * np.where(tile > 0.5, shade, 1.0)[..., None], 0.0, 1.0),
        roughness=0.9 - tile * (0.72 - 0.1 * wavy),
        height=0.012 * tile + 0.004 * tile * wavy + 0.002 * (1.0 - tile) * rough,
    )


def copper(seed: int) -> Surface:
    """Hammered copper, green with verdigris where the noise is high: metal and dielectric in one map."""
    dents = np.clip(cells(12, seed), 0.0, 1.0)
    old = smooth((fractal(4, 4, seed + 1) - 0.5) * 9.0)
    scratches = fractal(96, 3, seed + 9, octaves=3)
    return Surface(
        albedo=blend(old, (0.95, 0.60, 0.48), (0.12, 0.38, 0.30)),
        roughness=np.clip(0.18 + 0.14 * scratches + 0.55 * old, 0.0, 1.0),
        metallic=1.0 - old,
        height=0.02 * dents**2 * (1.0 - 0.7 * old) + 0.004 * old * fractal(32, 32, seed + 5, octaves=3),
    )


def iron(seed: int) -> Surface:
    """Brushed iron: fine lines along u."""
    lines = fractal(4, 160, seed, octaves=2)
    return Surface(
        albedo=blend(lines, (0.44, 0.43, 0.42), (0.60, 0.59, 0.57)),
        roughness=0.28 + 0.22 * lines,
        metallic=np.ones_like(lines),
        height=0.0009 * lines,
    )


def leaf(seed: int) -> Surface:
    """One pointed leaf, its stalk at the bottom, with a midrib and side veins; transparent around it."""
    u, v = plane()
    across = np.abs(u - 0.5)
    half_width = 0.42 * np.sin(np.pi * np.clip(v, 0.0, 1.0)) ** 0.8 * (1.0 - 0.45 * v)
    midrib = 1.0 - smooth((across - 0.006) / 0.01)
    side = np.abs((v * 9.0 - across * 7.0) % 1.0 - 0.5)
    veins = np.maximum(midrib, 0.6 * (1.0 - smooth((side - 0.03) / 0.05)))
    mottle = fractal(8, 8, seed)
    return Surface(
        albedo=blend(veins, (0.035, 0.16, 0.03), (0.16, 0.34, 0.10)) * (0.7 + 0.5 * mottle[..., None]),
        roughness=0.38 + 0.2 * mottle,
        height=0.006 * veins,
        alpha=(across < half_width).astype(np.float64),
    )
