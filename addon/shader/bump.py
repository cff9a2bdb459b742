# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that bend normals: Bump, Normal Map, and Displacement, which bends them as a bump map.

Blinn 1978, "Simulation of Wrinkled Surfaces": a height is evaluated in its place and one step aside along two axes.
"""

from __future__ import annotations

import bpy
import numpy as np

from .feeds import Fed
from .reader import HERE, SHIFTS, Node, Reader, Shift, value
from .tree import DIVIDE, MULTIPLY, SUBTRACT, VECTOR_ADD, VECTOR_DOT, VECTOR_SUBTRACT, Ref

BLUE = (0.5, 0.5, 1.0)  # of a normal map: the normal itself
ALONG_BITANGENT = (0.5, 1.0, 0.5)
DIRECTX = 1 << 3

# Modes of object_transform: a normal from world to object, a vector from object to world.
NORMAL_TO_OBJECT = 2 | 0 << 2 | 1 << 4
VECTOR_TO_WORLD = 0 | 1 << 2 | 0 << 4


# How wide the steps of a displacement are that is a bump map, in pixels: the default of Bump nodes, as in Cycles.
DISPLACEMENT_WIDTH = float(np.float16(0.1))


def _steps(width: float) -> tuple[Shift, Shift, Shift]:
    return HERE, (1, width), (2, width)


def _width(node: bpy.types.Node) -> float:
    """How wide the steps of a Bump node are, in pixels. Cycles takes the constant even where something is linked."""
    socket = node.inputs.get('Filter Width')
    width = 1.0 if socket is None else socket.default_value
    return float(np.float16(width)) if 1e-4 < width < 1e4 else 1.0


def _bump_shifts(node: bpy.types.Node, socket: bpy.types.NodeSocket) -> tuple[Shift, ...]:
    return _steps(_width(node)) if socket.identifier == 'Height' else (HERE,)


SHIFTS['ShaderNodeBump'] = _bump_shifts


@value('ShaderNodeBump')
def _bump(node: Node, output: str) -> Ref:
    node = node.reader.node(node.node, node.contexts)  # a normal is not asked for aside
    normal = node.normal()
    if not node.is_fed('Height'):
        return normal
    width = _width(node.node)
    reader, builder = node.reader, node.builder
    heights = [reader.node(node.node, node.contexts, shift).f('Height') for shift in _steps(width)]
    distance = node.f('Distance')
    if width != 1.0:
        # Differences of heights are `width` times smaller than those a whole pixel aside.
        known = builder.constant_of(distance)
        if known is None:
            distance = builder.math(DIVIDE, distance, node.constant(width))
        else:
            distance = node.constant(known[0] / width)
    return node.emit('bump', *heights, node.f('Strength'), distance, normal, mode=int(node.node.invert))


@value('ShaderNodeNormalMap')
def _normal_map(node: Node, output: str) -> Ref:
    own = node.node
    color = node.v('Color')
    if own.space == 'TANGENT' and node.builder.constant_of(color) == BLUE:
        return node.surface_normal()
    mode = node.enum('space') | (DIRECTX if getattr(own, 'convention', 'OPENGL') == 'DIRECTX' else 0)
    layer = node.builder.named('tangent', own.uv_map) if own.space == 'TANGENT' else node.constant(0.0)
    return node.emit('normal_map', color, node.f('Strength'), layer, mode=mode)


@value('ShaderNodeDisplacement')
def _displacement(node: Node, output: str) -> Ref:
    """A way along the normal, in world space."""
    builder = node.builder
    raised = builder.math(SUBTRACT, node.f('Height'), node.f('Midlevel'))
    raised = builder.math(MULTIPLY, raised, node.f('Scale'))
    normal = node.normal()
    if node.node.space != 'OBJECT':
        return builder.scale(normal, raised)
    way = builder.scale(node.emit('object_transform', normal, mode=NORMAL_TO_OBJECT), raised)
    return node.emit('object_transform', way, mode=VECTOR_TO_WORLD)


@value('ShaderNodeVectorDisplacement')
def _vector_displacement(node: Node, output: str) -> Ref:
    """A way in the space of the surface, the object or the world; in world space."""
    builder, zero = node.builder, node.constant(0.0)
    middle = builder.splat(node.f('Midlevel'))
    way = node.emit('vector_math_v', node.v('Vector'), middle, zero, zero, mode=VECTOR_SUBTRACT)
    way = builder.scale(way, node.f('Scale'))
    if node.node.space == 'WORLD':
        return way
    if node.node.space == 'TANGENT':
        layer, normal = builder.named('tangent', ''), node.surface_normal()
        # x along the tangent, y along the normal, z along what is square to both, on the side that the UV map says.
        bitangent = node.emit('normal_map', node.constant(ALONG_BITANGENT), node.constant(1.0), layer)
        parts = (node.emit('uv_tangent', layer), normal, bitangent)
        scaled = [builder.scale(axis, node.emit('component', way, mode=at)) for at, axis in enumerate(parts)]
        way = node.emit('vector_math_v', scaled[0], scaled[1], zero, zero, mode=VECTOR_ADD)
        return node.emit('vector_math_v', way, scaled[2], zero, zero, mode=VECTOR_ADD)
    return node.emit('object_transform', way, mode=VECTOR_TO_WORLD)


def displaced_normal(reader: Reader, socket: bpy.types.NodeSocket) -> Ref | None:
    """The surface's normal as the displacement at a material's output bends it; None where there is none."""
    if not isinstance(reader.feeds.feeding(socket, ()), Fed):
        return None
    builder, zero = reader.builder, reader.builder.constant(0.0)
    label, builder.label = builder.label, 'Displacement'
    normal = builder.emit('normal')
    heights = []
    for shift in _steps(DISPLACEMENT_WIDTH):
        way = reader.arriving(socket, (), shift, True)
        if way is None:
            builder.label = label
            return None
        heights.append(builder.emit('vector_math_f', way, normal, zero, zero, mode=VECTOR_DOT))
    # Differences of heights are that much smaller than those a whole pixel aside.
    distance = builder.constant(1.0 / DISPLACEMENT_WIDTH)
    bent = builder.emit('bump', *heights, builder.constant(1.0), distance, normal)
    builder.label = label
    reader.forget()
    return bent
