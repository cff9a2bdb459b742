# SPDX-License-Identifier: GPL-3.0-or-later
"""Every figure of error, once: RMSE, relMSE, FLIP, noise and bias told apart, intervals, the "same image" criterion.

Nothing here reads files, knows Blender or draws. Benchmark, charts, tests and the add-on take their figures from here.

Images are (h, w, 3) float arrays, scene-linear, the first row on top. A reference comes as independent parts (other
seeds) where it can: their mean is the reference, and their differences tell how noisy that mean still is, so that
noise in the reference is neither counted as an error of the image under test nor taken for a difference of two engines.

Sources. relMSE: Rousselle, Knaus and Zwicker 2011, "Adaptive Sampling and Reconstruction using Greedy Error
Minimization", equation 14, whose constant is scaled by the mean here. FLIP: Andersson et al. 2020, "FLIP: A Difference
Evaluator for Alternating Images"; of scene-linear images by Andersson et al. 2021, "Visualizing Errors in Rendered High
Dynamic Range Images". Interval of a difference: Welch 1947, "The generalization of Student's problem".
"""

from __future__ import annotations

import importlib.util
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.floating]

# relMSE divides by reference² + (RELATIVE_FLOOR · image mean)²: relative in the lit parts, absolute in the dark ones,
# and independent of exposure. 0.1 of the mean is what the usual constant 0.01 is for an image whose mean is 1.
RELATIVE_FLOOR = 0.1
# Share of the pixels, those with the greatest error, that the trimmed measure leaves out (fireflies).
TRIMMED_SHARE = 0.001
TILE = 16
# Tiles darker than this share of the image's mean are compared absolutely, as if they had this brightness.
TILE_FLOOR = 1e-3
# An error that falls more slowly than this power of the samples is no noise: fireflies or a systematic difference.
LEAST_SLOPE = 0.2
# A 640×360 image has 2760 tile channels: of these, noise alone puts 7 beyond 3 standard deviations and 0.2 beyond 4.
NOISE_SIGMAS = 4


@dataclass(frozen=True, slots=True)
class Reference:
    """A converged image and the variance of its pixels (of the mean of its halves); zeros where that is not known."""

    image: Image
    variance: Image

    @staticmethod
    def from_parts(parts: Sequence[Image]) -> Reference:
        """The mean of k independent renders; their sample variance over k is an unbiased estimate of that mean's.

        ValueError for none, and where the shapes differ. One alone tells nothing of its noise.
        """
        if not parts:
            raise ValueError('a reference needs a picture')
        for part in parts:
            check_pair(part, parts[0])
        stack = np.asarray(parts, np.float64)
        if len(parts) == 1:
            return Reference(stack[0], np.zeros(stack[0].shape))
        return Reference(stack.mean(axis=0), stack.var(axis=0, ddof=1) / len(parts))

    @staticmethod
    def from_halves(a: Image, b: Image) -> Reference:
        """The mean of two independent renders; (a − b)²/4 is an unbiased estimate of that mean's variance."""
        return Reference.from_parts((a, b))

    @staticmethod
    def from_image(image: Image) -> Reference:
        return Reference.from_parts((image,))


@dataclass(frozen=True, slots=True)
class Error:
    """Error of an image against a reference, the reference's own noise subtracted.

    mse:      mean squared error.
    relmse:   mean of error² / (reference² + floor²), reference² being the pixel's mean over its channels.
    trimmed:  relmse without the TRIMMED_SHARE of pixels that have the greatest error.
    residual: subtracted from relmse for the noise of the reference; where it is not small, render a better one.
    bad:      pixels with NaN or infinity; they are left out of the three means.
    """

    mse: float
    relmse: float
    trimmed: float
    residual: float
    bad: int

    @property
    def rmse(self) -> float:
        """Square root of the MSE; 0 where nothing is left once the reference's noise is subtracted."""
        return math.sqrt(max(0.0, self.mse)) if self.mse == self.mse else math.nan


def check_pair(a: Image, b: Image) -> None:
    """Two images must have one shape, (h, w, 3)."""
    if a.shape != b.shape or a.ndim != 3 or a.shape[2] != 3:
        raise ValueError(f'two images of one shape (h, w, 3) are needed, not {a.shape} and {b.shape}')


