# SPDX-License-Identifier: GPL-3.0-or-later
"""Falloffs and spot edges of lamps: whole renders against the formulas in double precision, and where they might fail.

Lamps that fall off as Blender's do are compared with Cycles elsewhere.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import cotorra_native
import numpy as np
import pytest
from cotorra import native, stats
from cotorra.export.buffers import RenderSettings, SceneBuffers
from mathutils import Euler, Matrix

from render_calls import read_exr, render_to
from scenes import build
from scenes.depsgraphs import exported, exported_camera

pytestmark = pytest.mark.usefixtures('engine')

# The kernels compute in single precision: a handful of roundings of 6e-8, and a ramp's slope times those.
EXACT = 1e-5
ALBEDO = 0.8
ENERGY = 100.0


@pytest.fixture
def scene() -> bpy.types.Scene:
    """A grey matte plane, 8 m wide, seen from above at one sample a pixel."""
    made = build.new_scene()
    camera = build.camera(made, type='ORTHO', ortho_scale=6.0)
    camera.location = (0.0, 0.0, 50.0)
    plane = build.mesh_object(made, 'Plane', vertices=[(4 * x, 4 * y, 0) for x, y, _ in build.QUAD])
    plane.data.materials.append(matte())
    made.render.engine = 'COTORRA'
    made.render.resolution_x = made.render.resolution_y = 48
    made.cotorra.integrator, made.cotorra.samples = 'DIRECT', 1
    made.cotorra.use_sample_sharing = False  # each pixel shows the point that its sample saw
    made.view_layers[0].use_pass_position = True
    return made


def matte() -> bpy.types.Material:
    made = build.with_nodes(bpy.data.materials.new('Matte'))
    diffuse = build.node(made.node_tree, 'BsdfDiffuse', Color=(ALBEDO, ALBEDO, ALBEDO, 1.0))
    build.connect(made.node_tree, diffuse.outputs[0], build.output(made.node_tree).inputs['Surface'])
    return made


def lamp(scene: bpy.types.Scene, kind: str, shape: dict[str, Any], **settings: Any) -> bpy.types.Object:
    obj = build.light(scene, kind, **{'energy': ENERGY, 'shadow_soft_size': 0.0} | settings)
    for name, value in shape.items():
        setattr(obj.data.cotorra, name, value)
    return obj


def rendered(scene: bpy.types.Scene, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Combined's red, and the points that the samples saw, in double precision."""
    found = read_exr(render_to(scene, folder / 'image.exr', multilayer=True))
    position = found['ViewLayer.Position']
    points = np.stack([position[axis] for axis in 'XYZ'], axis=-1).astype(np.float64)
    return found['ViewLayer.Combined']['R'].astype(np.float64), points


def warnings(scene: bpy.types.Scene) -> list[str]:
    return stats.last(scene.name)[-1].warnings


# ---- The formulas, of models.md


def falloff(shape: dict[str, Any], d: np.ndarray) -> np.ndarray:
    if shape.get('falloff') == 'RANGED':
        return np.maximum(np.minimum(1.0 - (d / shape['range']) ** 4, 1.0), 0.0) / d**2
    if shape.get('falloff') == 'POLYNOMIAL':
        return 1.0 / (shape['c0'] + shape['c1'] * d + shape['c2'] * d**2)
    return 1.0 / d**2


def edge(shape: dict[str, Any], theta: np.ndarray) -> np.ndarray:
    # Blender keeps angles in single precision.
    inner, outer = (float(np.float32(shape[f'{name}_angle'])) for name in ('inner', 'outer'))
    if inner == outer:
        return np.where(theta < outer, 1.0, 0.0)
    if shape['spot_edge'] == 'LINEAR':
        return np.clip((outer - theta) / (outer - inner), 0.0, 1.0)
    ramp = (np.cos(theta) - math.cos(outer)) / (math.cos(inner) - math.cos(outer))
    return np.clip(ramp, 0.0, 1.0) ** 2


def lit(points: np.ndarray, obj: bpy.types.Object, shape: dict[str, Any]) -> np.ndarray:
    """The matte plane under the lamp, without size."""
    place = np.array(obj.matrix_world, np.float64)
    to_light = place[:3, 3] - points
    d = np.linalg.norm(to_light, axis=-1)
    wi = to_light / d[..., None]
    value = ALBEDO / math.pi * wi[..., 2] * ENERGY / (4.0 * math.pi) * falloff(shape, d)
    if 'spot_edge' in shape:
        # The cone lies in the lamp's own space: a lamp that is scaled has another cone.
        local = wi @ np.linalg.inv(place[:3, :3]).T
        value = value * edge(shape, np.arccos(local[..., 2] / np.linalg.norm(local, axis=-1)))
    return value


