# SPDX-License-Identifier: GPL-3.0-or-later
"""`./scripts/bench --all`: every scene that is here, within a given time, beside Cycles matched and as it is shipped.

It plans and collects; `runner.py` renders, `judge.py` judges, `sheet.py` draws.
"""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from statistics import geometric_mean
from typing import Any

from cotorra.metrics import SameImage, same_image

from benchmark import judge, report, runner, scenes

# Most samples of the renders that are compared, and how many times that each half of a reference has.
SAMPLES = (128, 64, 32, 16, 8)
REFERENCE = 4
# Renders of half and a quarter of the samples, too; of Cycles once more as shipped.
SHARES = (1.0, 0.5, 0.25)
TILE_LIMIT = 0.02  # what the table counts tiles beyond
SIDE = {'total': 0.005, 'within': 0.98}


@dataclass(frozen=True, slots=True)
class Plan:
    """samples: of the longest render; reference: of each half of a reference; seconds: what that will take."""

    samples: int
    reference: int
    seconds: float


def plan(probes: dict[str, runner.Render], seconds: float) -> Plan:
    """The most samples that fit into the time. probes: a short render by each engine; their starts count, too."""
    rate = {engine: probe.render / probe.samples for engine, probe in probes.items()}
    start = {engine: probe.whole - probe.render for engine, probe in probes.items()}
    for samples in SAMPLES:
        work = sum(SHARES) * samples
        reference = REFERENCE * samples
        needed = rate['COTORRA'] * (work + 2 * reference) + rate['CYCLES'] * (2 * work + 2 * reference)
        needed += 5 * start['COTORRA'] + 8 * start['CYCLES']
        if needed <= seconds or samples == SAMPLES[-1]:
            # What is left makes the references better, up to four times.
            both = 2 * (rate['COTORRA'] + rate['CYCLES'])
            more = int(max(seconds - needed, 0.0) / max(both, 1e-9))
            reference = min(reference + more, 4 * reference)
            return Plan(samples, reference, needed)
    raise AssertionError


def all_sources() -> list[scenes.SceneSource]:
    """The demos that mean the same to Cycles, and the scenes by others that are here."""
    return [scenes.find(name) for name in (*scenes.SAME_IN_CYCLES, *scenes.open_names())]


def one(case: runner.Case, blender: int, seconds: float) -> tuple[dict[str, Any], SameImage, tuple[Any, Any]]:
    """All figures of one scene; the comparison of both converged images; and these images, ours first."""
    probes = {engine: runner.timed(case, engine, [4], [7])[0] for engine in ('COTORRA', 'CYCLES')}
    chosen = plan(probes, seconds)
    counts = [max(1, round(share * chosen.samples)) for share in SHARES]
    ours, reference = runner.measure(case, 'COTORRA', counts, [11], chosen.reference, (2001, 2002))
    cycles, truth = runner.measure(case, 'CYCLES', counts, [1], chosen.reference, (1001, 1002))
    shipped = runner.timed(case, 'CYCLES', counts, [3], shipped=True)
    result, _ = judge.verdict('COTORRA', ours, reference, cycles, truth, blender)
    result['shipped'] = against_shipped(ours, reference, shipped, truth, blender)
    same = same_image(reference, truth, TILE_LIMIT)
    numbers = asdict(same)
    del numbers['tiles']
    result['same_2_percent'] = numbers
    result['starts'] = {engine: asdict(probe) | {'image': None} for engine, probe in probes.items()}
    result['plan'] = asdict(chosen)
    return {'scene': case.source.name, 'bounces': case.bounces, **result}, same, (reference.image, truth.image)


def against_shipped(
    ours: list[runner.Render], reference: Any, shipped: list[runner.Render], truth: Any, blender: int
) -> dict[str, Any]:
    """Time to equal error against Cycles with its adaptive sampling and light threshold on."""
    our_rows = judge.rows('COTORRA', ours, reference, truth, blender)
    their_rows = judge.rows('CYCLES as shipped', shipped, truth, truth, blender)
    found: dict[str, Any] = {'rows': [asdict(row) for row in their_rows]}
    for measure in ('trimmed', 'relmse'):
        try:
            found[measure] = asdict(judge.equal_error(our_rows, their_rows, measure))
        except ValueError as problem:
            found[measure] = {'failed': str(problem)}
    return found