def image_error(image: Image, reference: Reference) -> Error:
    """Error of `image` against `reference`, see `Error`."""
    check_pair(image, reference.image)
    finite = np.isfinite(image).all(axis=2) & np.isfinite(reference.image).all(axis=2)
    if not finite.any():
        return Error(np.nan, np.nan, np.nan, np.nan, int(finite.size))
    truth = reference.image[finite].astype(np.float64)
    squared = ((image[finite].astype(np.float64) - truth) ** 2).mean(axis=1)
    noise = reference.variance[finite].mean(axis=1)
    scale = relative_scale(truth)
    relative, relative_noise = squared / scale, noise / scale

    # Which pixels are trimmed hardly depends on the reference's noise, so that noise is taken over what is kept.
    kept = np.argsort(relative, kind='stable')[: max(1, relative.size - int(np.ceil(TRIMMED_SHARE * relative.size)))]
    return Error(
        mse=float(squared.mean() - noise.mean()),
        relmse=float(relative.mean() - relative_noise.mean()),
        trimmed=float(relative[kept].mean() - relative_noise[kept].mean()),
        residual=float(relative_noise.mean()),
        bad=int(finite.size - finite.sum()),
    )


def relative_scale(truth: NDArray[np.float64]) -> NDArray[np.float64]:
    """What relMSE divides by: the pixel's mean over its channels (the last axis), squared, and the floor's square."""
    floor = RELATIVE_FLOOR * abs(truth.mean())
    scale = truth.mean(axis=-1) ** 2 + floor**2
    return np.where(scale > 0, scale, 1.0)  # a black reference: absolute


def error_map(image: Image, reference: Reference) -> NDArray[np.float64]:
    """(h, w): the square root of what each pixel adds to relMSE, the reference's noise included; NaN where bad."""
    check_pair(image, reference.image)
    truth = reference.image.astype(np.float64)
    squared = ((image.astype(np.float64) - truth) ** 2).mean(axis=2)
    finite = np.isfinite(truth).all(axis=2)
    scale = relative_scale(np.where(finite[..., None], truth, 0.0))
    return np.where(finite & np.isfinite(squared), np.sqrt(squared / scale), np.nan)


# ---- Noise and bias.


@dataclass(frozen=True, slots=True)
class Parts:
    """An error told apart, each as MSE and as relMSE. noise: falls with samples; bias: what seeds have in common."""

    noise_mse: float
    noise_relmse: float
    bias_mse: float
    bias_relmse: float


def noise_and_bias(images: Sequence[Image], reference: Reference) -> Parts:
    """Error of renders of one setting and independent seeds, told apart; two at least, else ValueError.

    noise: the variance of one render, by how the seeds differ: it needs no reference. bias: the mean product of the
    errors of two seeds, from which noise averages out, less the reference's variance; both are unbiased, so that the
    bias of a method without any is as often below 0 as above. Bad pixels are left out.
    """
    if len(images) < 2:
        raise ValueError('noise and bias are told apart by two renders at least')
    for image in images:
        check_pair(image, reference.image)
    finite = np.isfinite(reference.image).all(axis=2)
    for image in images:
        finite &= np.isfinite(image).all(axis=2)
    if not finite.any():
        return Parts(np.nan, np.nan, np.nan, np.nan)
    stack = np.asarray([image[finite] for image in images], np.float64)
    truth = reference.image[finite].astype(np.float64)
    mean, variance = stack.mean(axis=0), stack.var(axis=0, ddof=1)
    bias = (mean - truth) ** 2 - variance / len(images) - reference.variance[finite]
    scale = relative_scale(truth)
    return Parts(
        noise_mse=float(variance.mean()),
        noise_relmse=float((variance.mean(axis=1) / scale).mean()),
        bias_mse=float(bias.mean()),
        bias_relmse=float((bias.mean(axis=1) / scale).mean()),
    )


@dataclass(frozen=True, slots=True)
class Interval:
    """A value and half the width of its interval; the width is infinite where nothing is known of the noise."""

    value: float
    half: float

    @property
    def holds_zero(self) -> bool:
        return abs(self.value) <= self.half


