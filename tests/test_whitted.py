# SPDX-License-Identifier: GPL-3.0-or-later
"""Whitted against closed forms: mirrors, panes of glass, the critical angle, absorption, and that the recursion ends.

That demo whitted_classic is the picture of Cycles is in test_whitted_cycles.py.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from classic_scenes import GLASS, MIRROR, Lamp, Material, box, camera, quad, render, scene, session, sphere

SIZE = (8, 8)
GLOW = Material(base_color=(0.0, 0.0, 0.0), emission=(2.0, 3.0, 5.0))
ALL = {'whitted_threshold': 0.0, 'whitted_depth': 40}


def slanted(angle: float) -> np.ndarray:
    """A direction down at `angle` from -z, to +x."""
    return np.array([math.sin(angle), 0.0, -math.cos(angle)])


def view_at(angle: float, distance: float = 10.0, window: float = 0.1):
    """Toward the origin at `angle` to the vertical."""
    return camera(SIZE, -distance * slanted(angle), slanted(angle), window=window)


def dielectric(c: float, eta: float) -> float:
    """Fresnel's reflectance at cosine c, by Snell's angles."""
    sine = math.sqrt(1.0 - c * c) / eta
    if sine >= 1.0:
        return 1.0
    t = math.sqrt(1.0 - sine * sine)
    s, p = (c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t)
    return 0.5 * (s * s + p * p)


@pytest.mark.parametrize('angle', [0.0, 0.5, 1.2])
def test_a_mirror_shows_what_is_across_by_schlick(angle: float) -> None:
    base = np.array([0.9, 0.6, 0.3])
    floor = quad((-5, -5, 0), (10, 0, 0), (0, 10, 0), replace(MIRROR, base_color=tuple(base)))
    ceiling = quad((-60, -60, 20), (120, 0, 0), (0, 120, 0), GLOW)
    made = scene([floor, ceiling])
    picture = render(made, view_at(angle), 'WHITTED')
    expected = np.array(GLOW.emission) * (base + (1.0 - base) * (1.0 - math.cos(angle)) ** 5)
    assert picture[..., :3] == pytest.approx(np.broadcast_to(expected, (8, 8, 3)), rel=2e-5)


@pytest.mark.parametrize('angle', [0.0, 0.6, 1.3])
@pytest.mark.parametrize('ior', [1.33, 1.5, 2.4])
def test_a_pane_transmits_the_fresnel_series(angle: float, ior: float) -> None:
    pane = box((-50, -50, -0.1), (50, 50, 0.1), replace(GLASS, ior=ior))
    behind = quad((-90, -90, -9), (180, 0, 0), (0, 180, 0), GLOW)
    picture = render(scene([pane, behind]), view_at(angle), 'WHITTED', **ALL)
    f = dielectric(math.cos(angle), ior)
    expected = np.array(GLOW.emission) * (1.0 - f) / (1.0 + f)  # (1 - F)^2 (1 + F^2 + F^4 + ...)
    assert picture[..., :3] == pytest.approx(np.broadcast_to(expected, (8, 8, 3)), rel=1e-4)


def test_glass_of_index_1_is_invisible() -> None:
    behind = [
        quad((x - 0.5, -5, -1), (0.25, 0, 0), (0, 10, 0), replace(GLOW, emission=(1.0 + x, 2.0, 3.0 - x)))
        for x in np.arange(0.0, 1.0, 0.25)
    ]
    view = camera((32, 32), (0, 0, 5), (0.1, 0.2, -1))
    ball = sphere((0, 0, 0), 0.3, replace(GLASS, ior=1.0))
    with_ball = render(scene([*behind, ball]), view, 'WHITTED', **ALL)
    without = render(scene(behind), view, 'WHITTED', **ALL)
    assert np.array_equal(with_ball, without)


@pytest.mark.parametrize('ior', [1.1, 1.5, 2.4])
def test_all_is_reflected_from_the_critical_angle_on(ior: float) -> None:
    """From inside of glass, just below the critical angle the outside shows; just above only the inside does."""
    critical = math.asin(1.0 / ior)
    body = quad((-50, -50, 0), (0, 100, 0), (100, 0, 0), replace(GLASS, ior=ior))  # its front is below
    sky = quad((-900, -900, -9), (1800, 0, 0), (0, 1800, 0), GLOW)
    made = scene([body, sky])
    for angle in (critical - 1e-3, critical + 1e-3):
        f = dielectric(math.cos(angle), 1.0 / ior)
        picture = render(made, view_at(angle, 5.0, 1e-3), 'WHITTED', **ALL)[..., :3]
        assert picture == pytest.approx(np.broadcast_to(np.array(GLOW.emission) * (1.0 - f), (8, 8, 3)), abs=5e-3)
        assert (picture.max() == 0.0) == (angle > critical)


def corridor(reflectance: float):
    """Two mirrors that face each other, and a view that never leaves them."""
    mirror = replace(MIRROR, base_color=(reflectance,) * 3)
    low = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0), mirror)
    high = quad((-1, -1, 1), (0, 2, 0), (2, 0, 0), mirror)
    return scene([low, high]), camera(SIZE, (0, 0, 0.5), (0, 0, -1), window=0.1)


@pytest.mark.parametrize('depth', [0, 1, 7])
def test_the_recursion_ends_at_its_depth(depth: int) -> None:
    made, view = corridor(1.0)
    rays = session(made, view, 'WHITTED', whitted_depth=depth).stats()['rays']
    assert rays['bounce'] == depth * rays['camera']


def test_the_recursion_ends_where_little_is_left() -> None:
    made, view = corridor(0.5)
    rays = session(made, view, 'WHITTED', whitted_depth=60, whitted_threshold=0.01).stats()['rays']
    assert rays['bounce'] == 6 * rays['camera']  # 0.5^6 = 0.016, 0.5^7 = 0.008


def test_lamps_and_ambient_light_add_up() -> None:
    """I = ka Ia C + the lamps' light, by the material's own model: here Lambert's."""
    color = np.array([0.2, 0.5, 0.8])
    floor = quad((-5, -5, 0), (10, 0, 0), (0, 10, 0), Material(base_color=tuple(color)))
    made = scene([floor], [Lamp('POINT', (100.0, 50.0, 25.0), (0, 0, 2)), Lamp('SUN', (2.0, 2.0, 2.0))])
    picture = render(made, view_at(0.0, 1.0, 1e-3), 'WHITTED', ambient_color=(1.0, 0.5, 0.25), ambient_strength=0.3)
    point = np.array([100.0, 50.0, 25.0]) / (4.0 * np.pi) / 4.0
    expected = color / np.pi * (point + 2.0) + 0.3 * np.array([1.0, 0.5, 0.25]) * color
    assert picture[..., :3] == pytest.approx(np.broadcast_to(expected, (8, 8, 3)), rel=1e-5)