def run(
    sources: list[scenes.SceneSource], bounces: int, size: tuple[int, int], threads: int, minutes: float, show: Any
) -> list[dict[str, Any]]:
    """Each scene takes its part of the time that is left; where none is left, the rest are named as such.

    show(result, same, images) is called after each.
    """
    results = []
    end = time.perf_counter() + 60.0 * minutes
    for index, source in enumerate(sources):
        case = runner.Case(source, bounces, size, threads)
        began = time.perf_counter()
        if began >= end:
            results.append({'scene': source.name, 'error': 'no time was left for it'})
            continue
        share = (end - began) / (len(sources) - index)
        try:
            blender = runner.blender_memory(case)
            result, same, images = one(case, blender, 0.9 * share)
            show(result, same, images)
        except (RuntimeError, OSError, ValueError) as problem:
            result = {'scene': source.name, 'error': str(problem)}
            print(f'{source.name} FAILED: {problem}', flush=True)
        result['seconds'] = time.perf_counter() - began
        results.append(result)
    return results


# ---- The table.

HEAD = (
    'scene',
    'spp',
    'trimmed',
    'relMSE',
    'CPU',
    'shipped',
    'relMSE',
    'whole s',
    'Cycles',
    'first s',
    'Cycles',
    'total',
    'tiles >2%',
    'sure',
    'noise',
)
WORDS = """\
time to equal error, Cycles / ours: trimmed and untrimmed relMSE, and by processor seconds; then against Cycles as
shipped (adaptive sampling, light tree, light threshold). whole: seconds of the render of spp samples; first: seconds to
the first sample. total: of our image over Cycles'; tiles: share of 16×16 tiles beyond 2 %, and of those that are so
beyond noise; noise: of a tile. `-`: the error does not fall"""


def ratio(entry: dict[str, Any] | None, key: str = 'render') -> str:
    if not entry or key not in entry:
        return '-'
    return f'{entry[key]:.2f}' + ('~' if entry['extrapolated'] else '')


def line(result: dict[str, Any]) -> tuple[str, ...]:
    if 'error' in result:
        return (result['scene'], 'failed', *[''] * (len(HEAD) - 2))
    equal = {(e['against'], e['measure']): e for e in result['equal_error']}
    same = result['same_2_percent']
    whole = {row['engine']: row['whole'] for row in result['rows']}  # the last row has the most samples
    first = {engine: entry['first'] for engine, entry in result['starts'].items()}
    return (
        result['scene'],
        str(result['plan']['samples']),
        ratio(equal.get(('own', 'trimmed'))),
        ratio(equal.get(('own', 'relmse'))),
        ratio(equal.get(('own', 'trimmed')), 'cpu'),
        ratio(result['shipped']['trimmed']),
        ratio(result['shipped']['relmse']),
        f'{whole["COTORRA"]:.2f}',
        f'{whole["CYCLES"]:.2f}',
        *(f'{first[engine]:.2f}' if first[engine] is not None else '-' for engine in ('COTORRA', 'CYCLES')),
        f'{same["total"]:+.2%}',
        f'{1.0 - same["within"]:.1%}',
        f'{same["beyond_noise"]:.1%}',
        f'{same["noise"]:.1%}',
    )


def table(results: list[dict[str, Any]]) -> str:
    """One line a scene, and the geometric means."""
    lines = [line(result) for result in results]
    means = []
    for column in range(2, 7):
        numbers = [float(cells[column].rstrip('~')) for cells in lines if cells[column] not in ('', '-')]
        positive = [number for number in numbers if number > 0.0]
        means.append(f'{geometric_mean(positive):.2f}' if positive else '-')
    lines.append(('geometric mean', '', *means, *[''] * (len(HEAD) - 7)))
    return f'{report.table(HEAD, lines)}\n{WORDS}'
