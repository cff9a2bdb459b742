# SPDX-License-Identifier: GPL-3.0-or-later
"""Where Blender 4.5 LTS and 5.2 LTS differ: the one place that asks for the version.

What is the same in both stands elsewhere.
"""

from __future__ import annotations

import bpy
import numpy as np

# Blender 5.0 renamed the passes: the name in 5.x, and what 4.5 calls the same pass.
PASS_NAMES_4 = {
    'Object Index': 'IndexOB',
    'Material Index': 'IndexMA',
    'Diffuse Color': 'DiffCol',
    'Emission': 'Emit',
    'Environment': 'Env',
    'Ambient Occlusion': 'AO',
}


def pass_name(name: str) -> str:
    """The name in this Blender of a render pass that 5.x calls `name`."""
    return name if bpy.app.version >= (5, 0, 0) else PASS_NAMES_4.get(name, name)


def set_image_format(image_settings: bpy.types.ImageFormatSettings, file_format: str) -> None:
    """Set an image format; since 5.0 the kind of medium decides which formats can be chosen."""
    if hasattr(image_settings, 'media_type'):
        multilayer = file_format == 'OPEN_EXR_MULTILAYER'
        image_settings.media_type = 'MULTI_LAYER_IMAGE' if multilayer else 'IMAGE'
    image_settings.file_format = file_format


def node_tree(owner: bpy.types.ID) -> bpy.types.NodeTree | None:
    """The node tree of a material, world or light, if it is in use: 5.0 made that always so."""
    if bpy.app.version >= (5, 0, 0):
        return owner.node_tree
    return owner.node_tree if owner.use_nodes else None


def compositing_tree(scene: bpy.types.Scene) -> bpy.types.NodeTree | None:
    """The compositor's nodes, if they are in use."""
    if bpy.app.version >= (5, 0, 0):
        return scene.compositing_node_group
    return scene.node_tree if scene.use_nodes else None


def principled(material: bpy.types.Material) -> bpy.types.ShaderNode:
    """The Principled BSDF of a new material; 4.5 makes its nodes on demand."""
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    return next(node for node in material.node_tree.nodes if node.type == 'BSDF_PRINCIPLED')


def background(world: bpy.types.World) -> bpy.types.ShaderNode:
    """The Background node of a new world; 4.5 makes its nodes on demand."""
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    return next(node for node in world.node_tree.nodes if node.type == 'BACKGROUND')


def inlined(owner: bpy.types.ID) -> object | None:
    """The node tree of a material, world or light as engines see it; `node_tree` of the result is the tree.

    It lives as long as the result does. None in 4.5, which cannot do so, and where an output is for Cycles alone, which
    Blender does not take.
    """
    inline = getattr(owner, 'inline_shader_nodes', None)
    if inline is None:
        return None
    tree = node_tree(owner)
    output = None if tree is None else tree.get_output_node('CYCLES')
    return None if output is not None and output.target == 'CYCLES' else inline()


def can_draw_text() -> bool:
    """Whether `text_coverage` works: 4.5 gives no way to the pixels of such a buffer."""
    import blf  # Blender's modules are there once bpy is
    import imbuf

    return hasattr(blf, 'bind_imbuf') and hasattr(imbuf.types.ImBuf, 'with_buffer')


def text_coverage(text: str, size: int) -> np.ndarray:
    """A text in Blender's font, as coverage from 0 to 1, (h, w), the first row on top. size: of the font, in pixels."""
    import blf
    import imbuf

    blf.size(0, size)
    width, height = round(blf.dimensions(0, text)[0]) + 2, round(1.35 * size)
    buffer = imbuf.new((width, height))
    with blf.bind_imbuf(0, buffer):
        blf.position(0, 1, round(0.3 * size), 0)
        blf.color(0, 1.0, 1.0, 1.0, 1.0)
        blf.draw_buffer(0, text)
    with buffer.with_buffer() as pixels:
        return np.array(pixels)[::-1, :, 3].astype(np.float32) / 255.0
