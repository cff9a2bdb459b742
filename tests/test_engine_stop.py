# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders that fail or are stopped: Blender is told, nothing hangs, and what was rendered stays.

The native module is a stand-in that takes as long and fails where it is told.
"""

from __future__ import annotations

import os
import signal
import threading
import time

import bpy
import pytest
from cotorra import export, final_render, native, stats, watch
from cotorra.log import SHOWN_PER_LEVEL, Cancelled, Log

import fake_native
from render_calls import read_exr, render_to
from scenes import build

pytestmark = pytest.mark.usefixtures('engine', 'fake')

STOP_SECONDS = 0.2


@pytest.fixture
def scene() -> bpy.types.Scene:
    made = build.new_scene()
    build.camera(made)
    made.render.engine = 'COTORRA'
    made.render.resolution_x, made.render.resolution_y = 12, 8
    return made


class Stopper(watch.Watcher):
    """Wishes to stop when `phase` has lasted `seconds`, and remembers what it was told."""

    def __init__(self, phase: str = '', seconds: float = 0.0) -> None:
        self.phase, self.seconds = phase, seconds
        self.stop_time = 0.0
        self.states: list[watch.Progress] = []
        self.messages: list[tuple[str, str]] = []

    @property
    def stop(self) -> bool:
        return self.stop_time > 0.0

    def _stop(self) -> None:
        self.stop_time = time.perf_counter()

    def progress(self, state: watch.Progress) -> None:
        if state.phase == self.phase and not any(before.phase == self.phase for before in self.states):
            threading.Timer(self.seconds, self._stop).start()
        self.states.append(state)

    def message(self, level: str, text: str) -> None:
        self.messages.append((level, text))


@pytest.mark.parametrize(
    'place, words',
    [
        ('scene', 'ValueError: positions[3] = nan'),
        ('session', 'RuntimeError: no session today'),
        ('render', 'RuntimeError: a worker failed'),
        ('read', 'RuntimeError: pass combined cannot be read'),
    ],
)
def test_a_failure_anywhere_is_an_error_and_the_next_render_works(scene, tmp_path, place, words):
    fake_native.configure(f'fail_in={place}')
    path = tmp_path / 'image.exr'
    with pytest.raises(RuntimeError, match='Cotorra: ') as caught:
        render_to(scene, path, multilayer=True)  # Blender crashes here if an exception leaves `render`
    assert words in str(caught.value)
    assert not path.exists()
    assert words in stats.last(scene.name)[0].error
    fake_native.reset()
    assert render_to(scene, path, multilayer=True).exists()
    assert stats.last(scene.name)[0].error == ''


@pytest.mark.parametrize(
    ('failure', 'words'),
    [
        (SystemExit(3), 'SystemExit'),
        (MemoryError(), 'out of memory'),
        (KeyboardInterrupt(), 'KeyboardInterrupt'),
        (GeneratorExit(), 'GeneratorExit'),
    ],
)
def test_no_exception_of_any_kind_reaches_blender(scene, tmp_path, monkeypatch, failure, words):
    def fail(*_arguments, **_named):
        raise failure

    monkeypatch.setattr(export, 'export_scene', fail)
    with pytest.raises(RuntimeError, match=words):
        render_to(scene, tmp_path / 'image.exr')


def test_an_error_of_the_export_is_reported_once_and_for_all(scene, monkeypatch):
    def refuse(_scene, _camera, log):
        log.error('Camera "Camera": no')

    monkeypatch.setattr(export, 'export_camera', refuse)
    with pytest.raises(RuntimeError) as caught:
        bpy.ops.render.render()
    assert str(caught.value) == 'Error: Cotorra: Camera "Camera": no\n'


def test_a_missing_native_module_is_named(scene, monkeypatch):
    def missing():
        raise native.NativeError('The native module cotorra_native cannot be loaded')

    monkeypatch.setattr(native, 'load', missing)
    with pytest.raises(RuntimeError, match='The native module cotorra_native cannot be loaded'):
        bpy.ops.render.render()


def test_the_real_search_names_what_is_missing(monkeypatch, tmp_path):
    monkeypatch.undo()
    monkeypatch.setattr(native.importlib, 'import_module', lambda name: __import__('no_such_module'))
    with pytest.raises(native.NativeError, match='cotorra_native cannot be loaded .*built for Python 3'):
        native.load()

    monkeypatch.setattr(native.importlib.util, 'find_spec', lambda name: None)
    monkeypatch.setattr(native, 'find_library', lambda name: None)
    monkeypatch.setenv('COTORRA_EMBREE', str(tmp_path / 'nothing.so'))
    with pytest.raises(native.NativeError) as caught:
        native.embree_library()
    for words in ('embreex is not installed', 'nothing.so, which is not a file', 'system has no library embree4'):
        assert words in str(caught.value)

    own = tmp_path / 'libembree4.so'
    own.touch()
    monkeypatch.setenv('COTORRA_EMBREE', str(own))
    assert native.embree_library() == str(own)


@pytest.mark.parametrize(
    'platform, file',
    [
        ('linux', 'embreex.libs/libembree4-4aef3270.so.4'),
        ('win32', 'embreex.libs/embree4-0123.dll'),
        ('darwin', 'embreex/.dylibs/libembree4.4.dylib'),
    ],
)
def test_embree_is_found_in_the_wheels_of_each_platform(tmp_path, platform, file):
    path = tmp_path / file
    path.parent.mkdir(parents=True)
    path.touch()
    assert native.embree_in_wheel(tmp_path, platform) == path
    assert native.embree_in_wheel(tmp_path / 'elsewhere', platform) is None


@pytest.mark.parametrize('name, words', watch.STOP_SIGNALS.items())
def test_a_signal_in_a_script_is_an_error_that_says_so(scene, name, words):
    """In the bpy module signals are Python's; the render must end soon, in order, and not look like a success."""
    fake_native.configure('sample_seconds=0.02')
    scene.view_layers.new('Second')
    number = getattr(signal, name)
    usual = signal.default_int_handler if name == 'SIGINT' else signal.SIG_DFL
    signal.signal(number, usual)  # shells let what runs in the background ignore Ctrl-C, and nohup SIGHUP
    threading.Timer(0.4, os.kill, (os.getpid(), number)).start()
    start = time.perf_counter()
    with pytest.raises(RuntimeError, match=f'Interrupted by {words}'):
        bpy.ops.render.render()
    assert time.perf_counter() - start < 0.4 + STOP_SECONDS
    assert [entry.interrupted for entry in stats.last(scene.name)] == [True, True]
    assert stats.last(scene.name)[1].progress == 0.0  # the second layer is not begun
    assert signal.getsignal(number) is usual


