# SPDX-License-Identifier: GPL-3.0-or-later
"""The coordinates that images are read with, the normals that they bend, and what meshes bring for both.

Values on their way from an image to an input are tested in test_export_textures.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np
import pytest
from cotorra import export
from cotorra.export.buffers import SceneBuffers
from cotorra.log import Log

from flat_scenes import shining
from scenes import build
from scenes.depsgraphs import exported, in_render
from scenes.materials import constants
from scenes.textured import between, lookups, seen, show, textured
from shaders import calls
from texture_scenes import centres

# ---- Coordinates.


SIZE = 8  # of a picture


def placed(
    build_nodes: Callable[[bpy.types.NodeTree, bpy.types.NodeSocket], None],
) -> tuple[SceneBuffers, list[str]]:
    """The export of a material that shines with the coordinates that `build_nodes` makes."""
    build.new_scene()
    material = shining('Material')
    build_nodes(material.node_tree, material.node_tree.nodes['Shine'].inputs['Color'])
    return show(material)


def assert_rows(buffers: SceneBuffers, expected: object, z: float = 0.0, uv: bool = True) -> None:
    """The coordinates are these rows times (u, v, z, 1), or with `uv` off times places in the world."""
    x, y = centres(size=SIZE)
    at = np.stack([(x + 1) / 2 if uv else x, (y + 1) / 2 if uv else y, np.full_like(x, z), np.ones_like(x)], axis=-1)
    rows = np.asarray(expected, float)
    np.testing.assert_allclose(seen(buffers, SIZE)[..., : len(rows)], at @ rows.T, atol=2e-6)


def layers(buffers: SceneBuffers) -> list[int]:
    """The layers that the material looks up."""
    shader = buffers.shaders[buffers.materials.shader[1]]
    return [int(args[0][0]) for name, _, args in calls(shader) if name == 'attribute']


def test_uv_map_by_name() -> None:
    build.new_scene()
    material, node = textured()
    uv = build.node(material.node_tree, 'UVMap')
    uv.uv_map = 'Second'
    build.connect(material.node_tree, uv.outputs[0], node.inputs['Vector'])
    data = build.grid(2)
    second = data.uv_layers.new(name='Second')
    second.uv.foreach_set('vector', np.full(len(data.loops) * 2, 0.25, np.float32))
    buffers, warnings = show(material, mesh=data)
    assert buffers.uv_layers == ('', 'Second') and layers(buffers) == [1] and not warnings
    uv = buffers.meshes[0].uv.reshape(2, -1, 2)
    assert (uv[1] == 0.25).all() and uv[0].max() == 1


def test_name_of_the_active_map_is_no_second_map() -> None:
    def nodes(tree: bpy.types.NodeTree, vector: bpy.types.NodeSocket) -> None:
        uv = build.node(tree, 'UVMap')
        uv.uv_map = 'UVMap'
        build.connect(tree, uv.outputs[0], vector)

    buffers, _ = placed(nodes)
    assert buffers.uv_layers == ('',) and layers(buffers) == [0]
    assert_rows(buffers, np.eye(2, 4))


def test_uv_map_that_a_mesh_has_not() -> None:
    def nodes(tree: bpy.types.NodeTree, vector: bpy.types.NodeSocket) -> None:
        uv = build.node(tree, 'UVMap')
        uv.uv_map = 'Gone'
        build.connect(tree, uv.outputs[0], vector)

    buffers, warnings = placed(nodes)
    assert buffers.uv_layers == ('', 'Gone')
    assert not buffers.meshes[0].uv.reshape(2, -1, 2)[1].any()
    assert warnings == ['Object "Grid": mesh "Grid" has no UV map "Gone", which its material asks for: 0 is used']


def mapping_node(kind: str, output: str | None = 'UV', **inputs: tuple) -> Callable:
    def nodes(tree: bpy.types.NodeTree, vector: bpy.types.NodeSocket) -> None:
        node = build.node(tree, 'Mapping')
        node.vector_type = kind
        for name, value in inputs.items():
            node.inputs[name].default_value = value
        if output:
            build.connect(tree, build.node(tree, 'TexCoord').outputs[output], node.inputs['Vector'])
        build.connect(tree, node.outputs[0], vector)

    return nodes


QUARTER = math.pi / 2


@pytest.mark.parametrize(
    ('kind', 'expected'),
    [
        # POINT: turn (2x, 4y) by 90 degrees, then move.
        ('POINT', [[0, -4, 0, 0.25], [2, 0, 0, 0.5]]),
        ('VECTOR', [[0, -4, 0, 0], [2, 0, 0, 0]]),
        # TEXTURE is its inverse.
        ('TEXTURE', [[0, 0.5, 0, -0.25], [-0.25, 0, 0, 0.0625]]),
    ],
)
def test_mapping(kind: str, expected: list) -> None:
    given = {'Rotation': (0, 0, QUARTER), 'Scale': (2, 4, 1)}
    if kind != 'VECTOR':
        given['Location'] = (0.25, 0.5, 0)
    buffers, warnings = placed(mapping_node(kind, **given))
    assert_rows(buffers, expected)
    assert not warnings


def test_mapping_of_normals() -> None:
    """By the inverse of the scale, and of length 1."""
    buffers, warnings = placed(mapping_node('NORMAL', Scale=(2, 4, 1)))
    x, y = centres(size=SIZE)
    turned = np.stack([(x + 1) / 4, (y + 1) / 8, np.zeros_like(x)], axis=-1)
    expected = turned / np.linalg.norm(turned, axis=-1, keepdims=True)
    np.testing.assert_allclose(seen(buffers, SIZE), expected, atol=2e-6)
    assert not warnings


def test_mapping_without_coordinates_is_a_point() -> None:
    """As in Cycles, which gives only textures the UV map by default."""
    buffers, _ = placed(mapping_node('POINT', output=None, Location=(0.25, 0.5, 0)))
    assert_rows(buffers, [[0, 0, 0, 0.25], [0, 0, 0, 0.5]])


def test_vector_math() -> None:
    def nodes(tree: bpy.types.NodeTree, vector: bpy.types.NodeSocket) -> None:
        product, total = build.node(tree, 'VectorMath'), build.node(tree, 'VectorMath')
        product.operation, total.operation = 'MULTIPLY', 'ADD'
        product.inputs[1].default_value, total.inputs[1].default_value = (2, 3, 1), (0.5, 0.25, 0)
        build.connect(tree, build.node(tree, 'TexCoord').outputs['UV'], product.inputs[0])
        build.connect(tree, product.outputs[0], total.inputs[0])
        build.connect(tree, total.outputs[0], vector)

    buffers, warnings = placed(nodes)
    assert_rows(buffers, [[2, 0, 0, 0.5], [0, 3, 0, 0.25]])
    assert not warnings


@pytest.mark.parametrize(
    ('output', 'op'),
    [('Normal', 'normal'), ('Camera', 'camera_position'), ('Window', 'window'), ('Reflection', 'incoming')],
)
def test_other_coordinates(output: str, op: str) -> None:
    def nodes(tree: bpy.types.NodeTree, vector: bpy.types.NodeSocket) -> None:
        build.connect(tree, build.node(tree, 'TexCoord').outputs[output], vector)

    buffers, warnings = placed(nodes)
    assert op in {name for name, _, _ in calls(buffers.shaders[0])} and not warnings


def test_generated() -> None:
    def nodes(tree: bpy.types.NodeTree, vector: bpy.types.NodeSocket) -> None:
        build.connect(tree, build.node(tree, 'TexCoord').outputs['Generated'], vector)

    buffers, warnings = placed(nodes)
    assert_rows(buffers, [[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5]], uv=False)
    assert not warnings
    mesh = buffers.meshes[0]
    # The grid is flat: its texture space has no height, but Blender gives it some.
    np.testing.assert_allclose(mesh.generated[:, :2], 0.5 * mesh.positions[:, :2] + 0.5, atol=1e-6)
    assert mesh.generated.dtype == np.float32 and len(mesh.generated) == len(mesh.positions)


def export_all(depsgraph: bpy.types.Depsgraph) -> SceneBuffers:
    return export.export_scene(depsgraph, depsgraph.scene_eval, depsgraph.view_layer_eval, Log())


def test_generated_is_from_before_deformation() -> None:
    scene = build.new_scene()
    material, node = textured()
    build.connect(
        material.node_tree, build.node(material.node_tree, 'TexCoord').outputs['Generated'], node.inputs['Vector']
    )
    obj = build.link(scene, 'Bent', build.grid(2))
    obj.data.materials.append(material)
    cast = obj.modifiers.new('Cast', 'CAST')
    cast.factor = 1.0
    build.camera(scene)
    [[mesh]] = in_render(scene, lambda engine, depsgraph: export_all(depsgraph).meshes)
    assert np.abs(mesh.positions[0, :2]).max() < 0.9  # the corners went onto a circle
    np.testing.assert_allclose([mesh.generated.min(axis=0)[0], mesh.generated.max(axis=0)[0]], [0, 1], atol=1e-6)


def test_object_coordinates() -> None:
    def nodes(tree: bpy.types.NodeTree, vector: bpy.types.NodeSocket) -> None:
        build.connect(tree, build.node(tree, 'TexCoord').outputs['Object'], vector)

    placed(nodes)
    grid = bpy.context.scene.objects['Grid']
    grid.location, grid.scale = (0.5, -0.25, 2), (4, 2, 1)
    rows = [[0.25, 0, 0, -0.125], [0, 0.5, 0, 0.125], [0, 0, 1, -2]]
    assert_rows(exported(bpy.context.scene), rows, z=2.0, uv=False)
    grid.scale = (4, 2, 0)  # flat: no inverse
    assert_rows(exported(bpy.context.scene), [*rows[:2], [0, 0, 0, 0]], z=2.0, uv=False)


def test_coordinates_of_another_object() -> None:
    def nodes(tree: bpy.types.NodeTree, vector: bpy.types.NodeSocket) -> None:
        other = build.link(bpy.context.scene, 'Other', None)
        other.location, other.scale = (1, 2, 3), (2, 2, 2)
        coordinate = build.node(tree, 'TexCoord')
        coordinate.object = other
        build.connect(tree, coordinate.outputs['Object'], vector)

    buffers, warnings = placed(nodes)
    assert_rows(buffers, [[0.5, 0, 0, -0.5], [0, 0.5, 0, -1]], uv=False)
    assert not warnings


# ---- Normal maps.


def normal_mapped(
    space: str = 'TANGENT', uv_map: str = '', **inputs: float
) -> tuple[bpy.types.Material, bpy.types.Node]:
    material, image = textured()
    tree = material.node_tree
    node = build.node(tree, 'NormalMap', **inputs)
    node.space, node.uv_map = space, uv_map
    build.connect(tree, image.outputs['Color'], node.inputs['Color'])
    build.connect(tree, node.outputs[0], build.principled(material).inputs['Normal'])
    return material, node


def bent(buffers: SceneBuffers, material: int = 1) -> tuple[int, tuple]:
    """Mode and arguments of a material's normal map."""
    shader = buffers.shaders[buffers.materials.shader[material]]
    ((_, mode, args),) = [call for call in calls(shader) if call[0] == 'normal_map']
    return mode, args