def assert_equal(
    found: np.ndarray, wanted: np.ndarray, near_edge: np.ndarray | bool = False, rounding: float = 1e-6
) -> None:
    assert np.isfinite(found).all()
    wrong = (np.abs(found - wanted) > EXACT * wanted + rounding * wanted.max()) & ~np.asarray(near_edge)
    assert not wrong.any(), f'{wrong.sum()} pixels, the worst off by {np.abs(found - wanted)[wrong].max():g}'


FALLOFFS = [
    {'falloff': 'RANGED', 'range': 2.0},
    {'falloff': 'RANGED', 'range': 1000.0},
    {'falloff': 'POLYNOMIAL', 'c0': 1.0, 'c1': 0.0, 'c2': 0.0},
    {'falloff': 'POLYNOMIAL', 'c0': 0.0, 'c1': 0.7, 'c2': 0.0},
    {'falloff': 'POLYNOMIAL', 'c0': 0.5, 'c1': 0.25, 'c2': 2.0},
    {'falloff': 'PHYSICAL'},
]


@pytest.mark.parametrize('shape', FALLOFFS, ids=lambda shape: '-'.join(str(part) for part in shape.values()))
def test_a_point_light_over_a_plane(shape, scene, tmp_path):
    obj = lamp(scene, 'POINT', shape)
    obj.location = (0.3, -0.2, 1.5)
    found, points = rendered(scene, tmp_path)
    wanted = lit(points, obj, shape)
    assert wanted.max() > 0.1
    assert_equal(found, wanted)


ANGLES = [(0.2, 0.6), (0.0, 0.8), (0.5, 0.55), (0.0, math.pi / 2)]


@pytest.mark.parametrize('kind', ['LINEAR', 'SQUARED'])
@pytest.mark.parametrize('angles', ANGLES, ids=str)
def test_a_spot_over_a_plane(kind, angles, scene, tmp_path):
    shape = {'spot_edge': kind, 'inner_angle': angles[0], 'outer_angle': angles[1], 'falloff': 'RANGED', 'range': 5.0}
    obj = lamp(scene, 'SPOT', shape, spot_size=0.1)  # Blender's own angle does not matter then
    obj.matrix_world = Matrix.LocRotScale((0.3, -0.2, 2.0), Euler((0.3, 0.2, 0.0)), (1.0, 1.0, 1.0))
    bpy.context.view_layer.update()
    found, points = rendered(scene, tmp_path)
    wanted = lit(points, obj, shape)
    assert wanted.max() > 0.1 and (wanted == 0.0).any() == (angles[1] < 1.5)
    # Toward the end a ramp goes to 0, and the rounding of the angle (1e-7) over its width is all that is left of it.
    assert_equal(found, wanted, rounding=max(1e-6, 1e-7 / max(angles[1] - angles[0], 1e-3)))


def test_a_scaled_spot_has_the_cone_of_its_own_space(scene, tmp_path):
    shape = {'spot_edge': 'LINEAR', 'inner_angle': 0.2, 'outer_angle': 0.6}
    obj = lamp(scene, 'SPOT', shape)
    obj.matrix_world = Matrix.LocRotScale((0.0, 0.0, 2.0), Euler((0.2, 0.0, 0.4)), (2.0, 0.5, 1.0))
    bpy.context.view_layer.update()
    found, points = rendered(scene, tmp_path)
    assert_equal(found, lit(points, obj, shape))


# ---- Lamps of size


def with_and_without(scene: bpy.types.Scene, obj: bpy.types.Object, folder: Path) -> tuple[np.ndarray, ...]:
    """The picture by the lamp's falloff and by Blender's, by the same samples; and the points."""
    found, points = rendered(scene, folder)
    name, obj.data.cotorra.falloff = obj.data.cotorra.falloff, 'PHYSICAL'
    plain, _ = rendered(scene, folder)
    obj.data.cotorra.falloff = name
    return found, plain, points


@pytest.mark.parametrize('disk', [False, True])
@pytest.mark.parametrize('shape', FALLOFFS[:5], ids=lambda shape: '-'.join(str(part) for part in shape.values()))
def test_a_lamp_of_size_is_dimmed_by_the_distance_to_its_centre(shape, disk, scene, tmp_path):
    obj = lamp(scene, 'POINT', shape, shadow_soft_size=0.4, use_soft_falloff=disk)
    obj.location = (0.3, -0.2, 1.5)
    found, plain, points = with_and_without(scene, obj, tmp_path)
    d = np.linalg.norm(points - np.array(obj.location), axis=-1)
    assert_equal(found, plain * falloff(shape, d) * d**2)


