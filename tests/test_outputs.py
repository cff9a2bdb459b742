# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that `cotorra render` leaves: an old one is replaced by a whole one, in one step, or it stays.

What is in the pictures is other tests'; the native module is a stand-in wherever Blender writes one.
"""

from __future__ import annotations

import errno
import json
import os
import resource
import stat

import bpy
import OpenImageIO as oiio
import pytest
from cotorra import cli, outputs, terminal

from render_calls import run_cli
from scenes import build

OLD = b'an older picture'


def render(*arguments, size='16x9'):
    """A demo, by the stand-in."""
    return run_cli('render', '--demo', 'box_room', '--samples', 1, '--size', size, *arguments, fake='')


def width(path):
    image = oiio.ImageInput.open(str(path))
    return image.spec().width if image is not None else 0


@pytest.fixture
def folder(tmp_path):
    """A folder in which nothing else stands in the end."""
    made = tmp_path / 'pictures'
    made.mkdir()
    return made


# What comes to stand where.


def test_the_old_file_stays_until_the_new_one_is_whole(folder):
    path = folder / 'o.bin'
    path.write_bytes(OLD)
    with outputs.replacing(path) as new:
        new.write_bytes(b'half')
        assert path.read_bytes() == OLD
        new.write_bytes(b'whole')
        reader = path.open('rb')
    assert path.read_bytes() == b'whole' and list(folder.iterdir()) == [path]
    with reader:
        assert reader.read() == OLD  # who has it open goes on seeing the old one, not half of the new


@pytest.mark.parametrize('failure', [ValueError('no'), KeyboardInterrupt()])
def test_what_fails_replaces_nothing(folder, failure):
    path = folder / 'o.bin'
    path.write_bytes(OLD)
    with pytest.raises(type(failure)), outputs.replacing(path) as new:
        new.write_bytes(b'half')
        raise failure
    assert path.read_bytes() == OLD and list(folder.iterdir()) == [path]


def test_a_file_that_cannot_be_written_is_named(folder):
    path = folder / 'o.bin'
    path.write_bytes(OLD)
    with pytest.raises(terminal.CommandError, match='o.bin: cannot be written: No space left'):
        with outputs.replacing(path):
            raise OSError(errno.ENOSPC, 'No space left on device')
    assert path.read_bytes() == OLD


def test_two_at_once_leave_one_whole_file(folder):
    path = folder / 'o.bin'
    with outputs.replacing(path) as first, outputs.replacing(path) as second:
        assert first != second
        first.write_bytes(b'first')
        second.write_bytes(b'second')
    assert path.read_bytes() == b'first' and list(folder.iterdir()) == [path]


def test_a_link_stays_a_link_and_rights_stay(folder, tmp_path):
    path, link = tmp_path / 'file.bin', folder / 'link.bin'
    path.write_bytes(OLD)
    path.chmod(0o640)
    link.symlink_to(path)
    with outputs.replacing(link) as new:
        new.write_bytes(b'new')
    assert link.is_symlink() and path.read_bytes() == b'new'
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    path.unlink()
    with outputs.replacing(link) as new:
        new.write_bytes(b'newer')
    assert link.is_symlink() and path.read_bytes() == b'newer'


def test_a_new_file_has_the_usual_rights(folder):
    before = os.umask(0o027)
    try:
        with outputs.replacing(folder / 'o.bin') as new:
            new.write_bytes(b'new')
    finally:
        os.umask(before)
    assert stat.S_IMODE((folder / 'o.bin').stat().st_mode) == 0o640


def test_a_device_is_written_to_and_stays_one(folder):
    link = folder / 'o.png'
    link.symlink_to('/dev/null')
    code, told = render('-o', link)
    assert code == 0, told
    assert link.is_symlink() and stat.S_ISCHR(os.stat(link).st_mode) and list(folder.iterdir()) == [link]
    link.unlink()
    link.symlink_to('/dev/full')
    code, told = render('-o', link)
    assert code == terminal.FAILED and 'o.png: cannot be written: No space left on device' in told


def test_where_nothing_may_be_replaced_the_file_is_written_over(folder, monkeypatch):
    """Another user's file in a folder such as /tmp, or one that is mounted by itself."""
    path = folder / 'o.bin'
    path.write_bytes(OLD)

    def refuse(_source, _target):
        raise OSError(errno.EBUSY, 'Device or resource busy')

    monkeypatch.setattr(os, 'replace', refuse)
    with outputs.replacing(path) as new:
        new.write_bytes(b'new')
    assert path.read_bytes() == b'new' and list(folder.iterdir()) == [path]


