# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes that take a picture apart: a pass for each lamp, and the terms D, G and F of the highlight.

The models' formulas have tests of their own; here, that a pass shows the right ones, summed over the right lamps.
"""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from cotorra import lamps, stats

from render_calls import read_exr, render_to
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')


@pytest.fixture
def scene() -> bpy.types.Scene:
    """A glossy sphere of few faces on a plane, under a sun, a point and a spot."""
    made = build.new_scene()
    camera = build.camera(made, type='ORTHO', ortho_scale=4.0)
    camera.location = (0.0, 0.0, 10.0)
    plane = build.mesh_object(made, 'Plane', vertices=[(2 * x, 2 * y, 0) for x, y, _ in build.QUAD])
    plane.data.materials.append(build.material('Gloss', Roughness=0.4))
    build.light(made, 'SUN', energy=1.0).rotation_euler = (0.3, 0.2, 0.0)
    build.light(made, 'POINT', energy=60.0, shadow_soft_size=0.3).location = (0.7, 0.2, 1.0)
    build.light(made, 'SPOT', energy=200.0, shadow_soft_size=0.0).location = (-0.5, 0.0, 2.0)
    block = build.mesh_object(made, 'Block', vertices=[(0.3 * x, 0.3 * y, 0.5) for x, y, _ in build.QUAD])
    block.data.materials.append(bpy.data.materials['Gloss'])
    made.render.engine = 'COTORRA'
    made.render.resolution_x = made.render.resolution_y = 32
    made.cotorra.samples = 8
    return made


def rendered(scene: bpy.types.Scene, folder) -> dict[str, np.ndarray]:
    """Passes of the view layer as (height, width, channels)."""
    found = read_exr(render_to(scene, folder / 'image.exr', multilayer=True))
    return {
        name.removeprefix('ViewLayer.'): np.stack(
            [layer[key] for key in 'RGB' if key in layer] or [*layer.values()], -1
        )
        for name, layer in found.items()
    }


@pytest.mark.parametrize('integrator', ['DIRECT', 'PATH', 'WHITTED'])
def test_lamps_add_up_to_the_picture(integrator, scene, tmp_path):
    scene.cotorra.integrator = integrator
    scene.view_layers[0].cotorra.use_pass_lights = True
    found = rendered(scene, tmp_path)
    assert 'terms' in stats.last(scene.name)[-1].features
    parts = [found[f'Light {name}'] for name in ('Sun', 'Point', 'Spot')]
    assert all(part.max() > 0.0 for part in parts)
    assert np.allclose(sum(parts), found['Combined'], rtol=1e-4, atol=1e-6)


def test_lamps_world_and_emission_add_up_to_the_picture(scene, tmp_path):
    """With all that can light: the world and what emits stand in light groups of their own, lamps in theirs, too."""
    layer = scene.view_layers[0]
    build.world(scene, (0.2, 0.3, 0.4)).lightgroup = 'World'
    block = bpy.data.objects['Block']
    block.data.materials[0] = build.material('Shine', Emission_Color=(1, 0.5, 0.2, 1), Emission_Strength=3.0)
    block.lightgroup, bpy.data.objects['Sun'].lightgroup = 'Shine', 'Lamps'
    for name in ('World', 'Shine', 'Lamps'):
        layer.lightgroups.add(name=name)
    bpy.data.objects['Point'].visible_camera = True
    layer.cotorra.use_pass_lights = True
    scene.cotorra.integrator = 'PATH'
    found = rendered(scene, tmp_path)
    parts = [found[f'Light {name}'] for name in ('Sun', 'Point', 'Spot')]
    others = [found[f'Combined_{name}'] for name in ('World', 'Shine')]
    assert all(part.max() > 0.0 for part in (*parts, *others))
    assert np.allclose(sum(parts) + sum(others), found['Combined'], rtol=1e-4, atol=1e-6)
    # A lamp is in its group as before.
    assert np.allclose(found['Combined_Lamps'], found['Light Sun'], rtol=1e-5, atol=1e-7)


def test_a_lamp_alone_is_the_picture_without_the_others(scene, tmp_path):
    scene.view_layers[0].cotorra.use_pass_lights = True
    together = rendered(scene, tmp_path)
    for name in ('Point', 'Spot'):
        bpy.data.objects[name].hide_render = True
    alone = rendered(scene, tmp_path)
    assert np.allclose(together['Light Sun'], alone['Combined'], rtol=1e-5, atol=1e-7)
    assert np.all(alone['Light Spot'] == 0.0)  # its pass is there, and black


def test_many_lamps_picked_by_importance_have_their_passes(scene, tmp_path):
    for index in range(9):
        obj = build.light(scene, 'POINT', energy=5.0)
        obj.location = (0.4 * index - 1.6, 0.3, 0.7)
    scene.view_layers[0].cotorra.use_pass_lights = True
    found = rendered(scene, tmp_path)
    parts = [part for name, part in found.items() if name.startswith('Light ')]
    assert len(parts) == 12
    assert np.allclose(sum(parts), found['Combined'], rtol=1e-4, atol=1e-6)


def test_instances_of_a_lamp_share_its_pass(scene, tmp_path):
    collection = bpy.data.collections.new('Lamps')
    inner = bpy.data.objects.new('Inner', bpy.data.lights.new('Inner', 'POINT'))
    inner.data.energy = 30.0
    collection.objects.link(inner)
    for index, place in enumerate(((0.9, 0.9, 0.5), (-0.9, 0.9, 0.5))):
        empty = build.link(scene, f'Empty{index}', None)
        empty.instance_type, empty.instance_collection, empty.location = 'COLLECTION', collection, place
    scene.view_layers[0].cotorra.use_pass_lights = True
    found = rendered(scene, tmp_path)
    parts = [part for name, part in found.items() if name.startswith('Light ')]
    assert len(parts) == 4 and np.allclose(sum(parts), found['Combined'], rtol=1e-4, atol=1e-6)
    left, right = found['Light Inner'][:, :16].mean(), found['Light Inner'][:, 16:].mean()
    assert left > 0.0 and left == pytest.approx(right, rel=0.2)


def more_lamps(scene: bpy.types.Scene, *names: str) -> None:
    for name in names:
        scene.collection.objects.link(bpy.data.objects.new(name, bpy.data.lights['Sun']))
    bpy.context.view_layer.update()


def test_names_of_passes_are_told_apart(scene):
    layer = scene.view_layers[0]
    more_lamps(scene, 'A.001', 'A_001', 'é' * 31)
    assert lamps.pass_names(layer) == {}
    layer.cotorra.use_pass_lights = True
    found = lamps.pass_names(layer)
    assert [found[name] for name in ('Point', 'Spot', 'Sun')] == ['Light Point', 'Light Spot', 'Light Sun']
    assert found['A.001'] == 'Light A_001' and found['A_001'] == 'Light A_001 2'
    assert all(len(name.encode()) <= lamps.NAME_BYTES for name in found.values())
    assert lamps.pass_numbers(layer) == {name: number for number, name in enumerate(found.values())}


def test_beyond_many_lamps_the_rest_share_a_pass(scene):
    layer = scene.view_layers[0]
    layer.cotorra.use_pass_lights = True
    more_lamps(scene, *(f'L{index:02d}' for index in range(80)))
    names = lamps.pass_names(layer)
    assert len(names) == 83 and len(set(names.values())) == lamps.PASSES_MAX
    assert sum(name == lamps.REST for name in names.values()) == 83 - (lamps.PASSES_MAX - 1)


def test_without_these_passes_nothing_is_carried(scene, tmp_path):
    rendered(scene, tmp_path)
    assert 'terms' not in stats.last(scene.name)[-1].features


# ---- D, G and F


def tilted(scene: bpy.types.Scene, folder) -> dict[str, np.ndarray]:
    """The plane alone, seen from the side, at one sample a pixel; every pass in double precision."""
    bpy.data.objects.remove(bpy.data.objects['Block'])
    camera = scene.camera
    camera.location, camera.rotation_euler = (0.0, -8.0, 8.0), (math.pi / 4, 0.0, 0.0)
    scene.cotorra.samples = 1
    layer = scene.view_layers[0]
    layer.use_pass_position = layer.use_pass_normal = True
    own = layer.cotorra
    own.use_pass_distribution = own.use_pass_masking = own.use_pass_fresnel = True
    return {name: values.astype(np.float64) for name, values in rendered(scene, folder).items()}


def vectors(found: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Which pixels show the plane, and where."""
    hit = np.abs(found['Normal'][..., -1] - 1.0) < 1e-3
    return hit, np.stack([found['Position'][..., axis] for axis in range(3)], axis=-1)


def unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def terms(points: np.ndarray, place: tuple[float, ...], a: float, f0: float) -> tuple[np.ndarray, ...]:
    """D of GGX, Smith's correlated G and Schlick's F of models.md, for a plane seen at 45 degrees."""
    wo = np.array((0.0, -math.sqrt(0.5), math.sqrt(0.5)))
    wi = unit(np.array(place) - points)
    h = unit(wi + wo)
    nh, nl, nv, vh = h[..., 2], wi[..., 2], wo[2], (h * wo).sum(axis=-1)

    def smith(n: np.ndarray) -> np.ndarray:
        return (-1.0 + np.sqrt(1.0 + a * a * (1.0 - n * n) / (n * n))) / 2.0

    d = a * a / (math.pi * (1.0 + nh * nh * (a * a - 1.0)) ** 2)
    return d, 1.0 / (1.0 + smith(nv) + smith(nl)), f0 + (1.0 - f0) * (1.0 - vh) ** 5


def cook_torrance(scene: bpy.types.Scene) -> None:
    own = bpy.data.materials['Gloss'].cotorra
    own.model, own.distribution, own.masking, own.fresnel = 'COOK_TORRANCE', 'GGX', 'SMITH_CORRELATED', 'SCHLICK'
    own.f0_mode, own.f0, own.split = 'COLOR', (0.3, 0.5, 0.7), 'ENERGY'


