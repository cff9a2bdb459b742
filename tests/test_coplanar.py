# SPDX-License-Identifier: GPL-3.0-or-later
"""Which meshes have triangles in one plane with others, as a scene counts them where rays can tell.

What rays do there is test_ray_starts.py's, beside Cycles.
"""

from __future__ import annotations

import dataclasses

import bpy
import cotorra_native as native
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from scenes import build
from scenes.depsgraphs import exported
from test_ray_starts import GLASS, material_of

pytestmark = [
    pytest.mark.usefixtures('engine'),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='the nodes are those of Blender 5.2'),
]

FLOOR = [(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)]


def cube(lift: float = 0.0, size: float = 1.6) -> bpy.types.Object:
    bpy.ops.mesh.primitive_cube_add(size=size, location=(0.0, 0.0, 0.5 * size + lift), rotation=(0.0, 0.0, 0.5))
    thing = bpy.context.object
    thing.data.materials.append(material_of(GLASS))
    return thing


def found(scene: bpy.types.Scene, editable: bool = False) -> int:
    buffers = exported(scene)
    return native.Scene(buffers, bvh=False, editable=editable).stats()['coplanar_meshes']


@pytest.mark.parametrize(
    ('scale', 'at'), [(1.0, (0, 0, 0)), (1e-4, (0, 0, 0)), (100.0, (1e5, 1e5, 0)), (1.0, (37.3, -12.1, 5.7))]
)
@pytest.mark.parametrize('turn', [(0, 0, 0), (0.3, 0, 0), (0.7, -1.2, 2.0)])
def test_glass_on_a_floor(turn: tuple, scale: float, at: tuple) -> None:
    """Wherever both stand, and however they are turned together."""
    scene = build.new_scene()
    both = [build.mesh_object(scene, 'Floor', vertices=FLOOR), cube()]
    bpy.context.view_layer.update()
    move = Matrix.LocRotScale(Vector(at), Euler(turn), Vector((scale,) * 3))
    for thing in both:
        thing.matrix_world = move @ thing.matrix_world
    assert found(scene) == 2


def test_glass_above_a_floor() -> None:
    scene = build.new_scene()
    build.mesh_object(scene, 'Floor', vertices=FLOOR)
    cube(lift=1e-3)
    assert found(scene) == 0
    assert found(scene, editable=True) == 2  # the next edit may lower it


def test_a_mesh_of_both() -> None:
    scene = build.new_scene()
    floor = build.mesh_object(scene, 'Floor', vertices=FLOOR)
    glass = cube()
    bpy.ops.object.select_all(action='DESELECT')
    for thing in (floor, glass):
        thing.select_set(True)
    bpy.context.view_layer.objects.active = glass
    bpy.ops.object.join()
    assert found(scene) == 1


def test_tiles_side_by_side_and_smooth_things_do_not_count() -> None:
    scene = build.new_scene()
    for x in (-1, 1):
        for y in (-1, 1):
            build.mesh_object(scene, 'Tile', vertices=[(x * 3 + a, y * 3 + b, 0) for a, b, _ in np.array(FLOOR) / 2])
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, location=(0, 0, 1.0))
    bpy.context.object.data.materials.append(material_of(GLASS))
    assert found(scene) == 0


def test_instances_of_one_mesh() -> None:
    """Two copies of a pane in one place, and two in different ones."""
    for shift, expected in ((0.5, 1), (5.0, 0)):
        scene = build.new_scene()
        pane = build.mesh_object(scene, 'Pane', vertices=[(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
        pane.data.materials.append(material_of(GLASS))
        other = bpy.data.objects.new('Other', pane.data)
        other.location.x = shift
        scene.collection.objects.link(other)
        assert found(scene) == expected


def test_many_triangles_in_one_plane_are_taken_for_such() -> None:
    scene = build.new_scene()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=20, y_subdivisions=20, size=4)
    cube(lift=1.0)
    assert found(scene) == 1


def test_places_that_are_no_numbers_do_no_harm() -> None:
    """Such vertices are left out by the exporter; whoever hands them over all the same gets a scene."""
    scene = build.new_scene()
    build.mesh_object(scene, 'Floor', vertices=FLOOR)
    cube()
    buffers = exported(scene)
    [floor, glass] = buffers.meshes
    broken = floor.positions.copy()
    padded = np.zeros(broken.size + 1, np.float32)
    padded[: broken.size] = broken.ravel()
    padded[3] = np.nan  # of the second vertex, which one of two triangles uses
    floor = dataclasses.replace(floor, positions=padded[: broken.size].reshape(-1, 3))
    buffers = dataclasses.replace(buffers, meshes=(floor, glass))
    assert native.Scene(buffers, bvh=False).stats()['coplanar_meshes'] == 2


def opaque(name: str, vertices: list) -> bpy.types.Object:
    return build.mesh_object(bpy.context.scene, name, vertices=vertices)


def test_opaque_things_that_coincide() -> None:
    """Of opaque ones only those that face one way show: two floors do, and what stands on one does not."""
    scene = build.new_scene()
    opaque('Floor', FLOOR)
    bpy.ops.mesh.primitive_cube_add(size=1.6, location=(0.0, 0.0, 0.8))
    assert found(scene) == 0
    second = opaque('Second', [(x + 5, y + 5, z) for x, y, z in FLOOR])
    assert found(scene) == 2
    assert found(scene, editable=True) == 0
    bpy.data.objects.remove(bpy.data.objects['Cube'])  # whose bottom looks down
    second.scale.x = -1.0  # its faces look down, but what a negative scale turns over faces the same way
    second.location.x = 5.0
    assert found(scene) == 2
    second.rotation_euler.x = np.pi
    assert found(scene) == 0


def test_opaque_planes_that_are_finely_divided() -> None:
    """No cell of a grid overlaps another; a small face on it overlaps one."""
    scene = build.new_scene()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=40, y_subdivisions=40, size=4)
    assert found(scene) == 0
    opaque('Patch', [(0.11 + 0.02 * x, 0.12 + 0.02 * y, 0.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    assert found(scene) == 2
