# SPDX-License-Identifier: GPL-3.0-or-later
"""How a render looks at a terminal: one progress line that updates, or few lines where the output is not a terminal.

It writes to one stream, asks whether to stop, and knows nothing of Blender.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TextIO

from .watch import STOP_SIGNALS, Progress, Watcher

FAILED, WRONG_ARGUMENTS, INTERRUPTED = 1, 2, 130

MEBIBYTE = 1024.0 * 1024.0
SPARSE_SECONDS = 10.0
BAR_CELLS = 24


class CommandError(Exception):
    """Why nothing, or not all, was rendered; shown after the program's name."""

    def __init__(self, text: str, code: int = FAILED) -> None:
        super().__init__(text)
        self.code = code


class TerminalWatcher(Watcher):
    """Prints progress and messages to a stream, as long as it takes them.

    out: None where stderr was closed from the start.
    """

    def __init__(self, out: TextIO | None) -> None:
        self.stop = False
        self.label = ''  # the frame, where there are several
        self._out = out
        self._updates = out is not None and out.isatty()
        encoding = (out.encoding or '') if out is not None else ''
        self._blocks = '█░' if encoding.lower().replace('-', '') == 'utf8' else '#.'
        self._line = ''
        self._next_sparse = 0.0
        self._told: dict[tuple[str, str], None] = {}

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

    def status(self, text: str, fraction: float | None = None, elapsed: float = 0.0, left: float = 0.0) -> None:
        """What work other than one render is at; fraction: of all of it, with seconds so far and seconds left."""
        if fraction is None:
            words = text
        else:
            words = f'{text} | {100.0 * fraction:.0f} % | {clock(elapsed)} | {clock(left)} left'
        if self._updates:
            cells = round((fraction or 0.0) * BAR_CELLS)
            bar = self._blocks[0] * cells + self._blocks[1] * (BAR_CELLS - cells)
            self._show(f'{bar} {words}' if fraction is not None else words)
            return
        now = time.perf_counter()
        if fraction is None or now >= self._next_sparse:
            self._print(words)
            self._next_sparse = now + SPARSE_SECONDS

    def message(self, level: str, text: str) -> None:
        """Print a message, once however many view layers and frames repeat it."""
        if (level, text) not in self._told:
            self._told[level, text] = None
            self._print(f'{level.capitalize()}: {text}')

    def warnings(self) -> list[str]:
        """All warnings so far, in the order they came."""
        return [text for level, text in self._told if level == 'WARNING']

    def note(self, text: str) -> None:
        self._print(text)

    @contextmanager
    def stopped_by_signals(self) -> Iterator[None]:
        """While the block runs, Ctrl-C, SIGTERM and SIGHUP are the wish to stop.

        A second Ctrl-C quits at once. The others often come twice (`timeout` and shells send them to a process and to
        its group), so nothing but the first counts; one that is ignored from the start, as by `nohup`, stays so.
        """
        before = {}
        for name in STOP_SIGNALS:
            number = getattr(signal, name, None)  # Windows has no SIGHUP
            if number is not None and (name == 'SIGINT' or signal.getsignal(number) is not signal.SIG_IGN):
                before[number] = signal.signal(number, self._interrupt)
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def _interrupt(self, _signal: int, _frame: FrameType | None) -> None:
        if self.stop:
            return
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
        self._write('\r' + line + ' ' * max(0, len(self._line) - len(line)))
        self._line = line

    def _end_line(self) -> None:
        if self._line:
            self._write('\n')
            self._line = ''

    def _print(self, text: str) -> None:
        if self._line:
            self._write('\r' + ' ' * len(self._line) + '\r')
            self._line = ''
        self._write(text + '\n')

    def _write(self, text: str) -> None:
        """Write, if there is anyone to write to: a terminal that was closed and a full disk end no render."""
        if self._out is None:
            return
        try:
            try:
                self._out.write(text)
            except UnicodeEncodeError as error:
                self._out.write(text.encode(error.encoding, 'backslashreplace').decode(error.encoding))
            self._out.flush()
        except (BlockingIOError, RuntimeError):
            pass  # the terminal is behind, or a signal came while a line was being written: the next line may do
        except (OSError, ValueError):
            self._out = None


def open_standard_streams() -> None:
    """Give what was closed to the null device, else the next file that is opened would get all that Blender prints."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


def flush_standard_streams() -> None:
    """Write what is still buffered; what nobody takes is dropped, else Python would end with a failure of its own."""
    for number, stream in ((1, sys.stdout), (2, sys.stderr)):
        try:
            if stream is not None:
                stream.flush()
        except (OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, number)
            os.close(nowhere)


def clock(seconds: float) -> str:
    """Minutes and seconds, with hours where there are any."""
    whole = max(0, round(seconds))
    hours, minutes = divmod(whole // 60, 60)
    return f'{hours}:{minutes:02d}:{whole % 60:02d}' if hours else f'{minutes}:{whole % 60:02d}'
