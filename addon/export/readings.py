# SPDX-License-Identifier: GPL-3.0-or-later
"""What the nodes of a tree were found to give: each node is read once, however many inputs it feeds.

What a node means is told in surface.py and texture_nodes.py.
"""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, field
from typing import Any

from .nodes import Source, Trees, sources_in_order

# Nodes that are read one within the other; below them, nodes are read in order, so that Python's stack suffices.
DEPTH_MAX = 30


class UnreadError(Exception):
    """A value that comes from a node that is not understood."""

    def __init__(self, found: Source) -> None:
        super().__init__(found.node.name)
        self.source = found


@dataclass(slots=True)
class Readings:
    """ways: for each way to read a node, the types of nodes that it is for, and the function that does it."""

    trees: Trees
    ways: dict[str, tuple[Container[str], Callable[[Source], Any]]]
    _known: dict[tuple, Any] = field(default_factory=dict)
    _depth: int = 0

    def read(self, way: str, found: Source) -> Any:
        """What a node gives, read in one of the ways. Raises UnreadError."""
        key = (way, found.output, found.contexts)
        if key not in self._known and self._depth == DEPTH_MAX:
            self._read_below(found)
        if key not in self._known:
            self._depth += 1
            self._known[key] = self._result(way, found)
            self._depth -= 1
        result = self._known[key]
        if isinstance(result, UnreadError):
            raise result
        return result

    def _read_below(self, found: Source) -> None:
        depth, self._depth = self._depth, 0
        for below in sources_in_order(self.trees, found.all_inputs()):
            for way, (types, _) in self.ways.items():
                if below.node.type in types:
                    self._known.setdefault((way, below.output, below.contexts), self._result(way, below))
        self._depth = depth

    def _result(self, way: str, found: Source) -> Any:
        try:
            return self.ways[way][1](found)
        except UnreadError as unread:
            return unread
