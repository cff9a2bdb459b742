# SPDX-License-Identifier: GPL-3.0-or-later
"""Each kernel function computes on lavapipe (Vulkan) what it computes on the CPU, over random inputs.

Equal images are not the claim: per function, equal bits or a stated tolerance are (tests/kernel_cases.py).
"""

from __future__ import annotations

import ctypes
import re
from functools import cache
from pathlib import Path

import cotorra_native
import pytest

import kernel_cases
import kernel_cases_bvh
import kernel_cases_closures
import kernel_cases_integrators
import kernel_cases_lights
import kernel_cases_models
import kernel_cases_path
import kernel_cases_program
import kernel_cases_shading
import kernel_cases_textures
import kernel_source as kernels
from kernel_inputs import scene
from kernel_parity import ALL_FEATURES, Case, build_cpu, differences, run_cpu, run_vulkan
from vulkan import Runner

pytestmark = pytest.mark.early

CASES = [
    *kernel_cases.CASES,
    *kernel_cases_bvh.CASES,
    *kernel_cases_closures.CASES,
    *kernel_cases_integrators.CASES,
    *kernel_cases_lights.CASES,
    *kernel_cases_models.CASES,
    *kernel_cases_path.CASES,
    *kernel_cases_program.CASES,
    *kernel_cases_shading.CASES,
    *kernel_cases_textures.CASES,
]


@cache
def cpu(features: int) -> ctypes.CDLL:
    return build_cpu(CASES if features else kernel_cases_path.CASES, features)


def compare(case: Case, lavapipe: Runner, features: int) -> None:
    inputs = case.draw()
    on_cpu = run_cpu(cpu(features), case, inputs, scene())
    found = differences(case, inputs, on_cpu, run_vulkan(lavapipe, case, inputs, scene(), features))
    assert not found, '\n'.join(found)


@pytest.mark.parametrize('case', CASES, ids=lambda case: case.name)
def test_same_on_cpu_and_vulkan(case: Case, lavapipe: Runner) -> None:
    compare(case, lavapipe, ALL_FEATURES)


@pytest.mark.every(3)
@pytest.mark.parametrize('case', kernel_cases_path.CASES, ids=lambda case: case.name)
def test_same_with_every_feature_off(case: Case, lavapipe: Runner) -> None:
    """The kernels branch on features while they are compiled: both languages must leave out the same."""
    compare(case, lavapipe, 0)


@pytest.mark.parametrize('header', kernels.HEADERS, ids=lambda path: path.stem)
def test_every_function_has_a_row(header: Path) -> None:
    """A function that nobody calls in the table is compared with nothing."""
    called = {name for case in CASES for name in re.findall(r'(\w+)\(', case.body)}
    missing = [name for name in kernels.functions(header) if name not in called]
    assert not missing, f'add rows for these to tests/kernel_cases.py: {", ".join(missing)}'


def named_in_rows() -> set[str]:
    """What the bodies of rows call, ops that they call by number included."""
    called = {name for case in CASES for name in re.findall(r'(\w+)\(', case.body)}
    return called | {f'op_{op}' for case in CASES for op in case.ops}


def test_every_op_has_a_row() -> None:
    """Each op runs in a row, under its name or by its number."""
    called = named_in_rows()
    missing = [op for op in cotorra_native.shader_ops() if f'op_{op}' not in called]
    assert not missing, f'add rows for these to tests/kernel_cases_shading.py: {", ".join(missing)}'


@pytest.mark.parametrize('header', kernels.PROGRAM_HEADERS, ids=lambda path: path.stem)
def test_every_program_function_is_reached(header: Path) -> None:
    """What ops are made of runs with them. No op counts because something calls it by number: a row must."""
    calls = {name: body for path in kernels.PROGRAM_HEADERS for name, body in kernels.bodies(path).items()}
    # program_context alone calls ops by number that are no functions of their own name.
    reached, new = set(), named_in_rows()
    while new:
        reached |= new
        called = {callee for name in new for callee in re.findall(r'(\w+)\(', calls.get(name, ''))}
        new = {name for name in called if name in calls and not name.startswith('op_')} - reached
    missing = [name for name in kernels.functions(header) if name not in reached]
    assert not missing, f'nothing in the rows of tests/kernel_cases_*.py leads to: {", ".join(missing)}'


def test_tolerances_have_reasons() -> None:
    for case in CASES:
        for tolerance in (case.tolerance, *case.tolerances.values()):
            assert tolerance.reason
