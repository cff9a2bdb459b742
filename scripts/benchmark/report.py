# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's results as plain text. It computes nothing."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from pathlib import Path
from typing import Any

from cotorra.metrics import SameImage

from compare import describe

RULES = """\
  error    relMSE: mean of (x − r)² / (r² + (0.1 · image mean)²), r the converged image, whose own noise is subtracted;
           trimmed: without the worst 0.1 % of pixels. "own": r by the same engine, so noise alone; "Cycles": r by
           Cycles, so noise and any systematic difference
  seconds  prepare: all but rendering (depsgraph, sync, BVH, saving); render: sampling alone, by each engine's own
           clock; whole: bpy.ops.render.render from call to return; the most samples come first in a fresh process
  ratio    Cycles' seconds with its most samples over ours to the same error; error ∝ samples^−slope is fitted to the
           sample counts shown, seconds ∝ samples; CPU: the same from processor seconds per sample, nan if few
  tiles    16×16 pixels; the channel with the greatest difference, over the tile's mean; tiles darker than 0.001 of
           the image's mean compare absolutely; noise is known from the two halves of each reference"""


def machine() -> dict[str, Any]:
    """What the numbers were measured on."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path('/proc/cpuinfo')
    if cpuinfo.is_file():
        lines = cpuinfo.read_text().splitlines()
        model = next((line.split(':')[1].strip() for line in lines if line.startswith('model name')), model)
    load = round(os.getloadavg()[0], 1) if hasattr(os, 'getloadavg') else None
    return {'cpu': model, 'cores': os.cpu_count(), 'load': load, 'bpy': importlib.metadata.version('bpy')}


def table(head: tuple[str, ...], lines: list[tuple[str, ...]]) -> str:
    """Columns aligned, the first to the left, the others to the right."""
    widths = [max(len(line[i]) for line in (head, *lines)) for i in range(len(head))]
    aligned = []
    for line in (head, *lines):
        cells = [text.rjust(width) for text, width in zip(line, widths, strict=True)]
        aligned.append('  '.join((line[0].ljust(widths[0]), *cells[1:])).rstrip())
    return '\n'.join(f'  {line}' for line in aligned)


def case_text(title: str, result: dict[str, Any], same: SameImage, pixels: int) -> str:
    """One scene with one number of bounces."""
    lines = [
        (
            row['engine'],
            str(row['samples']),
            f'{row["whole"] - row["render"]:.2f}',
            f'{row["render"]:.2f}',
            f'{row["whole"]:.2f}',
            f'{pixels * row["samples"] / max(row["render"], 1e-9) / 1e6:.2f}',
            f'{row["own"]["relmse"]:.2e}',
            f'{row["own"]["trimmed"]:.2e}',
            f'{row["cycles"]["relmse"]:.2e}',
            '' if row['memory'] is None else f'{row["memory"] / 2**20:.0f}',
        )
        for row in result['rows']
    ]
    head = ('engine', 'samples', 'prepare s', 'render s', 'whole s', 'M/s', 'own', 'own trimmed', 'Cycles', 'peak MiB')
    text = [title, table(head, lines)]
    for entry in result['equal_error']:
        if (entry['against'], entry['measure']) not in (('own', 'trimmed'), ('own', 'relmse'), ('cycles', 'trimmed')):
            continue
        text.append(
            f'  equal error ({entry["against"]}, {entry["measure"]}): {entry["samples"]:.1f} samples of ours do; '
            f'Cycles / ours = {entry["render"]:.2f} rendering, {entry["whole"]:.2f} whole, {entry["cpu"]:.2f} CPU'
        )
        note = 'EXTRAPOLATED, ' if entry['extrapolated'] else ''
        text[-1] += f' ({note}slopes {entry["slope_ours"]:.2f} and {entry["slope_cycles"]:.2f})'
    for entry in result['equal_error_failed']:
        text.append(f'  equal error ({entry["measure"]}, {entry["against"]}): none, {entry["reason"]}')
    tracing = result.get('tracing')
    if tracing:
        rays = sum(tracing['rays'].values())
        kinds = ', '.join(f'{kind} {count / rays:.0%}' for kind, count in tracing['rays'].items())
        ours, embree = (rays / tracing[key] / 1e6 for key in ('busy_seconds', 'traced_seconds'))
        text.append(
            f'  million rays a second and thread: ours {ours:.2f}, Embree alone on the same rays {embree:.2f}, '
            f'ratio {ray_share(tracing):.1%} ({kinds})'
        )
    if 'device' in result:
        text += [cpu_text(result['cpu']), device_text(result['device'])]
    bad = max(max(row['own']['bad'], row['cycles']['bad']) for row in result['rows'])
    if bad:
        text.append(f'  {bad} PIXELS WITH NaN OR INFINITY were left out')
    share = max(row['own']['residual'] / max(row['own']['relmse'], 1e-30) for row in result['rows'])
    if share > 0.3:
        text.append(f'  noisy references: {share:.0%} of an error was subtracted for them; raise --reference-samples')
    text += ['  ' + line for line in describe(same).splitlines()]
    return '\n'.join(text)


def cpu_text(entry: dict[str, Any]) -> str:
    """A graphics card against our CPU device."""
    last = entry['rows'][-1]
    told = (
        f'  our CPU device: {last["render"]:.2f} s rendering, {last["whole"]:.2f} s whole for {last["samples"]} samples'
    )
    if 'failed' in entry:
        return f'{told}; equal error: none, {entry["failed"]}'
    note = 'EXTRAPOLATED, ' if entry['extrapolated'] else ''
    return (
        f'{told}; equal error (own, trimmed): {entry["samples"]:.1f} samples of the card do; CPU / card = '
        f'{entry["render"]:.2f} rendering, {entry["whole"]:.2f} whole ({note}slopes {entry["slope_ours"]:.2f} and '
        f'{entry["slope_cycles"]:.2f})'
    )


def device_text(figures: dict[str, Any]) -> str:
    """A graphics card's rays and what it took before the first."""
    starts = ', '.join(
        f'{start} start: compiling {seconds["compile_seconds"]:.2f}, first samples after {seconds["first_seconds"]:.2f}'
        for start, seconds in figures['starts'].items()
    )
    rays = ', '.join(f'{kind} {count / figures["seconds"] / 1e6:.2f}' for kind, count in figures['rays'].items())
    return (
        f'  {figures["device"]} ({figures["isa"]} tracing), million rays a second: {rays}\n'
        f'  seconds: BVH {figures["device_build_seconds"]:.2f}, upload {figures["upload_seconds"]:.2f}, {starts}; '
        f'{figures["device_bytes"] / 2**20:.0f} MiB on the device'
    )


