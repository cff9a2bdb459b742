# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of rays and lights, through whole renders of a few pixels: scale, distance, thin triangles, strength.

Each scene has a closed form. They are tests/classic_scenes.py's, which need no Blender.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from charting.stability import Axis, Map, relative, steps

sys.path.append(str(Path(__file__).resolve().parents[2] / 'tests'))
import classic_scenes as classic

F64 = NDArray[np.float64]
SCALE, DISTANCE = (1e-4, 1e5), (0.0, 1e5)
RATIO = 1e4  # the size of what is promised at a distance: 2^-24 of it, its rounding, is below 1e-3 of the size
SIZE = (16, 12)


def maps(count: int) -> list[Map]:
    return [closed_mesh(count), sunlit_floor(count), thin_triangle(count), point_light(count), sun_strength(count)]


def scales(count: int) -> Axis:
    return Axis('scale', steps(1e-6, 1e6, count, *SCALE), SCALE)


def distances(count: int) -> Axis:
    """From the origin; 0 is drawn at the lowest."""
    return Axis('distance from the origin', steps(1e-3, 1e6, count, 1e5), (1e-3, 1e5))


def near_enough(x: Axis, y: Axis) -> NDArray[np.bool_]:
    return y.values[:, None] <= RATIO * x.values[None, :]


def where(distance: float) -> F64:
    return distance * np.array([0.6, -0.48, 0.64])


def icosphere(level: int, roughness: float = 0.0) -> tuple[F64, NDArray[np.int64]]:
    """A closed ball of 20 * 4^level triangles, whose vertices stand out by up to `roughness`."""
    golden = (1.0 + 5.0**0.5) / 2.0
    ring = [(-1, golden), (1, golden), (-1, -golden), (1, -golden)]
    v = np.array([(a, b, 0) for a, b in ring] + [(0, a, b) for a, b in ring] + [(b, 0, a) for a, b in ring], float)
    gaps = np.linalg.norm(v[:, None] - v, axis=-1)
    near = np.isclose(gaps, 2.0)
    f = np.array(
        [(i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] & near[j, k] & near[i, k]]
    )
    for _ in range(level):
        edges = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
        unique, index = np.unique(edges, axis=0, return_inverse=True)
        x, y, z = len(v) + index.reshape(3, -1)
        v = np.concatenate([v, v[unique].mean(axis=1)])
        a, b, c = f.T
        f = np.concatenate([np.stack(corners, 1) for corners in ((a, x, z), (b, y, x), (c, z, y), (x, y, z))])
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    return v * (1.0 + roughness * np.random.default_rng(1).uniform(-1.0, 1.0, (len(v), 1))), f


def inside(at: F64, size: tuple[int, int] = SIZE) -> classic.buffers.Camera:
    """A wide pinhole at a point."""
    frame = np.eye(3, 4)
    frame[:, 3] = at
    window, region = (-2.0, 2.0, -1.5, 1.5), (0, 0, *size)
    return classic.buffers.Camera('PERSP', frame.astype(np.float32), window, (0.0, 1e30), size, region, 1.5)


def leaked(
    v: F64, f: NDArray[np.int64], at: F64, samples: int, size: tuple[int, int] = SIZE, seed: int = 0
) -> tuple[float, int]:
    """Rays that left a closed white mesh, found by the light of the world outside, and how many there were."""
    made = classic.scene([classic.Shape(v + at, f, classic.Material())], world=(1.0, 1.0, 1.0))
    view = inside(at, size)
    most = dict.fromkeys(('max_bounces', 'diffuse_bounces', 'glossy_bounces'), 8)
    run = classic.session(made, view, 'PATH', samples=samples, seed=seed, **most)
    found = float(classic.read(run, view)[..., 0].sum()) * samples
    return found, int(sum(run.stats()['rays'].values()))


def closed_mesh(count: int) -> Map:
    """Of rays inside a closed ball, the part that leave it, over nine vertices of a path."""
    x, y = scales(count), distances(count)
    v, f = icosphere(3, 0.05)
    error = np.zeros((len(y.values), len(x.values)))
    for j, distance in enumerate(y.values):
        for i, scale in enumerate(x.values):
            light, rays = leaked(v * scale, f, where(distance), 2)
            error[j, i] = light / rays
    told = (
        'where the distance is more than 1e4 times the size, rounding of the coordinates moves corners by 1e-3 of the '
        'size: at some ratio the camera itself is outside'
    )
    return Map(
        'Closed mesh: rays that leak', x, y, error, told, near_enough(x, y), f'distance up to {RATIO:g} times the scale'
    )


