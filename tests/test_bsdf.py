# SPDX-License-Identifier: GPL-3.0-or-later
"""The BSDF kernels against what holds for every BSDF, and against a second evaluation in float64.

That they equal Cycles is test_bsdf_cycles.py's.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import bsdf_kernels as bsdf
import bsdf_reference as reference
import chi_square

NORMAL = np.array([0.36, -0.48, 0.8])
FRAME = np.array([[0.8, 0.6, 0.0], [-0.48, 0.64, 0.6], NORMAL])  # rows: two tangents and the normal


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def viewer(mu: float) -> np.ndarray:
    """A direction at cosine mu to the normal."""
    return np.array([math.sqrt(max(1 - mu * mu, 0.0)), 0.0, mu]) @ FRAME


def lattice(count: int) -> np.ndarray:
    """Points of the unit cube, more evenly spread than random ones: rank-1 with the plastic number's cubic cousin."""
    phi = 1.2207440846057596
    return (0.5 + np.arange(count)[:, None] * phi ** -np.arange(1.0, 4.0)) % 1.0


def any_materials(rng: np.random.Generator, count: int, low: float = 0.0) -> np.ndarray:
    return bsdf.materials(
        count,
        base_color=rng.random((count, 3)),
        metallic=rng.choice([0, 0.3, 1], count),
        roughness=low + (1 - low) * rng.random(count),
        ior=rng.choice([1.5, 1.1, 2.5, 0.8, 1.0], count),
        specular_level=rng.choice([0.5, 0.5, 0, 0.2, 1, 20], count),
        specular_tint=np.where(rng.random((count, 1)) < 0.5, 1, rng.random((count, 3))),
    )


def test_functions_of_loops_over_lanes() -> None:
    """Exponential, logarithm and angle against float64, over all that they promise: bounds are those of math.h."""
    rng = np.random.default_rng(3)
    x = np.concatenate(
        (10.0 ** rng.uniform(-37, 37, 100_000), rng.uniform(0, 88, 100_000), rng.uniform(0.5, 2, 100_000))
    )
    x = x.astype(np.float32)
    y = (rng.choice([-1, 1], len(x)) * 10.0 ** rng.uniform(-6, 3, len(x))).astype(np.float32)
    power, logarithm, angle = bsdf.lanes(x, y)
    wide = x.astype(np.float64)
    near = wide < 87
    np.testing.assert_allclose(power[near], np.exp(-wide[near]), rtol=2e-7)  # two roundings, and the polynomial's 5e-9
    assert np.all(power[wide > 87] == 0)
    # m + 1 and the quotient are rounded, and the sum where the power of two takes half of it away.
    np.testing.assert_allclose(logarithm, np.log(wide), rtol=2.5e-7)
    towards = (x - np.float32(1)).astype(np.float64)
    true = np.arctan2(y.astype(np.float64), towards)
    normal = np.abs(true) > 1e-37  # what is smaller has few digits in float32
    np.testing.assert_allclose(angle[normal], true[normal], rtol=2.5e-7)  # quotients and sums round four times
    zero, one = np.zeros(1, np.float32), np.ones(1, np.float32)
    assert bsdf.lanes(one, zero)[2, 0] == 0  # of the null vector


def test_eval_equals_float64() -> None:
    rng = np.random.default_rng(1)
    count = 20000
    material = any_materials(rng, count)
    material['roughness'] = 10 ** rng.uniform(-2.3, 0, count)
    material['flags'] = np.where(rng.random(count) < 0.8, material['flags'], bsdf.SPECULAR_FLAG)
    n = unit(rng.normal(size=(count, 3)))
    wo = unit(rng.normal(size=(count, 3)))
    wo *= np.sign((n * wo).sum(-1, keepdims=True))
    # Half vectors about the normal, within and outside of the lobe.
    spread = (material['roughness'] ** 2 * rng.choice([0.5, 3, 20], count))[:, None]
    h = unit(n + rng.normal(size=(count, 3)) * spread)
    wi = 2 * (wo * h).sum(-1, keepdims=True) * h - wo
    above = ((n * wo).sum(-1) > 1e-3) & ((n * wi).sum(-1) > 1e-3)
    material, n, wo, wi = material[above], *(v[above].astype(np.float32) for v in (n, wo, wi))
    diffuse, glossy, _ = bsdf.Lobes(material, n, wo).evaluate(wi)
    expected = reference.evaluate(material, bsdf.tables(), *(v.astype(float) for v in (n, wo, wi)))
    error_diffuse, error_glossy = (
        np.abs(got - want).max(-1) / (want.max(-1) + 1e-4)
        for got, want in zip((diffuse, glossy), expected, strict=True)
    )
    # The last rounding of h, 6e-8, is seen against alpha, the width of the lobe; 1e-3 covers grazing angles.
    assert (error_glossy < 1e-3 + 1e-7 / material['roughness'].astype(float) ** 2).all()
    assert error_diffuse.max() < 1e-3
    assert np.median(error_glossy) < 1e-5


