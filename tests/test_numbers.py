# SPDX-License-Identifier: GPL-3.0-or-later
"""NaN, infinity and numbers near it, wherever Blender lets them through: a picture of finite numbers, and a warning.

Every number that is read is set, one at a time; what Blender itself refuses or clamps is no case.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from cotorra import choices, cycles_settings, native, stats
from cotorra.export import bounds
from cotorra.export.buffers import PASSES as PASS_CHANNELS
from cotorra.export.buffers import Camera, RenderSettings, SceneBuffers
from cotorra.log import Log
from cotorra.viewport import preview

from classic_scenes import Lamp, Material, camera, exported, quad, session
from render_calls import read_exr, render_to
from scenes import build
from vulkan_jobs import Job

pytestmark = pytest.mark.usefixtures('engine')

NAN, INF, HUGE = math.nan, math.inf, 3.4e38
VALUES = (NAN, INF, HUGE, -HUGE)
PASSES = ('z', 'position', 'normal', 'uv', 'diffuse_color', 'emit', 'environment', 'shadow', 'ambient_occlusion')
INTEGRATORS = [identifier for identifier, _, _ in choices.INTEGRATORS]


@pytest.fixture
def scene() -> bpy.types.Scene:
    """A square under each kind of lamp in a grey world, seen with all passes."""
    made = build.new_scene()
    build.camera(made).location = (0.0, 0.0, 5.0)
    for x, kind in enumerate(('POINT', 'SPOT', 'SUN')):
        build.light(made, kind, energy=3.0).location = (x, 0.0, 3.0)
    build.world(made, (0.5, 0.5, 0.5))
    square = build.mesh_object(made, 'Square')
    square.data.uv_layers.new(name='UVMap')
    square.data.materials.append(build.material('Clear', Alpha=0.75, Emission_Strength=0.5))
    layer = made.view_layers[0]
    for name in PASSES:
        setattr(layer, f'use_pass_{name}', True)
    for name in ('distribution', 'masking', 'fresnel', 'lights'):
        setattr(layer.cotorra, f'use_pass_{name}', True)
    layer.lightgroups.add(name='Key')
    made.world.lightgroup = 'Key'
    made.render.engine = 'COTORRA'
    made.render.resolution_x = made.render.resolution_y = 4
    made.cotorra.samples = 2
    return made


def render(scene: bpy.types.Scene, path: Path) -> list[str]:
    """The warnings of a render whose every pass is finite; a RuntimeError where Blender reports a failure."""
    found = read_exr(render_to(scene, path / 'image.exr', multilayer=True))
    lost = [f'{layer}.{name}' for layer in found for name, p in found[layer].items() if not np.isfinite(p).all()]
    assert len(found) > 14 and not lost, f'not finite: {lost}'
    return stats.last(scene.name)[0].warnings


def changes(owner: Any, names: list[str], values: tuple[float, ...]) -> Iterator[tuple[str, bool]]:
    """Set each number to each of the values in turn; yields what was set, and whether it is as bad as that."""
    for name in names:
        before = getattr(owner, name)
        array = not isinstance(before, (int, float))
        before = tuple(before) if array else before
        for value in values:
            setattr(owner, name, (value, *before[1:]) if array else value)
            got = getattr(owner, name)
            got = got[0] if array else got
            yield f'{name} = {value}', not abs(got) <= bounds.LARGEST
        setattr(owner, name, before)


def numbers(owner: Any) -> list[str]:
    """The numbers of a group of settings: all of ours, of Blender's those that we read."""
    groups = cycles_settings.GROUPS
    kinds = [kind for kind in (owner.bl_rna, owner.bl_rna.base) if kind is not None and kind.identifier in groups]
    read = {name for kind in kinds for name in groups[kind.identifier].read.split()}
    found = [p.identifier for p in owner.bl_rna.properties if p.type == 'FLOAT' and not p.is_readonly]
    return [name for name in found if name in read or not kinds]


def survive(
    scene: bpy.types.Scene,
    owner: Any,
    path: Path,
    names: list[str] | None = None,
    values: tuple[float, ...] = VALUES,
) -> dict[str, list[str]]:
    """Render with each change: the warnings of those that let a bad number through."""
    told = {}
    for change, bad in changes(owner, numbers(owner) if names is None else names, values):
        try:
            found = render(scene, path)
        except (AssertionError, RuntimeError) as problem:
            pytest.fail(f'{change}: {problem}')
        if bad:
            told[change] = found
    return told


