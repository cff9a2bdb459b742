# SPDX-License-Identifier: GPL-3.0-or-later
"""How long Blender's window pauses while F12 renders three_lights, with Cotorra and with Cycles.

Runs in Blender, sent there by window_test.py with `SETTINGS`. A timer asks to be called again at once; the time between
two calls is what the main loop was busy for otherwise: with redraws of the picture, above all.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import bpy

import window_edits as edits
from window_inside import scene, write

DEFAULTS = {'engines': ['COTORRA', 'CYCLES'], 'renders': 1, 'report': '/tmp/pauses.json'}
SETTINGS = globals().get('SETTINGS', DEFAULTS)
SIZE = 1920, 1080
SECONDS = 20.0  # of rendering that are watched, Esc after them
TICK = 0.005
REPORT_SECONDS = 5.0


class Run:
    def __init__(self) -> None:
        self.found: dict[str, list[float]] = {}
        edits.build()
        self.steps = self.all()
        bpy.app.handlers.render_complete.append(self.over)
        bpy.app.handlers.render_cancel.append(self.over)
        self.rendering = False

    def over(self, *_: object) -> None:
        self.rendering = False

    def tick(self) -> float | None:
        try:
            return next(self.steps)
        except StopIteration:
            write(SETTINGS['report'], {'found': self.found, 'ended': True})
            return None

    def all(self) -> Iterator[float]:
        render = scene().render
        render.resolution_x, render.resolution_y, render.resolution_percentage = *SIZE, 100
        scene().cycles.samples = scene().cotorra.samples = 100_000
        scene().cycles.use_adaptive_sampling = scene().cycles.use_denoising = False
        scene().cotorra.use_adaptive_sampling = scene().cotorra.use_denoising = False
        for _ in range(SETTINGS['renders']):
            for engine in SETTINGS['engines']:
                yield from self.watch(engine)

    def watch(self, engine: str) -> Iterator[float]:
        scene().render.engine = engine
        times = self.found.setdefault(engine, [])
        self.rendering = True
        scene().cycles.time_limit = scene().cotorra.time_limit = SECONDS
        bpy.ops.render.render('INVOKE_DEFAULT')
        yield 1.0  # the window of the picture opens, the scene is read
        began = last = time.perf_counter()
        said = began
        while self.rendering and last - began < 2 * SECONDS:
            yield TICK
            now = time.perf_counter()
            times.append(1e3 * (now - last))
            last = now
            if now - said > REPORT_SECONDS:
                said = now
                write(SETTINGS['report'], {'found': self.found})
        yield 1.0


run = Run()
bpy.app.timers.register(run.tick, first_interval=1.0, persistent=True)