@pytest.mark.parametrize('row', [1, 5, 12, 22, 31])
def test_tables_equal_quadrature(row: int) -> None:
    table = bsdf.tables()[:1024].reshape(32, 32)
    for column in (3, 10, 20, 31):
        albedo, _ = reference.reflectance((row / 31) ** 2, min(column / 31, 0.9999), 1000)
        assert table[row, column] == pytest.approx(albedo, abs=2e-4)  # error of the quadrature's 1000 steps


# ---- Sampling


CELLS, FINE, COUNT = (24, 32), 12, 1_000_000


def observed_counts(lobes: bsdf.Lobes, o: np.ndarray, alpha: float | None) -> np.ndarray:
    """Samples per cell: azimuth times a coordinate p in 0..1.

    Without alpha, p is the height of wi. With it, cells are those of the half vector, and p is its slope measured in
    alpha, so that narrow lobes fill many cells.
    """
    samples = lobes.sample(np.random.default_rng(7).random((COUNT, 3)))
    v = samples['wi'][samples['pdf'] > 0].astype(float) @ FRAME.T
    if alpha is None:
        p = 1 - v[:, 2]
    else:
        v = unit(v + o)
        slope = np.hypot(v[:, 0], v[:, 1]) / v[:, 2] / alpha
        p = slope / (1 + slope)
    phi = np.arctan2(v[:, 1], v[:, 0]) % (2 * np.pi)
    return np.histogram2d(p, phi, CELLS, [(0, 1), (0, 2 * np.pi)])[0]


def expected_counts(lobes: bsdf.Lobes, o: np.ndarray, alpha: float | None) -> tuple[np.ndarray, np.ndarray]:
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
        oh = i @ o
        measure *= z**3 * alpha**2 * slope / (1 - p) ** 2 * 4 * np.maximum(oh, 0)
        i = 2 * oh[:, None] * i - o
    sub = (CELLS[0], FINE, CELLS[1], FINE)
    mass = lobes.evaluate(i @ FRAME)[2].astype(float) * measure
    up = (i[:, 2] > 0).reshape(sub).all((1, 3))
    up &= np.roll(up, 1, 1) & np.roll(up, -1, 1) & np.append(up[1:], np.full((1, CELLS[1]), alpha is None), 0)
    return mass.reshape(sub).mean((1, 3)) / (CELLS[0] * CELLS[1]) * COUNT, up


METAL = [(roughness, mu, True) for roughness in (0.03, 0.2, 0.8) for mu in (1.0, 0.6, 0.1)]
COATED = [(0.4, 0.9, False), (0.4, 0.15, False), (1.0, 0.5, False)]


@pytest.mark.parametrize(('roughness', 'mu', 'metal'), METAL + COATED)
def test_samples_follow_pdf(roughness: float, mu: float, metal: bool) -> None:
    material = bsdf.materials(roughness=roughness, metallic=float(metal), base_color=0.3)
    lobes, o, alpha = bsdf.Lobes(material, NORMAL, viewer(mu)), viewer(mu) @ FRAME.T, roughness**2 if metal else None
    observed = observed_counts(lobes, o, alpha)
    expected, clear = expected_counts(lobes, o, alpha)
    # All that is left is one cell: no sample, or one about the horizon.
    observed, expected = (np.append(a[clear], COUNT - a[clear].sum()) for a in (observed, expected))
    assert chi_square.p_value(observed, expected) > chi_square.sidak(0.01, len(METAL + COATED))


def test_sample_says_what_eval_says() -> None:
    rng = np.random.default_rng(2)
    material = any_materials(rng, 5000, low=0.1)
    n = unit(rng.normal(size=(5000, 3)))
    wo = unit(n * 1.01 + unit(rng.normal(size=(5000, 3))))
    lobes = bsdf.Lobes(material, n, wo)
    samples = lobes.sample(rng.random((5000, 3)))
    there = samples['pdf'] > 1e-3
    assert there.mean() > 0.8
    diffuse, glossy, pdf = lobes.evaluate(samples['wi'])
    # Evaluation finds the half vector again from wo + wi, whose rounding a sharp lobe magnifies.
    np.testing.assert_allclose(pdf[there], samples['pdf'][there], rtol=2e-3)
    np.testing.assert_allclose(
        (diffuse + glossy)[there], (samples['weight'] * samples['pdf'][:, None])[there], rtol=2e-3, atol=1e-5
    )
    assert set(samples['lobe'][there]) == {bsdf.DIFFUSE, bsdf.GLOSSY}


