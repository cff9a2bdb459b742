# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured luminaires (IES LM-63 files) as look-up tables over all directions, symmetries unfolded as Cycles does.

Which node reads which file is nodes_texture.py's; how a table is read is in kernels/program/ies.h.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..export.buffers import F32

# Candela to the watts of a lamp of this strength: 4 pi over the luminous efficacy of D65, lumen per watt.
WATTS = 4.0 * np.pi / 177.83
TYPE_C, TYPE_B, TYPE_A = 1, 2, 3  # photometric types as files number them
ENTRIES_MAX = 1 << 22
CLOSE = 1e-4  # degrees


class IesError(Exception):
    """Why there is no table."""


@dataclass(frozen=True, slots=True)
class Luminaire:
    """table: angles in radians, horizontal ones first, and (horizontal + 2, vertical + 2) strengths."""

    table: F32
    horizontal: int
    vertical: int


@lru_cache(maxsize=64)
def read(text: str) -> Luminaire:
    """The table of a file. Raises IesError."""
    kind, vertical, horizontal, candela = _parse(text)
    if kind == TYPE_A:
        return _table(*_type_a(horizontal, candela), vertical + 90.0)
    if kind == TYPE_B:
        # Its poles lie at the sides: whoever wants them there turns the lamp.
        horizontal, columns = _both_sides(horizontal, candela)
        vertical, rows = _both_sides(vertical, columns.T)
        return _table(vertical, rows, horizontal)
    return _table(*_type_c(horizontal, candela), vertical)


def _parse(text: str) -> tuple[int, np.ndarray, np.ndarray, np.ndarray]:
    """Photometric type, vertical and horizontal angles in degrees, and strengths (horizontal, vertical)."""
    lines = text.splitlines()
    tilt = next((number for number, line in enumerate(lines) if number and line.startswith('TILT=')), None)
    if tilt is None:
        raise IesError('it is no IES file: no line begins with TILT=')
    numbers = _numbers(lines[tilt + 1 :])
    at = 0
    if lines[tilt].startswith('TILT=INCLUDE'):
        at = 2 + 2 * int(_at(numbers, 1))  # of a lamp that is tilted: not for what it shines on
    factor = _at(numbers, at + 2) * _at(numbers, at + 10) * _at(numbers, at + 11) * WATTS
    v, h, kind = (int(_at(numbers, at + k)) for k in (3, 4, 5))
    if kind not in (TYPE_A, TYPE_B, TYPE_C):
        raise IesError(f'its photometric type is {kind}, not 1, 2 or 3')
    if not (0 < v <= ENTRIES_MAX and 0 < h <= ENTRIES_MAX and v * h <= ENTRIES_MAX):
        raise IesError(f'it has {v} by {h} angles')
    at += 13
    if len(numbers) < at + v + h + v * h:
        raise IesError('it ends too early')
    vertical, horizontal = numbers[at : at + v], numbers[at + v : at + v + h]
    candela = factor * numbers[at + v + h : at + v + h + v * h].reshape(h, v)
    if not (np.isfinite(candela).all() and np.isfinite(vertical).all() and np.isfinite(horizontal).all()):
        raise IesError('a number of it is not finite')
    return kind, vertical, horizontal, candela


def _numbers(lines: list[str]) -> np.ndarray:
    """All numbers up to the first word that is none."""
    found: list[float] = []
    for word in ' '.join(lines).replace(',', ' ').split():
        try:
            found.append(float(word))
        except ValueError:
            break
    return np.array(found)


def _at(numbers: np.ndarray, index: int) -> float:
    if not 0 <= index < len(numbers) or not abs(numbers[index]) < 1e15:
        raise IesError('it ends too early')
    return float(numbers[index])


def _is(angle: float, what: float) -> bool:
    return abs(angle - what) < CLOSE


def _both_sides(angles: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles from -90 to 90 degrees, or 0 to 90 and the same on the other side, as 0 to 180."""
    if not _is(angles[0], 0.0):
        return angles + 90.0, rows
    return np.concatenate([90.0 - angles[:0:-1], 90.0 + angles]), np.concatenate([rows[:0:-1], rows])


def _type_a(horizontal: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal angles from -90 to 90, or 0 to 90 and the same on the other side, run backward about 180 degrees."""
    angles, found = 180.0 - horizontal[::-1], rows[::-1]
    if _is(horizontal[0], 0.0):
        angles, found = np.concatenate([angles, 180.0 + horizontal[1:]]), np.concatenate([found, rows[1:]])
    return angles, found


def _type_c(horizontal: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal angles from 0 to 360 degrees, or a half or a quarter of them."""
    angles = horizontal
    if _is(angles[0], 90.0):
        angles = angles - 90.0
    if len(angles) == 1:
        return np.array([0.0, 360.0]), np.concatenate([rows, rows])
    for end in (90.0, 180.0):  # a quarter is mirrored to a half, and a half to all
        if _is(angles[-1], end):
            angles = np.concatenate([angles, 2.0 * end - angles[-2::-1]])
            rows = np.concatenate([rows, rows[-2::-1]])
    gap = 360.0 - angles[-1]
    steps = (angles[-1] - angles[-2], angles[1] - angles[0])
    if _is(angles[0], 0.0) and not _is(gap, 0.0) and any(_is(step, gap) for step in steps):
        angles, rows = np.append(angles, 360.0), np.concatenate([rows, rows[:1]])
    return angles, rows


def _table(horizontal: np.ndarray, rows: np.ndarray, vertical: np.ndarray) -> Luminaire:
    """With a row and a column beyond each end, as Cycles 5.2 reads them (found by changing one strength at a time).

    Below a pole lies what is above it; else an end is repeated. Only behind the last horizontal angle the last row but
    one comes again, whether the angles make a full turn or not.
    """
    if len(horizontal) < 2 or len(vertical) < 2:
        raise IesError('it has one angle only')
    h, v = np.radians(horizontal).astype(np.float32), np.radians(vertical).astype(np.float32)
    if (np.diff(h) < 0.0).any() or (np.diff(v) < 0.0).any():
        raise IesError('its angles do not ascend')
    before = rows[:, 1] if v[0] < 1e-7 else rows[:, 0]
    wide = np.column_stack([before, rows, rows[:, -1]])
    table = np.concatenate([h, v, wide[0], wide.ravel(), wide[-2]]).astype(np.float32)
    return Luminaire(table, len(h), len(v))
