# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobes of kernels/closure: sampling against density, energy, reciprocity, extremes, and formulas in float64.

What Cycles makes of the same closures is test_closures_cycles.py's.
"""

from __future__ import annotations

import numpy as np
import pytest

import bsdf_kernels as bsdf
import chi_square
import closure_kernels as closure
import kernel_source as kernels

Z = np.array([0.0, 0.0, 1.0])
OBLIQUE = np.array([0.6, 0.0, 0.8])
GRAZING = np.array([0.96, 0.0, 0.28])

# Name -> kind and values. Sharper ones would need finer cells than are counted.
ROUGH = {
    'lambert': ('DIFFUSE', {'roughness': 0.0}),
    'rough diffuse': ('DIFFUSE', {'roughness': 0.8}),
    'translucent': ('TRANSLUCENT', {'roughness': 0.0}),
    'rough translucent': ('TRANSLUCENT', {'roughness': 1.0}),
    'ggx': ('REFLECTION', {'roughness': 0.5}),
    'multiscatter ggx': ('REFLECTION', {'roughness': 0.7, 'distribution': closure.MULTI_GGX}),
    'anisotropic': ('REFLECTION', {'roughness': 0.7, 'anisotropy': 0.6, 'rotation': 0.1}),
    'beckmann': ('REFLECTION', {'roughness': 0.6, 'distribution': closure.BECKMANN}),
    'anisotropic beckmann': (
        'REFLECTION',
        {'roughness': 0.7, 'anisotropy': -0.5, 'distribution': closure.BECKMANN},
    ),
    'ashikhmin-shirley': ('ASHIKHMIN_SHIRLEY', {'roughness': 0.6, 'distribution': closure.ASHIKHMIN_SHIRLEY}),
    'anisotropic ashikhmin-shirley': (
        'ASHIKHMIN_SHIRLEY',
        {'roughness': 0.7, 'anisotropy': 0.5, 'rotation': 0.2, 'distribution': closure.ASHIKHMIN_SHIRLEY},
    ),
    'metal': ('METALLIC', {'roughness': 0.5, 'distribution': closure.MULTI_GGX}),
    'metal under a film': ('METALLIC', {'roughness': 0.5, 'film': 400.0}),
    'conductor': ('CONDUCTOR', {'roughness': 0.5, 'color': (0.2, 0.9, 1.5), 'edge': (3.9, 2.4, 2.1)}),
    'glass': ('GLASS', {'roughness': 0.5}),
    'glass from inside': ('GLASS', {'roughness': 0.6, 'inside': 1}),
    'glass under a film': ('GLASS', {'roughness': 0.6, 'film': 350.0}),
    'beckmann glass': ('GLASS', {'roughness': 0.7, 'distribution': closure.BECKMANN}),
    'refraction': ('REFRACTION', {'roughness': 0.5, 'ior': 1.33}),
    'refraction from inside': ('REFRACTION', {'roughness': 0.6, 'inside': 1}),
    'sheen': ('SHEEN', {'roughness': 0.4}),
    'velvet': ('VELVET', {'roughness': 0.5}),
    'diffuse toon': ('TOON_DIFFUSE', {'size': 0.5, 'smooth_rim': 0.3}),
    'glossy toon': ('TOON_GLOSSY', {'size': 0.3, 'smooth_rim': 0.2}),
}
NAMED = pytest.mark.parametrize('name', ROUGH)


def lobes(name: str, wo: object = OBLIQUE, count: int = 1, **values: object) -> closure.Lobes:
    kind, own = ROUGH[name]
    return closure.Lobes(closure.cases(kind, count, **{**own, **values}), Z, wo)


def sphere(nodes: int) -> np.ndarray:
    """Directions of equal solid angle all around, by rows of cosine, then azimuth."""
    cosine = 1 - 2 * (np.arange(nodes) + 0.5) / nodes
    phi = 2 * np.pi * (np.arange(nodes) + 0.5) / nodes
    sine = np.sqrt(1 - cosine**2)
    return np.stack(
        [
            sine[:, None] * np.cos(phi),
            sine[:, None] * np.sin(phi),
            np.broadcast_to(cosine[:, None], (nodes, nodes)),
        ],
        -1,
    )


def random(seed: int, count: int) -> np.ndarray:
    return np.random.default_rng(seed).random((count, 3)).astype(np.float32)


@NAMED
@pytest.mark.parametrize('wo', [OBLIQUE, GRAZING], ids=['oblique', 'grazing'])
def test_samples_follow_the_density(name: str, wo: np.ndarray) -> None:
    cells, fine, count = 16, 24, 200_000
    lobe = lobes(name, wo)
    _, pdf = lobe.evaluate(sphere(cells * fine).reshape(-1, 3))
    # Each cell is the mean of its directions, of equal solid angle.
    mean = pdf.astype(float).reshape(cells, fine, cells, fine).mean((1, 3))
    expected = mean.ravel() * (4 * np.pi / cells**2) * count
    samples = lobe.sample(random(7, count))
    taken = samples[samples['pdf'] > 0]
    row = np.clip(((1 - taken['wi'][:, 2]) * 0.5 * cells).astype(int), 0, cells - 1)
    turn = np.arctan2(taken['wi'][:, 1], taken['wi'][:, 0]) / (2 * np.pi) % 1
    column = np.clip((turn * cells).astype(int), 0, cells - 1)
    observed = np.bincount(row * cells + column, minlength=cells**2).astype(float)
    # What is no sample is a cell of its own.
    observed = np.append(observed, count - len(taken))
    expected = np.append(expected, max(count - expected.sum(), 1e-9))
    assert chi_square.p_value(observed, expected) > chi_square.sidak(0.01, 2 * len(ROUGH))


@NAMED
def test_weight_is_f_over_pdf(name: str) -> None:
    lobe = lobes(name)
    samples = lobe.sample(random(3, 4096))
    samples = samples[samples['pdf'] > 0]
    assert len(samples) > 1000
    assert not (samples['lobe'] & closure.SINGULAR).any()
    below = samples['wi'][:, 2] < 0
    assert (((samples['lobe'] & closure.TRANSMIT) != 0) == below).all()
    f, pdf = lobe.evaluate(samples['wi'])
    # The half vector of a sampled pair is rounded otherwise than the one that was drawn.
    np.testing.assert_allclose(pdf, samples['pdf'], rtol=5e-3)
    np.testing.assert_allclose(f, samples['weight'] * samples['pdf'][:, None], rtol=5e-3, atol=1e-6)


@NAMED
def test_energy_is_not_made(name: str) -> None:
    """Of a white surface in a white world."""
    kind, _ = ROUGH[name]
    white = {} if kind == 'CONDUCTOR' else {'color': 1.0, 'edge': 1.0}
    for wo in (OBLIQUE, GRAZING):
        samples = lobes(name, wo, **white).sample(random(5, 100_000))
        albedo = np.where(samples['pdf'][:, None] > 0, samples['weight'], 0).astype(float).mean(0)
        # Velvet and Ashikhmin & Shirley promise nothing at grazing angles; their papers say so.
        if kind not in ('VELVET', 'ASHIKHMIN_SHIRLEY'):
            assert (albedo < 1.005).all()


@pytest.mark.parametrize('roughness', [0.0, 0.3, 0.6, 1.0])
@pytest.mark.parametrize('inside', [0, 1])
@pytest.mark.parametrize('ior', [1.0, 1.33, 2.0])
def test_white_glass_keeps_all_light(roughness: float, inside: int, ior: float) -> None:
    case = closure.cases(
        'GLASS', color=1.0, roughness=roughness, ior=ior, inside=inside, distribution=closure.MULTI_GGX
    )
    for wo in (Z, OBLIQUE, GRAZING):
        samples = closure.Lobes(case, Z, wo).sample(random(11, 100_000))
        albedo = np.where(samples['pdf'][:, None] > 0, samples['weight'], 0).astype(float).mean(0)
        # The tables are linear between 16 nodes. From inside, they count what facets send back up, as Cycles' do.
        assert (albedo < 1.02).all()
        assert (albedo > (0.7 if inside and ior > 1 else 0.98)).all()


@pytest.mark.parametrize('roughness', [0.1, 0.5, 1.0])
def test_white_rough_diffuse_keeps_all_light(roughness: float) -> None:
    case = closure.cases('DIFFUSE', color=1.0, roughness=roughness)
    for wo in (Z, OBLIQUE, GRAZING):
        samples = closure.Lobes(case, Z, wo).sample(random(2, 100_000))
        np.testing.assert_allclose(samples['weight'].astype(float).mean(0), 1, atol=0.003)


@pytest.mark.parametrize('name', ['rough diffuse', 'ggx', 'anisotropic', 'beckmann', 'conductor'])
def test_reciprocity(name: str) -> None:
    rng = np.random.default_rng(4)
    a, b = rng.normal(size=(2, 200, 3))
    a[:, 2], b[:, 2] = np.abs(a[:, 2]) + 0.05, np.abs(b[:, 2]) + 0.05
    a, b = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (a, b))
    there, _ = lobes(name, a, 200).evaluate(b)
    back, _ = lobes(name, b, 200).evaluate(a)
    np.testing.assert_allclose(there / b[:, 2:], back / a[:, 2:], rtol=2e-4, atol=1e-6)


def test_bad_input_makes_no_nan() -> None:
    """Extremes of every number, directions at and below the horizon, and normals that lean away from the viewer."""
    rng = np.random.default_rng(9)
    count = 4000
    names = ['DIFFUSE', 'TRANSLUCENT', 'REFLECTION', 'ASHIKHMIN_SHIRLEY', 'METALLIC', 'CONDUCTOR', 'GLASS']
    names += ['REFRACTION', 'SHEEN', 'VELVET', 'TOON_DIFFUSE', 'TOON_GLOSSY']
    directions = rng.normal(size=(3, count, 3))
    directions[:, ::5, 2] *= 1e-6
    wo, wi, n = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in directions)
    n[::7], wi[::11] = wo[::7], -wo[::11]
    for name in names:
        case = closure.cases(name, count)
        for field in ('roughness', 'anisotropy', 'rotation', 'size', 'smooth_rim'):
            case[field] = rng.choice([0, 0, 1e-6, 0.01, 0.5, 1, 1.5, -1, -0.2], count)
        for field in ('color', 'edge'):
            case[field] = rng.choice([0, 0, 0.2, 1, 1, 3, -1], (count, 3))
        case['ior'] = rng.choice([0, 1e-6, 0.5, 1, 1 + 1e-5, 1.0003, 1.5, 1000], count)
        case['film'] = rng.choice([0, 0, 0.05, 0.5, 300, 1e6], count)
        case['film_ior'] = rng.choice([0, 1, 1.33, 100], count)
        case['distribution'] = rng.integers(0, 3, count)
        case['inside'] = rng.integers(0, 2, count)
        case['tangent'] = rng.choice([0, 0, 1], (count, 3))
        lobe = closure.Lobes(case, n, wo)
        f, pdf = lobe.evaluate(wi)
        samples = lobe.sample(rng.choice([0, 1e-7, 0.5, 0.99999994], (count, 3)))
        assert np.isfinite(samples['wi']).all(), name
        for values in (f, pdf, samples['pdf'], samples['weight'], lobe.albedo()):
            assert np.isfinite(values).all() and (values >= 0).all(), name


def test_mirrors_and_clear_glass_are_singular() -> None:
    for name, values in {
        'REFLECTION': {'roughness': 0.0},
        'ASHIKHMIN_SHIRLEY': {'roughness': 0.0},
        'GLASS': {'roughness': 0.0},
        'REFRACTION': {'roughness': 0.0},
    }.items():
        lobe = closure.Lobes(closure.cases(name, color=1.0, **values), Z, OBLIQUE)
        assert not np.any(lobe.evaluate(sphere(64).reshape(-1, 3))[0])
        samples = lobe.sample(random(1, 4096))
        assert (samples['lobe'] & closure.SINGULAR).all()
        through = samples['wi'][:, 2] < 0
        # Snell's law, and the mirror.
        expected = np.where(through[:, None], [-0.4, 0, -np.sqrt(1 - 0.16)], [-0.6, 0, 0.8])
        np.testing.assert_allclose(samples['wi'], expected, atol=1e-6)
        fresnel = fresnel_dielectric(0.8, 1.5)
        share = {'GLASS': 1 - fresnel, 'REFRACTION': 1.0}.get(name, 0.0)
        np.testing.assert_allclose(through.mean(), share, atol=0.01)
        np.testing.assert_allclose(samples['weight'], 1, rtol=1e-5)


def test_nothing_is_refracted_beyond_the_critical_angle() -> None:
    for name in ('GLASS', 'REFRACTION'):
        lobe = closure.Lobes(closure.cases(name, color=1.0, roughness=0.0, inside=1), Z, OBLIQUE * [1.5, 1, 0.5])
        samples = closure.Lobes(lobe.case, Z, [np.sqrt(0.75), 0, 0.5]).sample(random(1, 512))
        assert not (samples['lobe'] & closure.TRANSMIT).any()
        assert (samples['pdf'] == (1 if name == 'GLASS' else 0)).all()


# ---- Formulas in float64


def fresnel_dielectric(c: np.ndarray | float, eta: np.ndarray | float) -> np.ndarray:
    c_t = np.emath.sqrt(1 - (1 - np.asarray(c, float) ** 2) / np.asarray(eta, float) ** 2)
    s = np.abs((c - eta * c_t) / (c + eta * c_t)) ** 2
    p = np.abs((eta * c - c_t) / (eta * c + c_t)) ** 2
    return (s + p) / 2


def test_rough_glass_is_walters() -> None:
    """Walter et al. 2007, eq. 20, 21 and 33, for facets that can refract from one side to the other."""
    rng = np.random.default_rng(6)
    count = 4000
    wo, wi = rng.normal(size=(2, count, 3))
    wo[:, 2], wi[:, 2] = np.abs(wo[:, 2]) + 0.05, -np.abs(wi[:, 2]) - 0.05
    wo, wi = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (wo, wi))
    roughness, ior = rng.uniform(0.3, 1, count), rng.uniform(1.1, 2.5, count)
    inside = rng.integers(0, 2, count)
    case = closure.cases('GLASS', count, color=1.0, roughness=roughness, ior=ior, inside=inside)
    got, pdf = closure.Lobes(case, Z, wo).evaluate(wi)

    eta = np.where(inside, 1 / ior, ior)[:, None]
    h = -(wo + eta * wi)
    h *= np.sign(h[:, 2:])
    length = np.linalg.norm(h, axis=1)
    h /= length[:, None]
    c_o, c_i = (wo * h).sum(1), (wi * h).sum(1)
    alpha2 = roughness**4

    def smith(z: np.ndarray) -> np.ndarray:
        return (np.sqrt(1 + alpha2 * (1 / z**2 - 1)) - 1) / 2

    d = alpha2 / (np.pi * (h[:, 2] ** 2 * (alpha2 - 1) + 1) ** 2)
    g = 1 / (1 + smith(wo[:, 2]) + smith(wi[:, 2]))
    f = 1 - fresnel_dielectric(np.abs(c_o), eta[:, 0])
    want = np.abs(c_o * c_i) / wo[:, 2] * eta[:, 0] ** 2 * f * g * d / length**2
    possible = (c_o > 0) & (c_i < 0)
    assert 0.2 < possible.mean() < 0.95
    # Pairs that no facet leads to each other are lit all the same (Cycles), though never sampled.
    # The half vector of a nearly straight pair is a small difference in 32 bits; the digits it costs were not counted.
    np.testing.assert_allclose(got, np.tile(want[:, None], 3), rtol=2e-3, atol=1e-5)
    assert (pdf[possible] > 0).all() and not pdf[~possible].any()


def test_film_has_airys_limits() -> None:
    """Its limits, from Airy's formula; what lies between is compared with Cycles."""
    tables = bsdf.tables()
    first, nodes = kernels.constants()['TABLE_FILM'], kernels.constants()['FILM_NODES']
    cosines = tables[first : first + 3 * nodes].reshape(3, nodes)
    # 1. The tables are Fourier integrals of sensitivities of mean 1, which long paths wash out.
    np.testing.assert_allclose(cosines[:, 0], 1, atol=1e-6)
    assert (np.abs(cosines[:, -1]) < 5e-3).all()
    # 2. A film of the substrate's own index does nothing.
    n = np.tile(Z, (64, 1))
    mu = np.linspace(0.05, 1, 64)
    wo = np.stack([np.sqrt(1 - mu**2), 0 * mu, mu], -1)
    bare = closure.Lobes(closure.cases('GLASS', 64, color=1.0, roughness=0.3, ior=1.5), n, wo)
    same = closure.Lobes(closure.cases('GLASS', 64, color=1.0, roughness=0.3, ior=1.5, film=500.0, film_ior=1.5), n, wo)
    wi = wo * [-1, 1, 1]
    np.testing.assert_allclose(same.evaluate(wi)[0], bare.evaluate(wi)[0], rtol=2e-3)
    # 3. A thick film loses its colour: the mean over all phases, r12 + t12^2 r23 / (1 - r12 r23) of each polarisation.
    thick = closure.Lobes(
        closure.cases('CONDUCTOR', 64, color=0.2, edge=3.0, roughness=0.3, film=40_000.0, film_ior=1.4), n, wo
    )
    bare = closure.Lobes(closure.cases('REFLECTION', 64, color=1.0, roughness=0.3), n, wo)
    got = thick.evaluate(wi)[0] / bare.evaluate(wi)[0]
    inside = np.sqrt(1 - (1 - mu**2) / 1.4**2)
    index = complex(0.2, 3.0)
    root = np.emath.sqrt(index**2 - 1.4**2 * (1 - inside**2))

    def squared(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.abs((a - b) / (a + b)) ** 2

    want = 0.0
    for r12, r23 in (
        (squared(mu, 1.4 * inside), squared(1.4 * inside, root)),
        (squared(1.4 * mu, inside), squared(index**2 * inside, 1.4 * root)),
    ):
        want = want + 0.5 * (r12 + (1 - r12) ** 2 * r23 / (1 - r12 * r23))
    np.testing.assert_allclose(got, np.tile(want[:, None], 3), atol=5e-3)


# ---- Principled


def principled_furnace(p: closure.Principled, count: int = 200_000) -> np.ndarray:
    rng = np.random.default_rng(8)
    u = rng.random((count, 4))
    _, _, samples, _ = p.draw(u, Z)
    return np.where(samples['pdf'][:, None] > 0, samples['weight'], 0).astype(float).mean(0)


def test_a_plain_surface_is_todays() -> None:
    """Without the new layers the pick is certain, and all bits are those of bsdf.h."""
    rng = np.random.default_rng(2)
    count = 500
    values = {
        'base_color': rng.random((count, 3)),
        'metallic': rng.choice([0, 0.4, 1], count),
        'roughness': rng.random(count),
        'ior': rng.uniform(1, 2, count),
        'specular_tint': rng.random((count, 3)),
    }
    picked = closure.Principled(closure.inputs(count, **values), Z, OBLIQUE)
    wi = np.array([-0.3, 0.4, 0.86])
    f, pdf, _, kind = picked.draw(rng.random((count, 4)), wi)
    assert (kind == kernels.constants()['PICK_BSDF']).all()
    diffuse, glossy, want = bsdf.Lobes(bsdf.materials(count, **values), Z, OBLIQUE).evaluate(wi)
    assert (f == diffuse + glossy).all() and (pdf == want).all()


LAYERS = {
    'coat': {'coat': 1.0, 'coat_roughness': 0.3},
    'sheen': {'sheen': 1.0},
    'both over metal': {'coat': 0.5, 'sheen': 0.5, 'metallic': 0.7},
    'glass': {'transmission': 1.0},
    'half glass': {'transmission': 0.5, 'metallic': 0.5, 'coat': 1.0},
    'thin wall': {'transmission': 1.0, 'thin_wall': 1},
    'thin translucent wall': {'thin_wall': 1, 'subsurface': 0.7, 'diffuse_roughness': 0.5},
    'brushed': {'metallic': 0.6, 'anisotropic': 0.8},
    'film': {'film': 500.0, 'metallic': 0.3},
}


@pytest.mark.parametrize('name', LAYERS)
def test_layers_make_no_energy(name: str) -> None:
    for wo in (OBLIQUE, GRAZING):
        p = closure.Principled(closure.inputs(base_color=1.0, **LAYERS[name]), Z, wo)
        energy = principled_furnace(p)
        assert (energy < 1.01).all() and (energy > 0.3).all()


def test_layer_by_layer_is_the_fast_road() -> None:
    """An anisotropy too small to bend anything takes every layer for itself; their mean is what one Bsdf has."""
    rng = np.random.default_rng(3)
    count, picks = 50, 4096
    values = {
        'base_color': rng.random((count, 3)),
        'metallic': rng.choice([0, 0.4, 1], count),
        'roughness': rng.uniform(0.2, 1, count),
        'ior': rng.uniform(1.1, 2, count),
        'coat': rng.choice([0, 0.5, 1], count),
        'coat_roughness': 0.4,
        'sheen': rng.choice([0, 0.5, 1], count),
        'transmission': rng.choice([0, 0, 0.5], count),
    }
    u = np.zeros((picks, count, 4))
    u[..., 0] = ((np.arange(picks) + 0.5) / picks)[:, None]
    means = []
    for anisotropic in (0.0, 1e-12):
        p = closure.Principled(closure.inputs(count, anisotropic=anisotropic, **values), Z, OBLIQUE)
        f, _, _, picked = p.draw(u.reshape(-1, 4), [-0.3, 0.4, 0.86])
        assert (picked == kernels.constants()['PICK_BSDF']).any() == (anisotropic == 0.0)
        means.append(f.astype(float).reshape(picks, count, 3).mean(0))
    # A layer's edge falls within a step of the numbers.
    np.testing.assert_allclose(means[1], means[0], rtol=8 / picks * 10)


def test_principled_never_makes_nan() -> None:
    rng = np.random.default_rng(19)
    count = 8000
    values: dict[str, object] = {}
    for field in ('metallic', 'roughness', 'coat', 'coat_roughness', 'sheen', 'sheen_roughness', 'diffuse_roughness'):
        values[field] = rng.choice([0, 0, 1e-6, 0.3, 1, 2, -1], count)
    for field in ('subsurface', 'subsurface_anisotropy', 'anisotropic', 'rotation', 'transmission', 'specular_level'):
        values[field] = rng.choice([0, 0, 0.5, 1, 20, -1], count)
    for field in ('base_color', 'specular_tint', 'coat_tint', 'sheen_tint'):
        values[field] = rng.choice([0, 0.5, 1, 5, -1], (count, 3))
    for field in ('ior', 'coat_ior', 'film_ior'):
        values[field] = rng.choice([0, 0.5, 1, 1.5, 1e6], count)
    values['film'] = rng.choice([0, 0, 0.3, 500], count)
    values['thin_wall'], values['inside'] = rng.integers(0, 2, (2, count))
    values['tangent'] = rng.choice([0, 1], (count, 3))
    values['emission'] = 1.0
    wo, n = rng.normal(size=(2, count, 3))
    wo, n = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (wo, n))
    p = closure.Principled(closure.inputs(count, **values), n, wo)
    wi = rng.normal(size=(count, 3))
    f, pdf, samples, _ = p.draw(rng.random((count, 4)), wi / np.linalg.norm(wi, axis=1, keepdims=True))
    emission, albedo = p.sums()
    for got in (f, pdf, samples['weight'], samples['pdf'], emission, albedo):
        assert np.isfinite(got).all()
        assert (got >= 0).all()
