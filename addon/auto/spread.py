# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a picture's samples are best taken: more of them where there is noise, fewer where there is little.

It reads what a session has after its first samples and tells how many each pixel takes in all. A pixel's number comes
of its neighbours' samples and never of its own, so that it adds no bias, as pixels do that stop where they look clean.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..export.buffers import RenderSettings
from .measure import STEEPEST
from .plan import LONGEST_PASS, percent

Values = NDArray[np.float64]

PART = 4  # the first samples are this part of all, and what a pixel takes at least
FIRST = 4  # at least: fewer tell too little of noise
MOST = 4  # a pixel takes so many times the samples that were asked for at most
ASIDE = (2, 5)  # pixels to either side whose noise counts, near and far alike
DARKEST = 0.1  # of the mean brightness: below, errors count no more
WORTH = 0.1  # part of the rays that must be saved, or all pixels take the same
PIXELS = 8192  # fewer tell too little of what is left
LEVEL_MOST, STEPS = 40.0, 24  # powers of two that are searched, halved so often


@dataclass(frozen=True, slots=True)
class Spread:
    """most: samples of each pixel, (h, w). share: of the rays that the samples which were asked for take. error: root
    mean square of what is left of the noise, as a share of what those would leave, by the measure by which it is more.
    """

    most: NDArray[np.uint32]
    share: float
    error: float

    def figures(self) -> dict[str, float]:
        fewest, most = int(self.most.min()), int(self.most.max())
        return {'fewest': fewest, 'most': most, 'share': self.share, 'error': self.error}

    def sentence(self) -> str:
        if self.share == 1.0:
            return 'AUTO: noise is so alike everywhere that all pixels take the same samples'
        return (
            f'AUTO: samples go where there is noise, {self.most.min()} to {self.most.max()} a pixel: '
            f'{percent(1.0 - self.share)} fewer rays leave as much of it in the picture'
        )


def first_samples(samples: int) -> int:
    """After how many a session is looked at: the end of a pass; 0 where there are too few."""
    first = 2 ** int(math.log2(max(samples // PART, 1)))
    return first if first >= FIRST else 0


def spreading(settings: RenderSettings, pixels: int) -> RenderSettings:
    """The same, as a session that will be looked at after its first samples; unchanged where that is not possible."""
    first = first_samples(settings.samples)
    if settings.adaptive or settings.device != 'CPU' or first == 0 or pixels < PIXELS:
        return settings
    return replace(settings, samples=MOST * settings.samples, spread_after=first)


def asked_samples(settings: RenderSettings) -> int:
    """Of all pixels in the mean, at most."""
    return settings.samples // MOST if settings.spread_after > 0 else settings.samples


def spread_samples(differences: Values, brightness: Values, first: int, samples: int, reach: int = 0) -> Spread:
    """differences: film_error (kernels/film.h) of each pixel's `first` samples beside half of them, and of these beside
    a quarter; and the rays that a sample takes in its tile, (h, w, 3). brightness: the sum of its channels, (h, w).
    samples: that were asked for. reach: pixels to either side that show a pixel's samples, too (`shared_reach`).

    With variances v n^-s and c rays a sample, the sum of v n^-s / b is least, for as many rays, where
    s v n^-(1 + s) / (b c) is the same for all (Neyman 1934, who has s = 1). b is the brightness, as for film_error:
    noise in the dark counts more than in the root mean square over the picture. Neither of the two may be larger than
    with all samples alike. As v of a pixel counts that of its neighbours, and its own, of which its number is not made,
    tells what is left.
    """
    light = np.maximum(brightness.astype(np.float64), 0.0)
    errors = np.square(differences.astype(np.float64))
    now, before = (errors[..., k] * np.square(1e-4 + np.sqrt(light)) for k in (0, 1))
    with np.errstate(divide='ignore', invalid='ignore'):
        fall = np.log2(neighbours(before, ASIDE[-1], reach) / neighbours(now, ASIDE[-1], reach))
    slope = np.clip(np.nan_to_num(fall, nan=1.0), 1.0, STEEPEST)
    # Halves differ by 2^s - 1 times the variance of both together.
    own = now / (2.0**slope - 1.0)
    plain = Spread(np.full(own.shape, samples, np.uint32), 1.0, 1.0)
    if not 0.0 < float(own.sum()) < math.inf:
        return plain
    # What is looked at: the mean squared error, and that of film_error.
    seen = neighbours(light, ASIDE[0], reach) + DARKEST * light.mean()
    measures = [own, own / seen]
    # Where there is no noise at all, a ray meets nothing, or what only shines.
    clean = ~errors.any(axis=2)
    cost = np.where(clean, 1.0, np.maximum(differences[..., 2], 1.0)).astype(np.float64)
    around = np.mean([neighbours(own, aside, reach) for aside in ASIDE], axis=0) / seen
    # By the tile's rays, which a pixel's own samples are a small part of.
    dear = np.maximum(differences[..., 2], 1.0).astype(np.float64)
    wanted = (slope * (around / around.mean()) * (dear.mean() / dear)) ** (1.0 / (1.0 + slope))
    ends = rungs(first, MOST * samples)
    between = np.sqrt(ends[:-1] * ends[1:])

    def taken(level: float) -> Values:
        return ends[np.searchsorted(between, first * wanted * 2.0 ** (level / (1.0 + slope)))]

    def left(taken: Values) -> float:
        """The larger of both, each as a part of what all samples alike leave."""
        after, alike = (first / taken) ** slope, (first / samples) ** slope
        return max(float((of * after).sum() / (of * alike).sum()) for of in measures)

    low, high = 0.0, LEVEL_MOST
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if left(taken(middle)) <= 1.0 else (middle, high)
    most = taken(high)
    share = float(np.average(most, weights=cost)) / samples
    if share > 1.0 - WORTH or left(most) > 1.0:
        return plain
    return Spread(most.astype(np.uint32), share, math.sqrt(left(most)))


def rungs(first: int, last: int) -> Values:
    """Ends of passes from `first` on: powers of two, whose samples are the best distributed, and halfway between."""
    powers = 2.0 ** np.arange(round(math.log2(first)), math.log2(last) + 1e-9)
    steps = np.union1d(powers, 1.5 * powers[powers >= 2 * LONGEST_PASS])
    return steps[steps <= last]


def shared_reach(settings: RenderSettings, filter_width: float) -> int:
    """How many pixels away one shows a pixel's samples: those whose filters reach them, where samples are shared."""
    return max(math.ceil(filter_width) - 1, 0) if settings.sharing else 0


def neighbours(values: Values, aside: int, reach: int = 0) -> Values:
    """Mean of the pixels around each in a square, without itself, and those within reach; at the picture's edges of
    those that there are.
    """
    aside = max(aside, reach + 1)

    def boxes(grid: Values, aside: int) -> Values:
        sums = np.pad(grid, aside + 1)[:-1, :-1].cumsum(axis=0).cumsum(axis=1)
        size = 2 * aside + 1
        sums = np.pad(sums, ((0, 1), (0, 1)), mode='edge')
        return (sums[size:, size:] - sums[:-size, size:] - sums[size:, :-size] + sums[:-size, :-size])[:height, :width]

    def ring(grid: Values) -> Values:
        return boxes(grid, aside) - (boxes(grid, reach) if reach > 0 else grid)

    height, width = values.shape
    return np.maximum(ring(values), 0.0) / np.maximum(ring(np.ones_like(values)), 1.0)
