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

WATCHER_SECONDS = 0.1
# Each redraws the whole window, which waits meanwhile: so less and less often, and together with pictures.
WINDOW_SECONDS = 1.0
WINDOW_GROWTH = 1.1
WINDOW_SECONDS_MAX = 4.0
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
        self.scene_bytes = 0  # what the native scene holds, once there is one
        self._bytes_peak = 0
        self._layer = view_layer.name
        self._title = spelled(f'{scene.name}, {view_layer.name}')
        self._position, self._count = position_in_frame(scene, view_layer)
        self._began = time.perf_counter()
        self._next_watcher = self._next_window = 0.0
        self._pause = WINDOW_SECONDS

    def phase(self, name: str) -> None:
        """A new phase begins; times are counted from here."""
        self._began = time.perf_counter()
        self._memory.sample()
        memory = self.scene_bytes
        self._show(memory, name)
        watch.progress(watch.Progress(self._layer, name, memory=memory))

    def rendering(
        self, session: Any, total_samples: int, scale: float = 1.0, last: bool = False, redrawn: bool = False
    ) -> None:
        """Samples come in. Cheap where nothing is due. scale: of the session's progress. redrawn: the window will be
        drawn anyway."""
        now = time.perf_counter()
        watcher_due = watch.active is not None and (last or now >= self._next_watcher)
        window_due = last or redrawn or now >= self._next_window
        if not watcher_due and not window_due:
            return
        fraction = min(scale * session.progress(), 1.0)
        elapsed = now - self._began
        remaining = elapsed * (1.0 - fraction) / fraction if fraction > 0.0 else None
        samples = min(session.samples_done(), total_samples)
        self._memory.sample()
        figures = session.stats()
        memory = self.scene_bytes + figures['memory_bytes'] + figures.get('device_bytes', 0)
        if watcher_due:
            self._next_watcher = now + WATCHER_SECONDS
            watch.progress(
                watch.Progress(self._layer, 'Rendering', fraction, samples, total_samples, elapsed, remaining, memory)
            )
        if window_due:
            self._next_window = now + (BACKGROUND_SECONDS if bpy.app.background else self._pause)
            self._pause = min(self._pause * WINDOW_GROWTH, WINDOW_SECONDS_MAX)
            words = [f'Sample {samples}/{total_samples}']
            if remaining is not None and fraction < 1.0:
                words.insert(0, f'Remaining: {duration(remaining)}')
            self._show(memory, *words)
            self._engine.update_progress((self._position + fraction) / self._count)

    def _show(self, memory: int, *words: str) -> None:
        """Blender's status line, in the words of Cycles; Blender puts frame and time before it.

        memory: of the render alone, in bytes.
        """
        self._bytes_peak = max(self._bytes_peak, memory)
        used, peak = memory / MEBIBYTE, self._bytes_peak / MEBIBYTE
        parts = [self._title] if self._count > 1 else []
        parts += words[:-1]
        if memory:
            parts.append(f'Mem: {used:.0f}M')
        self._engine.update_stats('', ' | '.join([*parts, *words[-1:]]))
        self._engine.update_memory_stats(memory_used=used, memory_peak=peak)


def duration(seconds: float) -> str:
    """Minutes, seconds and hundredths, with hours where there are any, as Blender writes times of a render."""
    hundredths = round(max(0.0, seconds) * 100.0)
    minutes, rest = divmod(hundredths, 6000)
    hours, minutes = divmod(minutes, 60)
    text = f'{minutes:02d}:{rest // 100:02d}.{rest % 100:02d}'
    return f'{hours:02d}:{text}' if hours else text


def position_in_frame(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> tuple[int, int]:
    """Which of how many view layers of the frame this one is, counted from 0.

    scene: the original one; the evaluated scene has a single view layer.
    """
    names = [layer.name for layer in scene.view_layers if layer.use]
    if scene.render.use_single_layer or view_layer.name not in names:
        return 0, 1
    return names.index(view_layer.name), len(names)
