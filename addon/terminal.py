# SPDX-License-Identifier: GPL-3.0-or-later
"""How a render looks at a terminal: one progress line that updates, or few lines where the output is not a terminal.

It writes to one stream and knows nothing of Blender.
"""

from __future__ import annotations

import shutil
import signal
import time
from types import FrameType
from typing import TextIO

from .watch import Progress, Watcher

MEBIBYTE = 1024.0 * 1024.0
SPARSE_SECONDS = 10.0
BAR_CELLS = 24


class TerminalWatcher(Watcher):
    """Prints progress and messages, and turns the first Ctrl-C into the wish to stop; the second one kills."""

    def __init__(self, out: TextIO) -> None:
        self.stop = False
        self.label = ''  # the frame, where there are several
        self._out = out
        self._updates = out.isatty()
        self._blocks = '█░' if (out.encoding or '').lower().replace('-', '') == 'utf8' else '#.'
        self._line = ''
        self._next_sparse = 0.0
        self._told: set[tuple[str, str]] = set()

    def progress(self, state: Progress) -> None:
        done = state.phase == 'Rendering' and state.fraction >= 1.0
        if self._updates:
            self._show(self._bar(state))
            if done:
                self._end_line()
            return
        now = time.perf_counter()
        if state.phase != 'Rendering' or done or now >= self._next_sparse:
            self._print(self._words(state))
            self._next_sparse = now + SPARSE_SECONDS

    def message(self, level: str, text: str) -> None:
        """Print a message, once however many view layers and frames repeat it."""
        if (level, text) not in self._told:
            self._told.add((level, text))
            self._print(f'{level.capitalize()}: {text}')

    def note(self, text: str) -> None:
        self._print(text)

    def interrupt(self, _signal: int, _frame: FrameType | None) -> None:
        """Handler for SIGINT."""
        self.stop = True
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        self._print('Stopping; what is rendered is kept. Ctrl-C again quits at once')

    def _bar(self, state: Progress) -> str:
        cells = round(state.fraction * BAR_CELLS)
        bar = self._blocks[0] * cells + self._blocks[1] * (BAR_CELLS - cells)
        return f'{bar} {self._words(state)}'

    def _words(self, state: Progress) -> str:
        words = [self.label, state.layer]
        if state.phase == 'Rendering':
            words.append(f'{100.0 * state.fraction:.0f} %')
            words.append(f'{state.samples}/{state.total_samples} samples')
            words.append(clock(state.elapsed))
            if state.remaining is not None and state.fraction < 1.0:
                words.append(f'{clock(state.remaining)} left')
        else:
            words.append(state.phase)
        if state.memory:
            words.append(f'{state.memory / MEBIBYTE:.0f} MB')
        return ' | '.join(word for word in words if word)

    def _show(self, line: str) -> None:
        line = line[: shutil.get_terminal_size().columns - 1]
        self._out.write('\r' + line + ' ' * max(0, len(self._line) - len(line)))
        self._out.flush()
        self._line = line

    def _end_line(self) -> None:
        if self._line:
            self._out.write('\n')
            self._line = ''
        self._out.flush()

    def _print(self, text: str) -> None:
        if self._line:
            self._out.write('\r' + ' ' * len(self._line) + '\r')
            self._line = ''
        self._out.write(text + '\n')
        self._out.flush()


def clock(seconds: float) -> str:
    """Minutes and seconds, with hours where there are any."""
    whole = max(0, round(seconds))
    hours, minutes = divmod(whole // 60, 60)
    return f'{hours}:{minutes:02d}:{whole % 60:02d}' if hours else f'{minutes}:{whole % 60:02d}'
