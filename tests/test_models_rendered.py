# SPDX-License-Identifier: GPL-3.0-or-later
"""Models and hard lamps through the whole engine, against their formulas in double precision: bpy to EXR and back.

One ray through each pixel's centre, no shadows. Noise, soft lamps and bounces are other tests'.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from light_reference import arriving
from render_calls import read_exr, render_to
from scenes import build, samples

pytestmark = pytest.mark.usefixtures('engine')

COLUMNS, SIZE = 6, (192, 128)
BASE = (0.7, 0.4, 0.2)
# Below this share of the brightest pixel errors count as absolute: there the edges of cones and terminators end in 0.
FLOOR = 1e-3
TOLERANCE = 1e-4

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