def test_normal_map_brings_tangents() -> None:
    build.new_scene()
    material, _ = normal_mapped(Strength=0.5)
    buffers, warnings = show(material)
    assert bent(buffers) == (0, ('image_v', (0.5,) * 3, (0.0,) * 3)) and not warnings
    assert buffers.tangent_layers == (0,)
    mesh = buffers.meshes[0]
    # The grid's u grows with x, and v with y.
    np.testing.assert_allclose(mesh.tangents, np.tile([1, 0, 0, 1], (len(mesh.uv), 1)), atol=1e-6)


def test_only_meshes_with_a_normal_map_have_tangents() -> None:
    scene = build.new_scene()
    build.mesh_object(scene)
    buffers, _ = show(normal_mapped()[0])
    assert sorted(mesh.tangents is not None for mesh in buffers.meshes) == [False, True]


def test_normal_map_of_a_second_uv_map() -> None:
    build.new_scene()
    material, _ = normal_mapped(uv_map='Turned')
    data = build.grid(2)
    turned = data.uv_layers.new(name='Turned')
    uv = np.empty(len(data.loops) * 2, np.float32)
    data.uv_layers[0].uv.foreach_get('vector', uv)
    turned.uv.foreach_set('vector', uv.reshape(-1, 2)[:, ::-1].ravel())
    buffers, _ = show(material, mesh=data)
    assert buffers.uv_layers == ('', 'Turned') and buffers.tangent_layers == (1,)
    # u grows with y, and the map is mirrored.
    np.testing.assert_allclose(buffers.meshes[0].tangents, np.tile([0, 1, 0, -1], (len(data.loops), 1)), atol=1e-6)


