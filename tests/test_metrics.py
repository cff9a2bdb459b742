# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's measures on images whose error is known. No render and no Blender here."""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra import metrics
from cotorra.metrics import Reference


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def grey(value: float = 1.0, height: int = 64, width: int = 96) -> np.ndarray:
    return np.full((height, width, 3), value, np.float32)


def test_error_of_equal_images_is_zero() -> None:
    error = metrics.image_error(grey(), Reference.from_image(grey()))
    assert (error.mse, error.relmse, error.trimmed, error.bad) == (0.0, 0.0, 0.0, 0)


def test_error_of_a_known_offset() -> None:
    error = metrics.image_error(grey(2.2), Reference.from_image(grey(2.0)))
    assert error.mse == pytest.approx(0.04, rel=1e-5)
    assert error.relmse == pytest.approx(0.04 / (4 + 0.04), rel=1e-5)


def test_relative_error_does_not_depend_on_exposure(rng: np.random.Generator) -> None:
    truth = rng.uniform(0.0, 3.0, (64, 64, 3))
    image = truth + rng.normal(0, 0.1, truth.shape)
    one = metrics.image_error(image, Reference.from_image(truth))
    bright = metrics.image_error(image * 1000, Reference.from_image(truth * 1000))
    assert bright.relmse == pytest.approx(one.relmse)
    assert bright.mse == pytest.approx(one.mse * 1e6)


def test_trimmed_error_leaves_fireflies_out(rng: np.random.Generator) -> None:
    truth = grey(1.0, 100, 100).astype(np.float64)
    image = truth + rng.normal(0, 0.1, truth.shape)
    clean = metrics.image_error(image, Reference.from_image(truth))
    image[3, 4] = 1e4
    dirty = metrics.image_error(image, Reference.from_image(truth))
    assert dirty.relmse > 100 * clean.relmse
    assert dirty.trimmed == pytest.approx(clean.trimmed, rel=0.01)


def test_noise_of_the_reference_is_subtracted(rng: np.random.Generator) -> None:
    truth = np.ones((200, 200, 3))

    def render(deviation: float) -> np.ndarray:
        return truth + rng.normal(0, deviation, truth.shape)

    halves = Reference.from_halves(render(0.1), render(0.1))
    assert halves.variance.mean() == pytest.approx(0.1**2 / 2, rel=0.02)
    error = metrics.image_error(render(0.2), halves)
    # 120,000 values: a mean of their squares is known to sqrt(2/120000) = 0.4 %, so 2 % is more than 4 sigma of either.
    assert error.mse == pytest.approx(0.04, rel=0.02)
    assert error.residual == pytest.approx(0.005 / 1.01, rel=0.02)


def test_bad_pixels_are_counted_and_left_out() -> None:
    image = grey()
    image[0, 0, 1], image[5, 5, 2] = np.nan, np.inf
    error = metrics.image_error(image, Reference.from_image(grey()))
    assert (error.mse, error.bad) == (0.0, 2)
    assert np.isnan(metrics.image_error(grey(np.nan), Reference.from_image(grey())).mse)


def test_black_reference_is_compared_absolutely() -> None:
    assert metrics.image_error(grey(0.5), Reference.from_image(grey(0.0))).relmse == pytest.approx(0.25)


def test_shapes_must_agree() -> None:
    with pytest.raises(ValueError, match=r'\(64, 96, 3\) and \(64, 95, 3\)'):
        metrics.image_error(grey(), Reference.from_image(grey(width=95)))


@pytest.mark.parametrize('slope', [0.5, 1.0, 1.7])
def test_power_law_is_found(slope: float) -> None:
    counts = [4, 16, 64]
    law = metrics.fit_power_law(counts, [3 * n**-slope for n in counts])
    assert (law.factor, law.slope) == (pytest.approx(3), pytest.approx(slope))
    assert law.samples(law.error(37)) == pytest.approx(37)


@pytest.mark.parametrize(
    'counts, errors',
    [
        ([16], [0.1]),
        ([16, 16], [0.1, 0.1]),
        ([4, 16], [0.1, 0.2]),
        ([4, 16], [0.1, 0.09]),
        ([4, 16], [0.1, -1e-9]),
    ],
)
def test_power_law_refuses_what_it_cannot_fit(counts: list[int], errors: list[float]) -> None:
    with pytest.raises(ValueError, match=r'fit needs|does not fall'):
        metrics.fit_power_law(counts, errors)


def test_time_at_error() -> None:
    # Error 8/n; 64 samples take 2 s; error 0.25 needs 32 samples.
    seconds, samples = metrics.time_at_error([16, 64], [0.5, 0.125], 2.0, 64, 0.25)
    assert (seconds, samples) == (pytest.approx(1.0), pytest.approx(32))


