# SPDX-License-Identifier: GPL-3.0-or-later
"""What Embree's own Python interface says that rays meet, by triangles, in its robust mode."""

from __future__ import annotations

import numpy as np
from cotorra.export.buffers import Camera
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

HEIGHT = 4.0  # metres, of the camera


def embree_hits(vertices: np.ndarray, triangles: np.ndarray, view: Camera) -> dict[str, np.ndarray]:
    """`primID` (-1: none), `tfar` in metres, `u` and `v` of the ray through the middle of each pixel, row by row from
    the bottom.

    vertices: (V, 3) metres. triangles: (T, 3). view: orthographic, from (0, 0, HEIGHT) along -Z.
    """
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, vertices.astype(np.float32), triangles.astype(np.int32))
    (width, height), (left, right, low, high) = view.resolution, view.window
    x = left + (right - left) * (np.arange(width) + 0.5) / width
    y = low + (high - low) * (np.arange(height) + 0.5) / height
    origins = np.stack([*np.meshgrid(x, y), np.full((height, width), HEIGHT)], axis=-1).reshape(-1, 3)
    towards = np.broadcast_to(np.array([0.0, 0.0, -1.0], np.float32), origins.shape).copy()
    return scene.run(origins.astype(np.float32), towards, output=1)
