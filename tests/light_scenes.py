# SPDX-License-Identifier: GPL-3.0-or-later
"""A room's corner with a box, a metal ball and a pane of glass, lit by whatever a test hangs in it, beside Cycles.

What a light does there is said in the tests.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from cotorra import stats
from mathutils import Euler, Matrix, Vector

from beside_cycles import in_halves
from scenes import build

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import Reference, same_image

SIZE = (64, 48)
TILE = 8
SAMPLES = 128  # of each half
# What a tile and the whole may differ by beside noise.
LIMIT = 0.03
TOTAL = 0.005


def square(scene: bpy.types.Scene, name: str, size: float, material: bpy.types.Material) -> bpy.types.Object:
    s = size / 2
    obj = build.mesh_object(scene, name, vertices=[(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)])
    obj.data.materials.append(material)
    return obj


def corner(floor: dict[str, Any] | None = None) -> bpy.types.Scene:
    """Floor and back wall of diffuse colours; `floor` sets inputs of the floor's material."""
    scene = build.new_scene()
    ground = {'Base_Color': (0.6, 0.5, 0.3, 1), 'Roughness': 1.0, 'Specular_IOR_Level': 0.0} | (floor or {})
    square(scene, 'Floor', 12, build.material('Floor', **ground))
    wall = square(scene, 'Wall', 12, build.material('Wall', Base_Color=(0.4, 0.5, 0.7, 1), Specular_IOR_Level=0.0))
    wall.matrix_world = Matrix.LocRotScale((0, 2, 0), Euler((np.pi / 2, 0, 0)), None)
    camera = build.camera(scene)
    camera.location = (0, -6, 2.5)
    camera.rotation_euler = (Vector((0, 0, 0.8)) - camera.location).to_track_quat('-Z', 'Y').to_euler()
    return scene


def box(scene: bpy.types.Scene) -> None:
    """Something that casts a shadow."""
    bpy.ops.mesh.primitive_cube_add(size=0.8, location=(-1.0, 0.3, 0.4), rotation=(0, 0, 0.5))
    bpy.context.object.data.materials.append(build.material('Box', Base_Color=(0.8, 0.3, 0.2, 1), Roughness=1.0))


def ball(scene: bpy.types.Scene, **inputs: Any) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.6, location=(1.0, 0.0, 0.6))
    bpy.context.object.data.shade_smooth()
    bpy.context.object.data.materials.append(build.material('Ball', **inputs))


def hang(
    scene: bpy.types.Scene,
    kind: str,
    location: tuple[float, float, float] = (0.3, -0.5, 2.5),
    rotation: tuple[float, float, float] = (0.3, 0.2, 0.4),
    scale: tuple[float, float, float] = (1, 1, 1),
    seen: bool = False,
    **settings: Any,
) -> bpy.types.Object:
    """A light of 100 W, or what `settings` say."""
    obj = build.light(scene, kind, **{'energy': 100.0, **settings})
    obj.matrix_world = Matrix.LocRotScale(location, Euler(rotation), scale)
    obj.visible_camera = seen
    return obj


def picture(scene: bpy.types.Scene, engine: str, folder: Path, bounces: int, samples: int) -> Reference:
    return in_halves(scene, engine, folder, bounces, SIZE, samples)


def assert_as_cycles(scene: bpy.types.Scene, folder: Path, bounces: int = 1, samples: int = SAMPLES) -> None:
    ours = picture(scene, 'COTORRA', folder, bounces, samples)
    warnings = [text for layer in stats.last(scene.name) for text in layer.warnings]
    theirs = picture(scene, 'CYCLES', folder, bounces, samples)
    same = same_image(ours, theirs, LIMIT, TILE)
    told = (
        f'in total {same.total:+.4f} ± {same.total_noise:.4f}, worst tile {same.worst}, noise {same.noise:.4f}, '
        f'of pixels {ours.variance.mean() ** 0.5:.4g} and {theirs.variance.mean() ** 0.5:.4g}'
    )
    print(told)
    assert not warnings, warnings
    assert theirs.image.mean() > 1e-3, 'the picture is black'
    assert same.bad == 0, told
    assert same.beyond_noise == 0, f'{told}\n{np.round(100 * same.tiles).astype(int)} %'
    assert abs(same.total) <= TOTAL + 3 * same.total_noise, told
