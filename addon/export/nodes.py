# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks shader node trees as Blender inlines them: which value or which node feeds an input, whatever lies between.

It knows links, constants and what only hands on (reroutes, muted nodes, groups, zones, menus, bundles); what a shader
node means is told in addon/shader/.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import bpy

from .sockets import VALUES, ZEROS, Value, converted, own_value

# Nodes that Blender computes where all their inputs are constants (measured with 5.2.3): only such values are
# converted to the types of the sockets that they pass; what an engine has to compute skips those.
FOLDED = frozenset(
    (
        *('BLACKBODY', 'CLAMP', 'COMBXYZ', 'CURVE_FLOAT', 'CURVE_RGB', 'CURVE_VEC', 'GAMMA', 'MAP_RANGE', 'MATH'),
        *('MIX', 'MIX_RGB', 'SEPXYZ', 'VALTORGB', 'VECT_MATH', 'VECTOR_ROTATE', 'ShaderNodeRadialTiling'),
    )
)
STEPS_BETWEEN_CHECKPOINTS = 256
NESTED_MAX = 50  # of menus that choose a menu, and bundles in bundles; what lies deeper is not understood


@dataclass(frozen=True, slots=True)
class Context:
    """A step into a group, into an iteration of a repeat zone, or into a closure where it is evaluated.

    node:   the group node, the zone's output node, or the Evaluate Closure node.
    caller: for closures, what leads to that node; what leads to the closure itself stands before this context.
    """

    node: bpy.types.Node
    iteration: int = -1
    caller: tuple[Context, ...] = ()


@dataclass(frozen=True, slots=True)
class Input:
    """An input of a node, and the way that leads into its tree."""

    socket: bpy.types.NodeSocket
    contexts: tuple[Context, ...] = ()


@dataclass(frozen=True, slots=True)
class Source:
    """What feeds an input: an output of a node that has to be evaluated.

    through: the types of sockets that the value is converted to on its way, before that of the input.
    """

    node: bpy.types.Node
    output: bpy.types.NodeSocket
    contexts: tuple[Context, ...] = ()
    through: tuple[str, ...] = ()

    def all_inputs(self) -> list[Input]:
        return [Input(socket, self.contexts) for socket in self.node.inputs if socket.enabled]


@dataclass(frozen=True, slots=True)
class Constant:
    """What feeds an input: a value that stands elsewhere, and its type, which `source` makes that of the input.

    A value for a shader is a colour, which the surface emits.
    folded: whether Blender itself knows it, as it does all but the colour of node RGB.
    """

    value: Value
    type: str
    folded: bool = True


Feeding = tuple[bpy.types.NodeSocket | None, tuple[str, ...]]


@dataclass(slots=True)
class Trees:
    """The links of the node trees that were met during one export.

    `socket.links` searches all links of a tree at each call; this reads each tree once.
    warn:       takes texts about the material, world or light that is read at present.
    checkpoint: raises where the user asked to stop.
    """

    checkpoint: Callable[[], None]
    warn: Callable[[str], None] = lambda text: None
    _links: dict[bpy.types.NodeTree, dict[bpy.types.NodeSocket, bpy.types.NodeSocket]] = field(default_factory=dict)
    _loops: dict[bpy.types.NodeTree, list[str]] = field(default_factory=dict)
    _feeding: dict[bpy.types.NodeSocket, Feeding] = field(default_factory=dict)
    _folded: dict[tuple, bool] = field(default_factory=dict)
    _steps: int = 0

    def of(self, warn: Callable[[str], None]) -> Trees:
        """The same trees, read for an owner who is to be named in messages."""
        return replace(self, warn=warn)

    def feeding(self, socket: bpy.types.NodeSocket) -> Feeding:
        """The output that feeds an input within its tree, past reroutes and muted nodes, and the types in between.

        None where these end at nothing: Blender then takes such links for none, and the input's own value counts.
        """
        links = self._tree(socket.id_data)
        passed: list[tuple[bpy.types.NodeSocket, bpy.types.NodeSocket]] = []
        found: Feeding = (None, ())
        while True:
            if socket in self._feeding:
                found = self._feeding[socket]
                break
            self.step()
            output = links.get(socket)
            if output is None:
                self._feeding[socket] = found
                break
            inner = _passed_on(output)
            if inner is output:
                found = self._feeding[socket] = (output, (output.type,))
                break
            if inner is None:
                self._feeding[socket] = found
                break
            passed.append((socket, output))
            socket = inner
        for outer, output in reversed(passed):
            if found[0] is not None:
                found = (found[0], _added(found[1], socket.type, output.type))
            self._feeding[outer] = found
            socket = outer
        return found

    def folded(self, start: Source) -> bool:
        """Whether Blender computes this output itself, since nothing but constants feeds it."""
        waiting = [start]
        while waiting:
            at = waiting[-1]
            key = (at.node, at.contexts)
            if at.node.type not in FOLDED:
                self._folded[key] = False
            if key in self._folded:
                waiting.pop()
                continue
            self.step()
            found = [_found(self, target) for target in at.all_inputs()]
            below = [each for each in found if isinstance(each, Source)]
            unknown = [each for each in below if (each.node, each.contexts) not in self._folded]
            if unknown:
                waiting += unknown
                continue
            computed = any(isinstance(each, Constant) and not each.folded for each in found)
            self._folded[key] = not computed and all(self._folded[each.node, each.contexts] for each in below)
        return self._folded[start.node, start.contexts]

    def step(self) -> None:
        self._steps += 1
        if self._steps % STEPS_BETWEEN_CHECKPOINTS == 0:
            self.checkpoint()

    def has_loop(self, tree: bpy.types.NodeTree) -> bool:
        if tree not in self._loops:
            if _is_loop_free(tree):
                self._loops[tree] = []
            else:
                self._links[tree], self._loops[tree] = _tree_links(tree)
        return bool(self._loops[tree])

    def _tree(self, tree: bpy.types.NodeTree) -> dict[bpy.types.NodeSocket, bpy.types.NodeSocket]:
        if tree not in self._links:
            self._links[tree], self._loops[tree] = _tree_links(tree)
        for text in self._loops[tree]:
            self.warn(text)
        return self._links[tree]


