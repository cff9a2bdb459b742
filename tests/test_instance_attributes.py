# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of instances that geometry nodes make, and properties of what makes particles: each instance its own.

Points carry their own place as an attribute, so that an instance's value is right where it stands in that place.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra.export.attributes import instancer_layer

from beside_cycles import in_halves
from flat_scenes import Flat, flat
from scenes import build
from scenes.depsgraphs import exported

pytestmark = pytest.mark.usefixtures('engine')

SCALE = 0.1  # of all that is instanced
PLACES = ((-1.0, 0.5, 0.0), (0.75, -1.0, 0.0), (1.0, 1.25, 0.0))


def points(name: str, places: Sequence[Sequence[float]] = PLACES, **values: object) -> bpy.types.Object:
    """A mesh of vertices alone; `values`: its attributes beside 'place'."""
    obj = build.mesh_object(bpy.context.scene, name, vertices=places, faces=())
    data = obj.data
    data.attributes.new('place', 'FLOAT_VECTOR', 'POINT').data.foreach_set('vector', np.ravel(places))
    for key, numbers in values.items():
        data.attributes.new(key, 'INT', 'POINT').data.foreach_set('value', numbers)
    return obj


def at_points(made: Flat, holder: bpy.types.Object, what: bpy.types.ID) -> None:
    """Shows an object or a collection at the points of `holder`; a mesh is taken as such, not as an object."""

    def nodes(tree: bpy.types.NodeTree) -> None:
        on_points = tree.nodes.new('GeometryNodeInstanceOnPoints')
        is_collection = isinstance(what, bpy.types.Collection)
        source = tree.nodes.new('GeometryNodeCollectionInfo' if is_collection else 'GeometryNodeObjectInfo')
        if is_collection:
            source.inputs['Collection'].default_value = what
            shown = source.outputs[0]
        else:
            source.inputs['Object'].default_value = what if isinstance(what, bpy.types.Object) else made.obj
            source.inputs['As Instance'].default_value = isinstance(what, bpy.types.Object)
            shown = source.outputs['Geometry']
        tree.links.new(tree.nodes['In'].outputs[0], on_points.inputs['Points'])
        on_points.inputs['Scale'].default_value = (SCALE,) * 3
        tree.links.new(shown, on_points.inputs['Instance'])
        tree.links.new(on_points.outputs[0], tree.nodes['Out'].inputs[0])

    build.geometry_nodes(holder, nodes)


def asks(made: Flat, *names: str) -> None:
    """The square's material asks instancers for attributes, whose sum it shows."""
    shown = None
    for name in names:
        asked = made.node('Attribute', attribute_type='INSTANCER', attribute_name=name)
        if shown is None:
            shown = asked.outputs['Vector']
        else:
            total = made.node('VectorMath', operation='ADD')
            made.link(shown, total.inputs[0])
            made.link(asked.outputs['Vector'], total.inputs[1])
            shown = total.outputs[0]
    made.link(shown, made.emission.inputs['Color'])


def found(name: str = 'place') -> tuple[np.ndarray, np.ndarray]:
    """Where instances stand, and the value of each; without the square itself, which stands far away."""
    buffers = exported(bpy.context.scene)
    layers = [buffers.attribute_layers[index] for index in buffers.instance_layers]
    values = buffers.instances.attributes[layers.index(instancer_layer(name))]
    places = buffers.instances.transform[:, :, 3]
    shown = places[:, 0] < 50.0
    return places[shown], values[shown]


def square() -> Flat:
    made = flat()
    made.obj.location.x = 100.0
    made.obj.scale = (0.1, 0.1, 0.1)
    return made


@pytest.mark.parametrize('kind', ['geometry', 'object', 'collection'])
@pytest.mark.parametrize('ids', [None, (7, -3, 5), (4, 4, 4), (9, 2, 9)])
def test_each_instance_has_its_own_value(kind: str, ids: tuple[int, ...] | None) -> None:
    """By whatever numbers the instances are known: their order, or an attribute that may hold one twice."""
    made = square()
    asks(made, 'place')
    what = {'geometry': made.obj.data, 'object': made.obj}.get(kind)
    if what is None:
        what = bpy.data.collections.new('Shown')
        what.objects.link(made.obj)
        made.obj.location.x = 0.0
        made.scene.collection.objects.unlink(made.obj)
    at_points(made, points('Points', **({} if ids is None else {'id': ids})), what)
    places, values = found()
    assert len(places) == len(PLACES)
    np.testing.assert_allclose(values[:, :3], places, atol=1e-6)
    assert (values[:, 3] == 1.0).all()


def test_within_an_instance_of_a_collection() -> None:
    made = square()
    asks(made, 'place')
    holder = points('Points')
    at_points(made, holder, made.obj.data)
    empties = [build.collection_instance(made.scene, 'Group', [holder])]
    empties.append(build.link(made.scene, 'Again', None))
    empties[1].instance_type, empties[1].instance_collection = 'COLLECTION', empties[0].instance_collection
    empties[1].location.z = 8.0
    places, values = found()
    assert len(places) == 2 * len(PLACES) and set(places[:, 2].tolist()) == {0.0, 8.0}
    np.testing.assert_allclose(values[:, :2], places[:, :2], atol=1e-6)


