# SPDX-License-Identifier: GPL-3.0-or-later
"""What integrator AUTO decides, on made-up figures: no scene, no render, no Blender.

Renders that it decided on are test_auto.py's.
"""

from __future__ import annotations

import numpy as np
import pytest
from cotorra.auto import measure, plan
from cotorra.auto.measure import Noise, few
from cotorra.auto.plan import LIMITS, Probe, Sampling, Search, Spent
from cotorra.metrics import Paired, paired_difference

TOLERANCE = 0.01
LIMITS_SET = dict(zip(LIMITS, (12, 4, 4, 12, 8), strict=True))


def pictures(chance: np.random.Generator, truth: np.ndarray, noise: float, seeds: int = 4) -> np.ndarray:
    return truth + noise * chance.standard_normal((seeds, *truth.shape))


# ---- Measures


def test_the_interval_holds_the_difference_as_often_as_it_says():
    """Of 400 pairs of noisy pictures, those of one pair sharing half of their noise. With the right deviation, 95 % of
    the intervals hold; beyond four deviations of that count (1.1 % each) the interval is wrong."""
    chance = np.random.default_rng(1)
    truth = np.full((1024, 3), 0.5)
    other = truth * (1.0 + 0.02 * chance.standard_normal((1024, 1)))
    # The mean that an average choice of pixels has: the pixels are a sample of the picture's.
    wanted, held = 0.02, 0
    for _ in range(400):
        other = truth * (1.0 + 0.02 * chance.standard_normal((1024, 1)))
        shared = pictures(chance, np.zeros((1024, 3)), 0.05)
        a, b = (shared + pictures(chance, part, 0.05) for part in (truth, other))
        found = paired_difference(a, b, 0.5)
        held += found.low <= wanted <= found.high
    assert 0.95 - 4 * 0.011 <= held / 400 <= 0.95 + 4 * 0.011


def test_the_interval_holds_where_light_is_rare():
    """Of 200 pairs whose difference is made by few of its samples (logarithms of a deviation of 2.5, and of 0.7 from
    pixel to pixel): products of seeds miss most of it, and intervals by their spread alone held 169 times."""
    chance = np.random.default_rng(6)
    nothing, held = np.zeros((4, 1024, 3)), 0
    for _ in range(200):
        pixels = np.exp(0.7 * chance.standard_normal(1024) - 0.49)
        seen = pixels * np.exp(2.5 * chance.standard_normal((8, 4, 1024)) - 3.125).mean(axis=0)
        found = paired_difference(np.repeat(seen[..., None], 3, axis=2), nothing, 1.0)
        held += found.low <= 1.0 <= found.high
    assert held >= 190 - 4 * 3.1  # four deviations of the count


def test_noise_alone_makes_no_difference():
    """The mean of 100 estimates of a squared difference that is 0: within four deviations of 0, which a plain mean of
    squares, 0.02 here, is not."""
    chance = np.random.default_rng(2)
    truth = np.full((256, 3), 1.0)
    squares = []
    for _ in range(100):
        a, b = pictures(chance, truth, 0.1), pictures(chance, truth, 0.1)
        d = a - b
        squares.append(float(((d.sum(axis=0) ** 2 - (d**2).sum(axis=0)) / 12).mean()))
        assert paired_difference(a, b, 1.0).value == pytest.approx(max(squares[-1], 0.0) ** 0.5)
    assert abs(np.mean(squares)) < 4 * np.std(squares) / 10


def test_what_is_small_and_bright_is_seen_between_the_pixels():
    """One sample of one seed that met it is enough; what is below the tolerance, or everywhere, is another matter."""
    quiet = np.ones((4, 1024, 3))
    spark = quiet.copy()
    spark[2, 77] += 40.0
    assert measure.seen_between(quiet, spark, 1.0, 0.01)
    spark[2, 77] = 2.0
    assert not measure.seen_between(quiet, spark, 1.0, 0.01)
    assert not measure.seen_between(quiet, quiet + 0.1, 1.0, 0.01)


