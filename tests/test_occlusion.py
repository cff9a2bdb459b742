# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion against closed forms: a plane, a corner, a distance; as a picture, a pass and a term of Direct.

Expected values are integrals of cosine over pi over the part of the sky that is free.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from classic_scenes import Lamp, Material, camera, quad, read, render, scene, session

SIZE = (16, 16)
COLOR = (0.2, 0.5, 0.8)
# A mean of 16 x 16 pixels x 64 samples of a variance of at most 1/4, stratified: three deviations of plain sampling.
NOISE = 3.0 * 0.5 / math.sqrt(16 * 16 * 64)


def floor(color: tuple[float, float, float] = COLOR):
    return quad((-500, -500, 0), (1000, 0, 0), (0, 1000, 0), Material(base_color=color))


def wall(x: float, high: float):
    """A wide wall over the line x, facing -x."""
    return quad((x, -500, 0), (0, 0, high), (0, 1000, 0))


def from_above(x: float = 0.0, window: float = 1e-3, size: tuple[int, int] = SIZE):
    return camera(size, (x, 0, 0.5), (0, 0, -1), window=window)


def test_a_plane_sees_all_of_the_sky() -> None:
    assert np.all(render(scene([floor()]), from_above(), 'AO', samples=4)[..., :3] == 1.0)


@pytest.mark.parametrize('ratio', [0.25, 1.0, 4.0])
def test_a_point_before_a_wall(ratio: float) -> None:
    """A long wall `ratio` times as high as it is far away hides (1 - cos(atan ratio)) / 2 of the sky."""
    made = scene([floor(), wall(1.0, ratio)])
    picture = render(made, from_above(), 'AO', samples=64, ao_distance=1e4)
    hidden = 0.5 * (1.0 - math.cos(math.atan(ratio)))
    assert picture[..., 0].mean() == pytest.approx(1.0 - hidden, abs=NOISE)


def test_half_of_the_sky_is_free_in_a_corner() -> None:
    made = scene([floor(), wall(0.0, 1e4)])
    picture = render(made, camera(SIZE, (-0.01, 0, 0.5), (0, 0, -1), window=1e-4), 'AO', samples=64, ao_distance=1e3)
    assert picture[..., 0].mean() == pytest.approx(0.5, abs=NOISE)


@pytest.mark.parametrize('distance, share', [(0.99, 0.0), (2.0, 0.75), (1e4, 1.0)])
def test_only_surfaces_within_the_distance_hide(distance: float, share: float) -> None:
    """A ceiling 1 m above hides the directions that reach it: sin^2 of the angle whose cosine is 1 / distance."""
    ceiling = quad((-1e5, -1e5, 1), (2e5, 0, 0), (0, 2e5, 0))
    picture = render(scene([floor(), ceiling]), from_above(), 'AO', samples=64, ao_distance=distance)
    assert picture[..., 0].mean() == pytest.approx(1.0 - share, abs=NOISE)


def test_the_picture_knows_no_light() -> None:
    glowing = quad((-500, -500, 0), (1000, 0, 0), (0, 1000, 0), Material(emission=(9.0, 9.0, 9.0)))
    made = scene([glowing], [Lamp('SUN', (5.0, 5.0, 5.0))], world=(3.0, 2.0, 1.0))
    assert np.all(render(made, from_above(), 'AO')[..., :3] == 1.0)
    assert np.all(render(made, camera(SIZE, (0, 0, 1), (0, 0, 1)), 'AO')[..., :3] == (3.0, 2.0, 1.0))  # the background


@pytest.mark.parametrize('integrator', ['DIRECT', 'PATH', 'WHITTED', 'TOON', 'AO'])
def test_the_pass_is_the_picture(integrator: str) -> None:
    made = scene([floor(), wall(0.1, 0.1)], [Lamp('SUN', (1.0, 1.0, 1.0))])
    view = from_above(window=0.2)
    run = session(made, view, integrator, samples=4, passes=('combined', 'ao'))
    assert np.array_equal(read(run, view, 'ao'), render(made, view, 'AO', samples=4)[..., :3])


def test_the_ambient_term_of_direct() -> None:
    made = scene([floor(), wall(1.0, 1.0)])
    light = {'ambient_color': (1.0, 0.5, 0.25), 'ambient_strength': 0.6, 'ao_distance': 1e4, 'samples': 64}
    plain = render(made, from_above(), 'DIRECT', **light)[..., :3]
    expected = 0.6 * np.array((1.0, 0.5, 0.25)) * COLOR
    assert plain == pytest.approx(np.broadcast_to(expected, plain.shape), rel=1e-6)
    occluded = render(made, from_above(), 'DIRECT', use_ambient_occlusion=True, **light)[..., :3]
    sky = render(made, from_above(), 'AO', samples=64, ao_distance=1e4)[..., :3]
    assert occluded == pytest.approx(sky * expected, rel=1e-5)


def test_path_has_no_ambient_light() -> None:
    made = scene([floor()])
    assert render(made, from_above(), 'PATH', ambient_strength=1.0)[..., :3].max() == 0.0


def test_distance_0_hides_nothing() -> None:
    made = scene([floor(), wall(1e-3, 10.0)])
    assert np.all(render(made, from_above(), 'AO', samples=4, ao_distance=0.0)[..., :3] == 1.0)
