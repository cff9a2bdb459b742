# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of other programs: Blender's importers read them, and a camera and lights are added where a file has none.

Settings of the render are not made here; .blend files, which bring theirs, are opened by the command line.
"""

from __future__ import annotations

import ctypes
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from . import watch
from .demos import parts
from .terminal import CommandError

# What stands for whom: the operator of each format.
OPERATORS = {
    'glb': 'import_scene.gltf',
    'gltf': 'import_scene.gltf',
    'usd': 'wm.usd_import',
    'usda': 'wm.usd_import',
    'usdc': 'wm.usd_import',
    'usdz': 'wm.usd_import',
    'obj': 'wm.obj_import',
    'stl': 'wm.stl_import',
    'ply': 'wm.ply_import',
    'fbx': 'wm.fbx_import',
}

# The picture of a file without a camera is taken from the front, the right and above, as product pictures are.
VIEW_DIRECTION = (-0.55, 1.0, -0.45)
LENS = 50.0
MARGIN = 1.1  # the distance at which everything just fits, times this

# Lights of a file without any: a white wall that faces the sun is as bright as the world makes it, three times over.
SUN_DIRECTION = (0.2, 0.7, -1.0)
SUN_STRENGTH = 2.5
SUN_ANGLE = 5.0
WORLD_COLOR = (0.4, 0.4, 0.4)

# Lines of an importer's log that tell what it could not read.
PROBLEM = re.compile(r'(?:.*\|\s*)?\b(?:(?:Runtime )?error|warning)\b:?\s*(.*)', re.IGNORECASE)
PROBLEMS_MAX = 20


def load(path: Path) -> bpy.types.Scene:
    """Replace everything in memory by what the file holds."""
    import addon_utils

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    kind = path.suffix.lower().lstrip('.')
    if kind in ('glb', 'gltf'):
        addon_utils.enable('io_scene_gltf2')
    module, name = OPERATORS[kind].split('.')
    operator = getattr(getattr(bpy.ops, module), name)
    failure = ''
    with _plain(path) as plain, _log_taken() as log:
        try:
            operator(filepath=str(plain))
        except Exception as error:  # RuntimeError from Blender's importers, anything from those that are in Python
            failure = '; '.join(dict.fromkeys(str(error).replace('Error: ', '').split('\n'))).strip('; ')
    if failure:
        raise CommandError(f'{path}: {failure}')
    problems = list(dict.fromkeys(match[1] for line in log if (match := PROBLEM.match(line)) and match[1]))
    for problem in problems[:PROBLEMS_MAX]:
        watch.message('WARNING', f'{path}: {problem}')
    if len(problems) > PROBLEMS_MAX:
        watch.message('WARNING', f"{path}: {len(problems) - PROBLEMS_MAX} more of its importer's messages are left out")
    scene = bpy.context.scene
    faceless = [item.name for item in scene.objects if item.type == 'MESH' and not item.data.polygons]
    if faceless:
        watch.message('WARNING', f'{path}: meshes without faces are not seen: {", ".join(faceless)}')
    if not any(item.type not in ('EMPTY', 'CAMERA', 'LIGHT') and item.name not in faceless for item in scene.objects):
        raise CommandError(f'{path}: nothing in it can be rendered')
    return scene


def complete(scene: bpy.types.Scene) -> None:
    """Frame and light what was loaded, where the file did not; the size of the picture must be set."""
    if scene.camera is None:
        scene.camera = next((item for item in scene.objects if item.type == 'CAMERA'), None)
    if scene.camera is None:
        _add_camera(scene)
    if scene.world is None and not any(item.type == 'LIGHT' for item in scene.objects):
        parts.add_sun(scene, 'Sun', (1.0, 1.0, 1.0), SUN_STRENGTH, angle=SUN_ANGLE, direction=SUN_DIRECTION)
        parts.add_world(scene, WORLD_COLOR, 1.0)


def _add_camera(scene: bpy.types.Scene) -> None:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    corners = []
    for instance in depsgraph.object_instances:
        if instance.object.type not in ('EMPTY', 'CAMERA', 'LIGHT') and instance.show_self:
            corners += [instance.matrix_world @ Vector(corner) for corner in instance.object.bound_box]
    found = np.array(corners, np.float64).reshape(-1, 3)
    found = found[np.isfinite(found).all(axis=1)]
    low, high = (found.min(axis=0), found.max(axis=0)) if len(found) else (-np.ones(3), np.ones(3))
    centre, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low)) or 1.0

    camera = bpy.data.objects.new('Camera', bpy.data.cameras.new('Camera'))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.data.lens = LENS
    direction = Vector(VIEW_DIRECTION).normalized()
    camera.rotation_euler = direction.to_track_quat('-Z', 'Y').to_euler()
    bpy.context.view_layer.update()
    box = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    place, _ = camera.camera_fit_coords(bpy.context.evaluated_depsgraph_get(), np.array(box, np.float32).ravel())
    middle = Vector(centre)
    away = max((middle - place).dot(direction), 2.0 * radius)
    camera.location = place - direction * (MARGIN - 1.0) * away
    distance = away * MARGIN
    camera.data.clip_start = 0.001 * distance
    camera.data.clip_end = 10.0 * (distance + radius)


@contextmanager
def _plain(path: Path) -> Iterator[Path]:
    """The file, by a name without backslashes, which importers take for slashes; its neighbours lie beside it."""
    if os.name != 'posix' or '\\' not in str(path.resolve()):
        yield path.resolve()
        return
    with tempfile.TemporaryDirectory(prefix='cotorra-') as folder:
        for neighbour in path.resolve().parent.iterdir():
            (Path(folder) / neighbour.name).symlink_to(neighbour)
        plain = Path(folder) / path.name.replace('\\', '_')
        if not plain.exists():
            plain.symlink_to(path.resolve())
        yield plain


@contextmanager
def _log_taken() -> Iterator[list[str]]:
    """The lines that are printed while the block runs, by Blender or Python, instead of their being shown."""
    lines: list[str] = []
    libc = ctypes.CDLL(None) if os.name == 'posix' else ctypes.cdll.msvcrt

    def flush() -> None:
        libc.fflush(None)
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except (AttributeError, OSError, ValueError):
                pass

    with tempfile.TemporaryFile() as taken:
        flush()
        before = [(number, os.dup(number)) for number in (1, 2)]
        try:
            for number, _ in before:
                os.dup2(taken.fileno(), number)
            yield lines
        finally:
            flush()
            for number, kept in before:
                os.dup2(kept, number)
                os.close(kept)
            taken.seek(0)
            lines += taken.read().decode('utf-8', 'replace').splitlines()
