# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one colour, and which rays see it.

Environment textures and skies are not read yet; they are reported, and the socket's own colour stands in for them.
"""

from __future__ import annotations

import bpy

from .. import compat, cycles_settings
from ..log import Log
from . import bounds
from .buffers import (
    VISIBLE_CAMERA,
    VISIBLE_DIFFUSE,
    VISIBLE_GLOSSY,
    VISIBLE_SHADOW,
    VISIBLE_TRANSMISSION,
    VISIBLE_VOLUME,
    World,
)
from .closures import BLACK, Color
from .nodes import Trees, node_inputs, output_node
from .surface import Reader, read_closure, warn_missing_images

VISIBILITY = {
    'camera': VISIBLE_CAMERA,
    'diffuse': VISIBLE_DIFFUSE,
    'glossy': VISIBLE_GLOSSY,
    'transmission': VISIBLE_TRANSMISSION,
    'scatter': VISIBLE_VOLUME,
}


def read_world(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, groups: dict[str, int], trees: Trees, log: Log
) -> World:
    """The world of a view layer; black where there is none or the layer leaves it out ('Environment' in its filter)."""
    world = getattr(view_layer, 'world_override', None) or scene.world  # 5.x can override it
    if world is None or not view_layer.use_sky:
        return World()
    cycles_settings.warn_world(world, scene, log)
    flags = getattr(world, 'cycles_visibility', None)  # absent where the Cycles add-on is disabled
    visibility = VISIBLE_SHADOW | sum(bit for name, bit in VISIBILITY.items() if getattr(flags, name, True))
    return World(_color(world, trees, log), visibility, groups.get(world.lightgroup, -1))


def _color(world: bpy.types.World, trees: Trees, log: Log) -> Color:
    def warn(text: str) -> None:
        log.warning(f'World "{world.name}": {text}')

    tree = compat.node_tree(world)
    if tree is None:
        return bounds.color(world.color, BLACK, 'its colour', warn)
    output = output_node(tree)
    inputs = node_inputs(output) if output is not None else {}
    reader = Reader(trees, warn)
    color = read_closure(reader, inputs.get('Surface')).emission
    reader.leave_out_linked(inputs, 'Volume')
    reader.report()
    warn_missing_images(tree, warn)
    return bounds.color(color, BLACK, 'its colour', warn)