def test_threads_do_not_change_a_bit() -> None:
    balls = [sphere((x, 0, 0.4), 0.4, glass) for x, glass in ((-0.5, GLASS), (0.5, MIRROR))]
    made = scene([*balls, quad((-3, -3, 0), (6, 0, 0), (0, 6, 0))], [Lamp('SUN', (3.0,) * 3, towards=(1, 1, -2))])
    view = camera((40, 40), (0, -4, 3), (0, 4, -3), up=(0, 0, 1), window=2.0, filter_width=1.5)
    one, four = (render(made, view, 'WHITTED', samples=4, threads=threads) for threads in (1, 4))
    assert np.array_equal(one, four)
    assert one[..., :3].max() > 0.1


# ---- Media, constants of the studies, shadows

CLEAR = replace(GLASS, ior=1.0)


@pytest.mark.parametrize('angle', [0.0, 0.9])
def test_absorption_is_exponential_in_the_way(angle: float) -> None:
    sigma = np.array([0.5, 1.0, 3.0])
    body = box((-5, -5, -0.4), (5, 5, 0.4), replace(CLEAR, model={'absorption': tuple(sigma)}))
    behind = quad((-90, -90, -9), (180, 0, 0), (0, 180, 0), GLOW)
    picture = render(scene([body, behind]), view_at(angle), 'WHITTED', **ALL)[..., :3]
    expected = np.array(GLOW.emission) * np.exp(-sigma * 0.8 / math.cos(angle))
    assert picture == pytest.approx(np.broadcast_to(expected, picture.shape), rel=1e-4)
    # The same for what lies inside.
    inside = quad((-4, -4, 0), (8, 0, 0), (0, 8, 0), GLOW)
    picture = render(scene([body, inside]), view_at(angle), 'WHITTED', **ALL)[..., :3]
    expected = np.array(GLOW.emission) * np.exp(-sigma * 0.4 / math.cos(angle))
    assert picture == pytest.approx(np.broadcast_to(expected, picture.shape), rel=1e-4)


