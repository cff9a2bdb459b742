# SPDX-License-Identifier: GPL-3.0-or-later
"""The line between a running render and whoever started it from Python: what it reports, and whether it shall stop.

The command line watches through it; renders that Blender's window starts need no watcher.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType


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
    """What the engine calls while it renders. Set `stop` to end the render and keep what is there."""

    stop = False

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


@contextmanager
def interrupt_as_flag() -> Iterator[threading.Event]:
    """Turn Ctrl-C into an event while the block runs.

    A KeyboardInterrupt that leaves `RenderEngine.render` crashes Blender when it saves EXR: none may be raised there.
    Only Python's own handler is replaced: Blender's binary and scripts that have their own keep them.
    """
    pressed = threading.Event()
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
        yield pressed
        return

    def remember(_signal: int, _frame: FrameType | None) -> None:
        pressed.set()

    signal.signal(signal.SIGINT, remember)
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