def test_noise_of_one_sample_from_pictures_of_several():
    chance = np.random.default_rng(3)
    found = measure.noise(pictures(chance, np.full((4096, 3), 0.25), 0.1 / 4.0, 8), 16, 0.25)
    one = np.ones(4096)
    assert found.after(one).mean() == pytest.approx((0.1 / 0.25) ** 2, rel=0.02)
    # film_error of one sample: sqrt(2 / pi) of the deviation, three channels, over the root of their sum.
    error = (2.0 / np.pi) ** 0.5 * 3 * 0.1 / 0.75**0.5
    assert np.sqrt(found.samples_to(1.0)).mean() == pytest.approx(error, rel=0.01)
    assert not found.dominated and found.slope == 1.0


@pytest.mark.parametrize(('power', 'told'), [(0.5, 1.0), (1.0, 1.0), (1.25, 1.25), (2.0, measure.STEEPEST)])
def test_how_fast_noise_falls_is_seen_between_two_numbers_of_samples(power, told):
    """No faster than edges do, and no slower than independent samples."""
    chance = np.random.default_rng(4)
    truth = np.full((4096, 3), 1.0)
    few, many = (pictures(chance, truth, 0.3 * count ** (-0.5 * power), 8) for count in (4, 64))
    found = measure.noise(many, 64, 1.0, (few, 4))
    assert found.slope == pytest.approx(told, abs=0.02)
    more = found.after(np.full(4096, 256.0)).mean() / found.variance.mean()
    assert more == pytest.approx(4.0**-found.slope)
    samples = found.samples_to(1e-3)
    back = found.error * (samples / 64.0) ** (-0.5 * found.slope)
    assert back == pytest.approx(np.full(4096, 1e-3))


def test_fireflies_tell_no_slope():
    chance = np.random.default_rng(5)
    few, many = (pictures(chance, np.full((256, 3), 1.0), noise) for noise in (1e-3, 1e-4))
    few[0, 3] += 10.0
    assert measure.noise(many, 64, 1.0, (few, 4)).slope == 1.0


def test_a_few_pixels_dominate():
    """Fireflies: 2 of 1,024 pixels that hold most of it."""
    quiet = np.zeros((4, 1024, 3))
    loud = quiet.copy()
    loud[:, 100] = 5.0
    loud[:, 200] = -5.0
    found = paired_difference(quiet, loud, 1.0)
    assert few(found) and found.pixels == pytest.approx(2.0)
    even = paired_difference(quiet, quiet + 0.1, 1.0)
    assert even.pixels == pytest.approx(1024.0) and not few(even)
    assert even.value == pytest.approx(0.1)


@pytest.mark.parametrize('shape', [(1, 5, 3), (4, 5), (4, 5, 4)])
def test_pictures_of_another_shape_are_refused(shape):
    with pytest.raises(ValueError, match='seeds'):
        measure.noise(np.zeros(shape), 4, 1.0)
    with pytest.raises(ValueError):
        paired_difference(np.zeros((2, 5, 3)), np.zeros((2, 6, 3)), 1.0)
    with pytest.raises(ValueError, match='positive'):
        paired_difference(np.zeros((2, 5, 3)), np.zeros((2, 5, 3)), 0.0)


# ---- Budget


@pytest.mark.parametrize('size', [(320, 180), (1920, 1080), (64, 64), (4000, 20), (1, 3000)])
@pytest.mark.parametrize('samples', [1, 16, 64, 1024, 65536])
def test_a_pilot_takes_no_more_than_its_share(size, samples):
    found = plan.budget(*size, samples)
    whole = size[0] * size[1] * samples
    fewest = plan.SEARCH_MIN * plan.SEEDS * (plan.SETTINGS + plan.BETWEEN + plan.VERIFIED * plan.VERIFIED_WEIGHT)
    if found is None:
        assert plan.PILOT_SHARE * whole < 1.1 * fewest * plan.PIXELS
        return
    pixels = found.width * found.height
    pictures = (plan.SETTINGS + plan.BETWEEN) * found.search + plan.VERIFIED * found.verify
    spent = plan.SEEDS * pixels * pictures
    assert spent <= found.paths <= 0.05 * whole
    assert found.search >= plan.SEARCH_MIN and 1 <= found.width <= size[0] and 1 <= found.height <= size[1]


# ---- Limits


