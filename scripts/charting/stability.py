# SPDX-License-Identifier: GPL-3.0-or-later
"""The stability atlas: relative error of each method over two of its parameters, against double precision.

A map outlines where the error stays below 1e-3, and the region in which that is promised; what lies outside is told in
words. What is measured stands in stability_models.py and stability_transport.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import BoundaryNorm
from matplotlib.ticker import LogFormatterMathtext
from numpy.typing import NDArray

from charting.result import Chart, Table, panels

F64 = NDArray[np.float64]
LIMIT = 1e-3
LOWEST, HIGHEST = 1e-8, 1.0


@dataclass(frozen=True, slots=True)
class Axis:
    """values: ascending. promised: from and to, both included."""

    name: str
    values: F64
    promised: tuple[float, float]
    log: bool = True

    def inside(self) -> NDArray[np.bool_]:
        low, high = self.promised
        return (self.values >= low * (1.0 - 1e-9)) & (self.values <= high * (1.0 + 1e-9))


@dataclass(frozen=True, slots=True)
class Map:
    """error: (y, x) relative; NaN where there is nothing to compare. outside: what happens beyond the outline.

    where, narrower: (y, x) and in words, of the promised region, where two axes alone do not tell it.
    """

    name: str
    x: Axis
    y: Axis
    error: F64
    outside: str
    where: NDArray[np.bool_] | None = None
    narrower: str = ''

    def promised(self) -> NDArray[np.bool_]:
        box = self.y.inside()[:, None] & self.x.inside()[None, :]
        return box if self.where is None else box & self.where

    def worst(self) -> float:
        """In the promised region; infinity where a value is not finite there."""
        found = self.error[self.promised() & ~np.isnan(self.error)]
        return float(found.max()) if found.size else 0.0

    def held(self) -> float:
        """The part of the whole map in which the error is below the limit."""
        known = ~np.isnan(self.error)
        return float((self.error[known] <= LIMIT).mean()) if known.any() else 1.0


def steps(low: float, high: float, count: int, *always: float) -> F64:
    """Evenly on a logarithmic scale, and these values beside."""
    return np.unique(np.concatenate((np.geomspace(low, high, count), always)))


def relative(found: F64, truth: F64) -> F64:
    """Of the largest channel, where the truth is not 0; infinity where what was found is not finite."""
    with np.errstate(all='ignore'):
        error = np.abs(np.asarray(found, np.float64) - truth) / np.abs(truth)
    return np.where(np.isfinite(found), np.where(truth == 0.0, np.where(found == 0.0, 0.0, np.inf), error), np.inf)


def make(quick: bool) -> Chart:
    from charting import stability_models, stability_transport

    maps = [*stability_models.maps(9 if quick else 61), *stability_transport.maps(5 if quick else 13)]
    columns = 5
    figure, axes = panels(
        'Relative error against double precision. Black: 1e-3; dashed: promised so; grey: nothing to compare',
        -(-len(maps) // columns),
        columns,
        3.3,
        2.9,
    )
    shown = None
    for one, panel in zip(maps, axes, strict=False):
        shown = draw(panel, one)
    for panel in axes[len(maps) :]:
        panel.axis('off')
    figure.colorbar(shown, ax=axes, label='relative error', shrink=0.6, pad=0.01, format=LogFormatterMathtext())
    head = ('method', 'over', 'worst where promised', 'holds 1e-3 in', 'promised', 'outside')
    rows = [
        (one.name, f'{one.x.name}, {one.y.name}', one.worst(), f'{100.0 * one.held():.0f} %', span(one), told(one))
        for one in maps
    ]
    tables = [Table('summary', 'Stability: relative error against double precision', head, rows)]
    return Chart('stability', tables + [grid(one) for one in maps], figure, markdown(rows))


def span(one: Map) -> str:
    parts = [f'{axis.name} {axis.promised[0]:g} to {axis.promised[1]:g}' for axis in (one.x, one.y)]
    return '; '.join([*parts, one.narrower] if one.narrower else parts)


def told(one: Map) -> str:
    whole = one.held() == 1.0 and not np.isnan(one.error).any()
    return 'nothing fails in the map' if whole else one.outside


def markdown(rows: list[tuple[Any, ...]]) -> str:
    """The summary for the documentation."""
    lines = [
        '# Where the methods hold',
        '',
        'Relative error against double precision; `./scripts/chart stability` makes this table, its maps and their',
        'figures. In the promised region it stays below 1e-3.',
        '',
        '| Method | Promised for | Worst error there | Below 1e-3 in the whole map | Outside |',
        '|---|---|---|---|---|',
    ]
    lines += [f'| {name} | {where} | {worst:.1e} | {held} | {told} |' for name, _, worst, held, where, told in rows]
    return '\n'.join(lines) + '\n'


def grid(one: Map) -> Table:
    """A map as rows of x, y, error."""
    cells = [
        (float(x), float(y), float(one.error[j, i]))
        for j, y in enumerate(one.y.values)
        for i, x in enumerate(one.x.values)
    ]
    name = ''.join(c if c.isalnum() else '-' for c in one.name.lower())
    return Table(name, one.name, (one.x.name, one.y.name, 'relative error'), cells)


def draw(panel: Any, one: Map) -> Any:
    decades = 10.0 ** np.arange(np.log10(LOWEST), np.log10(HIGHEST) + 1.0)
    values = np.clip(np.nan_to_num(one.error, nan=LOWEST, posinf=HIGHEST), LOWEST, HIGHEST)
    panel.set_facecolor('0.8')  # nothing to compare
    shown = panel.pcolormesh(
        one.x.values,
        one.y.values,
        np.ma.masked_where(np.isnan(one.error), values),
        cmap='RdYlBu_r',
        norm=BoundaryNorm(decades, 256),
        shading='nearest',
        rasterized=True,
    )
    for axis, scale, limit in ((one.x, panel.set_xscale, panel.set_xlim), (one.y, panel.set_yscale, panel.set_ylim)):
        if axis.log:
            scale('log')
        limit(axis.values[0], axis.values[-1])
    if values.max() > LIMIT > values.min():
        panel.contour(one.x.values, one.y.values, values, levels=[LIMIT], colors='black', linewidths=1.4)
    where = one.promised().astype(float)
    if 0.0 < where.mean() < 1.0:
        panel.contour(one.x.values, one.y.values, where, levels=[0.5], colors='black', linestyles='--', linewidths=1.0)
    panel.set_title(f'{one.name}\nworst where promised {one.worst():.1e}', fontsize=8)
    panel.set_xlabel(one.x.name, fontsize=8)
    panel.set_ylabel(one.y.name, fontsize=8)
    panel.tick_params(labelsize=7)
    return shown
