# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's zip, as ./scripts/extension builds it, installs into an empty Blender and renders there.

The Blender is the bpy module; that the zip also passes Blender's own checker is part of building it.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

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

archive, image = sys.argv[1:]
bpy.ops.extensions.package_install_files(filepath=archive, repo='user_default', enable_on_install=True)
scene = bpy.context.scene
scene.render.engine = 'COTORRA'
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 32, 24, 100
scene.render.image_settings.file_format = 'OPEN_EXR'
scene.render.filepath = image
bpy.ops.render.render(write_still=True)
import cotorra_native
native = sys.modules['bl_ext.user_default.cotorra.native']
print('RESULT ' + json.dumps({'native': cotorra_native.__file__, 'embree': native.embree_library()}))
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
    assert sorted(wheel.split('/')[-1].split('-')[0] for wheel in manifest['wheels']) == ['cotorra', 'embreex']
    assert len(manifest['platforms']) == 1
    assert not [name for name in names if '__pycache__' in name or name.startswith(('tests/', 'native/', 'kernels/'))]


def test_version_is_told_once() -> None:
    project = tomllib.loads((ROOT / 'pyproject.toml').read_text())['project']
    manifest = tomllib.loads((ROOT / 'blender_manifest.toml').read_text())
    assert manifest['version'] == project['version']


def test_installs_and_renders(archive: Path, tmp_path: Path) -> None:
    user, image = tmp_path / 'user', tmp_path / 'frame.exr'
    environment = {name: value for name, value in os.environ.items() if not name.startswith(('PYTHON', 'COTORRA'))}
    environment |= {'BLENDER_USER_RESOURCES': str(user), 'TEST_SITE': sysconfig.get_path('platlib')}
    # -S: no site-packages of the environment, -I: no folder of the caller.
    command = [sys.executable, '-I', '-S', '-c', INSTALL_AND_RENDER, str(archive), str(image)]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stdout + result.stderr
    (line,) = [line for line in result.stdout.splitlines() if line.startswith('RESULT ')]
    for path in json.loads(line.removeprefix('RESULT ')).values():
        assert Path(path).is_relative_to(user), f"{path} is not the extension's own"

    import OpenImageIO

    pixels = OpenImageIO.ImageBuf(str(image)).get_pixels()
    assert pixels.shape[:2] == (24, 32)
    assert pixels[..., :3].max() > 0.01, 'the frame is black'
