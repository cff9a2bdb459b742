# SPDX-License-Identifier: GPL-3.0-or-later
"""Random node trees of what hands on values (groups, reroutes, muted nodes, menus, zones) and a little arithmetic.

They are what Cycles and Cotorra must agree about; they are compared in test_node_walks.py.
"""

from __future__ import annotations

import random

import bpy

from flat_scenes import Flat, flat, node

KINDS = ('Color', 'Float', 'Int', 'Bool', 'Vector')
DEPTH_MAX = 3  # of groups in groups


class Forest:
    """Trees from one seed. groups: those made so far, which are used again."""

    def __init__(self, seed: int) -> None:
        self.dice = random.Random(seed)
        self.groups: list[bpy.types.NodeTree] = []

    def scene(self) -> Flat:
        made = flat()
        found = self.fill(made.tree, [], 0)
        targets = [made.emission.inputs['Color']] * 2 + [made.emission.inputs['Strength'], made.output.inputs[0]]
        if found:
            made.link(self.look(made.tree, self.dice.choice(found[-3:])), self.dice.choice(targets))
        return made

    def fill(self, tree: bpy.types.NodeTree, given: list[tuple[str, str]], depth: int) -> list[tuple[str, str]]:
        """Add nodes; returns outputs as (node, identifier): sockets move in memory."""
        found = list(given)
        for _ in range(self.dice.randint(2, 7)):
            made = self.made(tree, found, depth)
            if made is None:
                continue
            if made.type != 'REROUTE' and self.dice.random() < 0.2:
                made.mute = True
            self.feed(tree, made, found)
            found += [(made.name, out.identifier) for out in made.outputs if out.enabled and out.type != 'CUSTOM']
        return found

    def made(self, tree: bpy.types.NodeTree, found: list, depth: int) -> bpy.types.Node | None:
        dice = self.dice
        match dice.choice(('rgb', 'value', 'value', 'math', 'mix', 'reroute', 'reroute', 'group', 'menu', 'repeat')):
            case 'rgb':
                made = node(tree, 'RGB')
                self.type_in(made.outputs[0])
            case 'value':
                made = node(tree, 'Value')
                self.type_in(made.outputs[0])
            case 'math':
                made = node(tree, 'Math', operation=dice.choice(('ADD', 'SUBTRACT', 'MULTIPLY')))
            case 'mix':
                blend = dice.choice(('MIX', 'ADD', 'MULTIPLY'))
                made = node(tree, 'Mix', data_type=dice.choice(('RGBA', 'FLOAT')), blend_type=blend)
            case 'reroute':
                made = node(tree, 'NodeReroute')
            case 'menu':
                made = node(tree, 'GeometryNodeMenuSwitch', data_type=dice.choice(('RGBA', 'FLOAT', 'VECTOR')))
                made.inputs[0].default_value = dice.choice('AB')
            case 'repeat':
                return self.repeat(tree, found)
            case _:
                if depth == DEPTH_MAX:
                    return None
                inner = dice.choice(self.groups) if self.groups and dice.random() < 0.5 else self.group(depth + 1)
                made = node(tree, 'Group', node_tree=inner)
        return made

    def repeat(self, tree: bpy.types.NodeTree, found: list) -> None:
        """A zone that adds a quarter, or the number of the iteration, to one of its values."""
        dice = self.dice
        start, end = node(tree, 'GeometryNodeRepeatInput'), node(tree, 'GeometryNodeRepeatOutput')
        start.pair_with_output(end)
        end.repeat_items.clear()
        end.repeat_items.new(dice.choice(('FLOAT', 'RGBA', 'VECTOR')), 'a')
        end.repeat_items.new(dice.choice(('FLOAT', 'RGBA')), 'b')
        self.feed(tree, start, found)
        start.inputs[0].default_value = dice.randint(0, 3)
        step = node(tree, 'Math', operation='ADD')
        step.inputs[1].default_value = 0.25
        tree.links.new(start.outputs[dice.randint(0, 2)], step.inputs[0])
        if dice.random() < 0.5:
            tree.links.new(start.outputs[0], step.inputs[1])
        tree.links.new(step.outputs[0], end.inputs[0])
        tree.links.new(start.outputs[1], end.inputs[1])
        found += [(end.name, out.identifier) for out in end.outputs if out.type != 'CUSTOM']

    def group(self, depth: int) -> bpy.types.NodeTree:
        dice = self.dice
        tree = bpy.data.node_groups.new('Group', 'ShaderNodeTree')
        for direction in ('INPUT', 'OUTPUT'):
            for index in range(dice.randint(1, 2)):
                kind = f'NodeSocket{dice.choice(KINDS)}'
                tree.interface.new_socket(f'{direction}{index}', in_out=direction, socket_type=kind)
        start, end = node(tree, 'NodeGroupInput'), node(tree, 'NodeGroupOutput')
        if dice.random() < 0.3:
            node(tree, 'NodeGroupOutput', is_active_output=dice.random() < 0.5)
        given = [(start.name, out.identifier) for out in start.outputs if out.type != 'CUSTOM']
        found = self.fill(tree, given, depth)
        self.feed(tree, end, found[-3:], often=0.85)
        self.groups.append(tree)
        return tree

    def feed(self, tree: bpy.types.NodeTree, made: bpy.types.Node, found: list, often: float = 0.5) -> None:
        for target in made.inputs:
            if not target.enabled or target.type in ('CUSTOM', 'MENU') or made.type + target.type == 'REPEAT_INPUTINT':
                continue
            self.type_in(target)
            if found and self.dice.random() < often:
                link = tree.links.new(self.look(tree, self.dice.choice(found)), target)
                link.is_muted = self.dice.random() < 0.1

    def type_in(self, target: bpy.types.NodeSocket) -> None:
        dice = self.dice
        if target.type in ('RGBA', 'VECTOR'):
            least = 0.0 if target.type == 'RGBA' else -1.0
            target.default_value = [round(dice.uniform(least, 2.0), 2) for _ in target.default_value]
        elif target.type == 'VALUE':
            target.default_value = round(dice.uniform(-1.0, 3.0), 2)
        elif target.type == 'INT':
            target.default_value = dice.randint(-1, 3)
        elif target.type == 'BOOLEAN':
            target.default_value = dice.random() < 0.5

    @staticmethod
    def look(tree: bpy.types.NodeTree, name: tuple[str, str]) -> bpy.types.NodeSocket:
        return next(out for out in tree.nodes[name[0]].outputs if out.identifier == name[1])
