# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that are small beside their distance from the world's origin: what is lit there suffers from rounding.

Rays start above the surface that they leave by what its position is rounded by (kernels/surface.h, surface_shape), and
where that is much of the object, shadows where things touch are wrong. Camera and lamps are not asked.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..log import Log
from .buffers import Instances, Mesh

LIFT = 4.8e-7  # of the largest coordinate: as in surface_shape
# Of the object's size. With twice as much, tiles at a ball's foot were a tenth too dark beside Cycles'.
MOST = 1.0 / 256.0


def warn_far(instances: Instances, meshes: Sequence[Mesh], log: Log) -> None:
    """One warning, which names the object that suffers most."""
    filled = [mesh.positions if len(mesh.positions) else np.zeros((1, 3), np.float32) for mesh in meshes]
    if not filled or not len(instances.mesh) or not instances.names:
        return
    low = np.array([positions.min(axis=0) for positions in filled])[instances.mesh]
    high = np.array([positions.max(axis=0) for positions in filled])[instances.mesh]
    axes = instances.transform[:, :, :3]
    middle = np.einsum('nij,nj->ni', axes, (low + high) / 2) + instances.transform[:, :, 3]
    size = np.linalg.norm(np.einsum('nij,nj->ni', axes, high - low), axis=1)
    lift = LIFT * np.abs(middle).max(axis=1)
    far = np.flatnonzero((lift > MOST * size) & (size > 0.0))
    if not len(far):
        return
    worst = far[np.argmax(lift[far] / size[far])]
    name = instances.names[min(worst, len(instances.names) - 1)]
    also = f' (and {len(far) - 1} more)' if len(far) > 1 else ''
    log.warning(
        f'Object "{name}"{also} lies so far from the origin that rays start {lift[worst]:.2g} m above its surface: '
        'shadows where things touch are too dark; move the scene to the origin'
    )
