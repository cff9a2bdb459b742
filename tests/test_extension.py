# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's zip, as ./scripts/extension builds it, installs into an empty Blender and renders there.

The Blenders are the bpy modules, the older one where it is set up; that the zip passes Blender's own checker is part of
building it.
"""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

OLD_PYTHON = ROOT / '.venv-4.5' / 'bin' / 'python'

# Runs without site-packages' .pth files; Cotorra and Embree, which pip installed there too, must come out of the zip.
INSTALL_AND_RENDER = """
import importlib.machinery, json, os, sys

class OnlyFromExtension:
    def find_spec(self, name, path=None, target=None):
        if name in {'cotorra', 'cotorra_native', 'embreex'}:
            mine = [folder for folder in sys.path if folder.startswith(os.environ['BLENDER_USER_RESOURCES'])]
            spec = importlib.machinery.PathFinder.find_spec(name, mine)
            if spec is None:
                raise ModuleNotFoundError(f'{name} is not in the extension', name=name)
            return spec

sys.meta_path.insert(0, OnlyFromExtension())
sys.path.append(os.environ['TEST_SITE'])
import bpy

def install(archive):
    bpy.ops.extensions.package_install_files(filepath=archive, repo='user_default', enable_on_install=True)

archive, image, *newer = sys.argv[1:]
install(archive)
scene = bpy.context.scene
scene.render.engine = 'COTORRA'
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 32, 24, 100
scene.render.image_settings.file_format = 'OPEN_EXR'
scene.render.filepath = image
bpy.ops.render.render(write_still=True)
import cotorra_native
native = sys.modules['bl_ext.user_default.cotorra.native']
print('RESULT ' + json.dumps({'native': cotorra_native.__file__, 'embree': native.embree_library()}))
for path in newer:
    install(path)
    assert sys.modules['bl_ext.user_default.cotorra.native'] is not native, 'the add-on is still the old one'
    try:
        bpy.ops.render.render()
    except RuntimeError as error:
        print(f'UPGRADED {error}')
    print('INSTALLED', *os.listdir(os.path.dirname(cotorra_native.__file__)))
bpy.ops.preferences.addon_disable(module='bl_ext.user_default.cotorra')
"""


@pytest.fixture(scope='module')
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp('dist')
    command = [sys.executable, str(ROOT / 'scripts' / 'build_extension.py'), '--output', str(folder)]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr
    (path,) = folder.glob('cotorra-*.zip')
    return path


def test_contents(archive: Path) -> None:
    with zipfile.ZipFile(archive) as opened:
        names = set(opened.namelist())
        manifest = tomllib.loads(opened.read('blender_manifest.toml').decode())
    assert {'__init__.py', 'export/__init__.py', 'LICENSE', 'blender_manifest.toml'} <= names
    assert 'presets/cotorra/material/gold.py' in names
    assert {wheel.removeprefix('./') for wheel in manifest['wheels']} == {n for n in names if n.endswith('.whl')}
    assert len(manifest['platforms']) == 1
    assert not [name for name in names if '__pycache__' in name or name.startswith(('tests/', 'native/', 'kernels/'))]


def has_old_python() -> bool:
    command = [str(ROOT / 'scripts' / 'setup'), '--tools']
    return not subprocess.run(command, env={**os.environ, 'COTORRA_BLENDER': '4.5'}, capture_output=True).returncode


def test_each_blender_has_its_wheels(archive: Path) -> None:
    """One of Embree for each Python; of the native module one for 3.11, and one for all from 3.12 on."""
    with zipfile.ZipFile(archive) as opened:
        wheels = [name.split('/')[-1].split('-') for name in opened.namelist() if name.endswith('.whl')]
    tags = {
        name: sorted(f'{tag}-{abi}' for n, _, tag, abi, _ in wheels if n == name) for name in ('cotorra', 'embreex')
    }
    old = ['cp311-cp311'] if has_old_python() else []
    assert tags == {'cotorra': [*old, 'cp312-abi3'], 'embreex': [*old, 'cp313-cp313', 'cp314-cp314']}


def test_a_wheel_names_its_build(archive: Path) -> None:
    """Blender takes a wheel for installed whose name and version are: so the version tells builds apart."""
    with zipfile.ZipFile(archive) as opened:
        for name in opened.namelist():
            if name.startswith('wheels/cotorra-'):
                version = name.split('-')[1]
                with zipfile.ZipFile(io.BytesIO(opened.read(name))) as wheel:
                    folders = {entry.split('/')[0] for entry in wheel.namelist() if '/' in entry}
                    assert folders == {f'cotorra-{version}.dist-info'} and '+' in version
                    assert f'\nVersion: {version}\n' in wheel.read(f'cotorra-{version}.dist-info/METADATA').decode()


def test_version_is_told_once() -> None:
    project = tomllib.loads((ROOT / 'pyproject.toml').read_text())['project']
    manifest = tomllib.loads((ROOT / 'blender_manifest.toml').read_text())
    assert manifest['version'] == project['version']


def run(python: Path | str, user: Path, *arguments: Path) -> str:
    """What a Blender prints that installs and renders, with a user folder of its own."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(('PYTHON', 'COTORRA'))}
    command = [python, '-c', 'import sysconfig; print(sysconfig.get_path("platlib"))']
    site = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    environment |= {'BLENDER_USER_RESOURCES': str(user), 'TEST_SITE': site}
    # -S: no site-packages of the environment, -I: no folder of the caller.
    command = [python, '-I', '-S', '-c', INSTALL_AND_RENDER, *arguments]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout + result.stderr


