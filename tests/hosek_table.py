# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the sky of Hosek and Wilkie in Cycles: the table that addon/shader/hosek_wilkie.csv holds.

Run it to write the table again; some minutes, and SciPy, which nothing else here needs. Hosek and Wilkie 2012, "An
Analytic Model for Full Spectral Sky-Dome Radiance", equation 8: ten numbers for each of X, Y and Z, each a Bezier curve
over the cube root of the sun's elevation, for ten turbidities and two albedos. Each is fitted to what Cycles shows.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from cotorra.shader import nodes_sky as sky
from scipy.optimize import least_squares

import cycles_ops

FILE = Path(sky.__file__).with_name('hosek_wilkie.csv')
AXIS = np.linspace(0.0, 1.0, 12)  # cube root of the share of 90 degrees
STEP = 0.25  # from one turbidity to the next, and from one albedo
NEAREST = 0.05  # radians from the sun
LIMIT = 1e-5  # relative error that 99 % of the pixels are to stay below
TO_XYZ = np.linalg.inv(np.array(sky.XYZ_TO_REC709)[:, :3])
STARTS = (
    *((-1.1, -0.2, -0.05, 0.6), (-1.0, -0.3, -3.0, 0.6), (-1.2, -0.5, -1.0, 0.4)),
    *((-1.3, -0.4, -0.01, 0.5), (-1.1, -0.2, 0.05, 0.6), (-1.0, -0.1, 0.3, 0.8)),
)
HEAD = """The sky of Hosek and Wilkie as Cycles shows it, measured by tests/hosek_table.py. Rows by turbidity 1 to 10,
albedo 0 and 1, and X, Y, Z; in each: six control points of each of a, b, e, h, c, d, f, g, i and the scale in
scale (1 + a exp(b / (cos t + 0.01))) (c + d exp(e s) + f cos^2 s + g (1 + cos^2 s) / (1 + h^2 - 2 h cos s)^1.5 +
i sqrt(cos t)), t from the zenith, s from the sun"""


def curve(x: np.ndarray | float) -> np.ndarray:
    """(n, 6): weights of control points."""
    x = np.atleast_1d(x)
    return np.stack([math.comb(5, k) * x**k * (1.0 - x) ** (5 - k) for k in range(6)], -1)


