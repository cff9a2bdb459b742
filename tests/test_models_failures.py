# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the formulas of reflection models fail, as they are printed or naively written; each shows by how much.

And that ours does not: that they are right elsewhere is test_models.py's.
"""

from __future__ import annotations

import numpy as np
import pytest

import model_bench as bench
import model_reference as reference
from model_bench import unit

ONLY = {'model': bench.COOK_TORRANCE, 'base_color': 0, 'metallic': 1, 'f0_mode': bench.COLOR, 'f0': 1}
DISTRIBUTIONS = pytest.mark.parametrize('distribution', range(3), ids=['GGX', 'Beckmann', 'Blinn-Phong'])
MASKINGS = pytest.mark.parametrize('masking', range(4), ids=['correlated', 'Smith', 'cavities', 'Schlick-GGX'])


def finite(*parts: np.ndarray) -> bool:
    return all(np.isfinite(part).all() and (part >= 0).all() for part in parts)


def mirrored(wo: np.ndarray) -> np.ndarray:
    return wo * np.array([-1, -1, 1], np.float32)


# ---- Roughness


@DISTRIBUTIONS
@MASKINGS
@pytest.mark.parametrize('roughness', [0.0, 1e-4])
def test_no_roughness_is_a_mirror(roughness: float, distribution: int, masking: int) -> None:
    """In 32 bits D is 0 / 0, or infinite at its peak and nothing beside it; here it is a mirror with a weight of F."""
    one = np.float32(1)
    a, nh = np.float32(roughness) ** 2, np.array([1, 1 - 6e-8, 0.9999], np.float32)
    with np.errstate(all='ignore'):
        printed = [
            a**2 / (np.float32(np.pi) * (one + nh**2 * (a**2 - one)) ** 2),
            np.exp((nh**2 - one) / (a**2 * nh**2)) / (np.float32(np.pi) * a**2 * nh**4),
            (2 / a**2) / np.float32(2 * np.pi) * nh ** (2 / a**2 - 2),
        ][distribution]
    assert not np.isfinite(printed[0]) or printed[0] > 1e14
    assert not printed[2] > 0.1  # the whole highlight is in what 32 bits cannot tell from the mirror direction

    m = bench.materials(**{**ONLY, 'roughness': roughness, 'distribution': distribution, 'masking': masking, 'f0': 0.3})
    for mu in (1.0, 0.6, 0.05):
        wo = bench.viewer(mu)
        diffuse, specular, pdf = bench.evaluate(m, wo, mirrored(wo))
        assert not diffuse.any() and not specular.any() and not pdf.any()  # no light sample can meet it
        wi, weight, pdf, lobe = bench.sample(m, wo, bench.lattice(64))
        np.testing.assert_allclose(wi, np.repeat(mirrored(wo), 64, 0), atol=1e-6)
        np.testing.assert_allclose(weight, 0.3 + 0.7 * (1 - mu) ** 5, rtol=1e-5)
        assert (lobe == bench.SPECULAR | bench.SINGULAR | bench.SHARP).all() and (pdf == 1).all()


@DISTRIBUTIONS
@MASKINGS
def test_least_roughness_that_is_no_mirror(distribution: int, masking: int) -> None:
    """Alpha of 1.44e-5: all light about the mirror direction, none of it lost and nothing infinite."""
    m = bench.materials(**{**ONLY, 'roughness': 0.0038, 'distribution': distribution, 'masking': masking})
    wo = bench.viewer(0.5)
    diffuse, specular, pdf = bench.evaluate(m, wo, mirrored(wo))
    assert finite(diffuse, specular, pdf) and specular.min() > 1e6
    wi, weight, pdf, _ = bench.sample(m, wo, bench.lattice(4096))
    assert finite(weight, pdf)
    assert weight.mean() == pytest.approx(1, abs=1e-3)
    assert np.abs(wi - mirrored(wo)).max() < 0.01


# ---- Grazing angles


@DISTRIBUTIONS
@MASKINGS
def test_grazing_light_and_viewer(distribution: int, masking: int) -> None:
    """G / (4 nv nl) as printed is 0 / 0 at the horizon; f cos is a number, down to cosines of 1e-30 and 0."""
    edge = (0.0, 1e-38, 1e-30, 1e-12, 1e-7, 1e-3)
    if masking != bench.CAVITY:
        with np.errstate(all='ignore'):
            zero = np.zeros(1)
            g = reference.G(masking, distribution, zero, zero, zero + 1, zero + 1, a=zero + 0.25)
            assert np.isnan(g / (4 * zero * zero)).all()
    for roughness in (0.004, 0.3, 1.0):
        m = bench.materials(**{**ONLY, 'roughness': roughness, 'distribution': distribution, 'masking': masking})
        for no in edge:
            wo = bench.viewer(no)
            for ni in edge:
                for turn in (1, -1):
                    parts = bench.evaluate(m, wo, bench.viewer(ni) * np.array([turn, 1, 1], np.float32))
                    assert finite(*parts), (roughness, no, ni, turn)
            _, weight, pdf, _ = bench.sample(m, wo, bench.lattice(500))
            assert finite(weight, pdf), (roughness, no)


@pytest.mark.parametrize('model', [bench.PHONG, bench.BLINN_PHONG])
def test_phong_divides_by_the_cosine(model: int) -> None:
    """ks (r.v)^n / nl grows without bound toward the light's horizon, and is infinite there; times nl it never does."""
    m = bench.materials(model=model, kd=0, ks=1, shininess=1)
    wo = bench.viewer(0.1)
    for ni in (1e-2, 1e-4, 1e-8, 1e-20):
        wi = mirrored(bench.viewer(ni))
        f_cos = bench.evaluate(m, wo, wi)[1][0, 0]
        assert f_cos / ni > 0.9 / ni or model == bench.BLINN_PHONG  # what is printed: 1e20 at last
        assert 0 < f_cos <= 1
    assert not bench.evaluate(m, wo, mirrored(bench.viewer(0)))[1].any()


