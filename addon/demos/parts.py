# SPDX-License-Identifier: GPL-3.0-or-later
"""What demo scenes are put together from: meshes, materials, lamps, a camera; each call adds one thing to a scene.

Images are made in patterns.py; which scene gets what is the scenes' own business.
"""

from __future__ import annotations

import math

import bmesh
import bpy
from mathutils import Matrix, Vector

from .. import compat

Color = tuple[float, float, float]


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
    return add_shown(scene, name, new_mesh(name, shape), material)


def add_shown(
    scene: bpy.types.Scene, name: str, mesh: bpy.types.Mesh, material: bpy.types.Material
) -> bpy.types.Object:
    """An object of a mesh that nothing else shows."""
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
