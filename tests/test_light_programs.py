# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights whose node trees vary: by distance, direction, place on the light, bounce, and measured files, beside Cycles.

How nodes become ops is test_shader_nodes.py's, and what an IES file says test_ies.py's.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi, radians
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat

from flat_scenes import node
from ies_files import STREET
from light_scenes import assert_as_cycles, ball, box, corner, hang
from scenes import build

pytestmark = [
    pytest.mark.usefixtures('engine'),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='the nodes are those of Blender 5.2'),
]

Tree = Callable[[bpy.types.NodeTree], bpy.types.NodeSocket]


def emission(obj: bpy.types.Object, tree: Tree, socket: str = 'Color') -> None:
    """Links what `tree` makes to the light's emission."""
    nodes = build.with_nodes(obj.data).node_tree
    shine = next(found for found in nodes.nodes if found.type == 'EMISSION')
    nodes.links.new(tree(nodes), shine.inputs[socket])


def falloff(output: str, smooth: float = 0.0) -> Tree:
    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        found = node(tree, 'LightFalloff')
        found.inputs['Strength'].default_value, found.inputs['Smooth'].default_value = 0.5, smooth
        return found.outputs[output]

    return made


def checker(kind: str, output: str, scale: float = 5.0) -> Tree:
    """A pattern over an output of a node."""

    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        found = node(tree, 'TexChecker')
        found.inputs['Color1'].default_value = (1.0, 0.3, 0.1, 1.0)
        found.inputs['Color2'].default_value = (0.1, 0.4, 1.0, 1.0)
        found.inputs['Scale'].default_value = scale
        # A little aside, so that nothing lies on an edge of the pattern.
        aside = node(tree, 'VectorMath', operation='ADD')
        aside.inputs[1].default_value = (0.013, 0.027, 0.041)
        tree.links.new(node(tree, kind).outputs[output], aside.inputs[0])
        tree.links.new(aside.outputs[0], found.inputs['Vector'])
        return found.outputs['Color']

    return made


def number(kind: str, output: str, scale: float = 0.3) -> Tree:
    """A number of a node, times `scale`."""

    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        found = node(tree, 'Math', operation='MULTIPLY_ADD')
        found.inputs[1].default_value, found.inputs[2].default_value = scale, 0.1
        tree.links.new(node(tree, kind).outputs[output], found.inputs[0])
        return found.outputs[0]

    return made


def length(kind: str, output: str, scale: float = 0.3) -> Tree:
    """The length of the absolute value of a vector, coloured by its parts."""

    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        found = node(tree, 'VectorMath', operation='ABSOLUTE')
        tree.links.new(node(tree, kind).outputs[output], found.inputs[0])
        scaled = node(tree, 'VectorMath', operation='SCALE')
        scaled.inputs['Scale'].default_value = scale
        tree.links.new(found.outputs[0], scaled.inputs[0])
        return scaled.outputs[0]

    return made


