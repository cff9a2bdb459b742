# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds and validates an installable extension: manifest, add-on, and the wheels of the native module and of Embree.

It is for one platform, the one that it runs on; how Blender installs it is Blender's affair.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

ROOT = Path(__file__).resolve().parent.parent
STAGE = ROOT / 'build' / 'extension'
PLATFORMS = {
    ('Linux', 'x86_64'): 'linux-x64',
    ('Darwin', 'x86_64'): 'macos-x64',
    ('Darwin', 'arm64'): 'macos-arm64',
    ('Windows', 'AMD64'): 'windows-x64',
}


def pip(*arguments: str, **environment: str) -> None:
    """Runs the environment's pip; its words are shown only where it fails."""
    command = [sys.executable, '-m', 'pip', '--disable-pip-version-check', *arguments]
    result = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f'extension: {" ".join(arguments[:2])} failed\n{result.stdout}{result.stderr}')


def pinned(requirement: str) -> str:
    """A requirement of pyproject.toml with its version, by name."""
    project = tomllib.loads((ROOT / 'pyproject.toml').read_text())['project']
    return next(line for line in project['dependencies'] if re.match(rf'{requirement}\b', line))


@contextmanager
def exclusive() -> Iterator[None]:
    """Keeps scripts/setup from building into the same folder meanwhile; the lock is the one that it takes."""
    try:
        import fcntl
    except ImportError:  # Windows, where scripts/setup takes none either
        yield
        return
    with open(Path(sys.prefix) / '.cotorra-lock', 'w') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def collect_wheels(folder: Path, pythons: list[str]) -> None:
    """Puts the native module's wheel, for the running Python, and Embree's for each Python into the folder."""
    native = ['--no-deps', '--no-build-isolation', '--wheel-dir', str(folder), str(ROOT)]
    with exclusive():
        pip('wheel', *native, COTORRA_NATIVE_ONLY='true')
    for version in pythons:
        chosen = ['--only-binary', ':all:', '--python-version', version]
        pip('download', '--no-deps', *chosen, '--dest', str(folder), pinned('embreex'))


def write_manifest(target: Path, here: str, wheels: list[str]) -> None:
    """The project's manifest, narrowed to one platform and with the wheels that are there."""
    text = (ROOT / 'blender_manifest.toml').read_text()
    text, count = re.subn(r'^platforms = .*$', f"platforms = ['{here}']", text, flags=re.MULTILINE)
    assert count == 1, 'blender_manifest.toml has no line with its platforms'
    lines = ''.join(f"  './wheels/{name}',\n" for name in wheels)
    # Before the first table, or the key would be the table's.
    head, bracket, tail = text.partition('\n[permissions]')
    target.write_text(f'{head}\nwheels = [\n{lines}]\n{bracket}{tail}')


def blender_ext(*arguments: str) -> None:
    """Blender's own tool for extensions, from the bpy module's files."""
    scripts = Path(bpy.utils.system_resource('SCRIPTS'))
    tool = scripts / 'addons_core' / 'bl_pkg' / 'cli' / 'blender_ext.py'
    result = subprocess.run([sys.executable, str(tool), *arguments], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f'extension: Blender refuses it ({arguments[0]})\n{result.stdout}{result.stderr}')


def build(output: Path, pythons: list[str]) -> Path:
    """Builds the extension into the folder `output` and returns the path of the zip."""
    key = (platform.system(), platform.machine())
    if key not in PLATFORMS:
        sys.exit(f'extension: there is no Embree wheel for {key[0]} on {key[1]}, so no extension can be built')
    here = PLATFORMS[key]
    shutil.rmtree(STAGE, ignore_errors=True)
    shutil.copytree(ROOT / 'addon', STAGE, ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(ROOT / 'LICENSE', STAGE)
    (STAGE / 'wheels').mkdir()
    collect_wheels(STAGE / 'wheels', pythons)
    write_manifest(STAGE / 'blender_manifest.toml', here, sorted(path.name for path in (STAGE / 'wheels').iterdir()))

    version = tomllib.loads((STAGE / 'blender_manifest.toml').read_text())['version']
    output.mkdir(parents=True, exist_ok=True)
    archive = output / f'cotorra-{version}-{here}.zip'
    archive.unlink(missing_ok=True)
    blender_ext('build', '--source-dir', str(STAGE), '--output-filepath', str(archive))
    blender_ext('validate', str(archive))
    return archive


def main() -> None:
    parser = argparse.ArgumentParser(prog='scripts/extension', description='Builds the Cotorra extension for Blender.')
    parser.add_argument('--output', type=Path, default=ROOT / 'dist', help='folder of the zip (default: dist)')
    parser.add_argument(
        '--python', action='append', metavar='VERSION', help='Pythons to carry Embree for (default: this)'
    )
    arguments = parser.parse_args()
    archive = build(arguments.output, arguments.python or [sysconfig.get_python_version()])
    print(f'{archive} ({archive.stat().st_size / 1e6:.1f} MB)')


if __name__ == '__main__':
    main()
