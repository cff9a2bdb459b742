# SPDX-License-Identifier: GPL-3.0-or-later
"""The pass Ambient Occlusion of demo box_room is Cycles' own, as far as noise lets one tell.

Closed forms are tested in test_occlusion.py.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from cotorra import demos

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from benchmark.fair import make_fair, set_job
from render_calls import here, read_exr, render_to

SIZE = (160, 90)
SAMPLES = 64
DISTANCE = 1.5
# The mean over a tile of 256 pixels x 64 samples of a share near 1/2 deviates by 0.004 in each of the two pictures;
# both sample better than at random.
TILE_ERROR, TOTAL = 0.012, 0.0015


def occlusion(engine: str, folder: Path) -> np.ndarray:
    scene = demos.build('box_room')
    make_fair(scene, engine, 0, SIZE, threads=2)
    scene.view_layers[0].use_pass_ambient_occlusion = True
    scene.world.light_settings.distance = scene.cotorra.ao_distance = DISTANCE
    set_job(scene, SAMPLES, 1, '')
    layers = read_exr(render_to(scene, folder / f'{engine}.exr', multilayer=True))
    return layers[f'ViewLayer.{here("Ambient Occlusion")}']['R']


@pytest.mark.usefixtures('engine')
def test_the_pass_is_that_of_cycles(tmp_path: Path) -> None:
    ours, theirs = (occlusion(engine, tmp_path) for engine in ('COTORRA', 'CYCLES'))
    assert abs(ours.mean() - theirs.mean()) < TOTAL
    tiles = [image[:80].reshape(5, 16, 10, 16).mean(axis=(1, 3)) for image in (ours, theirs)]
    assert np.abs(tiles[0] - tiles[1]).max() < TILE_ERROR
