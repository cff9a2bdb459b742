# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that trace rays: Ambient Occlusion, Bevel, Raycast. What a ray asks is the kernels' (program/rays.h).

Where no ray may be traced (shadow rays, light that emitters send) all is open and edges are sharp, as in Cycles.
"""

from __future__ import annotations

from .reader import Node, UnreadError, value
from .tree import VECTOR_ADD, Ref

# Bits of modes, AO_*, BEVEL_* and RAYCAST_* of the kernels.
INSIDE, ONLY_LOCAL = 1, 2
GIVEN_NORMAL = 1
SAMPLES_SHIFT = 8
RAYCAST_ONLY_LOCAL = 1 << 16


@value('ShaderNodeAmbientOcclusion')
def _occlusion(node: Node, output: str) -> Ref:
    own = node.node
    color = node.v('Color')
    distance = node.f('Distance')
    if not node.is_fed('Distance') and node.own('Distance') == 0.0:
        distance = node.constant(node.reader.scene.occlusion_distance)
    mode = own.inside * INSIDE | own.only_local * ONLY_LOCAL | own.samples << SAMPLES_SHIFT
    open_share = node.emit('ao', distance, node.normal(), mode=mode)
    return open_share if output == 'AO' else node.builder.scale(color, open_share)


@value('ShaderNodeBevel')
def _bevel(node: Node, output: str) -> Ref:
    given = node.linked('Normal')
    mode = (given is not None) * GIVEN_NORMAL | node.node.samples << SAMPLES_SHIFT
    return node.emit('bevel', node.f('Radius'), node.surface_normal() if given is None else given, mode=mode)


@value('ShaderNodeRaycast')
def _raycast(node: Node, output: str) -> Ref:
    position, direction = node.linked('Position'), node.normal('Direction')
    if position is None:
        position = node.at_point('position')
    ray = (position, direction, node.f('Length'))
    mode = node.node.only_local * RAYCAST_ONLY_LOCAL
    if output == 'Hit Normal':
        return node.at_point('raycast_normal', *ray, mode=mode)
    met = node.at_point('raycast', *ray, mode=mode)
    if output in OF_RAYCAST:
        return node.emit('component', met, mode=OF_RAYCAST.index(output))
    if output != 'Hit Position':
        raise UnreadError(f'its output "{output}", an attribute where the ray hits, is not supported yet')
    zero = node.constant(0.0)
    way = node.builder.scale(direction, node.emit('component', met, mode=OF_RAYCAST.index('Hit Distance')))
    place = node.emit('vector_math_v', position, way, zero, zero, mode=VECTOR_ADD)
    return node.builder.scale(place, node.emit('component', met, mode=OF_RAYCAST.index('Is Hit')))


OF_RAYCAST = ('Is Hit', 'Self Hit', 'Hit Distance')
