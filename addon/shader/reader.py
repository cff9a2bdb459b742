# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates a node tree into the ops of a Builder: sockets, what feeds them, and how one type becomes another.

What a node means is told in nodes_*.py and closures.py, which register one function a type.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import bpy
import numpy as np

from ..export.bounds import LARGEST
from ..export.images import ImageTable
from ..export.sockets import LUMINANCE
from .feeds import Constant, Contexts, Fed, Feeds
from .layout import inputs, layout, socket_type
from .support import NEAREST, NOT_SUPPORTED
from .tree import SHIFT_BIT, Builder, Ref, Triple, finite

NUMBERS = frozenset(('VALUE', 'INT', 'BOOLEAN'))
VECTORS = frozenset(('RGBA', 'VECTOR', 'ROTATION'))
TRUNCATE = 32  # of the Math node

# The deepest chain of nodes that is read by calls within calls; beyond, they are read one after the other.
DEPTH_MAX = 40

# Where an op is evaluated: in its place, or a step aside for a bump: the axis (1 or 2), and the width in pixels.
Shift = tuple[int, float]
HERE: Shift = (0, 1.0)


OCCLUSION_DISTANCE = 10.0  # Blender's default, of the world


class UnreadError(Exception):
    """A node that cannot be read; the text says why. The input that it feeds keeps its own value."""


@dataclass(slots=True)
class Scene:
    """What shaders are read with, and what they ask of the rest of the scene.

    images:     where images go.
    view_layer: finds an attribute of the view layer, as four numbers.
    suns:       of the skies of a world: the direction to each disc, and the angle across it.
    occlusion_distance: metres that Ambient Occlusion nodes see whose own distance is 0.
    """

    images: ImageTable
    view_layer: Callable[[str], tuple[float, float, float, float]]
    suns: list[tuple[float, float, float, float]] = field(default_factory=list)
    occlusion_distance: float = OCCLUSION_DISTANCE


UNKNOWN = -(1 << 62)  # of an output that was not read yet
ACTIVE = UNKNOWN + 1  # of one that is being read: it leads back to itself

Evaluate = Callable[['Node', str], Ref]
VALUES: dict[str, Evaluate] = {}


def value(*types: str) -> Callable[[Evaluate], Evaluate]:
    """Registers the function that evaluates outputs of nodes of these types."""

    def register(function: Evaluate) -> Evaluate:
        VALUES.update(dict.fromkeys(types, function))
        return function

    return register


