# SPDX-License-Identifier: GPL-3.0-or-later
"""The plot of one measure as pixels, by NumPy alone: Blender's Python has no matplotlib, and shall show it, too.

Letters come from who calls: a function that gives the coverage of a text. Edges are smooth by the distance to them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import labels
from .pictures import Bytes

# (text, size in pixels) -> coverage from 0 to 1, (h, w), the first row on top
Text = Callable[[str, int], NDArray[np.floating]]

INK, GREY, GRID, FRONT = (34, 34, 34), (110, 110, 110), (233, 233, 233), (203, 203, 203)
RADIUS = 0.011  # of a marker, as a part of the width


class Canvas:
    """Colors (h, w, 3) from 0 to 255, in floats; x to the right and y down, in pixels."""

    def __init__(self, width: int, height: int) -> None:
        self.pixels = np.full((height, width, 3), 255.0, np.float32)

    def cover(self, left: float, top: float, right: float, bottom: float, color: Any, distance: Any) -> None:
        """Paint where distance(x, y), in pixels, is below 0, inside a box that holds all of it."""
        height, width = self.pixels.shape[:2]
        x0, x1 = max(0, math.floor(left) - 1), min(width, math.ceil(right) + 2)
        y0, y1 = max(0, math.floor(top) - 1), min(height, math.ceil(bottom) + 2)
        if x0 >= x1 or y0 >= y1:
            return
        y, x = np.mgrid[y0:y1, x0:x1] + 0.5
        share = np.clip(0.5 - distance(x, y), 0.0, 1.0)[..., None]
        part = self.pixels[y0:y1, x0:x1]
        part += share * (np.array(color, np.float32) - part)

    def line(self, points: Sequence[tuple[float, float]], color: Any, width: float) -> None:
        for (ax, ay), (bx, by) in itertools.pairwise(points):
            length = (bx - ax) ** 2 + (by - ay) ** 2 or 1.0

            def away(x: Any, y: Any, a: Any = (ax, ay), b: Any = (bx, by), length: float = length) -> Any:
                along = np.clip(((x - a[0]) * (b[0] - a[0]) + (y - a[1]) * (b[1] - a[1])) / length, 0.0, 1.0)
                return np.hypot(x - a[0] - along * (b[0] - a[0]), y - a[1] - along * (b[1] - a[1])) - width / 2

            half = width / 2
            self.cover(min(ax, bx) - half, min(ay, by) - half, max(ax, bx) + half, max(ay, by) + half, color, away)

    def marker(self, kind: str, x: float, y: float, radius: float, color: Any, hollow: bool) -> None:
        def away(px: Any, py: Any) -> Any:
            dx, dy = np.abs(px - x), np.abs(py - y)
            if kind in ('D', 'X'):
                return (dx + dy) * math.sqrt(0.5) - radius
            if kind in ('s', 'P'):
                return np.maximum(dx, dy) - 0.9 * radius
            if kind in ('^', 'v'):
                side = (py - y) * (1.0 if kind == '^' else -1.0)
                return np.maximum(side - 0.8 * radius, (2.0 * dx - side) / math.sqrt(5.0) - 0.5 * radius)
            return np.hypot(dx, dy) - radius

        box = (x - 2 * radius, y - 2 * radius, x + 2 * radius, y + 2 * radius)
        self.cover(*box, color, away)
        if hollow:
            self.cover(*box, (255, 255, 255), lambda px, py: away(px, py) + 0.38 * radius)

    def mask(self, coverage: NDArray[np.floating], left: float, top: float, color: Any, halo: bool = False) -> None:
        height, width = coverage.shape
        x, y = round(left), round(top)
        if halo:
            wide = np.pad(coverage, 2)
            spread = np.max([np.roll(wide, shift, (0, 1)) for shift in np.ndindex(5, 5)], axis=0)
            self.mask(np.roll(spread, (-2, -2), (0, 1)), left - 2, top - 2, (255, 255, 255))
        x0, y0 = max(0, -x), max(0, -y)
        part = self.pixels[y + y0 : y + height, x + x0 : x + width]
        share = coverage[y0 : y0 + part.shape[0], x0 : x0 + part.shape[1]][..., None]
        part += share * (np.array(color, np.float32) - part)


def rgb(color: str) -> tuple[int, ...]:
    return tuple(int(color[place : place + 2], 16) for place in (1, 3, 5))


def ticks(low: float, high: float) -> list[float]:
    """Powers of ten, and 2 and 5 times them where there are few."""
    steps = (1, 2, 5) if high < 100.0 * low else (1,)
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [step * 10.0**power for power in powers for step in steps if low <= step * 10.0**power <= high]


def plot(data: dict[str, Any], key: str, title: str, width: int, height: int, text: Text) -> Bytes:
    """Seconds against one measure of page.plot_data, in a picture of that size."""
    canvas = Canvas(width, height)
    small, normal = max(9, width // 56), max(10, width // 46)
    left, right, top, bottom = 0.115 * width, 0.975 * width, 0.08 * height + normal, height - 3.6 * normal
    known = [(line, point) for line in data['lines'] for point in line['points'] if (point[key] or 0.0) > 0.0]
    name = next(measure['name'] for measure in data['measures'] if measure['key'] == key)
    canvas.mask(text(title, normal), 0.02 * width, 0.03 * height, INK)
    if not known:
        canvas.mask(text('No point has an error above that of the references', normal), left, top, GREY)
        return np.round(canvas.pixels).astype(np.uint8)
    seconds, errors = [point['seconds'] for _, point in known], [point[key] for _, point in known]
    x0, x1, y0, y1 = min(seconds) / 1.4, max(seconds) * 2.2, min(errors) / 1.5, max(errors) * 1.5

    def place(time: float, error: float) -> tuple[float, float]:
        across, up = math.log(time / x0) / math.log(x1 / x0), math.log(error / y0) / math.log(y1 / y0)
        return left + across * (right - left), bottom - up * (bottom - top)

    for value in ticks(x0, x1):
        x, _ = place(value, y0)
        canvas.line([(x, top), (x, bottom)], GRID, 1.0)
        put(canvas, text(f'{value:g}', small), x, bottom + 0.9 * small, GREY)
    for value in ticks(y0, y1):
        _, y = place(x0, value)
        canvas.line([(left, y), (right, y)], GRID, 1.0)
        words = text(f'{value:g}' if value >= 1e-3 else f'{value:.0e}', small)
        canvas.mask(words, left - words.shape[1] - 0.4 * small, y - words.shape[0] / 2, GREY)
    best = sorted((p['seconds'], p[key]) for _, p in known if key in p['front'])
    if best:
        stairs = [(place(best[0][0], y1)[0], top)]
        for time, error in best:
            stairs += [(place(time, error)[0], stairs[-1][1]), place(time, error)]
        canvas.line([*stairs, (right, stairs[-1][1])], FRONT, 0.009 * width)
    canvas.line([(left, top), (left, bottom), (right, bottom)], GREY, 1.4)
    put(canvas, text(f'{data["clock"]} of rendering', normal), (left + right) / 2, bottom + 2.7 * normal, INK)
    canvas.mask(np.rot90(text(name, normal)), 0.008 * width, (top + bottom) / 2 - 0.22 * width, INK)

    radius = RADIUS * width
    obstacles: list[labels.Box] = []
    wanted, colors = [], []
    for line in data['lines']:
        color = rgb(line['color'])
        places = [place(point['seconds'], point[key]) for other, point in known if other is line]
        if not places:
            continue
        curve = [place(time, error) for time, error in line['curves'].get(key, ()) if error > 0.0] or places
        inside = [(x, y) for x, y in curve if top <= y <= bottom and left <= x <= right]
        canvas.line(inside, color, 0.0026 * width)
        obstacles += [(x - 2, y - 2, x + 2, y + 2) for x, y in inside]
        obstacles += [(x - radius, y - radius, x + radius, y + radius) for x, y in places]
        words = text(line['name'], normal)
        wanted.append((labels.Label(line['name'], places[-1], (words.shape[1] + 4.0, words.shape[0] + 2.0)), words))
        colors.append(color)
    for line, point in known:
        canvas.marker(line['marker'], *place(point['seconds'], point[key]), radius, rgb(line['color']), line['hollow'])
    boxes = labels.place([label for label, _ in wanted], obstacles, (left, top, right, bottom))
    for (_, words), box, color in zip(wanted, boxes, colors, strict=True):
        canvas.mask(words, box[0] + 2, box[1] + 1, color, halo=True)
    return np.round(canvas.pixels).clip(0, 255).astype(np.uint8)


def put(canvas: Canvas, words: NDArray[np.floating], x: float, y: float, color: Any) -> None:
    """A text whose centre lies at (x, y)."""
    canvas.mask(words, x - words.shape[1] / 2, y - words.shape[0] / 2, color)
