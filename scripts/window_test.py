# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs scripts/window_soak.py in a real Blender's window, watches over it, and judges what it says.

Blender may crash or hang there: this process is another. How such a Blender is made is told in ../shared/window.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / 'shared' / 'window'
TOP = Path(os.environ.get('BLENDER_WINDOW') or Path(os.environ.get('TMPDIR') or '/tmp') / 'blender-window')
POLL_SECONDS = 0.5
# A tick that takes longer is a hang. Software OpenGL and a loaded machine are slow: the two seconds are judged
# by the reader of the summary.
HANG_SECONDS = 60.0
# Bytes that may stay after closing, of what there was before the first operation: Blender's own caches fill.
MEMORY_RATIO = 1.6


def window(*arguments: str, text: str | None = None, check: bool = True) -> str:
    found = subprocess.run([str(SHARED / 'window'), *arguments], input=text, capture_output=True, text=True)
    if check and found.returncode != 0:
        sys.exit(f'window-test: window {arguments[0]}: {found.stdout}{found.stderr}')
    return found.stdout


def prepare() -> None:
    if not (TOP / 'sid' / 'usr' / 'bin' / 'blender').exists():
        print('window-test: making a Blender with a window', file=sys.stderr)
        subprocess.run([str(SHARED / 'setup')], check=True, stdout=subprocess.DEVNULL)
    with tempfile.TemporaryDirectory() as folder:
        built = ROOT / 'scripts' / 'build_extension.py'
        subprocess.run(
            [sys.executable, str(built), '--python', '3.14', '--output', folder], check=True, stdout=subprocess.DEVNULL
        )
        window('install', str(next(Path(folder).glob('*.zip'))))


def watch(arguments: argparse.Namespace) -> tuple[dict, list[str]]:
    """Runs the operations; their summary, and what went wrong."""
    report, log = TOP / 'w' / 'soak.json', TOP / 'w' / 'ui.log'
    report.unlink(missing_ok=True)
    # What it starts stays: its output must go to no pipe, whose end would be waited for.
    subprocess.run([str(SHARED / 'window'), 'start'], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    (TOP / 'w' / 'window_soak.py').write_text((ROOT / 'scripts' / 'window_soak.py').read_text())
    settings = {name: getattr(arguments, name) for name in ('seed', 'operations', 'engine')}
    settings['report'] = '/w/soak.json'
    source = "compile(open('/w/window_soak.py').read(), 'window_soak.py', 'exec')"
    said = window('do', text=f"exec({source}, {{'__name__': 'window_soak', 'SETTINGS': {settings!r}}})")
    if said:
        sys.exit(f'window-test: {said}')
    end = time.monotonic() + 60.0 * arguments.minutes
    faults: list[str] = []
    found: dict = {}
    last, changed = '', time.monotonic()
    while True:
        time.sleep(POLL_SECONDS)
        text = report.read_text() if report.exists() else ''
        if text != last:
            last, changed = text, time.monotonic()
            found = json.loads(text)
        if log.read_text(errors='replace').rstrip().splitlines()[-1:] and 'exit code' in log.read_text(
            errors='replace'
        ):
            faults.append(f'Blender ended: {log.read_text(errors="replace").rstrip().splitlines()[-1]}')
            break
        if found.get('ended'):
            break
        if time.monotonic() - changed > HANG_SECONDS:
            faults.append(f'no answer for {HANG_SECONDS:g} s')
            break
        if time.monotonic() > end:
            break
    tracebacks = log.read_text(errors='replace').count('Traceback')
    if tracebacks:
        faults.append(f'{tracebacks} tracebacks in {log}')
    if found.get('ended'):
        left = {name: found[f'{name}_left'] for name in ('viewports', 'stores', 'threads')}
        if any(left.values()):
            faults.append(f'left behind: {left}')
        if found['memory_end'] > MEMORY_RATIO * found['memory_start']:
            faults.append(f'memory grew from {found["memory_start"] >> 20} to {found["memory_end"] >> 20} MiB')
    if faults:
        faults.append(f'the last operations: {", ".join(found.get("last", []))}')
    return found, faults


def main() -> None:
    parser = argparse.ArgumentParser(prog='scripts/window-test', description=__doc__.splitlines()[0])
    parser.add_argument('--seed', type=int, default=1, help='of the random operations (default: 1)')
    parser.add_argument('--operations', type=int, default=200, help='how many (default: 200)')
    parser.add_argument(
        '--engine', default='COTORRA', help="whose viewport: with CYCLES, a fault that stays is Blender's own"
    )
    parser.add_argument('--minutes', type=float, default=10.0, help='that it takes at most (default: 10)')
    parser.add_argument(
        '--keep', action='store_true', help='leave the window open, and use the extension that is there'
    )
    arguments = parser.parse_args()
    if not arguments.keep:
        prepare()
    found, faults = watch(arguments)
    if not arguments.keep:
        window('do', text='import bpy; bpy.ops.wm.quit_blender()', check=False)
    print(json.dumps({key: value for key, value in found.items() if key != 'last'}, indent=1))
    for fault in faults:
        print(f'window-test: {fault}')
    sys.exit(1 if faults else 0)


if __name__ == '__main__':
    main()
