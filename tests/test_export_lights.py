# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps and worlds become arrays in Blender's units.

What radiance the native module makes of them is tested there. The rules here were measured with Cycles 5.2.3.
"""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from cotorra import native
from cotorra.export.buffers import Lights
from cotorra.log import Log
from mathutils import Euler, Matrix

from scenes import build
from scenes.depsgraphs import exported, messages
from shaders import closures, emission_ops

CAMERA, DIFFUSE, GLOSSY, TRANSMISSION, VOLUME, SHADOW = 1, 2, 4, 8, 16, 32


def lights(scene: bpy.types.Scene) -> Lights:
    return exported(scene).lights


def emission(shader: int, scene: bpy.types.Scene) -> tuple[object, object]:
    """Weight and colour of a shader that is one emission."""
    (closure,) = closures(exported(scene).shaders[shader])
    assert closure.name == 'emission'
    return closure.weight, closure.args[0]


def test_dtypes() -> None:
    scene = build.new_scene()
    build.light(scene, 'POINT')
    found = lights(scene)
    floats = ('strength', 'transform', 'size', 'spot_size', 'spot_blend')
    assert all(getattr(found, name).dtype == np.float32 for name in floats)
    whole = ('type', 'soft_falloff', 'normalize', 'cast_shadow', 'use_mis', 'max_bounces', 'visibility')
    assert all(getattr(found, name).dtype == np.uint32 for name in whole)
    assert found.light_group.dtype == np.int32
    assert found.strength.shape == (1, 3) and found.transform.shape == (1, 3, 4)


def test_point() -> None:
    scene = build.new_scene()
    obj = build.light(scene, 'POINT', energy=100, color=(1, 0.5, 0.25), shadow_soft_size=0.75, use_soft_falloff=False)
    obj.matrix_world = Matrix.LocRotScale((1, 2, 3), Euler((1, 2, 3)), (1, 2, 3))
    found = lights(scene)
    assert found.type.tolist() == [0] and found.strength.tolist() == [[100, 50, 25]]
    assert found.size.tolist() == [0.75] and found.soft_falloff.tolist() == [0] and found.normalize.tolist() == [1]
    assert found.cast_shadow.tolist() == [1] and found.use_mis.tolist() == [1] and found.max_bounces.tolist() == [1024]
    assert np.array_equal(found.transform[0], np.array(obj.matrix_world, np.float32)[:3])
    assert found.names == ('Point',)


def test_sun() -> None:
    scene = build.new_scene()
    build.light(scene, 'SUN', energy=3, angle=0.125)
    found = lights(scene)
    assert found.type.tolist() == [1] and found.size.tolist() == [0.125] and found.strength.tolist() == [[3, 3, 3]]


def test_spot() -> None:
    scene = build.new_scene()
    build.light(scene, 'SPOT', energy=8, spot_size=math.radians(60), spot_blend=0.25, shadow_soft_size=0.5)
    found = lights(scene)
    assert found.type.tolist() == [2] and found.size.tolist() == [0.5]
    assert found.spot_size.tolist() == pytest.approx([math.pi / 3]) and found.spot_blend.tolist() == [0.25]
    assert found.soft_falloff.tolist() == [1]


def test_strength_is_a_product() -> None:
    """Colour × temperature colour × energy × 2^exposure."""
    scene = build.new_scene()
    obj = build.light(scene, 'POINT', energy=10, color=(1, 0.5, 0.25), exposure=2)
    assert lights(scene).strength.tolist() == [[40, 20, 10]]
    obj.data.use_temperature, obj.data.temperature = True, 3000
    warm = np.array(obj.data.temperature_color)
    assert warm[0] > 1.5 * warm[1] > warm[2]
    assert lights(scene).strength[0] == pytest.approx(np.array((40, 20, 10)) * warm, rel=1e-6)


def test_node_tree_is_a_factor() -> None:
    scene = build.new_scene()
    data = build.with_nodes(build.light(scene, 'POINT', energy=10).data)
    tree = data.node_tree
    node = next(node for node in tree.nodes if node.type == 'EMISSION')
    node.inputs['Strength'].default_value = 2
    node.inputs['Color'].default_value = (1, 0.5, 0.25, 1)
    assert lights(scene).strength.tolist() == [[10, 10, 10]]
    assert emission(lights(scene).shader[0], scene) == ((1.0,) * 3, (2.0, 1.0, 0.5))
    assert native.load().Scene(exported(scene), bvh=False).stats()['lights'] == 1
    tree.links.clear()
    assert native.load().Scene(exported(scene), bvh=False).stats()['lights'] == 0


def test_light_that_varies_has_a_program() -> None:
    scene = build.new_scene()
    data = build.with_nodes(build.light(scene, 'POINT', energy=10).data)
    tree = data.node_tree
    node = next(node for node in tree.nodes if node.type == 'EMISSION')
    build.connect(tree, build.node(tree, 'LightFalloff').outputs['Linear'], node.inputs['Strength'])
    made = native.load().Scene(exported(scene), bvh=False)
    assert made.stats()['lights'] == 1
    assert emission_ops(made.explain(0))[0] == 'light_falloff'


def test_switches() -> None:
    scene = build.new_scene()
    data = build.light(scene, 'POINT', use_shadow=False, normalize=False).data
    data.cycles.use_multiple_importance_sampling = False
    data.cycles.max_bounces = 3
    found = lights(scene)
    assert found.cast_shadow.tolist() == [0] and found.normalize.tolist() == [0]
    assert found.use_mis.tolist() == [0] and found.max_bounces.tolist() == [3]


@pytest.mark.parametrize(
    ('name', 'bit'),
    [
        ('visible_camera', CAMERA),
        ('visible_diffuse', DIFFUSE),
        ('visible_glossy', GLOSSY),
        ('visible_transmission', TRANSMISSION),
        ('visible_volume_scatter', VOLUME),
    ],
)
@pytest.mark.parametrize('on', ['light', 'instancer'])
def test_ray_visibility(name: str, bit: int, on: str) -> None:
    scene = build.new_scene()
    obj = build.light(scene, 'POINT')
    obj.visible_camera = True
    empty = build.collection_instance(scene, 'Instancer', [obj])
    setattr(obj if on == 'light' else empty, name, False)
    assert lights(scene).visibility.tolist() == [63 - bit]


def test_light_that_no_ray_sees_is_left_out() -> None:
    scene = build.new_scene()
    obj = build.light(scene, 'POINT')
    for name in ('camera', 'diffuse', 'glossy', 'transmission', 'volume_scatter', 'shadow'):
        setattr(obj, f'visible_{name}', False)
    assert not len(lights(scene).type)


def test_instanced_lights() -> None:
    scene = build.new_scene()
    obj = build.light(scene, 'POINT', energy=10)
    obj.location.x = 1
    sun = build.light(scene, 'SUN', energy=2)
    empty = build.collection_instance(scene, 'Instancer', [obj], unlink=False)
    empty.location.z = 5
    found = lights(scene)
    assert sorted(zip(found.names, found.type.tolist(), found.transform[:, :, 3].tolist(), strict=True)) == [
        ('Point', 0, [1, 0, 0]),
        ('Point', 0, [1, 0, 5]),
        (sun.name, 1, [0, 0, 0]),
    ]


def test_dark_lights_are_left_out() -> None:
    scene = build.new_scene()
    build.light(scene, 'POINT', energy=0)
    build.light(scene, 'SUN', color=(0, 0, 0))
    log = Log()
    assert not len(exported(scene, log).lights.type) and not log.messages


def test_negative_light_darkens() -> None:
    """As in Cycles."""
    scene = build.new_scene()
    build.light(scene, 'POINT', energy=-10)
    assert lights(scene).strength.tolist() == [[-10, -10, -10]]


@pytest.mark.parametrize(
    ('shape', 'size_y', 'ellipse'), [('SQUARE', 2.0, 0), ('RECTANGLE', 0.5, 0), ('DISK', 2.0, 1), ('ELLIPSE', 0.5, 1)]
)
def test_area(shape: str, size_y: float, ellipse: int) -> None:
    scene = build.new_scene()
    build.light(scene, 'POINT')
    obj = build.light(scene, 'AREA', shape=shape, size=2.0, size_y=0.5, spread=1.5)
    obj.matrix_world = Matrix.LocRotScale((1, 2, 3), Euler((1, 2, 3)), (1, -2, 3))
    found = lights(scene)
    assert sorted(found.type.tolist()) == [0, 3]
    index = found.type.tolist().index(3)
    assert (found.size[index], found.size_y[index], found.ellipse[index]) == (2.0, size_y, ellipse)
    assert found.spread.dtype == np.float32 and found.spread[index] == 1.5 and found.soft_falloff[index] == 0
    assert np.array_equal(found.transform[index], np.array(obj.matrix_world, np.float32)[:3])
    assert not messages(scene)


def test_without_area_lights_there_is_nothing_about_them() -> None:
    scene = build.new_scene()
    build.light(scene, 'SPOT')
    assert lights(scene).size_y is None


@pytest.mark.parametrize('size', [(0.0, 1.0), (1.0, 0.0), (float('nan'), 1.0), (1e30, 1.0)])
def test_area_without_a_size_is_named(size: tuple[float, float]) -> None:
    scene = build.new_scene()
    build.light(scene, 'AREA', shape='RECTANGLE', size=size[0], size_y=size[1]).name = 'Softbox'
    (text,) = messages(scene)
    assert text.startswith('Light "Softbox": ')
    if 0.0 in size:
        assert text.endswith('its size is 0: it lights nothing') and not len(lights(scene).type)


def test_portal_is_left_out() -> None:
    scene = build.new_scene()
    build.light(scene, 'AREA').data.cycles.is_portal = True
    log = Log()
    assert not len(exported(scene, log).lights.type)


@pytest.mark.parametrize('kind', ['POINT', 'SUN', 'SPOT', 'AREA'])
@pytest.mark.parametrize('turn', [0.0, 0.5])
def test_sheared_lamp_is_named(turn: float, kind: str) -> None:
    """By a parent that is scaled, where the lamp is turned in it. Cycles lights otherwise then, if it has axes."""
    scene = build.new_scene()
    parent = build.link(scene, 'Parent', None)
    parent.scale, parent.rotation_euler = (1.0, 0.3, 1.0), (0.4, 0.5, 0.6)
    lamp = build.light(scene, kind)
    lamp.parent, lamp.rotation_euler, lamp.name = parent, (0.0, 0.0, turn), 'Lamp'
    named = ['Light "Lamp": its transform shears it: Cycles lights otherwise there']
    assert messages(scene) == (named if turn and kind in ('SPOT', 'AREA') else [])


@pytest.mark.parametrize('kind', ['POINT', 'SUN', 'SPOT', 'AREA'])
def test_transform_without_inverse(kind: str) -> None:
    scene = build.new_scene()
    build.light(scene, kind).scale = (1, 1, 0)
    build.light(scene, 'POINT').name = 'Good'
    log = Log()
    found = exported(scene, log).lights
    assert found.names == ('Good',)
    assert log.texts('WARNING') == [f'Light "{kind.title()}": its transform is not invertible or not finite: left out']


def test_strength_that_is_not_finite() -> None:
    scene = build.new_scene()
    build.light(scene, 'POINT', energy=float('nan'))
    log = Log()
    assert not len(exported(scene, log).lights.type)
    assert log.texts('WARNING') == ['Light "Point": its strength is not a finite number: left out']


# ---- The world.


def test_no_world_is_black() -> None:
    world = exported(build.new_scene()).world
    assert (world.color, world.visibility, world.light_group, world.shader) == ((0, 0, 0), 63, -1, -1)


def shown(scene: bpy.types.Scene, log: Log | None = None) -> list[float]:
    """The radiance of a world that is one emission."""
    buffers = exported(scene, log)
    if buffers.world.shader < 0:
        return list(buffers.world.color)
    (closure,) = closures(buffers.shaders[buffers.world.shader])
    assert closure.name == 'emission' and buffers.world.color == (1.0, 1.0, 1.0)
    return [weight * part for weight, part in zip(closure.weight, closure.args[0], strict=True)]


def test_world_colour_times_strength() -> None:
    scene = build.new_scene()
    build.world(scene, (0.25, 0.5, 0.75), 2)
    assert shown(scene) == [0.5, 1.0, 1.5]


def test_world_visibility() -> None:
    scene = build.new_scene()
    flags = build.world(scene).cycles_visibility
    for name, bit in (('camera', CAMERA), ('diffuse', DIFFUSE), ('glossy', GLOSSY), ('transmission', TRANSMISSION)):
        setattr(flags, name, False)
        assert exported(scene).world.visibility == 63 - bit
        setattr(flags, name, True)
    flags.scatter = False
    assert exported(scene).world.visibility == 63 - VOLUME


def world_program(scene: bpy.types.Scene) -> list[str]:
    """Names of the ops that are evaluated where the world is seen; none for a constant."""
    buffers = exported(scene)
    return emission_ops(native.load().Scene(buffers, bvh=False).explain(buffers.world.shader))


def test_world_that_varies_is_a_program() -> None:
    scene = build.new_scene()
    world = build.world(scene, (0.5, 0.25, 0.125), 2)
    assert not world_program(scene)
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == 'BACKGROUND')
    texture = build.node(tree, 'TexEnvironment')
    texture.image = bpy.data.images.new('Sky', 4, 2)
    build.connect(tree, texture.outputs['Color'], background.inputs['Color'])
    assert 'environment_v' in world_program(scene) and exported(scene).world.name == 'World'


def test_missing_environment_texture_is_named() -> None:
    scene = build.new_scene()
    world = build.world(scene)
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == 'BACKGROUND')
    texture = build.node(tree, 'TexEnvironment')
    build.connect(tree, texture.outputs['Color'], background.inputs['Color'])
    assert 'World "World": node "Environment Texture": no image is chosen' in messages(scene)
    assert shown(scene) == [1, 0, 1]


def test_emission_in_a_world_is_background() -> None:
    scene = build.new_scene()
    tree = build.world(scene).node_tree
    emission = build.node(tree, 'Emission', Strength=3)
    build.connect(tree, emission.outputs[0], build.output(tree).inputs['Surface'])
    assert shown(scene) == [3, 3, 3]


def test_view_layer_without_environment() -> None:
    scene = build.new_scene()
    build.world(scene)
    bpy.context.view_layer.use_sky = False
    assert shown(scene) == [0, 0, 0]


@pytest.mark.skipif(
    'world_override' not in bpy.types.ViewLayer.bl_rna.properties, reason='this Blender has no world override'
)
def test_world_override_of_a_view_layer() -> None:
    scene = build.new_scene()
    other = build.world(scene, (0, 1, 0))
    build.world(scene, (1, 0, 0))
    bpy.context.view_layer.world_override = other
    assert shown(scene) == [0, 1, 0]


def test_world_volume_is_reported() -> None:
    scene = build.new_scene()
    tree = build.world(scene).node_tree
    build.connect(tree, build.node(tree, 'VolumeScatter').outputs[0], build.output(tree).inputs['Volume'])
    assert messages(scene) == ['World "World": volumes are not supported yet: left out']


def test_world_that_is_not_finite() -> None:
    scene = build.new_scene()
    build.world(scene, strength=float('nan'))
    log = Log()
    assert shown(scene, log) == [0, 0, 0]
    assert log.texts('WARNING') == ['World "World": node "Background": Strength is not a finite number: 0 is used']