def gobo(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """An image over the light's UV map."""
    image = bpy.data.images.new('Gobo', 16, 16, float_buffer=True)
    x, y = np.meshgrid(np.arange(16) / 16, np.arange(16) / 16)
    pixels = np.ones((16, 16, 4), np.float32)
    pixels[..., 0], pixels[..., 1], pixels[..., 2] = x, y, 0.5 + 0.5 * np.sin(12 * x) * np.sin(9 * y)
    image.pixels.foreach_set(pixels.ravel())
    return node(tree, 'TexImage', image=image).outputs['Color']


def measured(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    text = bpy.data.texts.new('Street')
    text.write(STREET)
    found = node(tree, 'TexIES', mode='INTERNAL', ies=text)
    found.inputs['Strength'].default_value = 0.02
    return found.outputs['Fac']


POINT = {'kind': 'POINT', 'shadow_soft_size': 0.2, 'rotation': (0.4, 0.3, 0.2), 'scale': (1.0, 2.0, 0.5)}
HARD = {**POINT, 'shadow_soft_size': 0.0}
SPHERE = {**POINT, 'use_soft_falloff': False, 'scale': (1, 1, 1)}
SPOT = {'kind': 'SPOT', 'shadow_soft_size': 0.05, 'spot_size': radians(70), 'spot_blend': 0.2, 'energy': 300.0}
STRETCHED = {**SPOT, 'scale': (1.5, 0.7, 1.0)}
SUN = {'kind': 'SUN', 'energy': 2.0, 'angle': 0.6, 'rotation': (0.5, 0.4, 0.1)}
AREA = {'kind': 'AREA', 'shape': 'RECTANGLE', 'size': 1.6, 'size_y': 0.8, 'location': (0.2, 0.2, 1.2)}

CASES: dict[str, tuple[dict[str, object], Tree, str]] = {
    'falloff, linear': (POINT, falloff('Linear'), 'Strength'),
    'falloff, constant': (SPOT, falloff('Constant'), 'Strength'),
    'falloff, quadratic and smooth': (HARD, falloff('Quadratic', 3.0), 'Strength'),
    'falloff, linear and smooth, area': (AREA, falloff('Linear', 2.0), 'Strength'),
    'falloff of a sun': (SUN, falloff('Constant', 2.0), 'Strength'),
    'normal, point': (HARD, checker('TexCoord', 'Normal'), 'Color'),
    'normal, sphere': (SPHERE, checker('TexCoord', 'Normal'), 'Color'),
    'normal, spot': (SPOT, checker('TexCoord', 'Normal', 15.0), 'Color'),
    'UV, point': (HARD, checker('TexCoord', 'UV', 12.0), 'Color'),
    'UV, spot': (SPOT, gobo, 'Color'),
    'UV, spot, stretched': (STRETCHED, gobo, 'Color'),
    'UV, area': (AREA, gobo, 'Color'),
    'UV, sun': (SUN, gobo, 'Color'),
    'parametric, area': (AREA, checker('NewGeometry', 'Parametric'), 'Color'),
    'object, area': ({**AREA, 'scale': (0.6, 1.4, 1.0)}, checker('TexCoord', 'Object'), 'Color'),
    'generated, area': (AREA, checker('TexCoord', 'Generated'), 'Color'),
    'camera, area': (AREA, checker('TexCoord', 'Camera', 3.0), 'Color'),
    'reflection, area': (AREA, length('TexCoord', 'Reflection', 1.0), 'Color'),
    'position, sphere': (SPHERE, length('NewGeometry', 'Position'), 'Color'),
    'incoming, spot': (SPOT, length('NewGeometry', 'Incoming', 1.0), 'Color'),
    'location': (POINT, length('ObjectInfo', 'Location'), 'Color'),
    'ray length': (POINT, number('LightPath', 'Ray Length'), 'Strength'),
    # Where bounces meet the light, Cycles mixes what it sends at their depth with what it sends a bounce before.
    'ray depth': (HARD, number('LightPath', 'Ray Depth', 1.0), 'Strength'),
    'camera ray': (AREA, number('LightPath', 'Is Camera Ray', 5.0), 'Strength'),
    'diffuse depth': (HARD, number('LightPath', 'Diffuse Depth', 2.0), 'Strength'),
    'facing, area': (AREA, number('LayerWeight', 'Facing', 1.0), 'Strength'),
    'measured, point': ({**HARD, 'scale': (1, 1, 1), 'energy': 20.0}, measured, 'Strength'),
    'measured, spot': ({**SPOT, 'spot_size': pi, 'energy': 20.0}, measured, 'Strength'),
}


def lit_by(light: dict[str, object], tree: Tree, socket: str) -> bpy.types.Scene:
    scene = corner()
    box(scene)
    emission(hang(scene, **light), tree, socket)
    return scene


@pytest.mark.every(4)
@pytest.mark.parametrize('name', CASES)
def test_a_light_that_varies_is_as_cycles_shows_it(name: str, tmp_path: Path) -> None:
    assert_as_cycles(lit_by(*CASES[name]), tmp_path)


SEEN: dict[str, tuple[dict[str, object], Tree, str]] = {
    'area': ({**AREA, 'rotation': (radians(70), 0.3, 0)}, gobo, 'Color'),
    'sphere': ({**SPHERE, 'shadow_soft_size': 0.5}, checker('TexCoord', 'Normal'), 'Color'),
    'falloff': ({**SPHERE, 'shadow_soft_size': 0.5}, falloff('Linear'), 'Strength'),
}


@pytest.mark.parametrize('name', SEEN)
def test_it_is_seen_by_the_camera_and_in_a_mirror(name: str, tmp_path: Path) -> None:
    light, tree, socket = SEEN[name]
    scene = corner({'Metallic': 1.0, 'Roughness': 0.1})
    ball(scene, Metallic=1.0, Roughness=0.0)
    # In a black world a few rays make all of what dark mirrors show, and halves tell little of that noise.
    scene.world = bpy.data.worlds.new('World')
    compat.background(scene.world).inputs['Color'].default_value = (0.05, 0.05, 0.05, 1.0)
    emission(hang(scene, **{**light, 'location': (0, 1.0, 1.2)}, seen=True), tree, socket)
    assert_as_cycles(scene, tmp_path)


def test_many_lights_of_which_some_vary(tmp_path: Path) -> None:
    """Those that vary are picked like the others."""
    scene = corner()
    for k in range(12):
        obj = hang(
            scene, 'POINT', location=(k % 4 - 1.5, k // 4 - 1.0, 0.6 + 0.2 * k), energy=10.0, shadow_soft_size=0.1
        )
        if k % 3 == 0:
            emission(obj, checker('TexCoord', 'Normal'))
    assert_as_cycles(scene, tmp_path)
