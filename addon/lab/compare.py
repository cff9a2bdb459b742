# SPDX-License-Identifier: GPL-3.0-or-later
"""`cotorra compare`: a scene by Cotorra and by Cycles, side by side with their signed difference, and its figures.

Each renders with two seeds, so that a difference can be told from noise. It renders by the chart's worker.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import arguments, choices, metrics, outputs
from ..metrics import Error, Image, Interval, Reference, SameImage
from ..terminal import INTERRUPTED, WRONG_ARGUMENTS, CommandError, TerminalWatcher
from . import chart, pictures, results
from .driver import Worker
from .plan import Job, Series

SEEDS = (1, 2)
SAMPLES = 64


@dataclass(frozen=True, slots=True)
class Comparison:
    """seconds: of one render of each, ours first. error: of ours against Cycles', the noise of Cycles' subtracted."""

    ours: Image
    theirs: Image
    seconds: tuple[float, float]
    total: Interval
    same: SameImage
    error: Error
    flip: float | None

    def lines(self) -> list[str]:
        """The figures, for people."""
        same, error = self.same, self.error
        worst, x, y = same.worst
        return [
            f'total difference   {results.told(self.total)} of the mean (95 %)',
            f'tiles {metrics.TILE}×{metrics.TILE}        {same.within:.1%} within {same.limit:.0%}; beyond it and '
            f'noise {same.beyond_noise:.1%}; worst {worst:+.1%} at ({x}, {y}); noise of a tile {same.noise:.2%}',
            f'RMSE               {known(error.rmse)}',
            f'relMSE             {known(error.relmse)}, without the worst 0.1 % of pixels {known(error.trimmed)}',
            *([] if self.flip is None else [f'HDR-FLIP           {self.flip:.3g}']),
            f'seconds            Cotorra {self.seconds[0]:.2f}, Cycles {self.seconds[1]:.2f} '
            f'({self.seconds[1] / self.seconds[0]:.2f} times), of sampling',
            *([f'pixels not finite  {same.bad}'] if same.bad else []),
        ]


def known(error: float) -> str:
    """An error from which the reference's noise was subtracted: nothing may be left of it."""
    return f'{error:.3g}' if error > 0.0 else 'below the noise'


def compared(ours: list[Image], theirs: list[Image], seconds: tuple[float, float]) -> Comparison:
    """The figures of renders by two seeds each."""
    a, b = Reference.from_parts(ours), Reference.from_parts(theirs)
    flip = metrics.flip(a.image, b.image.astype(np.float32))[0] if metrics.has_flip() else None
    total = metrics.total_difference(ours, theirs)
    return Comparison(a.image, b.image, seconds, total, metrics.same_image(a, b), metrics.image_error(a.image, b), flip)


def picture(found: Comparison) -> pictures.Bytes:
    """Cotorra | Cycles | Cotorra − Cycles, with what each is above."""
    white = results.white_of(found.theirs)
    difference = (found.ours - found.theirs).mean(axis=2) / white
    limit = pictures.round_limit(difference)
    parts = [pictures.displayed(image, white) for image in (found.ours, found.theirs)]
    joined = pictures.side_by_side([*parts, pictures.signed(difference, limit)])
    step = parts[0].shape[1] + pictures.GAP
    texts = [f'Cotorra, {found.seconds[0]:.2f} s', f'Cycles, {found.seconds[1]:.2f} s']
    texts.append(f'difference, ±{100 * limit:g} % of white')
    return pictures.titled(joined, [(step * index, text) for index, text in enumerate(texts)])


def run(options: argparse.Namespace, watcher: TerminalWatcher) -> None:
    """All that `cotorra compare` does; the figures go to stdout."""
    chart.source_of(options)
    name = chart.name_of(options)
    target = options.output or Path(f'{name}-compare.png')
    if target.suffix.lower() not in ('.png', '.jpg'):
        raise CommandError(f'{target}: the name must end in .png or .jpg', WRONG_ARGUMENTS)
    outputs.require_writable(target)
    images: dict[str, list[Image]] = {'COTORRA': [], 'CYCLES': []}
    seconds: dict[str, list[float]] = {'COTORRA': [], 'CYCLES': []}
    with Worker(chart.task_of(options)) as worker:
        watcher.status('Opening the scene')
        jobs = [
            Job(Series(engine, integrator=options.integrator or 'PATH', denoised=options.denoise), samples, seed, True)
            for samples, seed in ((1, 1), *((options.samples, seed) for seed in SEEDS))
            for engine in images
        ]
        info = worker.opened(lambda: watcher.stop)
        began = time.perf_counter()
        for number, job in enumerate(jobs if info else ()):
            done = number / len(jobs)
            spent = time.perf_counter() - began
            watcher.status(f'{job.series.name}, seed {job.seed}', done, spent, spent * (1 - done) / done if done else 0)
            answer = worker.render(job, lambda: watcher.stop)
            if answer is None:
                break
            for text in answer.get('warnings', ()):
                watcher.message('WARNING', text)
            if 'error' in answer:
                raise CommandError(answer['error'])
            if number >= len(images):  # the first of each pays for what later ones find
                images[job.series.engine].append(np.load(answer['image']))
                seconds[job.series.engine].append(answer['wall'])
    if not all(images.values()):
        raise CommandError('interrupted before both had rendered; nothing is written', INTERRUPTED)
    found = compared(images['COTORRA'], images['CYCLES'], (min(seconds['COTORRA']), min(seconds['CYCLES'])))
    with outputs.replacing(target) as new:
        pictures.write(new, picture(found))
    width, height = info['size']
    print(f'{name}, {width}×{height}, {options.samples} samples, {len(SEEDS)} seeds')
    print('\n'.join(f'  {line}' for line in found.lines()), flush=True)
    watcher.note(f'{target}: Cotorra | Cycles | difference')


def add_command(commands: Any) -> None:
    """Adds `compare` to the command line's commands."""
    line = commands.add_parser(
        'compare',
        help='compare with Cycles',
        description='Renders a scene by Cotorra and by Cycles, reduced, writes both and their signed difference side '
        'by side, and prints the figures.',
    )
    arguments.add_source(line)
    line.add_argument('-o', '--output', type=Path, metavar='OUT', help='OUT.png or .jpg (NAME-compare.png)')
    line.add_argument(
        '--samples', type=arguments.whole(1, choices.SAMPLES_MAX), default=SAMPLES, metavar='N', help=f'({SAMPLES})'
    )
    line.add_argument('--denoise', action='store_true', help='both, by OpenImageDenoise')
    arguments.one_of(line, '--integrator', choices.INTEGRATORS, '{} (path)')
    chart.add_frame_options(line)
