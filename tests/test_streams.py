# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing that reports ends a render: closed, full and lost streams, a terminal that goes away, watchers that raise.

What is reported, and how it looks, is test_cli.py's.
"""

from __future__ import annotations

import errno
import io
import os
import signal
import subprocess
import sys

import bpy
import pytest
from cotorra import export, stats, terminal, watch
from cotorra.watch import Progress

from render_calls import TESTS, render_to, start_cli
from scenes import build

needs_unix = pytest.mark.skipif(sys.platform == 'win32', reason='closes streams as a shell on Unix does')


def demo(path):
    return ('render', '--demo', 'box_room', '-o', path, '--size', '16x9', '--samples', 40)


@needs_unix
def test_streams_that_are_closed_full_or_lost_cost_neither_picture_nor_exit_code(tmp_path):
    """Each in a process of its own, all at once. EXR, since Blender crashes there if an exception reaches it."""
    full = open('/dev/full', 'w')
    reading, writing = os.pipe()
    master, slave = os.openpty()
    cases = {
        'full': {'stdout': full, 'stderr': full},
        # Then whatever is opened next would get all that Blender prints: the picture.
        'closed': {'stdout': None, 'stderr': None, 'preexec_fn': lambda: [os.close(number) for number in range(3)]},
        # A terminal's owner gets SIGHUP as it closes, here ignored as by nohup: what is left is a stream that fails.
        'lost': {
            'stdout': writing,
            'stderr': slave,
            'start_new_session': True,
            'preexec_fn': lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),
        },
    }
    paths = {name: tmp_path / f'{name}.exr' for name in cases}
    started = {
        name: start_cli(*demo(paths[name]), fake='sample_seconds=0.01', stdin=subprocess.DEVNULL, **streams)
        for name, streams in cases.items()
    }
    full.close()
    os.close(writing)
    os.close(slave)
    os.close(reading)
    # The first words are read, as by `head`; after them nobody is there any more.
    told = b''
    while b'Building' not in told:
        told += os.read(master, 1000)
    os.close(master)
    codes = {name: process.wait(timeout=60) for name, process in started.items()}
    assert codes == dict.fromkeys(cases, 0)
    for name, path in paths.items():
        assert path.read_bytes()[:4] == b'v/1\x01', name


@needs_unix
def test_streams_that_are_closed_lead_nowhere():
    """Else the next files that are opened take their numbers."""
    code = 'import os, stat; from cotorra import terminal; terminal.open_standard_streams(); '
    code += 'os._exit(sum(stat.S_ISCHR(os.fstat(number).st_mode) for number in range(3)))'
    lines = f'import sys; sys.path.insert(0, {str(TESTS)!r}); import conftest; {code}'
    done = subprocess.run([sys.executable, '-c', lines], preexec_fn=lambda: [os.close(number) for number in range(3)])
    assert done.returncode == 3


class Stream(io.StringIO):
    encoding = 'ascii'

    def __init__(self, failure):
        super().__init__()
        self.failure = failure

    def isatty(self):
        return True

    def write(self, text):
        text.encode(self.encoding)
        if self.failure is not None:
            raise self.failure
        return super().write(text)


@pytest.mark.parametrize(
    'failure, lost',
    [
        (OSError(errno.EIO, 'terminal gone'), True),
        (BrokenPipeError(), True),
        (ValueError('I/O operation on closed file'), True),
        (BlockingIOError(), False),
        (RuntimeError('reentrant call'), False),
    ],
)
def test_a_stream_that_fails(failure, lost):
    """A line that does not get through is dropped; a stream that is gone is left alone."""
    out = Stream(failure)
    watcher = terminal.TerminalWatcher(out)
    watcher.progress(Progress('Layer', 'Rendering', 0.5, 1, 2, 1.0, 1.0))
    watcher.note('dropped')
    out.failure = None
    watcher.note('later')
    assert out.getvalue() == ('' if lost else 'later\n')
    assert watcher.warnings() == []
    watcher.message('WARNING', 'kept')
    assert watcher.warnings() == ['kept']


def test_names_that_a_stream_cannot_spell():
    out = Stream(None)
    terminal.TerminalWatcher(out).note('Fläche \udcff')
    assert out.getvalue() == 'Fl\\xe4che \\udcff\n'


def test_no_stream_at_all():
    watcher = terminal.TerminalWatcher(None)
    watcher.progress(Progress('Layer', 'Rendering', 1.0, 2, 2, 1.0))
    watcher.message('WARNING', 'text')
    watcher.note('done')


@pytest.fixture
def scene(engine, fake) -> bpy.types.Scene:
    made = build.new_scene()
    build.camera(made)
    made.render.engine = 'COTORRA'
    made.render.resolution_x, made.render.resolution_y = 12, 8
    made.render.use_motion_blur = True  # a warning
    return made


class Failing(watch.Watcher):
    """Raises where it is told, and counts how often it was asked."""

    def __init__(self, method, failure):
        self.calls = 0
        setattr(self, method, self._fail)
        self._failure = failure

    def _fail(self, *_what):
        self.calls += 1
        raise self._failure


@pytest.mark.parametrize('failure', [OSError(errno.EIO, 'gone'), ValueError('a slip'), BrokenPipeError()])
@pytest.mark.parametrize('method', ['progress', 'message'])
def test_a_watcher_that_raises_is_left_alone(scene, tmp_path, capfd, method, failure):
    """It is told of on stderr, once; its messages go to Blender instead."""
    watcher = Failing(method, failure)
    with watch.attached(watcher):
        path = render_to(scene, tmp_path / 'o.exr')
    assert path.exists() and watcher.calls == 1
    (entry,) = stats.last(scene.name)
    assert entry.error == '' and entry.progress == 1.0
    assert entry.warnings == ['Scene "Scene": motion blur is not rendered yet']
    told = capfd.readouterr()
    assert told.err.count('Traceback') == 1 and type(failure).__name__ in told.err
    assert ('motion blur is not rendered yet' in told.out + told.err) == (method == 'message')


def test_an_exception_is_reported_though_stderr_is_lost(scene, tmp_path, monkeypatch):
    import fake_native

    class Lost(io.StringIO):
        def write(self, _text):
            raise OSError(errno.ENOSPC, 'No space left on device')

    fake_native.configure('fail_in=render')
    for stderr in (Lost(), None):
        monkeypatch.setattr(sys, 'stderr', stderr)
        with pytest.raises(RuntimeError, match='a worker failed'):
            render_to(scene, tmp_path / 'o.exr')


def test_words_that_blender_cannot_spell(scene, tmp_path, monkeypatch, capfd):
    """A name of bytes that are no UTF-8: an exception where it is reported would leave `render`, and crash Blender."""

    def complain(_scene, _camera, log):
        log.warning('image \udcff\0 is missing')
        log.error('camera \udcff\0 is broken')

    monkeypatch.setattr(export, 'export_camera', complain)
    with pytest.raises(RuntimeError) as caught:
        render_to(scene, tmp_path / 'o.exr', multilayer=True)
    assert str(caught.value) == 'Error: Cotorra: camera \\udcff\\0 is broken\n'
    told = capfd.readouterr()
    assert 'image \\udcff\\0 is missing' in told.out + told.err


@pytest.mark.parametrize('content', ['', 'a b c', '1'])
def test_memory_that_the_system_tells_oddly(tmp_path, monkeypatch, content):
    (tmp_path / 'statm').write_text(content)
    monkeypatch.setattr(stats, 'Path', lambda _path: tmp_path / 'statm')
    assert stats.memory_now() == 0
    (tmp_path / 'statm').write_text('10 3 1')
    assert stats.memory_now() == 3 * os.sysconf('SC_PAGE_SIZE')
