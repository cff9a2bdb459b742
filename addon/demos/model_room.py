# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo model_room: furniture in a room, textured, each piece with a reflection model of its own, under three lamps.

It answers the room of textured models in the OpenGL study; all of it is built from boxes, turned shapes and leaves.
"""

from __future__ import annotations

import bmesh
import bpy

from . import parts, patterns, shapes, textures

WIDE, DEEP, HIGH = 5.6, 5.0, 2.8  # of the room inside, metres; the front is open to the camera
# Radius and height: up the outside, over the lip and down inside.
JUG = (
    (0.001, 0.0), (0.060, 0.0), (0.068, 0.01), (0.095, 0.06), (0.110, 0.12), (0.100, 0.19), (0.066, 0.26),
    (0.052, 0.31), (0.062, 0.35), (0.072, 0.36), (0.066, 0.355), (0.046, 0.31), (0.058, 0.26), (0.090, 0.18),
)  # fmt: skip
POT = (
    (0.001, 0.0), (0.15, 0.0), (0.16, 0.01), (0.20, 0.18), (0.23, 0.36), (0.25, 0.38), (0.25, 0.43), (0.24, 0.44),
    (0.215, 0.43), (0.205, 0.38), (0.001, 0.36),
)  # fmt: skip
SHADE = (
    (0.05, 0.24), (0.055, 0.245), (0.09, 0.23), (0.20, 0.13), (0.30, 0.0), (0.30, -0.01), (0.29, -0.005), (0.19, 0.12),
    (0.085, 0.215), (0.05, 0.23),
)  # fmt: skip


def build(scene: bpy.types.Scene) -> None:
    """Table, chairs, shelf, plant and rug; the sun through the window, a lamp over the table, a spot on the shelf."""
    scene.cotorra.integrator = 'PATH'
    parts.add_world(scene, (0.62, 0.76, 1.0), 0.7)
    add_walls(scene)
    wood = textures.add_material('Walnut', patterns.boards(6, (0.10, 0.045, 0.02), (0.30, 0.16, 0.075), 11, 0.34))
    choose(wood, 'BLINN_PHONG', normalized=True, shininess=90.0, ks=0.08)
    add_table(scene, wood)
    add_chairs(scene)
    add_shelf(scene)
    add_plant(scene)
    add_rug(scene)
    add_lamps(scene)
    parts.add_camera(scene, location=(0.45, -4.6, 1.55), target=(-0.05, 0.4, 0.93), lens=29.0)


def choose(material: bpy.types.Material, model: str, **settings: object) -> None:
    """Give a material a reflection model and that model's settings (material.cotorra)."""
    material.cotorra.model = model
    for name, value in settings.items():
        setattr(material.cotorra, name, value)


def add_walls(scene: bpy.types.Scene) -> None:
    """Floor of boards, plastered walls, a window on the left and a curtain beside it."""
    oak = textures.add_material('Oak', patterns.boards(8, (0.24, 0.13, 0.065), (0.52, 0.34, 0.19), 7, 0.38))
    choose(oak, 'COOK_TORRANCE', distribution='GGX', masking='SMITH_CORRELATED', fresnel='SCHLICK')
    parts.add_shown(scene, 'Floor', shapes.boxes('Floor', [((0, 0, -0.1), (WIDE, DEEP, 0.2))]), oak)
    white = parts.add_material('Ceiling', (0.78, 0.77, 0.74), roughness=1.0)
    choose(white, 'LAMBERT')
    parts.add_box(scene, 'Ceiling', (0, 0, HIGH + 0.1), (WIDE + 0.4, DEEP, 0.2), white)

    warm = textures.add_material('Warm plaster', patterns.plaster((0.74, 0.66, 0.54), 17))
    choose(warm, 'OREN_NAYAR', oren_nayar_form='ENERGY_PRESERVING')
    back = [((0, DEEP / 2 + 0.1, HIGH / 2), (WIDE + 0.4, 0.2, HIGH))]
    parts.add_shown(scene, 'Back wall', shapes.boxes('Back wall', back), warm)
    green = textures.add_material('Green plaster', patterns.plaster((0.30, 0.42, 0.34), 19))
    choose(green, 'OREN_NAYAR', oren_nayar_form='QUALITATIVE')
    right = [((WIDE / 2 + 0.1, 0, HIGH / 2), (0.2, DEEP, HIGH))]
    parts.add_shown(scene, 'Right wall', shapes.boxes('Right wall', right), green)

    # The window lies between y = near and far, and between sill and lintel.
    x, sill, lintel, near, far = -WIDE / 2 - 0.1, 0.85, 2.35, -1.1, 1.1
    left = [
        ((x, 0, sill / 2), (0.2, DEEP, sill)),
        ((x, 0, (lintel + HIGH) / 2), (0.2, DEEP, HIGH - lintel)),
        ((x, (near - DEEP / 2) / 2, (sill + lintel) / 2), (0.2, DEEP / 2 + near, lintel - sill)),
        ((x, (far + DEEP / 2) / 2, (sill + lintel) / 2), (0.2, DEEP / 2 - far, lintel - sill)),
        ((x, 0, (sill + lintel) / 2), (0.06, 0.06, lintel - sill)),
    ]
    parts.add_shown(scene, 'Left wall', shapes.boxes('Left wall', left), warm)
    linen = textures.add_material('Linen', patterns.cloth((0.66, 0.20, 0.12), (0.72, 0.30, 0.16), 96, 23))
    choose(linen, 'LAMBERT')
    curtain = parts.add_shown(scene, 'Curtain', shapes.curtain('Curtain', 0.75, 2.1), linen)
    curtain.location, curtain.rotation_euler = (-WIDE / 2 + 0.14, 1.55, 0.35), (0.0, 0.0, 1.5707963)


