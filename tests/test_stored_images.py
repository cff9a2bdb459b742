# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures against the mean and the variance that were stored of many: z-tests (Subr & Arvo 2007).

tests/stored holds a line a pixel: mean and standard deviation of one picture's luminance over SEEDS seeds.
COTORRA_STORE=1 writes them anew, after a change that is meant to change pictures; a converged mean elsewhere says
whether it may (test_transport.py, test_engine_real.py).
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import classic_scenes as classic
from chi_square import sidak
from classic_scenes import GLASS, MIRROR, Lamp, Material

FOLDER = Path(__file__).resolve().parent / 'stored'
SIZE, SAMPLES, SEEDS, NEW = (16, 12), 16, 96, 4
LUMINANCE = (0.2126, 0.7152, 0.0722)  # ITU-R BT.709
METAL = Material(base_color=(0.9, 0.6, 0.3), metallic=1.0, roughness=0.3)
GLOW = Material(base_color=(0.0, 0.0, 0.0), emission=(4.0, 3.0, 2.0))


def room(ball: Material) -> list[classic.Shape]:
    grey = Material(base_color=(0.7, 0.7, 0.7))
    red = Material(base_color=(0.7, 0.2, 0.2))
    return [
        classic.quad((-2, -1, -2), (4, 0, 0), (0, 0, 4), red),
        classic.quad((-2, -1, -2), (4, 0, 0), (0, 3, 0), grey),
        classic.quad((-0.5, 1.8, -0.5), (1, 0, 0), (0, 0, 1), GLOW),
        classic.sphere((0.0, 0.0, 0.0), 0.8, ball, segments=24),
    ]


SCENES = {
    'metal': (room(METAL), [Lamp('POINT', (20.0,) * 3, (1.5, 1.5, 2.0), size=0.2)], (0.2, 0.2, 0.3)),
    'glass': (room(GLASS), [], (0.3, 0.3, 0.3)),
    'mirror': (room(MIRROR), [Lamp('SUN', (1.0,) * 3, towards=(-0.3, -1.0, -0.4), size=0.2)], (0.1, 0.1, 0.1)),
}


def pictures(name: str, seeds: range) -> np.ndarray:
    """(seeds, pixels) luminance."""
    shapes, lamps, world = SCENES[name]
    made = classic.scene(shapes, lamps, world=world)
    view = classic.camera(SIZE, (0.0, 0.6, 5.0), (0.0, -0.1, -1.0), window=3.0)
    found = [classic.render(made, view, 'PATH', samples=SAMPLES, seed=seed)[..., :3].ravel() for seed in seeds]
    return np.stack(found).astype(float).reshape(len(seeds), -1, 3) @ LUMINANCE


def z_scores(found: np.ndarray, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Of the mean of several pictures; the last one is the whole picture's, whose pixels are taken as independent."""
    count = len(found)
    spread = np.maximum(deviation, 1e-6 * mean.mean()) * np.sqrt(1.0 / count + 1.0 / SEEDS)
    difference = found.mean(axis=0) - mean
    return np.append(difference / spread, difference.sum() / np.sqrt((spread**2).sum()))


@pytest.mark.parametrize('name', SCENES)
def test_pictures_are_those_that_were_stored(name: str) -> None:
    path = FOLDER / f'{name}.txt'
    if os.environ.get('COTORRA_STORE'):
        images = pictures(name, range(SEEDS))
        np.savetxt(path, np.stack([images.mean(axis=0), images.std(axis=0, ddof=1)], axis=1), fmt='%.6g')
    mean, deviation = np.loadtxt(path, unpack=True)
    z = z_scores(pictures(name, range(1000, 1000 + NEW)), mean, deviation)
    # Rare bright samples make tails heavier than the normal distribution's: all but a few of the pixels, and the sum.
    level = sidak(0.01, len(SCENES) * len(z))
    limit = np.sqrt(-2.0 * np.log(0.5 * level))  # erfc(z / sqrt 2) is below 2 exp(-z² / 2)
    assert np.sum(np.abs(z[:-1]) > limit) <= 0.02 * len(z) and abs(z[-1]) < limit, (limit, np.sort(np.abs(z))[-8:])


def test_a_wrong_picture_is_found() -> None:
    """One that is 3 % brighter."""
    mean, deviation = np.loadtxt(FOLDER / 'metal.txt', unpack=True)
    found = 1.03 * pictures('metal', range(1000, 1000 + NEW))
    assert abs(z_scores(found, mean, deviation)[-1]) > 6.0
