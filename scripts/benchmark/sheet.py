# SPDX-License-Identifier: GPL-3.0-or-later
"""The contact sheet of `./scripts/bench --all`: a row for each scene: ours, Cycles', their tiles' difference."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from cotorra.metrics import TILE, Image, SameImage

from compare import displayed

WIDTH = 320  # of each picture, pixels
TITLE = 18
STEPS = 3.0  # the colours end at so many times the limit


class Sheet:
    """Rows are added one by one, and the file is written each time: a run that is stopped leaves what there is."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.rows: list[tuple[str, Image, Image, Image]] = []

    def add(self, result: dict[str, Any], same: SameImage, images: tuple[Image, Image]) -> None:
        ours, cycles = images
        white = max(float(np.nanpercentile(np.where(np.isfinite(cycles), cycles, np.nan), 99)), 1e-12)
        height, width = cycles.shape[:2]
        tiles = same.tiles.repeat(TILE, axis=0).repeat(TILE, axis=1)[:height, :width]
        beyond = f'{1.0 - same.within:.1%} of tiles beyond {same.limit:.0%}, {same.beyond_noise:.1%} for sure'
        shown = (displayed(ours, white), displayed(cycles, white), signed(tiles / (STEPS * same.limit)))
        self.rows.append((f'{result["scene"]}: total {same.total:+.2%}, {beyond}', *shown))
        self.write()

    def write(self) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        tall = [WIDTH * row[1].shape[0] / row[1].shape[1] + TITLE for row in self.rows]
        figure = Figure(figsize=(3 * WIDTH / 100, sum(tall) / 100), dpi=100)
        FigureCanvasAgg(figure)
        top = sum(tall)
        for (title, *pictures), size in zip(self.rows, tall, strict=True):
            figure.text(0.005, (top - TITLE / 2) / sum(tall), title, fontsize=7, va='center')
            top -= size
            for column, picture in enumerate(pictures):
                axes = figure.add_axes((column / 3, top / sum(tall), 1 / 3, (size - TITLE) / sum(tall)))
                axes.imshow(picture, interpolation='nearest', aspect='auto')
                axes.set_axis_off()
        self.path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(self.path)


def signed(values: np.ndarray) -> Image:
    """-1 is blue, 0 white, 1 red, (h, w) to (h, w, 3)."""
    clipped = np.clip(values, -1.0, 1.0)[..., None]
    red, blue = np.array([0.7, 0.05, 0.1]), np.array([0.05, 0.2, 0.7])
    return 1.0 - np.maximum(clipped, 0.0) * (1.0 - red) - np.maximum(-clipped, 0.0) * (1.0 - blue)
