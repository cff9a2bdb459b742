# SPDX-License-Identifier: GPL-3.0-or-later
"""What feeds an input of a node tree: in the tree that Blender inlines for engines, or in the tree as it was drawn.

Blender 5 resolves groups, zones, menus and whatever else only hands on; elsewhere export/nodes.py does. Trees in which
nothing is to be resolved are read as they are.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import bpy

from .. import compat
from ..export.nodes import FOLDED, Constant, Context, Input, Source, Trees, output_node, source
from .layout import layout, socket_type

Contexts = tuple[Context, ...]


class Fed(NamedTuple):
    """An output that has to be evaluated.

    contexts: the way into its tree.
    types:    of the sockets that its value passes, its own first.
    """

    node: bpy.types.Node
    socket: bpy.types.NodeSocket
    contexts: Contexts
    types: tuple[str, ...]


class Feeds(Protocol):
    """A node tree with its output. Where `feeding` is None, an input's own value counts, or what it stands for."""

    output: bpy.types.Node | None
    tree: bpy.types.NodeTree

    def feeding(self, socket: bpy.types.NodeSocket, contexts: Contexts) -> Fed | Constant | None: ...

    def name(self, node: bpy.types.Node) -> str: ...


def _fed(node: bpy.types.Node, output: bpy.types.NodeSocket) -> Fed:
    return Fed(node, output, (), (socket_type(output),))


@dataclass(slots=True)
class DirectFeeds:
    """A tree without groups and muted nodes, where each link ends at what it feeds.

    links:     what feeds an input.
    numbered:  whether Blender put a number before each name, as `inline_shader_nodes()` does.
    owner:     keeps the tree alive.
    """

    tree: bpy.types.NodeTree
    output: bpy.types.Node
    links: dict[bpy.types.NodeSocket, Fed]
    numbered: bool = False
    owner: object = None

    def feeding(self, socket: bpy.types.NodeSocket, contexts: Contexts) -> Fed | None:
        return self.links.get(socket)

    def name(self, node: bpy.types.Node) -> str:
        """The name that the user gave it."""
        if not self.numbered:
            return node.name
        number, bar, name = node.name.partition('_')
        return name if bar and number.isdecimal() else node.name


@dataclass(slots=True)
class DrawnFeeds:
    """A tree as it was drawn, walked through groups, zones and muted nodes."""

    trees: Trees
    tree: bpy.types.NodeTree
    output: bpy.types.Node | None

    def feeding(self, socket: bpy.types.NodeSocket, contexts: Contexts) -> Fed | Constant | None:
        found = source(self.trees, Input(socket, contexts))
        if isinstance(found, Source):
            return Fed(found.node, found.output, found.contexts, found.through)
        return found if isinstance(found, Constant) else None

    def name(self, node: bpy.types.Node) -> str:
        return node.name


# More nodes than anyone draws, groups within groups counted as often as they are used.
NODES_MAX = 1_000_000


def node_count(tree: bpy.types.NodeTree, known: dict[bpy.types.NodeTree, int] | None = None) -> int:
    """How many nodes a tree has with those of its groups, of which each use counts."""
    known = {} if known is None else known
    waiting = [tree]
    while waiting:
        at = waiting[-1]
        inner = [node.node_tree for node in at.nodes if node.type == 'GROUP' and node.node_tree is not None]
        unknown = [one for one in inner if one not in known and one not in waiting]
        if unknown:
            waiting += unknown
        else:
            known[at] = len(at.nodes) + sum(known.get(one, 0) for one in inner)
            waiting.pop()
    return known[tree]


def _trees_within(tree: bpy.types.NodeTree, trees: Trees) -> dict[bpy.types.NodeTree, None]:
    """A tree and those of its groups, each once; groups that their library lacks are named."""
    met, waiting = {tree: None}, [tree]
    while waiting:
        for node in waiting.pop().nodes:
            inner = node.node_tree if node.type == 'GROUP' else None
            if inner is None:
                continue
            if inner.original.is_missing:
                trees.warn(f'node "{node.name}": group "{inner.name}" is missing from its library: 0 is used')
            if inner not in met:
                met[inner] = None
                waiting.append(inner)
    return met


def plain_feeds(tree: bpy.types.NodeTree, kinds: Container[str]) -> DirectFeeds | None:
    """A tree that Blender would inline to itself, as it is; None for all others.

    Its nodes are of these kinds, none is muted, none is a constant or computed from nothing but constants, and all its
    links are in use, without a loop. Most trees are such, and inlining them costs as much as reading them.
    """
    nodes = tree.nodes.values()
    layouts = {kind: layout(node) for kind, node in {type(node): node for node in nodes}.items()}
    if len(nodes) > NODES_MAX or not all(each.kind in kinds for each in layouts.values()):
        return None
    if any(_flags(tree.nodes, 'mute')):
        return None
    if any(_flags(tree.links, 'is_muted')) or not all(_flags(tree.links, 'is_valid')):
        return None  # of each loop Blender calls a link invalid, but for that of a node to itself
    links = {}
    fed = set()
    for link in tree.links.values():
        start, end = link.from_node, link.to_node
        if start == end:
            return None
        fed.add(end)
        links[link.to_socket] = _fed(start, link.from_socket)
    folded = {kind for kind, each in layouts.items() if each.type in FOLDED}
    if any(type(node) in folded and node not in fed for node in nodes):
        return None
    outputs = {kind for kind, each in layouts.items() if each.type.startswith('OUTPUT_')}
    output = output_node(tree)
    if output is None or sum(type(node) in outputs for node in nodes) != 1:
        return None
    return DirectFeeds(tree, output, links)


def _flags(collection: bpy.types.bpy_prop_collection, name: str) -> list[bool]:
    flags = [False] * len(collection)
    collection.foreach_get(name, flags)
    return flags


def feeds_of(owner: bpy.types.ID, tree: bpy.types.NodeTree, trees: Trees) -> Feeds:
    """The tree of a material, world or light, inlined where this Blender can do so.

    A tree with a loop is walked, which names the loop: Blender inlines it to nothing, and never comes back from one
    within a group (5.2.3).
    """
    loops = [met for met in _trees_within(tree, trees) if trees.has_loop(met)]
    inlined = None if loops else compat.inlined(owner)
    if inlined is not None:
        output = output_node(inlined.node_tree)
        if output is not None:
            valid = (link for link in inlined.node_tree.links if link.is_valid)
            links = {link.to_socket: _fed(link.from_node, link.from_socket) for link in valid}
            return DirectFeeds(inlined.node_tree, output, links, True, inlined)
    return DrawnFeeds(trees, tree, output_node(tree))
