# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo box_room: a cone, a cube and a sphere in a room, after the OpenGL study that it answers.

What its parts are is told in parts.py.
"""

from __future__ import annotations

import bmesh
import bpy

from . import parts


def build(scene: bpy.types.Scene) -> None:
    """A room with a window: the sun falls through it, a spot lights the cube, a bulb hangs over the sphere."""
    scene.cotorra.integrator = 'PATH'
    parts.add_world(scene, (0.6, 0.75, 1.0), 0.8)
    plaster = parts.add_material('Plaster', (0.74, 0.71, 0.66), roughness=0.9)
    wide, high, thick = 7.0, 3.4, 0.2
    front, back = -6.5, 3.0
    deep, middle = back - front, (back + front) / 2

    # Floor, ceiling, back and right wall; the front is open to the camera.
    oak = parts.add_material('Oak', (0.40, 0.26, 0.15), roughness=0.35)
    parts.add_box(scene, 'Floor', (0, middle, -thick / 2), (wide, deep, thick), oak)
    parts.add_box(scene, 'Ceiling', (0, middle, high + thick / 2), (wide + 2 * thick, deep, thick), plaster)
    parts.add_box(
        scene, 'Back wall', (0, back + thick / 2, high / 2), (wide + 2 * thick, thick, high + 2 * thick), plaster
    )
    terracotta = parts.add_material('Terracotta', (0.55, 0.17, 0.08), roughness=0.85)
    parts.add_box(scene, 'Right wall', ((wide + thick) / 2, middle, high / 2), (thick, deep, high), terracotta)

    # The left wall leaves a window open between sill and lintel, parted by one mullion.
    blue = parts.add_material('Blue wall', (0.10, 0.21, 0.34), roughness=0.85)
    x = -(wide + thick) / 2
    sill, lintel, near, far = 0.9, 2.7, -1.2, 1.6
    opening = (sill + lintel) / 2
    parts.add_box(scene, 'Wall below window', (x, middle, sill / 2), (thick, deep, sill), blue)
    parts.add_box(scene, 'Wall above window', (x, middle, (lintel + high) / 2), (thick, deep, high - lintel), blue)
    parts.add_box(
        scene, 'Wall before window', (x, (front + near) / 2, opening), (thick, near - front, lintel - sill), blue
    )
    parts.add_box(scene, 'Wall behind window', (x, (far + back) / 2, opening), (thick, back - far, lintel - sill), blue)
    parts.add_box(scene, 'Mullion', (x, (near + far) / 2, opening), (0.08, 0.08, lintel - sill), plaster)

    # Three solids: a metal cone, a plastic cube, a metal sphere.
    cone = bmesh.new()
    bmesh.ops.create_cone(cone, cap_ends=True, segments=96, radius1=0.75, radius2=0.0, depth=1.7)
    item = parts.add_mesh(
        scene, 'Cone', cone, parts.add_material('Copper', (0.95, 0.64, 0.54), metallic=1.0, roughness=0.3)
    )
    item.location = (-1.75, 0.75, 0.85)
    parts.smooth_below(item.data, 0.6)
    cube = parts.add_box(
        scene,
        'Cube',
        (0, 0, 0),
        (1.15, 1.15, 1.15),
        parts.add_material('Green plastic', (0.03, 0.30, 0.10), roughness=0.25),
    )
    cube.location, cube.rotation_euler = (0.15, -0.35, 0.575), (0.0, 0.0, 0.55)
    gold = parts.add_material('Gold', (1.0, 0.71, 0.29), metallic=1.0, roughness=0.32)
    sphere = parts.add_user(scene, 'Sphere', parts.sphere_mesh(0.8), gold)
    sphere.location = (1.95, 0.55, 0.8)

    parts.add_sun(scene, 'Sun', (1.0, 0.85, 0.65), 8.0, angle=0.53, direction=(0.80, -0.42, -0.52))
    parts.add_spot(
        scene,
        'Spot',
        (1.0, 0.95, 0.88),
        420.0,
        radius=0.08,
        location=(0.8, -2.6, 3.25),
        target=(0.3, 0.1, 0.5),
        angle=58,
    )
    parts.add_point(scene, 'Bulb', (1.0, 0.80, 0.58), 130.0, radius=0.12, location=(2.0, 0.4, 2.75))
    parts.add_camera(scene, location=(0.35, -7.2, 1.75), target=(0.05, 0.3, 1.2), lens=31.0)
