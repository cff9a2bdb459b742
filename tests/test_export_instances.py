# SPDX-License-Identifier: GPL-3.0-or-later
"""Every way in which Blender shows an object: each mesh is exported once, each instance where Blender puts it.

The arrays of the meshes are test_export_geometry.py's.
"""

from __future__ import annotations

import math
import time

import bpy
import numpy as np
import pytest
from cotorra.export.buffers import SceneBuffers
from cotorra.log import Log
from mathutils import Euler, Matrix

from scenes import build
from scenes.depsgraphs import exported, exported_camera, exported_in_render, messages

NAN, INF = float('nan'), float('inf')
CAMERA, DIFFUSE, GLOSSY, TRANSMISSION, VOLUME, SHADOW = 1, 2, 4, 8, 16, 32


def transforms(buffers: SceneBuffers) -> dict[str, np.ndarray]:
    return dict(zip(buffers.instances.names, buffers.instances.transform, strict=True))


def matrix(value: Matrix) -> np.ndarray:
    return np.array(value, np.float32)[:3]


def test_empty_scene() -> None:
    buffers = exported(build.new_scene())
    assert not buffers.meshes and not len(buffers.instances.mesh) and not len(buffers.lights.type)
    assert buffers.instances.transform.shape == (0, 3, 4) and buffers.lights.transform.shape == (0, 3, 4)
    assert buffers.world.color == (0, 0, 0) and buffers.light_groups == ()
    assert len(buffers.materials.shader) == 1


def test_linked_duplicates_share_one_mesh() -> None:
    scene = build.new_scene()
    data = build.mesh()
    data.materials.append(build.material())
    for index in range(4):
        build.link(scene, f'Quad{index}', data).location.x = index
    buffers = exported(scene)
    instances = buffers.instances
    assert len(buffers.meshes) == 1 and instances.mesh.tolist() == [0, 0, 0, 0]
    assert instances.transform[:, 0, 3].tolist() == [0, 1, 2, 3]
    assert instances.names == ('Quad0', 'Quad1', 'Quad2', 'Quad3')
    assert instances.material_base.tolist() == [0, 0, 0, 0] and buffers.material_slots.tolist() == [1]


@pytest.mark.parametrize('scale', [(1, 1, 1), (-1, 1, 1), (2, 0.5, 3), (-2, -0.5, -3)])
def test_transform_is_object_to_world(scale: tuple) -> None:
    scene = build.new_scene()
    parent = build.link(scene, 'Parent', None)
    parent.matrix_world = Matrix.LocRotScale((1, 2, 3), Euler((0.3, 0.2, 0.1)), (1, 2, 1))
    obj = build.mesh_object(scene)
    obj.parent = parent  # turned under a non-uniform scale: sheared
    obj.matrix_local = Matrix.LocRotScale((4, 5, 6), Euler((1, 2, 3)), scale)
    buffers = exported(scene)
    assert np.array_equal(buffers.instances.transform[0], matrix(obj.matrix_world))
    assert (np.linalg.det(buffers.instances.transform[0][:, :3]) < 0) == (np.prod(scale) < 0)


def test_nested_collection_instances() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene, 'Leaf')
    obj.location.x = 1
    inner = build.collection_instance(scene, 'Inner', [obj])
    inner.location.y = 10
    twin = build.link(scene, 'Twin', None)
    twin.instance_type, twin.instance_collection = 'COLLECTION', inner.instance_collection
    twin.location.y, twin.scale = 20, (1, 1, -1)
    outer = build.collection_instance(scene, 'Outer', [inner, twin])
    outer.location.z = 100
    outer.scale = (2, 2, 2)
    buffers = exported(scene)
    assert len(buffers.meshes) == 1
    positions = sorted(buffers.instances.transform[:, :, 3].tolist())
    assert positions == [[2, 20, 100], [2, 40, 100]]
    assert sorted(np.linalg.det(buffers.instances.transform[:, :, :3]).tolist()) == pytest.approx([-8, 8])