def only_lamps_at(*places: tuple[float, ...]) -> None:
    for name in ('Sun', 'Point', 'Spot'):
        bpy.data.objects.remove(bpy.data.objects[name])
    for place in places:
        build.light(bpy.context.scene, 'POINT', energy=40.0, shadow_soft_size=0.0).location = place


def test_terms_are_those_of_the_formula_summed_over_lamps(scene, tmp_path):
    places = ((0.7, 0.2, 1.0), (-0.5, 0.0, 2.0))
    only_lamps_at(*places, (0.0, 0.0, -1.0))  # the last is below the plane, and counts for nothing
    cook_torrance(scene)
    found = tilted(scene, tmp_path)
    hit, points = vectors(found)
    assert hit.mean() > 0.3
    for channel, f0 in enumerate((0.3, 0.5, 0.7)):
        wanted = [sum(parts) for parts in zip(*(terms(points, place, 0.16, f0) for place in places), strict=True)]
        assert found['Cotorra D'][hit][:, 0] == pytest.approx(wanted[0][hit], rel=1e-4)
        assert found['Cotorra G'][hit][:, 0] == pytest.approx(wanted[1][hit], rel=1e-4)
        assert found['Cotorra F'][hit][:, channel] == pytest.approx(wanted[2][hit], rel=1e-4)
    assert np.all(found['Cotorra D'][~hit] == 0.0) and np.all(found['Cotorra F'][~hit] == 0.0)


def test_terms_make_the_highlight_of_the_picture(scene, tmp_path):
    """A metal under one lamp without size: what arrives is D G F / (4 nv) times the lamp's irradiance."""
    only_lamps_at((0.7, 0.2, 1.0))
    cook_torrance(scene)
    build.principled(bpy.data.materials['Gloss']).inputs['Metallic'].default_value = 1.0
    found = tilted(scene, tmp_path)
    hit, points = vectors(found)
    distance2 = ((np.array((0.7, 0.2, 1.0)) - points) ** 2).sum(axis=-1)
    irradiance = 40.0 / (4.0 * math.pi) / distance2
    wanted = found['Cotorra D'] * found['Cotorra G'] * found['Cotorra F'] / (4.0 * math.sqrt(0.5))
    assert found['Combined'][hit][:, :3] == pytest.approx((wanted * irradiance[..., None])[hit], rel=1e-4)


def test_terms_of_principled_and_of_what_has_none(scene, tmp_path):
    """Principled shows its own D and G; Lambert has no highlight, so D and F are 0."""
    places = ((0.7, 0.2, 1.0),)
    only_lamps_at(*places)
    found = tilted(scene, tmp_path)
    hit, points = vectors(found)
    d, g, _ = terms(points, places[0], 0.16, 0.04)
    assert found['Cotorra D'][hit][:, 0] == pytest.approx(d[hit], rel=1e-4)
    assert found['Cotorra G'][hit][:, 0] == pytest.approx(g[hit], rel=1e-4)
    bpy.data.materials['Gloss'].cotorra.model = 'LAMBERT'
    found = rendered(scene, tmp_path)
    assert np.all(found['Cotorra D'] == 0.0) and np.all(found['Cotorra F'] == 0.0)
