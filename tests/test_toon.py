# SPDX-License-Identifier: GPL-3.0-or-later
"""Toon: tones by the number of lamps that light a point fully, and outlines that keep their width and their alpha.

Sobel's kernel is also shown as the OpenGL study misprints it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from classic_scenes import Lamp, Material, box, camera, quad, render, scene, sphere

SIZE = (32, 32)
COLOR = np.array((0.8, 0.4, 0.2))
LIT, SHADE = np.array((0.9, 0.8, 0.1)), np.array((0.1, 0.0, 0.3))
TOON = {'model': 6, 'toon_lit': tuple(LIT), 'toon_shade': tuple(SHADE)}
FLOOR = quad((-50, -50, 0), (100, 0, 0), (0, 100, 0), Material(base_color=tuple(COLOR)))
NO_LINES = {'toon_outline': False}
DOWN = camera(SIZE, (0, 0, 5), (0, 0, -1), window=0.1)


def sun(cosine: float) -> Lamp:
    """A sun under which n.l on the floor is `cosine`."""
    return Lamp('SUN', towards=(math.sqrt(1.0 - cosine * cosine), 0.0, -cosine))


def tone(material: Material, cosines: list[float]) -> np.ndarray:
    floor = replace(FLOOR, material=material)
    picture = render(scene([floor], [sun(cosine) for cosine in cosines]), DOWN, 'TOON', **NO_LINES)[..., :3]
    assert np.all(picture == picture[0, 0])
    return picture[0, 0]


@pytest.mark.parametrize(
    'cosines, lit',
    [
        ([0.51], True),
        ([0.49], False),
        ([0.9, 0.1], True),
        ([0.9, 0.1, 0.2], False),
        ([0.9, 0.8, 0.2], True),
        ([], True),
    ],
)
def test_two_tones_by_the_count_of_lamps(cosines: list[float], lit: bool) -> None:
    assert tone(Material(model=TOON), cosines) == pytest.approx(LIT if lit else SHADE)
    # Half as light to the eye: CIE L* 50 is 0.184 of the luminance of L* 100.
    assert tone(Material(base_color=tuple(COLOR)), cosines) == pytest.approx(COLOR * (1.0 if lit else 0.184))


@pytest.mark.parametrize('full, tones', [(0, 0.0), (1, 1 / 3), (2, 2 / 3), (3, 1.0)])
def test_any_number_of_steps(full: int, tones: float) -> None:
    """Of three lamps in four steps: as many tones up as lamps light fully."""
    found = tone(Material(model=TOON | {'toon_steps': 4}), [0.9] * full + [0.1] * (3 - full))
    assert found == pytest.approx(SHADE + (LIT - SHADE) * tones, rel=1e-5)


def test_a_shadow_has_the_dark_tone() -> None:
    screen = quad((-50, -50, 1), (50, 0, 0), (0, 100, 0))  # over x < 0, out of the view from below
    view = camera(SIZE, (0, 0, 0.5), (0, 0, -1), window=0.2)
    picture = render(scene([FLOOR, screen], [sun(1.0)]), view, 'TOON', **NO_LINES)[..., :3]
    assert np.allclose(picture[:, :15], COLOR * 0.184) and np.allclose(picture[:, 17:], COLOR)


# ---- Outlines

SHEET = quad((-50, -50, 0), (50, 0, 0), (0, 100, 0))  # its edge runs down the middle of the view
WHITE_LINE = {'outline_color': (1.0, 1.0, 1.0), 'outline_width': 10.0}


def test_a_line_is_as_wide_as_it_is_told() -> None:
    view = replace(DOWN, filter_width=1.5)
    for width in (1.0, 5.0, 10.0):
        picture = render(scene([SHEET]), view, 'TOON', samples=256, transparent_film=True, outline_width=width)
        # White sheet, black line, nothing: what is neither white nor open is line.
        covered = picture[..., 3] - picture[..., 0]
        noise = 3.0 * math.sqrt(width / 100.0 / (256 * covered.size))
        assert covered.mean() == pytest.approx(width / 100.0, abs=noise)


def test_lines_look_alike_at_every_resolution() -> None:
    shapes = [box((-0.03, -0.03, 0), (0.02, 0.01, 0.02)), sphere((0.02, 0.02, 0), 0.02)]
    made = scene(shapes, [sun(0.8)])
    small, large = (
        render(made, camera((n, n), (0, 0, 5), (0.1, 0.2, -1), window=0.1, filter_width=1.0), 'TOON', samples=samples)
        for n, samples in ((40, 256), (80, 64))
    )
    assert (large[..., 0] == 0.0).any()  # there are lines
    reduced = large.reshape(40, 2, 40, 2, 4).mean(axis=(1, 3))
    # The pixel filter is half as wide in the large picture: a blur of the lines' edges, not of their place.
    assert abs(reduced[..., 0].mean() - small[..., 0].mean()) < 2e-3
    assert np.abs(reduced - small).mean() < 0.01


def test_lines_cover_the_transparent_film() -> None:
    view = replace(DOWN, filter_width=1.5)
    picture = render(scene([SHEET]), view, 'TOON', samples=64, transparent_film=True, **WHITE_LINE)
    color, alpha = picture[..., :3], picture[..., 3]
    assert alpha[:, 0].min() == 1.0 and alpha[:, -1].max() == 0.0
    partly = (alpha > 0.0) & (alpha < 1.0)
    assert partly.any() and np.allclose(color[partly], alpha[partly][:, None])  # white, premultiplied
    assert (alpha[:, 16] > 0.95).all()  # the outer half of the line covers what is behind


def test_planes_have_no_lines_however_tilted() -> None:
    for slope in (0.0, 1.0, 20.0):
        view = camera(SIZE, (0, -slope, 1), (0, slope, -1), window=1.0)
        perspective = replace(view, kind='PERSP', window=(-0.5, 0.5, -0.5, 0.5))
        for seen in (view, perspective):
            picture = render(scene([FLOOR]), seen, 'TOON', outline_width=2.0, outline_color=(0.0, 9.0, 0.0))
            floor = picture[:12] if slope > 1.0 else picture  # what is left is beyond the horizon, or near it
            assert floor[..., 1].max() < 1.0, slope


def test_scale_changes_nothing() -> None:
    pictures = []
    for scale in (1e-3, 1.0, 1e3):
        shapes = [box(scale * np.array((-2, -2, 0)), scale * np.array((1, 1, 1))), sphere((scale, 0, 0), scale)]
        view = camera(SIZE, (0, -8 * scale, 6 * scale), (0, 8, -6), up=(0, 0, 1), kind='PERSP')
        view = replace(view, clip=(1e-6, 1e6), window=(-0.3, 0.3, -0.3, 0.3))
        pictures.append(render(scene(shapes), view, 'TOON', outline_width=3.0, outline_object=False))
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[1], pictures[2])
    assert (pictures[0] == 0.0).any()


@pytest.mark.parametrize('kind', ['outline_normal', 'outline_depth', 'outline_object'])
def test_each_kind_of_line_finds_its_own(kind: str) -> None:
    """A crease, a step within one object, and the border of two objects that touch in one plane."""
    only = {name: name == kind for name in ('outline_normal', 'outline_depth', 'outline_object')}
    upper = quad((0, -50, 0), (50, 0, 0), (0, 100, 0))
    flat = quad((-50, -50, 0), (50, 0, 0), (0, 100, 0))
    slope = np.array([[-50, -50, -50], [0, -50, 0], [0, 50, 0], [-50, 50, -50]], float)
    step = np.array([[-50, -50, -1], [0, -50, -1], [0, 50, -1], [-50, 50, -1]], float)
    faces = np.array([[0, 1, 2], [0, 2, 3]])

    def joined(other: np.ndarray):
        """One object of both."""
        positions = np.concatenate([upper.positions, other])
        return replace(upper, positions=positions, triangles=np.concatenate([faces, faces + 4]))

    scenes = {'outline_normal': [joined(slope)], 'outline_depth': [joined(step)], 'outline_object': [upper, flat]}
    for name, shapes in scenes.items():
        picture = render(scene(shapes), DOWN, 'TOON', outline_width=10.0, outline_color=(0.0, 0.0, 0.0), **only)
        assert (picture[..., 0].min() == 0.0) == (name == kind), name


def test_a_smooth_sphere_has_a_line_around_it_alone() -> None:
    ball = sphere((0, 0, 0), 0.04, Material(base_color=(1, 1, 1)))
    # Off the axis: a ray that meets an edge of the mesh exactly may slip through between its triangles.
    view = camera((64, 64), (1e-5, 2e-5, 5), (0, 0, -1), window=0.1)
    picture = render(scene([ball]), view, 'TOON', outline_width=2.0, transparent_film=True)
    y, x = np.mgrid[:64, :64]
    radius = np.hypot(x - 31.5, y - 31.5) / 64 * 0.1
    line = (picture[..., 3] == 1.0) & (picture[..., 0] == 0.0)
    assert line[np.abs(radius - 0.04) < 0.0005].all()
    assert not line[np.abs(radius - 0.04) > 0.0025].any()


def test_the_misprinted_kernel_draws_on_everything() -> None:
    """[-1 0 1; -2 0 -2; -1 0 1], as printed, answers a constant with -4 of it: every pixel would be a line."""
    right = np.array([[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]])
    misprinted = np.array([[-1, 0, 1], [-2, 0, -2], [-1, 0, 1]])
    constant = np.ones((3, 3))
    step = np.array([[0, 0, 1]] * 3)
    assert (right * constant).sum() == 0 and (right * step).sum() == 4
    assert (misprinted * constant).sum() == -4 and (misprinted * step).sum() == 0  # and it is blind to an edge


@pytest.mark.parametrize('integrator', ['TOON', 'AO', 'DIRECT'])
def test_threads_do_not_change_a_bit(integrator: str) -> None:
    shapes = [FLOOR, box((-1, -1, 0), (0, 0, 1)), sphere((0.7, 0.2, 0.6), 0.6)]
    made = scene(shapes, [sun(0.8), Lamp('POINT', (90.0, 80.0, 70.0), (2, -2, 3), size=0.2)])
    view = camera((40, 40), (0, -4, 3), (0, 4, -3), up=(0, 0, 1), window=3.0, filter_width=1.5)
    settings = {'samples': 4, 'ambient_strength': 0.2, 'use_ambient_occlusion': True}
    one, four = (render(made, view, integrator, threads=threads, **settings) for threads in (1, 4))
    assert np.array_equal(one, four) and one[..., :3].std() > 0.01
