# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo material_grid: what roughness and metallic do.

What its parts are is told in parts.py.
"""

from __future__ import annotations

import math

import bmesh
import bpy
from mathutils import Euler, Matrix

from . import parts


def build(scene: bpy.types.Scene) -> None:
    """Nine spheres by roughness from left to right, five by metallic from bottom to top."""
    parts.add_world(scene, (0.8, 0.88, 1.0), 0.25)
    columns, rows, step, radius = 9, 5, 1.12, 0.5
    wide, high = columns * step, rows * step
    wall = parts.add_material('Wall', (0.06, 0.07, 0.09), roughness=0.7)
    backdrop = bmesh.new()
    bmesh.ops.create_grid(backdrop, x_segments=1, y_segments=1, size=40.0)
    parts.add_mesh(scene, 'Backdrop', backdrop, wall).matrix_world = (
        Matrix.Translation((0.0, 5.0, 0.0)) @ Euler((math.pi / 2, 0.0, 0.0)).to_matrix().to_4x4()
    )
    mesh = parts.sphere_mesh(radius)
    for row in range(rows):
        for column in range(columns):
            metallic = row / (rows - 1)
            roughness = 0.05 + 0.95 * column / (columns - 1)
            material = parts.add_material(
                f'Roughness {roughness:.2f}, metallic {metallic:.2f}',
                (0.80, 0.20, 0.06),
                metallic=metallic,
                roughness=roughness,
            )
            sphere = parts.add_user(scene, f'Sphere {row + 1}-{column + 1}', mesh, material)
            sphere.location = ((column + 0.5) * step - wide / 2, 0.0, (row + 0.5) * step - high / 2)

    parts.add_sun(scene, 'Sun', (1.0, 0.95, 0.88), 1.3, angle=4.0, direction=(0.45, 0.75, -0.55))
    parts.add_point(scene, 'Point', (0.55, 0.75, 1.0), 900.0, radius=0.6, location=(6.0, -6.0, 3.0))
    parts.add_spot(
        scene,
        'Spot',
        (1.0, 0.80, 0.60),
        1800.0,
        radius=0.5,
        location=(-7.0, -7.0, -2.5),
        target=(0.0, 0.0, 0.0),
        angle=60,
    )
    parts.add_camera(scene, location=(0.0, -24.0, 0.0), target=(0.0, 0.0, 0.0), lens=80.0)
