# SPDX-License-Identifier: GPL-3.0-or-later
"""Which material an object shows: that of its data, its own, an empty slot's grey, an override; as Cycles has it.

Each case is rendered by both engines on a few pixels. How slots become arrays is tested in test_export_materials.py.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat

import flat_scenes
from flat_scenes import Flat, flat, shining, shown
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

RED = (0.9, 0.1, 0.1)


def emptied(obj: bpy.types.Object, slot: int = 0) -> None:
    """The slot is linked to the object, which has nothing in it."""
    obj.material_slots[slot].link = 'OBJECT'
    obj.material_slots[slot].material = None


def empty(made: Flat) -> None:
    emptied(made.obj)


def empty_second(made: Flat) -> None:
    made.obj.data.materials.append(shining('Red', RED))
    made.obj.data.polygons[0].material_index = 1
    emptied(made.obj, 1)


def own(made: Flat) -> None:
    emptied(made.obj)
    made.obj.material_slots[0].material = shining('Red', RED)


def empty_beside_another(made: Flat) -> None:
    """Two objects of one mesh: only one has an empty slot, and is behind the other."""
    behind = build.link(made.scene, 'Behind', made.obj.data)
    behind.location.z = -1.0
    emptied(behind)


def empty_with_modifier(made: Flat) -> None:
    emptied(made.obj)
    made.obj.modifiers.new('Subdivision', 'SUBSURF')


def empty_in_collection(made: Flat) -> None:
    emptied(made.obj)
    inside = bpy.data.collections.new('Inside')
    inside.objects.link(made.obj)
    made.scene.collection.objects.unlink(made.obj)
    instancer = build.link(made.scene, 'Instancer', None)
    instancer.instance_type, instancer.instance_collection = 'COLLECTION', inside


def empty_on_vertices(made: Flat) -> None:
    emptied(made.obj)
    point = bpy.data.meshes.new('Point')
    point.from_pydata([(0, 0, 0)], [], [])
    made.obj.parent = build.link(made.scene, 'Points', point)
    made.obj.parent.instance_type = 'VERTS'


def empty_curve(made: Flat) -> None:
    curve = bpy.data.curves.new('Curve', 'CURVE')
    curve.dimensions, curve.fill_mode = '2D', 'BOTH'
    spline = curve.splines.new('POLY')
    spline.points.add(3)
    spline.use_cyclic_u = True
    for point, place in zip(spline.points, ((-3, -3), (3, -3), (3, 3), (-3, 3)), strict=True):
        point.co = (*place, 0, 1)
    curve.materials.append(shining('Red', RED))
    made.obj.hide_render = True
    emptied(build.link(made.scene, 'Curve', curve))


def empty_metaball(made: Flat) -> None:
    ball = bpy.data.metaballs.new('Ball')
    ball.elements.new().radius = 3
    ball.materials.append(shining('Red', RED))
    made.obj.hide_render = True
    emptied(build.link(made.scene, 'Ball', ball))


def instanced(made: Flat, realize: bool) -> bpy.types.Object:
    """Geometry nodes show another object in place of the square, with a material of its data."""
    shape = build.link(made.scene, 'Shape', made.obj.data.copy())
    shape.hide_render = True
    shape.data.materials[0] = shining('Red', RED)
    tree = bpy.data.node_groups.new('Geometry', 'GeometryNodeTree')
    tree.interface.new_socket('Geometry', in_out='INPUT', socket_type='NodeSocketGeometry')
    tree.interface.new_socket('Geometry', in_out='OUTPUT', socket_type='NodeSocketGeometry')
    info, end = tree.nodes.new('GeometryNodeObjectInfo'), tree.nodes.new('NodeGroupOutput')
    info.inputs['Object'].default_value = shape
    info.inputs['As Instance'].default_value = True
    geometry = info.outputs['Geometry']
    if realize:
        real = tree.nodes.new('GeometryNodeRealizeInstances')
        tree.links.new(geometry, real.inputs[0])
        geometry = real.outputs[0]
    tree.links.new(geometry, end.inputs[0])
    made.obj.modifiers.new('Geometry', 'NODES').node_group = tree
    return shape


def empty_instance(made: Flat) -> None:
    emptied(instanced(made, realize=False))


def empty_realized(made: Flat) -> None:
    emptied(instanced(made, realize=True))


def own_of_instancer(made: Flat) -> None:
    instanced(made, realize=False)
    emptied(made.obj)


def beyond_the_slots(made: Flat) -> None:
    made.obj.data.materials.append(shining('Red', RED))
    made.obj.data.polygons[0].material_index = 7


def override_of_empty(made: Flat) -> None:
    emptied(made.obj)
    bpy.context.view_layer.material_override = shining('Red', RED)


def no_slot(made: Flat) -> None:
    made.obj.data.materials.clear()


CASES = (
    *(empty, empty_second, own, empty_beside_another, empty_with_modifier, empty_in_collection, empty_on_vertices),
    *(empty_curve, empty_metaball, empty_instance, empty_realized, own_of_instancer),
    *(beyond_the_slots, override_of_empty, no_slot),
)


@pytest.mark.parametrize('case', CASES, ids=lambda case: case.__name__)
def test_as_cycles(case: Callable[[Flat], None], tmp_path: Path) -> None:
    made = flat()
    made.scene.world = bpy.data.worlds.new('World')
    compat.background(made.scene.world).inputs['Color'].default_value = (1.0, 1.0, 1.0, 1.0)
    case(made)
    # Grey is lit by the world: one sample on four pixels has noise of a few hundredths, the colours are far apart.
    mine, theirs = shown('COTORRA', tmp_path)[0], shown('CYCLES', tmp_path)[0]
    np.testing.assert_allclose(mine, theirs, atol=0.05)
    assert abs(mine - flat_scenes.OWN[:3]).max() > 0.1 or case is empty_beside_another
