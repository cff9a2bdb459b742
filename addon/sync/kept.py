# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, shaders and images from one export to the next. The exporter asks here before it reads.

No Blender object is kept, only numbers (`session_uid`) by which one is recognised: they are never given twice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy

from ..log import Log

if TYPE_CHECKING:  # they use this file
    from ..export.buffers import Mesh
    from ..export.images import ImageTable
    from ..shader import Draft

Messages = tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class KeptShader:
    """A shader that was read.

    suns: of its skies. occlusion_distance: with which it was read. images: whether it has numbers of images in it.
    """

    draft: Draft
    suns: list[tuple[float, float, float, float]]
    occlusion_distance: float
    images: bool
    messages: Messages


class Kept:
    """What one sequence of exports keeps. What an export does not ask for is gone at its end."""

    def __init__(self) -> None:
        self._meshes: dict[tuple, tuple[Mesh | None, Messages]] = {}
        self._asked: dict[tuple, tuple[Mesh | None, Messages]] = {}
        self._shaders: dict[tuple, KeptShader] = {}
        self._asked_shaders: set[tuple] = set()
        self.images: ImageTable | None = None

    # ---- Around an export

    def begin(self) -> None:
        self._asked = {}
        self._asked_shaders = set()

    def end(self) -> None:
        """The export is whole: forget what it did not ask for."""
        self._meshes = self._asked
        self._shaders = {key: found for key, found in self._shaders.items() if key in self._asked_shaders}

    # ---- What changed

    def note(self, updates: Iterable[bpy.types.DepsgraphUpdate]) -> None:
        """Forget the shaders that Blender says have changed, of whatever their trees depend on it says so too."""
        for update in updates:
            owner = update.id
            if isinstance(owner, (bpy.types.Material, bpy.types.World, bpy.types.Light)):
                self._shaders.pop(identity(owner), None)
            elif isinstance(owner, (bpy.types.Image, bpy.types.MovieClip)):
                self.forget_images()

    def forget_images(self) -> None:
        """Pixels may be others now."""
        self.images = None
        self._shaders = {key: found for key, found in self._shaders.items() if not found.images}

    def forget_shaders(self, images: bool = True) -> None:
        """After an undo, say: everything that has no number of its own for each of its states."""
        if images:
            self.images = None
        self._shaders.clear()

    # ---- What the exporter asks

    def mesh(self, key: tuple, read: Callable[[], Mesh | None], log: Log) -> Mesh | None:
        """The mesh of that key, read now if it was not there before."""
        found = self._meshes.get(key) or self._asked.get(key)
        if found is None:
            mark = len(log.messages)
            mesh = read()
            found = mesh, tuple(log.messages[mark:])
        else:
            log.repeat(found[1])
        self._asked[key] = found
        return found[0]

    def shader(self, owner: bpy.types.ID, occlusion_distance: float, log: Log) -> KeptShader | None:
        key = identity(owner)
        found = self._shaders.get(key)
        if found is None or found.occlusion_distance != occlusion_distance:
            return None
        self._asked_shaders.add(key)
        log.repeat(found.messages)
        return found

    def keep_shader(self, owner: bpy.types.ID, found: KeptShader) -> None:
        key = identity(owner)
        self._shaders[key] = found
        self._asked_shaders.add(key)


def identity(owner: bpy.types.ID) -> tuple[str, int]:
    """Of an evaluated or original block of data: that of the original, as evaluated ones have no number always."""
    original: Any = owner.original or owner
    return type(original).__name__, original.session_uid