def test_geometry_nodes_instances() -> None:
    """Instances on points, of an object and of a mesh that exists nowhere else."""
    scene = build.new_scene()
    obj = build.mesh_object(scene, 'Host', vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[(0, 1, 2)])
    shown = build.mesh_object(scene, 'Shown')
    shown.hide_render = shown.hide_viewport = True

    def points(tree: bpy.types.NodeTree) -> None:
        cube = tree.nodes.new('GeometryNodeMeshCube')
        info = tree.nodes.new('GeometryNodeObjectInfo')
        info.inputs['Object'].default_value = shown
        info.inputs['As Instance'].default_value = True
        join = tree.nodes.new('GeometryNodeJoinGeometry')
        for source in (cube.outputs['Mesh'], info.outputs['Geometry']):
            instance = tree.nodes.new('GeometryNodeInstanceOnPoints')
            tree.links.new(tree.nodes['In'].outputs[0], instance.inputs['Points'])
            tree.links.new(source, instance.inputs['Instance'])
            tree.links.new(instance.outputs[0], join.inputs[0])
        tree.links.new(join.outputs[0], tree.nodes['Out'].inputs[0])

    build.geometry_nodes(obj, points)
    buffers = exported(scene)
    counts = {name: len(mesh.triangles) for name, mesh in ((mesh.name, mesh) for mesh in buffers.meshes)}
    assert sorted(counts.values()) == [2, 12]
    assert len(buffers.instances.mesh) == 6
    for index in (0, 1):
        at = buffers.instances.transform[buffers.instances.mesh == index][:, :, 3]
        assert sorted(at.tolist()) == [[0, 0, 0], [0, 1, 0], [1, 0, 0]]


def test_materials_set_by_geometry_nodes() -> None:
    """They are in the evaluated mesh only; the object's own slots do not know them."""
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    green = build.material('Green', Base_Color=(0, 1, 0, 1))

    def paint(tree: bpy.types.NodeTree) -> None:
        setter = tree.nodes.new('GeometryNodeSetMaterial')
        setter.inputs['Material'].default_value = green
        tree.links.new(tree.nodes['In'].outputs[0], setter.inputs['Geometry'])
        tree.links.new(setter.outputs[0], tree.nodes['Out'].inputs[0])

    build.geometry_nodes(obj, paint)
    buffers = exported(scene)
    slot = buffers.instances.material_base[0] + (0 if buffers.meshes[0].slots is None else buffers.meshes[0].slots[0])
    assert buffers.materials.names[buffers.material_slots[slot]] == 'Green'


def test_particles() -> None:
    scene = build.new_scene()
    shown = build.mesh_object(scene, 'Shown')
    emitter = build.link(scene, 'Emitter', build.grid(4))
    system = emitter.modifiers.new('Particles', 'PARTICLE_SYSTEM').particle_system
    settings = system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 50, 0, 0, 100
    settings.physics_type, settings.render_type, settings.instance_object = 'NO', 'OBJECT', shown
    settings.particle_size = 0.25
    emitter.show_instancer_for_viewport = False
    scene.frame_set(2)
    buffers = exported(scene)
    assert len(buffers.meshes) == 1  # the emitter itself is hidden
    assert len(buffers.instances.mesh) == 51
    scales = np.linalg.norm(buffers.instances.transform[:, :, 0], axis=1)
    assert np.sort(scales) == pytest.approx([0.25] * 50 + [1.0], rel=1e-4)


def test_particle_hair_is_reported() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene, 'Scalp')
    system = obj.modifiers.new('Particles', 'PARTICLE_SYSTEM').particle_system
    system.settings.type = 'HAIR'
    assert messages(scene) == [
        f'Object "Scalp": hair of particle system "{system.name}" is not supported yet: left out'
    ]


def test_objects_hidden_from_rendering() -> None:
    scene = build.new_scene()
    build.camera(scene)
    build.mesh_object(scene, 'Seen')
    build.mesh_object(scene, 'Unseen').hide_render = True
    only_in_viewport = bpy.data.collections.new('Unseen too')
    scene.collection.children.link(only_in_viewport)
    only_in_viewport.hide_render = True
    only_in_viewport.objects.link(bpy.data.objects.new('Member', build.mesh()))
    [buffers] = exported_in_render(scene)
    assert buffers.instances.names == ('Seen',)
    assert set(exported(scene).instances.names) == {'Seen', 'Unseen', 'Member'}


