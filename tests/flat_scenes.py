# SPDX-License-Identifier: GPL-3.0-or-later
"""A square that fills a few pixels and shines with what its node tree says: its colour tells what was read.

Both engines take hundredths of a second for it. What is right is said in the tests.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from cotorra import compat, stats

import render_calls
from scenes import build

OWN = (0.25, 0.5, 0.75, 1.0)  # the colour typed into the Emission


@dataclass
class Flat:
    """obj: the square. links: a shorthand."""

    scene: bpy.types.Scene
    obj: bpy.types.Object
    tree: bpy.types.NodeTree
    emission: bpy.types.Node
    output: bpy.types.Node

    def node(self, kind: str, **values: object) -> bpy.types.Node:
        return node(self.tree, kind, **values)

    def link(self, start: bpy.types.NodeSocket, end: bpy.types.NodeSocket) -> bpy.types.NodeLink:
        return self.tree.links.new(start, end)


def node(tree: bpy.types.NodeTree, kind: str, **values: object) -> bpy.types.Node:
    made = tree.nodes.new(kind if kind.startswith(('Node', 'Geometry', 'Function')) else f'ShaderNode{kind}')
    for name, value in values.items():  # of inputs, or of what the node is set to
        if name in made.inputs:
            made.inputs[name].default_value = value
        else:
            setattr(made, name, value)
    return made


def shining(name: str, color: tuple[float, ...] = OWN) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    compat.principled(material)
    tree = material.node_tree
    tree.nodes.clear()
    emission, output = node(tree, 'Emission', name='Shine'), node(tree, 'OutputMaterial', name='Out')
    emission.inputs['Color'].default_value = (*color[:3], 1.0)
    tree.links.new(emission.outputs[0], output.inputs['Surface'])
    return material


def flat() -> Flat:
    scene = build.new_scene()
    data = bpy.data.meshes.new('Square')
    data.from_pydata([(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)], [], [(0, 1, 2, 3)])
    uv = data.uv_layers.new(name='UVMap').uv
    for entry, place in zip(uv, ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True):
        entry.vector = place
    obj = build.link(scene, 'Square', data)
    build.camera(scene).location = (0, 0, 3)
    material = shining('Material')
    data.materials.append(material)
    tree = material.node_tree
    return Flat(scene, obj, tree, tree.nodes['Shine'], tree.nodes['Out'])


def shown(engine: str, folder: Path) -> tuple[np.ndarray, list[str]]:
    """The colour in the middle, and what Cotorra warned of."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.resolution_percentage = 100
    scene.cycles.samples = scene.cotorra.samples = 1
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cotorra.use_sample_sharing = False  # four pixels together choose well among what is mixed
    path = render_calls.render_to(scene, folder / f'{engine}.exr')
    channels = render_calls.read_exr(path)['']
    color = np.array([channels[name][1:3, 1:3].mean() for name in 'RGB'])
    warnings = [text for layer in stats.last(scene.name) for text in layer.warnings] if engine == 'COTORRA' else []
    return color, warnings


def assert_as_cycles(folder: Path, tolerance: float = 2e-3, which: str = '') -> tuple[float, ...]:
    """Returns the colour. tolerance: half floats and bytes on the way. Cotorra has nothing to say, either."""
    mine, warnings = shown('COTORRA', folder)
    theirs, _ = shown('CYCLES', folder)
    assert not warnings, which
    # Surfaces that take light away are another matter than what feeds them.
    mine, theirs = np.maximum(mine, 0.0), np.maximum(theirs, 0.0)
    np.testing.assert_allclose(mine, theirs, rtol=tolerance, atol=tolerance, err_msg=which)
    return tuple(theirs)


def group(
    name: str,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    fill: Callable[[bpy.types.NodeTree, bpy.types.Node, bpy.types.Node], None] | None = None,
) -> bpy.types.NodeTree:
    """A group whose sockets have these types (Color, Float …); fill: takes it with its input and its output node."""
    tree = bpy.data.node_groups.new(name, 'ShaderNodeTree')
    for kinds, direction in ((inputs, 'INPUT'), (outputs, 'OUTPUT')):
        for index, kind in enumerate(kinds):
            tree.interface.new_socket(f'{kind}{index}', in_out=direction, socket_type=f'NodeSocket{kind}')
    start, end = node(tree, 'NodeGroupInput'), node(tree, 'NodeGroupOutput')
    if fill is not None:
        fill(tree, start, end)
    return tree


def through(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
    """What a group is filled with that hands on its first input."""
    tree.links.new(start.outputs[0], end.inputs[0])
