# SPDX-License-Identifier: GPL-3.0-or-later
"""Each demo is the same image as Cycles renders, as far as noise lets one tell at this size. Speed is not judged here.

Both engines render two halves with different seeds: how far these differ tells how far two images of one scene may.
References of Cycles are kept in build/bench-cache, so that only the first run takes a minute.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import same_image

import compare
from benchmark import runner, scenes

SIZE = (160, 90)
SAMPLES = {0: 128, 4: 64}  # of each half, by bounces
# What is asked for is 99 % of tiles within 1 % and 0.3 % in total. At this size a tile's mean is known to some tenths
# of a percent, so a tile is outside where it is so by more than 4 standard deviations; the total may differ by 3 more.
SHARE_OUTSIDE = 0.01
TOTAL = 0.003


@pytest.mark.parametrize('demo, bounces', [('three_lights', 0), ('box_room', 0), ('material_grid', 0), ('box_room', 4)])
def test_demo_is_the_image_of_cycles(demo: str, bounces: int) -> None:
    case = runner.Case(scenes.find(demo), bounces, SIZE, threads=2)
    _, ours = runner.measure(case, 'COTORRA', [], [], SAMPLES[bounces], (2001, 2002))
    _, cycles = runner.measure(case, 'CYCLES', [], [], SAMPLES[bounces], (1001, 1002))
    same = same_image(ours, cycles)
    told = compare.describe(same)
    assert same.bad == 0, told
    assert same.beyond_noise <= SHARE_OUTSIDE and abs(same.total) <= TOTAL + 3 * same.total_noise, (
        f'{told}\n{where(case)}'
    )


def where(case: runner.Case) -> str:
    """The images to look at."""
    ours, theirs = (runner.reference_folder(case, engine, SAMPLES[case.bounces]) for engine in ('COTORRA', 'CYCLES'))
    return f'look: python scripts/compare.py {ours}/half2001.exr {theirs}/half1001.exr -o difference.png'
