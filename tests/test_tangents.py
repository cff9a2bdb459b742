# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangents and unit normals as the native module finds them, on meshes small enough to know the answer.

Whole meshes beside Blender's and Cycles' tangents are test_normal_maps.py's.
"""

from __future__ import annotations

import cotorra_native as native
import numpy as np
import pytest

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
UP = np.tile(np.array([0, 0, 1], np.float32), (4, 1))


def tangents(uv: np.ndarray, normals: np.ndarray = UP, triangles: np.ndarray = TRIANGLES) -> np.ndarray:
    return native.corner_tangents(SQUARE, normals, np.ascontiguousarray(uv, np.float32), triangles, triangles)


@pytest.mark.parametrize('turn', [0.0, 0.7, 2.5])
def test_they_lie_along_u(turn: float) -> None:
    """uv that is turned by an angle: u grows along (cos, sin)."""
    along = np.array([np.cos(turn), np.sin(turn)])
    uv = np.stack([SQUARE[:, :2] @ along, SQUARE[:, :2] @ [-along[1], along[0]]], axis=1)
    np.testing.assert_allclose(tangents(uv), np.tile([*along, 0.0, 1.0], (4, 1)), atol=1e-6)  # float32's rounding
    np.testing.assert_allclose(tangents(uv * [-1, 1]), np.tile([*-along, 0.0, -1.0], (4, 1)), atol=1e-6)


def test_corners_are_shared_where_uv_turns_alike() -> None:
    """The second triangle is mirrored in uv: where it meets the first, each keeps its own tangent."""
    corners = np.array([[0, 1, 2], [3, 4, 5]], np.uint32)
    uv = np.float32([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [2, 0]])
    found = native.corner_tangents(SQUARE, np.tile(UP[:1], (6, 1)), uv, TRIANGLES, corners)
    assert (found[:3, 3] == 1.0).all() and (found[3:, 3] == -1.0).all()
    np.testing.assert_allclose(np.linalg.norm(found[:, :3], axis=1), 1.0, atol=1e-6)


def test_uv_without_area_gives_no_direction() -> None:
    np.testing.assert_array_equal(tangents(np.zeros((4, 2)))[:, :3], 0.0)


def test_a_triangle_without_area_in_uv_takes_its_neighbours() -> None:
    uv = np.float32([[0, 0], [1, 0], [1, 1], [0, 0]])
    np.testing.assert_allclose(tangents(uv)[[0, 2]], np.tile([1.0, 0.0, 0.0, 1.0], (2, 1)), atol=1e-6)


def test_what_has_no_entry_is_refused() -> None:
    with pytest.raises(ValueError, match='vertices holds 7, must be below 4'):
        tangents(np.zeros((4, 2)), triangles=np.array([[0, 1, 7]], np.uint32))
    with pytest.raises(ValueError, match='as many uv as normals'):
        tangents(np.zeros((3, 2)))


@pytest.mark.parametrize(('length', 'good'), [(1.0, True), (0.8, True), (0.0, False), (2.0, False), (np.nan, False)])
def test_directions(length: float, good: bool) -> None:
    normals = np.tile(UP, (5, 1))
    normals[17, 2] = length
    assert native.are_directions(normals) is good