def test_a_link_to_itself_and_names_too_long_are_named(folder):
    loop = folder / 'loop.png'
    loop.symlink_to(loop)
    for path, words in ((loop, 'symbolic links'), (folder / ('x' * 300 + '.png'), 'name too long')):
        code, told = render('-o', path)
        assert code == terminal.FAILED and f'{path}: cannot be written' in told and words in told


# Names.


@pytest.mark.parametrize(
    'name',
    ['a\\b.exr', 'ba\udcffd.exr', '{x}.exr', '%d.exr', 'two\nlines.png', 'back\\slash\\o.png', 'UPPER.PNG', '-o.png'],
)
@pytest.mark.parametrize('where', ['', 'fold\\er {x}', 'fold\udcffer'])
def test_names_that_blender_would_read_otherwise(folder, where, name):
    path = folder / where / name
    figures = path.with_suffix('.json')
    code, told = render('-o', path, '--stats', figures)
    assert code == 0, told
    assert sorted(path.parent.iterdir()) == sorted([path, figures])
    assert path.read_bytes()[:4] in (b'v/1\x01', b'\x89PNG')
    assert json.loads(figures.read_bytes())['frames'][0]['output'] == str(path)


def test_a_folder_whose_name_is_longer_than_blenders(folder):
    path = folder
    for letter in 'abcdefg':
        path /= letter * 200
    code, told = render('-o', path / 'o.exr')
    assert code == 0, told
    assert [entry.name for entry in path.iterdir()] == ['o.exr']


# Pictures.


def test_a_picture_that_is_cut_off_does_not_replace_a_whole_one(folder):
    """The disk is full when the image is saved; here a limit on the size of files stands for it."""
    for suffix in ('exr', 'png'):
        path = folder / f'o.{suffix}'
        path.write_bytes(OLD)
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (200, limits[1]))
        try:
            code, told = render('-o', path, size='256x256')
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert code == terminal.FAILED, told
        assert f'o.{suffix}: the image was not written to its end' in told
        assert path.read_bytes() == OLD and list(folder.iterdir()) == [path]
        path.unlink()


def test_a_picture_that_blender_does_not_write_is_missed(folder, tmp_path, engine):
    """Also where one was there before; here a script in Blender sends the new one elsewhere."""
    path = folder / 'o.exr'
    assert render('-o', path)[0] == 0
    old = path.read_bytes()

    def elsewhere(scene, *_more):
        scene.render.filepath = str(tmp_path / 'elsewhere.exr')

    bpy.app.handlers.render_init.append(bpy.app.handlers.persistent(elsewhere))
    try:
        code, told = render('-o', path)
    finally:
        bpy.app.handlers.render_init.remove(elsewhere)
    assert (tmp_path / 'elsewhere.exr').exists()
    assert code == terminal.FAILED and 'o.exr: Blender did not write the image' in told
    assert path.read_bytes() == old and list(folder.iterdir()) == [path]


def test_statistics_are_never_written_over_anything_else(folder, tmp_path, engine):
    build.camera(build.new_scene())
    blend = tmp_path / 'scene.blend'
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    content = blend.read_bytes()
    path, link = folder / 'o.exr', folder / 'link.json'
    link.symlink_to(path)
    hard = folder / 'scene.json'
    hard.hardlink_to(blend)
    frames = ('-o', folder / 'f_##.exr', '--frame', '1..2')
    for arguments in (
        ('-o', path, '--stats', path),
        ('-o', path, '--stats', link),
        ('-o', path, '--stats', folder / '..' / folder.name / 'o.exr'),
        ('-o', path, '--stats', blend),
        ('-o', path, '--stats', hard),
        (*frames, '--stats', folder / 'f_02.exr'),
        ('-o', folder / 'f_##.exr', '--stats', folder / 'f_01.exr'),
    ):
        code, told = run_cli('render', blend, '--size', '8x8', *arguments, fake='')
        assert code == terminal.FAILED and 'the statistics would be written over' in told, arguments
    assert sorted(folder.iterdir()) == [link, hard] and blend.read_bytes() == content


def test_statistics_that_cannot_be_written_hide_no_other_failure(folder, monkeypatch):
    def refuse(*_arguments):
        raise terminal.CommandError('s.json: the disk is full')

    monkeypatch.setattr(cli, 'write_stats', refuse)
    arguments = ('render', '--demo', 'box_room', '--size', '8x8', '-o', folder / 'o.exr', '--stats', folder / 's.json')
    code, told = run_cli(*arguments, fake='fail_in=render')
    assert code == terminal.FAILED and 'a worker failed; s.json: the disk is full' in told
