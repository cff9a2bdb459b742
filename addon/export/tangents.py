# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangents of triangles as MikkTSpace defines them (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited", 6.2).

Blender's own `calc_tangents` refuses n-gons and works on quads, where Cycles works on the triangles that are rendered.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .buffers import F32, U32

F64 = NDArray[np.float64]


def corner_tangents(positions: F32, normals: F32, uv: F32, vertices: U32, corners: U32, corner_count: int) -> F32:
    """(corner_count, 4): a unit tangent along u and the sign of its bitangent; 0, 0, 0 where uv gives no direction.

    positions: by vertex; normals, uv: by corner; vertices, corners: (T, 3) of the triangles.

    Corners of one position, normal and uv share a tangent if their triangles have one orientation in uv. MikkTSpace
    also asks that the triangles hang together around the vertex: that differs where two fans touch in a point only.
    """
    tangents, oriented = _triangle_tangents(positions, uv, vertices, corners)
    usable = np.any(tangents != 0.0, axis=1)
    at = corners.ravel()
    place = _welded(positions[vertices.ravel()], normals[at], uv[at]) * 2
    group = place + np.repeat(oriented, 3)

    # At each corner the triangle's tangent, laid into the plane of the normal and weighted with the corner's angle.
    sums = np.zeros((int(place.max()) + 2, 3))
    for corner in range(3):
        of_triangle = np.flatnonzero(usable)
        normal = normals[corners[of_triangle, corner]].astype(np.float64)
        here, after, before = (positions[vertices[of_triangle, (corner + k) % 3]].astype(np.float64) for k in range(3))
        laid = _laid(tangents[of_triangle], normal)
        cosine = np.einsum('ij,ij->i', _laid(after - here, normal), _laid(before - here, normal))
        laid *= np.arccos(np.clip(cosine, -1.0, 1.0))[:, None]
        target = group[of_triangle * 3 + corner]
        for axis in range(3):
            sums[:, axis] += np.bincount(target, laid[:, axis], len(sums))

    # Triangles without area in uv take what their neighbours have.
    lost = np.repeat(~usable, 3)
    group[lost] = place[lost] + np.any(sums[place[lost] + 1] != 0.0, axis=1)
    found = np.zeros((corner_count, 4), np.float32)
    found[:, 3] = 1.0
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    units = np.divide(sums, lengths, out=np.zeros_like(sums), where=lengths > 0.0)
    found[at, :3] = units[group]
    found[at, 3] = np.where(group % 2 == 1, 1.0, -1.0)
    return found


def _triangle_tangents(positions: F32, uv: F32, vertices: U32, corners: U32) -> tuple[F64, NDArray[np.bool_]]:
    """(T, 3) the direction in which u grows, 0 where there is none; and whether uv turns as the triangle does."""
    p0, p1, p2 = (positions[vertices[:, k]].astype(np.float64) for k in range(3))
    t0, t1, t2 = (uv[corners[:, k]].astype(np.float64) for k in range(3))
    d1, d2, e1, e2 = p1 - p0, p2 - p0, t1 - t0, t2 - t0
    area = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    direction = e2[:, 1:] * d1 - e1[:, 1:] * d2
    direction *= np.sign(area)[:, None]
    return direction, area > 0.0


def _laid(vectors: F64, normals: F64) -> F64:
    """Unit vectors in the planes of the normals; 0 where a vector stands on its plane."""
    flat = vectors - normals * np.einsum('ij,ij->i', vectors, normals)[:, None]
    lengths = np.linalg.norm(flat, axis=1, keepdims=True)
    return np.divide(flat, lengths, out=np.zeros_like(flat), where=lengths > 0.0)


def _welded(*columns: F32) -> NDArray[np.int64]:
    """One number a row; equal rows have equal numbers.

    Rows are told apart by a 64-bit hash: among 10 million of them two collide with a chance of 3 in a million.
    """
    bits = np.concatenate(columns, axis=1) + np.float32(0.0)  # -0 is 0
    words = np.ascontiguousarray(bits, np.float32).view(np.uint32).astype(np.uint64)
    hashes = np.zeros(len(words), np.uint64)
    for column in words.T:
        # SplitMix64's finalizer (Steele, Lea & Flood 2014) over what is there and the next word.
        hashes = (hashes ^ column) + np.uint64(0x9E3779B97F4A7C15)
        hashes = (hashes ^ (hashes >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        hashes = (hashes ^ (hashes >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        hashes ^= hashes >> np.uint64(31)
    return np.unique(hashes, return_inverse=True)[1].reshape(-1)