def test_view_layers_show_their_collections() -> None:
    scene = build.new_scene()
    build.camera(scene)
    build.mesh_object(scene, 'Common')
    side = bpy.data.collections.new('Side')
    scene.collection.children.link(side)
    side.objects.link(bpy.data.objects.new('Sidekick', build.mesh()))
    second = scene.view_layers.new('Second')
    second.layer_collection.children['Side'].exclude = True
    third = scene.view_layers.new('Third')
    third.use_solid = False
    found = exported_in_render(scene)
    assert [set(buffers.instances.names) for buffers in found] == [{'Common', 'Sidekick'}, {'Common'}, set()]


def test_material_override_of_a_view_layer() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    obj.data.materials.append(build.material('Own'))
    obj.data.materials.append(build.material('Own too'))
    bpy.context.view_layer.material_override = build.material('Override', Base_Color=(1, 0, 0, 1))
    buffers = exported(scene)
    assert [buffers.materials.names[slot] for slot in buffers.material_slots] == ['Override']


@pytest.mark.parametrize(
    ('name', 'bit'),
    [
        ('visible_camera', CAMERA),
        ('visible_diffuse', DIFFUSE),
        ('visible_glossy', GLOSSY),
        ('visible_transmission', TRANSMISSION),
        ('visible_volume_scatter', VOLUME),
        ('visible_shadow', SHADOW),
    ],
)
@pytest.mark.parametrize('on', ['object', 'instancer'])
def test_ray_visibility(name: str, bit: int, on: str) -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    empty = build.collection_instance(scene, 'Instancer', [obj])
    setattr(obj if on == 'object' else empty, name, False)
    assert exported(scene).instances.visibility.tolist() == [127 - bit]


def test_object_that_no_ray_sees_is_left_out() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    for name in ('camera', 'diffuse', 'glossy', 'transmission', 'volume_scatter', 'shadow'):
        setattr(obj, f'visible_{name}', False)
    assert not exported(scene).meshes


def test_collections_of_a_view_layer() -> None:
    """'Indirect only' hides from the camera; 'holdout' is reported."""
    scene = build.new_scene()
    for name in ('Indirect', 'Holdout'):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        collection.objects.link(bpy.data.objects.new(name, build.mesh()))
    layers = bpy.context.view_layer.layer_collection.children
    layers['Indirect'].indirect_only = True
    layers['Holdout'].holdout = True
    log = Log()
    instances = exported(scene, log).instances
    assert dict(zip(instances.names, instances.visibility.tolist(), strict=True)) == {'Indirect': 126, 'Holdout': 127}
    assert log.texts('WARNING') == [
        'Object "Holdout": holdout is not supported yet: it is rendered as an ordinary object'
    ]


def test_shadow_catcher_is_reported() -> None:
    scene = build.new_scene()
    build.mesh_object(scene, 'Floor').is_shadow_catcher = True
    build.light(scene, 'POINT')  # lights carry the flag from the start, with another meaning
    assert messages(scene) == [
        'Object "Floor": shadow catcher is not supported yet: it is rendered as an ordinary object'
    ]


def test_pass_index_and_terminator() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    obj.pass_index = 7
    obj.shadow_terminator_geometry_offset = 0.25
    instances = exported(scene).instances
    assert instances.pass_index.tolist() == [7] and instances.terminator.tolist() == [0.25]


def test_light_groups() -> None:
    scene = build.new_scene()
    layer = bpy.context.view_layer
    for name in ('Key', 'Fill', 'Rim'):
        layer.lightgroups.add(name=name)
    own = build.mesh_object(scene, 'Own')
    own.lightgroup = 'Fill'
    build.mesh_object(scene, 'Unknown').lightgroup = 'Key'
    layer.lightgroups.remove(layer.lightgroups['Key'])
    inherited = build.mesh_object(scene, 'Inherited')
    build.collection_instance(scene, 'Instancer', [inherited]).lightgroup = 'Fill'
    both = build.mesh_object(scene, 'Both')
    both.lightgroup = 'Rim'
    build.collection_instance(scene, 'Other instancer', [both]).lightgroup = 'Fill'
    build.light(scene, 'POINT').lightgroup = 'Fill'
    world = build.world(scene)
    world.lightgroup = 'Fill'
    buffers = exported(scene)
    assert buffers.light_groups == ('Fill', 'Rim')
    found = dict(zip(buffers.instances.names, buffers.instances.light_group.tolist(), strict=True))
    assert found == {'Own': 0, 'Unknown': -1, 'Inherited': 0, 'Both': 1}, 'its own comes first, as in Cycles 5.2.3'
    assert buffers.lights.light_group.tolist() == [0] and buffers.world.light_group == 0
    # A world and a lamp without a group are in none.
    lamp = bpy.data.objects['Point']
    world.lightgroup = lamp.lightgroup = ''
    for changed in (world, lamp):
        changed.update_tag()  # as a click in the panel does; Blender 4.5 does not for a script
    buffers = exported(scene)
    assert buffers.lights.light_group.tolist() == [-1] and buffers.world.light_group == -1


