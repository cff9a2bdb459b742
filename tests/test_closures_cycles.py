# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobes of kernels/closure against Cycles: each BSDF node under a sun above and below, and Principled's energy.

Each is one render with a facet a pixel (cycles_bsdf.py).
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

import closure_kernels as closure
import cycles_bsdf as cycles

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 2), reason='the formulas are those of Blender 5.2')

SIDE = 40
COUNT = SIDE * SIDE
VIEWER = np.array([0.0, 0.0, 1.0])
ABOVE = np.array([0.5, 0.2, 0.8]) / np.linalg.norm([0.5, 0.2, 0.8])
BELOW = np.array([0.3, -0.2, -0.9]) / np.linalg.norm([0.3, -0.2, -0.9])

ROUGH = {'color': 'Color', 'roughness': 'Roughness'}
FILM = {'film': 'Thin Film Thickness', 'film_ior': 'Thin Film IOR'}
BRUSHED = {'anisotropy': 'Anisotropy', 'rotation': 'Rotation', 'tangent': 'Tangent'}
METAL = {'color': 'Base Color', 'edge': 'Edge Tint', 'roughness': 'Roughness'}
INDEX = {'color': 'IOR', 'edge': 'Extinction', 'roughness': 'Roughness'}
DISTRIBUTIONS = {
    closure.GGX: 'GGX',
    closure.MULTI_GGX: 'MULTI_GGX',
    closure.BECKMANN: 'BECKMANN',
    closure.ASHIKHMIN_SHIRLEY: 'ASHIKHMIN_SHIRLEY',
}


def facets(rng: np.random.Generator, count: int) -> np.ndarray:
    mu, phi = rng.uniform(0.05, 1, count), rng.uniform(0, 2 * np.pi, count)
    r = np.sqrt(1 - mu**2)
    return np.stack([r * np.cos(phi), r * np.sin(phi), mu], -1)


def drawn(rng: np.random.Generator, sockets: dict[str, str]) -> dict[str, object]:
    """A value for each pixel of what a node reads. Highlights below 0.2 are Cycles' rounding (test_bsdf_cycles.py)."""
    ranges = {'roughness': (0.2, 1), 'anisotropy': (-0.9, 0.9), 'rotation': (0, 1), 'ior': (0.6, 2.5)}
    ranges |= {'film': (0, 1000), 'film_ior': (1, 2.5), 'size': (0, 1), 'smooth_rim': (0, 1)}
    values: dict[str, object] = {name: rng.uniform(*ranges[name], COUNT) for name in sockets if name in ranges}
    values |= {name: rng.random((COUNT, 3)) for name in ('color', 'edge') if name in sockets}
    return values


def error(got: np.ndarray, want: np.ndarray) -> np.ndarray:
    """Relative to the brightest channel, and to 0.01 where all are dark."""
    return np.abs(got - want).max(-1) / np.maximum(want.max(-1), 0.01)


def reflecting() -> list:
    cases = [
        ('DIFFUSE', 'Diffuse', ROUGH, {}, 0, 1e-4),
        ('VELVET', 'Sheen', ROUGH, {'distribution': 'ASHIKHMIN'}, 0, 1e-4),
        ('TOON_DIFFUSE', 'Toon', {'color': 'Color', 'size': 'Size', 'smooth_rim': 'Smooth'}, {}, 0, 1e-4),
        (
            'TOON_GLOSSY',
            'Toon',
            {'color': 'Color', 'size': 'Size', 'smooth_rim': 'Smooth'},
            {'component': 'GLOSSY'},
            0,
            1e-4,
        ),
    ]
    for number, name in DISTRIBUTIONS.items():
        kind = 'ASHIKHMIN_SHIRLEY' if number == closure.ASHIKHMIN_SHIRLEY else 'REFLECTION'
        cases.append((kind, 'Anisotropic', ROUGH | BRUSHED, {'distribution': name}, number, 1e-3))
    for number in (closure.GGX, closure.MULTI_GGX, closure.BECKMANN):
        settings = {'distribution': DISTRIBUTIONS[number]}
        cases.append(('METALLIC', 'Metallic', METAL | BRUSHED, settings | {'fresnel_type': 'F82'}, number, 1e-3))
        settings |= {'fresnel_type': 'PHYSICAL_CONDUCTOR'}
        cases.append(('CONDUCTOR', 'Metallic', INDEX, settings, number, 1e-3))
        # The observer's curves stand every 10 nm, and Cycles' every 1 nm: 0.3 % at most.
        cases.append(('CONDUCTOR', 'Metallic', INDEX | FILM, settings, number, 5e-3))
    settings = {'distribution': 'MULTI_GGX', 'fresnel_type': 'F82'}
    cases.append(('METALLIC', 'Metallic', METAL | FILM, settings, closure.MULTI_GGX, 5e-3))
    return cases