def total_difference(a: Sequence[Image], b: Sequence[Image], confidence: float = 0.95) -> Interval:
    """Difference of the image means of A and B over B's, from independent renders of each; 0.01 = 1 %.

    Welch's interval: it takes the renders' means as independent and normal, and nothing of their pixels. ValueError
    without a render of each.
    """
    if not a or not b:
        raise ValueError('a difference needs a picture of each')
    means_a, means_b = (
        np.array([np.mean(np.nan_to_num(part), dtype=np.float64) for part in parts]) for parts in (a, b)
    )
    scale = abs(float(means_b.mean())) or 1.0
    value = float(means_a.mean() - means_b.mean()) / scale
    if len(means_a) < 2 or len(means_b) < 2:
        return Interval(value, math.inf)
    parts = [(means.var(ddof=1) / len(means), len(means) - 1) for means in (means_a, means_b)]
    variance = sum(part for part, _ in parts)
    if variance == 0.0:
        return Interval(value, 0.0)
    freedom = variance**2 / sum(part**2 / n for part, n in parts)
    return Interval(value, student_t(confidence, freedom) * math.sqrt(variance) / scale)


def student_t(confidence: float, freedom: float) -> float:
    """The t beyond which on either side Student's distribution holds 1 − confidence.

    With t = √ν tan θ its density becomes cos^(ν−1) θ, which is integrated by the trapezoidal rule.
    """
    theta = np.linspace(0.0, math.pi / 2, 100_001)
    density = np.cos(theta) ** (freedom - 1.0)
    inner = np.concatenate(([0.0], np.cumsum((density[1:] + density[:-1]) / 2)))
    return math.sqrt(freedom) * math.tan(float(np.interp(confidence, inner / inner[-1], theta)))


# ---- The same seeds with two settings.

# Of a normal distribution, on either side: 97 %. Of 200 pilots of box_room, whose pixels differ by a skewness of 9,
# intervals with 1.96 (95 %) held the truth 179 times, with this 185 times, and those of a plain normal mean 166 times.
SIGMAS = 2.2
# Of 200 pilots each, with the first bounce alone left, intervals without the noise of single seeds held the truth 170
# times on material_grid and 172 on three_lights, with it 190 and 196 times; on box_room, where more pixels than these
# make the estimate, 194 times either way.
SURE_PIXELS = 100.0


@dataclass(frozen=True, slots=True)
class Paired:
    """Root mean square over the pixels of the difference of two converged pictures, as a share of the mean.

    value: the estimate. low, high: its interval of 95 %. pixels: how many make it, see `effective_number`.
    """

    value: float
    low: float
    high: float
    pixels: float


def check_seeds(pictures: NDArray[np.floating]) -> None:
    """(K, P, 3): two seeds at least."""
    if pictures.ndim != 3 or pictures.shape[2] != 3 or pictures.shape[0] < 2:
        raise ValueError(f'pictures of two seeds at least are needed, (K, P, 3), not {pictures.shape}')


def paired_difference(a: NDArray[np.floating], b: NDArray[np.floating], mean: float) -> Paired:
    """How far the converged pictures of two settings are apart, from renders (K, P, 3) of both with the same K seeds.

    What noise the two share falls out with a - b = D. Of what is left, products of different seeds have no bias: with
    K independent D of a pixel, the mean of D_i D_j over i != j expects the square of their common mean (a U-statistic:
    Hoeffding 1948). Its interval is that of a mean over pixels that stand for the whole picture's: `mean_interval`.

    What one seed alone met is in no product, though it may be there always: where light is rare, the products of all
    pixels may be small together, and look sure. Where fewer than SURE_PIXELS make the estimate, its upper end is no
    lower than by the noise of the D, which one seed is enough to show: with a variance v, products vary by
    2 v² / (K (K - 1)) + 4 m² v / K around m².

    Raises ValueError where the shapes are not alike, or the mean is not positive.
    """
    check_seeds(a)
    if a.shape != b.shape or not mean > 0.0:
        raise ValueError(f'pictures of one shape and a positive mean are needed, not {a.shape}, {b.shape} and {mean}')
    d = (a - b) / mean
    count = len(d)
    products = (d.sum(axis=0) ** 2 - (d**2).sum(axis=0)) / (count * (count - 1))
    squares = products.mean(axis=1)
    value = float(squares.mean())
    low, high = mean_interval(squares)
    pixels = effective_number(squares)
    if pixels < SURE_PIXELS:
        noise = d.var(axis=0, ddof=1).mean(axis=1)
        varies = 2.0 * noise**2 / (count * (count - 1)) + 4.0 * np.maximum(squares, 0.0) * noise / count
        high = max(high, value + SIGMAS * math.sqrt(float(varies.mean()) / len(varies)))
    return Paired(*(math.sqrt(max(part, 0.0)) for part in (value, low, high)), pixels=pixels)


