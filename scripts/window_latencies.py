# SPDX-License-Identifier: GPL-3.0-or-later
"""How long it takes from an edit to the drawn frame that shows it, by kind of edit, for Cotorra and for Cycles.

Runs in Blender, sent there by window_test.py with `SETTINGS`. The engines' `view_draw` is followed by a look at what it
drew, which waits for the graphics driver: one measure for both. A frame shows an edit when it is nearer to what the
picture came to in the edit's state than to what it came to in the other one: noise and large pixels do not matter.
What was drawn but is uniform is no picture.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from functools import partial

import bpy
import gpu
import numpy as np

import window_edits as edits
from window_inside import EXTENSION, scene, write

DEFAULTS = {'engines': ['COTORRA', 'CYCLES'], 'kinds': ['camera'], 'edits': 10, 'report': '/tmp/latencies.json'}
SETTINGS = globals().get('SETTINGS', DEFAULTS)
ENGINES = {'COTORRA': (f'{EXTENSION}.engine', 'CotorraRenderEngine'), 'CYCLES': ('cycles', 'CyclesRender')}
FIRST = 'first'
ROUNDS = 2  # in each of which every engine has its turn, the order reversed every second time
WARM = 2  # edits before the counted ones, one to each state: they tell what both look like
SETTLE = 0.3  # seconds of rendering between a frame that was waited for and the next edit
SETTLE_WARM = 3.0  # before a look at what a state comes to: on a loaded machine the old one may stand for a second
PATIENCE = 30.0  # seconds after which an edit counts as not shown
ROWS, COLUMNS = 36, 32  # of what is looked at in a drawn frame
TICK = 0.01


class Eye:
    """Follows the engines' calls: time spent in them, and what they draw."""

    def __init__(self) -> None:
        self.frame: np.ndarray | None = None  # the newest
        self.drawn = 0.0  # when
        self.inside = 0.0  # seconds in the engine since it was set to 0
        self.wanted: tuple[np.ndarray | None, np.ndarray | None] | None = None  # what is waited for, and the opposite
        self.strict = False  # whether the frame before may be of neither state
        self.seen: tuple[float, float] | None = None  # when it came, and the seconds in the engine until then
        for name, kind in ENGINES.values():
            for call in ('view_update', 'view_draw'):
                self._follow(getattr(sys.modules[name], kind), call)

    def _follow(self, kind: type, call: str) -> None:
        own = getattr(kind, call)

        def followed(engine, context, depsgraph):
            began = time.perf_counter()
            own(engine, context, depsgraph)
            self.inside += time.perf_counter() - began
            if call == 'view_draw':
                self._look()

        setattr(kind, call, followed)

    def _look(self) -> None:
        buffer = gpu.state.active_framebuffer_get()
        x, y, width, height = gpu.state.viewport_get()
        lines = []
        for row in range(ROWS):
            line = buffer.read_color(x, y + (2 * row + 1) * height // (2 * ROWS), width, 1, 4, 0, 'FLOAT')
            line = np.array(line, np.float32).reshape(-1, 4)[: width // COLUMNS * COLUMNS, :3]
            lines.append(line.reshape(COLUMNS, -1, 3).mean(1))
        self.frame, self.drawn = np.stack(lines), time.perf_counter()
        if self.wanted is not None and self.seen is None and self._is_it(*self.wanted):
            self.seen = self.drawn, self.inside

    def _is_it(self, new: np.ndarray | None, old: np.ndarray | None) -> bool:
        if self.frame.std() < 1e-3:
            return False
        if new is None or old is None:
            return True
        distance = np.square(self.frame - new).sum()
        # Where nothing is drawn yet, what another engine drew may be there.
        far = self.strict and distance > 0.5 * np.square(new - old).sum()
        return bool(not far and distance < np.square(self.frame - old).sum())

    def await_(self, new: np.ndarray | None, old: np.ndarray | None, strict: bool = False) -> None:
        self.wanted, self.seen, self.inside, self.strict = (new, old), None, 0.0, strict


class Run:
    def __init__(self) -> None:
        self.found: dict[str, dict[str, list]] = {}
        self.missed: list[str] = []
        self.at = ''
        edits.build()
        self.area = edits.arrange()
        self.eye = Eye()
        self.steps = self.all()

    def tick(self) -> float | None:
        try:
            return next(self.steps)
        except StopIteration:
            self.write(ended=True)
            return None

    def write(self, **more: object) -> None:
        region = edits.region(self.area)
        write(
            SETTINGS['report'],
            {'found': self.found, 'missed': self.missed, 'at': self.at, 'size': [region.width, region.height], **more},
        )

    @property
    def shading(self) -> bpy.types.View3DShading:
        return self.area.spaces.active.shading

    # ---- Each step yields the seconds until it is to go on

    def all(self) -> Iterator[float]:
        for kind in SETTINGS['kinds']:
            for number in range(ROUNDS):
                for engine in SETTINGS['engines'][:: 1 - 2 * (number % 2)]:
                    self.at = f'{kind} {engine} {number}'
                    share = SETTINGS['edits'] * (number + 1) // ROUNDS - SETTINGS['edits'] * number // ROUNDS
                    yield from self.turn(kind, engine, share)
        yield from self.off()

    def turn(self, kind: str, engine: str, count: int) -> Iterator[float]:
        yield from self.off()
        scene().render.engine = engine
        times = self.found.setdefault(kind, {}).setdefault(engine, [])
        edit = edits.KINDS['light' if kind == FIRST else kind]
        edit(0)
        self.render()
        looks: list[np.ndarray | None] = [None, None]
        for number in range(WARM + 1):
            self.eye.await_(None, None)
            edit(number % 2)
            yield SETTLE_WARM
            while self.eye.seen is None:
                yield TICK
            looks[number % 2] = self.eye.frame
        for number in range(count):
            state = (number + WARM + 1) % 2
            act = partial(edit, state)
            if kind == FIRST:
                yield from self.off()
                edit(state)
                yield SETTLE
                act = self.render
            yield from self.one(kind, engine, times, act, looks[state], looks[1 - state])
            yield SETTLE
        edit(0)
        if kind == 'frame':
            edits.forget_keys()

    def one(self, kind, engine, times, edit, new, old) -> Iterator[float]:
        """Adds milliseconds to the frame, and those of them in the engine's calls, for one edit."""
        self.write()
        self.eye.await_(new, old, kind == FIRST)
        began = time.perf_counter()
        edit()
        while self.eye.seen is None:
            yield TICK
            if time.perf_counter() - began > PATIENCE:
                self.missed.append(f'{kind} {engine}')
                return
        seen, inside = self.eye.seen
        times.append((1e3 * (seen - began), 1e3 * inside))

    def render(self) -> None:
        self.shading.type = 'RENDERED'

    def off(self) -> Iterator[float]:
        self.eye.wanted = None
        self.shading.type = 'SOLID'
        yield SETTLE


run = Run()
bpy.app.timers.register(run.tick, first_interval=1.0, persistent=True)
