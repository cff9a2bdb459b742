# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo whitted_classic: a glass and a mirror sphere over a checker floor, as in Whitted's paper (1980).

Hard lamps, smooth mirrors and clear glass alone: there is nothing in it that a path tracer would do by chance.
"""

from __future__ import annotations

import bmesh
import bpy

from .. import compat
from . import parts

TILES = 24  # a side of the floor
TILE = 0.5  # metres
RED, YELLOW = (0.55, 0.03, 0.02), (0.75, 0.55, 0.05)


def build(scene: bpy.types.Scene) -> None:
    """The glass sphere hangs before the mirror, under a sun and a dim point light."""
    scene.cotorra.integrator = 'WHITTED'
    scene.cotorra.samples = 16
    scene.cotorra.ambient_strength = 0.12
    scene.cotorra.ambient_color = (0.7, 0.85, 1.0)
    parts.add_world(scene, (0.24, 0.44, 0.78), 0.8)
    # The sky is seen, in mirrors too, but lights nothing: that is the ambient term's.
    scene.world.cycles_visibility.diffuse = False
    add_floor(scene)

    mirror = parts.add_material('Mirror', (0.9, 0.9, 0.9), metallic=1.0, roughness=0.0)
    add_sphere(scene, 'Mirror sphere', 0.85, mirror).location = (0.85, 1.15, 0.95)
    glass = parts.add_material('Glass', (1.0, 1.0, 1.0), roughness=0.0)
    compat.principled(glass).inputs['Transmission Weight'].default_value = 1.0
    add_sphere(scene, 'Glass sphere', 0.7, glass).location = (-0.45, -0.9, 1.25)

    parts.add_sun(scene, 'Sun', (1.0, 0.97, 0.9), 2.6, angle=0.0, direction=(0.45, 0.55, -0.9))
    parts.add_point(scene, 'Point', (0.7, 0.8, 1.0), 120.0, radius=0.0, location=(-3.0, -2.5, 4.0))
    parts.add_camera(scene, location=(0.0, -6.2, 2.1), target=(0.05, 0.0, 1.0), lens=42.0)


def add_floor(scene: bpy.types.Scene) -> None:
    """A chessboard of faces: two materials that reflect nothing, so that lamps are all that lights them."""
    shape = bmesh.new()
    bmesh.ops.create_grid(shape, x_segments=TILES, y_segments=TILES, size=0.5 * TILES * TILE)
    for face in shape.faces:
        middle = face.calc_center_median() / TILE
        face.material_index = int(middle.x // 1 + middle.y // 1) % 2
    floor = parts.add_mesh(scene, 'Floor', shape, add_matt('Red', RED))
    floor.data.materials.append(add_matt('Yellow', YELLOW))


def add_matt(name: str, color: parts.Color) -> bpy.types.Material:
    material = parts.add_material(name, color, roughness=1.0)
    compat.principled(material).inputs['Specular IOR Level'].default_value = 0.0
    return material


def add_sphere(scene: bpy.types.Scene, name: str, radius: float, material: bpy.types.Material) -> bpy.types.Object:
    """Finer than the other demos' spheres: glass shows every facet twice."""
    shape = bmesh.new()
    bmesh.ops.create_uvsphere(shape, u_segments=192, v_segments=96, radius=radius)
    item = parts.add_mesh(scene, name, shape, material)
    item.data.shade_smooth()
    return item
