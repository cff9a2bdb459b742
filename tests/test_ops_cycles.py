# SPDX-License-Identifier: GPL-3.0-or-later
"""Each pure op, and each op that reads a table or an image, against the node of Cycles that it stands for.

All nodes are rendered in one picture, a facet a pixel with random inputs of its own (cycles_ops.py, op_cases.py).
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest

import cycles_ops
import op_cases
import op_cases_tables
from op_cases import Case
from op_cases_tables import TableCase
from program_ops import evaluate, ops

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 2), reason='the formulas are those of Blender 5.2')

CASES = op_cases.every_case() if bpy.app.version >= (5, 2) else []
TABLE_CASES = op_cases_tables.every_case() if bpy.app.version >= (5, 2) else []
# No node stands for these alone: they are what links between sockets do, and other nodes are read to.
WITHOUT_NODE = {'splat', 'average', 'component', 'combine', 'affine'}


@pytest.fixture(scope='module')
def rendered(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    cases = [*CASES, *(entry.case for entry in TABLE_CASES)]
    inputs = [case.draw() for case in cases]
    normals = np.concatenate(
        [op_cases_tables.normals_of(case, array) for case, array in zip(cases, inputs, strict=True)]
    )
    path = tmp_path_factory.mktemp('ops') / 'ops.exr'
    results = cycles_ops.render([case.node for case in cases], inputs, path, normals)
    return {case.name: result for case, result in zip(cases, results, strict=True)}


def compare(case: Case, got: np.ndarray, want: np.ndarray) -> None:
    """Errors, relative to the value or, where it is smaller, to the mean of all."""
    got = case.fold(got)
    got = got if got.ndim == 2 else np.repeat(got[:, None], 3, 1)
    assert np.isfinite(got).all(), f'not finite for {case.draw()[~np.isfinite(got).all(1)][0]}'
    # Where Cycles divides by 0 its own way, any number is better.
    finite = np.isfinite(want).all(1)
    assert finite.mean() > 0.9
    got, want = got[finite], want[finite]
    error = (np.abs(got - want) / np.maximum(np.abs(want), max(np.abs(want).mean(), 1e-6))).max(1)
    far = error > 1e-3
    worst = int(error.argmax())
    told = f'{case.draw()[finite][worst]}: {got[worst]}, Cycles {want[worst]}; {far.mean():.3f} are off'
    assert far.mean() <= case.steps, told
    assert np.where(far, 0.0, error).mean() <= 5e-4, told


@pytest.mark.parametrize('case', CASES, ids=lambda case: case.name)
def test_pure_op(case: Case, rendered: dict[str, np.ndarray]) -> None:
    compare(case, evaluate(case.op, case.mode, case.draw()), rendered[case.name])


@pytest.mark.parametrize('entry', TABLE_CASES, ids=lambda entry: entry.case.name)
def test_table_op(entry: TableCase, rendered: dict[str, np.ndarray]) -> None:
    case = entry.case
    table = op_cases_tables.baked(entry)
    compare(case, evaluate(case.op, case.mode, case.draw(), table, op_cases_tables.image()), rendered[case.name])


def test_every_op_is_compared() -> None:
    compared = {case.op for case in CASES} | {entry.case.op for entry in TABLE_CASES}
    assert {op.name for op in ops().values() if op.kind != 'CONTEXT'} == compared | WITHOUT_NODE


def test_names_differ() -> None:
    """Results are kept by name."""
    names = [case.name for case in CASES] + [entry.case.name for entry in TABLE_CASES]
    assert len(set(names)) == len(names)
