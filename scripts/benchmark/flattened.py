# SPDX-License-Identifier: GPL-3.0-or-later
"""The exported scene as meshes in world space, one for each instance and material, for engines outside Blender.

Those trace them faster than instances. It needs NumPy alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

LIGHT_POINT, LIGHT_SUN, LIGHT_SPOT = 0, 1, 2


@dataclass(frozen=True)
class Flat:
    name: str
    positions: np.ndarray  # (n, 3)
    normals: np.ndarray | None  # (n, 3), unit
    triangles: np.ndarray  # (m, 3)
    material: int


def flattened(scene: dict[str, Any]) -> Iterator[Flat]:
    instances = scene['instances']
    for i, mesh_index in enumerate(instances['mesh']):
        mesh = scene['meshes'][mesh_index]
        matrix = instances['transform'][i].astype(np.float64)
        positions = mesh['positions'] @ matrix[:, :3].T + matrix[:, 3]
        triangles, normals = mesh['triangles'], mesh['normals']
        if mesh['normals_domain'] == 'CORNER' and normals is not None:
            # They have one normal for each vertex: each corner becomes a vertex.
            corners = mesh['corners']
            expanded = np.zeros((len(normals), 3))
            expanded[corners.ravel()] = positions[triangles.ravel()]
            positions, triangles = expanded, corners
        if normals is not None:
            normals = normals @ np.linalg.inv(matrix[:, :3])
            normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
        slots = mesh['slots'] if mesh['slots'] is not None else np.zeros(len(triangles), np.uint32)
        count = instances['material_count'][i]
        for slot in np.unique(slots):
            index = scene['material_slots'][instances['material_base'][i] + min(slot, count - 1)]
            yield Flat(f'{i}_{slot}', positions, normals, triangles[slots == slot], int(index))
