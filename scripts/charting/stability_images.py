# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of whole pictures by samples and scene: is the noise that is told the error that is left, is what adaptive
sampling leaves within its threshold, and do denoising and shared samples lower the error?

Truth is a converged picture of other seeds. The scenes are made of tests/classic_scenes.py, one for each kind of noise.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from cotorra import denoise
from numpy.typing import NDArray

from charting.stability import Axis, Map

sys.path.append(str(Path(__file__).resolve().parents[2] / 'tests'))
import classic_scenes as classic

F64 = NDArray[np.float64]
TRUTH_SEED = 977
FEATURES = ('denoising_albedo', 'denoising_normal')


def maps(quick: bool) -> list[Map]:
    size = (40, 24) if quick else (96, 54)
    counts = np.array([4.0, 16.0, 64.0] if quick else [2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0])
    converged = 1024 if quick else 8192
    made = [Pictures(build, size, converged) for build in SCENES.values()]
    return [told(made, counts), stopped(made, quick), cleaned(made, counts), shared(made, counts)]


# ---- Scenes


def floor_and(*others: classic.Shape, albedo: float = 0.7) -> list[classic.Shape]:
    matt = classic.Material((albedo,) * 3)
    return [classic.quad((-4, -4, 0), (8, 0, 0), (0, 8, 0), matt), *others]


def penumbra() -> tuple[Any, ...]:
    """A ball of light half behind a board."""
    board = classic.quad((-1.0, -1.0, 1.0), (1.0, 0, 0), (0, 2.0, 0))
    return floor_and(board), [classic.Lamp('POINT', (60.0,) * 3, (0.3, 0.2, 2.0), size=0.4)], (0.0,) * 3


def room() -> tuple[Any, ...]:
    """Light that comes in by bounces alone: a box whose opening shows the sky."""
    walls = [
        classic.quad((-2, -2, 0), (4, 0, 0), (0, 4, 0)),
        classic.quad((-2, 2, 0), (4, 0, 0), (0, 0, 2), classic.Material((0.8, 0.3, 0.2))),
        classic.quad((-2, -2, 0), (0, 4, 0), (0, 0, 2), classic.Material((0.2, 0.7, 0.3))),
    ]
    return walls, [], (0.8, 0.9, 1.0)


def gloss() -> tuple[Any, ...]:
    """Highlights of a large light on metals."""
    metal = classic.Material((0.9, 0.7, 0.4), metallic=1.0, roughness=0.3)
    lamp = classic.Lamp('POINT', (80.0,) * 3, (1.0, -1.0, 3.0), size=0.5)
    return floor_and(classic.sphere((0, 0, 0.7), 0.7, metal, 32), albedo=0.4), [lamp], (0.1,) * 3


def edges() -> tuple[Any, ...]:
    """No noise but that of edges in a pixel."""
    boards = [classic.quad((-1.6 + 0.5 * i, -1.2, 0.5), (0.21, 0.3, 0), (-0.3, 2.1, 0)) for i in range(6)]
    return floor_and(*boards, albedo=0.3), [classic.Lamp('SUN', (3.0,) * 3)], (0.0,) * 3


def rare() -> tuple[Any, ...]:
    """A small emitter in a mirror: few samples find it."""
    glow = classic.Material((0.0,) * 3, emission=(50.0,) * 3)
    mirror = classic.Material((1.0,) * 3, metallic=1.0, roughness=0.15)
    shapes = floor_and(classic.sphere((0, 0, 0.7), 0.7, mirror, 32), classic.sphere((1.2, 0.4, 1.6), 0.08, glow, 16))
    return shapes, [], (0.05,) * 3


SCENES: dict[str, Callable[[], tuple[Any, ...]]] = {
    'penumbra': penumbra, 'room': room, 'gloss': gloss, 'edges': edges, 'rare light': rare,
}  # fmt: skip


class Pictures:
    """One scene, and its converged picture."""

    def __init__(self, build: Callable[[], tuple[Any, ...]], size: tuple[int, int], converged: int) -> None:
        shapes, lamps, world = build()
        self.scene = classic.scene(shapes, lamps, world=world)
        self.view = classic.camera(size, (0.0, -6.0, 4.0), (0.0, 6.0, -3.6), (0.0, 0.0, 1.0), window=3.0)
        self.view = classic.replace(self.view, filter_width=1.5)
        self.truth = self.render(converged, TRUTH_SEED)[0]['combined']

    def render(self, samples: int, seed: int, **settings: Any) -> tuple[dict[str, F64], dict[str, Any]]:
        """Passes as (H, W, C), and the session's figures."""
        names = ('combined', 'noise', 'sample_count', *FEATURES)
        run = classic.session(self.scene, self.view, 'PATH', samples=samples, seed=seed, passes=names, **settings)
        found = {name: classic.read(run, self.view, name).astype(np.float64) for name in names}
        found['combined'] = found['combined'][..., :3]
        return found, run.stats()

    def true_error(self, picture: F64) -> float:
        """film_error (kernels/film.h) of the difference from the truth: relative to how bright that looks."""
        apart = np.abs(picture - self.truth).sum(axis=2)
        return float((apart / (1e-4 + np.sqrt(np.maximum(self.truth.sum(axis=2), 0.0)))).mean())