def sunlit_floor(count: int) -> Map:
    """A tilted floor under a sun: E cos / pi, less what shades itself."""
    x, y = scales(count), distances(count)
    error = np.zeros((len(y.values), len(x.values)))
    normal = np.array([0.36, 0.48, 0.8])
    side = np.cross(normal, (0.0, 1.0, 0.0))
    side /= np.linalg.norm(side)
    up = np.cross(normal, side)
    sun = np.array([0.1, 0.3, 0.9])
    sun /= np.linalg.norm(sun)
    for j, distance in enumerate(y.values):
        for i, scale in enumerate(x.values):
            at = where(distance)
            floor = classic.quad(at - scale * (side + up), 2.0 * scale * side, 2.0 * scale * up)
            lamp = classic.Lamp('SUN', (1.0,) * 3, towards=tuple(-sun))
            view = classic.camera(SIZE, at + 2.0 * scale * normal, -normal, window=scale)
            view = classic.replace(view, clip=(0.0, 1e30))
            found = classic.render(classic.scene([floor], [lamp]), view, 'DIRECT', samples=1)[..., 0].mean()
            error[j, i] = relative(found, sun @ normal / np.pi)
    told = 'beyond, the corners themselves are rounded by more than a thousandth of the size, and the floor is another'
    return Map('Sunlit floor', x, y, error, told, near_enough(x, y), f'distance up to {RATIO:g} times the scale')


def thin_triangle(count: int) -> Map:
    """Triangles as high as 1 / aspect of their length, whose picture they fill."""
    x = Axis('aspect of a triangle', steps(1.0, 1e10, count, 1e8), (1.0, 1e8))
    y = Axis('length', steps(1e-4, 1e5, count), SCALE)
    error = np.zeros((len(y.values), len(x.values)))
    sun = np.array([0.0, 0.3, 0.9])
    sun /= np.linalg.norm(sun)
    for j, length in enumerate(y.values):
        for i, aspect in enumerate(x.values):
            height = length / aspect
            corners = np.array([(-2.0 * length, -height, 0.0), (2.0 * length, -height, 0.0), (0.0, height, 0.0)])
            shape = classic.Shape(corners, np.array([[0, 1, 2]]))
            lamp = classic.Lamp('SUN', (1.0,) * 3, towards=tuple(-sun))
            view = classic.camera(SIZE, (0.0, -0.5 * height, length), (0.0, 0.0, -1.0), window=0.25 * height)
            view = classic.replace(view, clip=(0.0, 1e30))
            found = classic.render(classic.scene([shape], [lamp]), view, 'DIRECT', samples=1)[..., 0].mean()
            error[j, i] = relative(found, sun[2] / np.pi)
    return Map('Thin triangle', x, y, error, 'the square of the area falls below the smallest float: no normal')


def light_map(name: str, kind: str, x: Axis, y: Axis, told: str) -> Map:
    error = np.zeros((len(y.values), len(x.values)))

    def shown(strength: float, height: float) -> float:
        floor = classic.quad((-height, -height, 0.0), (2.0 * height, 0.0, 0.0), (0.0, 2.0 * height, 0.0))
        lamp = classic.Lamp(kind, (strength,) * 3, position=(0.0, 0.0, height))
        view = classic.camera(
            (1, 1), (0.0, 0.0, 0.5 * height), (0.0, 0.0, -1.0), window=1e-4 * height, filter_width=0.0
        )
        view = classic.replace(view, clip=(0.0, 1e30))
        return float(classic.render(classic.scene([floor], [lamp]), view, 'DIRECT', samples=1)[0, 0, 0])

    one = shown(1.0, 1.0)
    for j, height in enumerate(y.values):
        for i, strength in enumerate(x.values):
            by = float(np.float32(strength)) / (height**2 if kind == 'POINT' else 1.0)
            error[j, i] = relative(shown(strength, height), one * by)
    return Map(name, x, y, error, told)


def point_light(count: int) -> Map:
    x = Axis('strength', steps(1e-20, 1e20, count), (1e-20, 1e12))
    y = Axis('distance of the light', steps(1e-6, 1e6, count, *SCALE), SCALE)
    told = 'radiance beyond what the film takes is held there; below the smallest float it is 0'
    return light_map('Point light', 'POINT', x, y, told)


def sun_strength(count: int) -> Map:
    x = Axis('strength', steps(1e-20, 1e20, count), (1e-20, 1e12))
    y = Axis('scale', steps(1e-6, 1e6, count, *SCALE), SCALE)
    return light_map('Sun', 'SUN', x, y, 'radiance beyond what the film takes is held there')
