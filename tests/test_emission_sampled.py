# SPDX-License-Identifier: GPL-3.0-or-later
"""Emission that depends on what a ray is: light samples of a mesh light what rays that find it would, node by node.

Light samples change the noise and not the picture: ours with them is Cycles' without them (emission sampling "None"),
since Cycles' samples see no occlusion, no ray cast and no bump. What nodes are where rays meet them is told elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import stats

from beside_cycles import in_halves
from flat_scenes import node
from scenes import build

pytestmark = [
    pytest.mark.usefixtures('engine'),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='the nodes are those of Blender 5.2'),
]

SIZE = (24, 24)
SAMPLES = 96  # of each half
# What both engines' means may differ by beside four times their noise.
LIMIT = 0.01

Tree = bpy.types.NodeTree
Value = Callable[[Tree], bpy.types.NodeSocket]


def output(kind: str, name: str, **values: object) -> Value:
    """The absolute value of an output of a node, of vectors the first number and of normals the last."""

    def made(tree: Tree) -> bpy.types.NodeSocket:
        found = node(tree, kind, **values)
        return number(tree, found.outputs[name], 'Z' if 'Normal' in name else 'X')

    return made


def number(tree: Tree, socket: bpy.types.NodeSocket, part: str) -> bpy.types.NodeSocket:
    if socket.type == 'VECTOR':
        parts = node(tree, 'SeparateXYZ')
        tree.links.new(socket, parts.inputs[0])
        socket = parts.outputs[part]
    size = node(tree, 'Math', operation='ABSOLUTE')
    tree.links.new(socket, size.inputs[0])
    return size.outputs[0]


def cast(name: str) -> Value:
    def made(tree: Tree) -> bpy.types.NodeSocket:
        found = node(tree, 'Raycast')
        found.inputs['Direction'].default_value = (0.1, 0.0, -1.0)
        found.inputs['Length'].default_value = 2.5
        return found.outputs[name]

    return made


def bumped(tree: Tree) -> bpy.types.NodeSocket:
    """How far a normal that waves bend leans aside."""
    bump, wave = node(tree, 'Bump'), node(tree, 'TexWave')
    bump.inputs['Distance'].default_value = 0.3
    tree.links.new(node(tree, 'NewGeometry').outputs['Position'], wave.inputs['Vector'])
    tree.links.new(wave.outputs['Fac'], bump.inputs['Height'])
    return number(tree, bump.outputs['Normal'], 'X')


def bent_weight(tree: Tree) -> bpy.types.NodeSocket:
    found = node(tree, 'LayerWeight')
    bump, wave = node(tree, 'Bump'), node(tree, 'TexWave')
    tree.links.new(node(tree, 'NewGeometry').outputs['Position'], wave.inputs['Vector'])
    tree.links.new(wave.outputs['Fac'], bump.inputs['Height'])
    tree.links.new(bump.outputs['Normal'], found.inputs['Normal'])
    return found.outputs['Facing']


VALUES: dict[str, Value] = {
    'occlusion': output('AmbientOcclusion', 'AO', Distance=2.0),
    'occlusion, inside': output('AmbientOcclusion', 'AO', inside=True),
    'bevel': output('Bevel', 'Normal', Radius=0.5),
    'raycast': cast('Is Hit'),
    'raycast, distance': cast('Hit Distance'),
    'ray length': output('LightPath', 'Ray Length'),
    'ray depth': output('LightPath', 'Ray Depth'),
    'camera ray': output('LightPath', 'Is Camera Ray'),
    'layer weight, fresnel': output('LayerWeight', 'Fresnel', Blend=0.3),
    'layer weight, facing': output('LayerWeight', 'Facing', Blend=0.3),
    'layer weight, bent': bent_weight,
    'fresnel': output('Fresnel', 'Factor'),
    'camera, vector': output('CameraData', 'View Vector'),
    'camera, depth': output('CameraData', 'View Z Depth'),
    'camera, distance': output('CameraData', 'View Distance'),
    'incoming': output('NewGeometry', 'Incoming'),
    'backfacing': output('NewGeometry', 'Backfacing'),
    'window': output('TexCoord', 'Window'),
    'camera coordinates': output('TexCoord', 'Camera'),
    'reflection': output('TexCoord', 'Reflection'),
    'bump': bumped,
    'wireframe': output('Wireframe', 'Factor', Size=0.2),
}


def scene_of(value: Value) -> bpy.types.Scene:
    """A floor, above it a leaning square that shines, and a box that hides part of it. The camera sees the floor."""
    scene = build.new_scene()
    floor = bpy.data.materials.new('Floor')
    build.mesh_object(scene, 'Floor', vertices=[(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)]).data.materials.append(
        build.with_nodes(floor)
    )
    material = build.with_nodes(bpy.data.materials.new('Glow'))
    tree = material.node_tree
    tree.nodes.clear()
    shine = node(tree, 'Emission')
    shine.inputs['Strength'].default_value = 4.0
    tree.links.new(value(tree), shine.inputs['Color'])
    tree.links.new(shine.outputs[0], node(tree, 'OutputMaterial').inputs['Surface'])
    bpy.ops.mesh.primitive_plane_add(size=2, location=(0, 0, 2), rotation=(0.3, 0.2, 0))
    bpy.context.object.data.materials.append(material)
    bpy.ops.mesh.primitive_cube_add(size=0.7, location=(0.4, 0.3, 1.7))
    bpy.context.object.data.materials.append(floor)
    camera = build.camera(scene)
    camera.location, camera.rotation_euler = (0, -3.5, 1.2), (0.9, 0, 0)
    return scene


@pytest.mark.every(2)
@pytest.mark.parametrize('name', VALUES)
def test_light_samples_change_the_noise_only(name: str, tmp_path: Path) -> None:
    scene = scene_of(VALUES[name])
    ours = in_halves(scene, 'COTORRA', tmp_path, 1, SIZE, SAMPLES)
    warnings = [text for layer in stats.last(scene.name) for text in layer.warnings]
    bpy.data.materials['Glow'].cycles.emission_sampling = 'NONE'
    theirs = in_halves(scene, 'CYCLES', tmp_path, 1, SIZE, SAMPLES)
    mine, other = ours.image.mean(), theirs.image.mean()
    noise = np.sqrt(ours.variance.sum() + theirs.variance.sum()) / ours.image.size
    named = ['Ambient Occlusion'] if name.startswith('occlusion') else []
    assert [text.partition('emission by ')[2].partition(':')[0] for text in warnings] == named
    assert abs(mine - other) <= LIMIT * other + 4.0 * noise + 1e-6, (mine, other, noise)
