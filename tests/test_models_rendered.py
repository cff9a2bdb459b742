# SPDX-License-Identifier: GPL-3.0-or-later
"""Models and hard lamps through the whole engine, against their formulas in double precision: bpy to EXR and back.

One ray through each pixel's centre, no shadows. Noise, soft lamps and bounces are other tests'.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra import demos

from charting import formulas
from charting.kernels import DEFAULTS
from light_reference import arriving
from render_calls import read_exr, render_to
from scenes import build, samples

pytestmark = pytest.mark.usefixtures('engine')

COLUMNS, SIZE = 6, (192, 128)
BASE = (0.7, 0.4, 0.2)
NODE = {'base_color': BASE, 'metallic': 0.3, 'roughness': 0.35, 'ior': 1.45}
# Below this share of the brightest pixel errors count as absolute: there the edges of cones and terminators end in 0.
FLOOR = 3e-3
TOLERANCE = 2e-4  # linear edges of cones enlarge roundings of what a pixel shows: 1.1e-4 at one of them

LAMPS = {
    'sun': ('SUN', (2.0, -3.0, 8.0), {}),
    'point': ('POINT', (2.0, -3.0, 5.0), {}),
    'point ranged': ('POINT', (2.0, -3.0, 5.0), {'falloff': 'RANGED', 'range': 11.0}),
    'point polynomial': ('POINT', (2.0, -3.0, 5.0), {'falloff': 'POLYNOMIAL', 'c0': 4.0, 'c1': 1.5, 'c2': 0.3}),
    'spot': ('SPOT', (2.0, -3.0, 8.0), {}),
    'spot linear': ('SPOT', (2.0, -3.0, 8.0), {'spot_edge': 'LINEAR', 'inner_angle': 0.1, 'outer_angle': 0.8}),
    'spot squared': ('SPOT', (2.0, -3.0, 8.0), {'spot_edge': 'SQUARED', 'inner_angle': 0.1, 'outer_angle': 0.8}),
    'spot squared ranged': (
        'SPOT',
        (2.0, -3.0, 8.0),
        {'spot_edge': 'SQUARED', 'inner_angle': 0.1, 'outer_angle': 0.9, 'falloff': 'RANGED', 'range': 14.0},
    ),
}

# Sharper highlights than these turn the roundings of a position (3e-7 m of 5 m) into more than the tolerance: GGX of
# roughness 0.1 was off by 1.8e-4.
CT = {'model': 'COOK_TORRANCE'}
MODELS: dict[str, dict[str, Any]] = {
    'Lambert': {'model': 'LAMBERT'},
    'Oren-Nayar': {'model': 'OREN_NAYAR'},
    'EON': {'model': 'OREN_NAYAR', 'oren_nayar_form': 'ENERGY_PRESERVING', 'oren_nayar_sigma': 0.9},
    'Phong': {'model': 'PHONG', 'specular_color': (0.9, 0.8, 1.0)},
    'Phong, normalized': {'model': 'PHONG', 'normalized': True, 'shininess': 200.0},
    'Blinn-Phong': {'model': 'BLINN_PHONG', 'kd': 0.2, 'ks': 0.8},
    'Blinn-Phong, normalized': {'model': 'BLINN_PHONG', 'normalized': True, 'shininess': 5.0},
    'Toon': {'model': 'TOON', 'toon_lit': (0.8, 0.6, 0.4)},
    'Toon, 5 steps': {'model': 'TOON', 'toon_steps': 5},
    'D GGX': {**CT, 'distribution': 'GGX'},
    'D Beckmann': {**CT, 'distribution': 'BECKMANN'},
    'D Blinn-Phong': {**CT, 'distribution': 'BLINN_PHONG'},
    'D GGX, roughness 0.25': {**CT, 'distribution': 'GGX', 'roughness': 0.25},
    'D Beckmann, roughness 0.25': {**CT, 'distribution': 'BECKMANN', 'roughness': 0.25},
    'D Blinn-Phong, roughness 0.25': {**CT, 'distribution': 'BLINN_PHONG', 'roughness': 0.25},
    'D GGX, roughness 1': {**CT, 'distribution': 'GGX', 'roughness': 1.0},
    'G Smith': {**CT, 'masking': 'SMITH'},
    'G Cook-Torrance': {**CT, 'masking': 'COOK_TORRANCE'},
    'G Schlick-GGX': {**CT, 'masking': 'SCHLICK_GGX'},
    'F dielectric': {**CT, 'fresnel': 'DIELECTRIC'},
    'F conductor': {**CT, 'fresnel': 'CONDUCTOR', 'metallic': 1.0},
    'F F82': {**CT, 'fresnel': 'F82', 'f82_tint': (0.9, 0.7, 0.5), 'metallic': 1.0},
    'F0 color, mixed': {**CT, 'f0_mode': 'COLOR', 'f0': (0.3, 0.2, 0.1), 'split': 'MIX'},
    'F0 IOR': {**CT, 'f0_mode': 'IOR'},
}


def sample(name: str) -> bpy.types.Material:
    """A material with one of MODELS."""
    settings = DEFAULTS | NODE | MODELS[name]
    made = build.material(
        name,
        Base_Color=(*settings['base_color'], 1.0),
        Metallic=settings['metallic'],
        Roughness=settings['roughness'],
        IOR=settings['ior'],
    )
    for key, value in settings.items():
        if key not in NODE:
            setattr(made.cotorra, key, value)
    return made


def field(lamp: str, materials: list[bpy.types.Material]) -> tuple[bpy.types.Scene, bpy.types.Object]:
    """The field under one of LAMPS."""
    scene = samples.field(materials, COLUMNS, SIZE)
    kind, location, settings = LAMPS[lamp]
    made = samples.hard_light(scene, kind, location, **settings)
    if kind == 'SPOT':
        made.data.spot_size, made.data.spot_blend = 1.6, 0.7
    return scene, made


def rendered(scene: bpy.types.Scene, path: Path) -> dict[str, np.ndarray]:
    hits = samples.first_hits(read_exr(render_to(scene, path / 'image.exr', multilayer=True)))
    bpy.context.view_layer.update()
    return hits


def largest_error(found: np.ndarray, expected: np.ndarray) -> float:
    """Relative, with the floor."""
    return float((np.abs(found - expected) / np.maximum(expected, FLOOR * expected.max())).max())


def test_a_ray_goes_through_its_pixels_centre(tmp_path):
    build.new_scene()
    scene = samples.field([build.material()], 1, (48, 32))
    hits = rendered(scene, tmp_path)
    camera = np.array(scene.camera.matrix_world, np.float64)
    height, width = hits['material'].shape
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height)[::-1] + 0.5)
    pixel = 36.0 / scene.camera.data.lens / width  # on the plane at distance 1
    rays = np.stack(((x - width / 2) * pixel, (y - height / 2) * pixel, -np.ones_like(x)), axis=-1) @ camera[:3, :3].T
    plane = (hits['material'] == 0) & (np.abs(hits['position'][..., 2]) < 1e-6)
    assert plane.sum() > 100
    expected = camera[:3, 3] - rays * (camera[2, 3] / rays[..., 2:])
    off = np.linalg.norm(hits['position'] - expected, axis=-1)[plane].max()
    # A ray is off by the filter's width at most in x and in y; the plane is seen aslant, at 45 degrees.
    assert off < 2.0 * samples.FILTER_WIDTH * pixel * np.linalg.norm(camera[:3, 3]) * 1.2


@pytest.mark.parametrize('lamp', LAMPS)
def test_lamps(lamp, tmp_path):
    """A Lambertian field, so that only the lamp is on trial."""
    build.new_scene()
    materials = [build.material(f'M{k}', Base_Color=(*BASE, 1), Specular_IOR_Level=0.0, IOR=1.0) for k in range(24)]
    scene, made = field(lamp, materials)
    hits = rendered(scene, tmp_path)
    seen = hits['material'] >= 0
    wi, irradiance = arriving(made, hits['position'][seen])
    cosine = np.maximum((hits['normal'][seen] * wi).sum(axis=-1, keepdims=True), 0.0)
    expected = np.array(BASE) / np.pi * irradiance * cosine
    assert seen.mean() > 0.4 and (expected > 0.01 * expected.max()).mean() > 0.3
    assert largest_error(hits['color'][seen], expected) < TOLERANCE


def expected_color(settings: dict[str, Any], lamps: list[bpy.types.Object], hits: dict[str, np.ndarray], where) -> Any:
    """What the formulas give at the camera's hits, and which of these are no judge of a model: see the comments."""
    n, p = hits['normal'][where], hits['position'][where]
    wo = np.array(bpy.context.scene.camera.matrix_world.translation) - p
    wo /= np.linalg.norm(wo, axis=-1, keepdims=True)
    # Where a smooth normal leans from the viewer, the kernels bend it for the highlight, as Cycles does.
    usable = (n * wo).sum(axis=-1) > 0.1
    color = np.zeros((where.sum(), 3))
    for lamp in lamps:
        wi, irradiance = arriving(lamp, p)
        color += formulas.f_cos(DEFAULTS | settings, n, wo, wi) * irradiance
        if settings['model'] == 'TOON':  # roundings choose the tone where one ends
            tone = (n * wi).sum(axis=-1) * (DEFAULTS | settings)['toon_steps']
            usable &= np.abs(tone - np.round(tone)) > 1e-4
    return color, usable