# ---- What is no mesh.


def test_curves_text_metaballs_and_surfaces() -> None:
    """Blender lists each twice, as itself and as the mesh it makes."""
    scene = build.new_scene()
    curve = bpy.data.curves.new('Curve', 'CURVE')
    curve.bevel_depth = 0.1
    curve.splines.new('POLY').points.add(1)
    curve.splines[0].points[1].co = (1, 0, 0, 1)
    curve.materials.append(build.material('Wire'))
    text = bpy.data.curves.new('Text', 'FONT')
    text.body = 'A'
    ball = bpy.data.metaballs.new('Ball')
    ball.elements.new()
    for data in (curve, text, ball):
        build.link(scene, data.name, data)
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    buffers = exported(scene)
    assert sorted(buffers.instances.names) == sorted(['Curve', 'Text', 'Ball', bpy.context.object.name])
    assert all(len(mesh.triangles) > 3 for mesh in buffers.meshes) and len(buffers.meshes) == 4
    base = buffers.instances.material_base[buffers.instances.names.index('Curve')]
    assert buffers.materials.names[buffers.material_slots[base]] == 'Wire'
    assert not messages(scene)


def test_curve_without_thickness_is_silent() -> None:
    scene = build.new_scene()
    curve = bpy.data.curves.new('Path', 'CURVE')
    curve.splines.new('POLY').points.add(3)
    build.link(scene, 'Path', curve)
    assert not exported(scene).meshes and not messages(scene)


def test_curve_in_collection_instances() -> None:
    scene = build.new_scene()
    curve = bpy.data.curves.new('Curve', 'CURVE')
    curve.bevel_depth = 0.1
    curve.splines.new('POLY').points.add(1)
    curve.splines[0].points[1].co = (1, 0, 0, 1)
    obj = build.link(scene, 'Curve', curve)
    build.collection_instance(scene, 'Instancer', [obj], unlink=False).location.z = 3
    buffers = exported(scene)
    assert len(buffers.meshes) == 1
    assert sorted(buffers.instances.transform[:, 2, 3].tolist()) == [0, 3]


@pytest.mark.parametrize(
    ('kind', 'make'),
    [
        ('hair curves', lambda: bpy.data.hair_curves.new('Data')),
        ('point clouds', lambda: bpy.data.pointclouds.new('Data')),
        ('volumes', lambda: bpy.data.volumes.new('Data')),
    ],
)
def test_what_is_not_supported_is_named(kind: str, make) -> None:
    scene = build.new_scene()
    build.link(scene, 'Thing', make())
    assert messages(scene) == [f'Object "Thing": {kind} are not supported yet: left out']


def test_smoke_domain_is_reported() -> None:
    """Its mesh is a box around the smoke, which Cycles does not show."""
    scene = build.new_scene()
    domain = build.mesh_object(scene, 'Smoke').modifiers.new('Fluid', 'FLUID')
    domain.fluid_type = 'DOMAIN'
    domain.domain_settings.domain_type = 'GAS'
    log = Log()
    assert not exported(scene, log).meshes
    assert log.texts('WARNING') == ['Object "Smoke": smoke and fire are not supported yet: left out']


def test_without_the_cycles_addon() -> None:
    """Cycles' settings are its add-on's: without it, its defaults count."""
    import addon_utils  # Blender's; only there once bpy is

    scene = build.new_scene()
    build.mesh_object(scene).data.materials.append(build.material())
    build.light(scene, 'POINT')
    build.world(scene)
    build.camera(scene)
    scene.render.filter_size = 2.0
    with_addon = exported(scene)
    addon_utils.disable('cycles')
    try:
        assert not hasattr(scene, 'cycles')
        buffers = exported(scene)
        camera = exported_camera(scene)
    finally:
        addon_utils.enable('cycles')
    assert camera.filter_width == 2.0
    assert buffers.lights.max_bounces.tolist() == with_addon.lights.max_bounces.tolist()
    assert buffers.lights.use_mis.tolist() == with_addon.lights.use_mis.tolist()
    assert buffers.materials.emission_sampling.tolist() == with_addon.materials.emission_sampling.tolist()
    assert buffers.world == with_addon.world


