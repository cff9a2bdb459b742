# SPDX-License-Identifier: GPL-3.0-or-later
"""What repeated small renders tell: how far two settings' converged pictures are apart, and how noisy one sample is.

Pictures are (K, P, 3) float arrays: K seeds, P pixels, scene-linear. Errors are shares of the picture's mean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Pictures = NDArray[np.float64]

SIGMAS = 1.96  # of a normal distribution, on either side: 95 %
# An estimate that is no surer than one of so few pixels is dominated by fireflies.
FEW_PIXELS = 10.0


@dataclass(frozen=True, slots=True)
class Difference:
    """Root mean square over the pixels of the difference of two converged pictures, as a share of the mean.

    value: the estimate. low, high: its interval of 95 %. pixels: how many make it, see `effective`.
    """

    value: float
    low: float
    high: float
    pixels: float

    @property
    def dominated(self) -> bool:
        """Whether a few pixels make the estimate: what is that rare may as well have been missed."""
        return self.pixels < FEW_PIXELS


@dataclass(frozen=True, slots=True)
class Noise:
    """Variance of one sample in each pixel, as a share of the mean squared, and what adaptive sampling sees of it.

    variance: (P,) mean over the channels. error: (P,) what `film_error` (kernels/film.h) expects after one sample.
    pixels: how many make the mean variance, see `effective`.
    """

    variance: NDArray[np.float64]
    error: NDArray[np.float64]
    pixels: float

    @property
    def dominated(self) -> bool:
        return self.pixels < FEW_PIXELS


def check(pictures: Pictures) -> None:
    if pictures.ndim != 3 or pictures.shape[2] != 3 or pictures.shape[0] < 2:
        raise ValueError(f'pictures of two seeds at least are needed, (K, P, 3), not {pictures.shape}')


def difference(a: Pictures, b: Pictures, mean: float) -> Difference:
    """How far the converged pictures of two settings are apart, from renders of both with the same seeds.

    What noise the two share falls out with a - b = D. Of what is left, products of different seeds have no bias: with
    K independent D of a pixel, the mean of D_i D_j over i != j expects the square of their common mean (a U-statistic:
    Hoeffding 1948). Its interval is that of a mean over pixels that stand for all of the picture's.

    Raises ValueError where the shapes are not alike, or the mean is not positive.
    """
    check(a)
    if a.shape != b.shape or not mean > 0.0:
        raise ValueError(f'pictures of one shape and a positive mean are needed, not {a.shape}, {b.shape} and {mean}')
    d = (a - b) / mean
    count = len(d)
    products = (d.sum(axis=0) ** 2 - (d**2).sum(axis=0)) / (count * (count - 1))
    squares = products.mean(axis=1)
    error = squares.std(ddof=1) / np.sqrt(len(squares)) if len(squares) > 1 else np.inf
    value = squares.mean()
    low, high = value - SIGMAS * error, value + SIGMAS * error
    return Difference(
        value=float(np.sqrt(max(value, 0.0))),
        low=float(np.sqrt(max(low, 0.0))),
        high=float(np.sqrt(max(high, 0.0))),
        pixels=effective(squares),
    )


def seen_between(a: Pictures, b: Pictures, mean: float, tolerance: float) -> bool:
    """Whether anything small, such as a lamp behind glass, may make the difference that pixels far apart do not see.

    a, b: pictures whose pixels cover all that lies between them. What one sample in many meets is seen once or twice,
    by one seed or two: here each such sample counts as what it would be if it were the rule.
    """
    check(a)
    squares = (((a - b) / mean).mean(axis=0) ** 2).mean(axis=1)
    return float(squares.mean()) > tolerance**2 and effective(squares) < FEW_PIXELS


def noise(pictures: Pictures, samples: int, mean: float) -> Noise:
    """What one sample of each pixel varies by, from renders of `samples` each."""
    check(pictures)
    variances = pictures.var(axis=0, ddof=1) * samples
    # film_error sums over the channels what all samples and every second one differ by: half of what two independent
    # halves do. Two pictures of n samples differ by as much as halves of 2 n samples.
    brightness = np.maximum(pictures.mean(axis=0).sum(axis=1), 0.0)
    first, second = np.triu_indices(len(pictures), 1)
    apart = 0.5 * np.abs(pictures[first] - pictures[second]).sum(axis=2).mean(axis=0)
    error = apart * np.sqrt(2.0 * samples) / (1e-4 + np.sqrt(brightness))
    relative = variances.mean(axis=1) / mean**2
    return Noise(relative, error, effective(relative))


def effective(values: NDArray[np.float64]) -> float:
    """How many equal values would be as sure a sum (Kish 1965, effective sample size); all of them where all are 0."""
    squares = float((values**2).sum())
    return float(np.abs(values).sum()) ** 2 / squares if squares > 0.0 else float(len(values))


def upper_mean(values: NDArray[np.float64]) -> float:
    """Upper end of the 95 % interval of the mean."""
    if len(values) < 2:
        return float('inf')
    return float(values.mean() + SIGMAS * values.std(ddof=1) / np.sqrt(len(values)))