def add_table(scene: bpy.types.Scene, wood: bpy.types.Material) -> None:
    """A table, and on it a copper jug and a bowl of tin-glazed ware."""
    legs = [((sx * 0.68, sy * 0.36, 0.35), (0.07, 0.07, 0.70)) for sx in (-1, 1) for sy in (-1, 1)]
    apron = [((0, sy * 0.36, 0.65), (1.30, 0.03, 0.10)) for sy in (-1, 1)]
    table = shapes.boxes('Table', [((0, 0, 0.725), (1.60, 0.90, 0.05)), *legs, *apron], bevel=0.008)
    parts.add_shown(scene, 'Table', table, wood).location = (0.1, 0.35, 0.0)
    copper = textures.add_material('Copper', patterns.copper(31))
    choose(copper, 'COOK_TORRANCE', distribution='GGX', masking='SMITH')
    parts.add_shown(scene, 'Jug', shapes.turned('Jug', JUG), copper).location = (-0.22, 0.42, 0.75)
    glaze = parts.add_material('Glaze', (0.10, 0.28, 0.52), roughness=0.2)
    choose(glaze, 'COOK_TORRANCE', distribution='BECKMANN', masking='COOK_TORRANCE', f0_mode='IOR')
    bowl = ((0.001, 0.0), (0.07, 0.0), (0.075, 0.012), (0.14, 0.05), (0.18, 0.11), (0.185, 0.112), (0.175, 0.105))
    inside = ((0.13, 0.055), (0.06, 0.02), (0.001, 0.018))
    parts.add_shown(scene, 'Bowl', shapes.turned('Bowl', bowl + inside), glaze).location = (0.42, 0.25, 0.75)


def add_chairs(scene: bpy.types.Scene) -> None:
    """Two chairs, one mesh, with a cushion each."""
    beech = textures.add_material('Beech', patterns.boards(10, (0.42, 0.25, 0.13), (0.62, 0.42, 0.25), 13, 0.4))
    choose(beech, 'PHONG', normalized=True, shininess=40.0, ks=0.06)
    cotton = textures.add_material('Cotton', patterns.cloth((0.10, 0.18, 0.38), (0.42, 0.44, 0.46), 40, 29))
    choose(cotton, 'OREN_NAYAR', oren_nayar_sigma=0.6)
    front = [((sx * 0.19, -0.19, 0.22), (0.04, 0.04, 0.44)) for sx in (-1, 1)]
    rear = [((sx * 0.19, 0.19, 0.47), (0.04, 0.04, 0.94)) for sx in (-1, 1)]
    slats = [((0, 0.19, z), (0.36, 0.02, 0.06)) for z in (0.62, 0.75, 0.88)]
    chair = shapes.boxes('Chair', [((0, 0, 0.45), (0.44, 0.44, 0.03)), *front, *rear, *slats], bevel=0.006)
    cushion = shapes.boxes('Cushion', [((0, 0, 0.495), (0.40, 0.40, 0.06))], bevel=0.025)
    for number, (x, y, turn) in enumerate(((-0.75, -0.35, 2.7), (1.15, 0.05, -1.9)), 1):
        for mesh, material in ((chair, beech), (cushion, cotton)):
            shown = parts.add_user(scene, f'{mesh.name} {number}', mesh, material)
            shown.location, shown.rotation_euler = (x, y, 0.0), (0.0, 0.0, turn)