def output_node(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The output that Cycles would take: its own if there is one, else the active one for all engines."""
    return tree.get_output_node('CYCLES')


def source(trees: Trees, target: Input) -> Source | Constant | Input:
    """Follow the link that ends at `target`: to the node that feeds it, or to a value that stands elsewhere.

    `target` itself where nothing arrives: its own value counts, or what it stands for (a normal, coordinates).
    """
    found = _found(trees, target)
    if isinstance(found, Source) and len(found.through) > 1 and not trees.folded(found):
        return replace(found, through=found.through[:1])
    return found


def _found(trees: Trees, target: Input, depth: int = 0) -> Source | Constant | Input:
    at, through = target, ()
    while True:
        trees.step()
        output, types = trees.feeding(at.socket)
        if output is None:
            return target if at is target else _typed_in(at.socket, through, target)
        through = _added(types, *through)
        handed = _handed_on(trees, output, at.contexts, depth)
        if isinstance(handed, Source):
            return replace(handed, through=through)
        if isinstance(handed, Constant):
            passed = _added((handed.type,), *through) if handed.folded else (handed.type,)
            return _constant(handed.value, passed, target, handed.folded)
        if handed is None:
            return _constant(ZEROS.get(output.type), through, target)
        at, through = handed, _added((handed.socket.type,), *through)


def _typed_in(socket: bpy.types.NodeSocket, through: tuple[str, ...], target: Input) -> Constant | Input:
    """The value typed into an input that hands it on to `target`; `target` where neither of them shows a value."""
    hidden = socket.hide_value and target.socket.hide_value
    if hidden and all(kind == target.socket.type for kind in through):
        return target
    return _constant(own_value(socket), through, target)


def _constant(value: Value | None, through: tuple[str, ...], target: Input, folded: bool = True) -> Constant | Input:
    kind = target.socket.type
    if value is None or (kind == 'SHADER' and through[0] == 'SHADER'):
        return target
    return Constant(converted(value, (*through, kind)), kind, folded)


def _added(types: tuple[str, ...], *more: str) -> tuple[str, ...]:
    """Conversions one after the other; a second one to the same type changes nothing."""
    return (*types, *(kind for kind in dict.fromkeys(more) if kind not in types))


def _passed_on(output: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The input that a reroute or a muted node hands on, None for none; the output itself where a node computes it."""
    node = output.node
    if node.type == 'REROUTE':
        return node.inputs[0]
    if node.mute:
        return next((link.from_socket for link in node.internal_links if link.to_socket == output), None)
    return output


def _is_loop_free(tree: bpy.types.NodeTree) -> bool:
    """Whether it shows at a glance that there is no loop: Blender calls a link of each invalid, but for one of a node
    to itself."""
    valid = [False] * len(tree.links)
    tree.links.foreach_get('is_valid', valid)
    return all(valid) and not any(link.from_node == link.to_node for link in tree.links)


def _tree_links(
    tree: bpy.types.NodeTree,
) -> tuple[dict[bpy.types.NodeSocket, bpy.types.NodeSocket], list[str]]:
    """The links in use by the input where they end, without those that close a loop; and a text for each of these.

    In a tree with a loop Blender also calls others invalid; elsewhere only links between types that do not fit.
    """
    found: dict[bpy.types.NodeSocket, bpy.types.NodeSocket] = {}
    invalid: list[bpy.types.NodeSocket] = []
    below: dict[bpy.types.Node, dict[bpy.types.Node, None]] = {}
    for link in tree.links:
        start, end = link.from_socket, link.to_socket
        if link.is_muted or not (start.enabled and end.enabled):
            continue
        if not link.is_valid:
            if start.type != end.type and not (start.type in VALUES and end.type in ZEROS):
                continue
            invalid.append(end)
        found[end] = start
        below.setdefault(link.to_node, {})[link.from_node] = None
    cut = dict.fromkeys(_loops(below))
    if cut:
        found = {end: start for end, start in found.items() if (start.node, end.node) not in cut}
    else:
        for end in invalid:
            del found[end]
    return found, [_loop_text(tree, *pair) for pair in cut]


def _loops(below: dict[bpy.types.Node, dict[bpy.types.Node, None]]) -> Iterator[tuple[bpy.types.Node, bpy.types.Node]]:
    """The links that lead back to a node on the way (depth first); without them there is no loop."""
    done: set[bpy.types.Node] = set()
    for root in below:
        way: dict[bpy.types.Node, Iterator[bpy.types.Node]] = {}
        start: bpy.types.Node | None = root if root not in done else None
        while start is not None or way:
            if start is not None:
                done.add(start)
                way[start] = iter(below.get(start, {}))
            end = next(reversed(way))
            start = next(way[end], None)
            if start is None:
                del way[end]
            elif start in way:
                yield start, end
                start = None
            elif start in done:
                start = None


def _loop_text(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> str:
    where = '' if tree.is_embedded_data else f'group "{tree.name}": '
    if start == end:
        return f'{where}node "{start.name}" is linked to itself: that link is left out'
    return f'{where}node "{start.name}" is linked to node "{end.name}" in a loop: that link is left out'


# ---- What hands on values of others. Each function returns the input that is handed on, a constant, None where there
# is nothing (0 is used), or the output as a source, where it is not understood.

Handed = Source | Constant | Input | None


def _handed_on(trees: Trees, output: bpy.types.NodeSocket, contexts: tuple[Context, ...], depth: int) -> Handed:
    hand = HANDING.get(output.node.type)
    found = Source(output.node, output, contexts)
    return found if hand is None else hand(trees, found, depth)


def _group(trees: Trees, found: Source, depth: int) -> Handed:
    tree = found.node.node_tree
    if tree is None or any(context.node == found.node for context in found.contexts):
        return None
    if tree.original.is_missing:
        trees.warn(f'node "{found.node.name}": group "{tree.name}" is missing from its library: 0 is used')
        return None
    for node in tree.nodes:
        if node.type == 'GROUP_OUTPUT' and node.is_active_output:
            return _by_identifier(node.inputs, found, (*found.contexts, Context(found.node)))
    return None


def _group_input(trees: Trees, found: Source, depth: int) -> Handed:
    at = _innermost(found.contexts, 'GROUP')
    if at is None:
        return None
    return _by_identifier(found.contexts[at].node.inputs, found, found.contexts[:at])


def _repeat_output(trees: Trees, found: Source, depth: int) -> Handed:
    """The last iteration's value, or that of the zone's input node where there is none."""
    node = found.node
    first = next((other for other in node.id_data.nodes if getattr(other, 'paired_output', None) == node), None)
    if first is None:
        return None
    count = _chosen(trees, Input(first.inputs[0], found.contexts), depth)
    if isinstance(count, Source):
        return found
    index = list(node.outputs).index(found.output)
    if count <= 0:
        return Input(first.inputs[index + 1], found.contexts)
    return Input(node.inputs[index], (*found.contexts, Context(node, count - 1)))


def _repeat_input(trees: Trees, found: Source, depth: int) -> Handed:
    """The value of the iteration before, or that of the zone's input node in the first one."""
    node = found.node
    at = _innermost(found.contexts, 'REPEAT_OUTPUT')
    while at is not None and found.contexts[at].node != node.paired_output:
        at = _innermost(found.contexts[:at], 'REPEAT_OUTPUT')
    if at is None:
        return None
    zone, outside = found.contexts[at], found.contexts[:at]
    index = list(node.outputs).index(found.output)
    if index == 0:
        return Constant(zone.iteration, 'INT')
    if zone.iteration == 0:
        return Input(node.inputs[index], outside)
    return Input(zone.node.inputs[index - 1], (*outside, replace(zone, iteration=zone.iteration - 1)))


def _menu_switch(trees: Trees, found: Source, depth: int) -> Handed:
    node = found.node
    choice = _chosen(trees, Input(node.inputs[0], found.contexts), depth)
    if isinstance(choice, Source):
        return found
    names = [item.name for item in node.enum_items]
    index = list(node.outputs).index(found.output)
    if choice not in names:
        return None
    if index > 0:
        return Constant(names[index - 1] == choice, 'BOOLEAN')
    return Input(node.inputs[names.index(choice) + 1], found.contexts)


def _evaluate_closure(trees: Trees, found: Source, depth: int) -> Handed:
    node = found.node
    closure = _chosen(trees, Input(node.inputs[0], found.contexts), depth)
    if isinstance(closure, Source) and closure.node.type == 'NodeClosureOutput':
        if any(context.node == node for context in found.contexts):
            return None  # it evaluates itself
        inside = (*closure.contexts, Context(node, caller=found.contexts))
        return _by_name(closure.node.inputs, found, inside)
    inner = next((link.from_socket for link in node.internal_links if link.to_socket == found.output), None)
    return None if inner is None else Input(inner, found.contexts)


def _closure_input(trees: Trees, found: Source, depth: int) -> Handed:
    at = _innermost(found.contexts, 'NodeEvaluateClosure')
    if at is None:
        return None
    context = found.contexts[at]
    return _by_name(list(context.node.inputs)[1:], found, context.caller)


def _separate_bundle(trees: Trees, found: Source, depth: int) -> Handed:
    bundle = _chosen(trees, Input(found.node.inputs[0], found.contexts), depth)
    if isinstance(bundle, Source) and bundle.node.type == 'NodeCombineBundle':
        return _by_name(bundle.node.inputs, found, bundle.contexts)
    return None


def _chosen(trees: Trees, target: Input, depth: int) -> Source | Value:
    """The constant at an input that decides where to go on, or the node that gives it."""
    if depth == NESTED_MAX:
        return ZEROS['INT']
    found = _found(trees, target, depth + 1)
    if isinstance(found, Source):
        return found
    return found.value if isinstance(found, Constant) else own_value(found.socket)


def _innermost(contexts: tuple[Context, ...], kind: str) -> int | None:
    return next((at for at in reversed(range(len(contexts))) if contexts[at].node.type == kind), None)


def _by_identifier(
    sockets: bpy.types.bpy_prop_collection, found: Source, contexts: tuple[Context, ...]
) -> Input | None:
    wanted = found.output.identifier
    return next((Input(socket, contexts) for socket in sockets if socket.identifier == wanted), None)


def _by_name(
    sockets: bpy.types.bpy_prop_collection | list[bpy.types.NodeSocket],
    found: Source,
    contexts: tuple[Context, ...],
) -> Input | None:
    return next((Input(socket, contexts) for socket in sockets if socket.name == found.output.name), None)


HANDING: dict[str, Callable[[Trees, Source, int], Handed]] = {
    'GROUP': _group,
    'GROUP_INPUT': _group_input,
    'REPEAT_OUTPUT': _repeat_output,
    'REPEAT_INPUT': _repeat_input,
    'MENU_SWITCH': _menu_switch,
    'NodeEvaluateClosure': _evaluate_closure,
    'NodeClosureInput': _closure_input,
    'NodeSeparateBundle': _separate_bundle,
    'VALUE': lambda trees, found, depth: Constant(found.output.default_value, 'VALUE'),
    'RGB': lambda trees, found, depth: Constant(own_value(found.output), 'RGBA', folded=False),
    'INPUT_INT': lambda trees, found, depth: Constant(found.node.integer, 'INT'),
    'INPUT_BOOL': lambda trees, found, depth: Constant(found.node.boolean, 'BOOLEAN'),
    'INPUT_VECTOR': lambda trees, found, depth: Constant(tuple(found.node.vector), 'VECTOR'),
}