@dataclass(slots=True)
class Reader:
    """Reads one tree of one owner.

    kind:   'material', 'world' or 'light'.
    warn:   takes texts about this owner.
    normal: what stands for the normal where nothing is linked; None = the surface's own.
    """

    feeds: Feeds
    builder: Builder
    scene: Scene
    kind: str
    warn: Callable[[str], None]
    normal: Ref | None = None
    _memo: dict[tuple, Ref | None] = field(default_factory=dict)
    _inputs: dict[bpy.types.Node, tuple[str, str, dict[str, bpy.types.NodeSocket]]] = field(default_factory=dict)
    mappings: dict[bpy.types.Node, object] = field(default_factory=dict)  # of textures themselves, once a node
    _depth: int = 0

    def inputs(self, node: bpy.types.Node) -> tuple[str, str, dict[str, bpy.types.NodeSocket]]:
        """Type, name and inputs of a node, which are read once however often it is evaluated."""
        found = self._inputs.get(node)
        if found is None:
            found = self._inputs[node] = layout(node).kind, self.feeds.name(node), inputs(node)
        return found

    def node(self, node: bpy.types.Node, contexts: Contexts, shift: Shift = HERE) -> Node:
        return Node(self, node, contexts, shift)

    def value(self, socket: bpy.types.NodeSocket, contexts: Contexts, shift: Shift, vector: bool) -> Ref:
        """The value of an input, as three numbers if `vector`, else as one."""
        if socket.is_linked:
            ref = self.arriving(socket, contexts, shift, vector)
            if ref is not None:
                return ref
        own = getattr(socket, 'default_value', 0.0)
        if type(own) is float and -LARGEST <= own <= LARGEST:  # the most frequent kind: a number as it should be
            return self.builder.constant(own)
        return self.typed(own, socket_type(socket), vector, socket)

    def arriving(self, socket: bpy.types.NodeSocket, contexts: Contexts, shift: Shift, vector: bool) -> Ref | None:
        """As `value`; None where an input's own value counts."""
        fed = self.feeds.feeding(socket, contexts)
        if fed is None:
            return None
        kind = socket_type(socket)
        if isinstance(fed, Constant):
            return self.typed(fed.value, kind, vector, socket)
        ref = self.output(fed, shift)
        wanted = 'VECTOR' if vector else 'VALUE'
        if ref is None or fed.types == (kind,) == (wanted,):
            return ref
        at = fed.types[0]
        for into in (*fed.types[1:], kind, wanted):
            if into != at:
                ref, at = self.converted(ref, at, into), into
        return ref

    def typed(self, own: object, kind: str, vector: bool, socket: bpy.types.NodeSocket) -> Ref:
        """A value that was typed in, of a socket of type `kind`."""
        if isinstance(own, str):
            own = 0.0
        # Vectors have two to four numbers in Blender 5.
        number = float(own) if isinstance(own, (int, float)) else (*tuple(own)[:3], 0.0)[:3]
        if not finite(number):
            self.warn(f'node "{self.feeds.name(socket.node)}": {socket.name} is not a finite number: 0 is used')
            number = (0.0, 0.0, 0.0) if isinstance(number, tuple) else 0.0
        parts = number if isinstance(number, tuple) else (number,)
        if max(map(abs, parts)) > LARGEST:
            self.warn(
                f'node "{self.feeds.name(socket.node)}": {socket.name} is beyond what can be rendered: '
                f'{LARGEST:g} is used'
            )
            parts = tuple(min(max(part, -LARGEST), LARGEST) for part in parts)
            number = parts if isinstance(number, tuple) else parts[0]
        return self.converted(self.builder.constant(number), kind, 'VECTOR' if vector else 'VALUE')

    def output(self, fed: Fed, shift: Shift) -> Ref | None:
        """The value of an output; None where the node cannot be read, which is named."""
        key = (fed.socket, fed.contexts, shift)
        known = self._memo.get(key, UNKNOWN)
        if known == ACTIVE:
            self.warn(f'node "{self.feeds.name(fed.node)}" is part of a loop: its link is left out')
            return None
        if known != UNKNOWN:
            return known
        if self._depth == DEPTH_MAX:
            depth, self._depth = self._depth, 0
            self._read_ahead(fed, shift)
            self._depth = depth
            return self._memo[key]
        return self._evaluate(fed, shift, key)

    def forget(self) -> None:
        """Read everything anew from now on, since `normal` is another; what is equal is shared nevertheless."""
        self._memo.clear()

    def _evaluate(self, fed: Fed, shift: Shift, key: tuple) -> Ref | None:
        node = Node(self, fed.node, fed.contexts, shift)
        label, self.builder.label = self.builder.label, node.label
        self._memo[key] = ACTIVE
        self._depth += 1
        try:
            evaluate = VALUES.get(node.kind)
            if evaluate is None:
                raise UnreadError(NOT_SUPPORTED.get(node.kind, 'this node is not supported yet'))
            ref = evaluate(node, fed.socket.identifier)
        except UnreadError as unread:
            if str(unread):
                node.warn(str(unread))
            ref = None
        finally:
            self._depth -= 1
            self.builder.label = label
        self._memo[key] = ref
        return ref

    def _read_ahead(self, start: Fed, shift: Shift) -> None:
        """Evaluate all that feeds an output, what lies deepest first."""
        waiting: list[tuple[Fed, Shift, bool]] = [(start, shift, False)]
        met: set[tuple] = set()
        while waiting:
            fed, at, ready = waiting.pop()
            key = (fed.socket, fed.contexts, at)
            if ready:
                if key not in self._memo:
                    self._evaluate(fed, at, key)
                continue
            if key in met or key in self._memo:
                continue
            met.add(key)
            waiting.append((fed, at, True))
            node = fed.node
            for socket in node.inputs:
                if not socket.enabled or socket.type == 'SHADER':
                    continue
                below = self.feeds.feeding(socket, fed.contexts)
                if isinstance(below, Fed):
                    shifts = SHIFTS[node.bl_idname](node, socket) if node.bl_idname in SHIFTS else (at,)
                    waiting += [(below, one, False) for one in shifts]

    def converted(self, ref: Ref, at: str, into: str) -> Ref:
        """A value of a socket of type `at` as one of a socket of type `into`, as Cycles converts."""
        if at == into:
            return ref
        if at in VECTORS:
            if into in VECTORS:
                return ref
            ref = self.luminance(ref) if at == 'RGBA' else self.average(ref)
        elif into in VECTORS:
            return self.builder.splat(ref)
        if into in ('INT', 'BOOLEAN') and at not in ('INT', 'BOOLEAN'):
            known = self.builder.constant_of(ref)
            if known is not None:
                return self.builder.constant(float(int(known[0])))
            return self.builder.math(TRUNCATE, ref, self.builder.constant(0.0))
        return ref

    def luminance(self, ref: Ref) -> Ref:
        known = self.builder.constant_of(ref)
        if known is None:
            return self.builder.emit('luminance', ref)
        if known[0] == known[1] == known[2]:
            return self.builder.constant(known[0])
        return self.builder.constant(sum(part * share for part, share in zip(known, LUMINANCE, strict=True)))

    def average(self, ref: Ref) -> Ref:
        known = self.builder.constant_of(ref)
        return self.builder.emit('average', ref) if known is None else self.builder.constant(sum(known) / 3.0)


