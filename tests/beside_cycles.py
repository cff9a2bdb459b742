# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of one scene by either engine, with means that are fair, as two halves of which the noise is known.

What may differ is said by the tests that compare them.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np

from render_calls import read_exr

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import Reference

from benchmark.fair import make_fair, set_job


def in_halves(
    scene: bpy.types.Scene, engine: str, folder: Path, bounces: int, size: tuple[int, int], samples: int
) -> Reference:
    """The picture, (height, width, 3), scene-linear. samples: of each half; size: width and height, pixels."""
    make_fair(scene, engine, bounces, size, threads=2)
    halves = []
    for seed in (1, 2):
        path = folder / f'{engine}{seed}.exr'
        set_job(scene, samples, seed, str(path))
        bpy.ops.render.render(write_still=True)
        channels = read_exr(path)['']
        halves.append(np.stack([channels[name] for name in 'RGB'], axis=-1))
    return Reference.from_halves(*halves)
