# SPDX-License-Identifier: GPL-3.0-or-later
"""`cotorra render`: arguments, files, progress, figures and exit codes; most in this process, whose Blender is there.

Most renders use the stand-in for the native module; what is wrong with files and scenes is test_bad_input.py's.
"""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from cotorra import cli, demos, opening, outputs, settings, terminal
from cotorra.log import Log
from cotorra.watch import Progress

import fake_native
from render_calls import read_exr, run_cli, start_cli
from scenes import build

SMALL = ('--size', '16x9', '--samples', '4')


@pytest.fixture
def blend(engine, tmp_path) -> Path:
    """A file made for Cycles, of two frames, with a pass and a light group."""
    scene = build.new_scene()
    scene.name = 'Made for Cycles'
    scene.render.engine = 'CYCLES'
    scene.frame_start, scene.frame_end = 4, 5
    scene.frame_set(4)
    scene.view_layers[0].use_pass_z = True
    scene.view_layers[0].lightgroups.add(name='Key')
    scene.view_layers[0].samples = 50
    build.camera(scene)
    build.mesh_object(scene)
    path = tmp_path / 'made for cycles.blend'
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_a_demo_becomes_a_png_by_the_real_engine(tmp_path):
    out, figures = tmp_path / 'new folder' / 'room.png', tmp_path / 'room.json'
    code, told = run_cli('render', '--demo', 'box_room', '-o', out, *SMALL, '--stats', figures)
    assert code == 0, told
    image = oiio.ImageBuf(str(out))
    assert (image.spec().width, image.spec().height, image.nchannels) == (16, 9, 3)
    assert image.get_pixels(oiio.FLOAT).std() > 0.05
    assert f'{out}: 16×9, 4 samples' in told
    found = json.loads(figures.read_text(encoding='utf-8'))
    assert found['rays']['camera'] == 16 * 9 * 4 and found['rays']['shadow'] > 0
    assert found['samples'] == 4 and found['interrupted'] is False and found['warnings'] == []
    for key in ('sync_seconds', 'build_seconds', 'render_seconds'):
        assert 0.0 < found[key] < found['total_seconds'] < 60.0
    assert 50e6 < found['memory_peak_bytes'] < 4e9
    assert found['features'] and found['left_out']
    (frame,) = found['frames']
    assert frame['layers'][0]['integrator'] == 'PATH'


def test_a_model_for_all_materials(engine):
    scene = build.new_scene()
    options = cli.parser().parse_args(['render', '--demo', 'box_room', '-o', 'room.exr', '--model', 'oren_nayar'])
    cli.apply(options, scene)
    assert scene.cotorra.use_model_override and scene.cotorra.model_override.model == 'OREN_NAYAR'
    with pytest.raises(SystemExit):
        cli.parser().parse_args(['render', '--demo', 'box_room', '-o', 'room.exr', '--model', 'ward'])


def test_a_graphics_card_and_how_it_traces(engine):
    scene = build.new_scene()
    line = ['render', '--demo', 'box_room', '-o', 'room.exr', '--device', 'vulkan:1', '--ray-tracing', 'software']
    cli.apply(cli.parser().parse_args(line), scene)
    found = settings.render_settings(scene, bpy.context.view_layer, (), Log())
    assert (found.device, found.device_index, found.ray_tracing) == ('VULKAN', 1, 'SOFTWARE')


@pytest.mark.parametrize('settings_from', ['auto', 'cycles', 'cotorra'])
def test_denoising_and_time_are_the_command_lines(engine, settings_from):
    line = ['render', '--demo', 'box_room', '-o', 'room.exr', '--settings', settings_from]
    for argument, denoises in (('--denoise', True), ('--no-denoise', False)):
        scene = build.new_scene()
        cli.apply(cli.parser().parse_args([*line, argument, '--time-limit', '1.5']), scene)
        assert scene.cotorra.settings_from == settings_from.upper()
        assert (settings.denoising(scene, scene.view_layers[0]) is not None) == denoises
        assert settings.time_limit(scene, Log()) == 1.5
    for wrong in ('-1', 'nan', 'soon'):
        with pytest.raises(SystemExit):
            cli.parser().parse_args([*line, '--time-limit', wrong])


def test_a_denoised_picture_is_a_plain_exr(tmp_path):
    """The noisy image beside it is no reason for another kind of file."""
    out = tmp_path / 'o.exr'
    code, told = run_cli('render', '--demo', 'box_room', '-o', out, *SMALL, '--denoise', fake='')
    assert code == 0, told
    assert set(read_exr(out)) == {''}