def all_named(told: dict[str, list[str]], owner: str, *names: str) -> None:
    """Those of the properties that a bad number got into had a warning that begins with their owner."""
    for change, found in told.items():
        if change.split(' ')[0] in names:
            assert any(text.startswith(owner) for text in found), (change, found)


@pytest.mark.parametrize('integrator', INTEGRATORS)
def test_settings_of_the_scene(scene, tmp_path, integrator):
    own = scene.cotorra
    own.integrator, own.use_reinhard, own.use_ambient_occlusion, own.ambient_strength = integrator, True, True, 0.5
    own.use_adaptive_sampling = True
    names = [name for name in numbers(own) if not name.startswith('preview_')]  # the viewport's alone
    told = survive(scene, own, tmp_path, names, values=(NAN, HUGE))
    assert {'ambient_color = nan', 'reinhard_white = nan', 'outline_width = nan'} <= told.keys()
    all_named(told, 'Scene "Scene": ', *names)


@pytest.mark.parametrize('value', [NAN, HUGE])
def test_settings_of_the_viewport(scene, value):
    """What the native module would refuse does not reach it."""
    scene.cotorra.settings_from = 'COTORRA'
    scene.cotorra.preview_noise_threshold = value
    log = Log()
    found = preview.render_settings(scene, bpy.context.view_layer, 'COMBINED', log)
    assert 0.0 < found.noise_threshold < 1e16
    assert bool(log.texts('WARNING')) == math.isnan(scene.cotorra.preview_noise_threshold)


def test_settings_for_cycles_and_the_world(scene, tmp_path):
    told = survive(scene, scene.cycles, tmp_path, ['film_exposure', 'filter_width'])
    told |= survive(scene, scene.world.light_settings, tmp_path, ['distance'])
    all_named(told, 'Scene "Scene": ', 'film_exposure', 'filter_width', 'distance')
    assert 'film_exposure = nan' in told


@pytest.mark.parametrize('kind', ['PERSP', 'ORTHO'])
def test_cameras(scene, tmp_path, kind):
    scene.camera.data.type = kind
    told = survive(scene, scene.camera.data, tmp_path)
    all_named(told, 'Camera "Camera": ', 'lens', 'ortho_scale', 'shift_x', 'shift_y', 'clip_start', 'clip_end')
    assert 'shift_x = inf' in told and 'ortho_scale = 3.4e+38' in told
    told = survive(scene, scene.render, tmp_path, ['pixel_aspect_x'])
    all_named(told, 'Camera "Camera": ', 'pixel_aspect_x')


def test_a_camera_far_away(scene, tmp_path):
    scene.camera.location.z = HUGE
    assert any(text.startswith('Camera "Camera": its place') for text in render(scene, tmp_path))


def test_looking_through_a_spot_light(scene, tmp_path):
    scene.camera = scene.objects['Spot']
    survive(scene, scene.camera.data, tmp_path, ['spot_size'])


@pytest.mark.parametrize('kind', ['Point', 'Spot', 'Sun'])
def test_lights(scene, tmp_path, kind):
    light = scene.objects[kind].data
    told = survive(scene, light, tmp_path)
    assert {'energy = nan', 'exposure = nan', 'color = nan'} <= told.keys()
    used = set(numbers(light)) - {'temperature'}  # which is not in use
    all_named(told, f'Light "{kind}": ', *used)
    if kind != 'Sun':
        light.cotorra.falloff = 'RANGED'
        told = survive(scene, light.cotorra, tmp_path, ['range'])
        light.cotorra.falloff = 'POLYNOMIAL'
        told |= survive(scene, light.cotorra, tmp_path, ['c0', 'c1', 'c2'])
        assert 'range = nan' in told and 'c1 = nan' in told
        all_named(told, f'Light "{kind}": ', 'range', 'c0', 'c1', 'c2')


