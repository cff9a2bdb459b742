# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra against Cycles in one run: seconds, error against converged images, time to equal error, same image, memory.

The command line and the order of things; `benchmark/` does the work. A run of the demos takes 6 to 9 minutes on two
cores the first time, half of that once Cycles' references lie in build/bench-cache. Nothing else should run meanwhile.
Whether two images are the same within 1 % is told only by references of many samples: --reference-samples 2048.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import compare
from benchmark import everything, fair, judge, peers, report, runner, scenes, shares, sheet, synthetic


def parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='bench', description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    there = ', '.join((*scenes.DEMOS, *scenes.open_names()))
    parser.add_argument(
        'scenes',
        metavar='SCENE',
        nargs='*',
        help=f'{there},\na .blend file, or `sync`, `instances`, `triangles` and `materials` '
        '(default: the demos without models of our own; three_lights with --against)',
    )
    parser.add_argument('--bounces', type=int, nargs='+', default=[0, 4], help='default: 0 4')
    parser.add_argument('--samples', type=int, default=64, help='most samples (64); half and a quarter too')
    parser.add_argument('--reference-samples', type=int, help="of each of a reference's two halves (3 × --samples)")
    parser.add_argument('--repeat', type=int, default=1, help='seeds for each sample count (default: 1)')
    parser.add_argument('--size', default='320x180', help='WxH (default: 320x180)')
    parser.add_argument('--threads', type=int, default=os.cpu_count() or 1, help='default: all')
    parser.add_argument('--engine', default='COTORRA', choices=('COTORRA', 'CYCLES'), help='CYCLES: check of the bench')
    parser.add_argument(
        '--device', type=str.upper, default='CPU', choices=('CPU', 'VULKAN'), help="Cotorra's: cpu, vulkan"
    )
    parser.add_argument('--constants', action='store_true', help='cut textures off: constant materials and world')
    parser.add_argument(
        '--against', choices=tuple(peers.PEERS), help='this instead of Cycles, where its wheel is installed'
    )
    parser.add_argument('--all', action='store_true', help='all scenes that are here, in one table and a sheet')
    parser.add_argument('--budget', type=float, default=60.0, help='minutes that --all may take (default: 60)')
    parser.add_argument('--sheet', type=Path, default=runner.CACHE.parent / 'bench-sheet.png', help='picture of --all')
    parser.add_argument('--shares', action='store_true', help='of what the variance of our pixels is made')
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
    if options.budget <= 0:
        parser.error('--budget must be above 0')
    options.reference_samples = options.reference_samples or 3 * options.samples
    every = [source.name for source in everything.all_sources()] if options.all or options.shares else []
    try:
        names = options.scenes or every or (['three_lights'] if options.against else scenes.SAME_IN_CYCLES)
        options.sources = [scenes.find(name) for name in names if name not in synthetic.TESTS]
        options.synthetic = [name for name in names if name in synthetic.TESTS]
    except ValueError as problem:
        parser.error(str(problem))
    return options


