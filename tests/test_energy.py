# SPDX-License-Identifier: GPL-3.0-or-later
"""Random Principled materials in a white furnace, through whole renders: none sends back more light than arrives.

Single lobes are held against their albedo in test_bsdf.py and test_closures.py. COTORRA_LONG=1 renders 10,000.
"""

from __future__ import annotations

import numpy as np
import pytest

import classic_scenes as classic
from classic_scenes import Material

SEEDS, SAMPLES = 8, 64
SIGMAS = 6.0  # of the mean over seeds, whose deviation eight of them tell roughly
# What albedo tables of 32 cells and their interpolation make in excess, at most: test_bsdf.py's bound.
TABLES = 0.005


def random_material(rng: np.random.Generator, white: bool) -> Material:
    """white: of base color 1, so that all that is lost or made shows."""
    return Material(
        base_color=(1.0, 1.0, 1.0) if white else tuple(rng.random(3)),
        metallic=float(rng.choice([0.0, 1.0, rng.random()])),
        roughness=float(rng.choice([0.0, 0.05, rng.random(), 1.0])),
        ior=float(rng.uniform(1.0, 2.5)),
        specular_level=float(rng.choice([0.0, 0.5, rng.random()])),
        transmission=float(rng.choice([0.0, 0.0, 1.0, rng.random()])),
        alpha=float(rng.choice([1.0, 1.0, rng.random()])),
    )


def furnace(count: int, seed: int, white: bool) -> tuple[np.ndarray, np.ndarray, list[Material]]:
    """Mean and standard error of each material's light in a world of 1, on tilted squares side by side."""
    rng = np.random.default_rng(seed)
    side = round(count**0.5)
    shapes = []
    for k in range(side * side):
        x, y = k % side, k // side
        tilt = rng.uniform(0.0, 1.4)
        # Each square stands above a pixel, and its tilted edges hide nothing of its neighbours' sky but a sliver.
        corner, along = np.array([x, y, 100.0 * k]), np.array([1.0, 0.0, np.tan(tilt)])
        shapes.append(classic.quad(corner, along, (0.0, 1.0, 0.0), random_material(rng, white)))
    middle = 0.5 * side
    view = classic.camera((side, side), (middle, middle, 1e6), (0.0, 0.0, -1.0), window=side, filter_width=0.0)
    view = classic.replace(view, clip=(0.0, 1e9))
    made = classic.scene(shapes, world=(1.0, 1.0, 1.0))
    bounces = dict.fromkeys(('max_bounces', 'diffuse_bounces', 'glossy_bounces', 'transmission_bounces'), 0)
    images = [classic.render(made, view, 'PATH', samples=SAMPLES, seed=s, **bounces) for s in range(SEEDS)]
    images = np.stack(images)[..., :3].reshape(SEEDS, -1, 3).astype(float)
    return images.mean(axis=0), images.std(axis=0, ddof=1) / SEEDS**0.5, [shape.material for shape in shapes]


def assert_no_energy_is_made(count: int, seed: int, white: bool) -> None:
    mean, error, materials = furnace(count, seed, white)
    assert np.isfinite(mean).all() and mean.min() >= 0.0 and mean.mean() > 0.2
    beyond = mean - SIGMAS * error > 1.0 + TABLES
    assert not beyond.any(), [(materials[k], mean[k]) for k in np.flatnonzero(beyond.any(axis=1))[:5]]


@pytest.mark.parametrize('white', [True, False])
def test_random_materials_make_no_energy(white: bool) -> None:
    assert_no_energy_is_made(225, 1, white)


@pytest.mark.long
@pytest.mark.parametrize('seed', range(2, 12))
def test_many_random_materials_make_no_energy(seed: int) -> None:
    assert_no_energy_is_made(1024, seed, seed % 2 == 0)
