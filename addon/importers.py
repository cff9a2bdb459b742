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

from . import choices, watch
from .demos import parts
from .terminal import CommandError

# The picture of a file without a camera is taken from the front, the right and above, as product pictures are.
VIEW_DIRECTION = (-0.55, 1.0, -0.45)
LENS = 50.0
MARGIN = 1.2  # times the distance of the nearest point at which everything just fits

# Lights of a file without any: a sun from the left behind the viewer, and a grey sky that keeps shadows from black.
SUN_DIRECTION = (0.3, 0.7, -1.0)
SUN_STRENGTH = 3.0
SUN_ANGLE = 5.0
WORLD_COLOR = (0.25, 0.25, 0.25)

# Lines of an importer's log that tell what it could not read; Blender 4.5 says where in its sources, too.
PROBLEM = re.compile(
    r'(?:.*\|\s*)?\b(?:(?:Runtime )?error|warn(?:ing)?)\b:?\s*(?:\([\w.]+\): \S+ \w+: )?(.*)', re.IGNORECASE
)
PROBLEMS_MAX = 20

# Folders of links that `_plain` made; images are read from them until the process ends.
_links: list[tempfile.TemporaryDirectory[str]] = []


def load(path: Path) -> bpy.types.Scene:
    """Replace everything in memory by what the file holds."""
    import addon_utils

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    importer = choices.IMPORTERS[path.suffix.lower()]
    if importer == 'import_scene.gltf':
        addon_utils.enable('io_scene_gltf2')
    module, name = importer.split('.')
    operator = getattr(getattr(bpy.ops, module), name)
    failure = ''
    plain = _plain(path)
    with _log_taken() as log:
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
    scene.cotorra.settings_from = 'COTORRA'  # the file says nothing, and nobody asked for Cycles'
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
    camera = bpy.data.objects.new('Camera', bpy.data.cameras.new('Camera'))
    scene.collection.objects.link(camera)
    scene.camera = camera
    camera.data.lens = LENS
    turn = Vector(VIEW_DIRECTION).to_track_quat('-Z', 'Y')
    camera.rotation_euler = turn.to_euler()
    # The corners of the box as the camera sees them from its centre, and how far away each must be to be seen.
    centre = 0.5 * (low + high)
    box = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low) + low
    seen = (box - centre) @ np.array(turn.to_matrix())
    frame = np.array(camera.data.view_frame(scene=scene))
    reach = np.abs(frame[:, :2] / frame[:, 2:]).max(axis=0)
    nearest = seen[:, 2].max()
    away = float((np.abs(seen[:, :2]) / reach + seen[:, 2:]).max() - nearest) or 1.0
    distance = nearest + MARGIN * away
    camera.location = turn @ Vector((0.0, 0.0, distance)) + Vector(centre)
    camera.data.clip_start = 0.01 * MARGIN * away
    camera.data.clip_end = 10.0 * float(distance - seen[:, 2].min())


def _plain(path: Path) -> Path:
    """The file, by a name without backslashes, which importers take for slashes; its neighbours lie beside it."""
    path = path.resolve()
    if os.name != 'posix' or '\\' not in str(path):
        return path
    links = tempfile.TemporaryDirectory(prefix='cotorra-')
    _links.append(links)
    for neighbour in path.parent.iterdir():
        (Path(links.name) / neighbour.name).symlink_to(neighbour)
    plain = Path(links.name) / path.name.replace('\\', '_')
    if not plain.exists():
        plain.symlink_to(path)
    return plain


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
