# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad samples are counted with where they come from: each kind is made on purpose, and its material is named.

Nothing bad reaches the picture, whether it is counted or not.
"""

from __future__ import annotations

import json
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import health, stats

from devices import counts_bad_samples
from render_calls import read_exr, render_to, run_cli
from scenes import build

pytestmark = [
    pytest.mark.usefixtures('engine'),
    counts_bad_samples,
]

SAMPLES = 16
OVERFLOW = 1e30  # times 1e30


def room(name: str, socket: str, value: float) -> bpy.types.Scene:
    """A floor that fills the picture under a grey world; a product feeds a socket of its Principled BSDF.

    The product is that of an attribute, which is 1e30, and a number: attributes that are not finite are mended when
    they are read.
    """
    scene = build.new_scene()
    scene.cotorra.use_denoising = scene.cotorra.use_reweighting = False  # samples are counted in pixels
    camera = build.camera(scene, type='ORTHO', ortho_scale=1.5)
    camera.location = (0.0, 0.0, 5.0)
    floor = build.mesh_object(scene, 'Floor', vertices=[], faces=[])
    floor.data = build.grid(2)
    attribute = floor.data.attributes.new('bad', 'FLOAT', 'POINT')
    attribute.data.foreach_set('value', np.full(9, 1e30, np.float32))
    material = build.material(name)
    tree = material.node_tree
    node = tree.nodes.new('ShaderNodeAttribute')
    node.attribute_name = 'bad'
    product = tree.nodes.new('ShaderNodeMath')
    product.operation = 'MULTIPLY'
    product.inputs[1].default_value = value * 1e-30 if abs(value) < 1e20 else value
    tree.links.new(node.outputs['Fac'], product.inputs[0])
    tree.links.new(product.outputs[0], build.principled(material).inputs[socket])
    floor.data.materials.append(material)
    build.world(scene, (0.5, 0.5, 0.5))
    scene.render.engine = 'COTORRA'
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.cotorra.settings_from = 'COTORRA'
    scene.cotorra.samples = SAMPLES
    scene.cotorra.health = 'REPORT'
    return scene


def rendered(scene: bpy.types.Scene, tmp_path: Path) -> tuple[dict[str, dict[str, np.ndarray]], stats.LayerStats]:
    """The picture, all of it finite, and what was counted."""
    layers = read_exr(render_to(scene, tmp_path / 'o.exr', multilayer=True))
    for channels in layers.values():
        assert all(np.isfinite(pixels).all() for pixels in channels.values())
    (layer,) = stats.last(scene.name)
    return layers, layer


def test_a_color_that_is_infinite(tmp_path: Path) -> None:
    scene = room('Broken.001', 'Base Color', OVERFLOW)
    scene.view_layers[0].cotorra.use_pass_health = True
    layers, layer = rendered(scene, tmp_path)
    count = 16 * 16 * SAMPLES
    told = (
        f'material "Broken.001", bounce 0, base of principled, from math: {count} samples '
        'with a number that is infinite or none'
    )
    assert layer.health[0] == told and not any('finite' in text for text in layer.health[1:])
    assert f'Numerical health: {told}' in layer.warnings
    shown = layers['ViewLayer.Cotorra Health']
    assert (shown['X'] == SAMPLES).all() and not shown['Y'].any()


def test_an_infinite_emission(tmp_path: Path) -> None:
    scene = room('Sun stuff', 'Emission Strength', OVERFLOW)
    build.principled(scene.objects['Floor'].active_material).inputs['Emission Color'].default_value = (1, 1, 1, 1)
    _, layer = rendered(scene, tmp_path)
    assert any(
        text.startswith('material "Sun stuff", bounce 0, emission, from math: ') and text.endswith('infinite or none')
        for text in layer.health
    )


def test_light_that_overflows_is_dropped_and_its_weight_told(tmp_path: Path) -> None:
    """Albedos of 1e15 between two floors, and a sky of 1e15: the product is beyond what a float holds."""
    scene = room('Too bright', 'Base Color', 1e15)
    build.world(scene, (1e15, 1e15, 1e15))
    _, layer = rendered(scene, tmp_path)
    count = 16 * 16 * SAMPLES
    rejected = layer.session['rejected_samples']
    assert 0 < rejected <= count
    assert layer.health[0] == health.dropped(rejected, count)
    assert any(text.startswith('material "Too bright", bounce 0, ') for text in layer.health[1:])
    assert any(text.endswith('samples not finite') for text in layer.health[1:])


def test_negative_light(tmp_path: Path) -> None:
    scene = room('Dark light', 'Emission Strength', -2.0)
    build.principled(scene.objects['Floor'].active_material).inputs['Emission Color'].default_value = (1, 1, 1, 1)
    scene.view_layers[0].cotorra.use_pass_health = True
    layers, layer = rendered(scene, tmp_path)
    assert f'material "Dark light", bounce 0, emission: {16 * 16 * SAMPLES} samples negative' in layer.health
    assert (layers['ViewLayer.Cotorra Health']['Y'] == SAMPLES).all()


def lamp_with_a_product(scene: bpy.types.Scene, name: str, factor: float) -> bpy.types.Object:
    """A point lamp whose strength is the product of its UV map's first number, 1e30 and `factor`."""
    lamp = build.light(scene, 'POINT', energy=10.0, shadow_soft_size=0.0)
    lamp.name = lamp.data.name = name
    lamp.location = (0.0, 0.0, 2.0)
    lamp.data.use_nodes = True
    tree = lamp.data.node_tree
    place = tree.nodes.new('ShaderNodeNewGeometry')
    parts = tree.nodes.new('ShaderNodeSeparateXYZ')
    tree.links.new(place.outputs['Position'], parts.inputs[0])
    value = parts.outputs['Z']
    for number in (1e30, factor):
        product = tree.nodes.new('ShaderNodeMath')
        product.operation = 'MULTIPLY'
        product.inputs[1].default_value = number
        tree.links.new(value, product.inputs[0])
        value = product.outputs[0]
    emission = next(node for node in tree.nodes if node.bl_idname == 'ShaderNodeEmission')
    tree.links.new(value, emission.inputs['Strength'])
    return lamp


