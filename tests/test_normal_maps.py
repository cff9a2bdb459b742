# SPDX-License-Identifier: GPL-3.0-or-later
"""Normal maps, through the whole native engine: directions against closed forms, and where bent normals fail.

The reference is written from the definition: t = tangent, b = sign * cross(n, t), both in object space, to the world by
the inverse transpose.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cotorra.export import buffers as b

from texture_scenes import (
    F32,
    OBJECT,
    TANGENT,
    U32,
    WORLD,
    NormalMap,
    Slot,
    camera,
    instances,
    lights,
    materials,
    plane,
    render,
    scene,
)

VIEW = camera(0.4, 8)
CLOSEST = b.INTERPOLATION_CLOSEST


def unit(v: object) -> np.ndarray:
    v = np.asarray(v, float)
    return v / np.linalg.norm(v)


def normal_image(direction: object) -> b.Image:
    """An image of one direction, -1 to 1 in each component."""
    return b.Image('normals', (np.asarray(direction, F32) * 0.5 + 0.5).reshape(1, 1, 3))


def tangents(direction: tuple[float, float, float] = (1, 0, 0), sign: float = 1.0) -> np.ndarray:
    return np.tile(np.array([*direction, sign], F32), (4, 1))


def seen_normal(
    direction: object,
    mesh: b.Mesh | None = None,
    strength: float = 1.0,
    space: int = TANGENT,
    **values: object,
) -> np.ndarray:
    """The Normal pass of a plane with a normal map."""
    bent = NormalMap(Slot(interpolation=CLOSEST), strength, space)
    mesh = replace(plane(), tangents=tangents()) if mesh is None else mesh
    view = values.pop('view', VIEW)
    made = scene((mesh,), materials(normal=[bent]), images=(normal_image(direction),), **values)
    normal = render(made, view, passes=('combined', 'normal'))['normal']
    assert np.abs(normal - normal[4, 4]).max() < 1e-5
    return normal[4, 4]


LEAN = unit((0.3, -0.5, 0.7))


def test_tangent_space() -> None:
    """x is the tangent, y the bitangent with its sign, z the normal; a tangent that is null leaves the normal."""
    assert seen_normal(LEAN) == pytest.approx(LEAN, abs=1e-5)
    flipped = replace(plane(), tangents=tangents(sign=-1.0))
    assert seen_normal(LEAN, flipped) == pytest.approx(LEAN * (1, -1, 1), abs=1e-5)
    turned = replace(plane(), tangents=tangents((0, 1, 0)))
    assert seen_normal(LEAN, turned) == pytest.approx((-LEAN[1], LEAN[0], LEAN[2]), abs=1e-5)
    assert seen_normal(LEAN, replace(plane(), tangents=tangents((0, 0, 0)))) == pytest.approx((0, 0, 1))
    assert seen_normal(LEAN, plane()) == pytest.approx((0, 0, 1))


@pytest.mark.parametrize('strength', (0.0, 0.5, 1.0, 3.0))
def test_strength(strength: float) -> None:
    """In tangent space x and y are scaled, and z goes to 1 below strength 1, as in Cycles 5."""
    expected = unit((LEAN[0] * strength, LEAN[1] * strength, 1.0 + (LEAN[2] - 1.0) * min(strength, 1.0)))
    assert seen_normal(LEAN, strength=strength) == pytest.approx(expected, abs=1e-5)
    bent = unit(np.array((0, 0, 1)) * (1.0 - strength) + LEAN * strength)
    assert seen_normal(LEAN, strength=strength, space=WORLD) == pytest.approx(bent, abs=1e-5)


def test_back_faces() -> None:
    """Seen from behind the bent normal turns over with the surface."""
    below = np.array([[1, 0, 0, 0.0013], [0, -1, 0, 0], [0, 0, -1, -5]], F32)
    assert seen_normal(LEAN, view=replace(VIEW, transform=below)) == pytest.approx(-LEAN, abs=1e-5)
    assert seen_normal(LEAN, space=WORLD, view=replace(VIEW, transform=below)) == pytest.approx(-LEAN, abs=1e-5)


FRAMES = {
    'turned': np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]], float),
    'scaled': np.diag((2.0, 1.0, 0.5)),
    'mirrored': np.diag((-1.0, 1.0, 1.0)),
    'sheared': np.array([[1.0, 0.3, 0.2], [0.0, 1.2, 0.0], [0.1, 0.0, 0.9]]),
}


@pytest.mark.parametrize('shared', (False, True), ids=('flattened', 'instanced'))
@pytest.mark.parametrize('smooth', (False, True), ids=('flat', 'smooth'))
@pytest.mark.parametrize('frame', FRAMES)
def test_transforms(frame: str, smooth: bool, shared: bool) -> None:
    """Objects that are turned, scaled, mirrored and sheared; moved to world space, or instanced."""
    m = FRAMES[frame]
    n = unit((0.2, -0.1, 1.0)) if smooth else np.array((0.0, 0.0, 1.0))
    mesh = replace(plane(-3, 3), tangents=tangents(), normals=np.tile(n, (4, 1)).astype(F32), normals_domain='POINT')
    if not smooth:
        mesh = replace(mesh, normals=None, normals_domain='FACE')
    frames = [np.hstack([m, [[0], [0], [0]]]), np.hstack([m, [[90], [0], [0]]])][: 2 if shared else 1]
    count = len(frames)
    placed = instances(count, np.stack(frames), mesh=np.zeros(count, U32), material_base=np.zeros(count, U32))
    t = np.array((1.0, 0.0, 0.0))
    local = LEAN[0] * t + LEAN[1] * np.cross(n, t) + LEAN[2] * n
    expected = unit(np.linalg.inv(m).T @ local)
    front = (np.linalg.inv(m).T @ (0, 0, 1))[2] > 0
    assert seen_normal(LEAN, mesh, instances=placed) == pytest.approx(expected * (1 if front else -1), abs=2e-5)
    expected = unit(np.linalg.inv(m).T @ LEAN)
    found = seen_normal(LEAN, mesh, space=OBJECT, instances=placed)
    assert found == pytest.approx(expected * (1 if front else -1), abs=2e-5)


def lit(
    direction: object,
    lamps: b.Lights,
    metallic: float = 0.0,
    roughness: float = 0.5,
    ior: float = 1.0,
    **values: object,
) -> np.ndarray:
    """The mean of a normal-mapped white plane."""
    bent = NormalMap(Slot(interpolation=CLOSEST))
    made = materials(normal=[bent], base_color=[1.0], metallic=[metallic], roughness=[roughness], ior=[ior])
    mesh = replace(plane(), tangents=tangents())
    world = values.pop('world', b.World())
    pixels = render(scene((mesh,), made, images=(normal_image(direction),), lights=lamps, world=world), VIEW, **values)[
        'combined'
    ]
    return pixels[..., :3].mean(axis=(0, 1))


def sunlit(direction: object, sun: object, **values: float) -> np.ndarray:
    """Under a hard sun that travels along `sun`, of irradiance pi."""
    return lit(direction, lights((sun, np.pi)), **values)


def bump_shadow(n: np.ndarray, wi: np.ndarray) -> float:
    """Conty Estevez, Lecocq and Stein 2019: G1 of GGX with alpha^2 = tan^2 / 8 of the angle between the normals."""
    alpha2 = min(0.125 * (1.0 / n[2] ** 2 - 1.0), 1.0)
    return 2.0 / (1.0 + np.sqrt(1.0 + alpha2 * (1.0 / wi[2] ** 2 - 1.0)))


@pytest.mark.parametrize('sun', [(0.0, 0.0, -1.0), (0.6, 0.0, -0.8), (-0.9, 0.1, -0.3)])
def test_diffuse_light_on_a_bent_normal(sun: tuple[float, float, float]) -> None:
    wi = -unit(sun)
    expected = max(float(LEAN @ wi), 0.0) * bump_shadow(LEAN, wi)
    assert sunlit(LEAN, sun)[0] == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_shading_normal_against_geometric_normal() -> None:
    """Light from below the triangle brings nothing, however the normal leans; from just above it fades in, and no
    direction is NaN."""
    steep = unit((1.0, 0.0, 0.15))
    assert sunlit(steep, (-1.0, 0.0, 0.05)) == pytest.approx(0.0)
    grazing = [sunlit(steep, unit((-1.0, 0.0, -z)))[0] for z in (1e-4, 1e-3, 1e-2, 0.1, 0.5)]
    assert np.isfinite(grazing).all() and grazing[0] < 0.01 and (np.diff(grazing) > 0).all()


@pytest.mark.parametrize('direction', [(0.0, 0.0, -1.0), (0.9, 0.0, -0.4), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize('metallic', (0.0, 1.0))
def test_normal_map_that_points_below_the_surface(direction: tuple[float, float, float], metallic: float) -> None:
    """Its mirror would send rays into the surface. The glossy lobes lift it just so far that they do not; the diffuse
    lobe keeps it and is dark. Nothing is NaN, and no energy appears. Straight down is black, as in Cycles: there the
    mirror of the back points up, and nothing is lifted."""
    for roughness in (0.0, 0.3):
        white = b.World((1.0, 1.0, 1.0))
        values = {'world': white, 'integrator': 'PATH', 'max_bounces': 4, 'samples': 64}
        seen = lit(direction, lights(), metallic, roughness, 1.5, **values)
        assert np.isfinite(seen).all() and (seen >= 0.0).all() and (seen <= 1.0 + 1e-3).all()
        if metallic == 1.0 and roughness == 0.0:
            assert seen == pytest.approx(0.0 if direction == (0.0, 0.0, -1.0) else 1.0, rel=1e-3)
    under_sun = sunlit(direction, (0.0, 0.0, -1.0), metallic=metallic)
    assert np.isfinite(under_sun).all()
    if metallic == 0.0 and direction[2] < 0.0:
        assert under_sun == pytest.approx(0.0)
