# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes of Blender data for tests, built without files and without operators that need a window.

What a test expects of them stands in the test.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import bpy
import numpy as np
from cotorra import compat

QUAD = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


def new_scene() -> bpy.types.Scene:
    """An empty file's scene, without camera, world and objects, and without what hides the noise of Cycles' renders."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    cycles = bpy.context.scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = 64, False, False
    cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0  # by which weak shadow rays are traced at random: noise where there is none
    # A test that names no size of its own renders a small picture, not Blender's of 1920 x 1080.
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = 64, 36
    return bpy.context.scene


def link(scene: bpy.types.Scene, name: str, data: bpy.types.ID | None) -> bpy.types.Object:
    obj = bpy.data.objects.new(name, data)
    scene.collection.objects.link(obj)
    return obj


def mesh(
    name: str = 'Quad',
    vertices: Sequence[Sequence[float]] = QUAD,
    faces: Sequence[Sequence[int]] = ((0, 1, 2, 3),),
    smooth: bool = False,
) -> bpy.types.Mesh:
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, [], faces)
    if smooth:
        data.shade_smooth()
    return data


def mesh_object(scene: bpy.types.Scene, name: str = 'Quad', **shape: Any) -> bpy.types.Object:
    return link(scene, name, mesh(name, **shape))


def grid(segments: int) -> bpy.types.Mesh:
    """A square of segments × segments quads with a UV map, row by row."""
    side = segments + 1
    places = np.arange(side * side)
    uv = np.stack([places % side, places // side], axis=1).astype(np.float32) / segments
    first = (np.arange(segments)[:, None] * side + np.arange(segments)).reshape(-1, 1)
    corners = (first + np.array([0, 1, side + 1, side])).ravel().astype(np.int32)
    data = bpy.data.meshes.new('Grid')
    data.vertices.add(len(places))
    data.loops.add(len(corners))
    data.polygons.add(len(first))
    data.polygons.foreach_set('loop_start', np.arange(0, len(corners), 4, dtype=np.int32))
    data.attributes['.corner_vert'].data.foreach_set('value', corners)
    positions = np.concatenate([2.0 * uv - 1.0, np.zeros((len(uv), 1), np.float32)], axis=1)
    data.attributes['position'].data.foreach_set('vector', positions.ravel())
    data.uv_layers.new(name='UVMap').uv.foreach_set('vector', uv[corners].ravel())
    data.update(calc_edges=True)
    data.shade_flat()
    return data


def camera(scene: bpy.types.Scene, **settings: Any) -> bpy.types.Object:
    data = bpy.data.cameras.new('Camera')
    for name, value in settings.items():
        setattr(data, name, value)
    scene.camera = link(scene, 'Camera', data)
    return scene.camera


def light(scene: bpy.types.Scene, kind: str, **settings: Any) -> bpy.types.Object:
    data = bpy.data.lights.new(kind.title(), kind)
    for name, value in settings.items():
        setattr(data, name, value)
    return link(scene, kind.title(), data)


def with_nodes(owner: bpy.types.ID) -> bpy.types.ID:
    """The owner with a node tree, which Blender 5 gives everything from the start."""
    if owner.node_tree is None:
        owner.use_nodes = True
    return owner


def material(name: str = 'Material', **inputs: Any) -> bpy.types.Material:
    """A new material; keywords set inputs of its Principled BSDF, with _ for spaces."""
    made = with_nodes(bpy.data.materials.new(name))
    node = principled(made)
    for key, value in inputs.items():
        node.inputs[key.replace('_', ' ')].default_value = value
    return made


def principled(made: bpy.types.Material) -> bpy.types.Node:
    return next(node for node in made.node_tree.nodes if node.type == 'BSDF_PRINCIPLED')


def output(tree: bpy.types.NodeTree) -> bpy.types.Node:
    return next(node for node in tree.nodes if node.type.startswith('OUTPUT_'))


def node(tree: bpy.types.NodeTree, kind: str, **inputs: Any) -> bpy.types.Node:
    """A new node, 'ShaderNode' left out of its type; keywords set inputs, with _ for spaces."""
    made = tree.nodes.new(f'ShaderNode{kind}')
    for key, value in inputs.items():
        made.inputs[key.replace('_', ' ')].default_value = value
    return made


def connect(tree: bpy.types.NodeTree, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
    tree.links.new(source, target)


def world(scene: bpy.types.Scene, color: Sequence[float] = (1, 1, 1), strength: float = 1.0) -> bpy.types.World:
    made = with_nodes(bpy.data.worlds.new('World'))
    background = next(node for node in made.node_tree.nodes if node.type == 'BACKGROUND')
    background.inputs['Color'].default_value = (*color, 1)
    background.inputs['Strength'].default_value = strength
    scene.world = made
    return made


def collection_instance(
    scene: bpy.types.Scene, name: str, members: Sequence[bpy.types.Object], unlink: bool = True
) -> bpy.types.Object:
    """An empty that shows a collection of `members`; unlink takes them out of the scene themselves."""
    collection = bpy.data.collections.new(name)
    for member in members:
        collection.objects.link(member)
        if unlink:
            scene.collection.objects.unlink(member)
    empty = link(scene, name, None)
    empty.instance_type = 'COLLECTION'
    empty.instance_collection = collection
    return empty


def vertex_instances(scene: bpy.types.Scene, shown: bpy.types.Object, points: np.ndarray) -> bpy.types.Object:
    """A parent that shows `shown` at each of the points (N, 3), and `shown` itself where it was."""
    data = bpy.data.meshes.new('Points')
    data.vertices.add(len(points))
    data.attributes['position'].data.foreach_set('vector', np.ascontiguousarray(points, np.float32).ravel())
    parent = link(scene, 'Points', data)
    parent.instance_type = 'VERTS'
    shown.parent = parent
    return parent


def geometry_nodes(target: bpy.types.Object, build: Callable[[bpy.types.NodeTree], None]) -> bpy.types.NodeTree:
    """A geometry nodes modifier on `target`; `build` adds nodes between the group's input and output."""
    tree = bpy.data.node_groups.new('Nodes', 'GeometryNodeTree')
    tree.interface.new_socket('Geometry', in_out='INPUT', socket_type='NodeSocketGeometry')
    tree.interface.new_socket('Geometry', in_out='OUTPUT', socket_type='NodeSocketGeometry')
    tree.nodes.new('NodeGroupInput').name = 'In'
    tree.nodes.new('NodeGroupOutput').name = 'Out'
    build(tree)
    target.modifiers.new('Nodes', 'NODES').node_group = tree
    return tree


def compositor(scene: bpy.types.Scene) -> bpy.types.Node:
    """Gives the scene a compositor that hands on the image of a node with render layers, which is returned."""
    if bpy.app.version >= (5, 0, 0):
        tree = scene.compositing_node_group = bpy.data.node_groups.new('Compositing', 'CompositorNodeTree')
        tree.interface.new_socket('Image', in_out='OUTPUT', socket_type='NodeSocketColor')
        end = tree.nodes.new('NodeGroupOutput')
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        end = tree.nodes.new('CompositorNodeComposite')
    layers = tree.nodes.new('CompositorNodeRLayers')
    tree.links.new(layers.outputs['Image'], end.inputs[0])
    assert compat.compositing_tree(scene) == tree
    return layers
