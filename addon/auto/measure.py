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
    apart: error and variance of disjoint seeds, (K, P) each: what a pixel that looks clean may hide. None: not known.
    cost: (P,) of a sample of each pixel, 1 in the mean. None: all cost the same.
    """

    variance: NDArray[np.float64]
    error: NDArray[np.float64]
    pixels: float
    samples: float = 1.0
    slope: float = 1.0
    apart: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    cost: NDArray[np.float64] | None = None

    @property
    def dominated(self) -> bool:
        return few(self)

    def after(self, samples: NDArray[np.float64]) -> NDArray[np.float64]:
        """Variance of each pixel after (P,) samples; fewer than were seen fall as independent ones do."""
        return self.variance * self.fall(samples)

    def fall(self, samples: NDArray[np.float64]) -> NDArray[np.float64]:
        """What is left of the variance after so many samples, of any shape."""
        more = samples / self.samples
        return more ** -np.where(more > 1.0, self.slope, 1.0)

    def samples_to(self, error: float, expected: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """Samples after which film_error expects so little, (P,); as `after`. expected: another error than its own."""
        more = np.square((self.error if expected is None else expected) / error)
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


def costs(empty: NDArray[np.bool_], rays: float) -> NDArray[np.float64]:
    """Noise.cost, where a sample takes so many rays in the mean: of pixels that show no surface, (P,), it takes one.

    What those save by stopping is little.
    """
    share = float(empty.mean())
    if share in (0.0, 1.0) or not rays > 1.0:
        return np.ones(len(empty))
    return np.where(empty, 1.0 / rays, (1.0 - share / rays) / (1.0 - share))


def noise(pictures: Pictures, samples: int, mean: float, fewer: tuple[Pictures, int] | None = None) -> Noise:
    """From renders of `samples` each; fewer: others of the same settings, of fewer samples, which tell the slope.

    Stratified samples converge faster than independent ones where the picture is smooth, or has edges (Owen 1997); how
    much faster is seen between the two, if neither is made by fireflies.
    """
    check_seeds(pictures)
    variances = pictures.var(axis=0, ddof=1)
    error = expected_error(pictures)
    relative = variances.mean(axis=1) / mean**2
    found = Noise(relative, error, effective_number(relative), float(samples), apart=disjoint(pictures, mean))
    if fewer is None:
        return found
    before = fewer[0].var(axis=0, ddof=1).mean(axis=1)
    return replace(found, slope=slope(found, before / mean**2, fewer[1]))


def expected_error(pictures: Pictures) -> NDArray[np.float64]:
    """What `film_error` (kernels/film.h) expects of each pixel after as many samples as each picture has, (P,).

    It sums over the channels what all samples and the first half of them differ by: half of what two independent halves
    do.
    Two pictures of n samples differ by as much as halves of 2 n samples, whose halves differ by sqrt(2) less than those
    of n do.
    """
    brightness = np.maximum(pictures.mean(axis=0).sum(axis=1), 0.0)
    first, second = np.triu_indices(len(pictures), 1)
    apart = 0.5 * np.abs(pictures[first] - pictures[second]).sum(axis=2).mean(axis=0)
    return apart * np.sqrt(2.0) / (1e-4 + np.sqrt(brightness))


def disjoint(pictures: Pictures, mean: float) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Noise.apart: for each seed the error that the others show, and the variance that this one shows beside them.

    A pixel stops by the samples that it is made of: those in which rare light was missed look clean. Of fewer than
    three seeds none is left over.
    """
    count = len(pictures)
    if count < 3:
        return None
    errors, variances = [], []
    for number in range(count):
        others = np.delete(pictures, number, axis=0)
        alone = others.mean(axis=0)
        errors.append(expected_error(others))
        # The mean of the others has a share of their variance itself.
        squares = np.square(pictures[number] - alone) * ((count - 1) / count)
        variances.append(squares.mean(axis=1) / mean**2)
    return np.stack(errors), np.stack(variances)


def typical(pictures: Pictures, samples: int) -> float:
    """Mean over the pixels of the deviation of one sample, from renders of `samples` each.

    Where each pixel takes as many samples as its deviation asks for, it is what the error of all comes of (Neyman
    1934), and a few fireflies are a small part of it.
    """
    check_seeds(pictures)
    return float(np.sqrt(pictures.var(axis=0, ddof=1).mean(axis=1) * samples).mean())


def slope(found: Noise, before: NDArray[np.float64], samples: int) -> float:
    """The power by which the variance fell from `before`, after fewer samples; 1 where that cannot be told."""
    if samples >= found.samples or min(effective_number(before), found.pixels) < MANY_PIXELS:
        return 1.0
    was, now = float(before.mean()), float(found.variance.mean())
    if not 0.0 < now < was:
        return 1.0
    return float(np.clip(np.log(was / now) / np.log(found.samples / samples), 1.0, STEEPEST))
