# SPDX-License-Identifier: GPL-3.0-or-later
"""From depsgraph to the first sample, and the memory of instances and of many triangles, on meshes of `scenes.py`.

It renders 8×8 pixels with one sample, so nothing about the speed of rendering is told here.
"""

from __future__ import annotations

from statistics import median
from typing import Any

from benchmark.materials import materials
from benchmark.report import table
from benchmark.runner import Case, run_worker, task_of
from benchmark.scenes import SceneSource

TRIANGLES = 2_000_000
INSTANCES = 100_000
MANY_TRIANGLES = 50_000_000


def first_render(source: SceneSource, engine: str, threads: int, device: str = 'CPU') -> dict[str, Any]:
    """One render of 8×8 pixels and one sample in a fresh Blender."""
    job = {'samples': 1, 'seed': 1, 'output': ''}
    return run_worker(task_of(Case(source, 0, (8, 8), threads, device=device), engine, [job]))['renders'][0]


def sync(threads: int, engine: str, repeat: int, _device: str) -> dict[str, Any]:
    """A smooth mesh with a UV map, from Blender's call to the first sample, what Blender itself takes subtracted."""
    source = SceneSource('grid', 'grid', number=TRIANGLES)
    repeat = max(3, repeat)
    engines = ('BENCH_NULL', 'CYCLES', engine)
    runs = {name: [first_render(source, name, threads) for _ in range(repeat)] for name in engines}
    blender = median(run['whole'] for run in runs['BENCH_NULL'])
    blender_memory = median(run['memory_peak'] for run in runs['BENCH_NULL'])
    result: dict[str, Any] = {'case': 'sync', 'triangles': TRIANGLES, 'blender_seconds': blender, 'runs': runs}
    lines = []
    for name in engines[1:]:
        whole = median(run['whole'] for run in runs[name]) - blender
        memory = median(run['memory_peak'] for run in runs[name]) - blender_memory
        first = [run['first_sample'] for run in runs[name] if run['first_sample'] is not None]
        begins = median(first) - blender if first else None
        stats = [run['stats'] for run in runs[name] if 'stats' in run]
        export = median(s['sync_seconds'] for s in stats) if stats else None
        build = median(s['build_seconds'] for s in stats) if stats else None
        result[name] = {
            'whole': whole,
            'first_sample': begins,
            'export': export,
            'build': build,
            'memory': memory,
        }
        seconds = ['-' if value is None else f'{value:.3f}' for value in (export, build, begins, whole)]
        lines.append((name, *seconds, f'{memory / 2**20:.0f}'))
    head = ('engine', 'export s', 'BVH s', 'sampling begins s', 'first image s', 'peak MiB')
    print(f'sync: one mesh of {TRIANGLES:,} triangles, {threads} threads, median of {repeat}, fresh process each,')
    print(f'      all above what Blender takes for a render that draws nothing ({blender:.3f} s)')
    print(table(head, lines) + '\n', flush=True)
    return result


def instances(threads: int, engine: str, _repeat: int, _device: str) -> dict[str, Any]:
    """Bytes that an instance costs: peak with many, less peak with one, less what Blender itself takes for either."""
    one, many = (SceneSource('instances', 'instances', number=number) for number in (1, INSTANCES))
    engines = ('BENCH_NULL', 'CYCLES', engine)
    runs = {
        name: {'one': first_render(one, name, threads), 'many': first_render(many, name, threads)} for name in engines
    }
    extra = {name: run['many']['memory_peak'] - run['one']['memory_peak'] for name, run in runs.items()}
    result: dict[str, Any] = {'case': 'instances', 'instances': INSTANCES, 'runs': runs}
    lines = []
    for name in engines[1:]:
        each = (extra[name] - extra['BENCH_NULL']) / (INSTANCES - 1)
        stats = [runs[name][key].get('stats', {}).get('scene', {}).get('memory_bytes') for key in ('one', 'many')]
        own = (stats[1] - stats[0]) / (INSTANCES - 1) if None not in stats else None
        result[name] = {'bytes_each': each, 'own_bytes_each': own}
        lines.append((name, f'{each:.0f}', '-' if own is None else f'{own:.0f}'))
    print(f'instances: {INSTANCES:,} of one mesh of 20,000 triangles; bytes each, above the mesh and Blender itself')
    print(table(('engine', 'peak of the process', 'scene as the engine counts it'), lines))
    print('  (the peak moves by a megabyte or two from run to run, which is 10 to 20 bytes each)\n', flush=True)
    return result


def triangles(threads: int, _engine: str, _repeat: int, device: str) -> dict[str, Any]:
    """Does a scene of very many triangles fit, and what does it take until the first sample is there?"""
    run = first_render(SceneSource('triangles', 'grid', number=MANY_TRIANGLES), 'COTORRA', threads, device)
    (layer,) = run['stats']['layers']
    session = layer['session']
    figures = {
        'export s': run['stats']['sync_seconds'],
        "Embree's BVH s": layer['scene']['build_seconds'],
        "device's BVH s": session['device_build_seconds'],
        'upload s': session['upload_seconds'],
        'first samples s': session['first_seconds'],
        'whole s': run['whole'],
        'on the device MiB': session['device_bytes'] / 2**20,
        'peak MiB': run['memory_peak'] / 2**20,
    }
    print(f'triangles: one mesh of {layer["scene"]["triangles"]:,} on {session["device"]} ({session["isa"]})')
    print(table(tuple(figures), [tuple(f'{value:.1f}' for value in figures.values())]) + '\n', flush=True)
    return {'case': 'triangles', **figures, 'run': run}


TESTS = {'sync': sync, 'instances': instances, 'triangles': triangles, 'materials': materials}