def made_up(needed: dict[str, float], high: float = 1.2, share: dict[str, float] | None = None):
    """A probe of a scene in which each limit below `needed` makes 3 % of difference, and saves rays."""

    def probe(limits: dict[str, int]) -> Probe:
        value = 0.03 if any(limits[name] < least for name, least in needed.items()) else 0.004
        rays = 1.0 - sum(
            (share or dict.fromkeys(LIMITS, 0.02))[name] * (LIMITS_SET[name] - limits[name]) for name in LIMITS
        )
        return Probe(Paired(value, value / 2, value * high, 500.0), rays)

    return probe


@pytest.mark.parametrize(
    'needed',
    [(0, 0, 0, 0, 0), (3, 1, 2, 3, 4), (12, 4, 4, 12, 8), (1, 0, 1, 0, 8), (5, 3, 0, 5, 1)],
)
def test_limits_are_the_lowest_of_the_ladder_that_suffice(needed):
    wanted = dict(zip(LIMITS, needed, strict=True))
    found = Search(dict(LIMITS_SET), made_up(wanted), TOLERANCE, frozenset({*LIMITS, 'integrator'})).run()
    for name, least in wanted.items():
        enough = next((value for value in plan.LADDER if value >= least), None)
        total = found['max_bounces']
        if name in ('diffuse_bounces', 'glossy_bounces', 'transmission_bounces'):
            enough = min(enough, total)
        assert found[name] == min(enough, LIMITS_SET[name]), name


def test_what_is_switched_off_stays():
    everything = made_up(dict.fromkeys(LIMITS, 0))
    for off in LIMITS[1:]:
        allowed = frozenset({*LIMITS[1:], 'integrator'}) - {off, 'integrator'}
        search = Search(dict(LIMITS_SET), everything, TOLERANCE, allowed)
        found = search.run()
        assert found[off] == LIMITS_SET[off] and search.why(off) == 'switched off'
        assert found['max_bounces'] == LIMITS_SET['max_bounces']
        assert all(found[name] == 0 for name in LIMITS[1:] if name != off)
    search = Search(dict(LIMITS_SET), everything, TOLERANCE, frozenset(LIMITS))
    assert search.run()['max_bounces'] == 1, 'Direct is another row'
    search = Search(dict(LIMITS_SET), everything, TOLERANCE, frozenset({'integrator'}))
    assert search.run()['max_bounces'] == 0


def test_a_wide_interval_simplifies_nothing():
    search = Search(dict(LIMITS_SET), made_up(dict.fromkeys(LIMITS, 0), high=3.0), TOLERANCE, frozenset(LIMITS))
    assert search.run() == LIMITS_SET
    assert all('cannot tell' in search.why(name) for name in LIMITS)


def test_fireflies_simplify_nothing():
    def probe(limits: dict[str, int]) -> Probe:
        return Probe(Paired(0.004, 0.0, 0.008, 2.0), 0.5)

    search = Search(dict(LIMITS_SET), probe, TOLERANCE, frozenset(LIMITS))
    assert search.run() == LIMITS_SET
    assert all('a few pixels decide' in search.why(name) for name in LIMITS)


def test_what_saves_nothing_stays():
    nothing = made_up(dict.fromkeys(LIMITS, 0), share=dict.fromkeys(LIMITS, 0.0))
    search = Search(dict(LIMITS_SET), nothing, TOLERANCE, frozenset(LIMITS))
    assert search.run() == LIMITS_SET
    assert all('saves nothing' in search.why(name) for name in LIMITS)


def test_a_search_ends_where_its_paths_do():
    count = 0

    def probe(limits: dict[str, int]) -> Probe:
        nonlocal count
        count += 1
        if count > 5:
            raise Spent
        return made_up({'max_bounces': 3})(limits)

    search = Search(dict(LIMITS_SET), probe, TOLERANCE, frozenset(LIMITS))
    found = search.run()
    assert search.spent and found['max_bounces'] == 3
    assert 'too short' in search.why('transparent_bounces')


# ---- Shadow rays


