# SPDX-License-Identifier: GPL-3.0-or-later
"""`cotorra chart`: speed against accuracy of a scene, as a figure, a page, a table and pictures.

It reads arguments and writes files; what is rendered is the driver's, what is computed results.py's.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import hashlib
import importlib.util
import io
import json
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import arguments, choices, metrics, opening
from ..terminal import FAILED, INTERRUPTED, CommandError, TerminalWatcher
from . import page, pictures, plan, results, worker
from .driver import Driver
from .plan import Plan, Series
from .results import Results
from .store import Store, replace_text

BUDGET_LEAST = 10.0  # seconds: Blender alone takes some of them to start
POINTS_MAX = 1000
# Drawing takes for each point, and beside, so many times what it takes to compare one picture.
CLOSING_POINT, CLOSING_BESIDE = 2.0, 24.0


def run(options: argparse.Namespace, watcher: TerminalWatcher) -> None:
    """All that `cotorra chart` does. Raises CommandError; an interrupt shows in `watcher.stop`."""
    began = time.perf_counter()
    with contextlib.closing(Store(options.output, identity_of(options))) as store:
        make(store, options, watcher, began)


def make(store: Store, options: argparse.Namespace, watcher: TerminalWatcher, began: float) -> None:
    """Renders what the folder lacks, and draws."""
    known = store.open(options.fresh)
    driver = Driver(store, watcher, options.budget, began)
    chart = driver.run(
        task_of(options),
        with_wishes(known, options) if known else None,
        lambda: plan_of(options),
        lambda chart: seconds_of_drawing(options, chart),
    )
    watcher.status('Drawing')
    renders = store.all()
    found = results.evaluate(chart, renders, options.clock)
    if found is None or not found.lines:
        reason = 'interrupted' if watcher.stop else 'time was up'
        if driver.failed:
            reason = '; '.join(driver.failed.values())
        code = INTERRUPTED if watcher.stop else FAILED
        raise CommandError(f'{reason} before there was anything to chart; the same command goes on', code)
    done = sum(store.has(job) for job in chart.jobs())
    write(options.output, found, store, chart, name_of(options), watcher)
    seconds = time.perf_counter() - began
    watcher.note(
        f'{options.output / "index.html"}: {len(found.points)} points, {done} of {len(chart.jobs())} renders, '
        f'{seconds:.1f} s, {driver.rendered_seconds:.1f} s of them renders'
    )


def task_of(options: argparse.Namespace) -> dict[str, Any]:
    """What the worker opens."""
    return {
        'file': str(options.file.resolve()) if options.file else None,
        'demo': options.demo,
        'size': options.size,
        'frame': options.frame,
        'threads': options.threads,
    }


def source_of(options: argparse.Namespace) -> str:
    """The demo, or the file's name and digest; CommandError where it is none that can be opened."""
    if options.file is None:
        return options.demo
    opening.require_source(options.file)
    return f'{options.file.name} {hashlib.sha256(options.file.read_bytes()).hexdigest()[:12]}'


def identity_of(options: argparse.Namespace) -> dict[str, Any]:
    """What must be the same for a chart to be gone on with."""
    from importlib import metadata

    source = source_of(options)
    state = hashlib.sha256()
    folder = Path(__file__).resolve().parent.parent
    for path in sorted(folder.rglob('*.py')):
        if 'lab' not in path.parts and 'ui' not in path.parts:  # what is drawn may change
            state.update(path.read_bytes())
    native = importlib.util.find_spec('cotorra_native')
    if native is not None and native.origin:
        state.update(Path(native.origin).read_bytes())
    try:
        blender = metadata.version('bpy')
    except metadata.PackageNotFoundError:
        blender = ''
    return {
        'scene': source,
        'size': list(options.size) if options.size else None,
        'frame': options.frame,
        'threads': options.threads,
        'engine': f'{state.hexdigest()[:12]} {blender}'.strip(),
    }


def seconds_of_drawing(options: argparse.Namespace, chart: Plan) -> float:
    """What drawing will take on this machine as busy as it is now: a picture is compared to know."""
    image = np.linspace(0.1, 1.0, worker.AREA * 3, dtype=np.float32).reshape(180, -1, 3)
    began = time.perf_counter()
    metrics.image_error(image, metrics.Reference.from_halves(image, image))
    if metrics.has_flip():
        metrics.flip(image, image[::-1].copy())
    pace = time.perf_counter() - began
    width, height = options.size or (320, 180)
    share = width * height / worker.AREA
    return pace * (CLOSING_BESIDE + CLOSING_POINT * share * len(chart.series) * len(chart.samples))


def series_of(options: argparse.Namespace) -> list[Series]:
    asked = (options.engines, options.integrators, options.models, options.devices, options.adaptive, options.denoised)
    if not any(asked):
        return list(plan.DEFAULT_SERIES)
    return plan.chosen_series(
        options.engines or ('COTORRA', 'CYCLES'),
        options.integrators or ('PATH',),
        [model if model != 'FILE' else '' for model in options.models or ('FILE',)],
        options.devices or ('CPU',),
        YES_NO[options.adaptive or 'no'],
        YES_NO[options.denoised or 'no'],
    )