def measure(cases: list[tuple[float, float, float]], count: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """For each turbidity, albedo and place on the axis: cosines from the zenith and from the sun, and XYZ."""
    rng = np.random.default_rng(1)
    nodes, inputs, suns = [], [], []
    for turbidity, albedo, x in cases:
        e = 0.5 * math.pi * x**3
        sun = (math.cos(e), 0.0, math.sin(e))
        near, low = count // 5, count // 5
        z = np.r_[rng.uniform(0.001, 1.0, count - near - low), rng.uniform(0.001, 0.1, low)]
        z = np.r_[z, np.clip(math.sin(e) + rng.normal(0.0, 0.2, near), 0.001, 1.0)]
        phi = np.r_[rng.uniform(0.0, np.pi, count - near), np.abs(rng.normal(0.0, 0.2, near))]
        flat = np.sqrt(1.0 - z * z)
        inputs.append(np.round(np.stack([flat * np.cos(phi), flat * np.sin(phi), z], -1) * 2.0**20) / 2.0**20)
        made = {'sky_type': 'HOSEK_WILKIE', 'turbidity': turbidity, 'ground_albedo': albedo, 'sun_direction': sun}
        nodes.append(cycles_ops.Node('ShaderNodeTexSky', 'v', ['Vector'], ['Color'], made))
        suns.append(np.array(sun))
    with tempfile.TemporaryDirectory() as folder:
        shown = cycles_ops.render(nodes, inputs, Path(folder) / 'sky.exr')
    found = []
    for ways, sun, rgb in zip(inputs, suns, shown, strict=True):
        way = ways / np.linalg.norm(ways, axis=1, keepdims=True)
        # What was clamped tells nothing, and close to the sun Cycles' angle from it has few digits.
        seen = (rgb > 0.0).all(axis=1) & (way @ sun < math.cos(NEAREST))
        way = way[seen]
        found.append((np.minimum(way[:, 2], 1.0), np.clip(way @ sun, -1.0, 1.0), rgb[seen].astype(float) @ TO_XYZ.T))
    return found


def fitted(f: Callable, jacobian: Callable, x: np.ndarray, turns: int) -> tuple[float, np.ndarray]:
    """By Levenberg and Marquardt: the residual that 99 % stay below, and where."""
    scale = np.maximum(np.abs(x), 1e-3)

    def finite(values: np.ndarray) -> np.ndarray:
        return np.nan_to_num(values, nan=1e3, posinf=1e3, neginf=-1e3)

    found = least_squares(
        lambda q: finite(f(q * scale)),
        x / scale,
        jac=lambda q: finite(jacobian(q * scale) * scale),
        method='lm',
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
        max_nfev=turns,
    )
    return float(np.quantile(np.abs(found.fun), 0.99)), found.x * scale


def terms(p: np.ndarray, height: np.ndarray, toward: np.ndarray) -> np.ndarray:
    """(n, 5): what c, d, f, g and i are multiplied by. p: a, b, e, h, each a number or (n,)."""
    a, b, e, h = p
    first = 1.0 + a * np.exp(np.clip(b / (height + 0.01), -60.0, 60.0))
    fall = np.exp(np.clip(e * np.arccos(toward), -60.0, 60.0))
    glow = (1.0 + toward**2) / np.maximum(1.0 + h * h - 2.0 * h * toward, 1e-9) ** 1.5
    return first[:, None] * np.stack([np.ones_like(fall), fall, toward**2, glow, np.sqrt(height)], -1)


def one_elevation(height: np.ndarray, toward: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(9,): a, b, e, h, c, d, f, g, i."""

    def solved(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        t = terms(p, height, toward) / y[:, None]
        c = np.linalg.lstsq(t, np.ones(len(y)), rcond=1e-14)[0]
        return t @ c - 1.0, c

    def slope(p: np.ndarray) -> np.ndarray:
        steps = 1e-6 * np.maximum(np.abs(p), 1e-3)
        moved = [(solved(p + s)[0] - solved(p - s)[0]) / (2.0 * s.sum()) for s in np.diag(steps)]
        return np.stack(moved, -1)

    _, p = min((fitted(lambda p: solved(p)[0], slope, np.array(s), 200) for s in STARTS), key=lambda r: r[0])
    return np.r_[p, solved(p)[1]]


class Fit:
    """A table, (10, 6) control points, from what Cycles shows of it and of what lies between it and a known one."""

    def __init__(self, data: list[tuple[float, list[tuple]]], channel: int, known: np.ndarray | None) -> None:
        """data: shares of the new table, and by AXIS what is seen there."""
        rows = [(share, k, *seen) for share, places in data for k, seen in enumerate(places)]
        counts = [len(row[2]) for row in rows]
        self.height, self.toward = (np.concatenate([row[i] for row in rows]) for i in (2, 3))
        self.y = np.concatenate([row[4][:, channel] for row in rows])
        self.basis = np.repeat(curve(AXIS[[row[1] for row in rows]]), counts, axis=0)
        self.share = np.repeat([row[0] for row in rows], counts)[:, None]
        self.known = None if known is None else (1.0 - self.share) * (self.basis @ known.T)
        self.gauge = 0.0  # what the first table's scales add up to: c to i may be larger where they are smaller

    def numbers(self, x: np.ndarray) -> np.ndarray:
        own = self.basis @ x.reshape(10, 6).T
        return own if self.known is None else self.known + self.share * own

    def residual(self, x: np.ndarray) -> np.ndarray:
        n = self.numbers(x)
        shown = n[:, 9] * (terms(n[:, :4].T, self.height, self.toward) * n[:, 4:9]).sum(-1)
        held = [] if self.known is not None else [1e-2 * (x[54:].sum() / self.gauge - 1.0)]
        return np.r_[shown / self.y - 1.0, held]

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        n, height, toward = self.numbers(x), self.height, self.toward
        a, _, _, h = n[:, :4].T
        t = terms(n[:, :4].T, height, toward)
        bright, first = (t * n[:, 4:9]).sum(-1), t[:, 0]
        ex = (first - 1.0) / np.where(a == 0.0, 1.0, a)
        wide = np.maximum(1.0 + h * h - 2.0 * h * toward, 1e-9)
        own = [bright / first * ex, bright / first * a * ex / (height + 0.01), n[:, 5] * t[:, 1] * np.arccos(toward)]
        own += [n[:, 7] * t[:, 3] * -1.5 / wide * (2.0 * h - 2.0 * toward)]
        d = np.c_[n[:, 9:] * np.c_[np.stack(own, -1), t], bright] * (self.share / self.y[:, None])
        rows = (d[:, :, None] * self.basis[:, None, :]).reshape(len(self.y), 60)
        if self.known is not None:
            return rows
        return np.r_[rows, np.r_[np.zeros(54), np.full(6, 1e-2 / self.gauge)][None]]

    def from_(self, start: np.ndarray) -> tuple[float, np.ndarray]:
        """The relative error of 99 %, and the table."""
        self.gauge = start[9].sum()
        error, x = fitted(self.residual, self.jacobian, start.ravel(), 1000)
        return error, x.reshape(10, 6)


def first_table(data: list[tuple], channel: int) -> np.ndarray:
    found = np.array([one_elevation(h, t, xyz[:, channel]) for h, t, xyz in data])
    mean = np.array([xyz[:, channel].mean() for _, _, xyz in data])
    found = np.c_[found[:, :4], found[:, 4:] / mean[:, None], mean]
    error, table = math.inf, found
    for left_out in (None, *range(len(AXIS))):  # one of them may have come to other numbers that are as good
        kept = [k for k in range(len(AXIS)) if k != left_out]
        start = np.linalg.lstsq(curve(AXIS[kept]), found[kept], rcond=None)[0].T
        error, table = Fit([(1.0, data)], channel, None).from_(start)
        if error < LIMIT:
            return table
    sys.exit(f'{"XYZ"[channel]} of the first table: {error:.1e}')


def next_table(known: np.ndarray, data: list[tuple[float, list[tuple]]], channel: int, name: str) -> np.ndarray:
    """From what lies near the known one on to the new one: of a quarter of both the numbers are a quarter of both."""
    tries = []
    for way in (range(1, len(data) + 1), (2, len(data)), (len(data),)):
        found = known
        for count in way:
            error, found = Fit(data[:count], channel, known).from_(found)
        if error < LIMIT:
            return found
        tries.append(f'{error:.1e}')
    sys.exit(f'{name}: {", ".join(tries)}')


def table() -> np.ndarray:
    """(10, 2, 3, 10, 6)."""
    steps = np.arange(1.0, 10.01, STEP)
    keys = [(t, a) for a in (0.0, 1.0) for t in steps] + [(2.0, a) for a in np.arange(STEP, 0.99, STEP)]
    shown = measure([(t, a, x) for t, a in keys for x in AXIS], 160)
    data = {key: shown[len(AXIS) * k : len(AXIS) * (k + 1)] for k, key in enumerate(keys)}
    shares = np.arange(STEP, 1.01, STEP)
    found: dict[tuple, np.ndarray] = {}
    for channel in range(3):
        found[2.0, 0.0, channel] = first_table(data[2.0, 0.0], channel)
        pairs = [((2.0, 0.0), (2.0, 1.0))]
        for a in (0.0, 1.0):
            pairs += [((2.0, a), (1.0, a))] + [((float(t), a), (t + 1.0, a)) for t in range(2, 10)]
        for first, second in pairs:
            way = [(float(s), data[tuple((1.0 - s) * np.array(first) + s * np.array(second))]) for s in shares]
            name = f'{"XYZ"[channel]} of turbidity {second[0]:g}, albedo {second[1]:g}'
            found[(*second, channel)] = next_table(found[(*first, channel)], way, channel, name)
        print(f'{"XYZ"[channel]} is found', flush=True)
    return np.array([[[found[float(t), a, c] for c in range(3)] for a in (0.0, 1.0)] for t in range(1, 11)])


if __name__ == '__main__':
    np.savetxt(FILE, table().reshape(-1, 60), fmt='%.7g', delimiter=',', header=HEAD)