def test_the_light_threshold_is_where_time_and_noise_are_least():
    """Samples of eight rays, two of which bring light of lamps (logarithms of a deviation of 1), whose noise is a
    quarter of all: half and twice the threshold are worse than what is chosen."""
    light = np.exp(np.random.default_rng(9).standard_normal(100_000))
    variance, rays = 8.0 * light.var(), 8.0

    def product(limit: float) -> float:
        chance = np.minimum(light / limit, 1.0)
        more = 2.0 * (light**2 * (1.0 / chance - 1.0)).mean()
        return (1.0 + more / variance) * (6.0 + 2.0 * chance.mean()) / rays

    limit = plan.light_threshold(variance**0.5, rays)
    assert product(limit) < min(0.97, product(0.5 * limit), product(2.0 * limit))


@pytest.mark.parametrize(
    ('rays', 'noise', 'worth'), [(0.8, 1.0, True), (0.8, 1.1, False), (0.96, 1.0, False), (1.0, 0.8, False)]
)
def test_what_random_shadow_rays_are_worth(rays, noise, worth):
    """Time for as much noise; a pilot's luck in it does not count."""
    assert plan.Shadows(0.1, rays, noise).worth == worth


def test_the_typical_deviation_is_of_one_sample():
    chance = np.random.default_rng(10)
    found = pictures(chance, np.full((4096, 3), 0.5), 0.1, 8)
    # The root of a variance of seven degrees of freedom by three channels is 1.2 % low.
    assert measure.typical(found, 16) == pytest.approx(0.4, rel=0.02)
    found[0, :4] += 100.0
    assert measure.typical(found, 16) < 0.4 * 1.5, 'a few fireflies count for little'


# ---- Samples


def even(variance: float, pixels: int = 1024) -> Noise:
    """Noise that is the same everywhere, in a picture whose mean is 1 / 3 a channel."""
    error = 0.798 * 3 * (variance**0.5 / 3.0)
    return Noise(np.full(pixels, variance), np.full(pixels, error), 1024.0)


def test_samples_are_as_few_as_the_tolerance_allows():
    """One sample's noise is 20 % of the mean, and 1 % is asked for: 400 samples, the next end of a pass being 416."""
    found = plan.sampling(Sampling(4096), even(0.04), even(0.04), 0.0, TOLERANCE)
    taken = found.work(even(0.04))
    assert 400 <= taken <= 416 and found.error(even(0.04))[1] <= TOLERANCE
    # Half of the tolerance squared is used up: twice as many.
    found = plan.sampling(Sampling(4096), even(0.04), even(0.04), 0.01 * 0.5**0.5, TOLERANCE)
    assert 800 <= found.work(even(0.04)) <= 832


def test_even_noise_above_the_tolerance_keeps_the_samples():
    assert plan.sampling(Sampling(64), even(4.0), even(4.0), 0.0, TOLERANCE) == Sampling(64)


def uneven() -> Noise:
    """A tenth of the pixels has 100 times the variance of the others."""
    variance = np.where(np.arange(1000) % 10 == 0, 10.0, 0.1)
    return Noise(variance, 0.8 * np.sqrt(variance), 300.0)


def test_uneven_noise_moves_samples_to_where_it_is():
    """Within the tolerance: noisy pixels take more samples than would be enough for all of them, the others fewer."""
    found = plan.sampling(Sampling(4096), uneven(), uneven(), 0.0, 0.05)
    alike = next(Sampling(count) for count in plan.pass_ends(4096) if Sampling(count).error(uneven())[1] <= 0.05)
    assert found.adaptive and found.error(uneven())[1] <= 0.05
    assert found.work(uneven()) <= 0.8 * alike.work(uneven())
    taken = set(found.taken(uneven()))
    assert taken <= set(plan.pass_ends(found.samples)) and min(taken) < alike.samples < max(taken) <= 4096


def test_no_pixel_is_stopped_early_where_that_adds_more_than_is_tolerated():
    assert plan.sampling(Sampling(64), uneven(), uneven(), 0.0, TOLERANCE) == Sampling(64)
    own = Sampling(512, True, 0.02)
    assert plan.sampling(own, uneven(), uneven(), 0.0, TOLERANCE) == own


