# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo three_lights: many triangles under a sun, a point and a spot light.

Speed is measured on it; what its parts are is told in parts.py.
"""

from __future__ import annotations

import random

import bmesh
import bpy

from . import parts


def build(scene: bpy.types.Scene) -> None:
    """Thirty monkeys, each subdivided twice by its modifier: 472 320 triangles, and two more for the ground."""
    parts.add_world(scene, (0.45, 0.55, 0.7), 0.3)
    ground = bmesh.new()
    bmesh.ops.create_grid(ground, x_segments=1, y_segments=1, size=60.0)
    parts.add_mesh(scene, 'Ground', ground, parts.add_material('Ground', (0.32, 0.30, 0.28), roughness=0.6))

    monkey = bmesh.new()
    bmesh.ops.create_monkey(monkey)
    mesh = parts.new_mesh('Monkey', monkey)
    mesh.shade_smooth()
    finishes = [
        parts.add_material('Gold', (1.0, 0.71, 0.29), metallic=1.0, roughness=0.28),
        parts.add_material('Red plastic', (0.62, 0.04, 0.03), roughness=0.3),
        parts.add_material('Steel', (0.56, 0.57, 0.58), metallic=1.0, roughness=0.4),
        parts.add_material('Teal plastic', (0.02, 0.30, 0.32), roughness=0.22),
        parts.add_material('Copper', (0.95, 0.64, 0.54), metallic=1.0, roughness=0.2),
        parts.add_material('Clay', (0.72, 0.62, 0.50), roughness=0.8),
        parts.add_material('Blue plastic', (0.05, 0.10, 0.50), roughness=0.45),
    ]
    chance = random.Random(7)
    for number in range(30):
        row, column = divmod(number, 6)
        item = parts.add_user(scene, f'Monkey {number + 1}', mesh, finishes[(number * 3 + row) % len(finishes)])
        item.modifiers.new('Subdivision', 'SUBSURF').render_levels = 2
        item.location = ((column - 2.5 + 0.5 * (row % 2) - 0.25) * 2.9, row * 2.9, 0.98)
        item.rotation_euler = (0.0, 0.0, chance.uniform(-0.55, 0.55))

    parts.add_sun(scene, 'Sun', (1.0, 0.86, 0.68), 2.6, angle=2.0, direction=(0.75, 0.55, -0.62))
    parts.add_point(scene, 'Point', (0.45, 0.65, 1.0), 900.0, radius=0.3, location=(7.5, 2.0, 4.5))
    parts.add_spot(
        scene,
        'Spot',
        (1.0, 0.93, 0.85),
        3000.0,
        radius=0.25,
        location=(-5.0, -6.0, 10.0),
        target=(-1.0, 3.5, 0.5),
        angle=42,
    )
    parts.add_camera(scene, location=(-0.6, -14.0, 8.2), target=(-0.6, 4.0, 0.1), lens=31.5)