class Node:
    """A node as its function sees it: its inputs by identifier, evaluated when asked for."""

    __slots__ = ('builder', 'contexts', 'emit', 'kind', 'label', 'node', 'reader', 'shift', 'sockets')

    def __init__(self, reader: Reader, node: bpy.types.Node, contexts: Contexts, shift: Shift) -> None:
        self.reader = reader
        self.builder = reader.builder
        self.emit = reader.builder.emit
        self.node = node
        self.contexts = contexts
        self.shift = shift
        self.kind, self.label, self.sockets = reader.inputs(node)

    def f(self, name: str) -> Ref:
        """An input as one number."""
        return self.reader.value(self.sockets[name], self.contexts, self.shift, False)

    def v(self, name: str) -> Ref:
        """An input as a vector or colour."""
        return self.reader.value(self.sockets[name], self.contexts, self.shift, True)

    def has(self, name: str) -> bool:
        """Whether the node has this input, and it is in use."""
        return name in self.sockets and self.sockets[name].enabled

    def used(self, name: str, vector: bool = False) -> Ref:
        """An input as one number or as a vector; 0 where the node's mode hides it."""
        socket = self.sockets.get(name)
        if socket is None or not socket.enabled:
            return self.builder.constant(0.0)
        return self.reader.value(socket, self.contexts, self.shift, vector)

    def is_fed(self, name: str) -> bool:
        socket = self.sockets[name]
        return socket.is_linked and self.reader.feeds.feeding(socket, self.contexts) is not None

    def linked(self, name: str) -> Ref | None:
        """A vector that is linked to an input; None where it stands for something of the surface."""
        socket = self.sockets.get(name)
        if socket is None or not socket.is_linked:
            return None
        return self.reader.arriving(socket, self.contexts, self.shift, True)

    def own(self, name: str) -> float | Triple:
        """The value typed into an input."""
        own = self.sockets[name].default_value
        return float(own) if isinstance(own, (int, float)) else tuple(own)[:3]

    def enum(self, name: str) -> int:
        """The number of a property's choice."""
        return enum_numbers(self.kind, name)[getattr(self.node, name)]

    def constant(self, number: float | Triple) -> Ref:
        return self.builder.constant(number)

    def warn(self, text: str) -> None:
        self.reader.warn(f'node "{self.label}": {text}')

    def warn_nearest(self) -> None:
        """Say what this node is shown as."""
        self.warn(NEAREST[self.kind])

    def normal(self, name: str = 'Normal') -> Ref:
        """A normal: what is linked, or the surface's."""
        ref = self.linked(name)
        return self.surface_normal() if ref is None else ref

    def surface_normal(self) -> Ref:
        return self.emit('normal') if self.reader.normal is None else self.reader.normal

    def at_point(self, name: str, *args: Ref, mode: int = 0) -> Ref:
        """An op that reads the shading point, which bump maps ask for a step aside."""
        axis, width = self.shift
        if axis:
            mode |= axis << SHIFT_BIT | half_bits(width)
        return self.emit(name, *args, mode=mode)


def half_bits(number: float) -> int:
    """The bits of a half float, in which modes hold the width of a step."""
    return int(np.float16(number).view(np.uint16))


@cache
def enum_numbers(kind: str, name: str) -> dict[str, int]:
    """The numbers of all choices of a property, by what Python calls them."""
    return {item.identifier: item.value for item in getattr(bpy.types, kind).bl_rna.properties[name].enum_items}


# Which shifts of an input a node of this type asks for: bump maps evaluate their height at three places.
SHIFTS: dict[str, Callable[[bpy.types.Node, bpy.types.NodeSocket], tuple[Shift, ...]]] = {}
