# SPDX-License-Identifier: GPL-3.0-or-later
"""What repeated small renders tell beside the difference of two settings: how noisy one sample is, and what was missed.

Pictures are (K, P, 3) float arrays: K seeds, P pixels, scene-linear. Errors are shares of the picture's mean; that of
converged pictures is `metrics.paired_difference`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..metrics import Paired, check_seeds, effective_number

Pictures = NDArray[np.float64]

# An estimate that is no surer than one of so few pixels is dominated by fireflies.
FEW_PIXELS = 10.0


@dataclass(frozen=True, slots=True)
class Noise:
    """Variance of one sample in each pixel, as a share of the mean squared, and what adaptive sampling sees of it.

    variance: (P,) mean over the channels. error: (P,) what `film_error` (kernels/film.h) expects after one sample.
    pixels: how many make the mean variance, see `metrics.effective_number`.
    """

    variance: NDArray[np.float64]
    error: NDArray[np.float64]
    pixels: float

    @property
    def dominated(self) -> bool:
        return few(self)


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


def noise(pictures: Pictures, samples: int, mean: float) -> Noise:
    """What one sample of each pixel varies by, from renders of `samples` each."""
    check_seeds(pictures)
    variances = pictures.var(axis=0, ddof=1) * samples
    # film_error sums over the channels what all samples and every second one differ by: half of what two independent
    # halves do. Two pictures of n samples differ by as much as halves of 2 n samples.
    brightness = np.maximum(pictures.mean(axis=0).sum(axis=1), 0.0)
    first, second = np.triu_indices(len(pictures), 1)
    apart = 0.5 * np.abs(pictures[first] - pictures[second]).sum(axis=2).mean(axis=0)
    error = apart * np.sqrt(2.0 * samples) / (1e-4 + np.sqrt(brightness))
    relative = variances.mean(axis=1) / mean**2
    return Noise(relative, error, effective_number(relative))