def test_a_signal_ends_an_animation_and_leaves_no_frame_behind(scene, tmp_path):
    fake_native.configure('sample_seconds=0.02')
    scene.frame_start, scene.frame_end = 1, 9
    scene.render.filepath = str(tmp_path / 'frame_')
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGTERM)).start()
    with pytest.raises(RuntimeError, match='Interrupted by SIGTERM'):
        bpy.ops.render.render(animation=True)
    assert stats.last(scene.name)[0].frame == 1 and list(tmp_path.iterdir()) == []


def test_signals_that_somebody_else_handles_or_ignores_are_left_to_them(scene):
    seen = []
    theirs = {signal.SIGTERM: lambda number, _frame: seen.append(number), signal.SIGHUP: signal.SIG_IGN}
    before = {number: signal.signal(number, handler) for number, handler in theirs.items()}
    try:
        with watch.interrupt_as_flag() as interrupt:
            for number in theirs:
                os.kill(os.getpid(), number)
            time.sleep(0.05)
            assert interrupt.by == '' and seen == [signal.SIGTERM]
            assert {number: signal.getsignal(number) for number in theirs} == theirs
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_a_stopped_render_keeps_its_image(scene, tmp_path):
    fake_native.configure('sample_seconds=0.02')
    scene.view_layers[0].use_pass_z = True
    with watch.attached(Stopper('Rendering', 0.3)) as stopper:
        path = render_to(scene, tmp_path / 'image.exr', multilayer=True)
        ended = time.perf_counter()
    assert ended - stopper.stop_time < STOP_SECONDS
    found = read_exr(path)
    assert found['ViewLayer.Combined']['R'].max() == 0.5 and found['ViewLayer.Depth']['Z'].max() == 0.5
    (entry,) = stats.last(scene.name)
    assert entry.interrupted and 0.0 < entry.progress < 1.0


def test_stopping_while_the_scene_is_built(scene):
    fake_native.configure('build_seconds=20')
    with watch.attached(Stopper('Building', 0.2)) as stopper:
        with pytest.raises(RuntimeError, match='Stopped before anything was rendered'):
            bpy.ops.render.render()
        assert time.perf_counter() - stopper.stop_time < STOP_SECONDS


