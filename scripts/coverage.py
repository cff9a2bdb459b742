# SPDX-License-Identifier: GPL-3.0-or-later
"""How often what the engine states of its own errors holds, over many seeds, beside converged pictures.

bias:      intervals of 95 % for the difference that fewer bounces make, each by a pilot of a few pixels and samples.
AUTO:      intervals of 95 % for the difference of the picture that integrator AUTO chose, each by its own pilot; and
           how often the difference is within the stated bound, its upper end.
adaptive:  how often the error that adaptive sampling leaves is within 20 % of the one that it tells.
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from benchmark.scenes import DEMOS

SIZE = (172, 96)
SMALL = (43, 24)
SCENES = ('three_lights', 'box_room', 'material_grid', 'whitted_classic')
FEWER = {'three_lights': {'max_bounces': 1}, 'material_grid': {'max_bounces': 1}, 'whitted_classic': {'max_bounces': 1}}
FIRST_SEED = 1000  # of those that are judged; the truth has others
TRUTH = (7001, 7002, 7003, 7004)
NEAR = 0.2
TOLERANCE = 0.01  # of AUTO
POLL_SECONDS = 0.02
MOST = 1024  # samples of adaptive sampling, and of each of the truths beside it
HEAD = ('scene', 'bias', 'AUTO', 'within bound', 'adaptive', 'told / true')
WIDTH = 16


class Judge:
    """One demo at SIZE, its truths, and its intervals."""

    def __init__(self, name: str, options: argparse.Namespace) -> None:
        import bpy
        from cotorra import auto, demos, export, native
        from cotorra.export.buffers import RenderSettings
        from cotorra.log import Log

        self.name, self.options = name, options
        scene = demos.build(name)
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        scene.render.resolution_percentage = 100
        depsgraph = bpy.context.evaluated_depsgraph_get()
        evaluated, log = depsgraph.scene_eval, Log()
        self.camera = export.export_camera(evaluated, evaluated.camera, log)
        buffers = export.export_scene(depsgraph, evaluated, depsgraph.view_layer_eval, log)
        self.module = native.load()
        self.built = self.module.Scene(buffers, threads=options.threads, embree=native.embree_library())
        self.facts = auto.facts(buffers)
        self.asked = RenderSettings(samples=options.samples, threads=options.threads)
        self.trial = auto.Pilot(self.module, self.built, self.camera, lambda: None)
        self.differences: dict[Any, float] = {}

    @cached_property
    def mean(self) -> float:
        return float(self.whole(self.asked, 256, TRUTH[:1]).mean())

    def whole(self, settings: Any, samples: int, seeds: Any) -> Any:
        """(K, P, 3): pictures of all pixels."""
        return self.trial.render(settings, samples, list(seeds)).pictures

    def true_difference(self, settings: Any) -> float:
        """Of the converged picture from that of what was asked for, as a share of the mean; each once."""
        from cotorra.auto.plan import LIMITS
        from cotorra.metrics import paired_difference

        limits = {name: getattr(settings, name) for name in LIMITS}
        key = replace(self.asked, integrator=settings.integrator, **limits)
        if key not in self.differences:
            a, b = (self.whole(entry, self.options.converged, TRUTH) for entry in (self.asked, key))
            self.differences[key] = paired_difference(a, b, self.mean).value
        return self.differences[key]

    def bias(self) -> float:
        """Share of intervals that hold; each has seeds and a grid of pixels of its own."""
        from cotorra.auto import pilot
        from cotorra.metrics import paired_difference

        fewer = replace(self.asked, **FEWER.get(self.name, {'diffuse_bounces': 2}))
        truth, chance, held = self.true_difference(fewer), np.random.default_rng(1), 0
        small = pilot.small_camera(self.camera, *SMALL)
        left, right, bottom, top = small.window
        for _ in range(self.options.repeat):
            across, up = (chance.integers(0, 4, 2) - 1.5) * ((right - left) / SIZE[0], (top - bottom) / SIZE[1])
            moved = replace(small, window=(left + across, right + across, bottom + up, top + up))
            seeds = chance.integers(0, 2**32, 4).tolist()
            a, b = (self.trial.render(entry, 8, seeds, camera=moved).pictures for entry in (self.asked, fewer))
            found = paired_difference(a, b, self.mean)
            held += found.low <= truth <= found.high
        return held / self.options.repeat

    def auto(self) -> tuple[float, float]:
        """Of the choices that leave something out, the shares of intervals and of bounds that hold; NaN without any."""
        from cotorra import auto, choices

        rows = frozenset(key for key, _, _ in choices.AUTO_ROWS)
        held, within = [], []
        for seed in self.seeds:
            trial = auto.Pilot(self.module, self.built, self.camera, lambda: None)  # of one render: it counts its paths
            found = auto.choose(trial, self.camera, replace(self.asked, seed=seed), self.facts, TOLERANCE, rows)
            if found.difference is None:
                continue
            truth = self.true_difference(found.settings)
            held.append(found.difference.low <= truth <= found.difference.high)
            within.append(truth <= found.bound)
        return (float(np.mean(held)), float(np.mean(within))) if held else (np.nan, np.nan)

    def adaptive(self) -> tuple[float, float]:
        """Share of pictures whose error is within NEAR of what is told, and told over true in the mean."""
        threshold = self.options.threshold
        settings = replace(self.asked, samples=MOST, adaptive=True, adaptive_min_samples=0, noise_threshold=threshold)
        truth = self.whole(self.asked, MOST, TRUTH).mean(axis=0, dtype=np.float64)
        told, true = [], []
        for seed in self.seeds:
            picture, noise = self.picture(replace(settings, seed=seed))
            told.append(noise.mean())
            # film_error of kernels/film.h, of the difference from the truth.
            brightness = np.sqrt(np.maximum(truth.sum(axis=1), 0.0))
            true.append((np.abs(picture - truth).sum(axis=1) / (1e-4 + brightness)).mean())
        ratios = np.array(told) / np.array(true)
        return float((np.abs(ratios - 1.0) <= NEAR).mean()), float(ratios.mean())

    @property
    def seeds(self) -> range:
        return range(FIRST_SEED, FIRST_SEED + self.options.repeat)

    def picture(self, settings: Any) -> tuple[Any, Any]:
        """(P, 3) the light and (H, W, 1) the error that is told, of one render."""
        from cotorra.export.buffers import PASSES

        names = ('combined', 'noise')
        run = self.module.Session(self.built, self.camera, replace(settings, passes=names))
        run.start()
        while not run.wait(POLL_SECONDS):
            pass
        found = {}
        for name in names:
            found[name] = np.zeros((SIZE[1], SIZE[0], PASSES[name]), np.float32)
            run.read(name, found[name])
        return found['combined'][..., :3].reshape(-1, 3).astype(np.float64), found['noise'].astype(np.float64)


def parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog='coverage', description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument(
        'scenes', metavar='SCENE', nargs='*', default=SCENES, help=f'demos (default: {" ".join(SCENES)})'
    )
    parser.add_argument('--repeat', type=int, default=200, help='seeds of each kind (default: 200)')
    parser.add_argument('--samples', type=int, default=4096, help="that AUTO's pilot is told of (default: 4096)")
    parser.add_argument('--threshold', type=float, default=0.1, help='of adaptive sampling (default: 0.1)')
    parser.add_argument('--converged', type=int, default=64, help='samples of each of four truths (default: 64)')
    parser.add_argument('--threads', type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    for name in options.scenes:
        if name not in DEMOS:
            parser.error(f'{name}: demos are {", ".join(DEMOS)}')
    return options


def main(arguments: list[str] | None = None) -> int:
    options = parse(arguments)
    import cotorra

    cotorra.register()
    print('  '.join(cell.ljust(WIDTH) for cell in HEAD), flush=True)
    for name in options.scenes:
        judge = Judge(name, options)
        shares = judge.bias(), *judge.auto()
        near, ratio = judge.adaptive()
        cells = (name, *(f'{100.0 * share:.1f} %' for share in (*shares, near)), f'{ratio:.2f}')
        print('  '.join(cell.ljust(WIDTH) for cell in cells), flush=True)
    # Blender 4.5 hangs at exit while an engine written in Python is registered.
    sys.stdout.flush()
    os._exit(0)


if __name__ == '__main__':
    sys.exit(main())