# ---- Shininess


@pytest.mark.parametrize('model', [bench.PHONG, bench.BLINN_PHONG])
def test_shininess_of_a_million(model: int) -> None:
    """Powers of a rounded cosine: one step of 6e-8 at exponent 1e6 is 6 %, and pow() is a staircase."""
    n, count = 1e6, 2001
    wo = bench.viewer(0.6)
    angle = np.arccos(0.6) + np.linspace(0, 2e-3, count)
    wi = np.stack([-np.sin(angle), 0 * angle, np.cos(angle)], -1).astype(np.float32)
    m = bench.materials(model=model, kd=0, ks=1, shininess=n)
    got = bench.evaluate(m, wo, wi)[1][:, 0]
    want = reference.evaluate(m, wo, wi)[1][:, 0]
    seen = want > 1e-3
    if model == bench.PHONG:
        cosine = (mirrored(wi) * wo).sum(-1, dtype=np.float32)
    else:
        h = wo + wi
        cosine = h[:, 2] / np.sqrt((h * h).sum(-1, dtype=np.float32))
    naive = np.minimum(cosine, np.float32(1)) ** np.float32(n)
    worst_naive = (np.abs(naive - want) / want)[seen].max()
    worst = (np.abs(got - want) / want)[seen].max()
    assert worst_naive > 0.03
    assert worst < 2e-3
    _, weight, pdf, _ = bench.sample(m, wo, bench.lattice(1000))
    assert finite(weight, pdf)


@pytest.mark.parametrize('normalized', [0, 1])
@pytest.mark.parametrize('model', [bench.PHONG, bench.BLINN_PHONG])
def test_any_shininess_gives_numbers(model: int, normalized: int) -> None:
    for n in (0.0, 1e-6, 1e6, 1e12, 3e38):
        m = bench.materials(model=model, shininess=n, normalized=normalized, kd=0)
        for mu in (1.0, 0.3, 1e-6, 0.0):
            wo = bench.viewer(mu)
            assert finite(*bench.evaluate(m, wo, mirrored(wo))), (n, mu)
            _, weight, pdf, _ = bench.sample(m, wo, bench.lattice(200))
            assert finite(weight, pdf), (n, mu)


# ---- Fresnel


@pytest.mark.parametrize('fresnel', [bench.SCHLICK, bench.F82])
def test_F0_of_none_and_of_all(fresnel: int) -> None:
    """F0 = 0 shows no highlight head-on, yet one at grazing angles that must be sampled; F0 = 1 leaves no diffuse."""
    none = bench.materials(**{**ONLY, 'f0': 0, 'fresnel': fresnel})
    f = bench.terms(none, bench.viewer(1), bench.viewer(1))[2]
    assert f[0, 0] == 0
    wo = bench.viewer(1)
    slanted = bench.viewer(0.3)
    assert bench.evaluate(none, wo, slanted)[1].min() > 0
    _, weight, pdf, lobe = bench.sample(none, wo, bench.lattice(1000))
    assert finite(weight, pdf) and (lobe & bench.SPECULAR).all()  # black base: the highlight is all there is

    whole = bench.materials(model=bench.COOK_TORRANCE, f0_mode=bench.COLOR, f0=1, base_color=1, fresnel=fresnel)
    diffuse, specular, _ = bench.evaluate(whole, bench.viewer(0.5), bench.viewer(0.7))
    assert not diffuse.any() and (specular > 0).all()


