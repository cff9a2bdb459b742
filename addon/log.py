# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render has to say to its user: messages, each once, and the question whether to go on.

It knows neither `bpy` nor a terminal: where messages go is decided by whoever makes the Log.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

# Messages of one level beyond this count are kept but not shown: thousands of lines would hide what matters.
SHOWN_PER_LEVEL = 50


def spelled(text: str) -> str:
    """The text as Blender takes it: names and paths may hold bytes that are no UTF-8, at which it would raise."""
    return text.encode('utf-8', 'backslashreplace').decode('utf-8').replace('\0', '\\0')


class Cancelled(Exception):
    """The user asked to stop. Not an error: what is rendered so far is kept."""


class Log:
    """Messages of one render of one view layer.

    show:        receives each new (level, text), level being 'INFO', 'WARNING' or 'ERROR'.
    should_stop: says whether the user pressed Esc or Ctrl-C.
    messages:    all messages in the order they came, without duplicates.
    """

    def __init__(
        self,
        show: Callable[[str, str], None] | None = None,
        should_stop: Callable[[], bool] | None = None,
    ) -> None:
        self.messages: list[tuple[str, str]] = []
        self._seen: set[tuple[str, str]] = set()
        self._count: dict[str, int] = {}
        self._show = show
        self._should_stop = should_stop

    def info(self, text: str) -> None:
        self._add('INFO', text)

    def warning(self, text: str) -> None:
        self._add('WARNING', text)

    def error(self, text: str) -> None:
        """Something without which the render cannot be right: it ends as failed, whatever was rendered until then."""
        self._add('ERROR', text)

    def repeat(self, messages: Iterable[tuple[str, str]]) -> None:
        """What was said when something was read that is now known."""
        for level, text in messages:
            self._add(level, text)

    def stopped(self) -> bool:
        """Whether the user asked to stop. Cheap enough to be asked for each mesh."""
        return self._should_stop is not None and self._should_stop()

    def checkpoint(self) -> None:
        """Raise Cancelled if the user asked to stop."""
        if self.stopped():
            raise Cancelled

    def close(self) -> None:
        """Say how many messages were kept back."""
        for level, count in self._count.items():
            if count > SHOWN_PER_LEVEL and self._show is not None:
                self._show(level, f'{count - SHOWN_PER_LEVEL} more messages of this kind are in the statistics file')

    def texts(self, level: str) -> list[str]:
        return [text for at, text in self.messages if at == level]

    def _add(self, level: str, text: str) -> None:
        if (level, text) in self._seen:
            return
        self._seen.add((level, text))
        self.messages.append((level, text))
        self._count[level] = self._count.get(level, 0) + 1
        if self._show is not None and self._count[level] <= SHOWN_PER_LEVEL:
            self._show(level, text)