def test_stopping_while_objects_are_exported(scene):
    for _ in range(3):
        build.mesh_object(scene)
    with watch.attached(Stopper('Synchronizing', 0.0)) as stopper:
        stopper._stop()
        with pytest.raises(RuntimeError, match='Stopped before anything was rendered'):
            bpy.ops.render.render()
    assert stats.last(scene.name)[0].build_seconds == 0.0
    assert [state.phase for state in stopper.states] == ['Synchronizing']


def test_blenders_own_stop_is_no_error(scene, monkeypatch):
    """Esc in the window: Blender knows, and wants no report."""
    fake_native.configure('sample_seconds=0.02')
    pressed = time.perf_counter() + 0.3
    monkeypatch.setattr(final_render, 'stop_asked', lambda engine: time.perf_counter() > pressed)
    bpy.ops.render.render()
    assert time.perf_counter() - pressed < STOP_SECONDS
    assert stats.last(scene.name)[0].interrupted


def test_a_watcher_sees_progress_and_messages(scene):
    fake_native.configure('sample_seconds=0.01')
    scene.render.use_motion_blur = True
    scene.view_layers.new('Second')
    with watch.attached(Stopper()) as watcher:
        bpy.ops.render.render()
    assert watch.active is None
    told = [text for level, text in watcher.messages if level == 'WARNING']
    assert told == ['Scene "Scene": motion blur is not rendered yet'] * 2
    assert len(watcher.messages) == 2
    for layer in ('ViewLayer', 'Second'):
        seen = [state for state in watcher.states if state.layer == layer]
        assert [state.phase for state in seen[:3]] == ['Synchronizing', 'Building', 'Rendering']
        fractions = [state.fraction for state in seen]
        assert fractions == sorted(fractions) and fractions[-1] == 1.0
        assert 3 < len(seen) < 20
        halfway = min(seen, key=lambda state: abs(state.fraction - 0.5))
        assert halfway.remaining == pytest.approx(halfway.elapsed, rel=0.5)


def test_a_log_says_each_thing_once_and_not_too_much():
    shown = []
    log = Log(lambda level, text: shown.append((level, text)))
    for _ in range(3):
        log.warning('the same')
    for number in range(SHOWN_PER_LEVEL + 5):
        log.info(f'message {number}')
    log.close()
    assert log.texts('WARNING') == ['the same']
    assert len(log.texts('INFO')) == SHOWN_PER_LEVEL + 5
    assert len(shown) == 1 + SHOWN_PER_LEVEL + 1
    assert shown[-1] == ('INFO', '5 more messages of this kind are in the statistics file')


def test_a_log_stops_the_export():
    Log().checkpoint()
    Log(should_stop=lambda: False).checkpoint()
    with pytest.raises(Cancelled):
        Log(should_stop=lambda: True).checkpoint()


def test_a_card_that_cannot_render_hands_over_to_the_cpu(scene, tmp_path):
    """With a warning that says why; or, where the user wants no other device, with an error."""
    fake_native.fail_in = 'device'
    scene.cotorra.device = 'VULKAN'
    stopper = Stopper()
    with watch.attached(stopper):
        render_to(scene, tmp_path / 'o.exr')
    assert fake_native.sessions[-1].settings.device == 'CPU'
    assert stats.last(scene.name)[0].device == 'CPU'
    assert ('WARNING', 'The CPU renders instead of VULKAN: no card today') in stopper.messages
    scene.cotorra.use_device_fallback = False
    with pytest.raises(RuntimeError, match='VULKAN: no card today'):
        render_to(scene, tmp_path / 'o.exr')


def test_a_card_that_is_lost_hands_over_what_is_missing(scene, tmp_path):
    """The session stays, and with it the samples that it has."""
    fake_native.configure('fail_in=lost sample_seconds=0.01')
    scene.cotorra.device, scene.cotorra.samples = 'VULKAN', 8
    stopper = Stopper()
    with watch.attached(stopper):
        render_to(scene, tmp_path / 'o.exr')
    assert len(fake_native.sessions) == 1 and fake_native.sessions[0].samples_done() == 8
    assert stats.last(scene.name)[0].device == 'VULKAN, CPU'
    assert any('of 8 samples: the card is gone' in text for _, text in stopper.messages)