def test_normal_map_without_a_uv_map_leaves_the_normal() -> None:
    build.new_scene()
    buffers, _ = show(normal_mapped()[0], mesh=build.mesh())
    mesh = buffers.meshes[0]
    assert not mesh.tangents[:, :3].any() and mesh.corners is not None


@pytest.mark.parametrize(('space', 'code'), [('OBJECT', 1), ('WORLD', 2), ('BLENDER_OBJECT', 3), ('BLENDER_WORLD', 4)])
def test_normal_maps_of_other_spaces(space: str, code: int) -> None:
    build.new_scene()
    buffers, warnings = show(normal_mapped(space)[0])
    assert bent(buffers)[0] == code and buffers.meshes[0].tangents is None and not warnings


@pytest.mark.skipif(
    'convention' not in bpy.types.ShaderNodeNormalMap.bl_rna.properties, reason='this Blender knows one convention'
)
def test_directx_normal_map() -> None:
    build.new_scene()
    material, node = normal_mapped()
    node.convention = 'DIRECTX'
    assert bent(show(material)[0])[0] == 8


def test_bump_keeps_the_normal_map_beneath() -> None:
    build.new_scene()
    material, node = normal_mapped()
    tree = material.node_tree
    bump = build.node(tree, 'Bump')
    build.connect(tree, node.outputs[0], bump.inputs['Normal'])
    build.connect(tree, bump.outputs[0], build.principled(material).inputs['Normal'])
    buffers, warnings = show(material)
    assert bent(buffers)[0] == 0 and lookups(buffers)[0].image == 0 and not warnings


