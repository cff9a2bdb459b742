# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that rounding spoils far from the origin are named; where they are large enough, or near, nothing is said."""

from __future__ import annotations

import bpy
import pytest

from scenes import build
from scenes.depsgraphs import messages

pytestmark = pytest.mark.usefixtures('engine')


def ball(distance: float, radius: float = 0.8) -> bpy.types.Scene:
    scene = build.new_scene()
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=(distance, 0.4 * distance, 0.7))
    return scene


def test_a_ball_far_from_the_origin_is_named() -> None:
    [text] = messages(ball(50_000.0))
    assert text.startswith('Object "Sphere" lies so far from the origin that rays start 0.024 m above')


@pytest.mark.parametrize(('distance', 'radius'), [(0.0, 1e-4), (10.0, 1e-4), (10_000.0, 0.8), (50_000.0, 3.0)])
def test_others_are_not(distance: float, radius: float) -> None:
    assert messages(ball(distance, radius)) == []


def test_several_are_told_together() -> None:
    scene = ball(50_000.0)
    bpy.ops.mesh.primitive_cube_add(size=0.1, location=(50_000.0, 0.0, 0.0))
    [text] = messages(scene)
    assert text.startswith('Object "Cube" (and 1 more) lies so far')
