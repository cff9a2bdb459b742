# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders of tests: into a file through Blender's operator, and back out of it.

Scenes are made in tests/scenes, and judged in the tests.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
from cotorra import compat

TESTS = Path(__file__).resolve().parent


def render_to(scene: bpy.types.Scene, path: Path, multilayer: bool = False) -> Path:
    """Render the frame into a 32-bit EXR."""
    image = scene.render.image_settings
    compat.set_image_format(image, 'OPEN_EXR_MULTILAYER' if multilayer else 'OPEN_EXR')
    image.color_depth = '32'
    image.color_mode = 'RGBA'
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return path


def read_exr(path: Path) -> dict[str, dict[str, np.ndarray]]:
    """Pixels by layer and channel, top row first; channels without a layer stand under ''."""
    found: dict[str, dict[str, np.ndarray]] = {}
    image = oiio.ImageInput.open(str(path))
    assert image is not None, oiio.geterror()
    part = 0
    while image.seek_subimage(part, 0):
        names = image.spec().channelnames
        pixels = image.read_image('float')
        for index, name in enumerate(names):
            layer, _, channel = name.rpartition('.')
            found.setdefault(layer, {})[channel] = pixels[:, :, index]
        part += 1
    return found


def run_cli(*arguments: object, fake: str | None = None, start_only: bool = False) -> subprocess.Popen[str]:
    """`cotorra ARGUMENTS` in a process of its own; with the native module replaced where `fake` configures one."""
    lines = [f'import sys; sys.path.insert(0, {str(TESTS)!r})', 'import conftest']
    if fake is not None:
        lines += [
            'import fake_native',
            "sys.modules['cotorra_native'] = fake_native",
            f'fake_native.configure({fake!r})',
        ]
    lines += ['from cotorra.cli import main', 'sys.exit(main())']
    process = subprocess.Popen(
        [sys.executable, '-c', '\n'.join(lines), *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, 'PYTHONUNBUFFERED': '1'},
    )
    return process
