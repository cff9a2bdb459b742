# SPDX-License-Identifier: GPL-3.0-or-later
"""Where integrator AUTO takes a picture's samples: on made-up noise, and in a render. How a session takes them is
test_session.py's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cotorra import demos, stats
from cotorra.auto import spread
from cotorra.export.buffers import RenderSettings

from render_calls import render_to

SHAPE = (90, 160)


def seen(
    chance: np.random.Generator, deviation: np.ndarray, first: int, power: float = 1.0, rays: float | np.ndarray = 2.0
) -> np.ndarray:
    """Differences of a picture of brightness 1 whose samples have such deviations, which fall by that power, and take
    so many rays."""
    parts = []
    for count in (first, first // 2):
        halves = deviation * count ** (-0.5 * power) * (2.0**power - 1.0) ** 0.5
        parts.append(np.abs(chance.standard_normal((*deviation.shape, 3))).mean(axis=2) * 3.0 * halves)
    return np.stack([*parts, rays * np.ones(deviation.shape)], axis=2).astype(np.float32)


def two_halves(ratio: float) -> np.ndarray:
    return np.where(np.arange(SHAPE[1]) < SHAPE[1] // 2, 1.0, ratio) * np.ones(SHAPE)


@pytest.mark.parametrize('power', [1.0, 1.5])
def test_samples_go_where_there_is_noise(power):
    """One half has eight times the deviation of the other. As many samples of each half as go with v^(1 / (1 + s))
    leave the same noise in all; for s = 1 that takes 0.62 of them, less what lies between the ends of passes."""
    deviation = two_halves(8.0)
    found = spread.spread_samples(seen(np.random.default_rng(1), deviation, 32, power), np.ones(SHAPE), 32, 128)
    variance = deviation**2
    left = (variance * found.most.astype(float) ** -power).sum() / (variance * 128.0**-power).sum()
    assert left == pytest.approx(1.0, abs=0.08)
    quiet, loud = found.most[:, :70].mean(), found.most[:, 90:].mean()
    assert 32 <= quiet < 0.5 * loud and loud <= 4 * 128
    assert 0.55 < found.share < 0.8


def test_even_noise_keeps_the_samples():
    found = spread.spread_samples(seen(np.random.default_rng(2), np.ones(SHAPE), 32), np.ones(SHAPE), 32, 100)
    assert found.share == 1.0 and (found.most == 100).all()
    found = spread.spread_samples(np.zeros((*SHAPE, 3), np.float32), np.zeros(SHAPE), 32, 100)
    assert found.share == 1.0 and (found.most == 100).all()


def test_no_pixel_decides_about_itself():
    """A firefly changes the number of its neighbours' samples, and not its own: else what it takes, and what those take
    who missed theirs, would depend on what they have, and the mean be too low."""
    quiet = seen(np.random.default_rng(3), two_halves(8.0), 32)
    loud = quiet.copy()
    loud[40, 20, :2] *= 1.5
    a, b = (spread.neighbours(part[..., 0].astype(float) ** 2, 5) for part in (quiet, loud))
    assert a[40, 20] == pytest.approx(b[40, 20], rel=1e-9) and (b[39:42, 19:22] > 1.001 * a[39:42, 19:22]).sum() == 8


def test_what_is_dear_takes_fewer_samples():
    """Two halves of the same noise, of which one takes nine times the rays: a third of the samples of the other's. By
    their number alone all would stay as it is."""
    rays = two_halves(1.0)
    rays[:, SHAPE[1] // 2 :] = 9.0
    chance = np.random.default_rng(5)
    found = spread.spread_samples(seen(chance, np.ones(SHAPE), 32, rays=rays), np.ones(SHAPE), 32, 128)
    cheap, dear = found.most[:, :70].mean(), found.most[:, 90:].mean()
    assert dear < 0.5 * cheap and dear < 128 < cheap
    # (sqrt(1) + sqrt(9))^2 / 4 of the 5 rays that a sample takes in the mean.
    assert found.share == pytest.approx(0.8, abs=0.05)
    alike = spread.spread_samples(seen(chance, np.ones(SHAPE), 32, rays=9.0), np.ones(SHAPE), 32, 128)
    assert alike.share == 1.0


@pytest.mark.parametrize('aside, reach', [(1, 0), (2, 0), (5, 0), (2, 1), (5, 2), (1, 1)])
def test_neighbours_are_those_around(aside, reach):
    values = np.random.default_rng(4).random((7, 9))
    found = spread.neighbours(values, aside, reach)
    wide = max(aside, reach + 1)

    def box(y: int, x: int, size: int) -> np.ndarray:
        return values[max(y - size, 0) : y + size + 1, max(x - size, 0) : x + size + 1]

    for y, x in ((0, 0), (3, 4), (6, 8), (2, 0)):
        near, far = box(y, x, reach), box(y, x, wide)
        assert found[y, x] == pytest.approx((far.sum() - near.sum()) / (far.size - near.size))


def test_no_pixel_decides_about_itself_where_samples_are_shared():
    """A sample counts for the pixels whose filters reach it: their noise tells of its own pixel's, too."""
    asked = RenderSettings(sharing=True)
    reaches = {1.0: 0, 1.5: 1, 2.0: 1, 2.5: 2}
    assert {width: spread.shared_reach(asked, width) for width in reaches} == reaches
    assert spread.shared_reach(replace(asked, sharing=False), 2.5) == 0
    quiet = seen(np.random.default_rng(3), two_halves(8.0), 32)
    loud = quiet.copy()
    loud[39:42, 19:22, :2] *= 8.0  # a firefly of the pixel in the middle
    a, b = (spread.spread_samples(part, np.ones(SHAPE), 32, 128, reach=1).most for part in (quiet, loud))
    own, around = (a[40, 20], b[40, 20]), (a[38:43, 18:23].sum(), b[38:43, 18:23].sum())
    assert own[0] == own[1] and around[1] > around[0]


def test_which_renders_are_spread():
    asked = RenderSettings(samples=100)
    found = spread.spreading(asked, 10000)
    assert found == replace(asked, samples=400, spread_after=16) and spread.asked_samples(found) == 100
    for other in (replace(asked, samples=12), replace(asked, adaptive=True), replace(asked, device='VULKAN')):
        assert spread.spreading(other, 10000) == other and spread.asked_samples(other) == other.samples
    assert spread.spreading(asked, 1000) == asked


@pytest.mark.usefixtures('engine')
def test_a_render_takes_its_samples_where_there_is_noise(tmp_path):
    """Through Blender: the figures tell what was taken, and no less light comes of it than of as many everywhere."""
    scene = demos.build('three_lights')
    scene.render.resolution_x, scene.render.resolution_y = 128, 72
    own = scene.cotorra
    own.samples, own.use_reweighting, own.use_denoising = 32, False, False
    rays = []
    for integrator in ('AUTO', 'PATH'):
        own.integrator = integrator
        render_to(scene, tmp_path / f'{integrator}.exr')
        layer = stats.last(scene.name)[-1]
        assert not layer.error and layer.samples == 32 and layer.progress == 1.0
        rays.append(layer.rays['camera'])
        if integrator == 'AUTO':
            found = layer.auto['spread']
            assert found['fewest'] == layer.samples_done == 8 and found['most'] > 32 and found['share'] < 0.9
    assert rays[0] < rays[1]