@pytest.mark.parametrize(
    ('kind', 'node', 'sockets', 'settings', 'distribution', 'bound'),
    reflecting(),
    ids=lambda value: value if isinstance(value, str) else None,
)
def test_reflection(
    tmp_path: Path,
    kind: str,
    node: str,
    sockets: dict[str, str],
    settings: dict[str, object],
    distribution: int,
    bound: float,
) -> None:
    rng = np.random.default_rng(5)
    values = drawn(rng, sockets)
    if node == 'Metallic' and 'anisotropy' in values:
        values['anisotropy'] = np.abs(values['anisotropy'])
    if kind == 'CONDUCTOR':
        values['color'], values['edge'] = values['color'] * 3, values['edge'] * 4
    case, n = closure.cases(kind, COUNT, distribution=distribution, **values), facets(rng, COUNT)
    shader = cycles.Shader(f'ShaderNodeBsdf{node}', sockets, settings)
    image = cycles.render(case, n, tmp_path / 'sun.exr', sun=ABOVE, shader=shader)['Combined']
    f, _ = closure.Lobes(case, n, VIEWER).evaluate(ABOVE, COUNT)
    assert (image.max(-1) > 1e-3).mean() > 0.15
    assert error(f, image).max() < bound
    assert np.median(error(f, image)) < bound / 10


@pytest.mark.parametrize('back', [False, True], ids=['outside', 'inside'])
@pytest.mark.parametrize('sun', [ABOVE, BELOW], ids=['above', 'below'])
@pytest.mark.parametrize('name', ['GGX', 'MULTI_GGX', 'BECKMANN', 'film', 'refraction'])
def test_glass(tmp_path: Path, name: str, sun: np.ndarray, back: bool) -> None:
    rng = np.random.default_rng(6)
    sockets = ROUGH | {'ior': 'IOR'} | (FILM if name == 'film' else {})
    values = drawn(rng, sockets)
    if name == 'film':
        values['ior'] = rng.uniform(1.05, 2.5, COUNT)
    distribution = {'GGX': closure.GGX, 'BECKMANN': closure.BECKMANN, 'refraction': closure.GGX}.get(name, 1)
    kind = 'REFRACTION' if name == 'refraction' else 'GLASS'
    case, n = closure.cases(kind, COUNT, distribution=distribution, inside=back, **values), facets(rng, COUNT)
    shader = cycles.Shader(f'ShaderNodeBsdf{kind.capitalize()}', sockets, {'distribution': DISTRIBUTIONS[distribution]})
    image = cycles.render(case, n, tmp_path / 'sun.exr', sun=sun, shader=shader, back=back)['Combined']
    f, _ = closure.Lobes(case, n, VIEWER).evaluate(sun, COUNT)
    # Pairs of directions that no facet refracts to each other are lit, too, as in Cycles.
    lit = (image.max(-1) > 1e-3).mean()
    assert lit > 0.05 or (name == 'refraction' and sun is ABOVE)
    bound = 0.01 if distribution == closure.MULTI_GGX else 2e-3
    assert error(f, image).max() < bound
    assert np.median(error(f, image)) < bound / 4


