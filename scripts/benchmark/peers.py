# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra against Mitsuba 3, where its wheel is installed: samples per second and time to equal error.

The scene is the one that Cotorra exports; `mitsuba_worker.py` says what is approximated. Each engine's error is that
against its own converged image, because their materials and some lights differ.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from benchmark import judge
from benchmark.report import table
from benchmark.runner import Case, Render, measure, run_worker, task_of
from metrics import Reference

VARIANTS = ('scalar_rgb', 'llvm_ad_rgb')
APPROXIMATIONS = """\
  for Mitsuba: instances flattened; its own principled BSDF; spot lights hard, with another edge; box filter;
  independent sampler; direct light by one sample of one light; LLVM's compilation not counted (LLVM 15 and 16
  cannot compile it, 19 can)"""


def run_mitsuba(task: dict[str, Any], folder: Path) -> dict[str, Any]:
    task_file, result_file = folder / 'task.json', folder / 'result.json'
    task_file.write_text(json.dumps(task))
    result_file.unlink(missing_ok=True)
    worker = Path(__file__).parent / 'mitsuba_worker.py'
    done = subprocess.run(
        [sys.executable, str(worker), str(task_file), str(result_file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors='replace',
    )
    if not result_file.is_file():
        raise RuntimeError('Mitsuba: ' + '\n  '.join(done.stdout.splitlines()[-6:]))
    return json.loads(result_file.read_text())


def measure_mitsuba(
    case: Case, variant: str, dump: Path, counts: list[int], reference_samples: int
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
        task = {'variant': variant, 'threads': case.threads, 'size': case.size, 'bounces': case.bounces}
        result = run_mitsuba({**task, 'dump': str(dump), 'jobs': jobs}, folder)
        images = [np.load(job['output']) for job in jobs]
    renders = [
        Render(entry['samples'], entry['seed'], image, entry['render'], entry['whole'], entry['cpu'], 0, {})
        for entry, image in zip(result['renders'][: len(counts)], images, strict=False)
    ]
    first, second = (np.mean(part, axis=0) for part in np.split(np.array(images[len(counts) :]), 2))
    return renders, Reference.from_halves(first, second)


def against_mitsuba(case: Case, counts: list[int], reference_samples: int) -> dict[str, Any]:
    """Prints one table; a variant that cannot run (LLVM missing) is told and left out."""
    if importlib.util.find_spec('mitsuba') is None:
        raise RuntimeError('the mitsuba wheel is not installed (pip install mitsuba, in the environment of this bench)')
    ours, reference = measure(case, 'COTORRA', counts, [11], reference_samples, (2001, 2002))
    ours_rows = judge.rows('COTORRA', ours, reference, reference, 0)
    pixels = case.size[0] * case.size[1]
    last = ours_rows[-1]
    lines = [
        (
            'COTORRA',
            f'{last.render:.2f}',
            f'{pixels * last.samples / last.render / 1e6:.2f}',
            f'{last.own.trimmed:.2e}',
            '',
        )
    ]
    result: dict[str, Any] = {
        'scene': case.source.name,
        'bounces': case.bounces,
        'rows': [asdict(row) for row in ours_rows],
    }
    result['equal_error'] = {}
    with tempfile.TemporaryDirectory(prefix='cotorra-bench-') as work:
        dump = Path(work, 'scene.pickle')
        run_worker(task_of(case, 'BENCH_DUMP', [{'samples': 1, 'seed': 1, 'output': ''}]) | {'dump': str(dump)})
        for variant in VARIANTS:
            try:
                theirs, own = measure_mitsuba(case, variant, dump, counts, reference_samples)
            except RuntimeError as problem:
                print(f'  {variant} left out: {problem}')
                result[variant] = {'error': str(problem)}
                continue
            rows = judge.rows(variant, theirs, own, own, 0)
            equal = judge.equal_error(ours_rows, rows, 'trimmed')
            result['rows'] += [asdict(row) for row in rows]
            result['equal_error'][variant] = asdict(equal)
            last = rows[-1]
            speed = pixels * last.samples / last.render / 1e6
            lines.append(
                (variant, f'{last.render:.2f}', f'{speed:.2f}', f'{last.own.trimmed:.2e}', f'{equal.render:.2f}')
            )
    what = 'direct samples' if case.bounces == 0 else f'paths of up to {case.bounces} bounces'
    print(f'{case.source.name} against Mitsuba, {what}, {case.size[0]}×{case.size[1]}, {counts[-1]} samples')
    print(table(('engine', 'render s', 'M/s', 'own error, trimmed', 'its time / ours at equal error'), lines))
    print(APPROXIMATIONS + '\n', flush=True)
    return result
