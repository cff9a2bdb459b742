# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts workers, each a Blender of its own, and keeps converged references in build/bench-cache.

It does not import bpy and computes no error.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from cotorra.metrics import Image, Reference

from benchmark.scenes import ROOT, SceneSource
from compare import read_exr

CACHE = ROOT / 'build' / 'bench-cache'


@dataclass(frozen=True, slots=True)
class Case:
    """What both engines are to solve."""

    source: SceneSource
    bounces: int
    size: tuple[int, int]
    threads: int
    constants: bool = False
    device: str = 'CPU'  # Cotorra's; Cycles is always on the CPU


@dataclass(frozen=True, slots=True)
class Render:
    """One finished render. Seconds: `render` of sampling alone by the engine's own clock, `whole` as the user waits."""

    samples: int
    seed: int
    image: Image
    render: float
    whole: float
    cpu: float
    memory: int
    stats: dict[str, Any]
    first: float | None = None  # until samples began, from the call on


def run_worker(task: dict[str, Any], environment: dict[str, str] | None = None) -> dict[str, Any]:
    """The worker's result; RuntimeError with its last words if there is none. `environment` is added to ours."""
    with tempfile.TemporaryDirectory(prefix='cotorra-bench-') as folder:
        task_file, result_file = Path(folder, 'task.json'), Path(folder, 'result.json')
        task_file.write_text(json.dumps(task))
        worker = Path(__file__).parent / 'worker.py'
        done = subprocess.run(
            [sys.executable, str(worker), str(task_file), str(result_file)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors='replace',
            env=os.environ | (environment or {}),
        )
        if not result_file.is_file():
            words = '\n  '.join(done.stdout.splitlines()[-15:])
            raise RuntimeError(
                f'{task["engine"]} on {task["source"]["name"]}: exit status {done.returncode}\n  {words}'
            )
        return json.loads(result_file.read_text())


def task_of(case: Case, engine: str, jobs: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        'engine': engine,
        'source': asdict(case.source),
        'bounces': case.bounces,
        'size': case.size,
        'threads': case.threads,
        'constants': case.constants,
        'device': case.device,
        'jobs': jobs,
    }


def clock(text: str) -> float:
    """Seconds of Cycles' '[hh:]mm:ss.ff'."""
    seconds = 0.0
    for part in text.split(':'):
        seconds = seconds * 60 + float(part)
    return seconds


def finished(engine: str, entry: dict[str, Any]) -> Render:
    image, attributes = read_exr(entry['output'])
    if engine == 'COTORRA':
        seconds = float(entry['stats']['render_seconds'])
    else:
        layers = [v for k, v in attributes.items() if k.startswith('cycles.') and k.endswith('.render_time')]
        seconds = sum(clock(str(value)) for value in layers)
    return Render(
        samples=entry['samples'],
        seed=entry['seed'],
        image=image,
        render=seconds,
        whole=entry['whole'],
        cpu=entry['cpu'],
        memory=entry['memory_peak'],
        first=entry.get('first_sample'),
        stats=entry.get('stats', {}),
    )


def engine_digest(engine: str) -> str:
    """Changes when the engine may render another image."""
    if engine != 'COTORRA':
        return importlib.metadata.version('bpy')
    state = hashlib.sha256(importlib.metadata.version('bpy').encode())
    import cotorra_native

    sources = sorted((ROOT / 'addon').rglob('*.py'))
    for path in (*sources, Path(cotorra_native.__file__)):
        state.update(path.read_bytes())
    return state.hexdigest()


def reference_folder(case: Case, engine: str, samples: int) -> Path:
    """Where the two halves of a reference lie; the name is the digest of all that they depend on but the threads."""
    fair = (Path(__file__).parent / 'fair.py').read_bytes()
    parts = (case.source.digest(), case.bounces, case.size, case.constants, engine_digest(engine), samples, fair)
    if engine == 'COTORRA' and case.device != 'CPU':
        parts += (case.device,)
    return CACHE / hashlib.sha256(repr(parts).encode()).hexdigest()[:20]


def blender_memory(case: Case) -> int:
    """Peak of a render that draws nothing, above what was in use before it: what Blender itself takes."""
    with tempfile.TemporaryDirectory(prefix='cotorra-bench-') as work:
        jobs = [{'samples': 1, 'seed': 1, 'output': str(Path(work, 'nothing.exr'))}]
        return run_worker(task_of(case, 'BENCH_NULL', jobs))['renders'][0]['memory_peak']


def tracing(case: Case, samples: int) -> dict[str, Any]:
    """Cotorra's rays and its threads' seconds, and Embree's for the same rays alone."""
    jobs = [{'samples': samples, 'seed': 1, 'output': ''}]
    return run_worker(task_of(case, 'BENCH_TRACE', jobs))['tracing']


def shares(case: Case) -> dict[str, float]:
    """Of what the variance of Cotorra's pixels is made: `shares.py`."""
    jobs = [{'samples': 4, 'seed': 1, 'output': ''}]
    return run_worker(task_of(case, 'BENCH_SHARES', jobs))['shares']


STARTS = ('compile_seconds', 'first_seconds')


def device_figures(case: Case, renders: list[Render]) -> dict[str, Any]:
    """What a graphics card took before its first sample, and its rays, by the render of most samples.

    starts: seconds of compiling, and until the first samples were there, of a process that finds no compiled kernels on
    the disk (cold) and of the next one (warm).
    """
    most = max(renders, key=lambda render: render.samples)
    session = most.stats['layers'][0]['session']
    keys = ('device', 'isa', 'device_build_seconds', 'upload_seconds', 'device_bytes')
    figures = {key: session[key] for key in keys} | {'rays': most.stats['rays'], 'seconds': most.render, 'starts': {}}
    with tempfile.TemporaryDirectory(prefix='cotorra-bench-') as folder:
        # The engine's own cache, and those of Mesa's and NVIDIA's drivers.
        caches = ('XDG_CACHE_HOME', 'MESA_SHADER_CACHE_DIR', '__GL_SHADER_DISK_CACHE_PATH')
        task = task_of(case, 'COTORRA', [{'samples': 1, 'seed': 1, 'output': ''}])
        for start in ('cold', 'warm'):
            render = run_worker(task, dict.fromkeys(caches, folder))['renders'][0]
            session = render['stats']['layers'][0]['session']
            figures['starts'][start] = {key: session[key] for key in STARTS}
    return figures


def timed(case: Case, engine: str, counts: list[int], seeds: list[int], shipped: bool = False) -> list[Render]:
    """Renders with each of `counts` samples and each seed. shipped: Cycles with what it has on by itself."""
    with tempfile.TemporaryDirectory(prefix='cotorra-bench-') as work:
        jobs = [
            {'samples': samples, 'seed': seed, 'output': str(Path(work, f'{samples}-{seed}.exr')), 'sharing': True}
            for samples in sorted(counts, reverse=True)
            for seed in seeds
        ]
        task = task_of(case, engine, jobs) | {'shipped': shipped}
        return [finished(engine, entry) for entry in run_worker(task)['renders']]


def measure(
    case: Case,
    engine: str,
    counts: list[int],
    seeds: list[int],
    reference_samples: int,
    reference_seeds: tuple[int, int],
) -> tuple[list[Render], Reference]:
    """Renders with each of `counts` samples and each seed, and the engine's reference where it is not cached.

    The most samples come first, so that their seconds and memory are those of a process that has rendered nothing yet.
    """
    folder = reference_folder(case, engine, reference_samples)
    halves = [folder / f'half{seed}.exr' for seed in reference_seeds]
    with tempfile.TemporaryDirectory(prefix='cotorra-bench-') as work:
        jobs = [
            {'samples': samples, 'seed': seed, 'output': str(Path(work, f'{samples}-{seed}.exr')), 'sharing': True}
            for samples in sorted(counts, reverse=True)
            for seed in seeds
        ]
        missing = [(seed, half) for seed, half in zip(reference_seeds, halves, strict=True) if not half.is_file()]
        made = [
            {'samples': reference_samples, 'seed': seed, 'output': str(Path(work, half.name))} for seed, half in missing
        ]
        done = run_worker(task_of(case, engine, jobs + made))['renders'] if jobs or made else []
        renders = [finished(engine, entry) for entry in done[: len(jobs)]]
        folder.mkdir(parents=True, exist_ok=True)
        for (_, half), job in zip(missing, made, strict=True):
            # Written beside its place and moved, so that a benchmark that was stopped leaves no half of a half.
            part = half.with_suffix('.part')
            part.write_bytes(Path(job['output']).read_bytes())
            part.replace(half)
    return renders, Reference.from_halves(*(read_exr(half)[0] for half in halves))