# ---- Bad input.


@pytest.mark.parametrize('value', [NAN, INF])
def test_transform_that_is_not_finite(value: float) -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene, 'Lost')
    obj.delta_location.x = value
    obj.delta_scale.y = value
    obj.scale.y = 1e30
    build.mesh_object(scene, 'Quad')
    log = Log()
    buffers = exported(scene, log)
    if not np.isfinite(np.array(obj.matrix_world)).all():
        assert buffers.instances.names == ('Quad',)
        assert log.texts('WARNING') == ['Object "Lost": its transform holds NaN, infinity or numbers near it: left out']
    else:
        pytest.skip('this Blender makes a finite transform of it')


@pytest.mark.parametrize('scale', [(1, 1, 0), (0, 2, 1), (1e-20, 1e-20, 1e-20)])
def test_flat_and_tiny_objects_are_kept(scale: tuple) -> None:
    scene = build.new_scene()
    build.mesh_object(scene).scale = scale
    log = Log()
    assert len(exported(scene, log).instances.mesh) == 1 and not log.messages


@pytest.mark.parametrize('scale', [(0, 0, 1), (0, 0, 0)])
def test_objects_without_extent_are_left_out(scale: tuple) -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene, 'Gone')
    obj.scale = scale
    obj.rotation_euler = (0.3, 0.2, 0.1)
    build.link(scene, 'Quad', obj.data)
    log = Log()
    assert exported(scene, log).instances.names == ('Quad',)
    assert log.texts('WARNING') == ['Object "Gone": its scale is zero along two axes: left out']


def test_object_without_data() -> None:
    scene = build.new_scene()
    build.link(scene, 'Empty', None)
    assert not exported(scene).meshes


# ---- Many.


def test_ten_thousand_instances_share_everything() -> None:
    scene = build.new_scene()
    shown = build.mesh_object(scene, 'Shown')
    for index in range(3):
        shown.data.materials.append(build.material(f'Material {index}'))
    shown.data.polygons[0].material_index = 2
    points = np.stack(np.meshgrid(np.arange(100), np.arange(100), [0]), axis=-1).reshape(-1, 3)
    build.vertex_instances(scene, shown, points)
    buffers = exported(scene)
    instances = buffers.instances
    assert len(buffers.meshes) == 1 and buffers.material_slots.tolist() == [1, 2, 3]
    assert len(instances.mesh) == 10_000 + 1
    assert set(instances.material_base.tolist()) == {0} and set(instances.material_count.tolist()) == {3}
    arrays = (instances.mesh, instances.transform, instances.material_base, instances.material_count)
    arrays += (instances.pass_index, instances.visibility, instances.light_group, instances.terminator)
    assert sum(array.nbytes for array in arrays) <= 100 * len(instances.mesh)
    places = {tuple(place) for place in instances.transform[:, :, 3].round().astype(int).tolist()}
    assert places == {(x, y, 0) for x in range(100) for y in range(100)}


def test_hundred_thousand_instances_are_quick() -> None:
    """Measured 0.19 s on two cores; reading each instance's matrix and properties would take several seconds."""
    scene = build.new_scene()
    shown = build.mesh_object(scene, 'Shown')
    build.vertex_instances(scene, shown, np.random.default_rng(1).random((100_000, 3)))
    bpy.context.evaluated_depsgraph_get()
    began = time.perf_counter()
    buffers = exported(scene)
    assert time.perf_counter() - began < 1.5
    assert len(buffers.instances.mesh) == 100_001


def test_export_twice_is_the_same() -> None:
    scene = build.new_scene()
    shown = build.mesh_object(scene, 'Shown', smooth=True)
    shown.rotation_euler.z = math.radians(30)
    build.vertex_instances(scene, shown, np.random.default_rng(1).random((100, 3)))
    first, second = exported(scene), exported(scene)
    assert first.instances.transform.tobytes() == second.instances.transform.tobytes()
    assert first.meshes[0].normals.tobytes() == second.meshes[0].normals.tobytes()
    assert first.instances.names == second.instances.names
