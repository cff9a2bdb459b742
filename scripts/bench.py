# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra against Cycles in one run: seconds, error against converged images, time to equal error, same image, memory.

The command line and the order of things; `benchmark/` does the work. A run of the demos takes 6 to 9 minutes on two
cores the first time, a third of that once the references lie in build/bench-cache.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import compare
from benchmark import fair, judge, report, runner, scenes, synthetic

EXTRAS = ('sync', 'instances')


def parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='bench', description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    there = ', '.join((*scenes.DEMOS, *scenes.open_names()))
    parser.add_argument(
        'scenes',
        metavar='SCENE',
        nargs='*',
        help=f'{there},\na .blend file, or `sync` and `instances` (default: the demos)',
    )
    parser.add_argument('--bounces', type=int, nargs='+', default=[0, 4], help='default: 0 4')
    parser.add_argument('--samples', type=int, default=64, help='most samples (64); half and a quarter too')
    parser.add_argument('--reference-samples', type=int, help="of each of a reference's two halves (4 × --samples)")
    parser.add_argument('--repeat', type=int, default=1, help='seeds for each sample count (default: 1)')
    parser.add_argument('--size', default='320x180', help='WxH (default: 320x180)')
    parser.add_argument('--threads', type=int, default=os.cpu_count() or 1, help='default: all')
    parser.add_argument('--engine', default='COTORRA', choices=('COTORRA', 'CYCLES'), help='CYCLES: check of the bench')
    parser.add_argument('--constants', action='store_true', help='cut textures off: constant materials and world')
    parser.add_argument('--against', choices=('mitsuba',), help='another engine, where its wheel is installed')
    parser.add_argument('--json', type=Path, help='everything measured')
    parser.add_argument('--images', type=Path, help='folder for the pictures of both and their difference')
    options = parser.parse_args(arguments)
    try:
        options.size = tuple(int(value) for value in options.size.lower().split('x'))
        if len(options.size) != 2 or min(options.size) < 1:
            raise ValueError
    except ValueError:
        parser.error(f'--size: WxH is wanted, such as 640x360, not {options.size}')
    if options.samples < 4 or min(options.bounces) < 0 or options.repeat < 1 or options.threads < 1:
        parser.error('--samples must be 4 or more, --repeat and --threads 1 or more, --bounces 0 or more')
    options.reference_samples = options.reference_samples or 4 * options.samples
    try:
        names = options.scenes or scenes.DEMOS
        options.sources = [scenes.find(name) for name in names if name not in EXTRAS]
        options.extras = [name for name in names if name in EXTRAS]
    except ValueError as problem:
        parser.error(str(problem))
    return options


def bench_case(case: runner.Case, blender: int, options: argparse.Namespace) -> dict[str, Any]:
    """Both engines, one after the other, on one scene."""
    counts = [options.samples // 4, options.samples // 2, options.samples]
    seeds = range(options.repeat)
    ours = 'COTORRA' if options.engine == 'COTORRA' else 'CYCLES again'
    renders, reference = runner.measure(
        case, options.engine, counts, [11 + seed for seed in seeds], options.reference_samples, (2001, 2002)
    )
    cycles, cycles_reference = runner.measure(
        case, 'CYCLES', counts, [1 + seed for seed in seeds], options.reference_samples, (1001, 1002)
    )
    result, same = judge.verdict(ours, renders, reference, cycles, cycles_reference, blender)
    width, height = case.size
    title = f'{case.source.name}, {case.bounces} bounces, {width}×{height}, {case.threads} threads'
    print(report.case_text(title, result, same, width * height) + '\n', flush=True)
    if options.images:
        path = options.images / f'{case.source.name}-{case.bounces}.png'
        compare.draw(path, reference.image, cycles_reference.image, same, (ours, 'CYCLES'), title)
    return {
        'scene': case.source.name,
        'bounces': case.bounces,
        'size': case.size,
        'engines': [ours, 'CYCLES'],
        **result,
    }


def main(arguments: list[str] | None = None) -> int:
    """Exit status 1 where a case failed; a slow or differing image is a result, not a failure."""
    options = parse(arguments)
    began = time.perf_counter()
    machine = report.machine()
    print(f'{machine["cpu"]}, {machine["cores"]} cores, load {machine["load"]}, Blender {machine["bpy"]}')
    for line in fair.RULES:
        print(f'  {line}')
    print(report.RULES + '\n', flush=True)

    cases = []
    for source in options.sources:
        blender = None
        for bounces in options.bounces:
            case = runner.Case(source, bounces, options.size, options.threads, options.constants)
            try:
                blender = runner.blender_memory(case) if blender is None else blender
                cases.append(bench_case(case, blender, options))
            except (RuntimeError, OSError, ValueError) as problem:
                print(f'{source.name}, {bounces} bounces FAILED: {problem}\n', flush=True)
                cases.append({'scene': source.name, 'bounces': bounces, 'error': str(problem)})
    if cases:
        print('Cycles over ours; greater is better for us, but for memory')
        print(report.summary(cases))
        print()
    extras: dict[str, Any] = {}
    for name in options.extras:
        try:
            if name == 'sync':
                extras[name] = synthetic.sync(options.threads, options.engine, max(3, options.repeat))
            else:
                extras[name] = synthetic.instances(options.threads, options.engine)
        except RuntimeError as problem:
            print(f'{name} FAILED: {problem}\n', flush=True)
            extras[name] = {'error': str(problem)}
    print(f'{time.perf_counter() - began:.0f} s in all')
    if options.json:
        options.json.write_text(
            json.dumps({'machine': machine, 'rules': fair.RULES, 'cases': cases, 'extras': extras}, indent=1)
        )
    return int(any('error' in result for result in (*cases, *extras.values())))


if __name__ == '__main__':
    sys.exit(main())
