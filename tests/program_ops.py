# SPDX-License-Identifier: GPL-3.0-or-later
"""The ops of shading programs as NumPy functions, compiled from kernels/program/, and the list of all ops.

What is demanded of them stands in test_ops.py and test_ops_cycles.py.
"""

from __future__ import annotations

import ctypes
import functools
from dataclasses import dataclass

import numpy as np

from native_build import build

ARGUMENTS = 32  # floats that an op may take


@dataclass(frozen=True)
class Op:
    """A line of kernels/program/ops.inc; `f` is a float, `v` is three."""

    name: str
    number: int
    kind: str
    result: str
    arguments: str

    def offset(self, argument: int) -> int:
        """Where an argument begins among the floats of all."""
        return sum(3 if kind == 'v' else 1 for kind in self.arguments[:argument])


@functools.cache
def library() -> ctypes.CDLL:
    return build('ops_test', ['tests/native/ops_test.cpp'])


class _Row(ctypes.Structure):
    _fields_ = (
        ('name', ctypes.c_char_p),
        ('number', ctypes.c_uint32),
        ('kind', ctypes.c_char_p),
        ('result', ctypes.c_char_p),
        ('arguments', ctypes.c_char_p),
    )


@functools.cache
def ops() -> dict[str, Op]:
    """Every op by its name, as the list has them."""
    found: list[Op] = []
    for row in (_Row * 1024).in_dll(library(), 'test_ops'):
        if row.name is None:  # the last row
            break
        found.append(Op(row.name.decode(), row.number, row.kind.decode(), row.result.decode(), row.arguments.decode()))
    return {op.name: op for op in found}


def evaluate(
    name: str, mode: int, arguments: np.ndarray, table: np.ndarray | None = None, image: np.ndarray | None = None
) -> np.ndarray:
    """Results, (n, 3) or of a number (n,), of an op for (n, k) arguments one after the other.

    table: floats, at offset 0 of the scene's tables. image: (height, width, 4), bottom row first, number 0.
    """
    op = ops()[name]
    padded = np.zeros((len(arguments), ARGUMENTS), np.float32)
    padded[:, : arguments.shape[1]] = arguments
    results = np.empty((len(arguments), 3), np.float32)
    calls = (op.number, mode, ctypes.c_size_t(len(arguments)), _pointer(padded), _pointer(results))
    if op.kind == 'PURE':
        library().test_pure(*calls)
    else:
        table = np.ascontiguousarray(np.zeros(1) if table is None else table, np.float32)
        image = np.ascontiguousarray(np.zeros((1, 1, 4)) if image is None else image, np.float32)
        library().test_table(*calls, _pointer(table), _pointer(image), image.shape[1], image.shape[0])
    return results if op.result == 'v' else results[:, 0]


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