@pytest.mark.parametrize('lamps', [1, 12])
def test_a_lamp_whose_program_breaks(tmp_path: Path, lamps: int) -> None:
    """All lamps are sampled while there are few; of many the tree picks. One of them is broken."""
    scene = room('Floor', 'Roughness', 0.5)
    build.world(scene, (0.0, 0.0, 0.0))
    lamp_with_a_product(scene, 'Broken lamp', 1e30)
    for number in range(lamps - 1):
        build.light(scene, 'POINT', energy=1.0).location = (0.1 * number, 0.5, 2.0)
    _, layer = rendered(scene, tmp_path)
    (told,) = [text for text in layer.health if text.endswith('infinite or none')]
    assert told.startswith('light "Broken lamp", bounce 0, from math: ')
    samples = int(told.split(': ')[1].split()[0])
    every = 16 * 16 * SAMPLES
    assert samples == every if lamps == 1 else 0 < samples <= every


@pytest.mark.parametrize('lamps', [2, 12])
def test_light_samples_that_overflow_name_their_lamp(tmp_path: Path, lamps: int) -> None:
    """An albedo of 1e15 next to lamps of 1e30 W: lamps that are all sampled, and those that the tree picks."""
    scene = room('Floor', 'Base Color', 1e15)
    build.world(scene, (0.0, 0.0, 0.0))
    for number in range(lamps):
        lamp = build.light(scene, 'POINT', energy=1e30, shadow_soft_size=0.0)
        lamp.location = (0.1 * number, 0.5, 1e-5)
        lamp.data.color = (1e9, 1.0, 1.0)
    _, layer = rendered(scene, tmp_path)
    told = [text for text in layer.health if text.startswith('material "Floor", light "Point')]
    assert told and all('bounce 0, diffuse: ' in text and text.endswith('not finite') for text in told)


