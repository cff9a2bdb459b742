# SPDX-License-Identifier: GPL-3.0-or-later
"""A real Blender's window from outside: makes it, sends it one of the scripts beside this one, and watches over it.

Blender may crash or hang there: this process is another. How such a Blender is made is told in ../shared/window.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / 'shared' / 'window'
TOP = Path(os.environ.get('BLENDER_WINDOW') or Path(os.environ.get('TMPDIR') or '/tmp') / 'blender-window')
LOG = TOP / 'w' / 'ui.log'
ENDED = 'exit code'  # its last line begins so
POLL_SECONDS = 0.5
LEAVE_SECONDS = 20.0
# A report that does not change for so long is a hang. Software OpenGL and a loaded machine are slow: shorter pauses are
# judged by the reader of the summary.
HANG_SECONDS = 60.0


def window(*arguments: str, text: str | None = None, check: bool = True) -> str:
    found = subprocess.run([str(SHARED / 'window'), *arguments], input=text, capture_output=True, text=True)
    if check and found.returncode != 0:
        sys.exit(f'window-test: window {arguments[0]}: {found.stdout}{found.stderr}')
    return found.stdout


def prepare() -> None:
    """A Blender with a window, where there is none yet, and this tree's extension in it."""
    if not (TOP / 'sid' / 'usr' / 'bin' / 'blender').exists():
        print('window-test: making a Blender with a window', file=sys.stderr)
        subprocess.run([str(SHARED / 'setup')], check=True, stdout=subprocess.DEVNULL)
    with tempfile.TemporaryDirectory() as folder:
        built = ROOT / 'scripts' / 'build_extension.py'
        subprocess.run(
            [sys.executable, str(built), '--python', '3.14', '--output', folder], check=True, stdout=subprocess.DEVNULL
        )
        window('install', str(next(Path(folder).glob('*.zip'))))


def play(script: str, settings: dict[str, Any], minutes: float) -> tuple[dict, list[str]]:
    """Opens the window and runs a script in it until it says that it has ended: its report, and what went wrong."""
    report, scripts = TOP / 'w' / 'report.json', TOP / 'w' / 'scripts'
    report.unlink(missing_ok=True)
    leave()  # one that was kept open
    # What it starts stays: its output must go to no pipe, whose end would be waited for.
    subprocess.run([str(SHARED / 'window'), 'start'], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    shutil.rmtree(scripts, ignore_errors=True)
    shutil.copytree(
        ROOT / 'scripts', scripts, ignore=lambda _, names: [n for n in names if not n.startswith('window_')]
    )
    settings = settings | {'report': '/w/report.json'}
    lines = (
        'import sys',
        "sys.path.insert(0, '/w/scripts')",
        f"source = compile(open('/w/scripts/{script}').read(), '{script}', 'exec')",
        f"exec(source, {{'__name__': '{script.removesuffix('.py')}', 'SETTINGS': {settings!r}}})",
    )
    said = window('do', text='\n'.join(lines))
    if said:
        sys.exit(f'window-test: {said}')
    end = time.monotonic() + 60.0 * minutes
    faults: list[str] = []
    found: dict = {}
    last, changed = '', time.monotonic()
    while time.monotonic() < end:
        time.sleep(POLL_SECONDS)
        text = report.read_text() if report.exists() else ''
        if text != last:
            last, changed = text, time.monotonic()
            found = json.loads(text)
        log = LOG.read_text(errors='replace')
        if ENDED in log:
            faults.append(f'Blender ended: {log.rstrip().splitlines()[-1]}')
            break
        if found.get('ended'):
            break
        if time.monotonic() - changed > HANG_SECONDS:
            faults.append(f'no answer for {HANG_SECONDS:g} s')
            break
    tracebacks = LOG.read_text(errors='replace').count('Traceback')
    if tracebacks:
        faults.append(f'{tracebacks} tracebacks in {LOG}')
    return found, faults


def leave() -> None:
    """Closes the window, where one is open."""
    if not LOG.exists() or ENDED in LOG.read_text(errors='replace'):
        return
    window('do', text='import bpy; bpy.ops.wm.quit_blender()', check=False)
    end = time.monotonic() + LEAVE_SECONDS
    while ENDED not in LOG.read_text(errors='replace') and time.monotonic() < end:
        time.sleep(POLL_SECONDS)