def test_a_lamp_that_the_camera_sees_is_dimmed_alike(scene, tmp_path):
    """Light that a ray finds must be the light that is sampled: the same factor, at the ray's origin."""
    scene.cycles.filter_width = 0.01
    obj = lamp(scene, 'POINT', {'falloff': 'RANGED', 'range': 60.0}, shadow_soft_size=0.5, use_soft_falloff=False)
    obj.location = (0.0, 0.0, 20.0)
    obj.visible_camera = True
    found, plain, _ = with_and_without(scene, obj, tmp_path)
    middle = (24, 24)
    assert plain[middle] > 1.0
    assert found[middle] / plain[middle] == pytest.approx(1.0 - (30.0 / 60.0) ** 4, rel=1e-4)


def test_sharp_gloss_gets_the_same_light_by_rays_as_by_sampling(scene, tmp_path):
    """Multiple importance sampling is unbiased only if both techniques tell of the same lamp."""
    shape = {'falloff': 'RANGED', 'range': 2.5, 'spot_edge': 'LINEAR', 'inner_angle': 0.3, 'outer_angle': 0.6}
    obj = lamp(scene, 'SPOT', shape, shadow_soft_size=0.3)
    obj.location = (0.0, 0.0, 1.5)
    mirror = build.material('Gloss', Metallic=1.0, Roughness=0.2)
    bpy.data.objects['Plane'].data.materials[0] = mirror
    scene.cotorra.integrator, scene.cotorra.samples = 'PATH', 1024
    shared, _ = rendered(scene, tmp_path)
    assert 'light found by bounces' in stats.last(scene.name)[-1].features
    obj.data.cycles.use_multiple_importance_sampling = False
    sampled, _ = rendered(scene, tmp_path)
    # The two means were 0.007 % apart, and 0.7 % with a quarter of the samples.
    assert shared.mean() > 0.01 and shared.mean() == pytest.approx(sampled.mean(), rel=0.005)


