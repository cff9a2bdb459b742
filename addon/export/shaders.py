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
from .attributes import view_layer_value
from .buffers import Shader
from .images import ImageTable
from .nodes import Trees


@dataclass(slots=True)
class ShaderTable:
    """The shaders met so far. view_layer: the evaluated one, for its attributes; suns: of skies, by shader."""

    log: Log
    trees: Trees
    images: ImageTable
    scene: bpy.types.Scene
    view_layer: bpy.types.ViewLayer
    drafts: list[shader.Draft] = field(default_factory=list)
    suns: dict[int, list[tuple[float, float, float, float]]] = field(default_factory=dict)
    _index: dict[tuple, int] = field(default_factory=dict)

    def index(self, owner: bpy.types.Material | bpy.types.World | bpy.types.Light, warn: Callable[[str], None]) -> int:
        """The number of the shader of a material, world or light, which is read now. warn: takes texts about it."""

        def attribute(name: str) -> tuple[float, float, float, float]:
            return view_layer_value(self.scene, self.view_layer, name)

        self.log.checkpoint()
        found = shader.Scene(self.images, attribute, occlusion_distance=shader.occlusion_distance(self.scene))
        draft = shader.shaders_of(owner, self.trees.of(warn), found, warn)
        key = draft.key
        if key not in self._index:
            self._index[key] = len(self.drafts)
            self.drafts.append(draft)
            self.suns[self._index[key]] = found.suns
        return self._index[key]

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
