# SPDX-License-Identifier: GPL-3.0-or-later
"""Tells the user how far a render is: Blender's progress bar and status line, and the watcher if there is one.

It decides how often, and in which words; what is told is read from the session.
"""

from __future__ import annotations

import time
from typing import Any

import bpy

from . import watch
from .log import spelled
from .stats import MemoryMeter
from .terminal import clock

WATCHER_SECONDS = 0.1
WINDOW_SECONDS = 0.25
BACKGROUND_SECONDS = 2.0  # Blender 4.5 prints a line each time
MEBIBYTE = 1024.0 * 1024.0


class Reporter:
    """Progress of one view layer among those that are rendered."""

    def __init__(
        self,
        engine: bpy.types.RenderEngine,
        scene: bpy.types.Scene,
        view_layer: bpy.types.ViewLayer,
        memory: MemoryMeter,
    ) -> None:
        self._engine = engine
        self._memory = memory
        self._layer = view_layer.name
        self._title = spelled(f'{scene.name}, {view_layer.name}')
        self._position, self._count = position_in_frame(scene, view_layer)
        self._began = time.perf_counter()
        self._next_watcher = self._next_window = 0.0

    def phase(self, name: str) -> None:
        """A new phase begins; times are counted from here."""
        self._began = time.perf_counter()
        memory = self._memory.sample()
        self._engine.update_stats(self._title, name)
        self._engine.update_memory_stats(memory_used=memory / MEBIBYTE, memory_peak=self._memory.peak() / MEBIBYTE)
        watch.progress(watch.Progress(self._layer, name, memory=memory))

    def rendering(self, session: Any, total_samples: int, last: bool = False) -> None:
        """Samples come in. Cheap where nothing is due."""
        now = time.perf_counter()
        watcher_due = watch.active is not None and (last or now >= self._next_watcher)
        window_due = last or now >= self._next_window
        if not watcher_due and not window_due:
            return
        fraction = session.progress()
        elapsed = now - self._began
        remaining = elapsed * (1.0 - fraction) / fraction if fraction > 0.0 else None
        samples = session.samples_done()
        memory = self._memory.sample()
        if watcher_due:
            self._next_watcher = now + WATCHER_SECONDS
            watch.progress(
                watch.Progress(self._layer, 'Rendering', fraction, samples, total_samples, elapsed, remaining, memory)
            )
        if window_due:
            self._next_window = now + (BACKGROUND_SECONDS if bpy.app.background else WINDOW_SECONDS)
            head = [self._title, f'Mem {memory / MEBIBYTE:.0f}M']
            if remaining is not None:
                head.insert(1, f'Remaining {clock(remaining)}')
            features = ', '.join(session.stats()['features'])
            self._engine.update_stats(' | '.join(head), f'Sample {samples}/{total_samples} | {features}')
            self._engine.update_progress((self._position + fraction) / self._count)
            self._engine.update_memory_stats(memory_used=memory / MEBIBYTE, memory_peak=self._memory.peak() / MEBIBYTE)


def position_in_frame(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> tuple[int, int]:
    """Which of how many view layers of the frame this one is, counted from 0.

    scene: the original one; the evaluated scene has a single view layer.
    """
    names = [layer.name for layer in scene.view_layers if layer.use]
    if scene.render.use_single_layer or view_layer.name not in names:
        return 0, 1
    return names.index(view_layer.name), len(names)
