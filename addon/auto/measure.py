# SPDX-License-Identifier: GPL-3.0-or-later
"""What repeated small renders tell beside the difference of two settings: how noisy one sample is, and what was missed.

Pictures are (K, P, 3) float arrays: K seeds, P pixels, scene-linear. Errors are shares of the picture's mean; that of
converged pictures is `metrics.paired_difference`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..metrics import Paired, check_seeds, effective_number

Pictures = NDArray[np.float64]

# An estimate that is no surer than one of so few pixels is dominated by fireflies.
FEW_PIXELS = 25.0
# A slope is looked for only where an estimate is as sure as one of so many.
MANY_PIXELS = 100.0
# Edges converge with the power 1.5 of the samples, where these are stratified in two dimensions.
STEEPEST = 1.5


@dataclass(frozen=True, slots=True)
class Noise:
    """How noisy each pixel is after so many samples, as a share of the mean, and how that falls with more.

    variance: (P,) mean of the channels, over the mean squared. error: (P,) what `film_error` (kernels/film.h) expects.
    samples: after which. slope: the power of the samples by which the variance falls, 1 for independent ones.
    pixels: how many make the mean variance, see `metrics.effective_number`.
    """

    variance: NDArray[np.float64]
    error: NDArray[np.float64]
    pixels: float
    samples: float = 1.0
    slope: float = 1.0

    @property
    def dominated(self) -> bool:
        return few(self)

    def after(self, samples: NDArray[np.float64]) -> NDArray[np.float64]:
        """Variance of each pixel after (P,) samples; fewer than were seen fall as independent ones do."""
        more = samples / self.samples
        return self.variance * more ** -np.where(more > 1.0, self.slope, 1.0)

    def samples_to(self, error: float) -> NDArray[np.float64]:
        """Samples after which film_error expects so little, (P,); as `after`."""
        more = np.square(self.error / error)
        return self.samples * np.where(more > 1.0, more ** (1.0 / self.slope), more)


def few(found: Paired | Noise) -> bool:
    """Whether a few pixels make an estimate: what is that rare may as well have been missed."""
    return found.pixels < FEW_PIXELS


def seen_between(a: Pictures, b: Pictures, mean: float, tolerance: float) -> bool:
    """Whether anything small, such as a lamp behind glass, may make the difference that pixels far apart do not see.

    a, b: pictures whose pixels cover all that lies between them. What one sample in many meets is seen once or twice,
    by one seed or two: here each such sample counts as what it would be if it were the rule.
    """
    check_seeds(a)
    squares = (((a - b) / mean).mean(axis=0) ** 2).mean(axis=1)
    return float(squares.mean()) > tolerance**2 and effective_number(squares) < FEW_PIXELS


def noise(pictures: Pictures, samples: int, mean: float, fewer: tuple[Pictures, int] | None = None) -> Noise:
    """From renders of `samples` each; fewer: others of the same settings, of fewer samples, which tell the slope.

    Stratified samples converge faster than independent ones where the picture is smooth, or has edges (Owen 1997); how
    much faster is seen between the two, if neither is made by fireflies.
    """
    check_seeds(pictures)
    variances = pictures.var(axis=0, ddof=1)
    # film_error sums over the channels what all samples and every second one differ by: half of what two independent
    # halves do. Two pictures of n samples differ by as much as halves of 2 n samples, whose halves differ by sqrt(2)
    # more than those of n do less.
    brightness = np.maximum(pictures.mean(axis=0).sum(axis=1), 0.0)
    first, second = np.triu_indices(len(pictures), 1)
    apart = 0.5 * np.abs(pictures[first] - pictures[second]).sum(axis=2).mean(axis=0)
    error = apart * np.sqrt(2.0) / (1e-4 + np.sqrt(brightness))
    relative = variances.mean(axis=1) / mean**2
    found = Noise(relative, error, effective_number(relative), float(samples))
    if fewer is None:
        return found
    before = fewer[0].var(axis=0, ddof=1).mean(axis=1)
    return replace(found, slope=slope(found, before / mean**2, fewer[1]))


def slope(found: Noise, before: NDArray[np.float64], samples: int) -> float:
    """The power by which the variance fell from `before`, after fewer samples; 1 where that cannot be told."""
    if samples >= found.samples or min(effective_number(before), found.pixels) < MANY_PIXELS:
        return 1.0
    was, now = float(before.mean()), float(found.variance.mean())
    if not 0.0 < now < was:
        return 1.0
    return float(np.clip(np.log(was / now) / np.log(found.samples / samples), 1.0, STEEPEST))