def test_tile_means_with_partial_tiles(rng: np.random.Generator) -> None:
    image = rng.uniform(0, 1, (40, 50, 3))
    means, sizes = metrics.tile_means(image), metrics.tile_sizes(40, 50)
    assert means.shape == (3, 4, 3)
    assert sizes.tolist() == [[256, 256, 256, 32], [256, 256, 256, 32], [128, 128, 128, 16]]
    assert means[1, 2] == pytest.approx(image[16:32, 32:48].mean(axis=(0, 1)))
    assert means[2, 3] == pytest.approx(image[32:, 48:].mean(axis=(0, 1)))


def test_same_image_finds_one_brighter_tile() -> None:
    image = grey(2.0)
    image[16:32, 48:64] *= 1.02
    same = metrics.same_image(Reference.from_image(image), Reference.from_image(grey(2.0)))
    assert same.within == pytest.approx(23 / 24)
    assert same.worst == (pytest.approx(0.02, rel=1e-4), 48, 16)
    assert same.total == pytest.approx(0.02 / 24, rel=1e-4)
    assert same.beyond_noise == pytest.approx(1 / 24)
    assert not same.holds()
    assert same.holds(share=0.95)


def test_same_image_sees_a_wrong_hue() -> None:
    image = grey()
    image[..., 0] += 0.02
    image[..., 2] -= 0.02
    same = metrics.same_image(Reference.from_image(image), Reference.from_image(grey()))
    assert abs(same.total) < 1e-6
    assert same.within == 0.0


def test_same_image_compares_dark_tiles_absolutely() -> None:
    truth = grey()
    truth[:16, :16] = 1e-5
    image = truth.copy()
    image[:16, :16] = 1.5e-5
    same = metrics.same_image(Reference.from_image(image), Reference.from_image(truth))
    assert same.dark == pytest.approx(1 / 24)
    assert same.within == 1.0


def test_same_image_tells_noise_from_difference(rng: np.random.Generator) -> None:
    truth = np.ones((320, 320, 3))

    def render() -> np.ndarray:
        return truth + rng.normal(0, 0.5, truth.shape)

    a, b = Reference.from_halves(render(), render()), Reference.from_halves(render(), render())
    same = metrics.same_image(a, b)
    # Each half has sigma 0.5, each mean 0.354, the difference 0.5; over 256 pixels of one channel 0.03125.
    assert same.noise == pytest.approx(0.5 / 16, rel=0.02)
    assert same.total_noise == pytest.approx(0.5 / np.sqrt(truth.size), rel=0.02)
    assert same.within < 0.5
    assert same.beyond_noise == 0.0
    brighter = Reference(a.image * 1.2, a.variance)
    assert metrics.same_image(brighter, b).beyond_noise > 0.95


def test_same_image_counts_bad_pixels() -> None:
    image = grey()
    image[2, 3] = np.nan
    same = metrics.same_image(Reference.from_image(image), Reference.from_image(grey()))
    assert same.bad == 1
    assert same.within == 1.0
    assert not same.holds()


def test_rmse_is_the_root_of_the_mse() -> None:
    assert metrics.image_error(grey(2.2), Reference.from_image(grey(2.0))).rmse == pytest.approx(0.2, rel=1e-5)
    halves = Reference(grey().astype(np.float64), np.full((64, 96, 3), 1.0))
    assert metrics.image_error(grey(), halves).rmse == 0.0, 'the noise of the reference explains more than there is'


def test_a_reference_of_parts(rng: np.random.Generator) -> None:
    parts = [np.ones((100, 100, 3)) + rng.normal(0, 0.4, (100, 100, 3)) for _ in range(8)]
    reference = Reference.from_parts(parts)
    # 30,000 variances of 7 degrees of freedom: their mean is known to sqrt(2 / 7 / 30000) = 0.3 %.
    assert reference.variance.mean() == pytest.approx(0.16 / 8, rel=0.02)
    with pytest.raises(ValueError, match='needs a picture'):
        Reference.from_parts([])
    with pytest.raises(ValueError, match='one shape'):
        Reference.from_parts([grey(), grey(height=32)])


def test_the_error_map_is_what_relmse_is_made_of(rng: np.random.Generator) -> None:
    truth = rng.uniform(0.0, 3.0, (64, 64, 3))
    image = truth + rng.normal(0, 0.1, truth.shape)
    reference = Reference.from_image(truth)
    shown = metrics.error_map(image, reference)
    assert np.mean(shown**2) == pytest.approx(metrics.image_error(image, reference).relmse)
    image[3, 4, 1] = np.nan
    assert np.isnan(metrics.error_map(image, reference)[3, 4])
    assert np.isfinite(metrics.error_map(image, reference)).sum() == 64 * 64 - 1