def test_many_lamps_of_all_shapes_are_picked_without_bias(scene, tmp_path):
    """Beyond eight lamps some are picked by importance: the mean must be the sum of each lamp alone."""
    rng = np.random.default_rng(5)
    lamps = []
    for index in range(12):
        shape = dict(FALLOFFS[index % 5])
        kind = 'SPOT' if index % 2 else 'POINT'
        if kind == 'SPOT':
            shape |= {'spot_edge': ('LINEAR', 'SQUARED')[index // 2 % 2], 'inner_angle': 0.1, 'outer_angle': 0.7}
        lamps.append(lamp(scene, kind, shape, energy=ENERGY, shadow_soft_size=0.3 * (index % 3)))
        lamps[-1].location = (*rng.uniform(-2.0, 2.0, 2), rng.uniform(0.5, 2.0))
    scene.cotorra.samples = 32
    together, _ = rendered(scene, tmp_path)
    alone = []
    for shown in lamps:
        for other in lamps:
            other.hide_render = other is not shown
        alone.append(rendered(scene, tmp_path)[0].mean())
    assert together.mean() == pytest.approx(sum(alone), rel=0.01)


@pytest.mark.parametrize('shape', [{}, {'spot_edge': 'LINEAR', 'inner_angle': 0.39, 'outer_angle': 0.4}], ids=str)
def test_a_spot_of_size_keeps_its_penumbra_among_many_lamps(shape, scene, tmp_path):
    """Past the edge of the cone about its centre a lamp still sends light: it must not be left out when picked."""
    scene.cotorra.samples = 64
    spot = lamp(scene, 'SPOT', shape, shadow_soft_size=0.19, spot_size=0.8, spot_blend=0.0)
    spot.location = (0.0, 0.0, 2.2)
    alone, points = rendered(scene, tmp_path)
    for index in range(9):
        lamp(scene, 'POINT', {}, energy=1e-3).location = (3.9, 3.9, 0.1 + 0.1 * index)
    among, _ = rendered(scene, tmp_path)
    outside = np.hypot(points[..., 0], points[..., 1]) - 2.2 * math.tan(0.4)
    ring = (outside > 0.0) & (outside < 0.25)
    assert alone[ring].mean() > 0.02
    assert among[ring].mean() == pytest.approx(alone[ring].mean(), rel=0.02)


# ---- Where methods fail


def test_inner_angle_equal_to_the_outer_is_a_hard_edge(scene, tmp_path):
    for kind in ('LINEAR', 'SQUARED'):
        shape = {'spot_edge': kind, 'inner_angle': 0.5, 'outer_angle': 0.5}
        obj = lamp(scene, 'SPOT', shape)
        obj.location = (0.0, 0.0, 2.0)
        bpy.context.view_layer.update()
        found, points = rendered(scene, tmp_path)
        theta = np.arctan2(np.hypot(points[..., 0], points[..., 1]), 2.0)
        assert_equal(found, lit(points, obj, shape), near_edge=np.abs(theta - 0.5) < 1e-6)
        bpy.data.objects.remove(obj)


def test_an_inner_angle_beyond_the_outer_is_the_outer_and_told(scene, tmp_path):
    shape = {'spot_edge': 'LINEAR', 'inner_angle': 0.9, 'outer_angle': 0.5}
    obj = lamp(scene, 'SPOT', shape)
    obj.location = (0.0, 0.0, 2.0)
    bpy.context.view_layer.update()
    found, points = rendered(scene, tmp_path)
    assert_equal(found, lit(points, obj, shape | {'inner_angle': 0.5}))
    assert any('Light "Spot"' in text and 'inner angle' in text for text in warnings(scene))


DARK = {
    'range 0': ('POINT', {'falloff': 'RANGED', 'range': 0.0}, 'range'),
    'c0 = c1 = c2 = 0': ('POINT', {'falloff': 'POLYNOMIAL', 'c0': 0.0, 'c1': 0.0, 'c2': 0.0}, 'c0, c1 and c2'),
    'outer angle 0': ('SPOT', {'spot_edge': 'LINEAR', 'inner_angle': 0.0, 'outer_angle': 0.0}, 'outer angle'),
}


@pytest.mark.parametrize('name', DARK)
def test_a_lamp_that_lights_nothing_is_dark_and_told(name, scene, tmp_path):
    kind, shape, word = DARK[name]
    lamp(scene, kind, shape).location = (0.0, 0.0, 1.5)
    found, _ = rendered(scene, tmp_path)
    assert np.all(found == 0.0)
    (told,) = warnings(scene)
    assert f'Light "{kind.title()}"' in told and word in told and 'lights nothing' in told


@pytest.mark.parametrize('name', ['range', 'c1', 'inner_angle'])
def test_a_setting_that_is_no_number_is_told(name, scene, tmp_path):
    shape = {'falloff': 'POLYNOMIAL' if name == 'c1' else 'RANGED', 'spot_edge': 'LINEAR'}
    obj = lamp(scene, 'SPOT', shape | {name: math.nan})
    obj.location = (0.0, 0.0, 1.5)
    found, _ = rendered(scene, tmp_path)
    assert np.isfinite(found).all() and found.max() > 0.0
    words = name.replace('_', ' ').replace('c1', 'polynomial')
    assert any(f'Light "Spot": {words} is not a finite number' in text for text in warnings(scene))


@pytest.mark.parametrize('radius', [0.0, 0.2])
@pytest.mark.parametrize('shape', FALLOFFS, ids=lambda shape: '-'.join(str(part) for part in shape.values()))
def test_a_light_on_the_surface_is_finite(shape, radius, scene, tmp_path):
    for place in ((0.0, 0.0, 0.0), (0.001, 0.0, 1e-6)):
        obj = lamp(scene, 'POINT', shape, shadow_soft_size=radius)
        obj.location = place
        found, _ = rendered(scene, tmp_path)
        assert np.isfinite(found).all() and (found >= 0.0).all()
        bpy.data.objects.remove(obj)


@pytest.mark.parametrize('angle', [0.0, math.pi])
def test_suns_from_a_point_and_from_half_the_sky(angle, scene, tmp_path):
    """A sun's strength is what a surface gets that faces it; it has no distance that could change it."""
    lamp(scene, 'SUN', {'falloff': 'RANGED', 'range': 0.0}, energy=2.0, angle=angle)
    scene.cotorra.samples = 64
    found, _ = rendered(scene, tmp_path)
    assert np.isfinite(found).all() and not warnings(scene)
    assert found.mean() == pytest.approx(2.0 * ALBEDO / math.pi, rel=1e-5 if angle == 0.0 else 5e-3)


# ---- The native module's border: what the exporter holds back, and what nobody may hand over


def lights_of(scene: bpy.types.Scene) -> SceneBuffers:
    """A point and a spot over the plane, both with a shape, as the exporter hands them over."""
    lamp(scene, 'POINT', {'falloff': 'RANGED', 'range': 2.0}).location = (0.0, 0.0, 1.0)
    shape = {'falloff': 'POLYNOMIAL', 'c0': 1.0, 'spot_edge': 'LINEAR', 'inner_angle': 0.2, 'outer_angle': 0.6}
    lamp(scene, 'SPOT', shape).location = (0.5, 0.0, 1.0)
    return exported(scene)


def native_picture(scene: bpy.types.Scene, buffers: SceneBuffers, **changed: np.ndarray) -> np.ndarray:
    """Combined of the buffers, with arrays of the lights exchanged, past everything that the exporter does."""
    buffers = replace(buffers, lights=replace(buffers.lights, **changed))
    made = cotorra_native.Scene(buffers, 1, native.embree_library())
    settings = RenderSettings(integrator='DIRECT', samples=1, threads=1)
    session = cotorra_native.Session(made, exported_camera(scene), settings)
    session.start()
    while not session.wait(1.0):
        pass
    out = np.zeros((48, 48, 4), np.float32)
    session.read('combined', out)
    return out[..., 0]


def test_what_the_exporter_leaves_out_would_be_dark_and_finite(scene):
    buffers = lights_of(scene)
    assert native_picture(scene, buffers).max() > 0.1
    zero = np.zeros(2, np.float32)
    dark = {'range': zero, 'polynomial': np.zeros((2, 3), np.float32)}
    assert np.all(native_picture(scene, buffers, **dark) == 0.0)
    closed = native_picture(scene, buffers, falloff=np.zeros(2, np.uint32), outer_angle=zero, inner_angle=zero)
    alone = native_picture(
        scene, buffers, falloff=np.zeros(2, np.uint32), strength=buffers.lights.strength * np.float32([[1], [0]])
    )
    assert np.array_equal(closed, alone)  # the spot gives nothing, the point gives what it gave


@pytest.mark.parametrize(
    ('name', 'values', 'words'),
    [
        ('falloff', [0, 3], r'lights\.falloff\[1\] = 3, must be below 3'),
        ('spot_edge', [7, 0], r'lights\.spot_edge\[0\] = 7, must be below 3'),
        ('range', [-1.0, 0.0], r'lights\.range\[0\] = -1.*, must be 0 or more'),
        ('outer_angle', [0.5, np.nan], r'lights\.outer_angle\[1\] = .*nan, must be 0 or more'),
        ('inner_angle', [0.5], 'must have 2 entries'),
        ('pass_index', [-2, 0], r'lights\.pass_index\[0\] = -2, must be from -1'),
    ],
)
def test_the_border_names_array_index_and_value(name, values, words, scene):
    buffers = lights_of(scene)
    kind = np.int32 if name == 'pass_index' else getattr(buffers.lights, name).dtype
    with pytest.raises(ValueError, match=words):
        native_picture(scene, buffers, **{name: np.array(values, kind)})


def misprinted_window(d: np.ndarray, reach: float) -> np.ndarray:
    """As system A prints it: a bracket in the wrong place, so that d^2 is the least value and not the divisor."""
    return np.maximum(np.minimum(1.0 - (d / reach) ** 4, 1.0), d**2)


def test_the_misprinted_window_makes_light_of_distance(scene, tmp_path):
    """Erratum of A: by the misprint a lamp gets brighter with distance, and has no range at all."""
    shape = {'falloff': 'RANGED', 'range': 2.0}
    obj = lamp(scene, 'POINT', shape)
    obj.location = (0.0, 0.0, 1.0)
    found, points = rendered(scene, tmp_path)
    d = np.linalg.norm(points - np.array(obj.location), axis=-1)
    per_window = ALBEDO / math.pi / d * ENERGY / (4.0 * math.pi)
    assert_equal(found, lit(points, obj, shape))
    beyond = d > 2.0
    misprinted = per_window * misprinted_window(d, 2.0)
    assert beyond.any() and np.all(found[beyond] == 0.0) and misprinted[beyond].min() > 1.0
    assert misprinted.mean() > 5.0 * found.mean()


def test_lamps_of_blenders_own_shape_cost_nothing(scene, tmp_path):
    lamp(scene, 'POINT', {}).location = (0.0, 0.0, 1.5)
    rendered(scene, tmp_path)
    assert 'light shapes' not in stats.last(scene.name)[-1].features