def test_translucent(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    case, n = closure.cases('TRANSLUCENT', COUNT, color=rng.random((COUNT, 3)), roughness=0), facets(rng, COUNT)
    shader = cycles.Shader('ShaderNodeBsdfTranslucent', {'color': 'Color'})
    image = cycles.render(case, n, tmp_path / 'sun.exr', sun=BELOW, shader=shader)['Combined']
    f, _ = closure.Lobes(case, n, VIEWER).evaluate(BELOW, COUNT)
    assert error(f, image).max() < 1e-4


def test_sheen(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    case, n = closure.cases('SHEEN', COUNT, color=1.0, roughness=rng.uniform(0, 1, COUNT)), facets(rng, COUNT)
    shader = cycles.Shader('ShaderNodeBsdfSheen', ROUGH, {'distribution': 'MICROFIBER'})
    image = cycles.render(case, n, tmp_path / 'sun.exr', sun=ABOVE, shader=shader)['Combined']
    f, _ = closure.Lobes(case, n, VIEWER).evaluate(ABOVE, COUNT)
    assert abs(f.mean() / image.mean() - 1) < 1e-3
    assert error(f, image).max() < 2e-3


# ---- Principled

SOCKETS = {
    'base_color': 'Base Color',
    'metallic': 'Metallic',
    'specular_tint': 'Specular Tint',
    'roughness': 'Roughness',
    'ior': 'IOR',
    'specular_level': 'Specular IOR Level',
    'tangent': 'Tangent',
    'coat': 'Coat Weight',
    'coat_tint': 'Coat Tint',
    'coat_roughness': 'Coat Roughness',
    'coat_ior': 'Coat IOR',
    'sheen': 'Sheen Weight',
    'sheen_tint': 'Sheen Tint',
    'sheen_roughness': 'Sheen Roughness',
    'diffuse_roughness': 'Diffuse Roughness',
    'anisotropic': 'Anisotropic',
    'rotation': 'Anisotropic Rotation',
    'transmission': 'Transmission Weight',
    'film': 'Thin Film Thickness',
    'film_ior': 'Thin Film IOR',
    'subsurface': 'Subsurface Weight',
    'subsurface_anisotropy': 'Subsurface Anisotropy',
    'emission': 'Emission Color',
    'thin_wall': 'Thin Wall',
}
RANGES = {
    'roughness': (0.2, 1),
    'ior': (1.05, 2.5),
    'coat_roughness': (0.2, 1),
    'coat_ior': (1, 3),
    'sheen_roughness': (0.2, 1),
    'film': (0, 1000),
    'film_ior': (1, 2.5),
    'subsurface_anisotropy': (-1, 1),
}
COLORS = ('base_color', 'specular_tint', 'coat_tint', 'sheen_tint', 'emission')


def principled(rng: np.random.Generator, names: list[str], **values: object) -> tuple[np.ndarray, cycles.Shader]:
    """Inputs of which the named ones differ from pixel to pixel, and the node that reads them."""
    for name in names:
        drawn = rng.random((COUNT, 3)) if name in COLORS else rng.uniform(*RANGES.get(name, (0, 1)), COUNT)
        values[name] = np.array([1.0, 0, 0]) if name == 'tangent' else drawn
    inputs = closure.inputs(COUNT, **values)
    distribution = 'MULTI_GGX' if values.get('multiscatter', 1) else 'GGX'
    read = {name: SOCKETS[name] for name in values if name in SOCKETS}
    return inputs, cycles.Shader('ShaderNodeBsdfPrincipled', read, {'distribution': distribution})


LAYERS = {
    'metal': (['metallic', 'specular_tint'], {}, 0.01),
    'brushed metal': (['metallic', 'specular_tint', 'anisotropic', 'rotation', 'tangent'], {}, 0.02),
    'rough diffuse': (['diffuse_roughness'], {}, 0.01),
    'coat': (['coat', 'coat_roughness', 'coat_ior', 'coat_tint'], {}, 0.01),
    'film': (['film', 'film_ior', 'specular_level', 'metallic'], {}, 0.02),
    'thin wall': (['specular_tint', 'ior'], {'thin_wall': 1, 'transmission': 1}, 0.05),
    'thin wall under a film': (['film', 'film_ior', 'ior'], {'thin_wall': 1, 'transmission': 1}, 0.03),
    'thin scattering': (
        ['subsurface', 'subsurface_anisotropy', 'diffuse_roughness'],
        {'thin_wall': 1},
        0.05,
    ),
    'coat over metal': (['coat', 'coat_roughness', 'metallic'], {'multiscatter': 0}, 0.01),
}


@pytest.mark.parametrize('name', LAYERS)
@pytest.mark.parametrize('sun', [ABOVE, BELOW], ids=['above', 'below'])
def test_principled(tmp_path: Path, name: str, sun: np.ndarray) -> None:
    names, fixed, bound = LAYERS[name]
    if sun is BELOW and not name.startswith('thin'):
        pytest.skip('no light comes through')
    rng = np.random.default_rng(9)
    inputs, shader = principled(rng, ['base_color', 'roughness', *names], **fixed)
    n = facets(rng, COUNT)
    image = cycles.render(inputs, n, tmp_path / 'sun.exr', sun=sun, shader=shader)['Combined']
    p, picks = closure.Principled(inputs, n, VIEWER), 512
    total = np.zeros((COUNT, 3))
    for k in range(picks):
        f, _, _, _ = p.draw(np.full((COUNT, 4), (k + 0.5) / picks), sun)
        total += f
    # The layers are drawn by steps of 1/512 of the number that chooses, which is most of the error.
    assert np.quantile(error(total / picks, image), 0.99) < bound
    assert abs(total.mean() / picks / image.mean() - 1) < 1e-3


def test_emission_through_coat_and_sheen(tmp_path: Path) -> None:
    rng = np.random.default_rng(10)
    names = ['emission', 'coat', 'coat_tint', 'coat_ior', 'coat_roughness', 'sheen', 'sheen_tint', 'sheen_roughness']
    inputs, shader = principled(rng, names)
    inputs['sheen'] *= 0.5
    n = facets(rng, COUNT)
    strong = cycles.Shader(shader.node, shader.sockets, shader.settings, {'Emission Strength': 1.0})
    image = cycles.render(inputs, n, tmp_path / 'dark.exr', sun=-VIEWER, shader=strong)['Combined']
    emission, _ = closure.Principled(inputs, n, VIEWER).sums()
    assert error(emission, image).max() < 0.05
    assert np.median(error(emission, image)) < 2e-3


@pytest.mark.parametrize(
    ('name', 'fixed'),
    {
        'coat': {'coat': 1.0, 'coat_roughness': 0.3},
        'sheen': {'sheen': 1.0},
        'glass': {'transmission': 1.0, 'base_color': 0.9},
        'half glass': {'transmission': 0.5, 'metallic': 0.3, 'coat': 0.5},
        'thin wall': {'transmission': 1.0, 'thin_wall': 1, 'base_color': 0.7},
    }.items(),
)
def test_furnace(tmp_path: Path, name: str, fixed: dict[str, object]) -> None:
    """What each roughness sends back of a white world, from the side and from above, within 1 % of Cycles."""
    rng = np.random.default_rng(12)
    angles, rows, each = 5, 5, 64
    inputs, shader = principled(rng, [], **{'base_color': 0.8, 'roughness': 0.5, **fixed})
    roughness, mu = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, rows), np.linspace(0.15, 1, angles)))
    inputs['roughness'] = roughness.repeat(each)
    n = np.stack([np.sqrt(1 - mu**2), 0 * mu, mu], -1)
    image = cycles.render(inputs, n.repeat(each, 0), tmp_path / 'world.exr', samples=64, shader=shader)['Combined']
    image = image.reshape(-1, each, 3).mean(1)
    u = np.random.default_rng(1).random((1 << 16, 4))
    for i, want in enumerate(image):
        _, _, samples, _ = closure.Principled(inputs[i * each : i * each + 1], n[i], VIEWER).draw(u, VIEWER)
        got = np.where(samples['pdf'][:, None] > 0, samples['weight'], 0).astype(float).mean(0)
        np.testing.assert_allclose(got, want, rtol=0.01, atol=0.004, err_msg=f'{name} {roughness[i]} {mu[i]}')