@pytest.mark.parametrize('edge', ['LINEAR', 'SQUARED'])
def test_edges_of_spots(scene, tmp_path, edge):
    own = scene.objects['Spot'].data.cotorra
    own.spot_edge = edge
    told = survive(scene, own, tmp_path, ['inner_angle', 'outer_angle'])
    all_named(told, 'Light "Spot": ', 'inner_angle', 'outer_angle')


@pytest.mark.parametrize('kind', ['Point', 'Spot', 'Sun', 'Square'])
def test_places(scene, tmp_path, kind):
    owner = 'Object "Square": ' if kind == 'Square' else f'Light "{kind}": '
    told = survive(scene, scene.objects[kind], tmp_path, ['location', 'scale', 'rotation_euler'])
    assert 'rotation_euler = nan' in told
    all_named(told, owner, 'location', 'scale')


def test_shadow_terminators(scene, tmp_path):
    survive(scene, scene.objects['Square'], tmp_path, ['shadow_terminator_geometry_offset'])


@pytest.mark.parametrize('integrator', INTEGRATORS)
def test_sockets_of_materials(scene, tmp_path, integrator):
    scene.cotorra.integrator = integrator
    node = build.principled(bpy.data.materials['Clear'])
    named = {'Base Color', 'Emission Color', 'Emission Strength', 'IOR'}
    for name in (*named, 'Roughness', 'Alpha', 'Specular Tint', 'Transmission Weight'):
        told = survive(scene, node.inputs[name], tmp_path, ['default_value'], (NAN, HUGE))
        if name in named:
            assert told
            all_named(told, 'Material "Clear": ', 'default_value')


def test_emission_and_colours_of_worlds(scene, tmp_path):
    node = next(node for node in scene.world.node_tree.nodes if node.type == 'BACKGROUND')
    for socket in (node.inputs['Color'], node.inputs['Strength']):
        told = survive(scene, socket, tmp_path, ['default_value'])
        all_named(told, 'World "World": ', 'default_value')
        assert told


def test_products_of_numbers_that_are_in_order(scene, tmp_path):
    """Each is below the limit, all together are not: the film rejects what overflows."""
    for lamp in ('Point', 'Spot', 'Sun'):
        light = scene.objects[lamp].data
        light.energy, light.exposure = 1e14, 3.0
    scene.objects['Sun'].data.angle = 1e-6
    node = build.principled(bpy.data.materials['Clear'])
    node.inputs['Base Color'].default_value = node.inputs['Emission Color'].default_value = (9e14, 9e14, 9e14, 1.0)
    render(scene, tmp_path)


@pytest.mark.parametrize('model', ['PHONG', 'COOK_TORRANCE', 'TOON'])  # between them they read all
def test_reflection_models(scene, tmp_path, model):
    scene.cotorra.use_model_override = True
    scene.cotorra.model_override.model = model
    survive(scene, scene.cotorra.model_override, tmp_path, values=(NAN, HUGE))


def test_uv_maps(scene, tmp_path):
    uv = scene.objects['Square'].data.uv_layers[0].uv
    told = {}
    for value in VALUES:
        uv.foreach_set('vector', np.full(8, value, np.float32))
        told[value] = render(scene, tmp_path)
    assert all(any(text.startswith('Object "Square": UV map "UVMap"') for text in found) for found in told.values())


@pytest.mark.parametrize('value', VALUES)
def test_vertices(scene, tmp_path, value):
    mesh = scene.objects['Square'].data
    mesh.attributes['position'].data.foreach_set('vector', np.array([*[0.0] * 9, value, 0.0, 0.0], np.float32))
    mesh.update()
    assert any(text.startswith('Object "Square": 1 vertices') for text in render(scene, tmp_path))


@pytest.mark.parametrize('value', VALUES)
def test_texels(scene, tmp_path, value):
    image = bpy.data.images.new('Bright', 2, 2, float_buffer=True)
    image.pixels.foreach_set(np.array([value] * 3 + [1.0] * 13, np.float32))
    tree = bpy.data.materials['Clear'].node_tree
    texture = build.node(tree, 'TexImage')
    texture.image = image
    shader = build.principled(bpy.data.materials['Clear'])
    for name in ('Base Color', 'Emission Color', 'Alpha'):
        build.connect(tree, texture.outputs['Color'], shader.inputs[name])
    found = render(scene, tmp_path)
    if not math.isfinite(value):
        assert any(text.startswith('Image "Bright": ') for text in found)