def ray_share(tracing: dict[str, Any]) -> float:
    """Rays a second of the whole engine, over those of Embree alone on the same rays, thread for thread."""
    return tracing['traced_seconds'] / tracing['busy_seconds']


def summary(cases: list[dict[str, Any]]) -> str:
    """One line a case; the first four figures and the last are ratios, Cycles over ours but for memory."""
    lines = []
    for case in cases:
        if 'error' in case:
            continue
        ratios = {(e['against'], e['measure']): e for e in case['equal_error']}
        own, theirs = ratios.get(('own', 'trimmed')), ratios.get(('cycles', 'trimmed'))
        same = case['same_image']
        memory = {r['engine']: r['memory'] for r in case['rows'] if r['memory'] is not None}
        ours, cycles = (memory[engine] for engine in case['engines'])
        lines.append(
            (
                case['scene'],
                str(case['bounces']),
                f'{own["render"]:.2f}' if own else '-',
                f'{own["whole"]:.2f}' if own else '-',
                f'{own["cpu"]:.2f}' if own else '-',
                f'{theirs["render"]:.2f}' if theirs else '-',
                f'{ray_share(case["tracing"]):.0%}' if 'tracing' in case else '-',
                f'{same["within"]:.2%}',
                f'{same["total"]:+.3%}',
                f'{ours / max(cycles, 1):.2f}',
            )
        )
    head = ('scene', 'bounces', 'time ratio', 'whole', 'CPU', "Cycles' ref", 'rays', 'tiles in 1 %', 'total', 'memory')
    what = 'Cycles / ours at equal error (trimmed); rays: ours / Embree alone; memory: ours / Cycles'
    return f'{what}\n{table(head, lines)}'