YES_NO = {'no': (False,), 'yes': (True,), 'both': (False, True)}


def plan_of(options: argparse.Namespace) -> Plan:
    """As many series as make the points, most telling first; samples stay open where a budget decides."""
    series = series_of(options)
    samples = sorted(set(options.samples or ()))
    rungs = len(samples) or min(plan.RUNGS, max(2, options.points // len(series)))
    if not samples and options.points >= plan.RUNGS:
        rungs = plan.RUNGS
    series = series[: max(1, options.points // rungs)]
    if not samples and options.budget is None:
        samples = plan.ladder(plan.MOST_SAMPLES, rungs)
    return Plan(series, samples, options.seeds, options.reference_samples or 0, options.points)


def with_wishes(known: Plan, options: argparse.Namespace) -> Plan:
    """The plan that is gone on with, and what is asked for beyond it now."""
    asked = plan_of(options)
    series = list(dict.fromkeys([*known.series, *asked.series]))
    samples = sorted({*known.samples, *(asked.samples if options.samples else ())})
    return Plan(series, samples, max(known.seeds, options.seeds), known.reference_samples, options.points)


def name_of(options: argparse.Namespace) -> str:
    return options.demo or options.file.stem


def write(folder: Path, found: Results, store: Store, chart: Plan, name: str, watcher: TerminalWatcher) -> None:
    """chart.png and sheet.jpg where matplotlib is there, table.csv, table.md, plot.json, thumbnails and index.html."""
    title = f'{name}: speed against accuracy'
    width, height = store.info['size']
    subtitle = f'{width}×{height}, Blender {store.info["blender"]}, {chart.seeds} seeds a point'
    if found.between is not None:
        subtitle += f'; {found.between.a} − {found.between.b}, converged: {results.told(found.between.total)}'
    notes = notes_of(found, chart)
    page.write(folder / 'index.html', found, title, subtitle, notes)
    replace_text(folder / 'plot.json', json.dumps(page.plot_data(found)))
    rows = table_rows(found)
    replace_text(folder / 'table.csv', as_csv(rows))
    replace_text(
        folder / 'table.md', f'# {title}\n\n{subtitle}\n\n{as_markdown(rows)}\n' + ''.join(f'- {n}\n' for n in notes)
    )
    write_thumbnails(folder / 'thumbnails', found)
    if importlib.util.find_spec('matplotlib') is None:
        watcher.message('WARNING', 'there is no matplotlib here: no chart.png and sheet.jpg; index.html has all')
        return
    from . import figure

    figure.chart(found, title, subtitle).savefig(folder / 'chart.png')
    figure.sheet(found, f'{name}: pictures and errors').savefig(folder / 'sheet.jpg')


def write_thumbnails(folder: Path, found: Results) -> None:
    """Each point's picture and error beside each other, and each reference."""
    folder.mkdir(exist_ok=True)
    white = results.white_of(next(iter(found.references.values())).image)
    for series, truth in found.references.items():
        pictures.write(folder / f'reference-{series.key}.jpg', pictures.displayed(truth.image, white))
    for point in found.points:
        both = pictures.side_by_side([pictures.displayed(point.image, white), pictures.heat(point.error)])
        pictures.write(folder / f'{point.series.key}-{point.samples}.jpg', both)


def notes_of(found: Results, chart: Plan) -> list[str]:
    """What the figures mean, and what the references say of each other."""
    notes = []
    if found.between is not None:
        between = found.between
        same = between.same
        notes.append(
            f'{between.a} − {between.b}, both converged: {results.told(between.total)} of the mean (95 %); '
            f'{same.within:.1%} of the tiles of {metrics.TILE}×{metrics.TILE} pixels within {same.limit:.0%}, '
            f'{same.beyond_noise:.1%} beyond that and beyond noise'
        )
    parts = ', '.join(
        f'{results.engine_name(series)} {len(images)} × {chart.part_samples()} samples'
        for series, images in found.parts.items()
    )
    notes += [
        f"References: {parts}. The error of each engine is against its own, so that a path tracer's is noise alone; "
        'what each reference still has of noise is subtracted (of RMSE and relMSE, not of FLIP)',
        'relMSE: mean of (x − r)² / (r² + (0.1 · image mean)²) (Rousselle et al. 2011); HDR-FLIP: Andersson et al. '
        '2021, of one seed; noise: variance between seeds; bias: what seeds have in common, both as relMSE',
        f'Seconds: {results.CLOCKS[found.clock]} of sampling and denoising, without export, BVH and saving; adaptive: '
        f'up to {plan.ADAPTIVE_REACH} times the samples, to a noise threshold of {plan.ADAPTIVE_NOISE:g}/√samples',
    ]
    for line in found.lines:
        if line.bias is not None:
            sure = 'none that can be told from noise' if line.bias.holds_zero else 'beyond noise'
            notes.append(f'Bias of {line.series.name}: {results.told(line.bias)} of the mean (95 %), {sure}')
        for point in line.points:
            if point.bad:
                notes.append(f'{line.series.name}, {point.samples} samples: {point.bad} pixels are not finite')
    return notes


def table_rows(found: Results) -> list[list[Any]]:
    """A head and a row for each point."""
    names = [measure.key for measure in found.measures]
    rows: list[list[Any]] = [
        ['series', 'samples', 'seeds', 'seconds', 'processor seconds', 'whole seconds', *names,
         'noise relmse', 'bias relmse', 'bad pixels', 'on the front of'],
    ]  # fmt: skip
    for point in found.points:
        noise = (point.parts.noise_relmse, point.parts.bias_relmse) if point.parts else (math.nan, math.nan)
        rows.append(
            [point.series.name, point.samples, point.seeds, point.wall, point.cpu, point.whole,
             *(point.value(name) for name in names), *noise, point.bad, ' '.join(sorted(point.front))]
        )  # fmt: skip
    return rows


def as_csv(rows: Sequence[Sequence[Any]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator='\n').writerows(rows)
    return out.getvalue()


def as_markdown(rows: Sequence[Sequence[Any]]) -> str:
    def cell(value: Any) -> str:
        return ('–' if math.isnan(value) else f'{value:.3g}') if isinstance(value, float) else str(value)

    lines = [f'| {" | ".join(map(cell, row))} |' for row in rows]
    lines.insert(1, '|' + '|'.join('---' if index == 0 else '---:' for index in range(len(rows[0]))) + '|')
    return '\n'.join(lines)


def add_command(commands: Any) -> None:
    """Adds `chart` to the command line's commands."""
    line = commands.add_parser(
        'chart',
        help='chart speed against accuracy of a scene',
        description='Renders a scene by many settings and by Cycles, reduced, and charts seconds against error: '
        'OUT/index.html, chart.png, sheet.jpg, table.csv, table.md and thumbnails. A chart that was stopped is gone on '
        'with by the same command.',
    )
    arguments.add_source(line)
    line.add_argument('-o', '--output', required=True, type=Path, metavar='OUT', help='folder')
    line.add_argument('--budget', type=budget, metavar='S', help='seconds that all may take; samples are chosen by it')
    line.add_argument('--points', type=arguments.whole(1, POINTS_MAX), default=20, metavar='N', help='at most (20)')
    line.add_argument(
        '--samples', type=listed(arguments.whole(1, choices.SAMPLES_MAX)), metavar='N,..', help='of points'
    )
    line.add_argument('--seeds', type=arguments.whole(1, 64), default=2, metavar='N', help='renders of each point (2)')
    line.add_argument(
        '--reference-samples',
        type=arguments.whole(1, choices.SAMPLES_MAX),
        metavar='N',
        help=f'of a reference in all ({plan.REFERENCE_SHARE} times the most samples)',
    )
    several(line, '--engines', plan.ENGINES, 'cotorra, cycles (default: both), eevee')
    several(line, '--integrators', [entry[0] for entry in choices.INTEGRATORS])
    several(line, '--models', ['FILE', *(entry[0] for entry in choices.MODELS)], 'for all materials; file: as they are')
    several(line, '--devices', [entry[0] for entry in choices.DEVICES])
    for name, text in (('--adaptive', 'stop early where the noise is low'), ('--denoised', 'by OpenImageDenoise')):
        line.add_argument(name, choices=YES_NO, help=text)
    line.add_argument('--clock', choices=results.CLOCKS, default='wall', help='seconds of the wall (default) or cpu')
    add_frame_options(line)
    line.add_argument('--fresh', action='store_true', help='throw away what the folder holds of a chart')


def add_frame_options(line: argparse.ArgumentParser) -> None:
    """Of what is rendered, at which size, by how many."""
    line.add_argument(
        '--size', type=arguments.size, metavar='WxH', help="in pixels (as many as 320x180, in the file's shape)"
    )
    line.add_argument('--frame', type=frame, metavar='N', help="default: the file's")
    line.add_argument('--threads', type=arguments.whole(0, choices.THREADS_MAX), metavar='N', help='0 for all cores')


def several(line: argparse.ArgumentParser, option: str, names: Sequence[str], text: str = '') -> None:
    def one(word: str) -> str:
        if word.upper() not in names:
            raise argparse.ArgumentTypeError(f'{word!r} is none of {", ".join(names).lower()}')
        return word.upper()

    line.add_argument(option, type=listed(one), metavar='NAME,..', help=text or ', '.join(names).lower())


def listed(read: Any) -> Any:
    """A type of argument: words with commas between, each of a type, each once."""
    return lambda text: list(dict.fromkeys(read(word.strip()) for word in text.split(',')))


def budget(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not BUDGET_LEAST <= number <= choices.SECONDS_MAX:
        raise argparse.ArgumentTypeError(f'{text!r} is no time from {BUDGET_LEAST:g} s: less is not enough to start')
    return number


def frame(text: str) -> int:
    return arguments.whole(-choices.FRAME_MAX, choices.FRAME_MAX)(text)
