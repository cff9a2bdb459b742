# SPDX-License-Identifier: GPL-3.0-or-later
"""The ops and closures that shaders are made of, as the native module lists them.

What an op computes is in the kernels; which node needs which op is told in the nodes_*.py beside this file.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from .. import native


@dataclass(frozen=True, slots=True)
class Op:
    """number: in a program; result: 'f' (one float) or 'v' (three); arguments: one such letter each."""

    number: int
    result: str
    arguments: str


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of closure: its number, and the letters of its arguments as in `Op`."""

    number: int
    arguments: str


@dataclass(frozen=True, slots=True)
class Tables:
    """All ops and all kinds of closures, by name."""

    ops: dict[str, Op]
    closures: dict[str, Kind]


@cache
def tables() -> Tables:
    module = native.load()
    return Tables(
        {name: Op(*row) for name, row in module.shader_ops().items()},
        {name: Kind(*row) for name, row in module.shader_closures().items()},
    )
