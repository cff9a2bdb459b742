# SPDX-License-Identifier: GPL-3.0-or-later
"""scripts/setup and the scripts that call it, where the folder is another user's, read-only, or reached by a link.

The folder is a stand-in with the real scripts; nothing is installed or built here.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parent.parent / 'scripts'
NOBODY = 65534

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='the scripts are for bash')


@pytest.fixture
def checkout():
    """A folder as setup leaves it, that every user can reach; its Python says what it is called with."""
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        root.chmod(0o755)
        shutil.copytree(SCRIPTS, root / 'scripts')
        for folder in ('native', 'kernels', '.venv/bin'):
            (root / folder).mkdir(parents=True)
        for file in ('CMakeLists.txt', 'pyproject.toml', '.venv/.cotorra-lock'):
            (root / file).touch()
        python = root / '.venv/bin/python'
        python.write_text('#!/bin/sh\n[ "$1" = -c ] || echo called with "$@"\n')
        python.chmod(0o755)
        summed = subprocess.run(['cksum'], stdin=(root / 'pyproject.toml').open(), capture_output=True, text=True)
        (root / '.venv/.cotorra-group-build').write_text(summed.stdout)
        (root / '.venv/.cotorra-built').touch()
        yield root
        for folder in (root, *root.glob('.venv')):
            folder.chmod(0o755)


def lock(root: Path) -> None:
    """Nobody may write there; it is another user's for whoever calls `script`."""
    for folder in (root, root / '.venv', root / '.venv/bin'):
        folder.chmod(0o555)
    (root / '.venv/.cotorra-lock').chmod(0o444)


def script(path: Path, *arguments: str, **more):
    """Run a script; by another user where this one is root, who may write anywhere."""
    other = {'user': NOBODY, 'group': NOBODY, 'extra_groups': []} if os.geteuid() == 0 else {}
    environment = {name: value for name, value in os.environ.items() if not name.startswith(('COTORRA_', 'CXX'))}
    return subprocess.run(
        [str(path), *arguments], capture_output=True, text=True, cwd='/', env=environment, **{**other, **more}
    )


def test_a_folder_that_may_not_be_written_to_serves_what_is_there(checkout):
    lock(checkout)
    done = script(checkout / 'scripts/cotorra', 'render', '--help')
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout == 'called with -P -m cotorra.cli render --help\n'


@pytest.mark.parametrize(
    'what, words',
    [
        ('.venv/.cotorra-built', 'the native module is not built, or older than its sources'),
        ('.venv/.cotorra-group-build', "the packages of 'build' are not installed, or not those of pyproject.toml"),
        ('.venv/bin/python', '.venv holds no Python 3.13 that runs'),
        ('.venv', 'there is no .venv yet'),
    ],
)
def test_and_says_what_is_needed_where_that_will_not_do(checkout, what, words):
    path = checkout / what
    if path.is_dir():
        shutil.rmtree(path)
        checkout.chmod(0o555)
    else:
        path.unlink()
        lock(checkout)
    done = script(checkout / 'scripts/cotorra')
    assert done.returncode == 1 and done.stdout == ''
    assert f'setup: {words}, and {checkout} cannot be written to by ' in done.stderr
    assert f'{checkout}/scripts/setup' in done.stderr


def test_links_to_the_scripts_lead_to_the_folder(checkout, tmp_path):
    """From one link to the next, relative and absolute, whatever the working folder and its name."""
    folder = tmp_path / 'a link {to} it'
    folder.mkdir()
    (folder / 'first').symlink_to(checkout / 'scripts/cotorra')
    (folder / 'second').symlink_to('first')
    mine = {'user': None, 'group': None, 'extra_groups': None}
    for link in ('first', 'second'):
        done = script(folder / link, 'x y', **mine)
        assert (done.returncode, done.stdout) == (0, 'called with -P -m cotorra.cli x y\n'), done.stderr
    linked = tmp_path / 'setup'
    linked.symlink_to(checkout / 'scripts/setup')
    assert script(linked, **mine).stdout == f'{checkout}/.venv/bin/python\n'


def test_a_stderr_that_is_closed_stops_nothing(checkout):
    """Here where something is to be said: that the module is built again, by a compiler that there is not."""
    (checkout / '.venv/.cotorra-built').unlink()
    lines = f'CXX=true "{checkout}/scripts/cotorra" words'
    for lost in ('2>&-', '2>/dev/full'):
        (checkout / '.venv/.cotorra-built').unlink(missing_ok=True)
        done = subprocess.run(['bash', '-c', f'{lines} {lost}'], capture_output=True, text=True)
        assert (done.returncode, done.stdout) == (0, 'called with -P -m cotorra.cli words\n')