def test_it_is_told_how_a_graphics_card_traces(tmp_path):
    code, told = run_cli(
        'render', '--demo', 'box_room', '-o', tmp_path / 'o.exr', *SMALL, '--device', 'vulkan', fake=''
    )
    assert code == 0 and 'VULKAN renders, tracing rays by imagination' in told


def test_arguments_override_the_file(blend, tmp_path):
    out, figures = tmp_path / 'o.exr', tmp_path / 'o.json'
    code, told = run_cli(
        *('render', blend, '-o', out, '--samples', 3, '--seed', 11, '--integrator', 'path', '--device', 'cpu'),
        *('--threads', 1, '--size', '20x10', '--frame', 5, '--stats', figures),
        fake='',
    )
    assert code == 0, told
    found = json.loads(figures.read_text(encoding='utf-8'))
    (frame,) = found['frames']
    (layer,) = frame['layers']
    assert frame['frame'] == 5 and frame['output'] == str(out)
    wanted = {'samples': 3, 'seed': 11, 'integrator': 'PATH', 'device': 'CPU', 'threads': 1, 'width': 20, 'height': 10}
    assert {key: layer[key] for key in wanted} == wanted


def test_passes_of_the_file_make_a_multilayer_exr(blend, tmp_path):
    code, told = run_cli('render', blend, '-o', tmp_path / 'o.exr', *SMALL, fake='')
    assert code == 0, told
    found = read_exr(tmp_path / 'o.exr')
    assert set(found) == {'ViewLayer.Combined', 'ViewLayer.Depth', 'ViewLayer.Combined_Key'}
    assert found['ViewLayer.Depth']['Z'].dtype == np.float32


def test_without_passes_the_exr_is_plain(tmp_path):
    code, told = run_cli('render', '--demo', 'box_room', '-o', tmp_path / 'o.exr', *SMALL, fake='')
    assert code == 0, told
    found = read_exr(tmp_path / 'o.exr')
    assert set(found) == {''} and set(found['']) == set('RGBA')
    assert oiio.ImageBuf(str(tmp_path / 'o.exr')).spec().format == oiio.FLOAT


@pytest.mark.parametrize(
    'output, names', [('o.png', ['o0004.png', 'o0005.png']), ('a#b##.png', ['a#b04.png', 'a#b05.png'])]
)
def test_a_range_of_frames(blend, tmp_path, output, names):
    folder = tmp_path / 'frames {with} braces'
    code, told = run_cli('render', blend, '-o', folder / output, *SMALL, '--frame', '4..5', fake='')
    assert code == 0, told
    assert sorted(path.name for path in folder.iterdir()) == names


def test_names_of_frames():
    def named(pattern, frame, several=False):
        return str(outputs.frame_path(Path('d') / pattern, frame, several).relative_to('d'))

    assert named('o.png', 7) == 'o.png'
    assert named('o.png', 7, several=True) == 'o0007.png'
    assert named('o_###.exr', 7) == 'o_007.exr'
    assert named('o_###.exr', -7) == 'o_-07.exr'
    assert named('#o##.exr', 12345, several=True) == '#o12345.exr'
    assert named('o##.exr', None) == 'o##.exr'


@pytest.mark.parametrize(
    'arguments, words',
    [
        ((), 'required'),
        (('render', '--demo', 'box_room'), '-o'),
        (('render', '-o', 'o.png'), 'FILE'),
        (('render', '--demo', 'nothing', '-o', 'o.png'), "'nothing'"),
        (('render', '--demo', 'box_room', '-o', 'o.jpg'), 'o.jpg'),
        (('render', 'a.blend', '--demo', 'box_room', '-o', 'o.png'), 'not allowed'),
        (('render', 'a.blend', '-o', 'o.png', '--samples', '0'), '0 is not from 1 to 16777216'),
        (('render', 'a.blend', '-o', 'o.png', '--samples', '2147483648'), '2147483648 is not from'),
        (('render', 'a.blend', '-o', 'o.png', '--samples', 'many'), "'many' is not a whole number"),
        (('render', 'a.blend', '-o', 'o.png', '--seed', '-1'), '-1 is not from 0'),
        (('render', 'a.blend', '-o', 'o.png', '--threads', '5000'), '5000 is not from 0 to 1024'),
        (('render', 'a.blend', '-o', 'o.png', '--integrator', 'magic'), 'MAGIC'),
        (('render', 'a.blend', '-o', 'o.png', '--device', 'abacus'), 'ABACUS'),
        (('render', 'a.blend', '-o', 'o.png', '--device', 'vulkan:x'), "'x' is not a whole number"),
        (('render', 'a.blend', '-o', 'o.png', '--ray-tracing', 'magic'), 'MAGIC'),
        (('render', 'a.blend', '-o', 'o.png', '--size', '10'), "'10' is not a size"),
        (('render', 'a.blend', '-o', 'o.png', '--size', '0x10'), '0 is not from 1'),
        (('render', 'a.blend', '-o', 'o.png', '--frame', '5..3'), '5..3 is empty'),
        (('render', 'a.blend', '-o', 'o.png', '--frame', 'all'), "'all' is neither"),
    ],
)
def test_wrong_arguments_are_named(capsys, monkeypatch, arguments, words):
    monkeypatch.setattr(opening, 'open_scene', lambda *_: pytest.fail('it went on'))
    try:
        code = cli.main(arguments)
    except SystemExit as leave:
        code = leave.code
    assert code == terminal.WRONG_ARGUMENTS
    assert words in capsys.readouterr().err