def sample_counts(options: argparse.Namespace) -> list[int]:
    return [options.samples // 4, options.samples // 2, options.samples]


def bench_case(case: runner.Case, blender: int, options: argparse.Namespace) -> dict[str, Any]:
    """Both engines, one after the other, on one scene."""
    counts = sample_counts(options)
    seeds = range(options.repeat)
    ours = 'COTORRA' if options.engine == 'COTORRA' else 'CYCLES again'
    renders, reference = runner.measure(
        case, options.engine, counts, [11 + seed for seed in seeds], options.reference_samples, (2001, 2002)
    )
    cycles, cycles_reference = runner.measure(
        case, 'CYCLES', counts, [1 + seed for seed in seeds], options.reference_samples, (1001, 1002)
    )
    cpu = None
    if options.engine == 'COTORRA' and case.device != 'CPU':
        on_cpu = dataclasses.replace(case, device='CPU')
        cpu = runner.measure(
            on_cpu, 'COTORRA', counts, [11 + seed for seed in seeds], options.reference_samples, (2001, 2002)
        )
    result, same = judge.verdict(ours, renders, reference, cycles, cycles_reference, blender, cpu)
    if options.engine == 'COTORRA' and case.device == 'CPU':
        result['tracing'] = runner.tracing(case, counts[0])
    elif options.engine == 'COTORRA':
        result['device'] = runner.device_figures(case, renders)
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


def bench_scenes(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Every scene with every number of bounces; a case that fails is told and does not stop the others."""
    cases = []
    for source in options.sources:
        blender = None
        for bounces in options.bounces:
            case = runner.Case(source, bounces, options.size, options.threads, options.constants, options.device)
            try:
                blender = runner.blender_memory(case) if blender is None else blender
                cases.append(bench_case(case, blender, options))
            except (RuntimeError, OSError, ValueError) as problem:
                cases.append(failed(f'{source.name}, {bounces} bounces', problem))
    return cases


def bench_everything(options: argparse.Namespace) -> list[dict[str, Any]]:
    """One table of all scenes, with the greatest of --bounces; what is there so far is drawn and told as it comes."""
    drawn = sheet.Sheet(options.sheet)

    def show(result: dict[str, Any], same: Any, images: Any) -> None:
        drawn.add(result, same, images)
        print('  '.join(everything.line(result)), flush=True)

    results = everything.run(options.sources, max(options.bounces), options.size, options.threads, options.budget, show)
    print(f'\n{everything.table(results)}\nThe sheet: {options.sheet}\n', flush=True)
    return results


def bench_shares(options: argparse.Namespace) -> list[dict[str, Any]]:
    results = []
    for source in options.sources:
        case = runner.Case(source, max(options.bounces), options.size, options.threads)
        try:
            found = runner.shares(case)
            print(shares.text(source.name, found), flush=True)
            results.append({'scene': source.name, 'shares': found})
        except RuntimeError as problem:
            results.append(failed(f'{source.name}, shares', problem))
    return results


def bench_peers(options: argparse.Namespace) -> list[dict[str, Any]]:
    results = []
    for source in options.sources:
        for bounces in options.bounces:
            case = runner.Case(source, bounces, options.size, options.threads, options.constants)
            try:
                results.append(peers.against(options.against, case, sample_counts(options), options.reference_samples))
            except (RuntimeError, OSError, ValueError) as problem:
                results.append(failed(f'{source.name}, {bounces} bounces, against {options.against}', problem))
    return results


def bench_synthetic(options: argparse.Namespace) -> list[dict[str, Any]]:
    results = []
    for name in options.synthetic:
        try:
            results.append(synthetic.TESTS[name](options.threads, options.engine, options.repeat, options.device))
        except RuntimeError as problem:
            results.append(failed(name, problem))
    return results


def failed(what: str, problem: Exception) -> dict[str, Any]:
    print(f'{what} FAILED: {problem}\n', flush=True)
    return {'case': what, 'error': str(problem)}


def main(arguments: list[str] | None = None) -> int:
    """Exit status 1 where a case failed; a slow or differing image is a result, not a failure."""
    options = parse(arguments)
    began = time.perf_counter()
    machine = report.machine()
    print(f'{machine["cpu"]}, {machine["cores"]} cores, load {machine["load"]}, Blender {machine["bpy"]}')
    for line in fair.RULES:
        print(f'  {line}')
    print(report.RULES + '\n', flush=True)

    if options.against:
        results = {'against': bench_peers(options)}
    elif options.all or options.shares:
        results = {'all': bench_everything(options)} if options.all else {}
        if options.shares:
            results['shares'] = bench_shares(options)
    else:
        results = {'cases': bench_scenes(options), 'synthetic': bench_synthetic(options)}
        if results['cases']:
            print(report.summary(results['cases']) + '\n')
    print(f'{time.perf_counter() - began:.0f} s in all')
    if options.json:
        everything = {'machine': machine, 'rules': fair.RULES, **results}
        options.json.write_text(json.dumps(everything, indent=1))
    return int(any('error' in result for part in results.values() for result in part))


if __name__ == '__main__':
    sys.exit(main())
