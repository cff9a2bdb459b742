# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes become the arrays that the border promises, broken ones included.

Which objects show them, and where, is test_export_instances.py's.
"""

from __future__ import annotations

import time

import bpy
import numpy as np
import pytest
from cotorra.export import bounds
from cotorra.export.buffers import Mesh
from cotorra.log import Log

from scenes import build
from scenes.depsgraphs import exported, exported_in_render, messages

NAN, INF = float('nan'), float('inf')


def only_mesh(scene: bpy.types.Scene) -> Mesh:
    meshes = exported(scene).meshes
    assert len(meshes) == 1
    return meshes[0]


def as_array(collection: bpy.types.bpy_prop_collection, name: str, width: int) -> np.ndarray:
    return np.array([getattr(item, name) for item in collection], np.float32).reshape(-1, width)


def test_flat_quad() -> None:
    scene = build.new_scene()
    build.mesh_object(scene)
    mesh = only_mesh(scene)
    assert mesh.name == 'Quad'
    assert mesh.positions.dtype == np.float32 and mesh.triangles.dtype == np.uint32
    assert np.array_equal(mesh.positions, np.array(build.QUAD, np.float32))
    assert sorted(map(sorted, mesh.triangles.tolist())) in ([[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]])
    assert (mesh.normals_domain, mesh.normals, mesh.corners, mesh.uv, mesh.slots) == ('FACE', None, None, None, None)
    assert mesh.attributes == ()


def test_positions_are_padded_for_embree() -> None:
    scene = build.new_scene()
    build.mesh_object(scene)
    positions = only_mesh(scene).positions
    assert positions.flags['C_CONTIGUOUS']
    assert positions.base.ctypes.data == positions.ctypes.data
    assert positions.base.nbytes >= positions.nbytes + 4


def test_arrays_are_copies() -> None:
    """Blender may free or change its mesh once the export is done."""
    scene = build.new_scene()
    obj = build.mesh_object(scene, smooth=True)
    obj.data.uv_layers.new(name='UVMap')
    mesh = only_mesh(scene)
    before = [array.copy() for array in (mesh.positions, mesh.triangles, mesh.corners, mesh.normals, mesh.uv)]
    obj.data.transform(((2, 0, 0, 5), (0, 2, 0, 5), (0, 0, 2, 5), (0, 0, 0, 1)))
    bpy.context.view_layer.update()
    build.new_scene()
    after = (mesh.positions, mesh.triangles, mesh.corners, mesh.normals, mesh.uv)
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))


def test_ngon_is_triangulated_with_its_corners() -> None:
    scene = build.new_scene()
    angles = np.linspace(0, 2 * np.pi, 7, endpoint=False)
    ring = [(np.cos(a), np.sin(a), 0) for a in angles]
    obj = build.mesh_object(scene, vertices=ring, faces=[range(7)])
    obj.data.uv_layers.new(name='UVMap')
    mesh = only_mesh(scene)
    assert mesh.triangles.shape == mesh.corners.shape == (5, 3)
    # The corners of this face come in the order of its vertices.
    assert np.array_equal(mesh.triangles, mesh.corners)
    a, b, c = (mesh.positions[mesh.triangles[:, k]] for k in range(3))
    area = 0.5 * np.cross(b - a, c - a)[:, 2]
    assert (area > 0).all() and area.sum() == pytest.approx(3.5 * np.sin(2 * np.pi / 7), rel=1e-5)


def test_smooth_normals_are_one_a_vertex() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(
        scene, vertices=[*build.QUAD, (0, 0, 1)], faces=[(0, 1, 4), (1, 2, 4), (2, 3, 4)], smooth=True
    )
    mesh = only_mesh(scene)
    assert mesh.normals_domain == 'POINT' and mesh.corners is None
    assert np.allclose(mesh.normals, as_array(obj.data.vertex_normals, 'vector', 3), atol=1e-6)


@pytest.mark.parametrize('how', ['sharp edge', 'sharp face'])
def test_split_normals_are_one_a_corner(how: str) -> None:
    scene = build.new_scene()
    obj = build.mesh_object(
        scene, vertices=[*build.QUAD, (3, -1, 1), (3, 1, 1)], faces=[(0, 1, 2, 3), (1, 4, 5, 2)], smooth=True
    )
    if how == 'sharp edge':
        next(edge for edge in obj.data.edges if set(edge.vertices) == {1, 2}).use_edge_sharp = True
    else:
        obj.data.polygons[0].use_smooth = False
    mesh = only_mesh(scene)
    assert mesh.normals_domain == 'CORNER' and mesh.normals.shape == (8, 3)
    assert np.allclose(mesh.normals[:4], (0, 0, 1), atol=1e-6)
    assert np.allclose(mesh.normals, as_array(obj.data.corner_normals, 'vector', 3), atol=1e-6)
    corner_vertices = np.array([loop.vertex_index for loop in obj.data.loops])
    assert np.array_equal(corner_vertices[mesh.corners], mesh.triangles)


def test_uv_map_is_the_one_for_rendering() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    for name in ('first', 'second', 'third'):
        obj.data.uv_layers.new(name=name)
    chosen = [(0.1, 0.2), (0.9, 0.2), (0.9, 0.8), (0.1, 0.8)]
    for loop, uv in zip(obj.data.uv_layers['second'].data, chosen, strict=True):
        loop.uv = uv
    obj.data.uv_layers['second'].active_render = True
    obj.data.uv_layers['third'].active = True
    mesh = only_mesh(scene)
    assert np.allclose(mesh.uv, chosen)
    assert mesh.corners.shape == mesh.triangles.shape


def test_slots_of_triangles() -> None:
    scene = build.new_scene()
    data = build.grid(2)
    for _ in range(3):
        data.materials.append(build.material())
    data.polygons.foreach_set('material_index', [0, 2, 1, 2])
    build.link(scene, 'Grid', data)
    buffers = exported(scene)
    assert buffers.meshes[0].slots.tolist() == [0, 0, 2, 2, 1, 1, 2, 2]
    assert buffers.instances.material_count.tolist() == [3]


def test_slots_are_left_out_where_all_are_the_first() -> None:
    scene = build.new_scene()
    data = build.grid(2)
    for _ in range(3):
        data.materials.append(build.material())
    data.polygons.foreach_set('material_index', [0, 0, 0, 0])
    build.link(scene, 'Grid', data)
    assert only_mesh(scene).slots is None


@pytest.mark.parametrize(('materials', 'expected'), [(0, None), (1, None), (2, [1, 1, 1, 1, 0, 0, 0, 0])])
def test_slots_out_of_range_take_the_nearest(materials: int, expected: list[int] | None) -> None:
    """As after a material is removed; Blender and Cycles show the last one that is there."""
    scene = build.new_scene()
    data = build.grid(2)
    for _ in range(materials):
        data.materials.append(build.material())
    attribute = data.attributes.new('material_index', 'INT', 'FACE')
    attribute.data.foreach_set('value', [7, 32767, -1, 0])
    build.link(scene, 'Grid', data)
    slots = only_mesh(scene).slots
    assert (None if slots is None else slots.tolist()) == expected


def test_modifiers_are_evaluated() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    array = obj.modifiers.new('Array', 'ARRAY')
    array.count = 5
    assert only_mesh(scene).triangles.shape == (10, 3)


def test_final_render_uses_render_levels() -> None:
    scene = build.new_scene()
    build.camera(scene)
    obj = build.mesh_object(scene)
    subdivision = obj.modifiers.new('Subdivision', 'SUBSURF')
    subdivision.levels, subdivision.render_levels = 0, 2
    assert len(only_mesh(scene).triangles) == 2
    [buffers] = exported_in_render(scene)
    assert len(buffers.meshes[0].triangles) == 32


def test_mesh_in_edit_mode_shows_the_edit() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.mesh.select_all(action='SELECT')
    bpy.ops.transform.translate(value=(0, 0, 3))
    try:
        assert only_mesh(scene).positions[:, 2].tolist() == [3, 3, 3, 3]
    finally:
        bpy.ops.object.mode_set(mode='OBJECT')


# ---- Bad input.


@pytest.mark.parametrize('vertices', [[], [(0, 0, 0), (1, 0, 0)]], ids=['empty', 'no faces'])
def test_mesh_without_faces_is_skipped(vertices: list) -> None:
    scene = build.new_scene()
    build.mesh_object(scene, 'Nothing', vertices=vertices, faces=[])
    build.mesh_object(scene, 'Quad')
    log = Log()
    buffers = exported(scene, log)
    assert [mesh.name for mesh in buffers.meshes] == ['Quad'] and buffers.instances.names == ('Quad',)
    assert log.texts('INFO') == ['Object "Nothing": mesh "Nothing" has no faces'] and not log.texts('WARNING')


@pytest.mark.parametrize('bad', [NAN, INF, -INF])
@pytest.mark.parametrize('shading', ['flat', 'smooth', 'split'])
def test_vertices_without_a_place(bad: float, shading: str) -> None:
    """Their triangles go, the rest stays, and no NaN reaches the arrays."""
    scene = build.new_scene()
    data = build.grid(3)
    data.materials.append(None)
    data.materials.append(None)
    data.polygons.foreach_set('material_index', [1] + [0] * 7 + [1])
    if shading != 'flat':
        data.shade_smooth()
    if shading == 'split':
        data.edges[10].use_edge_sharp = True
    positions = as_array(data.vertices, 'co', 3)
    positions[0, 1] = bad
    data.attributes['position'].data.foreach_set('vector', positions.ravel())  # `co` clamps infinity
    build.link(scene, 'Broken', data)
    log = Log()
    mesh = exported(scene, log).meshes[0]
    [warning] = log.texts('WARNING')
    assert 'Object "Broken": 1 vertices of mesh "Grid"' in warning
    gone = 18 - len(mesh.triangles)
    assert f'{gone} triangles' in warning and gone in (1, 2)  # as the corner's quad is cut
    assert 0 not in mesh.triangles
    assert len(mesh.corners) == len(mesh.slots) == len(mesh.triangles)
    assert mesh.slots.sum() == 4 - gone
    assert np.isfinite(mesh.positions).all()
    if mesh.normals is not None:
        entries = mesh.corners if mesh.normals_domain == 'CORNER' else mesh.triangles
        assert np.allclose(np.abs(mesh.normals[entries]), (0, 0, 1), atol=1e-5)


def test_only_broken_triangles() -> None:
    scene = build.new_scene()
    build.mesh_object(scene, 'Broken', vertices=[(NAN, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[(0, 1, 2)])
    buffers = exported(scene)
    assert not buffers.meshes and not len(buffers.instances.mesh)


@pytest.mark.parametrize('split', [False, True])
def test_triangles_without_area_have_normals(split: bool) -> None:
    scene = build.new_scene()
    line = [(2, 0, 0), (3, 0, 0), (4, 0, 0), (5, 5, 5), (5, 5, 5), (5, 5, 5)]
    obj = build.mesh_object(
        scene, vertices=[*build.QUAD, *line], faces=[(0, 1, 2, 3), (4, 5, 6), (7, 8, 9)], smooth=True
    )
    if split:
        obj.data.edges[0].use_edge_sharp = True
        obj.data.polygons[1].use_smooth = False
    mesh = only_mesh(scene)
    assert mesh.normals_domain == ('CORNER' if split else 'POINT')
    assert len(mesh.triangles) == 4
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-3)


@pytest.mark.parametrize('far, kept', [(bounds.LARGEST / 2.0, 1), (3e38, 0)])
def test_huge_coordinates_are_kept_as_far_as_rays_reach(far: float, kept: int) -> None:
    scene = build.new_scene()
    build.mesh_object(scene, vertices=[(far, 0, 0), (far, 1, 0), (0, 1, 0)], faces=[(0, 1, 2)])
    assert sum(len(mesh.triangles) for mesh in exported(scene).meshes) == kept
    assert len(messages(scene)) == 1 - kept


def test_uv_that_is_not_finite() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    layer = obj.data.uv_layers.new(name='UVMap')
    layer.uv.foreach_set('vector', np.array([0, 1, 0, 1, NAN, INF, 0, 1], np.float32))  # `uv` clamps infinity
    assert only_mesh(scene).uv[2].tolist() == [0, 0]


def test_two_million_triangles_are_quick() -> None:
    """Measured 45 to 120 ms on two cores once Blender has its normals; a per-face loop would take seconds."""
    scene = build.new_scene()
    data = build.grid(1000)
    data.shade_smooth()
    build.link(scene, 'Grid', data)
    exported(scene)
    began = time.perf_counter()
    mesh = only_mesh(scene)
    assert time.perf_counter() - began < 1.0
    assert mesh.triangles.shape == (2_000_000, 3)