@pytest.mark.parametrize('lamp', LAMPS)
def test_models(lamp, tmp_path):
    """Each model on a sphere and on a plane under one lamp."""
    build.new_scene()
    scene, made = field(lamp, [sample(name) for name in MODELS])
    hits = rendered(scene, tmp_path)
    errors = {}
    for index, name in enumerate(MODELS):
        where = hits['material'] == index
        expected, usable = expected_color(NODE | MODELS[name], [made], hits, where)
        assert usable.sum() > 200 and (expected[usable] > FLOOR * expected.max()).mean() > 0.15, name
        errors[name] = largest_error(hits['color'][where][usable], expected[usable])
    print(lamp, {name: f'{error:.1e}' for name, error in errors.items()})
    assert not {name: error for name, error in errors.items() if not error < TOLERANCE}


@pytest.mark.parametrize('name', ['Lambert', 'Oren-Nayar', 'Phong', 'Blinn-Phong', 'D GGX', 'Toon'])
def test_box_room(engine, name, tmp_path):
    """The demo, everything by one model, its three lamps made hard and without shadows."""
    scene = demos.build('box_room')
    scene.world = None
    scene.cotorra.integrator = 'DIRECT'
    scene.cotorra.samples = 1
    scene.cotorra.use_denoising = scene.cotorra.use_reweighting = False
    scene.cotorra.use_model_override = True
    for key, value in MODELS[name].items():
        setattr(scene.cotorra.model_override, key, value)
    scene.render.resolution_x, scene.render.resolution_y = 160, 90
    samples.observe(scene)
    bpy.data.objects['Cone'].data.shade_flat()  # its smooth normals lean far from its triangles, and are bent
    lamps = [item for item in scene.objects if item.type == 'LIGHT']
    for item in lamps:
        samples.harden(item.data)
    materials = list(bpy.data.materials)
    for index, material in enumerate(materials):
        material.pass_index = index + 1
    hits = rendered(scene, tmp_path)
    errors = {}
    for index, material in enumerate(materials):
        where = hits['material'] == index
        node = build.principled(material).inputs
        settings = MODELS[name] | {
            'base_color': tuple(node['Base Color'].default_value)[:3],
            **{key: node[key.title()].default_value for key in ('metallic', 'roughness')},
            'ior': node['IOR'].default_value,
        }
        expected, usable = expected_color(settings, lamps, hits, where)
        if usable.sum() > 20:
            errors[material.name] = largest_error(hits['color'][where][usable], expected[usable])
    print(name, {name: f'{error:.1e}' for name, error in errors.items()})
    assert len(errors) > 5 and max(errors.values()) < TOLERANCE
