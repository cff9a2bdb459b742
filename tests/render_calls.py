# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders of tests: into a file through Blender's operator, and back out of it.

Scenes are made in tests/scenes, and judged in the tests.
"""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import OpenImageIO as oiio
import pytest
from cotorra import cli, compat, native

import fake_native

TESTS = Path(__file__).resolve().parent

# What Blender 4.5 calls some passes.
NAMES_4 = {
    'Object Index': 'IndexOB',
    'Material Index': 'IndexMA',
    'Diffuse Color': 'DiffCol',
    'Emission': 'Emit',
    'Environment': 'Env',
    'Ambient Occlusion': 'AO',
}


def here(name: str) -> str:
    """The name of a pass in this Blender."""
    return name if bpy.app.version >= (5, 0, 0) else NAMES_4.get(name, name)


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


def run_cli(*arguments: object, fake: str | None = None) -> tuple[int, str]:
    """Exit code of `cotorra ARGUMENTS`, and what it wrote to stderr; in this process, whose Blender is there already.

    fake: knobs of the stand-in that takes the native module's place.
    """
    told = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stderr(told):
        if fake is not None:
            fake_native.reset()
            fake_native.configure(fake)
            patch.setattr(native, 'load', lambda: fake_native)
            patch.setattr(native, 'embree_library', lambda: 'libembree4.so')
        try:
            code = cli.main([*map(str, arguments)])
        except SystemExit as leave:
            code = leave.code
    return code, told.getvalue()


def start_cli(*arguments: object, fake: str | None = None, **streams: Any) -> subprocess.Popen[str]:
    """Start `cotorra ARGUMENTS` in a process of its own, for tests of what a process is.

    Without arguments it takes them from stdin, as JSON, a command a line, and answers with the exit codes on stdout.
    """
    lines = [f'import json, sys; sys.path.insert(0, {str(TESTS)!r})', 'import conftest']
    if fake is not None:
        lines += ['import fake_native', "sys.modules['cotorra_native'] = fake_native"]
        lines += [f'fake_native.configure({fake!r})']
    lines += ["print('what scripts print is lost with stdout')", 'from cotorra.cli import main']
    lines += ['if sys.argv[1:]: sys.exit(main())']
    lines += ["for line in sys.stdin: print('\\ncode', main(json.loads(line)), flush=True)"]
    command = [sys.executable, '-c', '\n'.join(lines), *map(str, arguments)]
    pipes = dict.fromkeys(('stdin', 'stdout', 'stderr'), subprocess.PIPE)
    buffered = {**os.environ, 'PYTHONUNBUFFERED': ''}
    return subprocess.Popen(command, text=True, env=buffered, **{**pipes, **streams})