def effective_number(values: NDArray[np.floating]) -> float:
    """How many equal values would be as sure a sum (Kish 1965, effective sample size); all of them where all are 0."""
    squares = float((values**2).sum())
    return float(np.abs(values).sum()) ** 2 / squares if squares > 0.0 else float(len(values))


def mean_interval(values: NDArray[np.floating]) -> tuple[float, float]:
    """About 95 % of the mean of skewed values; infinite for a single one.

    Where a few values are far above all others, a mean that lacks some of them is low, and so is its deviation. Hall's
    transformation takes the skewness out of the quotient of the two (Hall 1992, "On the removal of skewness by
    transformation").
    """
    count, mean = len(values), float(np.mean(values))
    if count < 2:
        return -math.inf, math.inf
    deviation = float(np.std(values, ddof=1))
    if deviation == 0.0:
        return mean, mean
    skew = float((((values - mean) / deviation) ** 3).mean())

    def quotient(z: float) -> float:
        q = z / math.sqrt(count)
        if abs(skew) < 1e-6:
            return q
        return 3.0 / skew * (math.cbrt(1.0 + skew * (q - skew / (6.0 * count))) - 1.0)

    return mean - deviation * quotient(SIGMAS), mean - deviation * quotient(-SIGMAS)


# ---- FLIP.


def has_flip() -> bool:
    """Whether the package flip-evaluator is installed; Blender's own Python has none."""
    return importlib.util.find_spec('flip_evaluator') is not None


def flip(image: Image, reference: Image) -> tuple[float, NDArray[np.float32]]:
    """Mean and map (h, w) of HDR-FLIP, from 0 to 1, at its authors' viewing distance; bad pixels count as black.

    The exposures are chosen by the lit pixels of the reference alone, so that figures against one reference can be
    compared; a black one is shown as it is (LDR). The noise of the reference is not subtracted. ImportError without the
    package (`has_flip`).
    """
    # Its threads would spin while they wait, on a machine that renders.
    os.environ.setdefault('OMP_WAIT_POLICY', 'passive')
    import flip_evaluator

    check_pair(image, reference)
    truth, test = (
        np.ascontiguousarray(np.nan_to_num(picture, posinf=0.0, neginf=0.0).clip(min=0.0), np.float32)
        for picture in (reference, image)
    )
    lit = truth[truth.any(axis=2)]
    dynamic, exposures = 'HDR' if len(lit) else 'LDR', {}
    if 0 < len(lit) <= truth.shape[0] * truth.shape[1] // 2:  # the median, which sets the last exposure, would be black
        row = np.ascontiguousarray(lit[None])
        chosen = flip_evaluator.evaluate(row, row, 'HDR', applyMagma=False, computeMeanError=False)[2]
        exposures = {name: chosen[name] for name in ('startExposure', 'stopExposure', 'numExposures')}
    shown, mean, _ = flip_evaluator.evaluate(truth, test, dynamic, applyMagma=False, parameters=exposures)
    return float(mean), np.asarray(shown, np.float32).reshape(truth.shape[:2])


# ---- Error against samples or time.


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """error = factor · samples^−slope."""

    factor: float
    slope: float

    def error(self, samples: float) -> float:
        return self.factor * samples**-self.slope

    def samples(self, error: float) -> float:
        """Samples at which the error is reached."""
        return float((self.factor / error) ** (1 / self.slope))


def fit_power_law(samples: Sequence[float], errors: Sequence[float]) -> PowerLaw:
    """Least squares in logarithms; the slope of plain Monte Carlo is 1, that of low-discrepancy samples may be greater.

    Raises ValueError where fewer than two sample counts with a positive error are there or the error hardly falls.
    """
    points = [(n, e) for n, e in zip(samples, errors, strict=True) if n > 0 and e > 0 and np.isfinite(e)]
    if len({n for n, _ in points}) < 2:
        raise ValueError(f'a fit needs two sample counts with a positive error, not {points}')
    x, y = np.log(np.array(points, dtype=np.float64)).T
    slope, intercept = np.polyfit(x, y, 1)
    if slope > -LEAST_SLOPE:
        told = ', '.join(f'{e:.2e} with {n}' for n, e in points)
        raise ValueError(f'the error does not fall with the samples: {told}')
    return PowerLaw(factor=float(np.exp(intercept)), slope=float(-slope))


# ---- The same image.


