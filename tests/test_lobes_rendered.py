# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths through surfaces: panes, spheres and sheets of lobes under suns and a white world, on both devices.

Shaders are made of a few closures here; no Blender. What a lobe does by itself is test_closures.py's.
"""

from __future__ import annotations

import numpy as np
import pytest
from cotorra.export import buffers as b

from texture_scenes import Made, camera, instances, lights, materials, plane, render, scene

VIEW = camera(0.5, 16)
FROM_ABOVE = lights(((0.0, 0.0, -1.0), np.pi))  # a white Lambertian surface that faces it has radiance 1
FROM_BELOW = lights(((0.0, 0.0, 1.0), np.pi))


def asked(count: int, **values: object) -> Made:
    """As many Principled materials of one kind, white and without a specular layer."""
    values = {'base_color': (1.0, 1.0, 1.0), 'ior': 1.5, 'specular_level': 0.0, **values}
    return materials(count, **{name: [value] * count for name, value in values.items()})


@pytest.fixture(params=['CPU', 'VULKAN'])
def device(request: pytest.FixtureRequest) -> str:
    if request.param == 'VULKAN':
        request.getfixturevalue('module')
    return request.param


def mean(made: b.SceneBuffers, device: str, **settings: object) -> np.ndarray:
    settings = {'samples': 64, 'integrator': 'PATH', 'max_bounces': 12, 'device': device} | settings
    return render(made, VIEW, **settings)['combined'][..., :3].mean(axis=(0, 1), dtype=np.float64)


def layers(count: int) -> tuple[b.Mesh, ...]:
    return tuple(plane(low=-4.0, high=4.0, z=0.1 * k) for k in range(count))


@pytest.mark.every(6)
@pytest.mark.parametrize('anisotropy', [-1.0, 0.0, 1.0])
def test_a_thin_sheet_shines_in_the_sun_behind_it(device: str, anisotropy: float) -> None:
    """Of a thin scattering wall, (1 + g) / 2 of a sun behind it comes through, and the rest of one before it back."""
    made = asked(1, thin_wall=1.0, subsurface=1.0, subsurface_anisotropy=anisotropy)
    for suns, share in ((FROM_BELOW, 0.5 * (1 + anisotropy)), (FROM_ABOVE, 0.5 * (1 - anisotropy))):
        got = mean(scene(layers(1), made, lights=suns), device)
        np.testing.assert_allclose(got, share, atol=0.02)


@pytest.mark.every(4)
@pytest.mark.parametrize('layer', [{'transmission': 1.0, 'roughness': 0.0}, {'transmission': 1.0, 'roughness': 0.5}])
def test_white_glass_is_as_bright_as_the_world(device: str, layer: dict[str, float]) -> None:
    """A slab of two faces, the back one seen from inside: all light that enters leaves again."""
    made = asked(2, ior=1.3, **layer)
    world = b.World(color=(1.0, 1.0, 1.0))
    got = mean(scene(layers(2), made, world=world), device, max_bounces=64, transmission_bounces=64, glossy_bounces=64)
    np.testing.assert_allclose(got, 1, atol=0.05 if layer['roughness'] else 0.01)


def test_transmission_has_a_limit_of_its_own(device: str) -> None:
    """Four clear sheets under the camera, and the world behind them."""
    made = asked(4, thin_wall=1.0, transmission=1.0, roughness=0.0, ior=1.0)
    world = b.World(color=(1.0, 1.0, 1.0))
    sheets = scene(layers(4), made, world=world)
    # A ray past the limit still brings light home. Lavapipe compiles for 20 seconds for each picture.
    for limit, light in ((0, 0), (3, 1), (4, 1), (12, 1)) if device == 'CPU' else ((0, 0),):
        got = mean(sheets, device, transmission_bounces=limit, glossy_bounces=0, diffuse_bounces=0)
        np.testing.assert_allclose(got, light, atol=1e-5)


def test_surfaces_hidden_from_transmission_are_not_met_behind_glass(device: str) -> None:
    """A clear sheet over a floor in the sun, which rays through the sheet see, or not."""
    glass = {'thin_wall': 1.0, 'transmission': 1.0, 'roughness': 0.0, 'ior': 1.0, 'base_color': (1.0, 1.0, 1.0)}
    floor = materials(2, **{name: [None, value] for name, value in glass.items() if name != 'ior'}, ior=[1.0, 1.0])
    for visibility, light in ((63, 0.8), (63 & ~8, 0.0)) if device == 'CPU' else ((63 & ~8, 0.0),):
        placed = instances(2, visibility=np.array([visibility, 63 & ~32], np.uint32))
        got = mean(scene(layers(2), floor, lights=FROM_ABOVE, instances=placed), device)
        np.testing.assert_allclose(got, light, atol=1e-4)


def test_a_scene_without_lobes_has_not_their_feature(device: str) -> None:
    plain = scene(layers(1), materials(1), lights=FROM_ABOVE)
    np.testing.assert_allclose(mean(plain, device), 0.8, rtol=1e-5)


@pytest.mark.long
def test_devices_agree(module: object) -> None:
    """Every layer at once, in the sun and a world: the same picture but for rounding."""
    made = asked(3, transmission=0.4, coat=0.7, sheen=0.5, metallic=0.2, specular_level=0.5, roughness=0.4)
    world = b.World(color=(0.5, 0.6, 0.7))
    together = scene(layers(3), made, world=world, lights=FROM_BELOW)
    cpu, vulkan = (mean(together, name, samples=256) for name in ('CPU', 'VULKAN'))
    np.testing.assert_allclose(vulkan, cpu, rtol=0.01)
