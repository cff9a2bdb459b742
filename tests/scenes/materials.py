# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials are exported as: the constants that the native module finds, and the closures of their shaders.

The materials themselves are made in the tests, with what build.py has.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
from cotorra import native
from cotorra.export.buffers import SceneBuffers, Shader
from cotorra.log import Log

import shaders

from . import build
from .depsgraphs import exported


@dataclass(frozen=True)
class Shown:
    """constants: what does not vary, by the names of Principled's inputs, colours as lists; with `alpha`."""

    name: str
    constants: dict[str, Any]
    shader: Shader | None
    buffers: SceneBuffers
    warnings: list[str]

    @property
    def closures(self) -> list[shaders.Closure]:
        return shaders.closures(self.shader)

    def __getitem__(self, name: str) -> Any:
        return self.constants[name]


def shown(material: bpy.types.Material | None) -> Shown:
    """What a new object with this material shows."""
    scene = bpy.context.scene
    obj = build.mesh_object(scene)
    obj.data.materials.append(material)
    log = Log()
    buffers = exported(scene, log)
    index = int(buffers.material_slots[buffers.instances.material_base[-1]])
    number = int(buffers.materials.shader[index])
    shader = buffers.shaders[number] if number >= 0 else None
    return Shown(buffers.materials.names[index], constants(buffers, index), shader, buffers, log.texts('WARNING'))


def constants(buffers: SceneBuffers, material: int) -> dict[str, Any]:
    found = native.load().Scene(buffers, bvh=False).constants(material)
    found = {name: list(value) if isinstance(value, tuple) else value for name, value in found.items()}
    if 'transparency' in found:
        clear = found.pop('transparency')
        assert clear[0] == clear[1] == clear[2]
        found['alpha'] = 1.0 - clear[0]
    return found
