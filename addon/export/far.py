# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that are small beside their distance from the world's origin: what is lit there suffers from rounding.

Rays start above the surface that they leave by what its position is rounded by (kernels/surface.h, surface_shape), and
where that is much of the object, shadows where things touch are wrong. Camera and lamps are not asked.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..log import Log
from .buffers import Instances, Mesh

LIFT = 4.8e-7  # of the largest coordinate: as in surface_shape
# Of the object's size. With twice as much, tiles at a ball's foot were a tenth too dark beside Cycles'.
MOST = 1.0 / 256.0
FAR = 100.0  # metres from the origin; nearer, only crumbs of millimetres suffer


def warn_far(instances: Instances, meshes: Sequence[Mesh], log: Log) -> None:
    """One warning, which names the object that suffers most."""
    if not len(instances.mesh) or not instances.names:
        return
    axes, origins = instances.transform[:, :, :3], instances.transform[:, :, 3]
    # What cannot be far is not looked at: this runs with each edit of the viewport.
    reach = np.array([_reach(mesh.positions) for mesh in meshes])[instances.mesh]
    reach = np.abs(origins).max(axis=1) + np.abs(axes).sum(axis=2).max(axis=1) * reach
    candidates = np.flatnonzero(reach > FAR)
    if not len(candidates):
        return
    boxes = {index: _box(meshes[index].positions) for index in np.unique(instances.mesh[candidates])}
    low, high = (np.array([boxes[index][end] for index in instances.mesh[candidates]]) for end in (0, 1))
    axes, origins = axes[candidates], origins[candidates]
    middle = np.einsum('nij,nj->ni', axes, (low + high) / 2) + origins
    size = np.linalg.norm(np.einsum('nij,nj->ni', axes, high - low), axis=1)
    distance = np.abs(middle).max(axis=1)
    lift = LIFT * distance
    far = np.flatnonzero((distance > FAR) & (lift > MOST * size) & (size > 0.0))
    if not len(far):
        return
    among = far[np.argmax(lift[far] / size[far])]
    worst = candidates[among]
    name = instances.names[min(worst, len(instances.names) - 1)]
    also = f' (and {len(far) - 1} more)' if len(far) > 1 else ''
    log.warning(
        f'Object "{name}"{also} lies so far from the origin that rays start {lift[among]:.2g} m above its surface: '
        'shadows where things touch are too dark; move the scene to the origin'
    )


def _reach(positions: NDArray[np.float32]) -> float:
    """Largest coordinate, either way."""
    return max(float(positions.max()), -float(positions.min())) if len(positions) else 0.0


def _box(positions: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    if not len(positions):
        return np.zeros(3, np.float32), np.zeros(3, np.float32)
    return positions.min(axis=0), positions.max(axis=0)