# ---- Energy


def furnace(material: np.ndarray, mu: float) -> np.ndarray:
    """Share of uniform light that goes to the viewer."""
    samples = bsdf.Lobes(material, NORMAL, viewer(mu)).sample(lattice(1 << 16))
    return (samples['weight'] * (samples['pdf'] > 0)[:, None]).mean(0)


ROUGHNESS = pytest.mark.parametrize('roughness', [0.0, 0.05, 0.2, 0.4, 0.7, 1.0])
MU = pytest.mark.parametrize('mu', [1.0, 0.5, 0.12])


@ROUGHNESS
@MU
def test_white_metal_keeps_all_energy(roughness: float, mu: float) -> None:
    # 1 %: linear interpolation of the albedo, at its worst where roughness and cosine are low.
    assert furnace(bsdf.materials(base_color=1, metallic=1, roughness=roughness), mu) == pytest.approx(1, abs=0.01)


@ROUGHNESS
@MU
def test_no_material_makes_energy(roughness: float, mu: float) -> None:
    for ior, metallic in ((1.5, 0.0), (1.1, 0.0), (3.0, 0.4), (1.5, 0.5)):
        albedo = furnace(bsdf.materials(base_color=1, metallic=metallic, roughness=roughness, ior=ior), mu)
        assert (albedo <= 1.01).all()
        assert (albedo >= 0.9).all()  # and a white one loses little


def test_albedo_is_what_the_furnace_shows() -> None:
    for roughness, mu, ior in ((0.3, 0.8, 1.5), (0.6, 0.4, 2.0), (0.1, 0.5, 1.3)):
        material = bsdf.materials(base_color=(0.1, 0.4, 0.9), roughness=roughness, ior=ior)
        diffuse, glossy = bsdf.Lobes(material, NORMAL, viewer(mu)).albedo()
        # Cycles' estimate leaves the shape of the Fresnel curve out of multiple scattering.
        np.testing.assert_allclose(diffuse[0] + glossy[0], furnace(material, mu), atol=0.01)


def test_single_scattering_loses_what_the_table_says() -> None:
    for row, column in ((6, 20), (16, 10), (31, 25)):
        material = bsdf.materials(base_color=1, metallic=1, roughness=row / 31, flags=bsdf.SPECULAR_FLAG)
        lost = bsdf.tables()[row * 32 + column]
        assert furnace(material, column / 31) == pytest.approx(lost, abs=2e-3)  # 65536 samples


def test_single_scattering_metal_is_reciprocal() -> None:
    rng = np.random.default_rng(3)
    material = any_materials(rng, 2000, low=0.1)
    material['metallic'], material['flags'] = 1, bsdf.SPECULAR_FLAG
    a, b = (unit(NORMAL * 1.05 + unit(rng.normal(size=(2000, 3)))) for _ in range(2))
    there, back = (
        bsdf.Lobes(material, NORMAL, wo).evaluate(wi)[1] / (wi @ NORMAL)[:, None] for wo, wi in ((a, b), (b, a))
    )
    # Float rounding: the two directions enter D and V in different places.
    np.testing.assert_allclose(there, back, rtol=1e-4, atol=1e-6)


# ---- Limits


def test_mirror() -> None:
    """Alpha below Cycles' threshold: nothing to evaluate, and one direction to sample."""
    material = bsdf.materials(2, roughness=(0.0, 0.0037), metallic=1, base_color=(0.2, 0.5, 0.9))
    lobes = bsdf.Lobes(material, NORMAL, viewer(0.5))
    mirrored = 2 * 0.5 * NORMAL - viewer(0.5)
    diffuse, glossy, pdf = lobes.evaluate(mirrored)
    assert not diffuse.any() and not glossy.any() and not pdf.any()
    samples = lobes.sample(lattice(100))
    np.testing.assert_allclose(samples['wi'], np.tile(mirrored, (100, 1)), atol=1e-6)
    assert (samples['lobe'] == bsdf.GLOSSY | bsdf.SINGULAR).all() and (samples['pdf'] == 1).all()
    schlick = 0.5**5
    np.testing.assert_allclose(samples['weight'][0], np.array((0.2, 0.5, 0.9)) * (1 - schlick) + schlick, atol=1e-3)
    assert (bsdf.Lobes(bsdf.materials(roughness=0.0038), NORMAL, NORMAL).evaluate(NORMAL)[1] > 1000).all()


