# SPDX-License-Identifier: GPL-3.0-or-later
"""Random operations in Blender's window, one at a time, with its main loop going on in between.

What they are is told in window_operations.py. It runs in Blender, sent there by window_test.py with `SETTINGS`; what
it does and finds it writes into a file, the operation before it begins: where Blender crashes, the last one is known.
"""

from __future__ import annotations

import time
from collections import Counter

import bpy

from window_inside import give_back, memory, stores, threads, viewports, write
from window_operations import OPERATIONS, begin, chance, push

DEFAULTS = {'seed': 1, 'operations': 20, 'report': '/tmp/soak.json', 'engine': 'COTORRA', 'only': []}
SETTINGS = globals().get('SETTINGS', DEFAULTS)
HANG_SECONDS = 2.0
MEMORY_EVERY = 100  # operations


class Run:
    def __init__(self) -> None:
        self.done, self.refused = Counter(), Counter()
        self.last: list[str] = []
        self.left = SETTINGS['operations']
        self.ticks: list[float] = []
        self.seen = time.perf_counter()
        self.slowest: list[tuple[float, str]] = []
        self.hangs = Counter()  # by the operation before
        self.memory = self.before = memory()
        self.grown = Counter()  # bytes, by the operation before
        self.course = [self.memory]
        self.threads = threads()
        self.closing = 0

    def write(self, **more: object) -> None:
        found = {
            'seed': SETTINGS['seed'],
            'operations': sum(self.done.values()),
            'refused': sum(self.refused.values()),
            'slowest_seconds': [(round(seconds, 2), name) for seconds, name in self.slowest[:5]],
            'hangs': dict(+self.hangs),
            'by_kind': dict(self.done),
            'mebibytes_by_kind': {name: grown >> 20 for name, grown in self.grown.most_common(8)},
            'mebibytes': [used >> 20 for used in self.course],
            'last': self.last[-8:],
            'memory_start': self.memory,
            'threads_start': self.threads,
            **more,
        }
        write(SETTINGS['report'], found)

    def tick(self) -> float | None:
        now = time.perf_counter()
        gap, self.seen = now - self.seen, now
        last = self.last[-1] if self.last else 'start'
        self.slowest = sorted([*self.slowest, (gap, last)], reverse=True)[:5]
        self.hangs[last] += gap > HANG_SECONDS
        if sum(self.done.values()) >= MEMORY_EVERY * len(self.course):
            give_back()
            self.course.append(memory())
        used = memory()
        self.grown[last] += used - self.before
        self.before = used
        if self.left > 0:
            self.left -= 1
            self.step()
            return 0.01 if SETTINGS['only'] else chance.choice((0.01, 0.05, 0.3))
        return self.close()

    def step(self) -> None:
        names = list(OPERATIONS)
        name = chance.choices(names, [OPERATIONS[name][0] for name in names])[0]
        if only := SETTINGS['only']:
            count = SETTINGS['operations']
            name = only[(count - self.left - 1) * len(only) // count]
        self.last.append(name)
        self.write()
        try:
            OPERATIONS[name][1]()
            self.done[name] += 1
            # As what users do is: undoing what was never noted crashes Blender 5.2.2, whoever's viewport it is.
            push(name)
        except (RuntimeError, ReferenceError, AttributeError, TypeError) as error:
            # Operators may refuse where they are called; what Cotorra raises is in Blender's log.
            self.refused[name] += 1
            self.last[-1] = f'{name} (refused: {str(error).splitlines()[0][:80]})'

    def close(self) -> float | None:
        """Leave the viewport, and see what stays."""
        self.closing += 1
        if self.closing == 1:
            self.last.append('closing')
            for screen in bpy.data.screens:
                for area in screen.areas:
                    if area.type == 'VIEW_3D':
                        area.spaces.active.shading.type = 'SOLID'
            bpy.ops.wm.read_homefile(use_factory_startup=False)
            return 3.0
        used = memory()
        give_back()
        # Embree, Blender and the graphics driver keep pools of threads of their own.
        self.write(
            ended=True,
            memory_end=memory(),
            memory_before_giving_back=used,
            stores_left=len(stores()),
            viewports_left=len(viewports()),
            threads_left=max(0, threads() - max(self.threads, 40)),
        )
        return None


run = Run()
begin(SETTINGS['seed'], SETTINGS['engine'])
bpy.app.timers.register(run.tick, first_interval=0.5, persistent=True)
