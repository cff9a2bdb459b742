# SPDX-License-Identifier: GPL-3.0-or-later
"""`cotorra chart` as its user meets it: a small chart from end to end, stopped and gone on with, and what it refuses.

Figures and plans are judged in test_lab.py.
"""

from __future__ import annotations

import csv
import json
import re
import signal
import time
from pathlib import Path

import bpy
import pytest
from cotorra import metrics

from render_calls import run_cli, start_cli
from scenes import build

SMALL = ('--size', '32x18', '--samples', '1,4', '--points', '4')


@pytest.fixture(scope='module')
def charted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp('chart') / 'new' / 'room'
    code, told = run_cli('chart', '--demo', 'box_room', '-o', folder, *SMALL)
    assert code == 0, told
    return folder, told


def test_a_chart_from_end_to_end(charted: tuple[Path, str]) -> None:
    folder, told = charted
    assert '4 points, 16 of 16 renders' in told
    for name in ('chart.png', 'sheet.jpg', 'index.html', 'table.md', 'thumbnails/cotorra-path-4.jpg'):
        assert (folder / name).stat().st_size > 500, name
    rows = list(csv.DictReader((folder / 'table.csv').open()))
    assert [(row['series'], row['samples']) for row in rows] == [
        ('Path', '1'), ('Path', '4'), ('Cycles', '1'), ('Cycles', '4'),
    ]  # fmt: skip
    for row in rows:
        assert 0.0 < float(row['seconds']) <= float(row['whole seconds'])
        assert float(row['relmse']) > 0.0 and row['seeds'] == '2' and row['bad pixels'] == '0'
        assert ('flip' in row) == metrics.has_flip()
    assert any('trimmed' in row['on the front of'] for row in rows)


def test_the_page_is_one_file(charted: tuple[Path, str]) -> None:
    text = (charted[0] / 'index.html').read_text(encoding='utf-8')
    data = json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.DOTALL)[1])
    assert [line['name'] for line in data['lines']] == ['Path', 'Cycles']
    assert all(p['picture'].startswith('data:image/jpeg;base64,') for line in data['lines'] for p in line['points'])
    assert not re.search(r'(src|href)="(?!\$)(?!data:)|https?://(?!www\.w3)|\{\{', text)


def test_it_goes_on_and_renders_nothing_twice(charted: tuple[Path, str]) -> None:
    folder, _ = charted
    lost = folder / 'renders' / 'cotorra-path-4-2.json'
    kept = (folder / 'renders' / 'cotorra-path-4-1.json').stat().st_mtime_ns
    lost.unlink()
    code, told = run_cli('chart', '--demo', 'box_room', '-o', folder, *SMALL)
    assert code == 0 and '16 of 16 renders' in told
    assert lost.exists() and (folder / 'renders' / 'cotorra-path-4-1.json').stat().st_mtime_ns == kept
    code, told = run_cli('chart', '--demo', 'box_room', '-o', folder, *SMALL)
    assert code == 0 and ' 0.0 s of them renders' in told
    code, told = run_cli('chart', '--demo', 'box_room', '-o', folder, '--size', '40x20')
    assert code == 2 and 'size [32, 18] (now [40, 20])' in told and '--fresh' in told


def test_an_interrupt_keeps_what_is_there(tmp_path: Path) -> None:
    folder = tmp_path / 'chart'
    line = ('chart', '--demo', 'box_room', '-o', folder, '--size', '32x18', '--samples', '1,4,400000', '--points', '6')
    process = start_cli(*line)
    wanted = folder / 'renders' / 'cycles-cycles-1-2.json'
    # A reference of 400,000 samples would take minutes: nothing to chart is there when it is stopped.
    deadline = time.monotonic() + 60
    while not (folder / 'chart.json').exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=30)
    assert process.returncode == 130, told
    assert 'interrupted before there was anything to chart; the same command goes on' in told
    assert not wanted.exists()
    small = (*line[:-4], '--samples', '1', '--reference-samples', '8', '--points', '2', '--fresh')
    code, told = run_cli(*small)
    assert code == 0 and wanted.exists(), told


@pytest.mark.parametrize(
    'arguments, words',
    [
        (('--demo', 'boxroom', '-o', 'x'), 'invalid choice'),
        (('--demo', 'box_room', '-o', 'x', '--budget', '0'), 'no time from 10 s'),
        (('--demo', 'box_room', '-o', 'x', '--points', '0'), 'not from 1'),
        (('--demo', 'box_room', '-o', 'x', '--samples', '4,many'), 'not a whole number'),
        (('--demo', 'box_room', '-o', 'x', '--integrators', 'photon'), "'photon' is none of"),
        (('none.blend', '-o', 'x'), 'there is no such file'),
    ],
)
def test_what_it_refuses(
    arguments: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code, told = run_cli('chart', *arguments)
    assert code in (1, 2) and words in told
    assert not Path('x').exists() or not list(Path('x').glob('*'))


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / 'file').write_text('')
    code, told = run_cli('chart', '--demo', 'box_room', '-o', tmp_path / 'file')
    assert code == 1 and f'{tmp_path / "file"}: cannot be written to' in told


def test_a_file_without_a_camera(engine: None, tmp_path: Path) -> None:
    build.new_scene()
    path = tmp_path / 'blind.blend'
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    code, told = run_cli('chart', path, '-o', tmp_path / 'chart')
    assert code == 1 and 'scene "Scene" has no camera' in told


def test_a_file_of_two_layers_and_its_frame(engine: None, tmp_path: Path) -> None:
    """Both layers are in the picture; the file's own frame and shape hold."""
    scene = build.new_scene()
    scene.render.resolution_x, scene.render.resolution_y = 400, 100
    scene.view_layers.new('Second')
    scene.frame_set(7)
    build.camera(scene)
    build.mesh_object(scene)
    path = tmp_path / 'two.blend'
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    code, told = run_cli('chart', path, '-o', tmp_path / 'chart', '--samples', '1', '--points', '1', '--seeds', '1',
                         '--engines', 'cotorra')  # fmt: skip
    assert code == 0, told
    info = json.loads((tmp_path / 'chart' / 'chart.json').read_text())['info']
    assert info['layers'] == 2 and info['frame'] == 7 and info['size'] == [480, 120]
