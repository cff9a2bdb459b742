# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles as a measuring instrument for shader nodes: one facet a pixel, which carries the node's inputs as attributes.

What the node puts out is written as it is, to a pass of its own (AOV). It knows nothing of Cotorra.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from render_calls import read_exr

WIDTH = 128  # of the picture, pixels


@dataclass(frozen=True)
class Node:
    """A node, its properties, the socket of each argument ('' for one that the node does not have) and its output,
    or three that together are a vector.

    Names of sockets are Blender's identifiers. `kinds` tells numbers (f) from vectors (v).
    """

    type: str
    kinds: str
    sockets: Sequence[str]
    outputs: Sequence[str]
    properties: dict[str, Any] = field(default_factory=dict)
    prepare: Callable[[Any], None] | None = None


def _attribute(tree: bpy.types.NodeTree, index: int) -> bpy.types.NodeSocket:
    node = tree.nodes.new('ShaderNodeAttribute')
    node.attribute_name = f'in{index}'
    return node.outputs['Fac']


def _socket(sockets: Any, identifier: str) -> bpy.types.NodeSocket:
    (found,) = [socket for socket in sockets if socket.identifier == identifier]
    return found


def _material(node: Node) -> bpy.types.Material:
    material = bpy.data.materials.new(node.type)
    tree = material.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new('ShaderNodeEmission')
    tree.links.new(emission.outputs['Emission'], tree.nodes.new('ShaderNodeOutputMaterial').inputs['Surface'])
    made = tree.nodes.new(node.type)
    for name, value in node.properties.items():
        setattr(made, name, value)
    if node.prepare:
        node.prepare(made)
    offset = 0
    for kind, identifier in zip(node.kinds, node.sockets, strict=True):
        if identifier and kind == 'f':
            tree.links.new(_attribute(tree, offset), _socket(made.inputs, identifier))
        elif identifier:
            combine = tree.nodes.new('ShaderNodeCombineXYZ')
            for axis in range(3):
                tree.links.new(_attribute(tree, offset + axis), combine.inputs[axis])
            tree.links.new(combine.outputs['Vector'], _socket(made.inputs, identifier))
        offset += 3 if kind == 'v' else 1
    aov = tree.nodes.new('ShaderNodeOutputAOV')
    aov.aov_name = 'result'
    if len(node.outputs) == 1:
        tree.links.new(_socket(made.outputs, node.outputs[0]), aov.inputs['Color'])
        return material
    combine = tree.nodes.new('ShaderNodeCombineXYZ')
    for axis, output in enumerate(node.outputs):
        tree.links.new(_socket(made.outputs, output), combine.inputs[axis])
    tree.links.new(combine.outputs['Vector'], aov.inputs['Color'])
    return material


def _facets(inputs: np.ndarray, of_material: np.ndarray, height: int, normals: np.ndarray | None) -> bpy.types.Mesh:
    count = WIDTH * height
    y, x = np.divmod(np.arange(count), WIDTH)
    corner = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    corners = np.zeros((count, 4, 3))
    corners[..., :2] = np.stack([x, y], -1)[:, None, :] + 0.5 + corner[None]
    if normals is not None:
        corners[: len(normals), :, 2] = -(normals[:, None, :2] * corner[None]).sum(-1) / normals[:, None, 2]
    mesh = bpy.data.meshes.new('facets')
    mesh.from_pydata(corners.reshape(-1, 3).tolist(), [], np.arange(4 * count).reshape(-1, 4).tolist())
    for index in range(inputs.shape[1]):
        values = np.zeros(count, np.float32)
        values[: len(inputs)] = inputs[:, index]
        mesh.attributes.new(f'in{index}', 'FLOAT', 'FACE').data.foreach_set('value', values)
    slots = np.zeros(count, np.int32)
    slots[: len(inputs)] = of_material
    mesh.polygons.foreach_set('material_index', slots)
    return mesh


def _scene(mesh: bpy.types.Mesh, height: int) -> bpy.types.Scene:
    scene = bpy.context.scene
    scene.collection.objects.link(bpy.data.objects.new('facets', mesh))
    camera = bpy.data.cameras.new('camera')
    camera.type, camera.ortho_scale, camera.clip_end = 'ORTHO', float(max(WIDTH, height)), 1000.0
    eye = bpy.data.objects.new('camera', camera)
    eye.location = (WIDTH / 2, height / 2, 500.0)
    scene.collection.objects.link(eye)
    scene.camera = eye
    scene.view_layers[0].aovs.add().name = 'result'
    render, cycles = scene.render, scene.cycles
    render.engine = 'CYCLES'
    render.resolution_x, render.resolution_y = WIDTH, height
    render.threads_mode, render.threads = 'FIXED', 2
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 1, False, False
    cycles.max_bounces = 0
    cycles.pixel_filter_type, cycles.filter_width = 'GAUSSIAN', 0.01
    image = render.image_settings
    image.media_type = 'MULTI_LAYER_IMAGE'
    image.file_format, image.color_depth = 'OPEN_EXR_MULTILAYER', '32'
    return scene


def render(
    nodes: Sequence[Node], inputs: Sequence[np.ndarray], path: Path, normals: np.ndarray | None = None
) -> list[np.ndarray]:
    """What each node puts out, (n, 3), for its (n, k) inputs; all in one picture.

    normals: of the facets, (n, 3) for all inputs one after the other, z above 0; without, all face the viewer.
    Attributes arrive as the third part of three times their value: exact where it has at most 22 binary digits.
    """
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    width = max(array.shape[1] for array in inputs)
    every = np.concatenate([np.pad(array, ((0, 0), (0, width - array.shape[1]))) for array in inputs])
    counts = [len(array) for array in inputs]
    height = max(-(-len(every) // WIDTH), 4)  # Blender renders no less
    mesh = _facets(every, np.repeat(np.arange(len(nodes)), counts), height, normals)
    for node in nodes:
        mesh.materials.append(_material(node))
    scene = _scene(mesh, height)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    (layer,) = [channels for name, channels in read_exr(path).items() if name.endswith('result')]
    pixels = np.stack([layer[channel][::-1].ravel() for channel in 'RGB'], -1)
    return np.split(pixels[: len(every)], np.cumsum(counts)[:-1])
