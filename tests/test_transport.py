# SPDX-License-Identifier: GPL-3.0-or-later
"""Which light a path finds, and how often it counts: closed forms and sums that must come out, on both devices.

The scenes are planes above a floor, as NumPy arrays; a camera between them looks straight down. No Blender here.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from cotorra.export import buffers as b

from devices import on_both
from texture_scenes import ASIDE, F32, U32, camera, instances, lights, materials, plane, render, scene

CAMERA, DIFFUSE, GLOSSY, SHADOW = b.VISIBLE_CAMERA, b.VISIBLE_DIFFUSE, b.VISIBLE_GLOSSY, b.VISIBLE_SHADOW
VIEW = camera(0.1, 16)
SUN = lights(((0.0, 0.0, -1.0), np.pi))  # a white Lambertian surface that faces it has radiance 1
UNSEEN = DIFFUSE | GLOSSY  # by the camera, which looks through it; it casts no shadow either


def mean(made: b.SceneBuffers, device: str, seen_by: b.Camera = VIEW, **settings: object) -> np.ndarray:
    """Mean colour of the picture."""
    settings = {'samples': 64, 'integrator': 'PATH', 'max_bounces': 0, 'device': device} | settings
    return render(made, seen_by, **settings)['combined'][..., :3].mean(axis=(0, 1), dtype=np.float64)


def turned(mesh: b.Mesh) -> b.Mesh:
    """The plane, looking down."""
    return replace(mesh, triangles=mesh.triangles[:, ::-1].copy(), corners=mesh.corners[:, ::-1].copy())


def rectangle(x: tuple[float, float], y: tuple[float, float], z: float) -> b.Mesh:
    mesh = plane(z=z)
    mesh.positions[:, 0] = np.array([x[0], x[1], x[1], x[0]], F32)
    mesh.positions[:, 1] = np.array([y[0], y[0], y[1], y[1]], F32)
    return turned(mesh)


# ---- Transparent surfaces

CELLS = 12  # columns of the picture below clear layers: column k is below k of them; rows likewise
GRID = camera(0.6, CELLS)
CLEAR = range(CELLS - 1)


def strip(axis: int, k: int, z: float) -> b.Mesh:
    """A layer over the columns (axis 0) or rows (axis 1) beyond number k of GRID."""
    spans = [(-1.0, 1.0), (-1.0, 1.0)]
    spans[axis] = -0.6 + 0.1 * (k + 1) + (ASIDE if axis == 0 else 0.0), 1.0
    return rectangle(*spans, z)


def crossings(kind: int, emission: float = 0.0, metallic: float = 0.0, **values: object) -> b.SceneBuffers:
    """A floor under clear layers: of those that the camera sees, column k of the picture has k; of those that rays of
    another kind see on their way up, row m has m."""
    layers = [strip(0, k, 3.0 + 0.1 * k) for k in CLEAR] + [strip(1, m, 1.0 + 0.1 * m) for m in CLEAR]
    seen = [63, *[CAMERA] * len(CLEAR), *[kind] * len(CLEAR)]
    count = len(seen)
    made = materials(
        count,
        alpha=[1.0] + [0.0] * (count - 1),
        emission=[[emission] * 3] + [[0.0] * 3] * (count - 1),
        emission_sampling=[0] * count,
        metallic=[metallic] * count,
        roughness=[0.0] * count,
    )
    return scene((plane(), *layers), made, instances=instances(count, visibility=np.array(seen, U32)), **values)


def grid(made: b.SceneBuffers, device: str, limit: int, **settings: object) -> np.ndarray:
    """The picture by m and k."""
    settings = {'integrator': 'PATH', 'max_bounces': 0} | settings
    return render(made, GRID, device=device, transparent_bounces=limit, **settings)['combined'][..., 0]


M, K = np.mgrid[:CELLS, :CELLS]


@on_both('limit', [(0,), (1,), (2,), (8,)], [(0,), (2,)])
def test_transparent_surfaces_count_along_the_whole_path(device: str, limit: int) -> None:
    """Measured with Cycles 5.2.3: a path crosses as many as its limit says, and one in any case; behind the last of
    them it is not lit, but brings home what the surface emits; a shadow ray crosses what its path has left."""
    most = max(limit, 1)
    lit = grid(crossings(SHADOW, lights=SUN), device, limit)
    assert lit == pytest.approx(np.where((K < most) & (K + M <= limit), 0.8, 0.0))
    # A mirror, so that the ray goes straight up.
    mirrored = grid(crossings(GLOSSY, metallic=1.0, world=b.World((1.0, 1.0, 1.0))), device, limit)
    assert mirrored == pytest.approx(np.where((K < most) & (K + M <= most), 0.8, 0.0), rel=1e-4)
    assert grid(crossings(SHADOW, emission=3.0), device, limit) == pytest.approx(np.where(K <= most, 3.0, 0.0))


@on_both('before, above, sky', [(0, 3, 1.0), (1, 2, 1.0), (1, 3, 0.0), (3, 0, 0.0)], [(1, 2, 1.0), (1, 3, 0.0)])
def test_rays_to_the_sky_count_likewise(device: str, before: int, above: int, sky: float) -> None:
    """Ambient occlusion with a limit of 3: layers that the camera sees, and wide ones that shadow rays see."""
    count = 1 + before + above
    floor = materials(count, alpha=[1.0] + [0.0] * (count - 1))
    placed = instances(count, visibility=np.array([63] + [CAMERA] * before + [SHADOW] * above, U32))
    meshes = tuple(plane(-1e3, 1e3, 0.5 * k) for k in range(count))
    settings = {'integrator': 'AO', 'ao_distance': 1e4, 'transparent_bounces': 3, 'samples': 4}
    assert mean(scene(meshes, floor, instances=placed), device, **settings) == pytest.approx(sky)


# ---- Lights that only some rays see


def corner_irradiance(a: float, c: float, h: float) -> float:
    """Of a surface under the corner of a rectangle a x c of radiance 1, in a parallel plane at height h."""
    x, y = a / h, c / h
    first = x / np.sqrt(1 + x * x) * np.arctan(y / np.sqrt(1 + x * x))
    return 0.5 * (first + y / np.sqrt(1 + y * y) * np.arctan(x / np.sqrt(1 + y * y)))


POINT = camera(1e-4, 16)  # looks at one point of the floor, ASIDE of the origin


def under_emitters(
    seen: tuple[int, int], edge: float, strengths: tuple[float, float] = (2.0, 3.0), **floor: object
) -> b.SceneBuffers:
    """A floor under two emitters that meet at x = `edge`, each seen by the rays that `seen` tells; `floor` changes its
    material."""
    left, right = rectangle((ASIDE - 1.5, edge), (-1.0, 1.0), 0.8), rectangle((edge, ASIDE + 1.0), (-1.0, 1.0), 0.8)
    sampled = floor.pop('sampled', (1, 1))
    values = {'base_color': [0.8, 0.0, 0.0], 'emission': [0.0, *strengths]}
    for name, value in floor.items():
        values[name] = [value, *values.get(name, [None] * 3)[1:]]
    made = materials(3, emission_sampling=[0, *sampled], **values)
    placed = instances(3, visibility=np.array([63, *seen], U32))
    return scene((plane(-0.5, 0.5), left, right), made, instances=placed)


SEEN = list(itertools.product((0, DIFFUSE, GLOSSY, UNSEEN), repeat=2))
SAMPLED = [(1, 1), (1, 0), (0, 1), (0, 0)]


@on_both('seen, sampled', list(itertools.product(SEEN, SAMPLED)), [((DIFFUSE, UNSEEN), (1, 1))])
def test_emitters_that_some_rays_see(device: str, seen: tuple[int, int], sampled: tuple[int, int]) -> None:
    """A Lambertian floor is lit by those that diffuse rays see, whatever stands beside them, sampled or not."""
    of_each = 2.0 * 2.0 * corner_irradiance(1.5, 1.0, 0.8), 3.0 * 2.0 * corner_irradiance(1.0, 1.0, 0.8)
    expected = 0.8 / np.pi * sum(e for e, kinds in zip(of_each, seen, strict=True) if kinds & DIFFUSE)
    found = mean(under_emitters(seen, ASIDE, sampled=sampled), device, POINT, samples=256)
    assert found == pytest.approx(expected, rel=4e-3, abs=1e-9)


# Of a glossy and a diffuse lobe together; the last as a model.
MIXED = [
    {'ior': 1.5, 'roughness': 0.4},
    {'ior': 2.5, 'roughness': 0.15, 'base_color': (0.9, 0.2, 0.05)},
    {'metallic': 0.5, 'roughness': 0.6, 'base_color': (0.9, 0.2, 0.05)},
    {'ior': 2.0, 'roughness': 0.0},
]


@on_both('floor, sampled', list(itertools.product(MIXED, (1, 0))), [(MIXED[1], 1)])
def test_lobes_add_up_under_emitters(device: str, floor: dict[str, object], sampled: int) -> None:
    """What diffuse rays alone see and what glossy rays alone see is together what both see."""

    def seen_by(kinds: int) -> np.ndarray:
        made = under_emitters((kinds, 0), 0.3, sampled=(sampled, 1), **floor)
        return mean(made, device, POINT, samples=512)

    both, diffuse, glossy = (seen_by(kinds) for kinds in (UNSEEN, DIFFUSE, GLOSSY))
    assert diffuse + glossy == pytest.approx(both, rel=6e-3)
    assert diffuse.min() > 0.0 and glossy.min() > 0.0


@pytest.mark.parametrize('floor', MIXED)
def test_an_emitter_does_not_mind_what_stands_beside_it(floor: dict[str, object]) -> None:
    """Glossy rays alone see it. Beside it: nothing that emits, or an emitter that no ray sees."""
    alone, beside = (
        mean(under_emitters((GLOSSY, 0), 0.3, (2.0, other), **floor), 'CPU', POINT, samples=512) for other in (0.0, 3.0)
    )
    assert alone == pytest.approx(beside, rel=6e-3)
    assert alone.min() > 0.0


def lamp(**values: object) -> b.Lights:
    """A ball above the origin that shines."""
    frame = np.eye(3, 4, dtype=F32)[None].copy()
    frame[0, :, 3] = 0.1, 0.0, 1.0
    arrays = {name: np.array([value], getattr(SUN, name).dtype) for name, value in values.items()}
    return replace(SUN, type=np.array([b.LIGHT_POINT], U32), transform=frame, size=np.full(1, 0.4, F32), **arrays)


@on_both('floor', [(floor,) for floor in MIXED], [(MIXED[1],)])
def test_lobes_add_up_under_a_lamp(device: str, floor: dict[str, object]) -> None:
    """As above; and sharp highlights, which bounces find, are those that light sampling alone brings."""
    made = {name: np.array([value], F32) for name, value in floor.items()}
    base = np.full((1, 3), 0.8, F32) if 'base_color' not in made else made['base_color'].reshape(1, 3)

    def seen_by(kinds: int, **values: object) -> np.ndarray:
        floor_material = materials(**(made | {'base_color': base}))
        arrays = lamp(visibility=kinds, **values)
        return mean(scene((plane(-0.5, 0.5),), floor_material, lights=arrays), device, POINT, samples=512)

    both, diffuse, glossy = (seen_by(kinds) for kinds in (UNSEEN, DIFFUSE, GLOSSY))
    assert diffuse + glossy == pytest.approx(both, rel=6e-3)
    assert glossy.min() > 0.0
    if floor['roughness'] > 0.0 and device == 'CPU':
        for kinds, expected in ((UNSEEN, both), (DIFFUSE, diffuse), (GLOSSY, glossy)):
            assert seen_by(kinds, use_mis=0) == pytest.approx(expected, rel=6e-3)


@on_both('roughness, bounces', list(itertools.product((0.0, 0.1, 0.2), (0, 1))), [(0.1, 0)])
def test_a_highlight_counts_among_the_bounces_of_the_lamp_alike(device: str, roughness: float, bounces: int) -> None:
    """A bounce may find the lamp at the vertex where light sampling may: max_bounces is of what is lit, and the rest
    of a highlight must not be lost where they share the work."""
    metal = materials(metallic=[1.0], roughness=[roughness])
    found, unlimited = (
        mean(scene((plane(-0.5, 0.5),), metal, lights=lamp(max_bounces=most)), device, POINT, max_bounces=bounces)
        for most in (0, 1024)
    )
    assert unlimited.min() > 0.0
    assert found == pytest.approx(unlimited, rel=1e-6)


@on_both('kind', [(CAMERA,), (DIFFUSE,), (GLOSSY,)], [(DIFFUSE,)])
def test_which_rays_see_the_world(device: str, kind: int) -> None:
    """The camera beside the floor; a Lambertian floor; a metal one, which in a white world is as bright as itself."""
    world = b.World((1.0, 1.0, 1.0), visibility=kind)
    floors = {
        CAMERA: scene((), materials(), instances=instances(0), world=world),
        DIFFUSE: scene((plane(-0.5, 0.5),), materials(), world=world),
        GLOSSY: scene((plane(-0.5, 0.5),), materials(metallic=[1.0], roughness=[0.0]), world=world),
    }
    brightness = {CAMERA: 1.0, DIFFUSE: 0.8, GLOSSY: 0.8}
    for ray, made in floors.items():
        assert mean(made, device) == pytest.approx(brightness[ray] if ray == kind else 0.0, rel=1e-4), ray


@pytest.mark.parametrize('floor', MIXED)
def test_lobes_add_up_under_the_world(floor: dict[str, object]) -> None:
    made = {name: np.array([value], F32) for name, value in floor.items()}
    base = np.full((1, 3), 0.8, F32) if 'base_color' not in made else made['base_color'].reshape(1, 3)

    def seen_by(kinds: int) -> np.ndarray:
        world = b.World((1.0, 1.0, 1.0), visibility=kinds)
        return mean(scene((plane(-0.5, 0.5),), materials(**(made | {'base_color': base})), world=world), 'CPU')

    assert seen_by(DIFFUSE) + seen_by(GLOSSY) == pytest.approx(seen_by(63), rel=1e-2)


# ---- Bounces


@on_both('most, expected', [(0, 0.8), (1, 0.8), (2, 0.8 + 0.8 * 0.5 * 0.8)], [(1, 0.8)])
def test_bounces_of_a_lamp(device: str, most: int, expected: float) -> None:
    """The sun, a floor, and a ceiling that only diffuse rays see: light is where the path has made 0 or 2 bounces."""
    made = materials(2, base_color=[[0.8] * 3, [0.5] * 3])
    planes = plane(-1e3, 1e3), turned(plane(-1e3, 1e3, 1.0))
    placed = instances(2, visibility=np.array([63, DIFFUSE], U32))
    few = replace(SUN, max_bounces=np.array([most], U32))
    found = mean(scene(planes, made, lights=few, instances=placed), device, max_bounces=2, diffuse_bounces=2)
    assert found == pytest.approx(expected, rel=3e-3)
    limited = scene(planes, made, lights=SUN, instances=placed)
    assert mean(limited, device, max_bounces=most, diffuse_bounces=most) == pytest.approx(expected, rel=3e-3)


def box(size: float) -> b.Mesh:
    corners = np.array(list(itertools.product((-size, size), repeat=3)), F32)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for s in sides for t in ((s[0], s[2], s[1]), (s[0], s[3], s[2]))], U32)
    padded = np.zeros((9, 3), F32)
    padded[:8] = corners
    return b.Mesh('box', padded[:8], triangles, np.zeros((0, 3), U32))


@on_both('albedo', [(0.2,), (0.5,), (0.9,)], [(0.5,)])
def test_roulette_gives_back_what_it_takes(device: str, albedo: float) -> None:
    """A closed box whose walls emit 1: a path gathers albedo^k at its k-th surface, and ends at random from the second
    bounce on. Light is found by rays alone, so that nothing but roulette is left to chance."""
    walls = materials(base_color=[[albedo] * 3], emission=[[1.0] * 3], emission_sampling=[0])
    limits = {'max_bounces': 30, 'diffuse_bounces': 30}
    found = mean(scene((box(8.0),), walls), device, samples=256, **limits)
    assert found == pytest.approx((1.0 - albedo**32) / (1.0 - albedo), rel=1e-2)


def test_a_lamp_without_shadow(device: str) -> None:
    """Light comes through what hides its lamp, at the first surface and at the second, where it does not cast one."""
    made = materials(2, base_color=[[0.8] * 3, [0.5] * 3])
    placed = instances(2, visibility=np.array([63, DIFFUSE | SHADOW], U32))
    planes = plane(-1e3, 1e3), turned(plane(-1e3, 1e3, 1.0))
    for shadow, expected in ((0, 0.8 + 0.8 * 0.5 * 0.8), (1, 0.0)):
        sun = replace(SUN, cast_shadow=np.array([shadow], U32))
        found = mean(scene(planes, made, lights=sun, instances=placed), device, max_bounces=2, diffuse_bounces=2)
        assert found == pytest.approx(expected, rel=3e-3)
