# SPDX-License-Identifier: GPL-3.0-or-later
"""*Speed and Accuracy* and *Compare with Cycles* in Blender: processes beside it, their plots, and rows to pick.

The bpy module has no window: what a user clicks there is called here.
"""

from __future__ import annotations

import re
import time
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from cotorra import compat, demos
from cotorra.lab import background, pictures, plan, raster
from cotorra.lab.apply import apply
from cotorra.ui import lab_panel

from render_calls import run_cli
from test_ui import drawn


@pytest.fixture
def room(engine: None) -> bpy.types.Scene:
    scene = demos.build('box_room')
    yield scene
    background.end_all()


def wait(kind: str) -> background.Task:
    task = background.tasks[kind]
    deadline = time.monotonic() + 120
    while task.poll():
        assert time.monotonic() < deadline, task.state()
        time.sleep(0.1)
    return task


def test_a_chart_of_the_open_file_and_its_rows(room: bpy.types.Scene) -> None:
    name = bpy.data.filepath
    background.start(room, 'chart', ['--size', '32x18', '--samples', '1,2', '--points', '4'], 50.0)
    assert re.search(r'\d+% of the time', ' '.join(drawn('COTORRA_RENDER_PT_speed_accuracy')))
    task = wait('chart')
    assert task.error == '' and [line['name'] for line in task.plot['lines']] == ['Path', 'Cycles']
    assert bpy.data.filepath == name, 'the open file is another one now'
    image = lab_panel.show_plot(bpy.context)
    assert image.name == 'Speed and Accuracy' and tuple(image.size) == lab_panel.PLOT_SIZE
    assert lab_panel.show_plot(bpy.context) == bpy.data.images['Speed and Accuracy']
    settings, pixels = bpy.context.window_manager.cotorra_lab, np.array(bpy.data.images['Speed and Accuracy'].pixels[:])
    settings.measure = 'rmse'  # which draws the plot again
    assert (pixels != np.array(bpy.data.images['Speed and Accuracy'].pixels[:])).any()
    settings.measure = 'trimmed'
    found = lab_panel.rows(task.plot, 'trimmed')
    assert len(found) == 4 and [row[2]['trimmed'] for row in found] == sorted(row[2]['trimmed'] for row in found)

    shown = drawn('COTORRA_RENDER_PT_speed_accuracy')
    assert {'Path, 1', 'Path, 2', 'Cycles, 1', 'Cycles, 2'} <= set(shown)

    assert bpy.ops.cotorra.lab_apply(line=1, point=1) == {'FINISHED'}
    assert (room.render.engine, room.cycles.samples) == ('CYCLES', 2)
    room.cotorra.integrator = 'WHITTED'
    assert bpy.ops.cotorra.lab_apply(line=0, point=0) == {'FINISHED'}
    assert (room.render.engine, room.cotorra.samples, room.cotorra.integrator) == ('COTORRA', 1, 'PATH')
    with pytest.raises(RuntimeError, match='no such row'):
        bpy.ops.cotorra.lab_apply(line=7, point=0)


def test_what_fails_in_the_background_is_told(room: bpy.types.Scene) -> None:
    room.camera = None
    assert not bpy.ops.cotorra.speed_accuracy.poll() and not bpy.ops.cotorra.compare.poll()
    background.start(room, 'chart', ['--size', '32x18', '--samples', '1', '--points', '2'])
    assert 'has no camera' in wait('chart').error


def test_it_is_stopped(room: bpy.types.Scene) -> None:
    task = background.start(room, 'chart', ['--size', '32x18', '--samples', '1,400000', '--points', '2'])
    assert task.running and task.poll()
    bpy.ops.cotorra.lab_stop(kind='chart')
    assert 'interrupted' in wait('chart').error


def test_a_comparison(room: bpy.types.Scene) -> None:
    background.start(room, 'compare', ['--size', '48x27', '--samples', '4'])
    task = wait('compare')
    assert task.error == '' and task.picture().is_file()
    lines = '\n'.join(task.lines)
    for words in ('total difference', 'beyond', 'RMSE', 'relMSE', 'seconds'):
        assert words in lines
    settings = bpy.context.window_manager.cotorra_lab
    three = lab_panel.show_comparison(bpy.context)
    assert three.name == 'Compare with Cycles' and three.size[0] == 3 * 48 + 2 * pictures.GAP
    settings.slide = True  # each change makes the image anew
    shown = drawn('COTORRA_RENDER_PT_compare')
    assert 'The picture is the image "Compare with Cycles" total difference' in ' '.join(shown)
    assert bpy.data.images['Compare with Cycles'].size[0] == 2 * 48 + pictures.GAP
    ours, half, theirs = (slid(split) for split in (1.0, 0.5, 0.0))
    assert (half[:, :20] == ours[:, :20]).all() and (half[:, 28:] == theirs[:, 28:]).all()
    assert (ours[:27, :48] != theirs[:27, :48]).any()
    settings.slide, settings.split = False, 0.5


