# SPDX-License-Identifier: GPL-3.0-or-later
"""The shaders of one scene: each equal one once, whoever asks for it, and its layers numbered in the end.

How a node tree becomes a shader is told in addon/shader/.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy

from .. import shader
from ..log import Log
from ..sync.kept import Kept, KeptShader
from .attributes import view_layer_value
from .buffers import Shader
from .images import ANIMATED, ImageTable
from .nodes import Trees


@dataclass(slots=True)
class ShaderTable:
    """The shaders met so far. view_layer: the evaluated one, for its attributes; suns: of skies, by shader."""

    log: Log
    trees: Trees
    images: ImageTable
    scene: bpy.types.Scene
    view_layer: bpy.types.ViewLayer
    kept: Kept
    drafts: list[shader.Draft] = field(default_factory=list)
    suns: dict[int, list[tuple[float, float, float, float]]] = field(default_factory=dict)
    _index: dict[tuple, int] = field(default_factory=dict)

    def index(self, owner: bpy.types.Material | bpy.types.World | bpy.types.Light, warn: Callable[[str], None]) -> int:
        """The number of the shader of a material, world or light, which is read now. warn: takes texts about it."""

        self.log.checkpoint()
        distance = shader.occlusion_distance(self.scene)
        found = self.kept.shader(owner, distance, self.log) or self._read(owner, distance, warn)
        return self.add(found.draft, found.suns)

    def add(self, draft: shader.Draft, suns: list[tuple[float, float, float, float]]) -> int:
        """The number of a shader that was read."""
        key = draft.key
        if key not in self._index:
            self._index[key] = len(self.drafts)
            self.drafts.append(draft)
            self.suns[self._index[key]] = suns
        return self._index[key]

    def _read(
        self,
        owner: bpy.types.Material | bpy.types.World | bpy.types.Light,
        distance: float,
        warn: Callable[[str], None],
    ) -> KeptShader:
        """Read a shader, and keep it where nothing goes into it of which Blender would not tell."""
        asked: list[str] = []

        def attribute(name: str) -> tuple[float, float, float, float]:
            asked.append(name)
            return view_layer_value(self.scene, self.view_layer, name)

        mark = len(self.log.messages)
        self.images.uses.clear()
        found = shader.Scene(self.images, attribute, occlusion_distance=distance)
        draft = shader.shaders_of(owner, self.trees.of(warn), found, warn)
        uses = self.images.uses
        read = KeptShader(draft, found.suns, distance, bool(uses), tuple(self.log.messages[mark:]))
        if not asked and not ANIMATED & uses:
            self.kept.keep_shader(owner, read)
        return read

    def lets_through(self, index: int) -> bool:
        """Whether a shader may let light through: a transparent closure, or an alpha that is not 1."""
        found = self.drafts[index].shader
        kinds = shader.tables().closures
        for row in found.closures:
            if row['kind'] == kinds['transparent'].number:
                return True
            if row['kind'] == kinds['principled'].number:
                alpha = found.closure_args[row['first_arg'] + len(kinds['principled'].arguments) - 1]
                if alpha >= 0 or found.constants[~alpha][0] != 1.0:
                    return True
        return False

    def resolved(self, numbers: dict[tuple[str, str], int]) -> tuple[Shader, ...]:
        """All shaders, with the numbers of their layers: see `Layers.numbers`."""
        return tuple(draft.resolved(numbers) for draft in self.drafts)