def test_clean_pixels_stop_where_that_adds_less_than_the_tolerance():
    """Nine tenths have a deviation of 10 % a sample, which 128 samples leave 0.9 % of, the others 100 times that: 28 %
    in the whole. Stopped at the first look the former add 2.2 %, which is not seen beside that."""
    variance = np.where(np.arange(1000) % 10 == 0, 100.0, 0.01)
    noise = Noise(variance, 0.8 * np.sqrt(variance), 100.0)
    asked = Sampling(128)
    assert asked.error(noise)[0] == pytest.approx(0.28, rel=0.01)
    found = plan.sampling(asked, noise, noise, 0.0, 0.03)
    assert found.adaptive and found.samples == 128 and found.work(noise) < 0.3 * 128
    assert found.added(noise, asked).high <= 0.03
    assert found.error(noise)[0] == pytest.approx(asked.error(noise)[0], rel=0.02)
    assert plan.missed(found, asked, noise) == found.added(noise, asked).high
    assert plan.missed(asked, asked, noise) == 0.0
    # What the other simplifications use up is not there for it.
    assert plan.sampling(asked, noise, noise, 0.0299, 0.03) == asked


def test_what_the_sky_saves_is_little():
    """Half of the pixels show the sky, by one ray a sample; the others take two, which makes 1.5 in the mean. If the
    former stop at an eighth of the samples, an eighth of their third of the rays is left."""
    error = np.where(np.arange(1000) < 500, 0.0, 3.0)
    noise = Noise(error**2, error, 500.0, cost=measure.costs(error == 0.0, 1.5))
    assert noise.cost[0] == pytest.approx(2 / 3) and noise.cost[-1] == pytest.approx(4 / 3)
    stopped = Sampling(128, True, 1e-3, 16)
    assert stopped.work(noise) / 128 == pytest.approx(1 / 24 + 2 / 3)
    found = plan.sampling(Sampling(128), noise, noise, 0.0, 1e-4)
    assert found.adaptive and found.work(noise) == pytest.approx(stopped.work(noise))
    cheap = Noise(error**2, error, 500.0, cost=measure.costs(error == 0.0, 15.0))
    assert plan.sampling(Sampling(128), cheap, cheap, 0.0, 1e-4) == Sampling(128)


def test_fireflies_elsewhere_forbid_no_stop():
    """One pixel makes all the noise, and takes all the samples; of the others' noise the pilot is sure."""
    variance = np.where(np.arange(1000) == 7, 1e4, 0.01)
    noise = Noise(variance, 0.8 * np.sqrt(variance), 1.0)
    assert noise.dominated
    found = plan.sampling(Sampling(128), noise, noise, 0.0, 0.03)
    assert found.adaptive and found.samples == 128 and found.work(noise) < 0.2 * 128


def test_what_looks_clean_and_is_not_forbids_a_stop():
    """Light that one seed in four meets: where it is missed the pixel looks clean, and the seed that is left tells."""
    chance = np.random.default_rng(8)
    seen = pictures(chance, np.full((1024, 3), 0.3), 0.003)
    seen[chance.integers(0, 4, 1024), np.arange(1024)] += 1.0
    rare = measure.noise(seen, 4, 0.3)
    quiet = measure.noise(pictures(chance, np.full((1024, 3), 0.3), 0.003), 4, 0.3)
    asked, stopped = Sampling(128), Sampling(128, True, 0.05, 16)
    assert stopped.added(quiet, asked).high < 0.005
    assert stopped.added(rare, asked).value > 0.1
    assert plan.sampling(asked, rare, rare, 0.0, 0.03) == asked


def test_a_threshold_that_was_set_is_only_raised():
    own = Sampling(65536, True, 1e-3)
    found = plan.sampling(own, uneven(), uneven(), 0.0, 0.05)
    assert found.adaptive and found.threshold > own.threshold and found.samples == own.samples
    assert found.error(uneven())[1] <= 0.05


def test_less_noise_needs_fewer_samples():
    """Without its bounces, the picture has a fourth of the variance: a fourth of the samples leave as much noise, less
    what the difference takes."""
    found = plan.sampling(Sampling(256), even(1.0), even(4.0), 0.0, TOLERANCE)
    assert found.work(even(1.0)) == 64 and not found.adaptive
    found = plan.sampling(Sampling(256), even(1.0), even(4.0), 0.01, TOLERANCE)
    assert found.work(even(1.0)) == 96


def test_pass_ends_are_the_native_modules():
    assert plan.pass_ends(100) == [1, 2, 4, 8, 16, 32, 64, 96, 100]
    assert plan.pass_ends(1) == [1]