def slid(split: float) -> np.ndarray:
    """The picture of the comparison with the slider there, its lowest row first."""
    bpy.context.window_manager.cotorra_lab.split = split
    image = bpy.data.images['Compare with Cycles']
    return np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)


def test_the_command_writes_three_pictures(engine: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / 'o.png'
    code, told = run_cli('compare', '--demo', 'box_room', '-o', out, '--size', '48x27', '--samples', '16')
    assert code == 0, told
    image = oiio.ImageBuf(str(out)).get_pixels(oiio.FLOAT)
    assert image.shape[1] == 3 * 48 + 2 * pictures.GAP and image.shape[0] >= 27
    ours, theirs = image[-27:, :48], image[-27:, 48 + pictures.GAP : 96 + pictures.GAP]
    assert ours.std() > 0.05 and abs(ours.mean() - theirs.mean()) < 0.1 * ours.mean()
    total = re.search(r'total difference +([+-][\d.]+) % ± ([\d.]+) %', capsys.readouterr().out)
    # The interval is one of 95 %, of two renders each: three times its half is left by one in a thousand.
    assert abs(float(total[1])) < 3.0 * float(total[2]) + 0.5
    code, told = run_cli('compare', '--demo', 'box_room', '-o', tmp_path / 'o.exr')
    assert code == 2 and 'must end in .png or .jpg' in told


@pytest.mark.parametrize('series', [*plan.DEFAULT_SERIES, plan.Series(model='LAMBERT'), plan.Series(device='VULKAN')])
@pytest.mark.parametrize('settings_from', ['AUTO', 'CYCLES', 'COTORRA'])
def test_settings_of_a_row_hold(engine: None, series: plan.Series, settings_from: str) -> None:
    from cotorra import cycles_settings

    scene = demos.build('box_room')
    scene.cotorra.settings_from = settings_from
    scene.view_layers[0].samples = 3
    apply(scene, series, 16)
    assert scene.view_layers[0].samples == 0
    if series.engine == 'CYCLES':
        found = scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising
    else:
        names = ('samples', 'use_adaptive_sampling', 'use_denoising')
        found = tuple(cycles_settings.inherited(scene, name) for name in names)
        own = scene.cotorra
        assert (own.integrator, own.device) == (series.integrator, series.device)
        assert own.use_model_override == bool(series.model)
    assert found == (16 * (plan.ADAPTIVE_REACH if series.adaptive else 1), series.adaptive, series.denoised)


def test_the_plot_by_numpy_alone(engine: None) -> None:
    """Markers lie where the logarithms of their values say, and where nothing is known a text says so."""
    point = {'seconds': 1.0, 'samples': 4, 'relmse': 0.1, 'front': ['relmse']}
    far = {'seconds': 10.0, 'samples': 64, 'relmse': 0.01, 'front': ['relmse']}
    line = {'name': 'Path', 'color': '#ff0000', 'marker': 's', 'hollow': False, 'curves': {}, 'points': [point, far]}
    data = {'clock': 'seconds', 'measures': [{'key': 'relmse', 'name': 'relMSE'}], 'lines': [line]}
    shown = raster.plot(data, 'relmse', 'title', 600, 400, compat.text_coverage).astype(int)
    red = (shown == (255, 0, 0)).all(axis=2)
    columns = np.flatnonzero(red.any(axis=0))
    assert red.sum() > 100 and columns.max() - columns.min() > 200
    rows = np.flatnonzero(red.any(axis=1))
    left = np.flatnonzero(red[:, columns.min() + 2])
    assert left.mean() < rows.mean(), 'the greater error is above'
    line['points'] = [{**point, 'relmse': None}]
    blank = raster.plot(data, 'relmse', 'title', 600, 400, compat.text_coverage)
    assert not (blank == (255, 0, 0)).all(axis=2).any() and blank.min() < 120
