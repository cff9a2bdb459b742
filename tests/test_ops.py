# SPDX-License-Identifier: GPL-3.0-or-later
"""The ops of shading programs by themselves: their list, what breaks naive code, and loops over lanes.

What they compute is compared with Cycles (test_ops_cycles.py), and GLSL with C++ (test_kernels_lavapipe.py).
"""

from __future__ import annotations

import platform
import subprocess

import numpy as np
import pytest

import kernel_source as kernels
from native_build import build_program
from program_ops import ARGUMENTS, evaluate, ops

BATCHES = ['tests/native/program_bench.cpp', 'native/cpu_program.cpp', 'native/cpu_textures.cpp']
VECTOR_FLAGS = ('-O3', '-fno-math-errno', '-fno-trapping-math')
NAMES = ('-DCOTORRA_PROGRAM_NAME=program_batch', '-DCOTORRA_PROGRAM_LOOPS=program_loops')


def test_list() -> None:
    numbers = [op.number for op in ops().values()]
    assert len(set(numbers)) == len(numbers)
    assert max(numbers) < kernels.constants()['OP_NUMBERS']
    for op in ops().values():
        assert op.kind in {'CONTEXT', 'PURE', 'TABLE'}
        assert op.result in {'f', 'v'}
        assert set(op.arguments) <= {'f', 'v'}
        assert op.offset(len(op.arguments)) <= ARGUMENTS


def test_every_pure_op_is_called_by_number() -> None:
    """Ops that nobody compares with a node: what links between sockets do."""
    a = np.array([[0.25, -3.0, 5.0, 2.0, 0, 0, 0, 3.0, 0, 0, 0, 4.0, 7.0, 8.0, 9.0]], np.float32)
    np.testing.assert_allclose(evaluate('splat', 0, a), [[0.25, 0.25, 0.25]])
    np.testing.assert_allclose(evaluate('average', 0, a), [0.75])
    np.testing.assert_allclose([evaluate('component', i, a)[0] for i in range(3)], [0.25, -3.0, 5.0])
    np.testing.assert_allclose(evaluate('combine', 0, a), [[0.25, -3.0, 5.0]])
    # Rows (2, 0, 0), (0, 3, 0), (0, 0, 4), then a translation.
    np.testing.assert_allclose(evaluate('affine', 0, a), [[7.5, -1.0, 29.0]])


def test_extremes() -> None:
    flags = ('-fsanitize=undefined,float-cast-overflow', '-fno-sanitize-recover=all')
    program = build_program('ops_extremes', ['tests/native/ops_extremes.cpp'], flags)
    result = subprocess.run([program], capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stdout + result.stderr


def test_batches_say_what_one_point_says() -> None:
    """The same bits, whether g++ made vector code of a loop over points or not."""
    if platform.machine() != 'x86_64':
        pytest.skip('the flags are those of x86-64')
    program = build_program('program_bench', BATCHES, (*VECTOR_FLAGS, *NAMES, '-march=x86-64-v2'))
    result = subprocess.run([program], capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stdout
