# SPDX-License-Identifier: GPL-3.0-or-later
"""A real Blender's window: random operations in it, or how long edits take to be seen, and what is to be said of it.

What runs in Blender is window_soak.py, window_latencies.py and what they need; window_blender.py watches over it.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from pathlib import Path

from window_blender import leave, play, prepare

# Bytes that may stay after closing, of what there was before the first operation: Blender's own caches fill.
MEMORY_RATIO = 1.6
# Kinds of edit, and the milliseconds within which they are to be seen.
GOALS = {'first': 1000, 'camera': 60, 'light': 50, 'material': 50, 'object': 60, 'mesh': 120, 'frame': 150}
LABELS = {
    'first': 'first pixels',
    'camera': 'camera moves',
    'light': 'light changes',
    'material': 'material changes',
    'object': 'object moves',
    'mesh': '16,200 triangles change',
    'frame': 'frame with 30 moving objects',
}
OF_CYCLES = 0.5  # of its time, at most
ENGINES = ('COTORRA', 'CYCLES')


def soak(arguments: argparse.Namespace) -> list[str]:
    settings = {name: getattr(arguments, name) for name in ('seed', 'operations', 'engine', 'only')}
    found, faults = play('window_soak.py', settings, arguments.minutes)
    if found.get('ended'):
        left = {name: found[f'{name}_left'] for name in ('viewports', 'stores', 'threads')}
        if any(left.values()):
            faults.append(f'left behind: {left}')
        if found['memory_end'] > MEMORY_RATIO * found['memory_start']:
            faults.append(f'memory grew from {found["memory_start"] >> 20} to {found["memory_end"] >> 20} MiB')
    if faults:
        faults.append(f'the last operations: {", ".join(found.get("last", []))}')
    print(json.dumps({key: value for key, value in found.items() if key != 'last'}, indent=1))
    return faults


def latencies(arguments: argparse.Namespace) -> list[str]:
    settings = {'engines': arguments.engines, 'kinds': arguments.kinds, 'edits': arguments.edits}
    report, faults = play('window_latencies.py', settings, arguments.minutes)
    faults += [f'not shown: {missed}' for missed in report.get('missed', [])]
    if not report.get('ended'):
        faults.append(f'not whole: it was at {report.get("at", "the start")}')
    found = report.get('found', {})
    if arguments.results is not None:
        known = json.loads(arguments.results.read_text()) if arguments.results.exists() else {}
        for kind, engines in found.items():
            known[kind] = known.get(kind, {}) | engines
        arguments.results.write_text(json.dumps(known))
        found = known
    print(f'viewport of {"×".join(map(str, report.get("size", ())))}; milliseconds from an edit to the frame with it')
    print('\n'.join(table(found)))
    return faults


def pauses(arguments: argparse.Namespace) -> list[str]:
    report, faults = play('window_pauses.py', {'engines': arguments.engines, 'renders': 1}, arguments.minutes)
    found = report.get('found', {})
    print('milliseconds between two turns of the main loop while F12 renders three_lights in full HD')
    print(f'{"":10}{"median":>8}{"longest":>9}{"turns":>7}{"over 200 ms":>13}{"their median":>14}{"share of time":>15}')
    for engine, times in found.items():
        long = [time for time in times if time > 200.0]
        share = sum(long) / max(sum(times), 1e-9)
        print(
            f'{engine.title():10}{statistics.median(times):8.0f}{max(times):9.0f}{len(times):7}{len(long):13}'
            f'{statistics.median(long) if long else 0.0:14.0f}{share:15.0%}'
        )
    if not report.get('ended'):
        faults.append('not whole')
    return faults


def table(found: dict[str, dict[str, list[tuple[float, float]]]]) -> list[str]:
    """found: by kind and engine, milliseconds until a frame shows an edit, and those of them in the engine's calls."""
    head = f'{"":30}{"goal":>6}' + ''.join(f'{name.title():>9}{"quartiles":>14}{"min":>7}{"n":>4}' for name in ENGINES)
    lines = [f'{head}{"ratio":>8}{"in calls":>10}']
    for kind in (kind for kind in GOALS if kind in found):
        line = f'{LABELS[kind]:30}{GOALS[kind]:6}'
        medians = {}
        for engine in ENGINES:
            times = [time for time, _ in found[kind].get(engine, [])]
            if len(times) < 2:
                line += f'{"-":>9}{"":25}'
                continue
            low, medians[engine], high = statistics.quantiles(times, n=4, method='inclusive')
            between = f'{low:.0f} to {high:.0f}'
            line += f'{medians[engine]:9.0f}{between:>14}{min(times):7.0f}{len(times):4}'
        met = medians.get(ENGINES[0], 0.0) <= GOALS[kind]
        if len(medians) == len(ENGINES):
            ratio = medians[ENGINES[0]] / medians[ENGINES[1]]
            met = met and ratio <= OF_CYCLES
            line += f'{ratio:8.2f}'
        else:
            line += f'{"-":>8}'
        if ENGINES[0] in medians:
            line += f'{statistics.median(inside for _, inside in found[kind][ENGINES[0]]):10.0f}'
        lines.append(line if met else f'{line}  missed')
    return lines


def names(known: tuple[str, ...]):
    def parse(text: str) -> list[str]:
        found = text.split(',')
        for name in found:
            if name not in known:
                raise argparse.ArgumentTypeError(f'{name} is none of {", ".join(known)}')
        return found

    return parse


def main() -> None:
    parser = argparse.ArgumentParser(prog='scripts/window-test', description=__doc__.splitlines()[0])
    parser.add_argument('--seed', type=int, default=1, help='of the random operations (default: 1)')
    parser.add_argument('--operations', type=int, default=200, help='how many (default: 200)')
    parser.add_argument(
        '--engine', default='COTORRA', help="whose viewport: with CYCLES, a fault that stays is Blender's own"
    )
    parser.add_argument(
        '--only',
        type=lambda text: text.split(','),
        default=[],
        help='these operations, one kind after the other, e.g. move,light',
    )
    parser.add_argument('--minutes', type=float, default=10.0, help='that it takes at most (default: 10)')
    parser.add_argument(
        '--keep', action='store_true', help='leave the window open, and use the extension that is there'
    )
    parser.add_argument('--latencies', action='store_true', help='no random operations: how soon edits are seen')
    parser.add_argument('--edits', type=int, default=50, help='of each kind (default: 50)')
    parser.add_argument(
        '--kinds', type=names(tuple(GOALS)), default=list(GOALS), help=f'of edit: {",".join(GOALS)} (default: all)'
    )
    parser.add_argument(
        '--engines', type=names(ENGINES), default=list(ENGINES), help=f'{",".join(ENGINES)} (default: both)'
    )
    parser.add_argument(
        '--results', type=Path, metavar='JSON', help='a file that keeps what was measured: the table has that, too'
    )
    parser.add_argument('--pauses', action='store_true', help='no random operations: pauses of the window during F12')
    arguments = parser.parse_args()
    if not arguments.keep:
        prepare()
    run = latencies if arguments.latencies else pauses if arguments.pauses else soak
    faults = run(arguments)
    if not arguments.keep:
        leave()
    for fault in faults:
        print(f'window-test: {fault}')
    sys.exit(1 if faults else 0)


if __name__ == '__main__':
    main()