def test_fireflies(tmp_path: Path) -> None:
    """A small, very bright ceiling that only bounces find lights the floor: few samples meet it."""
    scene = room('Floor', 'Roughness', 1.0)
    lamp = build.mesh_object(scene, 'Lamp', vertices=[], faces=[])
    lamp.data = build.grid(1)
    lamp.scale = (0.1, 0.1, 0.1)
    lamp.location = (0.0, 0.0, 0.8)
    lamp.visible_camera = False
    glow = build.material('Glow', Emission_Color=(1, 1, 1, 1), Emission_Strength=2000.0)
    glow.cycles.emission_sampling = 'NONE'
    lamp.data.materials.append(glow)
    scene.cotorra.use_sample_sharing = False
    layers, layer = rendered(scene, tmp_path)
    (told,) = [text for text in layer.health if 'fireflies' in text]
    assert told.startswith('material "Glow", bounce 1, emission: ')
    # A firefly alone turns its pixel white.
    bad = sum(entry['samples'] for entry in layer.session['bad_samples'] if entry['kind'] == health.FIREFLY)
    white = (layers['ViewLayer.Combined']['R'] >= 1.0).sum()
    assert 0 < white <= bad < 16 * 16 * SAMPLES / 4


def test_a_sound_scene_has_nothing_to_tell_and_the_same_picture(tmp_path: Path) -> None:
    scene = room('Fine', 'Roughness', 0.5)
    counted, layer = rendered(scene, tmp_path)
    assert layer.health == [] and layer.session['bad_samples'] == []
    scene.cotorra.health = 'OFF'
    plain, layer = rendered(scene, tmp_path)
    assert 'numerical health' not in layer.features and layer.session['bad_samples'] == []
    # Kernels that count are built for the lowest instruction set alone, and another one rounds otherwise.
    for channel in 'RGB':
        np.testing.assert_allclose(
            plain['ViewLayer.Combined'][channel], counted['ViewLayer.Combined'][channel], rtol=1e-4,
            err_msg='kernels of another instruction set round otherwise',
        )  # fmt: skip


def test_strict_is_an_error_at_a_terminal(tmp_path: Path) -> None:
    room('Broken', 'Base Color', OVERFLOW)
    path, out, figures = tmp_path / 'broken.blend', tmp_path / 'o.exr', tmp_path / 'o.json'
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    code, told = run_cli('render', path, '-o', out, '--health', '--stats', figures)
    assert code == 0 and 'material "Broken", bounce 0, base of principled' in told
    assert any('material "Broken"' in text for text in json.loads(figures.read_text())['health'])
    out.unlink()
    code, told = run_cli('render', path, '-o', out, '--strict')
    assert code == 1 and 'samples are bad (Numerical Health is strict)' in told and not out.exists()


def test_words() -> None:
    bad = {'kind': 0, 'place': health.SCATTER, 'material': 1, 'light': -1, 'bounce': 4, 'lobe': 4, 'argument': -1}
    names = health.Names(('Default', 'Glass.003'), ('Sun',))
    assert (
        health.line(bad | {'samples': 12}, names) == 'material "Glass.003", bounce 4, dielectric: 12 samples not finite'
    )
    lamp = {**bad, 'place': health.LAMP, 'material': -1, 'light': 0, 'samples': 1}
    assert health.line(lamp, names) == 'light "Sun", bounce 4: 1 sample not finite'
    named = health.Names(ops={7: 'map_range_f'})
    assert health.line({**lamp, 'kind': 3, 'op': 7}, named).startswith('light "number 0", bounce 4, from map range: ')
    many = [{**bad, 'bounce': bounce, 'samples': 1} for bounce in range(20)]
    told = health.report(many, 1000, 20, names)
    assert told[0] == '20 of 1000 samples were dropped as not finite, 2 % of the weight in the mean'
    assert len(told) == health.LINES + 2 and told[-1] == '8 more bad samples at 8 more places'
