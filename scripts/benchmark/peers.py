# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra against Mitsuba 3 or LuxCore, where their wheels are installed: samples per second, time to equal error.

The scene is the one that Cotorra exports; their workers beside this file say what is approximated. Each engine's error
is that against its own converged image, because their materials and some lights differ.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from cotorra.metrics import Reference

from benchmark import judge
from benchmark.report import table
from benchmark.runner import Case, Render, measure, run_worker, task_of


@dataclass(frozen=True)
class Peer:
    """setups: by name, what the worker is told; the first is what makes most samples a second."""

    name: str
    module: str
    wheel: str
    setups: dict[str, dict[str, Any]]
    notes: str


# `every_light` holds for direct light: each light once and the BSDF once for each sample, instead of one light alone.
# On three_lights the second gave Mitsuba's least error in a second.
SIMPLE = {'sampler': 'independent', 'every_light': False}
BEST = {'sampler': 'ldsampler', 'every_light': True}
PEERS = {
    'mitsuba': Peer(
        'Mitsuba',
        'mitsuba',
        'mitsuba',
        {
            f'{variant}, {name}': {'variant': variant, **setup}
            for variant in ('scalar_rgb', 'llvm_ad_rgb')
            for name, setup in (('simple', SIMPLE), ('best', BEST))
        },
        """\
  simple: independent sampler, direct light by one sample of one light; best: low-discrepancy sampler, direct light by
  each light and the BSDF. Equal error (trimmed, own): * extrapolated beyond the samples that were rendered.
  Approximated for Mitsuba: instances flattened; its own principled BSDF; spot lights hard, with another edge; box
  filter. LLVM's compilation is not counted (LLVM 15 and 16 cannot compile the scene, 19 can).""",
    ),
    'luxcore': Peer(
        'LuxCore',
        'pyluxcore',
        'pyluxcore',
        {'PATHCPU, Sobol': {}},
        """\
  Equal error (trimmed, own): * extrapolated beyond the samples that were rendered. Approximated for LuxCore: instances
  flattened; its Disney material; spot lights hard, with another edge; the brightness of lamps by a plane that they
  light. Its pixel filter is ours. It has no seconds of its own for the start of a render: few samples count it.""",
    ),
}


def run_peer(peer: Peer, task: dict[str, Any], folder: Path) -> dict[str, Any]:
    task_file, result_file = folder / 'task.json', folder / 'result.json'
    task_file.write_text(json.dumps(task))
    result_file.unlink(missing_ok=True)
    worker = Path(__file__).parent / f'{peer.name.lower()}_worker.py'
    done = subprocess.run(
        [sys.executable, str(worker), str(task_file), str(result_file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors='replace',
    )
    if not result_file.is_file():
        raise RuntimeError(f'{peer.name}: ' + '\n  '.join(done.stdout.splitlines()[-6:]))
    return json.loads(result_file.read_text())


def measure_peer(
    peer: Peer, case: Case, setup: str, dump: Path, counts: list[int], reference_samples: int
) -> tuple[list[Render], Reference]:
    """Its reference is made by more passes of what is measured, so that LLVM's memory stays that of one pass."""
    passes = max(1, reference_samples // counts[-1])
    measured = [(samples, 11) for samples in counts]
    halves = [[(counts[-1], 1000 * half + i) for i in range(passes)] for half in (1, 2)]
    with tempfile.TemporaryDirectory(prefix='cotorra-bench-') as work:
        folder = Path(work)
        jobs = [
            {'samples': samples, 'seed': seed, 'output': str(folder / f'{samples}-{seed}.npy')}
            for samples, seed in (*measured, *halves[0], *halves[1])
        ]
        task = {'threads': case.threads, 'size': case.size, 'bounces': case.bounces}
        result = run_peer(peer, {**task, **peer.setups[setup], 'dump': str(dump), 'jobs': jobs}, folder)
        images = [np.load(job['output']) for job in jobs]
    renders = [
        Render(entry['samples'], entry['seed'], image, entry['render'], entry['whole'], entry['cpu'], 0, {})
        for entry, image in zip(result['renders'][: len(counts)], images, strict=False)
    ]
    first, second = (np.mean(part, axis=0) for part in np.split(np.array(images[len(counts) :]), 2))
    return renders, Reference.from_halves(first, second)


def against(name: str, case: Case, counts: list[int], reference_samples: int) -> dict[str, Any]:
    """Prints one table; a setup that cannot run (LLVM missing) is told and left out. name: of PEERS."""
    peer = PEERS[name]
    if importlib.util.find_spec(peer.module) is None:
        raise RuntimeError(
            f'the {peer.wheel} wheel is not installed (pip install {peer.wheel}, in the environment of this bench)'
        )
    what = 'direct samples' if case.bounces == 0 else f'paths of up to {case.bounces} bounces'
    print(
        f'{case.source.name} against {peer.name}, {what}, {case.size[0]}×{case.size[1]}, {counts[-1]} samples',
        flush=True,
    )
    # Ours also with few samples: a peer's error is soon reached.
    few = sorted({max(1, counts[0] // 4), max(1, counts[0] // 2), *counts})
    ours, reference = measure(case, 'COTORRA', few, [11], reference_samples, (2001, 2002))
    ours_rows = judge.rows('COTORRA', ours, reference, reference, 0)
    result: dict[str, Any] = {'case': f'{case.source.name}, {case.bounces} bounces', 'size': case.size}
    result |= {'rows': [asdict(row) for row in ours_rows], 'equal_error': {}, 'left_out': {}}
    lines = [line_of('COTORRA', ours_rows[-1], case, None)]
    with tempfile.TemporaryDirectory(prefix='cotorra-bench-') as work:
        dump = Path(work, 'scene.pickle')
        run_worker(task_of(case, 'BENCH_DUMP', [{'samples': 1, 'seed': 1, 'output': ''}]) | {'dump': str(dump)})
        for setup in peer.setups:
            try:
                theirs, own = measure_peer(peer, case, setup, dump, counts, reference_samples)
            except RuntimeError as problem:
                print(f'  {setup} left out: {problem}')
                result['left_out'][setup] = str(problem)
                continue
            rows = judge.rows(setup, theirs, own, own, 0)
            equal = judge.equal_error(ours_rows, rows, 'trimmed')
            result['rows'] += [asdict(row) for row in rows]
            result['equal_error'][setup] = asdict(equal)
            lines.append(line_of(setup, rows[-1], case, equal))
    print(table(('engine', 'render s', 'M/s', 'error', 'its time / ours'), lines))
    print(peer.notes + '\n', flush=True)
    return result


def line_of(name: str, last: judge.Row, case: Case, equal: judge.EqualError | None) -> tuple[str, ...]:
    speed = case.size[0] * case.size[1] * last.samples / last.render / 1e6
    line = (name, f'{last.render:.2f}', f'{speed:.2f}', f'{last.own.trimmed:.2e}')
    if equal is None:
        return (*line, '')
    return (*line, f'{equal.render:.2f}{"*" if equal.extrapolated else " "}')
