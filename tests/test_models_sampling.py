# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of the reflection models: they follow their densities, carry f cos / pdf, and keep the energy that they may.

That f is the models' formula is test_models.py's.
"""

from __future__ import annotations

import numpy as np
import pytest

import chi_square
import model_bench as bench
from model_bench import Materials, unit

CELLS, FINE, COUNT = (24, 32), 12, 1_000_000


# Cells are azimuth times a coordinate p in 0..1. Without alpha, p is the height of wi. With it, cells are those of the
# half vector, and p is its slope measured in alpha, so that narrow lobes fill many cells.


def observed_counts(m: Materials, wo: np.ndarray, alpha: float | None) -> np.ndarray:
    wi, _, pdf, _ = bench.sample(m, wo, np.random.default_rng(7).random((COUNT, 3), np.float32))
    v = wi[pdf > 0].astype(float)
    if alpha is None:
        p = 1 - v[:, 2]
    else:
        v = unit(v + wo)
        slope = np.hypot(v[:, 0], v[:, 1]) / v[:, 2] / alpha
        p = slope / (1 + slope)
    phi = np.arctan2(v[:, 1], v[:, 0]) % (2 * np.pi)
    return np.histogram2d(p, phi, CELLS, [(0, 1), (0, 2 * np.pi)])[0]


def expected_counts(m: Materials, wo: np.ndarray, alpha: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Integral of the pdf over each cell by the midpoint rule, and whether the cell is clear of the horizon."""
    p, phi = ((np.arange(k * FINE) + 0.5) / (k * FINE) for k in CELLS)
    p, phi = (a.ravel() for a in np.meshgrid(p, 2 * np.pi * phi, indexing='ij'))
    slope = p / (1 - p)
    z = 1 - p if alpha is None else 1 / np.sqrt(1 + (alpha * slope) ** 2)
    r = np.sqrt(1 - z**2)
    i = np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)
    measure = 2 * np.pi * np.ones_like(p)
    if alpha is not None:
        # Solid angle of h, and of wi = reflection about h: 4 (o . h) times that.
        oh = i @ wo[0].astype(float)
        measure *= z**3 * alpha**2 * slope / (1 - p) ** 2 * 4 * np.maximum(oh, 0)
        i = 2 * oh[:, None] * i - wo
    sub = (CELLS[0], FINE, CELLS[1], FINE)
    mass = bench.evaluate(m, wo, i)[2].astype(float) * measure
    up = (i[:, 2] > 0).reshape(sub).all((1, 3))
    up &= np.roll(up, 1, 1) & np.roll(up, -1, 1) & np.append(up[1:], np.full((1, CELLS[1]), alpha is None), 0)
    return mass.reshape(sub).mean((1, 3)) / (CELLS[0] * CELLS[1]) * COUNT, up


MU = (1.0, 0.6, 0.08)
ONLY = {'base_color': 0, 'metallic': 1, 'f0_mode': bench.COLOR, 'f0': 1}
# (name, values, width of the highlight, cosines of the viewer)
CASES = [
    (f'{name} {roughness:g}', {'model': bench.COOK_TORRANCE, 'roughness': roughness, **ONLY, **kind}, roughness**2)
    for name, kind in [
        ('GGX', {'distribution': bench.GGX}),
        ('Beckmann', {'distribution': bench.BECKMANN, 'masking': bench.SCHLICK_GGX}),
        ('Blinn-Phong D', {'distribution': bench.BLINN, 'masking': bench.SMITH}),
        ('GGX cavities', {'distribution': bench.GGX, 'masking': bench.CAVITY}),
        ('Beckmann cavities', {'distribution': bench.BECKMANN, 'masking': bench.CAVITY}),
    ]
    for roughness in (0.05, 0.35, 0.9)
]
CASES += [
    (f'{name} {n:g}', {'model': model, 'kd': 0, 'shininess': n}, (2 / (n * wide + 2)) ** 0.5)
    for name, model, wide in [('Phong', bench.PHONG, 4), ('Blinn-Phong', bench.BLINN_PHONG, 1)]
    for n in (1, 40, 20000)
]
CASES += [
    ('Lambert', {'model': bench.LAMBERT}, None),
    ('Oren-Nayar', {'model': bench.OREN_NAYAR, 'oren_nayar_sigma': 1.2}, None),
    ('EON', {'model': bench.OREN_NAYAR, 'oren_nayar_sigma': 1.5, 'oren_nayar_form': 1}, None),
    ('toon', {'model': bench.TOON}, None),
    ('Cook-Torrance, both lobes', {'model': bench.COOK_TORRANCE, 'f0_mode': bench.COLOR, 'f0': 0.5}, 0.25),
    ('Phong, both lobes', {'model': bench.PHONG, 'normalized': 1}, 0.13),
    ('Blinn-Phong, both lobes', {'model': bench.BLINN_PHONG, 'shininess': 10}, 0.4),
]


@pytest.mark.every(4)
@pytest.mark.parametrize('mu', MU)
@pytest.mark.parametrize(('name', 'values', 'alpha'), CASES, ids=[case[0] for case in CASES])
def test_samples_follow_pdf(name: str, values: dict[str, object], alpha: float | None, mu: float) -> None:
    m, wo = bench.materials(**values), bench.viewer(mu)
    observed = observed_counts(m, wo, alpha)
    expected, clear = expected_counts(m, wo, alpha)
    # All that is left is one cell: no sample, or one about the horizon.
    observed, expected = (np.append(a[clear], COUNT - a[clear].sum()) for a in (observed, expected))
    assert chi_square.p_value(observed, expected) > chi_square.sidak(0.01, len(CASES) * len(MU))