def test_of_nested_instances_the_innermost_that_has_it_counts() -> None:
    made = square()
    asks(made, 'place', 'outer')
    inner = points('Inner', [(0.0, 0.0, 1.0), (0.25, 0.0, 1.0)])
    inner.location.x = 100.0
    at_points(made, inner, made.obj.data)
    outer = points('Outer', outer=(3, 4, 5))
    outer.data.attributes['place'].data.foreach_set('vector', [9.0] * 9)
    at_points(made, outer, inner)
    places, values = found()
    _, numbers = found('outer')
    assert len(places) == 6
    for place, value, number in zip(places, values, numbers, strict=True):
        index = int(number[0]) - 3
        np.testing.assert_allclose(place - np.array(PLACES[index]), SCALE * value[:3], atol=1e-6)


def test_what_no_instance_has_is_the_property_of_the_object() -> None:
    made = square()
    asks(made, 'tint', 'place')
    holder = points('Points')
    holder['tint'] = (0.25, 0.5, 0.75)
    holder['place'] = (8.0, 8.0, 8.0)
    at_points(made, holder, made.obj.data)
    _, values = found('tint')
    np.testing.assert_allclose(values, [(0.25, 0.5, 0.75, 1.0)] * 3)
    places, values = found()
    np.testing.assert_allclose(values[:, :3], places, atol=1e-6)


def test_particles_have_the_properties_of_their_settings(tmp_path: Path) -> None:
    """Cycles' red channel is that of the settings, before that of the emitter."""
    made = square()
    asks(made, 'tint')
    emitter = build.mesh_object(made.scene, 'Emitter')
    emitter.show_instancer_for_render = emitter.show_instancer_for_viewport = False
    settings = emitter.modifiers.new('Particles', 'PARTICLE_SYSTEM').particle_system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.particle_size = 3, 1, 1, 30.0
    settings.render_type, settings.instance_object = 'OBJECT', made.obj
    settings['tint'], emitter['tint'] = (0.5, 0.25, 0.125), (0.0, 1.0, 0.0)
    made.scene.frame_set(1)
    _, values = found('tint')
    np.testing.assert_allclose(values, [(0.5, 0.25, 0.125, 1.0)] * 3)
    theirs = in_halves(made.scene, 'CYCLES', tmp_path, 0, (8, 8), 4).image[4, 4]
    np.testing.assert_allclose(theirs, values[0, :3], rtol=1e-6)  # a mean of samples that are all alike


def test_cycles_shows_the_same(tmp_path: Path) -> None:
    """Squares whose ids stand there twice, at three points, in their colours."""
    made = square()
    asks(made, 'place')
    places = [(0.25, 0.5, 0.0), (1.0, 0.75, 0.0), (0.5, 1.25, 0.0)]
    at_points(made, points('Points', places, id=(9, 2, 9)), made.obj.data)
    images = [in_halves(made.scene, engine, tmp_path, 0, (32, 32), 32).image for engine in ('COTORRA', 'CYCLES')]
    means = [image.reshape(4, 8, 4, 8, 3).mean((1, 3)) for image in images]
    assert means[1].max() > 0.25
    np.testing.assert_allclose(*means, rtol=0.05, atol=0.02)


@pytest.mark.parametrize('kind', ['VERTS', 'PARTICLES'])
@pytest.mark.parametrize('output', ['Generated', 'UV'])
def test_coordinates_of_the_instancer(kind: str, output: str, tmp_path: Path) -> None:
    """Where on it the instance stands; half of a coordinate less one half, as Cycles has it. Seen beside Cycles."""
    made = square()
    # They are negative: a light that takes away is another matter.
    shown = made.node('VectorMath', operation='MULTIPLY_ADD')
    shown.inputs[1].default_value, shown.inputs[2].default_value = (0.25,) * 3, (1.0,) * 3
    made.link(made.node('TexCoord', from_instancer=True).outputs[output], shown.inputs[0])
    made.link(shown.outputs[0], made.emission.inputs['Color'])
    holder = build.mesh_object(made.scene, 'Holder')
    holder.data.uv_layers.new(name='UVMap')
    holder.show_instancer_for_render = holder.show_instancer_for_viewport = False
    if kind == 'VERTS':
        made.obj.parent, made.obj.location, holder.instance_type = holder, (0.0, 0.0, 0.0), 'VERTS'
    else:
        settings = holder.modifiers.new('Particles', 'PARTICLE_SYSTEM').particle_system.settings
        settings.count, settings.frame_start, settings.frame_end, settings.particle_size = 20, 1, 1, 0.3
        settings.render_type, settings.instance_object, settings.physics_type = 'OBJECT', made.obj, 'NO'
        made.scene.frame_set(2)
    if kind == 'VERTS' and output == 'Generated':
        buffers = exported(made.scene)
        values = buffers.instances.attributes[0]
        assert sorted(values[:, 0].tolist()) == [-0.5] * len(build.QUAD) + [0.0]  # the square itself is no instance
    images = [in_halves(made.scene, engine, tmp_path, 0, (32, 32), 32).image for engine in ('COTORRA', 'CYCLES')]
    means = [image.reshape(4, 8, 4, 8, 3).mean((1, 3)) for image in images]
    assert means[1].max() > 0.03
    np.testing.assert_allclose(*means, rtol=0.05, atol=0.005)