@DISTRIBUTIONS
def test_eta_of_one_is_no_interface(distribution: int) -> None:
    """F = 0 / 0 at the horizon as printed; no reflection at all, and none is sampled."""
    m = bench.materials(model=bench.COOK_TORRANCE, fresnel=bench.DIELECTRIC, ior=1, distribution=distribution)
    for mu in (1.0, 0.5, 1e-3):
        diffuse, specular, pdf = bench.evaluate(m, bench.viewer(mu), mirrored(bench.viewer(mu)))
        assert not specular.any() and finite(diffuse, pdf)
        assert (bench.sample(m, bench.viewer(mu), bench.lattice(100))[3] == bench.DIFFUSE).all()
    schlick = bench.materials(model=bench.COOK_TORRANCE, f0_mode=bench.IOR, ior=1)
    # Schlick's fit knows no interface that is not there: at 81 degrees it reflects 45 %.
    assert bench.terms(schlick, bench.viewer(0.15), mirrored(bench.viewer(0.15)))[2][0, 0] == pytest.approx(
        0.444, abs=1e-3
    )


@pytest.mark.parametrize('fresnel', [bench.DIELECTRIC, bench.CONDUCTOR])
def test_total_internal_reflection_at_the_critical_angle(fresnel: int) -> None:
    """Beyond it the printed root is of a negative number: not a number. Here F is 1, and meets 1 without a jump."""
    eta = 1 / 1.5
    m = bench.materials(**{**ONLY, 'fresnel': fresnel, 'ior': eta, 'conductor_n': eta, 'conductor_k': 0})
    critical = np.sqrt(1 - eta**2)
    for c, least, most in [
        (critical - 0.3, 1, 1),
        (critical - 1e-4, 1, 1),
        (critical, 0.98, 1),
        (critical + 1e-6, 0.98, 1),
        (critical + 1e-4, 0.89, 0.91),
        (1.0, 0.04, 0.04),
    ]:
        wo = bench.viewer(c)
        f = float(bench.terms(m, wo, mirrored(wo))[2][0, 0])
        assert least - 1e-6 <= f <= most + 1e-6, c - critical
    with np.errstate(invalid='ignore'):
        assert np.isnan(np.sqrt(np.array(eta**2 - 1 + (critical - 1e-4) ** 2)))


def test_metals_cancel_in_the_conductor_root() -> None:
    """a^2 = (sqrt(t^2 + 4 n^2 k^2) + t) / 2 with t < 0 loses silver's n = 0.05 beside k = 4 in 32 bits."""
    n, k, c = np.float32(0.05), np.float32(4.2), np.float32(0.3)
    t = n * n - k * k - (1 - c * c)
    a2b2 = np.sqrt(t * t + 4 * n * n * k * k)
    with np.errstate(invalid='ignore'):
        a = np.sqrt(0.5 * (a2b2 + t))
    exact = np.sqrt((complex(n) + 1j * complex(k)) ** 2 - (1 - float(c) ** 2)).real
    assert abs(a / exact - 1) > 1e-5
    m = bench.materials(**{**ONLY, 'fresnel': bench.CONDUCTOR, 'conductor_n': n, 'conductor_k': k})
    wo = bench.viewer(float(c))
    want = reference.fresnel(np.array([n + 1j * k], complex), np.array([float(wo[0, 2])]))[0]
    assert 1 - bench.terms(m, wo, mirrored(wo))[2][0, 0] == pytest.approx(1 - want, rel=1e-4)


# ---- Misprints of the sources (each as a figure: printed over right)


def test_misprint_F0_of_one_half() -> None:
    """Schlick with F0 = 0.5 for everything: plastic, 0.04, reflects 12.5 times as much head-on."""
    m = bench.materials(model=bench.COOK_TORRANCE)
    f = bench.terms(m, bench.viewer(1), bench.viewer(1))[2][0, 0]
    assert f == pytest.approx(0.04, rel=1e-5)
    assert 0.5 / f == pytest.approx(12.5, rel=1e-4)


def test_misprint_angle_between_light_and_viewer() -> None:
    """Schlick with l.v in place of v.h: with light and viewer 60 degrees off the normal, F is 1 and not 0.07."""
    m = bench.materials(model=bench.COOK_TORRANCE)
    wo = bench.viewer(0.5)
    wi = mirrored(wo)
    right = bench.terms(m, wo, wi)[2][0, 0]
    assert right == pytest.approx(0.04 + 0.96 * 0.5**5, rel=1e-5)
    printed = 0.04 + 0.96 * (1 - max((wo * wi).sum(), 0)) ** 5  # l.v is -0.5
    assert printed / right == pytest.approx(14.3, rel=0.01)


