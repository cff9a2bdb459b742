# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of two devices' pictures (vulkan_jobs.compare) passes what rounding does, and fails what it does not.

No graphics card takes part: the CPU's own picture, nudged or spoilt, stands for the card's.
"""

from __future__ import annotations

import numpy as np
import pytest
from cotorra import demos, native

from vulkan_jobs import NUDGES, UNEXPLAINED, Fragile, Job, compare, flips, job_of

pytestmark = pytest.mark.usefixtures('engine')


@pytest.fixture(scope='module')
def job(engine: None) -> Job:
    """Glossy bounces and edges in plenty."""
    return job_of(native.load(), demos.build('material_grid'), integrator='PATH')


@pytest.fixture(scope='module')
def cpu(job: Job) -> np.ndarray:
    return job.render('CPU')[0]['combined']


@pytest.fixture(scope='module')
def fragile(job: Job) -> Fragile:
    return job.fragile('combined')


def test_another_nudge_is_the_same_picture(job: Job, cpu: np.ndarray, fragile: Fragile) -> None:
    other = job.nudge(NUDGES, 1.0).render('CPU')[0]['combined']
    assert flips(cpu, other).any()
    compare(cpu, other, fragile, 'another nudge')


def test_few_pixels_are_fragile(job: Job, fragile: Fragile) -> None:
    """Else they would hide what is wrong."""
    assert 0.0 < fragile.mask.mean() < 0.1


def test_a_flip_needs_a_cause(cpu: np.ndarray, fragile: Fragile) -> None:
    places = np.argwhere(~fragile.mask)[:: (~fragile.mask).sum() // 7]
    assert len(places) > UNEXPLAINED * fragile.mask.size
    spoilt = cpu.copy()
    spoilt[tuple(places.T)] *= 1.01
    with pytest.raises(AssertionError, match='for no cause'):
        compare(cpu, spoilt, fragile, 'spoilt')


def test_flips_that_all_darken_move_the_mean(cpu: np.ndarray, fragile: Fragile) -> None:
    """Each to black, by which no nudge darkens them."""
    spoilt = cpu.copy()
    spoilt[fragile.mask] = 0.0
    with pytest.raises(AssertionError, match='add up to'):
        compare(cpu, spoilt, fragile, 'dark')


def test_all_pixels_a_little_brighter(cpu: np.ndarray, fragile: Fragile) -> None:
    with pytest.raises(AssertionError, match=' 0 of them for no cause'):
        compare(cpu, cpu * np.float32(1.0001), fragile, 'bright')
