# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials whose inputs are images, linked as a user links them: UV Map, Image Texture, Separate Color, Normal Map.

The pictures come from patterns.py; they are packed, so that a demo that is saved keeps them.
"""

from __future__ import annotations

import bpy
import numpy as np

from .. import compat
from . import patterns


def add_material(name: str, surface: patterns.Surface) -> bpy.types.Material:
    """A Principled material that reads the surface's maps from the active UV map's unit square, which repeats."""
    material = bpy.data.materials.new(name)
    shader = compat.principled(material)
    shader.inputs['IOR'].default_value = 1.5  # the default is 1.45 in Blender 4.5
    tree = material.node_tree
    place = tree.nodes.new('ShaderNodeUVMap')
    place.uv_map = 'UVMap'
    place.location = (-1000, 0)

    color = add_texture(tree, place, color_image(f'{name} albedo', surface), (-700, 300))
    tree.links.new(color.outputs['Color'], shader.inputs['Base Color'])
    if surface.alpha is not None:
        tree.links.new(color.outputs['Alpha'], shader.inputs['Alpha'])

    # Roughness in green and metallic in blue, as glTF packs them.
    packed = add_texture(tree, place, finish_image(f'{name} roughness metallic', surface), (-700, 0))
    parts = tree.nodes.new('ShaderNodeSeparateColor')
    parts.location = (-350, 0)
    tree.links.new(packed.outputs['Color'], parts.inputs['Color'])
    tree.links.new(parts.outputs['Green'], shader.inputs['Roughness'])
    if surface.metallic is not None:
        tree.links.new(parts.outputs['Blue'], shader.inputs['Metallic'])

    if surface.height is not None:
        bent = add_texture(tree, place, normal_image(f'{name} normal', surface), (-700, -300))
        normal = tree.nodes.new('ShaderNodeNormalMap')
        normal.uv_map = 'UVMap'
        normal.location = (-350, -300)
        tree.links.new(bent.outputs['Color'], normal.inputs['Color'])
        tree.links.new(normal.outputs['Normal'], shader.inputs['Normal'])
    return material


def add_texture(
    tree: bpy.types.NodeTree, place: bpy.types.Node, image: bpy.types.Image, location: tuple[float, float]
) -> bpy.types.Node:
    texture = tree.nodes.new('ShaderNodeTexImage')
    texture.image = image
    texture.location = location
    tree.links.new(place.outputs['UV'], texture.inputs['Vector'])
    return texture


def color_image(name: str, surface: patterns.Surface) -> bpy.types.Image:
    """8 bit, encoded as sRGB."""
    linear = np.clip(surface.albedo, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return new_image(name, encoded, surface.alpha, 'sRGB')


def finish_image(name: str, surface: patterns.Surface) -> bpy.types.Image:
    """8 bit, roughness in green and metallic in blue."""
    metallic = surface.metallic if surface.metallic is not None else np.zeros_like(surface.roughness)
    return new_image(name, np.stack((np.ones_like(metallic), surface.roughness, metallic), axis=-1), None, 'Non-Color')


def normal_image(name: str, surface: patterns.Surface) -> bpy.types.Image:
    """8 bit, -1 to 1 as 0 to 255."""
    return new_image(name, 0.5 + 0.5 * surface.normals(), None, 'Non-Color')


def new_image(name: str, color: patterns.F64, alpha: patterns.F64 | None, color_space: str) -> bpy.types.Image:
    size = patterns.SIZE
    image = bpy.data.images.new(name, size, size, alpha=alpha is not None)
    image.colorspace_settings.name = color_space
    pixels = np.ones((size, size, 4), np.float32)
    pixels[..., :3] = color
    if alpha is not None:
        pixels[..., 3] = alpha
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image
