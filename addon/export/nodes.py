# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks shader node trees: which value or which node feeds an input, through reroutes, muted nodes and groups.

It knows links and constants only; what a shader node means is told in surface.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from .textures import LUMINANCE, Color


@dataclass(frozen=True, slots=True)
class Input:
    """An input of a node, and the group nodes that one went through to reach its tree."""

    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()


@dataclass(frozen=True, slots=True)
class Source:
    """What feeds an input: an output of a node that has to be evaluated."""

    node: bpy.types.Node
    output: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()

    def inputs(self) -> dict[str, Input]:
        """The inputs in use by name; of several with one name, the first."""
        return node_inputs(self.node, self.groups)


@dataclass(frozen=True, slots=True)
class Trees:
    """The links of the node trees that were met during one export, by the input they end at.

    `socket.links` searches all links of a tree at each call; this reads each tree once.
    """

    links: dict[bpy.types.NodeTree, dict[bpy.types.NodeSocket, bpy.types.NodeSocket]]

    def feeding(self, socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
        tree = socket.id_data
        if tree not in self.links:
            self.links[tree] = {
                link.to_socket: link.from_socket
                for link in tree.links
                if link.is_valid and not link.is_muted and link.from_socket.enabled and link.to_socket.enabled
            }
        return self.links[tree].get(socket)


def node_inputs(node: bpy.types.Node, groups: tuple[bpy.types.Node, ...] = ()) -> dict[str, Input]:
    """The inputs in use by name (nodes with modes have several of a name, one enabled); of several, the first."""
    found: dict[str, Input] = {}
    for socket in node.inputs:
        if socket.enabled:
            found.setdefault(socket.name, Input(socket, groups))
    return found


def source(trees: Trees, target: Input) -> Source | Input:
    """Follow the link that ends at `target`: to the node that feeds it, or the unlinked input that gives the value."""
    start = target
    while True:
        output = trees.feeding(target.socket)
        if output is None:
            return target
        node = output.node
        if node.mute:
            inner = next((link.from_socket for link in node.internal_links if link.to_socket == output), None)
            if inner is None:
                return start
            target = Input(inner, target.groups)
        elif node.type == 'REROUTE':
            target = Input(node.inputs[0], target.groups)
        elif node.type == 'GROUP':
            inside = _group_output(node, output.identifier) if node not in target.groups else None
            if inside is None:
                return start
            target = Input(inside, (*target.groups, node))
        elif node.type == 'GROUP_INPUT' and target.groups:
            outside = _by_identifier(target.groups[-1].inputs, output.identifier)
            if outside is None:
                return start
            target = Input(outside, target.groups[:-1])
        else:
            return Source(node, output, target.groups)


def as_color(value: Color | float | bool) -> Color:
    return value if isinstance(value, tuple) else (float(value),) * 3


def as_float(value: Color | float | bool) -> float:
    if isinstance(value, tuple):
        return sum(part * weight for part, weight in zip(value, LUMINANCE, strict=True))
    return float(value)


def output_node(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The output that Cycles would take: its own if there is one, else the active one for all engines."""
    return tree.get_output_node('CYCLES')


def own_value(socket: bpy.types.NodeSocket) -> Color | float | bool:
    """The value that a socket has where nothing is linked to it; 0 for sockets that hold none (shaders)."""
    value = getattr(socket, 'default_value', 0.0)
    return value if isinstance(value, (int, float, bool)) else tuple(value)[:3]


def _group_output(group: bpy.types.Node, identifier: str) -> bpy.types.NodeSocket | None:
    if group.node_tree is None:
        return None
    for node in group.node_tree.nodes:
        if node.type == 'GROUP_OUTPUT' and node.is_active_output:
            return _by_identifier(node.inputs, identifier)
    return None


def _by_identifier(sockets: bpy.types.bpy_prop_collection, identifier: str) -> bpy.types.NodeSocket | None:
    return next((socket for socket in sockets if socket.identifier == identifier), None)