def has_bpy(python: Path) -> bool:
    command = [python, '-c', 'import importlib.util, sys; sys.exit(importlib.util.find_spec("bpy") is None)']
    return python.exists() and subprocess.run(command).returncode == 0


@pytest.mark.parametrize('python', [Path(sys.executable), OLD_PYTHON], ids=['5.2', '4.5'])
def test_installs_and_renders(python: Path, archive: Path, tmp_path: Path) -> None:
    # Not everyone has both Blenders; CI sets up both, so that this is skipped on desks alone.
    if not has_bpy(python):
        pytest.skip('Blender 4.5 is not set up (COTORRA_BLENDER=4.5 ./scripts/setup)')
    user, image = tmp_path / 'user', tmp_path / 'frame.exr'
    (line,) = [line for line in run(python, user, archive, image).splitlines() if line.startswith('RESULT ')]
    for path in json.loads(line.removeprefix('RESULT ')).values():
        assert Path(path).is_relative_to(user), f"{path} is not the extension's own"

    import OpenImageIO

    pixels = OpenImageIO.ImageBuf(str(image)).get_pixels()
    assert pixels.shape[:2] == (24, 32)
    assert pixels[..., :3].max() > 0.01, 'the frame is black'


def rebuilt(archive: Path, target: Path) -> Path:
    """The extension as another build of it would be: its native modules differ in a byte that nothing reads."""
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(target, 'w') as made:
        for name in source.namelist():
            data = source.read(name)
            if name.startswith('wheels/cotorra-'):
                build = name.split('-')[1].split('+')[1]
                buffer = io.BytesIO()
                with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(buffer, 'w') as new:
                    for entry in old.namelist():
                        content = old.read(entry) + (b'\0' if entry.endswith('.so') else b'')
                        new.writestr(entry.replace(build, 'newer'), content.replace(build.encode(), b'newer'))
                name, data = name.replace(build, 'newer'), buffer.getvalue()
            elif name == 'blender_manifest.toml':
                data = re.sub(rb'(cotorra-[\d.]+)\+\w+', rb'\1+newer', data)
            made.writestr(name, data)
    return target


def test_an_upgrade_in_a_running_blender_asks_for_a_restart(archive: Path, tmp_path: Path) -> None:
    """The new add-on must not render with the old native module, which Python keeps until Blender ends."""
    newer = rebuilt(archive, tmp_path / 'newer.zip')
    told = run(sys.executable, tmp_path / 'user', archive, tmp_path / 'frame.exr', newer)
    (line,) = [line for line in told.splitlines() if line.startswith('UPGRADED ')]
    assert 'restart Blender' in line
    # Another Blender finds the new one, though the version is the same.
    (line,) = [line for line in told.splitlines() if line.startswith('INSTALLED ')]
    assert re.findall(r'cotorra-[^ ]*\+(\w+)\.dist-info', line) == ['newer']


def test_the_same_again_needs_no_restart(archive: Path, tmp_path: Path) -> None:
    told = run(sys.executable, tmp_path / 'user', archive, tmp_path / 'frame.exr', archive)
    assert not [line for line in told.splitlines() if line.startswith('UPGRADED ')]
