# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's measures on images whose error is known. No render and no Blender here."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
import metrics
from metrics import Reference


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
