# SPDX-License-Identifier: GPL-3.0-or-later
"""IES files: what is read of each type, symmetry and fault, and lamps of each type beside Cycles.

How the table is looked up is kernels/program/ies.h's; here a look-up in double precision stands beside it.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra.shader import ies

from ies_files import STREET, ies_text
from light_scenes import assert_as_cycles, corner, hang
from scenes import build
from scenes.depsgraphs import messages

QUARTER = ((0, 30, 60, 90), (0, 45, 90))
ROWS = np.arange(12, dtype=float).reshape(3, 4) + 1.0


def split(found: ies.Luminaire) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Horizontal and vertical angles in degrees, and strengths in candela without the margin."""
    h, v = found.horizontal, found.vertical
    wide = found.table[h + v :].reshape(h + 2, v + 2).astype(float)
    return np.degrees(found.table[:h]), np.degrees(found.table[h : h + v]), wide[1:-1, 1:-1] / ies.WATTS


def test_a_quarter_is_unfolded_to_all() -> None:
    h, v, candela = split(ies.read(ies_text(*QUARTER, ROWS)))
    assert h == pytest.approx([0, 45, 90, 135, 180, 225, 270, 315, 360])
    assert v == pytest.approx([0, 30, 60, 90])
    assert candela == pytest.approx(ROWS[[0, 1, 2, 1, 0, 1, 2, 1, 0]])


def test_one_angle_holds_all_around() -> None:
    h, _, candela = split(ies.read(ies_text((0, 90, 180), (0,), [[3, 2, 1]])))
    assert h == pytest.approx([0, 360]) and candela == pytest.approx(np.array([[3, 2, 1], [3, 2, 1]]))


def test_a_full_turn_without_its_end_gets_it() -> None:
    h, _, candela = split(ies.read(ies_text((0, 90), (0, 120, 240), [[1, 2], [3, 4], [5, 6]])))
    assert h == pytest.approx([0, 120, 240, 360]) and candela[-1] == pytest.approx(candela[0])


def test_type_b_lies_on_its_side() -> None:
    h, v, candela = split(ies.read(ies_text((-90, 0, 90), (0, 45, 90), ROWS[:, :3], kind=2)))
    assert h == pytest.approx([0, 90, 180]) and v == pytest.approx([0, 45, 90, 135, 180])
    assert candela == pytest.approx(ROWS[[2, 1, 0, 1, 2], :3].T)


def test_type_a_runs_backward() -> None:
    h, v, candela = split(ies.read(ies_text((-90, 0, 90), (0, 45, 90), ROWS[:, :3], kind=3)))
    assert h == pytest.approx([90, 135, 180, 225, 270]) and v == pytest.approx([0, 90, 180])
    assert candela == pytest.approx(ROWS[[2, 1, 0, 1, 2], :3])


def test_factors_and_tilt() -> None:
    text = ies_text(*QUARTER, ROWS, tilt='INCLUDE', factors=(2.0, 0.5, 3.0))
    assert split(ies.read(text))[2][0] == pytest.approx(3.0 * ROWS[0])
    assert split(ies.read(text.replace(' ', ',')))[2][0] == pytest.approx(3.0 * ROWS[0])


@pytest.mark.parametrize(
    ('text', 'why'),
    [
        ('', 'TILT='),
        ('hello\nTILT=NONE\n1 2 3', 'ends too early'),
        (ies_text(*QUARTER, ROWS)[:-20], 'ends too early'),
        (ies_text(*QUARTER, ROWS, kind=7), 'photometric type'),
        (ies_text((0, 60, 30, 90), (0, 45, 90), ROWS), 'ascend'),
        (ies_text((0,), (0, 45, 90), ROWS[:, :1]), 'one angle'),
        (ies_text(*QUARTER, ROWS * np.nan), 'finite'),
        (ies_text(*QUARTER, ROWS).replace(' 4 3 1 ', ' 4000000 4000000 1 '), 'angles'),
        (ies_text(*QUARTER, ROWS).replace(' 4 3 1 ', ' -4 3 1 '), 'angles'),
        (ies_text(*QUARTER, ROWS).replace(' 4 3 1 ', ' nan 3 1 '), 'ends too early'),
    ],
)
def test_a_file_that_cannot_be_read_says_why(text: str, why: str) -> None:
    with pytest.raises(ies.IesError, match=why):
        ies.read(text)


def lamp(scene: bpy.types.Scene, text: str | None, **settings: object) -> bpy.types.Node:
    tree = build.with_nodes(hang(scene, 'POINT', shadow_soft_size=0.0, energy=20.0, **settings).data).node_tree
    made = build.node(tree, 'TexIES', Strength=0.02)
    made.mode = 'INTERNAL'
    if text is not None:
        made.ies = bpy.data.texts.new('Luminaire')
        made.ies.write(text)
    shine = next(found for found in tree.nodes if found.type == 'EMISSION')
    build.connect(tree, made.outputs[0], shine.inputs['Strength'])
    return made


def test_a_lamp_without_a_file_is_named(engine: None, tmp_path: Path) -> None:
    scene = corner()
    made = lamp(scene, None)
    assert any('Light "Point"' in text and 'it has no text: 100 is used' in text for text in messages(scene))
    made.mode, made.filepath = 'EXTERNAL', str(tmp_path / 'none.ies')
    assert any('none.ies" cannot be read' in text for text in messages(scene))
    (tmp_path / 'none.ies').write_text(STREET)
    assert not messages(scene)


FILES = {
    'quarter': ies_text(*QUARTER, 40 * ROWS),
    'one angle': ies_text((0, 40, 90, 140, 180), (0,), [[100, 300, 150, 50, 20]]),
    'up': ies_text((90, 120, 150, 180), (0, 90, 180, 270, 360), 40 * ROWS[[0, 1, 2, 1, 0]]),
    'type B': ies_text((-90, -45, 0, 45, 90), (0, 45, 90), 40 * np.arange(1.0, 16.0).reshape(3, 5), kind=2),
}


@pytest.mark.parametrize('name', FILES)
@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='Cycles 4.5 interpolates otherwise at the ends')
def test_a_luminaire_is_as_cycles_shows_it(name: str, engine: None, tmp_path: Path) -> None:
    scene = corner()
    lamp(scene, FILES[name], location=(0.2, 0.3, 1.0), rotation=(0.3, 0.2, 0.5))
    assert_as_cycles(scene, tmp_path, samples=32)
