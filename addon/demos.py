# SPDX-License-Identifier: GPL-3.0-or-later
"""Demo scenes that code builds, alike on every machine: `build` empties the file and leaves one scene ready to render.

They use nothing but what the engine renders; no file is read.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import bmesh
import bpy
from mathutils import Euler, Matrix, Vector

from . import choices, compat

Color = tuple[float, float, float]


def build(name: str) -> bpy.types.Scene:
    """Replace everything in memory by the demo of that name (see choices.DEMOS)."""
    builders: dict[str, Callable[[bpy.types.Scene], None]] = {
        'three_lights': three_lights,
        'box_room': box_room,
        'material_grid': material_grid,
    }
    builder = builders[name]
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.name = name
    scene.render.engine = choices.ENGINE
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    scene.render.resolution_percentage = 100
    scene.view_settings.look = 'AgX - Medium High Contrast'
    builder(scene)
    return scene


def three_lights(scene: bpy.types.Scene) -> None:
    """Thirty monkeys, each subdivided twice by its modifier: 472 320 triangles, and two more for the ground."""
    add_world(scene, (0.45, 0.55, 0.7), 0.3)
    ground = bmesh.new()
    bmesh.ops.create_grid(ground, x_segments=1, y_segments=1, size=60.0)
    add_mesh(scene, 'Ground', ground, add_material('Ground', (0.32, 0.30, 0.28), roughness=0.6))

    monkey = bmesh.new()
    bmesh.ops.create_monkey(monkey)
    mesh = new_mesh('Monkey', monkey)
    mesh.shade_smooth()
    finishes = [
        add_material('Gold', (1.0, 0.71, 0.29), metallic=1.0, roughness=0.28),
        add_material('Red plastic', (0.62, 0.04, 0.03), roughness=0.3),
        add_material('Steel', (0.56, 0.57, 0.58), metallic=1.0, roughness=0.4),
        add_material('Teal plastic', (0.02, 0.30, 0.32), roughness=0.22),
        add_material('Copper', (0.95, 0.64, 0.54), metallic=1.0, roughness=0.2),
        add_material('Clay', (0.72, 0.62, 0.50), roughness=0.8),
        add_material('Blue plastic', (0.05, 0.10, 0.50), roughness=0.45),
    ]
    chance = random.Random(7)
    for number in range(30):
        row, column = divmod(number, 6)
        item = add_user(scene, f'Monkey {number + 1}', mesh, finishes[(number * 3 + row) % len(finishes)])
        item.modifiers.new('Subdivision', 'SUBSURF').render_levels = 2
        item.location = ((column - 2.5 + 0.5 * (row % 2) - 0.25) * 2.9, row * 2.9, 0.98)
        item.rotation_euler = (0.0, 0.0, chance.uniform(-0.55, 0.55))

    add_sun(scene, 'Sun', (1.0, 0.86, 0.68), 2.6, angle=2.0, direction=(0.75, 0.55, -0.62))
    add_point(scene, 'Point', (0.45, 0.65, 1.0), 900.0, radius=0.3, location=(7.5, 2.0, 4.5))
    add_spot(
        scene,
        'Spot',
        (1.0, 0.93, 0.85),
        3000.0,
        radius=0.25,
        location=(-5.0, -6.0, 10.0),
        target=(-1.0, 3.5, 0.5),
        angle=42,
    )
    add_camera(scene, location=(-0.6, -14.0, 8.2), target=(-0.6, 4.0, 0.1), lens=31.5)


def box_room(scene: bpy.types.Scene) -> None:
    """A room with a window: the sun falls through it, a spot lights the cube, a bulb hangs over the sphere."""
    scene.cotorra.integrator = 'PATH'
    add_world(scene, (0.6, 0.75, 1.0), 0.8)
    plaster = add_material('Plaster', (0.74, 0.71, 0.66), roughness=0.9)
    wide, high, thick = 7.0, 3.4, 0.2
    front, back = -6.5, 3.0
    deep, middle = back - front, (back + front) / 2

    # Floor, ceiling, back and right wall; the front is open to the camera.
    oak = add_material('Oak', (0.40, 0.26, 0.15), roughness=0.35)
    add_box(scene, 'Floor', (0, middle, -thick / 2), (wide, deep, thick), oak)
    add_box(scene, 'Ceiling', (0, middle, high + thick / 2), (wide + 2 * thick, deep, thick), plaster)
    add_box(scene, 'Back wall', (0, back + thick / 2, high / 2), (wide + 2 * thick, thick, high + 2 * thick), plaster)
    terracotta = add_material('Terracotta', (0.55, 0.17, 0.08), roughness=0.85)
    add_box(scene, 'Right wall', ((wide + thick) / 2, middle, high / 2), (thick, deep, high), terracotta)

    # The left wall leaves a window open between sill and lintel, parted by one mullion.
    blue = add_material('Blue wall', (0.10, 0.21, 0.34), roughness=0.85)
    x = -(wide + thick) / 2
    sill, lintel, near, far = 0.9, 2.7, -1.2, 1.6
    opening = (sill + lintel) / 2
    add_box(scene, 'Wall below window', (x, middle, sill / 2), (thick, deep, sill), blue)
    add_box(scene, 'Wall above window', (x, middle, (lintel + high) / 2), (thick, deep, high - lintel), blue)
    add_box(scene, 'Wall before window', (x, (front + near) / 2, opening), (thick, near - front, lintel - sill), blue)
    add_box(scene, 'Wall behind window', (x, (far + back) / 2, opening), (thick, back - far, lintel - sill), blue)
    add_box(scene, 'Mullion', (x, (near + far) / 2, opening), (0.08, 0.08, lintel - sill), plaster)

    # Three solids: a metal cone, a plastic cube, a metal sphere.
    cone = bmesh.new()
    bmesh.ops.create_cone(cone, cap_ends=True, segments=96, radius1=0.75, radius2=0.0, depth=1.7)
    item = add_mesh(scene, 'Cone', cone, add_material('Copper', (0.95, 0.64, 0.54), metallic=1.0, roughness=0.3))
    item.location = (-1.75, 0.75, 0.85)
    smooth_below(item.data, 0.6)
    cube = add_box(
        scene, 'Cube', (0, 0, 0), (1.15, 1.15, 1.15), add_material('Green plastic', (0.03, 0.30, 0.10), roughness=0.25)
    )
    cube.location, cube.rotation_euler = (0.15, -0.35, 0.575), (0.0, 0.0, 0.55)
    gold = add_material('Gold', (1.0, 0.71, 0.29), metallic=1.0, roughness=0.32)
    sphere = add_user(scene, 'Sphere', sphere_mesh(0.8), gold)
    sphere.location = (1.95, 0.55, 0.8)

    add_sun(scene, 'Sun', (1.0, 0.85, 0.65), 8.0, angle=0.53, direction=(0.80, -0.42, -0.52))
    add_spot(
        scene,
        'Spot',
        (1.0, 0.95, 0.88),
        420.0,
        radius=0.08,
        location=(0.8, -2.6, 3.25),
        target=(0.3, 0.1, 0.5),
        angle=58,
    )
    add_point(scene, 'Bulb', (1.0, 0.80, 0.58), 130.0, radius=0.12, location=(2.0, 0.4, 2.75))
    add_camera(scene, location=(0.35, -7.2, 1.75), target=(0.05, 0.3, 1.2), lens=31.0)


def material_grid(scene: bpy.types.Scene) -> None:
    """Nine spheres by roughness from left to right, five by metallic from bottom to top."""
    add_world(scene, (0.8, 0.88, 1.0), 0.25)
    columns, rows, step, radius = 9, 5, 1.12, 0.5
    wide, high = columns * step, rows * step
    wall = add_material('Wall', (0.06, 0.07, 0.09), roughness=0.7)
    backdrop = bmesh.new()
    bmesh.ops.create_grid(backdrop, x_segments=1, y_segments=1, size=40.0)
    add_mesh(scene, 'Backdrop', backdrop, wall).matrix_world = (
        Matrix.Translation((0.0, 5.0, 0.0)) @ Euler((math.pi / 2, 0.0, 0.0)).to_matrix().to_4x4()
    )
    mesh = sphere_mesh(radius)
    for row in range(rows):
        for column in range(columns):
            metallic = row / (rows - 1)
            roughness = 0.05 + 0.95 * column / (columns - 1)
            material = add_material(
                f'Roughness {roughness:.2f}, metallic {metallic:.2f}',
                (0.80, 0.20, 0.06),
                metallic=metallic,
                roughness=roughness,
            )
            sphere = add_user(scene, f'Sphere {row + 1}-{column + 1}', mesh, material)
            sphere.location = ((column + 0.5) * step - wide / 2, 0.0, (row + 0.5) * step - high / 2)

    add_sun(scene, 'Sun', (1.0, 0.95, 0.88), 1.3, angle=4.0, direction=(0.45, 0.75, -0.55))
    add_point(scene, 'Point', (0.55, 0.75, 1.0), 900.0, radius=0.6, location=(6.0, -6.0, 3.0))
    add_spot(
        scene,
        'Spot',
        (1.0, 0.80, 0.60),
        1800.0,
        radius=0.5,
        location=(-7.0, -7.0, -2.5),
        target=(0.0, 0.0, 0.0),
        angle=60,
    )
    add_camera(scene, location=(0.0, -24.0, 0.0), target=(0.0, 0.0, 0.0), lens=80.0)


def add_material(name: str, color: Color, metallic: float = 0.0, roughness: float = 0.5) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    shader = compat.principled(material)
    shader.inputs['Base Color'].default_value = (*color, 1.0)
    shader.inputs['Metallic'].default_value = metallic
    shader.inputs['Roughness'].default_value = roughness
    shader.inputs['IOR'].default_value = 1.5  # the default is 1.45 in Blender 4.5
    return material


def add_world(scene: bpy.types.Scene, color: Color, strength: float) -> None:
    scene.world = bpy.data.worlds.new('World')
    background = compat.background(scene.world)
    background.inputs['Color'].default_value = (*color, 1.0)
    background.inputs['Strength'].default_value = strength


def new_mesh(name: str, shape: bmesh.types.BMesh) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    shape.to_mesh(mesh)
    shape.free()
    return mesh


def add_mesh(
    scene: bpy.types.Scene, name: str, shape: bmesh.types.BMesh, material: bpy.types.Material
) -> bpy.types.Object:
    mesh = new_mesh(name, shape)
    mesh.materials.append(material)
    item = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(item)
    return item


def add_box(
    scene: bpy.types.Scene, name: str, centre: Color, size: Color, material: bpy.types.Material
) -> bpy.types.Object:
    shape = bmesh.new()
    bmesh.ops.create_cube(shape, size=1.0, matrix=Matrix.Diagonal((*size, 1.0)))
    item = add_mesh(scene, name, shape, material)
    item.location = centre
    return item


def add_user(scene: bpy.types.Scene, name: str, mesh: bpy.types.Mesh, material: bpy.types.Material) -> bpy.types.Object:
    """An object of a mesh that others show too, with a material of its own."""
    if not mesh.materials:
        mesh.materials.append(None)
    item = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(item)
    item.material_slots[0].link = 'OBJECT'
    item.material_slots[0].material = material
    return item


def sphere_mesh(radius: float) -> bpy.types.Mesh:
    shape = bmesh.new()
    bmesh.ops.create_uvsphere(shape, u_segments=96, v_segments=48, radius=radius)
    mesh = new_mesh('Sphere', shape)
    mesh.shade_smooth()
    return mesh


def smooth_below(mesh: bpy.types.Mesh, angle: float) -> None:
    """Shade smooth, with sharp edges where faces meet at more than `angle` radians."""
    mesh.shade_smooth()
    mesh.set_sharp_from_angle(angle=angle)


def add_light(
    scene: bpy.types.Scene, name: str, kind: str, color: Color, energy: float
) -> tuple[bpy.types.Object, bpy.types.Light]:
    light = bpy.data.lights.new(name, kind)
    light.color = color
    light.energy = energy
    item = bpy.data.objects.new(name, light)
    scene.collection.objects.link(item)
    return item, light


def add_sun(scene: bpy.types.Scene, name: str, color: Color, energy: float, *, angle: float, direction: Color) -> None:
    """angle: of the sun's disk in degrees; direction: in which its light travels."""
    item, light = add_light(scene, name, 'SUN', color, energy)
    light.angle = math.radians(angle)
    item.rotation_euler = Vector(direction).to_track_quat('-Z', 'Y').to_euler()


def add_point(
    scene: bpy.types.Scene, name: str, color: Color, energy: float, *, radius: float, location: Color
) -> None:
    item, light = add_light(scene, name, 'POINT', color, energy)
    light.shadow_soft_size = radius
    item.location = location


def add_spot(
    scene: bpy.types.Scene,
    name: str,
    color: Color,
    energy: float,
    *,
    radius: float,
    location: Color,
    target: Color,
    angle: float,
) -> None:
    """angle: of the whole cone in degrees."""
    item, light = add_light(scene, name, 'SPOT', color, energy)
    light.shadow_soft_size = radius
    light.spot_size = math.radians(angle)
    light.spot_blend = 0.35
    item.location = location
    item.rotation_euler = (Vector(target) - Vector(location)).to_track_quat('-Z', 'Y').to_euler()


def add_camera(scene: bpy.types.Scene, *, location: Color, target: Color, lens: float) -> None:
    camera = bpy.data.cameras.new('Camera')
    camera.lens = lens
    item = bpy.data.objects.new('Camera', camera)
    item.location = location
    item.rotation_euler = (Vector(target) - Vector(location)).to_track_quat('-Z', 'Y').to_euler()
    scene.collection.objects.link(item)
    scene.camera = item