def add_shelf(scene: bpy.types.Scene) -> None:
    """A bookshelf at the back wall; books of three colours, a brass sphere on top."""
    pine = textures.add_material('Pine', patterns.boards(4, (0.40, 0.24, 0.10), (0.66, 0.46, 0.24), 15, 0.45))
    sides = [((sx * 0.60, 0, 0.85), (0.03, 0.28, 1.70)) for sx in (-1, 1)]
    levels = [((0, 0, z), (1.20, 0.28, 0.025)) for z in (0.08, 0.48, 0.88, 1.28, 1.688)]
    shelf = shapes.boxes('Shelf', [*sides, *levels, ((0, 0.135, 0.85), (1.20, 0.01, 1.70))])
    place = (1.5, DEEP / 2 - 0.16, 0.0)
    parts.add_shown(scene, 'Shelf', shelf, pine).location = place
    finishes = (
        ('Red books', (0.45, 0.05, 0.04)),
        ('Ochre books', (0.60, 0.38, 0.08)),
        ('Grey books', (0.16, 0.20, 0.24)),
    )
    for kind, (name, color) in enumerate(finishes):
        bound = parts.add_material(name, color, roughness=0.5)
        choose(bound, 'COOK_TORRANCE', distribution='BLINN_PHONG', masking='SCHLICK_GGX', split='MIX')
        books = []
        for level in range(4):
            for index in range(kind, 24, 3):
                # Heights and gaps come from a fixed mixing of the numbers, not from a random generator.
                mixed = (index * 37 + level * 23) % 11
                if (index + 5 * level) % 9 < 7:
                    height = 0.22 + 0.012 * mixed
                    x, z = -0.55 + 0.046 * index, 0.0925 + 0.4 * level + height / 2
                    books.append(((x, 0.02, z), (0.041, 0.18 + 0.004 * mixed, height)))
        parts.add_shown(scene, name, shapes.boxes(name, books, bevel=0.004), bound).location = place
    brass = parts.add_material('Brass', (0.91, 0.78, 0.42), metallic=1.0, roughness=0.22)
    choose(brass, 'COOK_TORRANCE', fresnel='F82')
    sphere = parts.add_user(scene, 'Sphere', parts.sphere_mesh(0.13), brass)
    sphere.location = (place[0] - 0.3, place[1], 1.70 + 0.13)


def add_plant(scene: bpy.types.Scene) -> None:
    """A pot of glazed tiles; the leaves are cut out by the alpha of their image."""
    tiles = textures.add_material('Pot tiles', patterns.tiles(12, (0.50, 0.16, 0.06), (0.55, 0.50, 0.42), 43))
    choose(tiles, 'COOK_TORRANCE', distribution='BLINN_PHONG', masking='SMITH_CORRELATED')
    foot = (-1.75, 1.75, 0.0)
    parts.add_shown(scene, 'Pot', shapes.turned('Pot', POT), tiles).location = foot
    leaf = textures.add_material('Leaf', patterns.leaf(47))
    grown = parts.add_shown(scene, 'Plant', shapes.leaves('Plant', 26, 1.05, seed=5), leaf)
    grown.location = (foot[0], foot[1], 0.35)


def add_rug(scene: bpy.types.Scene) -> None:
    """A woven rug under the table."""
    wool = textures.add_material('Wool', patterns.cloth((0.50, 0.12, 0.08), (0.62, 0.50, 0.34), 24, 53))
    choose(wool, 'OREN_NAYAR', oren_nayar_form='ENERGY_PRESERVING', oren_nayar_sigma=0.8)
    parts.add_shown(scene, 'Rug', shapes.boxes('Rug', [((0.1, 0.25, 0.008), (2.9, 2.1, 0.016))]), wool)


def add_lamps(scene: bpy.types.Scene) -> None:
    """The sun, a bulb in an iron shade over the table, a spot on the shelf."""
    iron = textures.add_material('Iron', patterns.iron(37))
    choose(iron, 'COOK_TORRANCE', distribution='BECKMANN', masking='SMITH_CORRELATED')
    place = (0.1, 0.35, 1.72)
    parts.add_shown(scene, 'Shade', shapes.turned('Shade', SHADE), iron).location = place
    black = parts.add_material('Cable', (0.02, 0.02, 0.02), roughness=0.5)
    cable = bmesh.new()
    bmesh.ops.create_cone(cable, segments=16, radius1=0.006, radius2=0.006, depth=HIGH - place[2] - 0.23)
    parts.add_mesh(scene, 'Cable', cable, black).location = (place[0], place[1], (HIGH + place[2] + 0.23) / 2)
    parts.add_point(scene, 'Bulb', (1.0, 0.80, 0.55), 70.0, radius=0.05, location=(place[0], place[1], place[2] + 0.06))
    parts.add_sun(scene, 'Sun', (1.0, 0.88, 0.70), 9.0, angle=0.53, direction=(0.78, -0.10, -0.60))
    parts.add_spot(
        scene,
        'Spot',
        (1.0, 0.93, 0.82),
        160.0,
        radius=0.05,
        location=(0.9, -0.2, HIGH - 0.1),
        target=(1.5, DEEP / 2 - 0.2, 1.0),
        angle=62,
    )
