# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers that Blender lets through and no formula can take: NaN, infinity, and what is near the end of the range.

They are replaced where Blender's values become arrays, with a warning that names their owner. What the user may set is
properties.py's; sums that overflow all the same are rejected by the film (kernels/film.h).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy
import numpy as np

# Its square, summed over all samples that a pixel may take (choices.SAMPLES_MAX), is a number of single precision.
LARGEST = 1e15

Warn = Callable[[str], None]


def number(
    value: float, default: float, what: str, warn: Warn, least: float = -LARGEST, most: float = LARGEST
) -> float:
    """The value where it is from least to most; `default` where it is not finite, else the nearer of both."""
    if not np.isfinite(value):
        warn(f'{what} is not a finite number; {default:g} is used')
        return default
    if not least <= value <= most:
        nearest = min(max(value, least), most)
        warn(f'{what} is {value:g}: beyond what can be rendered; {nearest:g} is used')
        return nearest
    return value


def of_property(
    owner: bpy.types.bpy_struct, name: str, warn: Warn, least: float = -LARGEST, most: float = LARGEST
) -> float:
    """A property that is a number; Blender keeps it within its own limits, save for NaN."""
    found = owner.bl_rna.properties[name]
    return number(getattr(owner, name), found.default, found.name, warn, least, most)


def color(values: Sequence[float], default: Sequence[float], what: str, warn: Warn) -> tuple[float, ...]:
    """As `number` for each component, with one message."""
    if not np.isfinite(values).all():
        warn(f'{what} is not a finite number; {_shown(default)} is used')
        return tuple(default)
    clamped = tuple(min(max(float(part), -LARGEST), LARGEST) for part in values)
    if clamped != tuple(map(float, values)):
        warn(f'{what} is {_shown(values)}: beyond what can be rendered; {_shown(clamped)} is used')
    return clamped


def column(values: np.ndarray, default: object, what: str, warn: Callable[[int, str], None]) -> None:
    """As `number` for an array (N, ...) in place: what is not finite becomes `default`; `warn` gets the row, too.

    what: its field's name, which is told as words.
    """
    what = what.replace('_', ' ')
    flat = values.reshape(len(values), -1)
    finite = np.isfinite(flat).all(axis=1)
    for row in np.flatnonzero(~finite):
        warn(int(row), f'{what} is not a finite number; the default is used')
    values[~finite] = default
    for row in np.flatnonzero((np.abs(flat) > LARGEST).any(axis=1)):
        warn(int(row), f'{what} is beyond what can be rendered; {LARGEST:g} is used')
    np.clip(values, -LARGEST, LARGEST, out=values)


def _shown(values: Sequence[float]) -> str:
    return ' '.join(f'{value:g}' for value in values)
