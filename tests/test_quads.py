# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that meet quadrilaterals of two triangles meet those triangles: number and barycentric coordinates.

That nothing leaks between them is test_watertight.py's.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import classic_scenes as classic
from embree_oracle import embree_hits


def patches(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Crooked quadrilaterals seen from above: pairs of triangles that begin at each of their corners, and some alone.

    Vertices, triangles, and a normal of its own at each vertex.
    """
    rng = np.random.default_rng(seed)
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    places = np.stack(np.meshgrid(np.linspace(-1.8, 1.8, 12), np.linspace(-1.8, 1.8, 12)), axis=-1).reshape(-1, 2)
    turns = itertools.cycle(itertools.product(range(3), range(3), (False, False, True)))
    vertices, triangles = [], []
    for place, (first, second, alone) in zip(places, turns, strict=False):
        base = len(vertices)
        corners = place + 0.14 * square + rng.uniform(-0.03, 0.03, (4, 2))
        vertices += [(*corner, rng.uniform(-0.1, 0.1)) for corner in corners]
        triangles.append(np.roll((base, base + 1, base + 2), first))
        if not alone:
            triangles.append(np.roll((base, base + 2, base + 3), second))
    normals = rng.normal(size=(len(vertices), 3)) * 0.3 + (0.0, 0.0, 1.0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.array(vertices), np.array(triangles), normals


@pytest.mark.parametrize('shuffled', [False, True])
def test_hits_of_pairs_are_those_of_their_triangles(shuffled: bool) -> None:
    """Shuffled, the triangles of a pair stand apart."""
    vertices, triangles, normals = patches(3)
    if shuffled:
        triangles = np.random.default_rng(5).permutation(triangles)
    size = (320, 320)
    view = classic.camera(size, (0.0, 0.0, 4.0), (0.0, 0.0, -1.0), window=4.0, filter_width=0.0)
    shape = classic.Shape(vertices, triangles, normals=normals)
    run = classic.session(classic.scene([shape], world=(1.0, 1.0, 1.0)), view, 'DIRECT', passes=('normal',))
    ours = classic.read(run, view, 'normal').astype(float)

    found = embree_hits(vertices, triangles, view)
    prim, u, v = found['primID'], found['u'][:, None], found['v'][:, None]
    a, b, c = (normals[triangles[prim, corner]] for corner in range(3))
    smooth = a * (1.0 - u - v) + b * u + c * v
    smooth /= np.linalg.norm(smooth, axis=1, keepdims=True)
    met = (prim != -1).reshape(size[::-1])
    theirs = smooth.reshape(ours.shape)

    assert 0.4 < met.mean() < 0.9
    differ = met & (np.abs(ours - theirs).max(axis=-1) > 1e-4)
    # At the edge of a patch either may have missed it.
    assert differ.sum() <= 4, np.argwhere(differ)[:10]
    assert (~met & (np.abs(ours).max(axis=-1) > 0.0)).sum() <= 4
