# SPDX-License-Identifier: GPL-3.0-or-later
"""Every shader node with each value of each property, and with values of each input, beside Cycles' pictures.

One page of small pictures a node; what differs and is not named in a warning is wrong.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import stats

from beside_cycles import in_halves
from node_variants import Variant, every_kind, page, variants

pytestmark = [
    pytest.mark.usefixtures('engine'),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='the nodes are those of Blender 5.2'),
]

# Of values and closures: samples of each half, bounces, pixels of a cell's side.
SHOWN = {False: (32, 0, 16), True: (40, 4, 24)}
LIMIT = 0.03  # of a quarter of a cell, beside four times its noise
VALUES, CLOSURES = every_kind() if bpy.app.version >= (5, 0, 0) else ([], [])


def off(shown: list[Variant], closures: bool, folder: Path) -> list[tuple[float, Variant]]:
    """The variants that differ in silence, and by how much."""
    samples, bounces, pixels = SHOWN[closures]
    side = math.ceil(math.sqrt(len(shown)))
    scene = page(shown, side, closures)
    size = (side * pixels, side * pixels)
    ours = in_halves(scene, 'COTORRA', folder, bounces, size, samples)
    warnings = [text for layer in stats.last(scene.name) for text in layer.warnings]
    theirs = in_halves(scene, 'CYCLES', folder, bounces, size, samples)

    def quarters(image: np.ndarray) -> np.ndarray:
        """(side, side, 2, 2, 3): row and column from below, halves of the cell."""
        half = pixels // 2
        return image[::-1].reshape(side, 2, half, side, 2, half, 3).mean(axis=(2, 5)).transpose(0, 2, 1, 3, 4)

    mine, other = quarters(ours.image), quarters(theirs.image)
    noise = np.sqrt((quarters(ours.variance) + quarters(theirs.variance)) / (pixels // 2) ** 2)
    found = []
    for k, variant in enumerate(shown):
        at = k // side, k % side
        scale = np.maximum(other[at], 0.25 * other[at].max() + 1e-3)
        error = float(((np.abs(mine[at] - other[at]) - 4.0 * noise[at]) / scale).max())
        if not error <= LIMIT and not any(f'"V{k}"' in text for text in warnings):
            found.append((error, variant))
    return found


@pytest.mark.every(12)
@pytest.mark.parametrize('kind', VALUES)
def test_values_of_a_node(kind: str, tmp_path: Path) -> None:
    assert not off(variants(kind), False, tmp_path)


@pytest.mark.every(6)
@pytest.mark.parametrize('kind', CLOSURES)
def test_closures_of_a_node(kind: str, tmp_path: Path) -> None:
    assert not off(variants(kind), True, tmp_path)