def test_help_needs_no_blender():
    lines = ['import sys', f'sys.path.insert(0, {str(Path(__file__).parent)!r})', 'import conftest']
    lines += ['from cotorra.cli import main', 'try:', "    main(['render', '--help'])", 'except SystemExit as leave:']
    lines += ["    sys.exit(leave.code or ('bpy' in sys.modules) * 9)"]
    done = subprocess.run([sys.executable, '-c', '\n'.join(lines)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for word in ('three_lights', 'box_room', 'material_grid', '--stats', 'direct, path', '###'):
        assert word in done.stdout


@pytest.fixture(scope='module')
def process(tmp_path_factory):
    """A process that takes commands, one after another; samples take it long."""
    started = start_cli(fake='sample_seconds=0.02')
    yield started
    started.stdin.close()
    assert started.wait(timeout=30) == 0
    started.stdout.close()
    started.stderr.close()


def stopped(process, phase, after, *signals, command):
    """Exit code of a command that is sent signals some seconds after it has told of a phase; and what it told."""
    process.stdin.write(json.dumps([*map(str, command)]) + '\n')
    process.stdin.flush()
    told = ''
    while phase not in told:
        told += process.stderr.readline()
        assert process.poll() is None, told
    time.sleep(after)
    for number in signals:
        process.send_signal(number)
    while not (line := process.stdout.readline()).startswith('code'):
        assert process.poll() is None and line, told
    os.set_blocking(process.stderr.fileno(), False)
    told += process.stderr.read() or ''
    os.set_blocking(process.stderr.fileno(), True)
    return int(line.split()[1]), told


# Shells send SIGHUP, and `timeout` SIGTERM, to a process and to its group: both may arrive.
@pytest.mark.parametrize(
    'suffix, signals',
    [
        ('png', [signal.SIGINT]),
        ('exr', [signal.SIGINT]),
        ('exr', [signal.SIGTERM, signal.SIGTERM]),
        ('exr', [signal.SIGHUP, signal.SIGHUP, signal.SIGTERM]),
    ],
)
def test_a_signal_to_stop_saves_what_was_rendered(process, tmp_path, suffix, signals):
    out, figures = tmp_path / f'o.{suffix}', tmp_path / 'o.json'
    command = ['render', '--demo', 'box_room', '-o', out, '--size', '16x9', '--samples', 100000, '--stats', figures]
    code, told = stopped(process, 'Building', 0.6, *signals, command=command)
    assert code == terminal.INTERRUPTED, told
    assert told.count('Stopping') == 1 and 'of 100000 samples' in told
    image = oiio.ImageBuf(str(out)).get_pixels(oiio.FLOAT)
    assert image.shape[:2] == (9, 16) and image.max() > 0.3
    found = json.loads(figures.read_text(encoding='utf-8'))
    assert found['interrupted'] and 0 < found['frames'][0]['layers'][0]['samples_done'] < 100000


def test_ctrl_c_ends_a_range_of_frames(process, blend, tmp_path):
    command = ['render', blend, '-o', tmp_path / 'o.png', '--size', '16x9', '--samples', 100000, '--frame', '4..9']
    code, told = stopped(process, 'Building', 0.6, signal.SIGINT, command=command)
    assert code == terminal.INTERRUPTED, told
    assert 'frame 5 and later ones are not rendered' in told
    assert [path.name for path in tmp_path.glob('*o*.png')] == ['o0004.png']


def test_ctrl_c_while_building_leaves_the_image_that_was_there(tmp_path, monkeypatch):
    out = tmp_path / 'o.exr'
    out.write_bytes(b'an older picture')
    build_bvh = fake_native.Scene.build_bvh

    def build_and_press(*arguments, **more):
        os.kill(os.getpid(), signal.SIGINT)
        build_bvh(*arguments, **more)

    monkeypatch.setattr(fake_native.Scene, 'build_bvh', build_and_press)
    code, told = run_cli('render', '--demo', 'box_room', '-o', out, *SMALL, fake='build_seconds=60')
    assert code == terminal.INTERRUPTED, told
    assert 'interrupted before anything was rendered' in told
    assert list(tmp_path.iterdir()) == [out] and out.read_bytes() == b'an older picture'


class FakeTerminal(io.StringIO):
    encoding = 'utf-8'

    def isatty(self):
        return True


def states(count):
    yield Progress('Layer', 'Synchronizing')
    yield Progress('Layer', 'Building')
    yield Progress('Layer', 'Rendering')
    for done in range(count + 1):
        part = done / count
        yield Progress('Layer', 'Rendering', part, done, count, done * 0.1, (count - done) * 0.1, 50 * 2**20)


def test_a_terminal_sees_one_line_that_updates(monkeypatch):
    out = FakeTerminal()
    watcher = terminal.TerminalWatcher(out)
    for state in states(10):
        watcher.progress(state)
        if state.samples == 5:
            watcher.message('WARNING', 'look at this')
            watcher.message('WARNING', 'look at this')
    watcher.note('done')
    shown = screen(out.getvalue())
    assert shown[0] == 'Warning: look at this'
    assert shown[1].startswith('█' * 24 + ' Layer | 100 % | 10/10 samples | 0:01 | 50 MB')
    assert shown[2:] == ['done', '']


def test_a_file_sees_few_lines():
    out = io.StringIO()
    watcher = terminal.TerminalWatcher(out)
    for state in states(1000):
        watcher.progress(state)
    lines = out.getvalue().splitlines()
    assert lines == [
        'Layer | Synchronizing',
        'Layer | Building',
        'Layer | 100 % | 1000/1000 samples | 1:40 | 50 MB',
    ]


def screen(text):
    """What a terminal shows after `text`."""
    lines = []
    for line in text.split('\n'):
        cells = []
        for part in line.split('\r'):
            cells[: len(part)] = part
        lines.append(''.join(cells).rstrip())
    return lines


@pytest.mark.parametrize(
    'seconds, text', [(0.4, '0:00'), (59.6, '1:00'), (61, '1:01'), (3599.9, '1:00:00'), (7322, '2:02:02')]
)
def test_clock(seconds, text):
    assert terminal.clock(seconds) == text


def test_three_lights_has_its_triangles_and_lights(engine):
    scene = demos.build('three_lights')
    depsgraph = in_render_depsgraph(scene)
    monkeys = [item for item in depsgraph if item.startswith('Monkey')]
    assert len(monkeys) == 30
    assert depsgraph['Monkey 1'] == 15744 and sum(depsgraph.values()) == 472320 + 2
    assert sorted(light.type for light in bpy.data.lights) == ['POINT', 'SPOT', 'SUN']
    assert (scene.render.resolution_x, scene.render.resolution_y, scene.render.engine) == (640, 360, 'COTORRA')


@pytest.mark.parametrize('name', ['three_lights', 'box_room', 'material_grid', 'model_pair', 'model_room'])
def test_demos_are_the_same_every_time_and_need_no_file(engine, name):
    def content():
        scene = demos.build(name)
        return [
            (item.name, [list(row) for row in item.matrix_world], [slot.material.name for slot in item.material_slots])
            for item in scene.objects
        ]

    assert content() == content()
    assert sorted(light.type for light in bpy.data.lights) == ['POINT', 'SPOT', 'SUN']
    assert bpy.context.scene.camera is not None and not bpy.data.libraries
    assert all(image.packed_file for image in bpy.data.images)


def in_render_depsgraph(scene):
    """Triangles by object, as a final render has them."""
    from scenes.depsgraphs import in_render

    def count(_engine, depsgraph):
        return {
            item.object.name: len(item.object.data.loop_triangles)
            for item in depsgraph.object_instances
            if item.object.type == 'MESH'
        }

    (found,) = in_render(scene, count)
    scene.render.engine = 'COTORRA'
    return found