def tile_means(image: Image, tile: int = TILE) -> NDArray[np.float64]:
    """Mean of each tile, (rows, columns, channels); tiles at the right and lower edge may be smaller."""
    rows = np.arange(0, image.shape[0], tile)
    columns = np.arange(0, image.shape[1], tile)
    sums = np.add.reduceat(np.add.reduceat(image.astype(np.float64), rows, axis=0), columns, axis=1)
    return sums / tile_sizes(image.shape[0], image.shape[1], tile)[..., None]


def tile_sizes(height: int, width: int, tile: int = TILE) -> NDArray[np.int64]:
    """Number of pixels in each tile."""
    heights = np.minimum(tile, height - np.arange(0, height, tile))
    widths = np.minimum(tile, width - np.arange(0, width, tile))
    return np.outer(heights, widths)


@dataclass(frozen=True, slots=True)
class SameImage:
    """How far image A is from image B, tile by tile. Differences are relative to B, signed, 0.01 = 1 %.

    total:       difference of the image means over all channels.
    within:      share of tiles within `limit`.
    beyond_noise:share of tiles outside `limit` by more than NOISE_SIGMAS standard deviations of the known noise; a tile
                 outside `limit` that is not counted here may be there for noise alone.
    worst:       the tile with the greatest difference: (difference, x, y), the pixel of its upper left corner.
    noise:       median standard deviation of a tile's difference, from the reference halves; 0 if not known.
    total_noise: standard deviation of `total`.
    dark:        share of tiles below the floor, compared absolutely.
    bad:         pixels with NaN or infinity in either image; they count as black in both.
    tiles:       the signed difference of each tile, (rows, columns), of the channel where it is greatest.
    """

    limit: float
    total: float
    within: float
    beyond_noise: float
    worst: tuple[float, int, int]
    noise: float
    total_noise: float
    dark: float
    bad: int
    tiles: NDArray[np.float64]

    def holds(self, share: float = 0.99, total: float = 0.003) -> bool:
        return self.bad == 0 and self.within >= share and abs(self.total) <= total


def same_image(a: Reference, b: Reference, limit: float = 0.01, tile: int = TILE) -> SameImage:
    """Compare two converged images by the means of their tiles.

    A tile's difference is that of the channel where it is greatest, over the tile's mean over all channels of B (over
    TILE_FLOOR · image mean where the tile is darker): a wrong hue counts, a channel that is nearly black does not.
    Pixels are taken as independent, which is exact for pixel filters that are sampled, where pixels share no samples.
    """
    check_pair(a.image, b.image)
    finite = np.isfinite(a.image).all(axis=2, keepdims=True) & np.isfinite(b.image).all(axis=2, keepdims=True)
    image_a, image_b = np.where(finite, a.image, 0.0), np.where(finite, b.image, 0.0)
    variance = np.where(finite, a.variance + b.variance, 0.0)

    mean_b = float(image_b.mean())
    means_b = tile_means(image_b, tile)
    brightness = np.abs(means_b.mean(axis=2))
    floor = TILE_FLOOR * abs(mean_b)
    scale = np.maximum(brightness, floor)
    scale = np.where(scale > 0, scale, 1.0)[..., None]
    difference = (tile_means(image_a, tile) - means_b) / scale
    count = tile_sizes(image_b.shape[0], image_b.shape[1], tile)[..., None]
    deviation = np.sqrt(tile_means(variance, tile) / count) / scale

    channel = np.abs(difference).argmax(axis=2)[..., None]
    signed = np.take_along_axis(difference, channel, axis=2)[..., 0]
    beyond = (np.abs(difference) - NOISE_SIGMAS * deviation > limit).any(axis=2)
    y, x = np.unravel_index(np.abs(signed).argmax(), signed.shape)
    return SameImage(
        limit=limit,
        total=float((image_a.mean() - mean_b) / (mean_b or 1.0)),
        within=float((np.abs(signed) <= limit).mean()),
        beyond_noise=float(beyond.mean()),
        worst=(float(signed[y, x]), int(x) * tile, int(y) * tile),
        noise=float(np.median(deviation)),
        total_noise=float(np.sqrt(variance.sum()) / variance.size / (abs(mean_b) or 1.0)),
        dark=float((brightness < floor).mean()),
        bad=int((~finite).sum()),
        tiles=signed,
    )


def time_at_error(
    samples: list[int], errors: list[float], seconds: float, at: int, error: float
) -> tuple[float, float]:
    """Seconds and samples to reach `error`, by the fitted law; `seconds` is what `at` samples take, time ∝ samples."""
    needed = fit_power_law(samples, errors).samples(error)
    return seconds * needed / at, needed
