# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one colour, and which rays see it.

Environment textures and skies are not read yet; they are reported, and the socket's own colour stands in for them.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np

from .. import compat
from ..log import Log
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
from .shaders import ShaderTable
from .surface import Reader, read_closure, warn_missing_images

VISIBILITY = {
    'camera': VISIBLE_CAMERA,
    'diffuse': VISIBLE_DIFFUSE,
    'glossy': VISIBLE_GLOSSY,
    'transmission': VISIBLE_TRANSMISSION,
    'scatter': VISIBLE_VOLUME,
}


def read_world(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    groups: dict[str, int],
    trees: Trees,
    log: Log,
    shaders: ShaderTable | None = None,
) -> World:
    """The world of a view layer; black where there is none or the layer leaves it out ('Environment' in its filter)."""
    world = getattr(view_layer, 'world_override', None) or scene.world  # 5.x can override it
    if world is None or not view_layer.use_sky:
        return World()
    flags = getattr(world, 'cycles_visibility', None)  # absent where the Cycles add-on is disabled
    visibility = VISIBLE_SHADOW | sum(bit for name, bit in VISIBILITY.items() if getattr(flags, name, True))
    group = groups.get(world.lightgroup, -1)

    def warn(text: str) -> None:
        log.warning(f'World "{world.name}": {text}')

    if shaders is None:
        return World(_color(world, trees, warn), visibility, group)
    # What its shader cannot be is told once.
    color = _color(world, trees, lambda text: None)
    return World(color, visibility, group, shaders.index(world, warn))


def _color(world: bpy.types.World, trees: Trees, warn: Callable[[str], None]) -> Color:

    tree = compat.node_tree(world)
    if tree is None:
        return tuple(world.color)
    output = output_node(tree)
    inputs = node_inputs(output) if output is not None else {}
    reader = Reader(trees, warn)
    color = read_closure(reader, inputs.get('Surface')).emission
    reader.leave_out_linked(inputs, 'Volume')
    reader.report()
    warn_missing_images(tree, warn)
    if not np.isfinite(color).all():
        warn('its colour is not a finite number: black is used')
        return BLACK
    return color