def test_noise_and_bias_are_told_apart(rng: np.random.Generator) -> None:
    truth = np.ones((200, 200, 3))

    def render(bias: float, deviation: float) -> np.ndarray:
        return truth + bias + rng.normal(0, deviation, truth.shape)

    reference = Reference.from_parts([render(0.0, 0.2) for _ in range(4)])
    parts = metrics.noise_and_bias([render(0.05, 0.3), render(0.05, 0.3)], reference)
    # 120,000 values: the noise is known to 0.4 %, the bias of 0.0025 to 0.0025·0.3·… = 1.9e-4 (its terms' deviation,
    # 0.065, over sqrt(120000)); four sigma each.
    assert parts.noise_mse == pytest.approx(0.09, rel=0.016)
    assert parts.noise_relmse == pytest.approx(0.09 / 1.01, rel=0.016)
    assert parts.bias_mse == pytest.approx(0.0025, abs=7.6e-4)
    none = metrics.noise_and_bias([render(0.0, 0.3), render(0.0, 0.3)], reference)
    assert abs(none.bias_mse) < 7.6e-4
    with pytest.raises(ValueError, match='two renders'):
        metrics.noise_and_bias([truth], reference)


def test_quantiles_of_student() -> None:
    # ν = 1: tan(π c / 2); ν = 2: c sqrt(2 / (1 − c²)); ν → ∞: the normal distribution's.
    assert metrics.student_t(0.95, 1) == pytest.approx(np.tan(0.95 * np.pi / 2), rel=1e-4)
    assert metrics.student_t(0.95, 2) == pytest.approx(0.95 * np.sqrt(2 / (1 - 0.95**2)), rel=1e-4)
    assert metrics.student_t(0.95, 1e6) == pytest.approx(NormalDist().inv_cdf(0.975), rel=1e-3)


@pytest.mark.parametrize('parts', [2, 4])
def test_intervals_of_the_difference_cover_it(parts: int) -> None:
    """Of 2000 intervals of 95 % as many hold the difference as they say. Noise correlates between pixels here."""
    rng = np.random.default_rng(parts)

    def renders(mean: float, deviation: float) -> list[np.ndarray]:
        return [np.full((2, 2, 3), mean * (1 + rng.normal(0, deviation))) for _ in range(parts)]

    held = 0
    for _ in range(2000):
        found = metrics.total_difference(renders(1.02, 0.01), renders(1.0, 0.01))
        held += abs(found.value - 0.02) <= found.half
    # Binomial: deviation 0.5 %. Welch's interval is wider than need be for two parts: its freedom is estimated.
    assert 0.935 <= held / 2000 <= (0.995 if parts == 2 else 0.97)


def test_a_single_render_says_nothing_of_its_noise() -> None:
    found = metrics.total_difference([grey(1.02)], [grey(), grey()])
    assert found.value == pytest.approx(0.02, rel=1e-4) and found.half == np.inf


@pytest.mark.skipif(not metrics.has_flip(), reason='flip-evaluator is not installed')
def test_flip(rng: np.random.Generator) -> None:
    truth = rng.uniform(0.1, 1.0, (48, 64, 3)).astype(np.float32)
    mean, shown = metrics.flip(truth, truth)
    assert mean == 0.0 and shown.shape == (48, 64) and not shown.any()
    less, more = (metrics.flip(truth + rng.normal(0, s, truth.shape), truth)[0] for s in (0.02, 0.1))
    assert 0.0 < less < more < 1.0
    wrong = truth.copy()
    wrong[10:20, 10:20] *= 3.0
    mean, shown = metrics.flip(wrong, truth)
    assert shown[15, 15] > 10 * shown[40, 50] and mean == pytest.approx(shown.mean(), rel=1e-3)
    # Black around a picture changes the mean by the share that it takes, and no exposure.
    framed = metrics.flip(np.pad(wrong, ((0, 96), (0, 0), (0, 0))), np.pad(truth, ((0, 96), (0, 0), (0, 0))))
    assert framed[0] == pytest.approx(mean / 3, rel=0.1)
    black = np.zeros((8, 8, 3), np.float32)
    assert metrics.flip(black, black)[0] == 0.0
    assert np.isfinite(metrics.flip(np.full((8, 8, 3), np.nan), truth[:8, :8])[0])


@pytest.mark.parametrize(('spread', 'least'), [(0.0, 0.95), (2.5, 0.87)])
def test_the_interval_of_a_skewed_mean(spread, least):
    """400 means of 1,000 values: normal ones, of which 2.2 deviations hold 97 %, and log-normal ones (a skewness of 16
    in the samples), of which a plain interval held 78 % and this one 92 % when the bound was set; three deviations of
    that count are 4 %."""
    chance = np.random.default_rng(6)
    held = plain = 0
    for _ in range(400):
        values = chance.lognormal(0.0, spread, 1000) if spread else chance.normal(1.0, 1.0, 1000)
        truth = float(np.exp(spread**2 / 2))
        low, high = metrics.mean_interval(values)
        held += low <= truth <= high
        plain += abs(values.mean() - truth) <= metrics.SIGMAS * values.std(ddof=1) / 1000**0.5
    assert held / 400 >= least and (spread == 0.0 or held > plain + 24), (held, plain)
    assert metrics.mean_interval(np.ones(5)) == (1.0, 1.0)
    assert metrics.mean_interval(np.ones(1)) == (-np.inf, np.inf)