def scenes_axis(promised: tuple[float, float]) -> Axis:
    return Axis('scene', np.arange(float(len(SCENES))), promised, log=False, labels=tuple(SCENES))


# ---- Maps

SEEDS = 4


def told(made: list[Pictures], counts: F64) -> Map:
    """Error over what was told of it, less one, where that is more than was told."""
    x = Axis('samples', counts, (16.0, 256.0))
    error = np.zeros((len(made), len(counts)))
    for j, one in enumerate(made):
        for i, samples in enumerate(counts.astype(int)):
            found = [one.render(int(samples), seed)[0] for seed in range(SEEDS)]
            true = np.mean([one.true_error(f['combined']) for f in found])
            error[j, i] = max(true / np.mean([f['noise'].mean() for f in found]) - 1.0, 0.0)
    said = 'of few samples two halves tell little; light that none of them met is in no estimate'
    return Map(
        'Noise that is told', x, scenes_axis((0.0, 3.0)), error, said, measure='error beyond what is told', limit=0.25
    )  # fmt: skip


def stopped(made: list[Pictures], quick: bool) -> Map:
    """Error that adaptive sampling leaves over the threshold that it stops at, less one."""
    thresholds = np.array([0.02, 0.1] if quick else [0.01, 0.02, 0.05, 0.1, 0.2])
    x = Axis('noise threshold', thresholds, (0.01, 0.2))
    error = np.zeros((len(made), len(thresholds)))
    for j, one in enumerate(made):
        for i, threshold in enumerate(thresholds):
            settings = {'adaptive': True, 'noise_threshold': float(threshold)}
            true = np.mean([one.true_error(one.render(1024, seed, **settings)[0]['combined']) for seed in range(2)])
            error[j, i] = max(float(true) / threshold - 1.0, 0.0)
    said = 'light that is met by one of hundreds of samples: pixels stop before they have met it'
    return Map(
        'Adaptive stop', x, scenes_axis((0.0, 3.0)), error, said, measure='error beyond the threshold', limit=0.25
    )


def shared(made: list[Pictures], counts: F64) -> Map:
    """Error where pixels share samples over that where each has its own, relative to how bright it looks."""
    x = Axis('samples', counts, (8.0, 256.0))
    error = np.zeros((len(made), len(counts)))
    for j, one in enumerate(made):
        for i, samples in enumerate(counts.astype(int)):
            all_, own = (
                np.mean([one.true_error(one.render(int(samples), k, sharing=on)[0]['combined']) for k in range(SEEDS)])
                for on in (True, False)
            )
            error[j, i] = all_ / own
    said = 'fewer samples do not tell where light is so smooth that each pixel had better keep its own'
    return Map(
        'Shared samples', x, scenes_axis((0.0, 4.0)), error, said, measure='error over that of own samples', limit=1.1
    )  # fmt: skip


def cleaned(made: list[Pictures], counts: F64) -> Map:
    """Error of the denoised picture over that of the noisy one, relative to how bright it looks."""
    x = Axis('samples', counts, (2.0, 64.0))
    error = np.full((len(made), len(counts)), np.nan)
    how = denoise.Denoising(quality='HIGH', threads=1)
    for j, one in enumerate(made):
        for i, samples in enumerate(counts.astype(int)):
            found, _ = one.render(int(samples), 1)
            images = {name: found[name].astype(np.float32) for name in FEATURES}
            try:
                clean = denoise.denoised(found['combined'].astype(np.float32), images, how)
            except denoise.DenoiseError:
                continue  # no library here: nothing to compare
            error[j, i] = one.true_error(clean.astype(np.float64)) / one.true_error(found['combined'])
    said = 'what has converged already, such as edges, is blurred by denoising'
    return Map(
        'Denoiser', x, scenes_axis((0.0, 2.0)), error, said, measure='error over that of the noisy picture', limit=1.0
    )  # fmt: skip
