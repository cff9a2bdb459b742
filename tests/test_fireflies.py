# SPDX-License-Identifier: GPL-3.0-or-later
"""Clamped light and what a denoiser is shown, in scenes whose values are known, on both devices.

Cycles' own pictures are test_fireflies_cycles.py's.
"""

from __future__ import annotations

import numpy as np
import pytest
from cotorra.export import buffers as b

from test_lobes_rendered import FROM_ABOVE, VIEW, asked, layers, mean
from texture_scenes import instances, materials, plane, render, scene

GREY = b.World(color=(0.5, 0.5, 0.5))


@pytest.fixture(params=['CPU', 'VULKAN'])
def device(request: pytest.FixtureRequest) -> str:
    if request.param == 'VULKAN':
        request.getfixturevalue('module')
    return request.param


def test_each_limit_holds_for_its_light(device: str) -> None:
    """A floor in the sun has radiance 0.8, and the sun is direct light. So is a world that the camera sees, or that one
    bounce finds."""
    # Each sample brings the same light, so that only sums of floats differ: 1e-4 is far above their rounding.
    floor, nothing = scene(layers(1), materials(1), lights=FROM_ABOVE), scene((), materials(1), world=GREY)
    np.testing.assert_allclose(mean(floor, device, clamp_direct=0.1), 0.1, rtol=1e-4)
    np.testing.assert_allclose(mean(floor, device, clamp_indirect=0.1), 0.8, rtol=1e-4)
    lit = scene(layers(1), materials(1), world=GREY)
    np.testing.assert_allclose(mean(lit, device, clamp_direct=0.1), 0.1, rtol=1e-4)
    np.testing.assert_allclose(mean(lit, device, clamp_indirect=0.1), 0.4, rtol=1e-4)
    np.testing.assert_allclose(mean(nothing, device, clamp_direct=0.1), 0.1, rtol=1e-4)


@pytest.mark.every(2)
def test_a_denoiser_sees_the_first_rough_surface(device: str) -> None:
    """The floor itself, or through a clear sheet above it."""
    names = ('denoising_albedo', 'denoising_normal')
    glass = {'thin_wall': 1.0, 'transmission': 1.0, 'roughness': 0.0, 'ior': 1.0, 'base_color': (1.0, 1.0, 1.0)}
    sheet = materials(2, **{name: [None, value] for name, value in glass.items() if name != 'ior'}, ior=[1.0, 1.0])
    for made in (scene(layers(1), materials(1)), scene(layers(2), sheet)):
        found = render(made, VIEW, samples=16, integrator='PATH', max_bounces=4, device=device, passes=names)
        np.testing.assert_allclose(found['denoising_albedo'], 0.8, rtol=1e-3)
        np.testing.assert_allclose(found['denoising_normal'], np.broadcast_to((0, 0, 1), (16, 16, 3)), atol=1e-3)


def test_rough_metal_has_an_albedo(device: str) -> None:
    metal = asked(1, base_color=(1.0, 1.0, 1.0), metallic=1.0, specular_tint=(1.0, 1.0, 1.0), roughness=0.6)
    found = render(scene(layers(1), metal), VIEW, samples=16, device=device, passes=('denoising_albedo',))
    np.testing.assert_allclose(found['denoising_albedo'], 1.0, atol=0.02)


def test_held_back_caustics_are_told_apart() -> None:
    """A floor that shines and, unseen by the camera, a mirror all over it: the floor's own light of 0.5, and as
    much again by way of the mirror, which is a caustic. Devices other than the CPU do not count."""
    mirror = {'metallic': [0.0, 1.0], 'roughness': [1.0, 0.0], 'specular_tint': [(1.0, 1.0, 1.0)] * 2}
    colors = {'base_color': [(1.0, 1.0, 1.0)] * 2, 'emission': [(0.5, 0.5, 0.5), (0.0, 0.0, 0.0)]}
    made = materials(2, emission_sampling=[0, 0], **colors, **mirror)
    above = instances(2, visibility=np.array([63, 63 & ~b.VISIBLE_CAMERA], np.uint32))
    room = scene((plane(-1e4, 1e4), plane(-1e4, 1e4, 1.0)), made, instances=above)
    for limits, held in (({'clamp_indirect': 0.1}, 0.4), ({'filter_glossy': 1e-3}, 0.0), ({'clamp_direct': 0.1}, 0.0)):
        found = render(room, VIEW, samples=16, integrator='PATH', max_bounces=2, **limits)['stats']
        assert found['caustics'] / found['light'] == pytest.approx(0.5, rel=1e-3)
        assert found['held_caustics'] / found['light'] == pytest.approx(held, rel=1e-3)
    found = render(room, VIEW, samples=16, integrator='PATH', max_bounces=2)['stats']
    assert found['caustics'] == found['light'] == 0.0