def test_flat_normal_map_without_an_image_changes_nothing() -> None:
    build.new_scene()
    material = build.material()
    between(material, build.node(material.node_tree, 'NormalMap'), 'Normal')
    buffers, warnings = show(material)
    assert constants(buffers, 1)['base_color'] == pytest.approx([0.8] * 3) and not warnings


def test_tangents_equal_blenders_own() -> None:
    """On triangles Blender's own function does the same, for a mesh with seams, mirrored parts and smooth normals."""
    scene = build.new_scene()
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.object
    obj.modifiers.new('Triangles', 'TRIANGULATE')
    obj.data.shade_smooth()
    obj.data.materials.append(normal_mapped()[0])
    [mesh] = exported(scene).meshes
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    copy = evaluated.to_mesh()
    copy.calc_tangents()
    expected = np.empty((len(copy.loops), 3), np.float32)
    copy.loops.foreach_get('tangent', expected.ravel())
    signs = np.empty(len(copy.loops), np.float32)
    copy.loops.foreach_get('bitangent_sign', signs)
    evaluated.to_mesh_clear()
    assert set(signs) == {-1.0, 1.0}
    np.testing.assert_array_equal(mesh.tangents[:, 3], signs)
    # One triangle lies on a line in uv: its lonely corner has (1, 0, 0) in Blender, none here.
    has_one = mesh.tangents[:, :3].any(axis=1)
    assert np.count_nonzero(~has_one) == 1
    # Blender calculates in single precision; measured 1e-5.
    np.testing.assert_allclose(mesh.tangents[has_one, :3], expected[has_one], atol=1e-4)


def test_tangents_of_n_gons_and_broken_places() -> None:
    scene = build.new_scene()
    corners = [(math.cos(at), math.sin(at), 0.0) for at in np.arange(7) * (2 * math.pi / 7)]
    data = build.mesh('Heptagon', [*corners, (math.nan, 0, 0)], [tuple(range(7)), (0, 1, 7)])
    uv = data.uv_layers.new(name='UVMap')
    turned = [corners[index % 7][axis] for index in (*range(7), 0, 1, 2) for axis in (1, 0)]
    uv.uv.foreach_set('vector', np.array(turned, np.float32))
    data.materials.append(normal_mapped()[0])
    build.link(scene, 'Heptagon', data)
    [mesh] = exported(scene).meshes
    assert np.isfinite(mesh.tangents).all()
    np.testing.assert_allclose(mesh.tangents[3:7], np.tile([0, 1, 0, -1], (4, 1)), atol=1e-6)
