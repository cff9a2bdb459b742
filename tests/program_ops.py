# SPDX-License-Identifier: GPL-3.0-or-later
"""The pure ops of shading programs as NumPy functions, compiled from kernels/program/, and the list of all ops.

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


def evaluate(name: str, mode: int, arguments: np.ndarray) -> np.ndarray:
    """Results, (n, 3) or of a number (n,), of an op for (n, k) arguments one after the other."""
    op = ops()[name]
    padded = np.zeros((len(arguments), ARGUMENTS), np.float32)
    padded[:, : arguments.shape[1]] = arguments
    results = np.empty((len(arguments), 3), np.float32)
    library().test_pure(
        op.number,
        mode,
        ctypes.c_size_t(len(arguments)),
        ctypes.c_void_p(padded.ctypes.data),
        ctypes.c_void_p(results.ctypes.data),
    )
    return results if op.result == 'v' else results[:, 0]
