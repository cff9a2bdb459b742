# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds and validates an installable extension: manifest, add-on, and the wheels of the native module and of Embree.

One serves every Blender of the platform that it runs on; how Blender installs it is Blender's affair.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import bpy

ROOT = Path(__file__).resolve().parent.parent
STAGE = ROOT / 'build' / 'extension'
NOT_FOUND = 3  # what scripts/setup exits with where there is no such Python
PLATFORMS = {
    ('Linux', 'x86_64'): 'linux-x64',
    ('Darwin', 'x86_64'): 'macos-x64',
    ('Darwin', 'arm64'): 'macos-arm64',
    ('Windows', 'AMD64'): 'windows-x64',
}

# The Pythons that Blenders embed: 4.5 has 3.11, 5.2 has 3.13, or 3.14 where a distribution built it.
PYTHONS = ('3.11', '3.13', '3.14')
OLD = '3.11'  # the native module's wheel for the running Python serves all later ones, and none before 3.12


def pip(*arguments: str, python: str = sys.executable, **environment: str) -> None:
    """Runs the pip of a Python; its words are shown only where it fails."""
    command = [python, '-m', 'pip', '--disable-pip-version-check', *arguments]
    path = os.pathsep.join([str(Path(python).parent), os.environ.get('PATH', '')])
    result = subprocess.run(command, env={**os.environ, 'PATH': path} | environment, capture_output=True, text=True)
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
    (ROOT / 'build').mkdir(exist_ok=True)
    with open(ROOT / 'build' / '.lock', 'w') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def old_python() -> str | None:
    """A Python 3.11 with what builds the module; None where there is none: scripts/setup has said how to get it."""
    command = [str(ROOT / 'scripts' / 'setup'), '--tools']
    result = subprocess.run(command, env={**os.environ, 'COTORRA_BLENDER': '4.5'}, stdout=subprocess.PIPE, text=True)
    if result.returncode not in (0, NOT_FOUND):
        sys.exit(result.returncode)
    return result.stdout.strip() if result.returncode == 0 else None


def collect_wheels(folder: Path, pythons: Sequence[str], old: str | None) -> None:
    """Puts the native module's wheels, one of them for `old`, and Embree's for each Python into the folder."""
    native = ['--no-deps', '--no-build-isolation', '--wheel-dir', str(folder), str(ROOT)]
    with exclusive():
        for python in [sys.executable, old]:
            if python is not None:
                print(f'extension: building the native module with {python}', file=sys.stderr)
                pip('wheel', *native, python=python, COTORRA_NATIVE_ONLY='true')
    for wheel in folder.glob('*.whl'):
        name_build(wheel)
    print(f'extension: fetching Embree for Python {", ".join(pythons)}', file=sys.stderr)
    for version in pythons:
        chosen = ['--only-binary', ':all:', '--python-version', version]
        pip('download', '--no-deps', *chosen, '--dest', str(folder), pinned('embreex'))


def name_build(wheel: Path) -> None:
    """Adds to the version of a wheel what tells this build from others of the version.

    Blender leaves a wheel alone whose name and version are installed already: a newer build would never get there.
    """
    name, version, tags = wheel.name.split('-', 2)
    with zipfile.ZipFile(wheel) as source:
        files = {entry: source.read(entry) for entry in source.infolist()}
    content = hashlib.sha256(b''.join(data for entry, data in files.items() if '.dist-info/' not in entry.filename))
    build = f'{version}+{content.hexdigest()[:12]}'
    old, new = f'{name}-{version}.dist-info/', f'{name}-{build}.dist-info/'
    with zipfile.ZipFile(wheel.with_name(f'{name}-{build}-{tags}'), 'w', zipfile.ZIP_DEFLATED) as target:
        for entry, data in files.items():
            if entry.filename == f'{old}METADATA':
                data = data.replace(f'\nVersion: {version}\n'.encode(), f'\nVersion: {build}\n'.encode(), 1)
            elif entry.filename == f'{old}RECORD':
                lines = data.decode().replace(old, new).splitlines()
                data = '\n'.join([hashless(line) if '/METADATA,' in line else line for line in lines] + ['']).encode()
            entry.filename = entry.filename.replace(old, new)
            target.writestr(entry, data)
    wheel.unlink()


def hashless(line: str) -> str:
    """A line of a wheel's RECORD that states the file alone."""
    return line.split(',', 1)[0] + ',,'


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


def build(output: Path, pythons: Sequence[str]) -> Path:
    """Builds the extension for these Pythons into the folder `output` and returns the path of the zip."""
    key = (platform.system(), platform.machine())
    if key not in PLATFORMS:
        sys.exit(f'extension: there is no Embree wheel for {key[0]} on {key[1]}, so no extension can be built')
    here = PLATFORMS[key]
    old = old_python() if OLD in pythons else None
    if OLD in pythons and old is None:
        pythons = [version for version in pythons if version != OLD]
        print(f'extension: Blender 4.5 is left out, which embeds Python {OLD}', file=sys.stderr)
    shutil.rmtree(STAGE, ignore_errors=True)
    shutil.copytree(ROOT / 'addon', STAGE, ignore=shutil.ignore_patterns('__pycache__'))
    shutil.copy(ROOT / 'LICENSE', STAGE)
    (STAGE / 'wheels').mkdir()
    collect_wheels(STAGE / 'wheels', pythons, old)
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
        '--python',
        action='append',
        choices=PYTHONS,
        metavar='VERSION',
        help=f'Python of a Blender that the extension is for, may be repeated (default: {", ".join(PYTHONS)})',
    )
    arguments = parser.parse_args()
    archive = build(arguments.output, arguments.python or PYTHONS)
    print(f'{archive} ({archive.stat().st_size / 1e6:.1f} MB)')


if __name__ == '__main__':
    main()
