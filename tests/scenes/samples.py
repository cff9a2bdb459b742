# SPDX-License-Identifier: GPL-3.0-or-later
"""A field of material samples, each a sphere over a square, seen so that a pixel is one ray through its centre.

Lamps cast no shadows here: what a model and a lamp give at a point can then be written down. Nothing is rendered.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bmesh
import bpy
import numpy as np
from cotorra import compat
from mathutils import Vector

from . import build

STEP, RADIUS = 2.0, 0.72  # metres between samples, of their spheres
# Cycles' least filter width; a ray is off its pixel's centre by no more than that.
FILTER_WIDTH = 0.01


def field(materials: Sequence[bpy.types.Material], columns: int, size: tuple[int, int]) -> bpy.types.Scene:
    """The samples row by row from the back left; material k has the pass index k + 1. Empties the file before."""
    scene = bpy.context.scene
    rows = -(-len(materials) // columns)
    sphere = smooth_sphere()
    square = build.mesh('Square', [(STEP / 2 * x, STEP / 2 * y, 0.0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    for mesh in (sphere, square):
        mesh.materials.append(None)
    for index, material in enumerate(materials):
        material.pass_index = index + 1
        row, column = divmod(index, columns)
        place = ((column - (columns - 1) / 2) * STEP, ((rows - 1) / 2 - row) * STEP)
        for mesh, height in ((sphere, 1.02 * RADIUS), (square, 0.0)):
            item = build.link(scene, f'{mesh.name} {index}', mesh)
            item.location = (*place, height)
            item.material_slots[0].link = 'OBJECT'
            item.material_slots[0].material = material
    camera = build.camera(scene, lens=96.0)
    camera.location = (0.0, -2.1 * STEP * columns, 2.0 * STEP * columns)
    camera.rotation_euler = (-Vector(camera.location)).to_track_quat('-Z', 'Y').to_euler()
    scene.render.engine = 'COTORRA'
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.cotorra.samples = 1
    scene.cotorra.integrator = 'DIRECT'
    observe(scene)
    return scene


def observe(scene: bpy.types.Scene) -> None:
    """Rays through the pixels' centres, and the passes that `first_hits` reads."""
    scene.cycles.filter_width = FILTER_WIDTH
    for name in ('position', 'normal', 'material_index'):
        setattr(scene.view_layers[0], f'use_pass_{name}', True)


def smooth_sphere() -> bpy.types.Mesh:
    """Fine enough that its normals and its triangles differ by half a degree."""
    shape = bmesh.new()
    bmesh.ops.create_icosphere(shape, subdivisions=6, radius=RADIUS)
    mesh = bpy.data.meshes.new('Sphere')
    shape.to_mesh(mesh)
    shape.free()
    mesh.shade_smooth()
    return mesh


def hard_light(scene: bpy.types.Scene, kind: str, location: Sequence[float], **settings: Any) -> bpy.types.Object:
    """A lamp without size and shadows that shines on the field's middle; keywords set light.cotorra."""
    lamp = build.light(scene, kind)
    light = lamp.data
    light.color = (1.0, 0.8, 0.6)
    light.energy = 3.0 if kind == 'SUN' else 2000.0
    harden(light)
    for name, value in settings.items():
        setattr(light.cotorra, name, value)
    lamp.location = location
    lamp.rotation_euler = (-Vector(location)).to_track_quat('-Z', 'Y').to_euler()
    return lamp


def harden(light: bpy.types.Light) -> None:
    """Neither size nor shadows."""
    light.use_shadow = False
    if light.type == 'SUN':
        light.angle = 0.0
    else:
        light.shadow_soft_size = 0.0


def first_hits(passes: dict[str, dict[str, np.ndarray]], layer: str = 'ViewLayer') -> dict[str, np.ndarray]:
    """position, normal (H, W, 3), color (H, W, 3) in double precision, and material (H, W) with -1 for none."""

    def vectors(name: str, channels: str) -> np.ndarray:
        return np.stack([passes[f'{layer}.{name}'][channel] for channel in channels], axis=-1).astype(np.float64)

    index = passes[f'{layer}.{compat.pass_name("Material Index")}']['X']
    return {
        'position': vectors('Position', 'XYZ'),
        'normal': vectors('Normal', 'XYZ'),
        'color': vectors('Combined', 'RGB'),
        'material': index.astype(int) - 1,
    }
