# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials whose inputs read images or coordinates, what they are exported as, and what they show.

Other shader trees are made in the tests, with what build.py has.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from cotorra.export.buffers import SceneBuffers
from cotorra.log import Log

import shaders
import texture_scenes
from flat_scenes import shining

from . import build
from .depsgraphs import exported

# RGBA of an image of a row; seen from above, each texel is a column of as many pixels.
TEXELS = np.array(
    [[0.1, 0.9, 0.3, 0.0], [0.2, 0.8, 0.6, 0.25], [0.5, 0.5, 0.5, 0.5], [0.8, 0.2, 0.1, 0.75], [1, 0, 0.7, 1]],
    np.float32,
)


def picture(name: str = 'Picture', alpha: bool = True) -> bpy.types.Image:
    return bpy.data.images.new(name, 2, 2, alpha=alpha)


def textured(target: str = 'Base Color', output: str = 'Color') -> tuple[bpy.types.Material, bpy.types.Node]:
    """A material whose input `target` reads an image."""
    material = build.material()
    node = build.node(material.node_tree, 'TexImage')
    node.image = picture()
    build.connect(material.node_tree, node.outputs[output], build.principled(material).inputs[target])
    return material, node


def between(
    material: bpy.types.Material, node: bpy.types.Node, target: str, output: bpy.types.NodeSocket | None = None
) -> bpy.types.Node:
    """Link a node's output, by default its first, to the input `target` of the Principled BSDF."""
    tree = material.node_tree
    build.connect(tree, output or node.outputs[0], build.principled(material).inputs[target])
    return node


def shining_texels() -> tuple[bpy.types.Material, bpy.types.Node, bpy.types.NodeSocket]:
    """A material that emits TEXELS, the node of its image, and what is linked to show something else."""
    material = shining('Material')
    tree = material.node_tree
    image = bpy.data.images.new('Texels', len(TEXELS), 1, alpha=True, float_buffer=True, is_data=True)
    image.alpha_mode = 'CHANNEL_PACKED'
    image.pixels.foreach_set(TEXELS.ravel())
    node = build.node(tree, 'TexImage')
    node.image, node.interpolation = image, 'Closest'
    color = tree.nodes['Shine'].inputs['Color']
    build.connect(tree, node.outputs['Color'], color)
    return material, node, color


def show(*materials: bpy.types.Material, mesh: bpy.types.Mesh | None = None) -> tuple[SceneBuffers, list[str]]:
    scene = bpy.context.scene
    data = mesh or build.grid(2)
    for material in materials:
        data.materials.append(material)
    build.link(scene, 'Grid', data)
    log = Log()
    return exported(scene, log), log.texts('WARNING')


def seen(buffers: SceneBuffers, size: int = len(TEXELS)) -> np.ndarray:
    """The grid from above, (size, size, 3), row 0 the lowest; places: `texture_scenes.centres(size=size)`."""
    return texture_scenes.render(buffers, texture_scenes.camera(size=size))['combined'][..., :3]


@dataclass(frozen=True)
class Lookup:
    """How an op reads an image."""

    op: str
    image: int
    interpolation: int
    extension: int
    projection: int
    divides_by_alpha: bool


def lookups(buffers: SceneBuffers, material: int = 1) -> list[Lookup]:
    """The images that a material's shader reads, as they stand in it."""
    shader = buffers.shaders[buffers.materials.shader[material]]
    found = []
    for name, mode, args in shaders.calls(shader):
        if name in ('image_v', 'image_f'):
            image = int(args[1][0])
            found.append(Lookup(name, image, mode & 3, mode >> 2 & 3, mode >> 4 & 3, bool(mode & 64)))
    return found
