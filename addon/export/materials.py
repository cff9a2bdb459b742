# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials to arrays: each material once, each run of material slots once.

What a node tree says is told in addon/shader/; which faces use which slot in geometry.py.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np

from .. import cycles_settings
from ..log import Log
from .buffers import U32, Materials
from .models import model_arrays
from .shaders import ShaderTable

DEFAULT_NAME = 'default material'


@dataclass(frozen=True, slots=True)
class Row:
    """One entry of the Materials arrays."""

    name: str
    owner: bpy.types.Material | None = None
    shader: int = -1
    pass_index: int = 0
    emission_sampling: bool = True


@dataclass(slots=True)
class MaterialTable:
    """The materials met so far. Row 0 is the default one, which objects without a material show."""

    log: Log
    shaders: ShaderTable
    rows: list[Row] = field(default_factory=lambda: [Row(DEFAULT_NAME)])
    slots: list[int] = field(default_factory=list)
    _index: dict[bpy.types.Material, int] = field(default_factory=dict)
    _runs: dict[tuple[int, ...], int] = field(default_factory=dict)

    def index(self, material: bpy.types.Material | None) -> int:
        """The row of a material, read when first met; None (an empty slot, a removed material) is the default one."""
        if material is None:
            return 0
        index = self._index.get(material)
        if index is None:
            index = self._index[material] = len(self.rows)
            self.rows.append(_read(material, self))
        return index

    def run(self, indices: tuple[int, ...]) -> int:
        """Where in `slots` this run of material indices begins; equal runs are stored once."""
        base = self._runs.get(indices)
        if base is None:
            base = self._runs[indices] = len(self.slots)
            self.slots.extend(indices)
        return base


def slot_materials(
    obj: bpy.types.Object, data: bpy.types.ID, override: bpy.types.Material | None
) -> list[bpy.types.Material | None]:
    """The materials of an object's slots: those of the data, save for slots that are linked to the object.

    An evaluated object shows the data's material where such a slot is empty; its original tells that it is.
    """
    if override is not None:
        return [override]
    materials = list(data.materials)
    own = obj.original.material_slots
    for index, slot in enumerate(obj.material_slots):
        if slot.link == 'OBJECT':
            empty = index < len(own) and own[index].link == 'OBJECT' and own[index].material is None
            materials.extend([None] * (index + 1 - len(materials)))
            materials[index] = None if empty else slot.material
    return materials or [None]


def material_arrays(table: MaterialTable, scene: bpy.types.Scene) -> tuple[Materials, U32]:
    """The table as arrays: the materials, and `material_slots`. The scene is the evaluated one."""
    rows = table.rows
    materials = Materials(
        pass_index=np.array([row.pass_index for row in rows], np.int32),
        emission_sampling=np.array([row.emission_sampling for row in rows], np.uint32),
        shader=np.array([row.shader for row in rows], np.int32),
        names=tuple(row.name for row in rows),
        models=model_arrays([row.owner for row in rows], scene, table.log),
    )
    return materials, np.array(table.slots, np.uint32)


def _read(material: bpy.types.Material, table: MaterialTable) -> Row:
    def warn(text: str) -> None:
        table.log.warning(f'Material "{material.name}": {text}')

    index = table.shaders.index(material, warn)
    if table.shaders.lets_through(index):
        cycles_settings.warn_owner(f'Material "{material.name}"', material, None, table.log)
    settings = getattr(material, 'cycles', None)  # absent where the Cycles add-on is disabled
    cycles_settings.warn_owner(f'Material "{material.name}"', settings, None, table.log)
    sampled = getattr(settings, 'emission_sampling', 'AUTO') != 'NONE'
    return Row(material.name, material, index, material.pass_index, sampled)
