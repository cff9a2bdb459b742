# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of node sockets: what is typed into them, and how one type becomes another, as Blender does it.

It follows no link: nodes.py does.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy

Color = tuple[float, ...]  # three, scene-linear

BLACK = (0.0, 0.0, 0.0)

# Luminance of linear Rec.709, Blender's default working space: what a colour is where a number is asked for.
LUMINANCE = (0.2126390, 0.7151687, 0.0721923)

# Colours and vectors have three components; menus are text.
Value = Color | float | bool | str

INT_MAX = 2**31 - 1


def as_color(value: Color | float | bool) -> Color:
    return value if isinstance(value, tuple) else (float(value),) * 3


def as_float(value: Color | float | bool) -> float:
    if isinstance(value, tuple):
        return sum(part * weight for part, weight in zip(value, LUMINANCE, strict=True))
    return float(value)


def own_value(socket: bpy.types.NodeSocket) -> Value:
    """The value that a socket has where nothing is linked to it; 0 for sockets that hold none (shaders)."""
    value = getattr(socket, 'default_value', 0.0)
    return value if isinstance(value, (int, float, bool, str)) else tuple(value)[:3]


def converted(value: Value, types: tuple[str, ...]) -> Value:
    """A value of the first type as it is after a conversion to each of the others in turn.

    A shader made of a value is its colour; what cannot be converted becomes 0.
    """
    at = types[0]
    for kind in types[1:]:
        if (at, kind) == ('VECTOR', 'BOOLEAN'):
            value = any(value)
        elif kind != at:
            value = ZEROS[kind] if at not in NUMBERS or kind not in INTO else INTO[kind](NUMBERS[at](value))
        at = kind
    return value


# The types that can be converted: to three numbers, and to the one that counts where one is asked for.
NUMBERS: dict[str, Callable[[Value], tuple[Color, float]]] = {
    'VALUE': lambda value: ((value,) * 3, value),
    'INT': lambda value: ((float(value),) * 3, value),
    'BOOLEAN': lambda value: ((float(value),) * 3, value),
    'RGBA': lambda value: (value, as_float(value)),
    'SHADER': lambda value: (value, as_float(value)),
    'VECTOR': lambda value: (value, sum(value) / 3.0),
}

INTO: dict[str, Callable[[tuple[Color, float]], Value]] = {
    'VALUE': lambda numbers: float(numbers[1]),
    'INT': lambda numbers: _whole(numbers[1]),
    'BOOLEAN': lambda numbers: numbers[1] > 0.0,
    'RGBA': lambda numbers: numbers[0],
    'SHADER': lambda numbers: numbers[0],
    'VECTOR': lambda numbers: numbers[0],
}

ZEROS: dict[str, Value] = {
    'VALUE': 0.0,
    'INT': 0,
    'BOOLEAN': False,
    'RGBA': BLACK,
    'SHADER': BLACK,
    'VECTOR': BLACK,
}

VALUES = frozenset(NUMBERS) - {'SHADER'}


def _whole(number: float) -> int:
    """Towards 0, within what Blender's integers hold."""
    return int(min(max(number, -INT_MAX), INT_MAX)) if math.isfinite(number) else 0
