# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes with UV maps for textured demos: joined boxes, turned vessels, leaves. UV units are metres but for the leaves.

Materials and places are the scenes' own business.
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Iterable, Sequence

import bmesh
import bpy
from mathutils import Euler, Matrix, Vector

Box = tuple[Sequence[float], Sequence[float]]  # centre, size


def boxes(name: str, parts: Iterable[Box], bevel: float = 0.0) -> bpy.types.Mesh:
    """Boxes along the axes in one mesh, their edges rounded off by `bevel` metres; smooth where it is rounded."""
    shape = bmesh.new()
    for centre, size in parts:
        matrix = Matrix.Translation(centre) @ Matrix.Diagonal((*size, 1.0))
        bmesh.ops.create_cube(shape, size=1.0, matrix=matrix)
    if bevel > 0.0:
        bmesh.ops.bevel(shape, geom=shape.edges[:], offset=bevel, segments=4, profile=0.5, affect='EDGES')
    project_box(shape)
    mesh = bpy.data.meshes.new(name)
    shape.to_mesh(mesh)
    shape.free()
    if bevel > 0.0:
        mesh.shade_smooth()
    return mesh


def project_box(shape: bmesh.types.BMesh) -> None:
    """UVs by the axis that a face looks along most: v is up on all sides, along y on top and below."""
    layer = shape.loops.layers.uv.new('UVMap')
    for face in shape.faces:
        normal = [abs(value) for value in face.normal]
        axis = normal.index(max(normal))
        u, v = ((1, 2), (0, 2), (0, 1))[axis]
        for corner in face.loops:
            corner[layer].uv = (corner.vert.co[u], corner.vert.co[v])


def turned(name: str, profile: Sequence[tuple[float, float]], segments: int = 96) -> bpy.types.Mesh:
    """A vessel turned about z; profile: (radius, height) from the first ring to the last, smoothly joined.

    u goes round in whole repeats of about a metre's texture a metre of girth, v along the profile.
    """
    repeats = max(1, round(2 * math.pi * max(radius for radius, _ in profile)))
    lengths = [0.0]
    for (r0, z0), (r1, z1) in itertools.pairwise(profile):
        lengths.append(lengths[-1] + math.hypot(r1 - r0, z1 - z0))
    shape = bmesh.new()
    layer = shape.loops.layers.uv.new('UVMap')
    turn = 2 * math.pi / segments
    rings = [
        [shape.verts.new((r * math.cos(k * turn), r * math.sin(k * turn), z)) for k in range(segments)]
        for r, z in profile
    ]
    for row in range(len(profile) - 1):
        for k in range(segments):
            after = (k + 1) % segments
            face = shape.faces.new((rings[row][k], rings[row][after], rings[row + 1][after], rings[row + 1][k]))
            u0, u1 = repeats * k / segments, repeats * (k + 1) / segments
            places = ((u0, lengths[row]), (u1, lengths[row]), (u1, lengths[row + 1]), (u0, lengths[row + 1]))
            for corner, place in zip(face.loops, places, strict=True):
                corner[layer].uv = place
    mesh = bpy.data.meshes.new(name)
    shape.to_mesh(mesh)
    shape.free()
    mesh.shade_smooth()
    return mesh


def curtain(name: str, width: float, height: float) -> bpy.types.Mesh:
    """Cloth that hangs in six folds: width along x, height from z = 0 up; UVs follow the cloth."""
    columns, folds, deep = 96, 6, 0.045
    shape = bmesh.new()
    layer = shape.loops.layers.uv.new('UVMap')
    rows, along = [], 0.0
    for k in range(columns + 1):
        x, y = width * (k / columns - 0.5), deep * math.sin(2 * math.pi * folds * k / columns)
        if rows:
            along += math.dist((x, y), rows[-1][0].co[:2])
        rows.append((shape.verts.new((x, y, 0.0)), shape.verts.new((x, y, height)), along))
    for (a, d, u0), (b, c, u1) in itertools.pairwise(rows):
        face = shape.faces.new((a, b, c, d))
        for corner, place in zip(face.loops, ((u0, 0.0), (u1, 0.0), (u1, height), (u0, height)), strict=True):
            corner[layer].uv = place
    mesh = bpy.data.meshes.new(name)
    shape.to_mesh(mesh)
    shape.free()
    mesh.shade_smooth()
    return mesh


def leaves(name: str, number: int, length: float, seed: int) -> bpy.types.Mesh:
    """Bent cards that grow out of the origin in all directions, each with the unit square of UVs."""
    chance = random.Random(seed)
    shape = bmesh.new()
    layer = shape.loops.layers.uv.new('UVMap')
    for index in range(number):
        size = length * chance.uniform(0.6, 1.0)
        heading = 2.4 * index + chance.uniform(-0.3, 0.3)  # 2.4 rad: the golden angle, as leaves grow
        pitch = chance.uniform(0.5, 1.3)
        matrix = Euler((0.0, 0.0, heading)).to_matrix() @ Euler((pitch, 0.0, 0.0)).to_matrix()
        add_card(shape, layer, matrix, size, bend=chance.uniform(0.5, 1.2))
    mesh = bpy.data.meshes.new(name)
    shape.to_mesh(mesh)
    shape.free()
    mesh.shade_smooth()
    return mesh


def add_card(
    shape: bmesh.types.BMesh, layer: bmesh.types.BMLayerItem, matrix: Matrix, size: float, bend: float
) -> None:
    """A strip of 8 quads that bends over by `bend` radians from its foot to its tip."""
    steps, width = 8, 0.36 * size
    point, rows = Vector((0.0, 0.0, 0.0)), []
    for step in range(steps + 1):
        rows.append([shape.verts.new(matrix @ (point + Vector((side * width / 2, 0.0, 0.0)))) for side in (-1, 1)])
        angle = -bend * (step + 0.5) / steps
        point = point + Vector((0.0, math.cos(angle), math.sin(angle))) * (size / steps)
    for step in range(steps):
        (a, b), (d, c) = rows[step], rows[step + 1]
        face = shape.faces.new((a, b, c, d))
        v0, v1 = step / steps, (step + 1) / steps
        for corner, place in zip(face.loops, ((0.0, v0), (1.0, v0), (1.0, v1), (0.0, v1)), strict=True):
            corner[layer].uv = place
