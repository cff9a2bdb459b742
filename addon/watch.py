# SPDX-License-Identifier: GPL-3.0-or-later
"""The line between a running render and whoever started it from Python: what it reports, and whether it shall stop.

The command line watches through it; renders that Blender's window starts need no watcher.
"""

from __future__ import annotations

import signal
import threading
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any

# What asks a process to stop, and what users call it: farms send SIGTERM, a terminal that is closed SIGHUP.
STOP_SIGNALS = {'SIGINT': 'Ctrl-C', 'SIGTERM': 'SIGTERM', 'SIGHUP': 'SIGHUP'}


@dataclass(frozen=True, slots=True)
class Progress:
    """One moment of a render. `fraction` runs from 0 to 1; times in seconds, memory in bytes."""

    layer: str
    phase: str  # 'Synchronizing', 'Building' or 'Rendering'
    fraction: float = 0.0
    samples: int = 0
    total_samples: int = 0
    elapsed: float = 0.0
    remaining: float | None = None
    memory: int = 0


class Watcher:
    """What the engine calls while it renders. Set `stop` to end the render and keep what is there.

    mute: set when one of its methods raised: a render does not fail because nobody can be told of it.
    """

    stop = False
    mute = False

    def progress(self, state: Progress) -> None:
        """Called about ten times a second."""

    def message(self, level: str, text: str) -> None:
        """Called for each message, in place of Blender's own report, except for the error that ends a render."""


active: Watcher | None = None


@contextmanager
def attached(watcher: Watcher) -> Iterator[Watcher]:
    """Watch all renders inside the `with` block."""
    global active
    before, active = active, watcher
    try:
        yield watcher
    finally:
        active = before


def progress(state: Progress) -> None:
    """Tell the watcher how far the render is, if there is one."""
    _tell('progress', state)


def message(level: str, text: str) -> bool:
    """Tell the watcher; False if nobody took the message."""
    return _tell('message', level, text)


def _tell(method: str, *what: Any) -> bool:
    if active is None or active.mute:
        return False
    try:
        getattr(active, method)(*what)
    except Exception:
        active.mute = True
        show_traceback()
    return not active.mute


def show_traceback() -> None:
    """Print the exception that is being handled, if stderr takes it: it may be closed, full or gone."""
    try:
        traceback.print_exc()
    except Exception:
        pass


@dataclass(slots=True)
class Interrupt:
    """Whether a signal asked the process to stop, and which: a value of STOP_SIGNALS, or ''."""

    by: str = ''


@contextmanager
def interrupt_as_flag(names: Iterable[str] = STOP_SIGNALS) -> Iterator[Interrupt]:
    """Turn the signals of these names into a flag while the block runs.

    A KeyboardInterrupt that leaves `RenderEngine.render` crashes Blender when it saves EXR: none may be raised there.
    Only what Python itself does about a signal is replaced: Blender's binary and scripts that handle it, and `nohup`,
    which ignores it, keep what they have.
    """
    interrupt = Interrupt()
    taken = {}

    def remember(number: int, _frame: FrameType | None) -> None:
        interrupt.by = STOP_SIGNALS[signal.Signals(number).name]

    if threading.current_thread() is threading.main_thread():
        for name in names:
            number = getattr(signal, name, None)  # Windows has no SIGHUP
            pythons = signal.default_int_handler if name == 'SIGINT' else signal.SIG_DFL
            if number is not None and signal.getsignal(number) is pythons:
                taken[number] = signal.signal(number, remember)
    try:
        yield interrupt
    finally:
        for number, handler in taken.items():
            signal.signal(number, handler)