@pytest.mark.parametrize('model', range(1, 7))
def test_sample_says_what_eval_says(model: int) -> None:
    rng = np.random.default_rng(model)
    count = 20000
    m = bench.materials(
        count,
        model=model,
        roughness=rng.random(count),
        metallic=rng.random(count),
        shininess=10 ** rng.uniform(0, 4, count),
        distribution=rng.integers(0, 3, count),
        masking=rng.integers(0, 4, count),
        fresnel=rng.integers(0, 4, count),
        split=rng.integers(0, 2, count),
        normalized=rng.integers(0, 2, count),
        oren_nayar_form=rng.integers(0, 2, count),
    )
    wo = unit(rng.normal(size=(count, 3)))
    wo[:, 2] = np.abs(wo[:, 2])
    wi, weight, pdf, lobe = bench.sample(m, wo, rng.random((count, 3), np.float32))
    there = (pdf > 0) & ((lobe & bench.SINGULAR) == 0)
    assert there.mean() > 0.7
    assert (weight[pdf == 0] == 0).all()
    diffuse, specular, again = bench.evaluate(m, wo, wi)
    np.testing.assert_array_equal(again[there], pdf[there])
    np.testing.assert_allclose(
        (diffuse + specular)[there].astype(float), weight[there].astype(float) * pdf[there, None], rtol=1e-5, atol=1e-12
    )


TIGHT = [(d, g) for d in range(3) for g in range(4) if d != bench.BLINN or g == bench.CAVITY]


@pytest.mark.parametrize(('distribution', 'masking'), TIGHT)
def test_highlight_is_sampled_tightly(distribution: int, masking: int) -> None:
    """No sample of a white highlight weighs more than 1: G2 is at most the G1 that its half vectors are seen by.

    Blinn-Phong's D with Smith's G is left out: Smith sees more of it than the cavities that it is sampled by.
    """
    # Beckmann is sampled by the exact Lambda and weighed by its rational fit.
    bound = 1.02 if distribution == bench.BECKMANN or masking == bench.SCHLICK_GGX else 1.0001
    for roughness in (0.02, 0.3, 0.7, 1.0):
        values = {'model': 5, 'roughness': roughness, 'distribution': distribution, 'masking': masking}
        m = bench.materials(**{**ONLY, **values})
        for mu in (1.0, 0.5, 0.1, 0.02):
            _, weight, pdf, _ = bench.sample(m, bench.viewer(mu), bench.lattice(1 << 14))
            assert weight[pdf > 0].max() < bound, (roughness, mu)


# ---- Energy


def most_albedo(low: float = 0.01, **values: object) -> tuple[float, float]:
    """The largest share of uniform light that goes to a viewer, and the viewer's cosine."""
    m = bench.materials(**values)
    return max((bench.albedo(m, mu), mu) for mu in (1.0, 0.7, 0.4, 0.2, 0.1, 0.03, low))


WHITE = {'base_color': 1, 'specular_color': 1, 'toon_lit': 1, 'toon_shade': 1}
KEEPS = [
    ('Lambert', {'model': bench.LAMBERT}),
    ('EON', {'model': bench.OREN_NAYAR, 'oren_nayar_form': 1, 'oren_nayar_sigma': 1.2}),
    ('normalised Phong', {'model': bench.PHONG, 'normalized': 1, 'kd': 0, 'ks': 1}),
    ('normalised Blinn-Phong', {'model': bench.BLINN_PHONG, 'normalized': 1, 'kd': 0, 'ks': 1}),
    ('toon', {'model': bench.TOON}),
]
KEEPS += [
    (f'{d} {g} MIX', {'model': bench.COOK_TORRANCE, 'split': bench.MIX, 'distribution': d, 'masking': g, **ONLY})
    for d in range(3)
    for g in range(4)
    if d != bench.BLINN or g in (bench.CAVITY, bench.SCHLICK_GGX)
]


@pytest.mark.parametrize(('name', 'values'), KEEPS, ids=[name for name, _ in KEEPS])
def test_makes_no_energy(name: str, values: dict[str, object]) -> None:
    for variation in ({'roughness': r, 'shininess': n} for r, n in ((0, 1e5), (0.3, 100), (0.7, 8), (1, 0))):
        most, mu = most_albedo(**{**WHITE, **values, **variation})
        assert most < 1.003, (variation, mu)  # 32768 samples


# What makes energy, and how much: the user's description names these.
MAKES = [
    ('classic Phong', {'model': bench.PHONG, 'kd': 0, 'ks': 1, 'shininess': 0}, 6.28),
    ('classic Blinn-Phong', {'model': bench.BLINN_PHONG, 'kd': 0, 'ks': 1, 'shininess': 0}, 6.28),
    ('kd and ks beyond 1', {'model': bench.PHONG, 'normalized': 1, 'ks': 1, 'shininess': 1000}, 2.0),
    ('qualitative Oren-Nayar', {'model': bench.OREN_NAYAR, 'oren_nayar_sigma': 0.3}, 1.005),
    ('ENERGY split', {'model': bench.COOK_TORRANCE, 'split': bench.ENERGY, 'roughness': 0, 'f0': 0.04}, 1.89),
    ('Blinn-Phong D with Smith', {**ONLY, 'model': bench.COOK_TORRANCE, 'distribution': bench.BLINN}, 1.69),
]


@pytest.mark.parametrize(('name', 'values', 'most'), MAKES, ids=[case[0] for case in MAKES])
def test_makes_energy_and_is_known_for_it(name: str, values: dict[str, object], most: float) -> None:
    defaults = {'roughness': 1.0, 'metallic': 0, 'f0_mode': bench.COLOR}
    assert most_albedo(**{**WHITE, **defaults, **values})[0] == pytest.approx(most, rel=0.02)