def test_the_constants_of_the_studies() -> None:
    """kr and kt weigh what a model's surface reflects and transmits, whatever the angle; by Snell's law."""
    above = quad((-90, -90, 20), (180, 0, 0), (0, 180, 0), GLOW)
    below = quad((-90, -90, -9), (180, 0, 0), (0, 180, 0), replace(GLOW, emission=(7.0, 11.0, 13.0)))
    sheet = quad((-50, -50, 0), (100, 0, 0), (0, 100, 0), Material(model={'model': 1, 'kr': 0.3, 'kt': 0.6}))
    picture = render(scene([above, sheet, below]), view_at(0.7), 'WHITTED', **ALL)[..., :3]
    expected = 0.3 * np.array(GLOW.emission) + 0.6 * np.array((7.0, 11.0, 13.0))
    assert picture == pytest.approx(np.broadcast_to(expected, picture.shape), rel=1e-5)


@pytest.mark.parametrize('angle', [0.0, 0.8])
def test_shadow_rays_see_through_glass_where_that_is_set(angle: float) -> None:
    tint = np.array((0.9, 0.5, 0.2))
    pane = box((-50, -50, 1.0), (50, 50, 1.2), replace(GLASS, base_color=tuple(tint)))
    floor = quad((-50, -50, 0), (100, 0, 0), (0, 100, 0))
    made = scene([pane, floor], [Lamp('SUN', (2.0, 2.0, 2.0), towards=tuple(slanted(angle)))])
    view = camera(SIZE, (0, 0, 0.5), (0, 0, -1), window=0.1)
    assert render(made, view, 'WHITTED')[..., :3].max() == 0.0
    picture = render(made, view, 'WHITTED', use_transparent_shadows=True)[..., :3]
    through = (1.0 - dielectric(math.cos(angle), 1.5)) ** 2 * tint
    expected = 2.0 * math.cos(angle) / math.pi * through
    assert picture == pytest.approx(np.broadcast_to(expected, picture.shape), rel=1e-4)


def test_shadow_rays_absorb_stop_at_walls_and_end() -> None:
    floor = quad((-50, -50, 0), (100, 0, 0), (0, 100, 0))
    lamp = Lamp('POINT', (4.0 * np.pi**2 * 9.0,) * 3, (0, 0, 3))  # 1 / cos on the floor below
    view = camera(SIZE, (0, 0, 0.05), (0, 0, -1), window=1e-3)

    def light(*shapes) -> float:
        return render(scene([floor, *shapes], [lamp]), view, 'WHITTED', use_transparent_shadows=True)[4, 4, 1]

    body = box((-5, -5, 1), (5, 5, 1.5), replace(CLEAR, model={'absorption': (2.0, 2.0, 2.0)}))
    wall = quad((-5, -5, 2), (10, 0, 0), (0, 10, 0))
    beyond = quad((-5, -5, 4), (10, 0, 0), (0, 10, 0))  # over the lamp: in nobody's way
    open_floor = light()
    assert light(body) == pytest.approx(open_floor * math.exp(-1.0), rel=1e-4)
    assert light(body, wall) == 0.0
    assert light(body, beyond) == pytest.approx(light(body), rel=1e-6)
    sheets = [quad((-5, -5, 0.1 + 0.1 * i), (10, 0, 0), (0, 10, 0), CLEAR) for i in range(17)]
    assert light(*sheets[:16]) == pytest.approx(open_floor, rel=1e-4)
    assert light(*sheets) == 0.0


def test_emitting_surfaces_are_seen_but_light_nothing() -> None:
    floor = quad((-5, -5, 0), (10, 0, 0), (0, 10, 0))
    made = scene([floor, quad((-5, -5, 1), (0, 10, 0), (10, 0, 0), GLOW)])
    assert render(made, camera(SIZE, (0, 0, 0.5), (0, 0, -1)), 'WHITTED')[..., :3].max() == 0.0
    assert render(made, camera(SIZE, (0, 0, 0.5), (0, 0, 1)), 'WHITTED')[0, 0, :3] == pytest.approx(GLOW.emission)