def test_misprint_half_vector_without_its_length() -> None:
    """n.(l + v) is up to 2: GGX at roughness 0.5, head-on, is then 0.0005 of its peak."""
    m = bench.materials(**{**ONLY, 'roughness': 0.5})
    peak = bench.terms(m, bench.viewer(1), bench.viewer(1))[0][0]
    assert peak == pytest.approx(1 / (np.pi * 0.25**2), rel=1e-4)
    printed = reference.D(bench.GGX, np.array([2.0]), np.array([0.25]))[0]
    assert printed / peak == pytest.approx(5.17e-4, rel=0.01)


def test_misprint_cosine_twice_in_lambert() -> None:
    """base / pi nl with the cosine of the light once more: a white plane keeps two thirds of the light."""
    m = bench.materials(model=bench.LAMBERT, base_color=1)
    assert bench.albedo(m, 0.7) == pytest.approx(1, abs=1e-4)
    wi, weight, _, _ = bench.sample(m, bench.viewer(0.7), bench.lattice(1 << 15))
    assert (weight[:, 0] * wi[:, 2]).mean() == pytest.approx(2 / 3, abs=1e-3)


def test_misprint_slope_without_the_square() -> None:
    """t with 1 - ns for 1 - ns^2: Beckmann's G1 at 75 degrees and roughness 1 is 0.657 and not 0.615."""
    ns, a = np.cos(np.radians([75.0])), np.ones(1)
    right = 1 / (1 + reference.Lambda(bench.BECKMANN, ns, a))
    t = ns / (a * np.sqrt(1 - ns))
    printed = 1 / (1 + (1 - 1.259 * t + 0.396 * t**2) / (3.535 * t + 2.181 * t**2))
    assert (right, printed) == (pytest.approx(0.615, abs=1e-3), pytest.approx(0.657, abs=1e-3))
    m = bench.materials(**{**ONLY, 'roughness': 1, 'distribution': bench.BECKMANN, 'masking': bench.SMITH})
    g = bench.terms(m, bench.viewer(float(ns[0])), bench.viewer(1))[1]
    np.testing.assert_allclose(g, right, rtol=1e-4)  # toward the normal G1 is 1


def test_unlimited_kd_and_ks() -> None:
    """kd and ks are the user's: a white Phong surface with both at 1 returns nearly twice what arrives."""
    m = bench.materials(model=bench.PHONG, normalized=1, base_color=1, ks=1, shininess=1000)
    assert bench.albedo(m, 0.9) == pytest.approx(1.9, abs=0.02)


def test_hostile_input_gives_numbers() -> None:
    """All corners of the parameters at once: no NaN, no infinity, no negative value."""
    rng = np.random.default_rng(12)
    count = 20000
    color = rng.choice([0.0, 1.0, 100.0], (count, 3))
    m = bench.materials(
        count,
        model=rng.integers(1, 7, count),
        base_color=color,
        specular_color=color,
        f0=color,
        toon_lit=color,
        conductor_n=rng.choice([0.0, 1e-6, 1.0, 1e9], (count, 3)),
        conductor_k=rng.choice([0.0, 1e-6, 1.0, 1e9], (count, 3)),
        f82_tint=rng.choice([0.0, 1.0, 50.0], (count, 3)),
        roughness=rng.choice([0.0, 1e-4, 0.0038, 0.004, 1.0, 7.0], count),
        metallic=rng.choice([0.0, 0.5, 1.0, 2.0], count),
        ior=rng.choice([0.0, 0.1, 1.0, 1.0001, 1.5, 1e9], count),
        shininess=rng.choice([0.0, 1.0, 1e6, 3e38], count),
        oren_nayar_sigma=rng.choice([0.0, 1e-6, 1.0, 100.0], count),
        toon_steps=rng.choice([0, 1, 2, 4000000000], count),
        **{name: rng.integers(0, 2, count) for name in ('normalized', 'oren_nayar_form', 'split')},
        **{name: rng.integers(0, 3, count) for name in ('distribution', 'f0_mode')},
        **{name: rng.integers(0, 4, count) for name in ('masking', 'fresnel')},
    )
    edge = np.array([0.0, 0.5, 1 - 2**-24], np.float32)
    for mu in (1.0, 0.5, 1e-7, 0.0, -0.5):
        wo = bench.viewer(mu)
        for wi in (mirrored(wo), wo, -wo, bench.viewer(0.3), unit(np.array([[0.6, 0.7, 1e-6]]))):
            assert finite(*bench.evaluate(m, wo, wi)), mu
            assert finite(*bench.terms(m, wo, wi)), mu
        for u in np.stack(np.meshgrid(edge, edge, edge), -1).reshape(-1, 1, 3):
            wi, weight, pdf, _ = bench.sample(m, wo, u)
            assert finite(weight, pdf) and np.isfinite(wi).all(), (mu, u)