@pytest.mark.parametrize('value', VALUES)
@pytest.mark.parametrize('socket', ['Location', 'Rotation', 'Scale'])
def test_mappings_of_textures(scene, tmp_path, socket, value):
    image = bpy.data.images.new('Grey', 2, 2)
    tree = bpy.data.materials['Clear'].node_tree
    texture, mapping, uv = (build.node(tree, kind) for kind in ('TexImage', 'Mapping', 'TexCoord'))
    texture.image = image
    build.connect(tree, uv.outputs['UV'], mapping.inputs['Vector'])
    build.connect(tree, mapping.outputs['Vector'], texture.inputs['Vector'])
    build.connect(tree, texture.outputs['Color'], build.principled(bpy.data.materials['Clear']).inputs['Base Color'])
    mapping.inputs[socket].default_value[0] = value
    render(scene, tmp_path)


@pytest.mark.parametrize('value', VALUES)
@pytest.mark.parametrize('operation', ['ADD', 'MULTIPLY', 'DIVIDE', 'SUBTRACT', 'LESS_THAN', 'GREATER_THAN', 'POWER'])
def test_arithmetic_of_textures(scene, tmp_path, operation, value):
    tree = bpy.data.materials['Clear'].node_tree
    texture, maths = build.node(tree, 'TexImage'), build.node(tree, 'Math')
    texture.image = bpy.data.images.new('Grey', 2, 2)
    maths.operation = operation
    build.connect(tree, texture.outputs['Color'], maths.inputs[0])
    maths.inputs[1].default_value = value
    shader = build.principled(bpy.data.materials['Clear'])
    for name in ('Roughness', 'Emission Strength', 'Alpha'):
        build.connect(tree, maths.outputs[0], shader.inputs[name])
    render(scene, tmp_path)


def test_a_driver_that_divides_by_zero(scene, tmp_path):
    """Drivers go another way than Python: they clamp, and let NaN through."""
    for path in ('reinhard_white', 'ambient_strength'):
        driver = scene.driver_add(f'cotorra.{path}').driver
        driver.expression = 'float("nan")'
    scene.cotorra.use_reinhard = True
    scene.frame_set(2)
    render(scene, tmp_path)


# ---- What the border does not see, such as products of numbers that are in order: written into the arrays here.

NATIVE_PASSES = (*PASS_CHANNELS, 'light:0')


def overflowing(value: float) -> tuple[SceneBuffers, Camera]:
    """A square over half of the picture, the background over the other, all of it with this value for its light."""
    made = Material((value,) * 3, roughness=0.5, specular_level=0.5, emission=(value,) * 3)
    lamps = [Lamp('SUN', (value,) * 3), Lamp('POINT', (value,) * 3, (0.5, 0.0, 1.0))]
    scene = exported([quad((0, -1, 0), (1, 0, 0), (0, 2, 0), made)], lamps, (value,) * 3)
    scene = replace(scene, lights=replace(scene.lights, pass_index=np.array([0, -1], np.int32)))
    return scene, camera((4, 4), (0, 0, 1), (0, 0, -1), window=2.0)


@pytest.mark.parametrize('value', [NAN, INF, 3e38])
@pytest.mark.parametrize('integrator', [name for name in INTEGRATORS if name != 'AUTO'])  # to the film, it is another
def test_the_film_takes_finite_numbers_only(integrator, value):
    scene, view = overflowing(value)
    built = native.load().Scene(scene, threads=1, embree=native.embree_library())
    run = session(built, view, integrator, samples=4, passes=NATIVE_PASSES)
    for name in NATIVE_PASSES:
        out = np.full((4, 4, PASS_CHANNELS.get(name, 3)), NAN, np.float32)
        run.read(name, out)
        assert np.isfinite(out).all(), name


@pytest.mark.every(3)
@pytest.mark.parametrize('value', [NAN, INF, 3e38])
def test_the_film_of_a_graphics_card_takes_finite_numbers_only(module, value):
    scene, view = overflowing(value)
    job = Job(module, scene, view, RenderSettings(samples=4, passes=NATIVE_PASSES))
    found, _ = job.render('VULKAN')
    assert not [name for name, pixels in found.items() if not np.isfinite(pixels).all()]
