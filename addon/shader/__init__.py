# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees to shaders: flat arrays of ops and closures, as the native module compiles them.

It reads trees only; folding constants, sharing programs and all that follows is the native module's.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

from .. import compat
from ..export.nodes import Trees

# They register their nodes.
from . import bump, nodes_input, nodes_math, nodes_rays, nodes_sky, nodes_texture  # noqa: F401
from .closures import CLOSURES, read_closures
from .feeds import NODES_MAX, Feeds, feeds_of, node_count, plain_feeds
from .ops import Tables, tables
from .reader import OCCLUSION_DISTANCE, VALUES, Reader, Scene
from .support import NEAREST, NOT_SUPPORTED, STRUCTURE
from .tree import Builder, Draft


def shaders_of(
    owner: bpy.types.Material | bpy.types.World | bpy.types.Light,
    trees: Trees,
    scene: Scene,
    warn: Callable[[str], None],
    ops: Tables | None = None,
) -> Draft:
    """What the node tree of a material, world or light computes; without a tree, what Blender shows then.

    warn: takes texts about this owner. ops: the native module's, if not given.
    """
    builder = Builder(ops or tables())
    tree = compat.node_tree(owner)
    kind = KINDS[type(owner).bl_rna.identifier if not isinstance(owner, bpy.types.Light) else 'Light']
    if tree is None:
        _plain(builder, owner, kind)
        return builder.draft(owner.name)
    feeds = plain_feeds(tree, PLAIN)
    if feeds is None:
        if node_count(tree) > NODES_MAX:
            warn(f'it has more than {NODES_MAX:,} nodes, those of groups in groups counted: it is not read')
            _plain(builder, owner, kind)
            return builder.draft(owner.name)
        feeds = feeds_of(owner, tree, trees)
    reader = Reader(feeds, builder, scene, kind, warn)
    if feeds.output is not None:
        _read_output(reader, owner, warn)
    return builder.draft(owner.name)


def occlusion_distance(scene: bpy.types.Scene) -> float:
    """Metres that Ambient Occlusion nodes see whose own distance is 0."""
    return OCCLUSION_DISTANCE if scene.world is None else scene.world.light_settings.distance


# Nodes that Blender's inliner takes as they are: those that are read here, without groups and constants.
PLAIN = frozenset((*VALUES, *CLOSURES, *STRUCTURE, 'NodeFrame')) - {
    *('FunctionNodeInputBool', 'FunctionNodeInputInt', 'FunctionNodeInputVector'),
    *('ShaderNodeGroup', 'ShaderNodeRGB', 'ShaderNodeValue'),
}

KINDS = {'Material': 'material', 'World': 'world', 'Light': 'light'}


def _plain(builder: Builder, owner: bpy.types.ID, kind: str) -> None:
    """What is shown without nodes: a diffuse surface, a plain background, a white lamp."""
    one = builder.constant(1.0)
    match kind:
        case 'material':
            color = builder.constant(tuple(owner.diffuse_color)[:3])
            builder.closure('diffuse', one, color, builder.constant(0.0), builder.emit('normal'))
        case 'world':
            builder.closure('emission', one, builder.constant(tuple(owner.color)[:3]))
        case _:
            builder.closure('emission', one, one)


def _read_output(reader: Reader, owner: bpy.types.ID, warn: Callable[[str], None]) -> None:
    sockets = {socket.identifier: socket for socket in reader.feeds.output.inputs}
    displacement = sockets.get('Displacement')
    if displacement is not None and displacement.enabled:
        reader.normal = reader.builder.own_normal = bump.displaced_normal(reader, displacement)
        if reader.normal is not None and owner.displacement_method != 'BUMP':
            warn('displacement is not supported yet: it is a bump map')
    volume = sockets.get('Volume')
    if volume is not None and reader.feeds.feeding(volume, ()) is not None:
        warn('volumes are not supported yet: left out')
    if 'Surface' in sockets:
        read_closures(reader, sockets['Surface'])
    for node in reader.feeds.tree.nodes:
        if isinstance(node, bpy.types.ShaderNodeOutputAOV) and node.aov_name:
            warn(f'node "{reader.feeds.name(node)}": passes of shaders are not supported yet: left out')


__all__ = [
    'CLOSURES',
    'NEAREST',
    'NOT_SUPPORTED',
    'STRUCTURE',
    'VALUES',
    'Draft',
    'Feeds',
    'Scene',
    'occlusion_distance',
    'shaders_of',
]
