# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflection models against their formulas in float64, and against what holds for every one of them.

Their samples are test_models_sampling.py's, and where the formulas fail is test_models_failures.py's.
"""

from __future__ import annotations

import numpy as np
import pytest

import model_bench as bench
import model_reference as reference
from model_bench import Materials

COUNT = 20000


def directions(rng: np.random.Generator, low: float, high: float = 1.0, count: int = COUNT) -> np.ndarray:
    """Directions with cosines from low to high."""
    z = rng.uniform(low, high, count)
    phi = rng.uniform(0, 2 * np.pi, count)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)


def about_mirror(rng: np.random.Generator, wo: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Directions whose half vectors lie around z."""
    h = bench.unit(rng.normal(size=wo.shape) * spread[:, None] + [0, 0, 1])
    return 2 * (wo * h).sum(-1, keepdims=True) * h - wo


def any_materials(rng: np.random.Generator, model: int, low: float = 0.2) -> Materials:
    """Materials of one model over all of its parameters, with roughness from `low` on."""
    return bench.materials(
        COUNT,
        model=model,
        base_color=rng.random((COUNT, 3)),
        metallic=rng.choice([0, 0.3, 1], COUNT),
        roughness=rng.uniform(low, 1, COUNT),
        ior=rng.choice([1.5, 1.1, 2.5, 0.8], COUNT),
        normalized=rng.integers(0, 2, COUNT),
        distribution=rng.integers(0, 3, COUNT),
        masking=rng.integers(0, 4, COUNT),
        fresnel=rng.integers(0, 4, COUNT),
        f0_mode=rng.integers(0, 3, COUNT),
        split=rng.integers(0, 2, COUNT),
        oren_nayar_form=rng.integers(0, 2, COUNT),
        oren_nayar_sigma=rng.uniform(0, 1.8, COUNT),
        toon_steps=rng.integers(2, 7, COUNT),
        shininess=10 ** rng.uniform(-1, 2.3, COUNT),
        specular_color=rng.random((COUNT, 3)),
        f0=rng.random((COUNT, 3)),
        f82_tint=rng.random((COUNT, 3)),
        conductor_n=rng.uniform(0.05, 3, (COUNT, 3)),
        conductor_k=rng.uniform(0, 5, (COUNT, 3)),
        toon_lit=rng.random((COUNT, 3)),
        toon_shade=rng.random((COUNT, 3)),
    )


def error(got: np.ndarray, want: np.ndarray) -> np.ndarray:
    """Relative to the largest channel; what is less than a millionth counts as that."""
    return np.abs(got - want).max(-1) / (np.abs(want).max(-1) + 1e-6)


NAMES = ['lambert', 'oren-nayar', 'phong', 'blinn-phong', 'cook-torrance', 'toon']
MODELS = pytest.mark.parametrize('model', range(1, 7), ids=NAMES)


@MODELS
@pytest.mark.parametrize('where', ['anywhere', 'highlight', 'grazing'])
def test_equals_the_formula(model: int, where: str) -> None:
    rng = np.random.default_rng(model)
    m = any_materials(rng, model)
    wo = directions(rng, *((1e-3, 0.05) if where == 'grazing' else (0.05, 1)))
    wi = directions(rng, *((1e-3, 0.05) if where == 'grazing' else (0.05, 1)))
    if where == 'highlight':
        wi = about_mirror(rng, wo, m.roughness.astype(float) ** 2)
    wo, wi = wo.astype(np.float32), wi.astype(np.float32)
    up = wi[:, 2] > 1e-3
    # Where a step of toon lies within rounding, either side is right.
    if model == bench.TOON:
        steps = wi[:, 2] * m.models.toon_steps
        up &= np.abs(steps - np.round(steps)) > 1e-4
    # Where r.v is about 0, rounding of the directions is all there is of it.
    if model == bench.PHONG:
        up &= np.abs((wi * [-1, -1, 1] * wo).sum(-1)) > 1e-2
    diffuse, specular, _ = bench.evaluate(m, wo, wi)
    expected = reference.evaluate(m, wo.astype(float), np.where(up[:, None], wi, [0, 0, 1]))
    assert error(diffuse, expected[0])[up].max() < 1e-4
    assert error(specular, expected[1])[up].max() < 1e-4
    assert np.median(error(diffuse + specular, sum(expected))[up]) < 1e-6


def test_terms_are_those_of_the_formula() -> None:
    rng = np.random.default_rng(8)
    m = any_materials(rng, bench.COOK_TORRANCE)
    wo = directions(rng, 0.05).astype(np.float32)
    wi = about_mirror(rng, wo.astype(float), m.roughness.astype(float) ** 2).astype(np.float32)
    up = wi[:, 2] > 0.01
    wi[~up] = 0, 0, 1
    got = bench.terms(m, wo, wi)
    want = reference.cook_torrance_terms(m, *(bench.unit(v.astype(float)) for v in (wo, wi)))
    for term, one, other in zip('DGF', got, want, strict=True):
        assert error(one.reshape(COUNT, -1), other.reshape(COUNT, -1))[up].max() < 1e-4, term


