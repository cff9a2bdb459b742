# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials whose inputs read images, for the tests of what they are exported as.

Other shader trees are made in the tests, with what build.py has.
"""

from __future__ import annotations

import bpy
import numpy as np
from cotorra.export import buffers as B
from cotorra.export.buffers import SceneBuffers
from cotorra.log import Log

from . import build
from .depsgraphs import exported


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


def show(*materials: bpy.types.Material, mesh: bpy.types.Mesh | None = None) -> tuple[SceneBuffers, list[str]]:
    scene = bpy.context.scene
    data = mesh or build.grid(2)
    for material in materials:
        data.materials.append(material)
    build.link(scene, 'Grid', data)
    log = Log()
    return exported(scene, log), log.texts('WARNING')


def slot(buffers: SceneBuffers, name: str = 'base_color', material: int = 1) -> np.void:
    textures = buffers.materials.textures
    index = textures.inputs[material, B.TEXTURED_INPUTS.index(name)]
    assert index >= 0, f'{name} reads no image'
    return textures.slots[index]


def constants(buffers: SceneBuffers, name: str) -> list[float]:
    textures = buffers.materials.textures
    if textures is not None:
        assert textures.inputs[1, B.TEXTURED_INPUTS.index(name)] == -1
    return getattr(buffers.materials, name)[1].tolist()