def test_mirror_over_diffuse_shares_the_samples() -> None:
    lobes = bsdf.Lobes(bsdf.materials(roughness=0, base_color=0.4), NORMAL, viewer(0.3))
    samples = lobes.sample(lattice(20000))
    mirror = samples['lobe'] == bsdf.GLOSSY | bsdf.SINGULAR
    p = samples['pdf'][mirror][0]
    assert mirror.mean() == pytest.approx(p, abs=0.005)
    diffuse = samples[~mirror]
    np.testing.assert_allclose(diffuse['pdf'], (1 - p) * (diffuse['wi'] @ NORMAL) / np.pi, atol=1e-5)


def test_lobe_choice_follows_albedo() -> None:
    lobes = bsdf.Lobes(bsdf.materials(roughness=0.5, base_color=0.2), NORMAL, viewer(0.6))
    diffuse, glossy = (float(a.mean()) for a in lobes.albedo())
    chosen = (lobes.sample(lattice(20000))['lobe'] == bsdf.GLOSSY).mean()
    assert chosen == pytest.approx(glossy / (glossy + diffuse), abs=0.002)


def test_nothing_below_the_horizon() -> None:
    lobes = bsdf.Lobes(bsdf.materials(), NORMAL, viewer(0.7))
    for wi in (-NORMAL, -viewer(0.7), viewer(-0.01)):
        assert not any(part.any() for part in lobes.evaluate(wi))


def test_viewer_behind_the_shading_normal_sees_the_base() -> None:
    diffuse, glossy, pdf = bsdf.Lobes(bsdf.materials(), NORMAL, viewer(-0.1)).evaluate(NORMAL)
    assert (diffuse > 0).all() and not glossy.any()
    assert pdf[0] == pytest.approx(1 / np.pi)


def test_hostile_input_gives_numbers() -> None:
    """All corners of the inputs at once: no NaN, no infinity, no negative value."""
    ends = [
        (0.0, 1e-4, 0.0038, 0.004, 1.0, 7.0),  # roughness
        (0.0, 0.5, 1.0, 2.0),  # metallic
        (0.0, 0.1, 1.0, 1.0001, 1.5, 1e9),  # ior
        (0.0, 0.5, 1e4),  # specular level
        (0.0, 1.0, 100.0),  # colours
    ]
    grid = np.stack(np.meshgrid(*ends, indexing='ij'), -1).reshape(-1, 5)
    material = bsdf.materials(
        len(grid),
        roughness=grid[:, 0],
        metallic=grid[:, 1],
        ior=grid[:, 2],
        specular_level=grid[:, 3],
        base_color=grid[:, 4:],
        specular_tint=grid[:, 4:],
    )
    edge = np.array([0.0, 0.5, 1 - 2**-24])
    u = np.stack(np.meshgrid(edge, edge, edge), -1).reshape(-1, 3)
    directions = [viewer(mu) for mu in (1.0, 1e-7, 0.0, -0.5)]
    for wo in directions:
        lobes = bsdf.Lobes(material, NORMAL, wo)
        for wi in (*directions, -wo, 2 * (wo @ NORMAL) * NORMAL - wo):
            for part in lobes.evaluate(wi):
                assert np.isfinite(part).all() and (part >= 0).all()
        samples = lobes.sample(np.repeat(u, len(grid), axis=0))
        for name in ('wi', 'pdf', 'weight'):
            assert np.isfinite(samples[name]).all()
        assert (samples['weight'] >= 0).all() and (samples['pdf'] >= 0).all()
        assert all(np.isfinite(part).all() for part in lobes.albedo())


def test_degenerate_directions_read_in_bounds() -> None:
    """A NaN from a degenerate mesh may spoil its sample, but must not crash."""
    for n, wo in ((np.full(3, np.nan), NORMAL), (NORMAL, np.full(3, np.nan)), (np.zeros(3), NORMAL)):
        lobes = bsdf.Lobes(bsdf.materials(2, metallic=(0.0, 1.0), roughness=(0.3, np.nan)), n, wo)
        assert len(lobes.sample(lattice(10))) == 10
        assert len(lobes.evaluate(NORMAL)[0]) == 2


def test_flags_name_the_lobes_that_are_there() -> None:
    S, D = bsdf.SPECULAR_FLAG, bsdf.DIFFUSE_FLAG
    cases = [
        (S | D, {}),
        (D, {'specular_level': 0}),
        (D, {'ior': 1.0}),
        (S, {'metallic': 1}),
        (S, {'base_color': 0}),
        (S | D, {'metallic': 0.5, 'ior': 1.0}),
    ]
    for expected, values in cases:
        assert bsdf.flags(bsdf.materials(**values))[0] == expected, values