def test_principled_terms_make_its_highlight() -> None:
    rng = np.random.default_rng(9)
    m = bench.materials(COUNT, metallic=1, base_color=rng.random((COUNT, 3)), roughness=rng.uniform(0.1, 1, COUNT))
    wo, wi = (directions(rng, 0.01).astype(np.float32) for _ in range(2))
    d, g, f = bench.terms(m, wo, wi)
    _, specular, _ = bench.evaluate(m, wo, wi)
    np.testing.assert_allclose(f * (d * g / (4 * wo[:, 2]))[:, None], specular, rtol=1e-4, atol=1e-7)


@MODELS
def test_nothing_below_the_surface(model: int) -> None:
    m = bench.materials(model=model)
    for wi in ([0, 0, -1], [0.8, 0, -0.6], [1, 0, -1e-7]):
        assert not any(part.any() for part in bench.evaluate(m, bench.viewer(0.5), np.array([wi], np.float32)))


@MODELS
def test_turns_with_the_normal(model: int) -> None:
    """Only angles count: the whole scene turned gives the same."""
    rng = np.random.default_rng(10 + model)
    m = any_materials(rng, model)
    wo, wi = directions(rng, 0.1), directions(rng, 0.1)
    n = bench.unit(np.array([[0.36, -0.48, 0.8]]))
    frame = np.array([[0.8, 0.6, 0.0], [-0.48, 0.64, 0.6], n[0]])
    for one, other in zip(
        bench.evaluate(m, wo, wi), bench.evaluate(m, wo @ frame, wi @ frame, n.astype(np.float32)), strict=True
    ):
        wrong = np.abs(one - other) > 1e-4 * np.abs(one) + 1e-5
        assert wrong.mean() < (1e-3 if model == bench.TOON else 1e-9)  # toon's steps


RECIPROCAL = [
    ('lambert', {'model': bench.LAMBERT}),
    ('oren-nayar', {'model': bench.OREN_NAYAR}),
    ('EON', {'model': bench.OREN_NAYAR, 'oren_nayar_form': 1}),
    ('normalised phong', {'model': bench.PHONG, 'normalized': 1}),
    ('normalised blinn-phong', {'model': bench.BLINN_PHONG, 'normalized': 1}),
    ('cook-torrance', {'model': bench.COOK_TORRANCE, 'split': bench.MIX, 'metallic': 0.5}),
    ('cook-torrance, energy', {'model': bench.COOK_TORRANCE, 'split': bench.ENERGY}),
]


@pytest.mark.parametrize(('name', 'values'), RECIPROCAL, ids=[name for name, _ in RECIPROCAL])
def test_is_reciprocal(name: str, values: dict[str, object]) -> None:
    rng = np.random.default_rng(11)
    m = bench.materials(2000, **values, distribution=rng.integers(0, 3, 2000), masking=rng.integers(0, 4, 2000))
    a, b = (directions(rng, 0.05, count=2000) for _ in range(2))
    there, back = (sum(bench.evaluate(m, o, i)[:2]) / i[:, 2:] for o, i in ((a, b), (b, a)))
    np.testing.assert_allclose(there, back, rtol=1e-4, atol=1e-6)


def test_classic_phong_is_not_reciprocal() -> None:
    """(r.v)^n / nl: the cosine of one of the two directions alone."""
    a, b = bench.viewer(0.9), bench.viewer(0.6)
    for model in (bench.PHONG, bench.BLINN_PHONG):
        m = bench.materials(model=model, kd=0, shininess=4)
        there, back = (float(bench.evaluate(m, o, i)[1][0, 0]) / i[0, 2] for o, i in ((a, b), (b, a)))
        assert there / back == pytest.approx(0.9 / 0.6, rel=1e-4)


def test_shading_normal_behind_the_viewer_shows_the_base() -> None:
    m = bench.materials(3, model=[bench.PHONG, bench.BLINN_PHONG, bench.COOK_TORRANCE])
    diffuse, specular, pdf = bench.evaluate(m, bench.viewer(-0.1), bench.viewer(0.7))
    assert (diffuse > 0).all() and not specular.any() and (pdf > 0).all()


@pytest.mark.parametrize(
    ('name', 'value'),
    [('model', 7), ('masking', 4), ('kd', -1.0), ('shininess', np.nan), ('f0', np.inf), ('conductor_n', -0.1)],
)
def test_wrong_values_are_named(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf'models\.{name}\[0\] = '):
        bench.evaluate(bench.materials(**{name: value}), bench.Z, bench.Z)


def test_wrong_lengths_are_named() -> None:
    m = bench.materials(2)
    object.__setattr__(m.models, 'ks', np.ones(3, np.float32))
    with pytest.raises(ValueError, match=r'models\.ks has 3 entries, expected 2'):
        bench.evaluate(m, bench.Z, bench.Z)
