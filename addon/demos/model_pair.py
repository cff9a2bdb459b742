# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo model_pair: a copper vase and a tiled block, textured, each with a reflection model of its own.

It answers the texture scene of the OpenGL study. What its parts are is told in parts.py, shapes.py and patterns.py.
"""

from __future__ import annotations

import bpy

from . import parts, patterns, shapes, textures

# Radius and height of the vase, from the middle of its foot up the outside, over the lip and down inside.
VASE = (
    (0.001, 0.0), (0.36, 0.0), (0.38, 0.03), (0.42, 0.12), (0.56, 0.32), (0.66, 0.55), (0.69, 0.78), (0.65, 1.00),
    (0.53, 1.20), (0.38, 1.36), (0.29, 1.50), (0.27, 1.62), (0.31, 1.74), (0.38, 1.82), (0.40, 1.84), (0.385, 1.85),
    (0.36, 1.83), (0.29, 1.74), (0.25, 1.62), (0.27, 1.50), (0.36, 1.34), (0.50, 1.16),
)  # fmt: skip


def build(scene: bpy.types.Scene) -> None:
    """On the left Cook-Torrance, on the right Blinn-Phong, under a sun, a bulb and a spot."""
    scene.cotorra.integrator = 'PATH'
    parts.add_world(scene, (0.70, 0.80, 1.0), 0.35)

    floor = textures.add_material('Floor', patterns.boards(5, (0.16, 0.085, 0.045), (0.42, 0.26, 0.14), 3, 0.42))
    parts.add_shown(scene, 'Floor', shapes.boxes('Floor', [((0, 0, -0.1), (14, 12, 0.2))]), floor)
    wall = textures.add_material('Wall', patterns.plaster((0.62, 0.59, 0.54), 21))
    wall.cotorra.model = 'OREN_NAYAR'
    parts.add_shown(scene, 'Wall', shapes.boxes('Wall', [((0, 3.1, 3.0), (14, 0.2, 6.4))]), wall)

    copper = textures.add_material('Copper', patterns.copper(31))
    copper.cotorra.model = 'COOK_TORRANCE'
    parts.add_shown(scene, 'Vase', shapes.turned('Vase', VASE), copper).location = (-1.15, 0.0, 0.0)
    tiles = textures.add_material('Tiles', patterns.tiles(5, (0.05, 0.16, 0.42), (0.50, 0.47, 0.42), 41))
    tiles.cotorra.model = 'BLINN_PHONG'
    tiles.cotorra.normalized = True
    tiles.cotorra.shininess = 120.0
    tiles.cotorra.ks = 0.1
    block = shapes.boxes('Block', [((0, 0, 0.7), (1.4, 1.4, 1.4))], bevel=0.08)
    shown = parts.add_shown(scene, 'Block', block, tiles)
    shown.location, shown.rotation_euler = (1.15, 0.1, 0.0), (0.0, 0.0, 0.55)

    parts.add_sun(scene, 'Sun', (1.0, 0.90, 0.75), 3.0, angle=3.0, direction=(0.62, 0.55, -0.60))
    parts.add_point(scene, 'Bulb', (0.60, 0.75, 1.0), 260.0, radius=0.15, location=(3.6, -2.4, 2.6))
    parts.add_spot(
        scene,
        'Spot',
        (1.0, 0.86, 0.68),
        900.0,
        radius=0.12,
        location=(-2.6, -4.2, 4.6),
        target=(-0.6, 0.2, 0.8),
        angle=46,
    )
    parts.add_camera(scene, location=(0.0, -7.4, 2.5), target=(0.0, 0.1, 0.82), lens=52.0)
