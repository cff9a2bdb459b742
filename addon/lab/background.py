# SPDX-License-Identifier: GPL-3.0-or-later
"""Charts and comparisons of the open file in processes beside this Blender, so that its window stays alive.

It starts, asks and stops them and reads what they leave; panels and operators are ui/lab_panel.py's.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy

KINDS = {'chart': 'Speed and Accuracy', 'compare': 'Compare with Cycles'}
STOP_SECONDS = 30.0  # until a process that shall stop, and draws what is there, is ended


@dataclass(slots=True)
class Task:
    """One process. seconds: what it may take, where that is known. lines: what it printed of figures."""

    kind: str
    folder: Path
    process: subprocess.Popen
    began: float
    seconds: float | None
    scene: str
    running: bool = True
    error: str = ''
    stop_asked: float = 0.0
    lines: list[str] = field(default_factory=list)
    plot: dict[str, Any] | None = None

    def poll(self) -> bool:
        """True while it runs; when it has ended, what it left is read."""
        if not self.running:
            return False
        if self.process.poll() is None:
            if self.stop_asked and time.monotonic() - self.stop_asked > STOP_SECONDS:
                self.process.kill()
            return True
        self.running = False
        self.lines = [line.strip() for line in self._text('out.txt').splitlines() if line.startswith('  ')]
        if self.picture().exists() or (self.output() / 'plot.json').exists():
            if self.kind == 'chart':
                self.plot = json.loads((self.output() / 'plot.json').read_text(encoding='utf-8'))
        else:
            told = [line for line in self._text('log.txt').splitlines() if line.startswith('cotorra: ')]
            self.error = told[-1].removeprefix('cotorra: ') if told else self._text('log.txt')[-300:]
            if self.stop_asked and not told:  # it had not even begun
                self.error = 'interrupted before there was anything to show'
        return False

    def stop(self) -> None:
        """Ask it to end with what is there; where there is nothing, end it: while it starts it hears no signal."""
        if not self.running or self.stop_asked:
            return
        self.stop_asked = time.monotonic()
        if not self._text('log.txt'):
            self.process.kill()
        else:
            self.process.send_signal(signal.SIGINT if os.name == 'posix' else signal.SIGTERM)

    def state(self) -> str:
        """The last line that it printed of its progress."""
        lines = self._text('log.txt').splitlines()
        return lines[-1] if lines else 'Starting'

    def share(self) -> float | None:
        """The part of its time that is over."""
        return None if self.seconds is None else min(1.0, (time.monotonic() - self.began) / self.seconds)

    def output(self) -> Path:
        return self.folder / 'chart'

    def picture(self) -> Path:
        """chart.png is there where the process had matplotlib."""
        return self.folder / 'compare.png' if self.kind == 'compare' else self.output() / 'chart.png'

    def size(self) -> tuple[int, int] | None:
        """Width and height of one picture of a comparison, as it printed them."""
        told = re.search(r'(\d+)×(\d+)', self._text('out.txt'))
        return None if told is None else (int(told[1]), int(told[2]))

    def _text(self, name: str) -> str:
        try:
            return (self.folder / name).read_text(encoding='utf-8', errors='replace')
        except OSError:
            return ''


tasks: dict[str, Task] = {}  # the last of each kind
_folders: list[tempfile.TemporaryDirectory[str]] = []


def start(scene: bpy.types.Scene, kind: str, arguments: list[str], seconds: float | None = None) -> Task:
    """Saves a copy of what is open and starts `cotorra KIND COPY ARGUMENTS`; what ran before of that kind is ended.

    OSError and RuntimeError where it cannot be saved or started.
    """
    end(kind)
    held = tempfile.TemporaryDirectory(prefix='cotorra-', ignore_cleanup_errors=True)
    _folders.append(held)
    folder = Path(held.name)
    copy = folder / f'{bpy.path.clean_name(scene.name) or "scene"}.blend'
    bpy.ops.wm.save_as_mainfile(filepath=str(copy), copy=True, check_existing=False)
    target = folder / ('chart' if kind == 'chart' else 'compare.png')
    command = [sys.executable, '-P', str(Path(__file__).with_name('launch.py')), kind, str(copy), '-o', str(target)]
    environment = {**os.environ, 'COTORRA_WORKER': json.dumps(worker_command())}
    with (folder / 'out.txt').open('wb') as out, (folder / 'log.txt').open('wb') as log:
        process = subprocess.Popen(
            [*command, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=log,
            env=environment,
            start_new_session=os.name == 'posix',
        )
    tasks[kind] = Task(kind, folder, process, time.monotonic(), seconds, scene.name)
    return tasks[kind]


def worker_command() -> list[str]:
    """How a process that renders is started: this Blender without a window, or this Python's bpy module."""
    package = __package__
    code = (
        'import importlib, os, pathlib, sys; '
        f'importlib.import_module({package + ".worker"!r}).main(pathlib.Path(sys.argv[-1])); os._exit(0)'
    )
    if bpy.app.binary_path and not bpy.app.module:
        return [bpy.app.binary_path, '--background', '--python-exit-code', '1', '--python-expr', code, '--']
    return [sys.executable, '-P', '-c', code]


def end(kind: str) -> None:
    """Ends the process of a kind, if it runs, without waiting for what it would still write."""
    task = tasks.pop(kind, None)
    if task is not None and task.process.poll() is None:
        task.process.kill()
        task.process.wait()


def end_all() -> None:
    for kind in list(tasks):
        end(kind)
    for held in _folders:
        held.cleanup()
    _folders.clear()
