# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether two exports differ: Blender tells of updates (a selection, a moved camera) that change nothing in a picture.

It compares arrays and knows no Blender.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from ..export.buffers import Image, Mesh, SceneBuffers


def equal(a: SceneBuffers, b: SceneBuffers) -> bool:
    """Whether both give the same scene. Meshes and images are equal where they are the same arrays."""
    return _equal(a, b)


def _equal(a: Any, b: Any) -> bool:
    if a is b:
        return True
    if type(a) is not type(b) or isinstance(a, (Mesh, Image)):
        return False
    if isinstance(a, np.ndarray):
        # NaN differs from itself: such scenes count as changed.
        return a.shape == b.shape and a.dtype == b.dtype and bool(np.array_equal(a, b))
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(_equal, a, b))
    if is_dataclass(a):
        return all(_equal(getattr(a, field.name), getattr(b, field.name)) for field in fields(a))
    return a == b
