# SPDX-License-Identifier: GPL-3.0-or-later
"""Clamping, Filter Glossy and the switches of caustics, beside the pictures of Cycles; and what a denoiser is shown.

That each changes the picture is asked for, too: two engines that both ignore a setting would agree.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat, cycles_settings, stats
from mathutils import Vector

from render_calls import read_exr, render_to
from scenes import build

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import Reference, same_image

from benchmark.fair import make_fair, set_job

pytestmark = pytest.mark.usefixtures('engine')

SIZE = (48, 32)
TILE = 8
SAMPLES = 128  # of each half
BOUNCES = 4
# What is left of clamped light depends on how it comes in samples, which is each engine's own: one lamp or one of many
# at a vertex, and paths that end at random. One bounce under one lamp without size has one way.
CLAMPED_BOUNCES = 1
# What a tile and the whole may differ by beside noise.
LIMIT = 0.03
TOTAL = 0.01
CHANGE = 0.03  # of the whole, that a setting makes at least


def add_sphere(name: str, x: float, **inputs: object) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, location=(x, 0, 1.0))
    bpy.context.object.data.shade_smooth()
    bpy.context.object.data.materials.append(build.material(name, **inputs))


def scene_of(**inputs: object) -> bpy.types.Scene:
    """Two spheres of a surface over a white floor, under a bright lamp that rays can meet, and a grey world."""
    scene = build.new_scene()
    build.world(scene, (0.5, 0.5, 0.5))
    floor = build.mesh_object(scene, 'Floor', vertices=[(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)])
    floor.data.materials.append(build.material('Floor', Base_Color=(0.8, 0.8, 0.8, 1.0), Roughness=1.0))
    compat.principled(floor.data.materials[0]).inputs['Specular IOR Level'].default_value = 0.0
    for x in (-1.1, 1.1):
        add_sphere('Surface', x, **inputs)
    build.light(scene, 'SUN', energy=4.0, angle=0.4).rotation_euler = (0.6, 0.3, 0.0)
    camera = build.camera(scene)
    camera.location = (0, -5, 3.0)
    camera.rotation_euler = (Vector((0, 0, 0.7)) - camera.location).to_track_quat('-Z', 'Y').to_euler()
    return scene


METAL = {'Base_Color': (0.9, 0.8, 0.6, 1.0), 'Metallic': 1.0, 'Roughness': 0.2}
PLASTIC = {'Base_Color': (0.2, 0.4, 0.8, 1.0), 'Roughness': 0.3}
CLAY = {'Base_Color': (0.8, 0.7, 0.6, 1.0), 'Roughness': 1.0, 'Specular_IOR_Level': 0.0}
GLASS = {'Base_Color': (0.9, 0.95, 1.0, 1.0), 'Transmission_Weight': 1.0, 'Roughness': 0.1, 'IOR': 1.45}
COATED = {**PLASTIC, 'Coat_Weight': 1.0, 'Coat_Roughness': 0.1}

CASES = {
    'clamp direct': (CLAY, {'clamp_direct': 0.3}),
    'clamp indirect': (CLAY, {'clamp_indirect': 0.05}),
    'clamp both': (PLASTIC, {'clamp_direct': 0.6, 'clamp_indirect': 0.05}),
    'filter glossy': ({**METAL, 'Roughness': 0.0}, {'filter_glossy': 100.0}),
    'filter glossy, lobes': ({**GLASS, 'Roughness': 0.0}, {'filter_glossy': 100.0}),
    'reflective, metal': (METAL, {'reflective_caustics': False}),
    'reflective, plastic': (PLASTIC, {'reflective_caustics': False}),
    'reflective, coat': (COATED, {'reflective_caustics': False}),
    'reflective, glass': (GLASS, {'reflective_caustics': False}),
    'refractive, glass': (GLASS, {'refractive_caustics': False}),
    'both, glass': (GLASS, {'reflective_caustics': False, 'refractive_caustics': False}),
}
# Where the mean of the picture hardly moves, though its places do.
STILL = {'filter glossy', 'filter glossy, lobes', 'reflective, plastic', 'reflective, coat', 'reflective, glass'}


def picture(scene: bpy.types.Scene, engine: str, bounces: int, folder: Path, **asked: object) -> Reference:
    make_fair(scene, engine, bounces, SIZE, threads=2)
    for name, value in asked.items():
        scene.cotorra.settings_from = 'CYCLES'
        owner, theirs = cycles_settings.source(scene, name)
        setattr(owner, theirs, value)
    halves = []
    for seed in (1, 2):
        path = folder / f'{engine}{seed}.exr'
        set_job(scene, SAMPLES, seed, str(path))
        bpy.ops.render.render(write_still=True)
        channels = read_exr(path)['']
        halves.append(np.stack([channels[name] for name in 'RGB'], axis=-1))
    return Reference.from_halves(*halves)


@pytest.mark.parametrize('case', CASES)
def test_the_picture_is_that_of_cycles(case: str, tmp_path: Path) -> None:
    surface, asked = CASES[case]
    scene, bounces = scene_of(**surface), BOUNCES
    if 'clamp' in case:
        bounces = CLAMPED_BOUNCES
        bpy.data.lights['Sun'].angle = 0.0
        compat.background(scene.world).inputs['Strength'].default_value = 0.0
    plain = picture(scene, 'COTORRA', bounces, tmp_path)
    ours = picture(scene, 'COTORRA', bounces, tmp_path, **asked)
    [layer] = stats.last(scene.name)
    assert not layer.warnings
    theirs = picture(scene, 'CYCLES', bounces, tmp_path, **asked)
    same = same_image(ours, theirs, LIMIT, TILE)
    told = f'in total {same.total:+.4f} ± {same.total_noise:.4f}, worst tile {same.worst}, noise {same.noise:.4f}'
    assert same.bad == 0, told
    assert same.beyond_noise == 0, f'{told}\n{np.round(100 * same.tiles).astype(int)} %'
    assert abs(same.total) <= TOTAL + 3 * same.total_noise, told
    change = abs(ours.image.mean() / plain.image.mean() - 1.0)
    assert case in STILL or change > CHANGE, change
    # Light that clamping held back is told of, as a share of what there was.
    held = layer.session['held_light'] / layer.session['light'] if 'clamp' in case else 0.0
    assert held == pytest.approx(change, abs=0.02) or 'clamp' not in case


def test_what_changes_nothing_changes_no_bit(tmp_path: Path) -> None:
    """Limits that nothing reaches, and a filter that finds no bounce wide enough."""
    scene = scene_of(**GLASS)
    plain = picture(scene, 'COTORRA', BOUNCES, tmp_path)
    asked = {'clamp_direct': 1e9, 'clamp_indirect': 1e9, 'filter_glossy': 1e-9}
    assert (picture(scene, 'COTORRA', BOUNCES, tmp_path, **asked).image == plain.image).all()


# ---- Denoising Albedo and Denoising Normal


def features(scene: bpy.types.Scene, engine: str, folder: Path) -> dict[str, np.ndarray]:
    """Means of tiles, by pass."""
    make_fair(scene, engine, BOUNCES, SIZE, threads=2)
    scene.view_layers[0].cycles.denoising_store_passes = True
    scene.cycles.samples = scene.cotorra.samples = SAMPLES
    found = read_exr(render_to(scene, folder / f'{engine}.exr', multilayer=True))
    albedo, normal = (found[f'ViewLayer.Denoising {name}'] for name in ('Albedo', 'Normal'))
    stacked = {
        'albedo': np.stack([albedo[name] for name in 'RGB'], axis=-1),
        'normal': np.stack([normal[name] for name in 'XYZ'], axis=-1),
    }
    return {
        name: image.reshape(SIZE[1] // TILE, TILE, SIZE[0] // TILE, TILE, 3).mean(axis=(1, 3))
        for name, image in stacked.items()
    }


SHOWN = {
    'plastic': PLASTIC,
    'rough metal': {**METAL, 'Roughness': 0.5},
    'mirror': {**METAL, 'Roughness': 0.0},
    'clear glass': {**GLASS, 'Roughness': 0.0},
}


@pytest.mark.parametrize('surface', SHOWN)
def test_a_denoiser_is_shown_what_that_of_cycles_is(surface: str, tmp_path: Path) -> None:
    """Also through mirrors and glass.

    No light is seen there: Cycles tints it once too often. Rough lobes have the albedo toward the mirrored direction,
    Cycles' a mean.
    """
    scene = scene_of(**SHOWN[surface])
    bpy.data.lights['Sun'].angle = 0.0
    compat.background(scene.world).inputs['Strength'].default_value = 0.0
    ours, theirs = (features(scene, engine, tmp_path) for engine in ('COTORRA', 'CYCLES'))
    np.testing.assert_allclose(ours['albedo'], theirs['albedo'], atol=0.08)
    np.testing.assert_allclose(ours['normal'], theirs['normal'], atol=0.08)
