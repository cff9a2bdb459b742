# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies before the camera's near clip or behind its far one is not seen, and all else is, on every device.

A plane, which casts no shadow, above a floor under a sun. What Blender says of clipping is in test_export_camera.py.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra.export import buffers as b

from beside_cycles import in_halves
from devices import on_both
from flat_scenes import flat
from scenes import build
from texture_scenes import U32, camera, instances, lights, materials, plane, render, scene

HEIGHT, ABOVE = 5.0, 1.0  # of the camera and of the plane, metres
FLOOR, PLANE = 0.8, 0.5  # what they show
SIDE = 8
CASES = [
    ('ORTHO', 0.01, 100.0, PLANE),
    ('ORTHO', 4.5, 100.0, FLOOR),
    ('ORTHO', 5.5, 100.0, 0.0),
    ('ORTHO', 0.01, 3.5, 0.0),
    ('PERSP', 0.01, 100.0, PLANE),
    ('PERSP', 4.5, 100.0, FLOOR),
    ('PERSP', 5.001, 100.0, 0.0),
    ('PERSP', 4.999, 5.001, FLOOR),  # measured along the axis: a ray at the border is longer
]


def clipped(kind: str, start: float, end: float, device: str, alpha: float) -> np.ndarray:
    """The picture; alpha: of the plane and the floor, of which light that it lets through makes another kind of ray."""
    whole = materials(2, alpha=[1.0, alpha], base_color=[[FLOOR] * 3, [PLANE] * 3])
    seen = instances(2, visibility=np.array([63, 63 & ~b.VISIBLE_SHADOW], U32))
    made = scene((plane(), plane(z=ABOVE)), whole, lights=lights(((0.0, 0.0, -1.0), np.pi)), instances=seen)
    half = 0.9 if kind == 'ORTHO' else 0.9 / HEIGHT
    view = replace(camera(half, SIDE, HEIGHT), kind=kind, clip=(start, end))
    return render(made, view, device=device, samples=64)['combined'][..., 0]


@on_both('kind, start, end, expected', CASES, [CASES[1], CASES[5], CASES[7]])
def test_what_is_clipped_is_not_seen(kind: str, start: float, end: float, expected: float, device: str) -> None:
    # The sum of 64 samples that are all alike, each rounded.
    np.testing.assert_allclose(clipped(kind, start, end, device, 1.0), expected, rtol=1e-5)


@on_both('kind, start, end, expected', CASES[:4], [CASES[1]])
def test_where_the_plane_lets_rays_through(kind: str, start: float, end: float, expected: float, device: str) -> None:
    found = clipped(kind, start, end, device, 0.5)
    expected = {PLANE: 0.5 * (PLANE + FLOOR)}.get(expected, expected)
    assert found.mean() == pytest.approx(expected, rel=0.02, abs=1e-6)


@pytest.mark.usefixtures('engine')
@pytest.mark.parametrize('kind', ['PERSP', 'ORTHO'])
def test_as_cycles_clips(kind: str, tmp_path: Path) -> None:
    """A slope that both clips cut."""
    made = flat()
    made.obj.rotation_euler.x = 0.8
    build.world(bpy.context.scene, (0.1, 0.1, 0.1))
    data = made.scene.camera.data
    data.type, data.ortho_scale, data.clip_start, data.clip_end = kind, 4.0, 2.5, 3.5
    ours, theirs = (in_halves(made.scene, engine, tmp_path, 0, (32, 32), 16).image for engine in ('COTORRA', 'CYCLES'))
    assert 0.2 < (theirs[..., 0] > 0.2).mean() < 0.8, 'a part is clipped'
    means = [image.reshape(8, 4, 8, 4, 3).mean((1, 3)) for image in (ours, theirs)]
    np.testing.assert_allclose(*means, rtol=0.05, atol=0.02)
