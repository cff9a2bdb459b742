# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials to arrays: each material once, each run of material slots once.

How a node tree becomes Principled constants is told in surface.py; which faces use which slot in geometry.py.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy
import numpy as np

from .. import compat
from ..log import Log
from .buffers import TEXTURED_INPUTS, U32, Materials, MaterialTextures
from .closures import Bsdf, diffuse, principled
from .images import ImageTable
from .layers import Layers
from .models import model_arrays
from .nodes import Trees, node_inputs, output_node
from .shaders import ShaderTable
from .surface import Reader, read_closure, warn_missing_images
from .textures import BLACK, Color, NormalMap, Texture, constant, slot_array

DEFAULT_NAME = 'default material'
COLORS = ('base_color', 'specular_tint', 'emission')
NO_NORMAL_MAP = NormalMap(constant(0.0))


@dataclass(frozen=True, slots=True)
class Row:
    """One entry of the Materials arrays."""

    name: str
    bsdf: Bsdf = field(default_factory=Bsdf)
    emission: Color | Texture = BLACK
    alpha: float | Texture = 1.0
    pass_index: int = 0
    emission_sampling: bool = True
    emission_sides: int = 3

    def textures(self) -> dict[str, Texture]:
        """Those of TEXTURED_INPUTS that vary."""
        normal = self.bsdf.normal
        found = {'emission': self.emission, 'alpha': self.alpha, 'normal': normal.texture if normal else None}
        values = {name: found[name] if name in found else getattr(self.bsdf, name) for name in TEXTURED_INPUTS}
        return {name: value for name, value in values.items() if isinstance(value, Texture)}


@dataclass(slots=True)
class MaterialTable:
    """The materials met so far. Row 0 is the default one, which objects without a material show."""

    log: Log
    trees: Trees
    images: ImageTable
    refracts: bool = False  # whether glass is rendered
    shader_table: ShaderTable | None = None
    shaders: list[int] = field(default_factory=lambda: [-1])  # of the rows
    rows: list[Row] = field(default_factory=lambda: [Row(DEFAULT_NAME)])
    slots: list[int] = field(default_factory=list)
    owners: list[bpy.types.Material | None] = field(default_factory=lambda: [None])
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
            self.shaders.append(_shader(material, self))
            self.owners.append(material)
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


def material_arrays(table: MaterialTable, layers: Layers, scene: bpy.types.Scene) -> tuple[Materials, U32]:
    """The table as arrays: the materials, and `material_slots`. The scene is the evaluated one."""
    rows = table.rows
    bsdfs = [row.bsdf for row in rows]
    floats = {
        'base_color': [bsdf.base_color for bsdf in bsdfs],
        'metallic': [bsdf.metallic for bsdf in bsdfs],
        'roughness': [bsdf.roughness for bsdf in bsdfs],
        'ior': [bsdf.ior for bsdf in bsdfs],
        'specular_level': [bsdf.specular_level for bsdf in bsdfs],
        'specular_tint': [bsdf.specular_tint for bsdf in bsdfs],
        'emission': [row.emission for row in rows],
        'alpha': [row.alpha for row in rows],
    }
    if table.refracts:
        floats['transmission'] = [bsdf.transmission for bsdf in bsdfs]
    arrays = {
        name: np.array([_typical(value, name) for value in values], np.float32) for name, values in floats.items()
    }
    for name, values in arrays.items():
        _replace_not_finite(name, values, rows, table.log)
    materials = Materials(
        **arrays,
        multi_ggx=np.array([bsdf.multi_ggx for bsdf in bsdfs], np.uint32),
        pass_index=np.array([row.pass_index for row in rows], np.int32),
        emission_sampling=np.array([row.emission_sampling for row in rows], np.uint32),
        emission_sides=np.array([row.emission_sides for row in rows], np.uint32),
        names=tuple(row.name for row in rows),
        models=model_arrays(table.owners, scene, table.log),
        textures=texture_arrays(rows, layers),
        shader=np.array(table.shaders, np.int32) if table.shader_table is not None else None,
    )
    return materials, np.array(table.slots, np.uint32)


def texture_arrays(rows: list[Row], layers: Layers) -> MaterialTextures | None:
    """The images that materials read; each lookup once. None where there are none."""
    index: dict[Texture, int] = {}
    inputs = np.full((len(rows), len(TEXTURED_INPUTS)), -1, np.int32)
    for row, columns in zip(rows, inputs, strict=True):
        for name, texture in row.textures().items():
            columns[TEXTURED_INPUTS.index(name)] = index.setdefault(layers.resolved(texture), len(index))
    if not index:
        return None
    normals = [row.bsdf.normal or NO_NORMAL_MAP for row in rows]
    return MaterialTextures(
        slots=slot_array(index, layers.uv_layers),
        inputs=inputs,
        normal_strength=np.array([normal.strength for normal in normals], np.float32),
        normal_tangent=np.array([layers.tangent(row.bsdf.normal) for row in rows], np.uint32),
        normal_space=np.array([normal.space for normal in normals], np.uint32),
    )


def _typical(value: Color | float | Texture, name: str) -> Color | float:
    """What stands for a texture among the constants, so that they tell which lobes there can be."""
    if not isinstance(value, Texture):
        return value
    typical = value.typical()
    return typical if name in COLORS else typical[0]


def _shader(material: bpy.types.Material, table: MaterialTable) -> int:
    """The number of its shader, -1 where none are read."""

    def warn(text: str) -> None:
        table.log.warning(f'Material "{material.name}": {text}')

    return -1 if table.shader_table is None else table.shader_table.index(material, warn)


def _read(material: bpy.types.Material, table: MaterialTable) -> Row:
    def warn(text: str) -> None:
        if table.shader_table is None:  # else what its shader cannot be is told
            table.log.warning(f'Material "{material.name}": {text}')

    tree = compat.node_tree(material)
    if tree is None:
        # As Cycles: the colour of the viewport, diffuse.
        bsdf, emission, alpha, sides = diffuse(tuple(material.diffuse_color)[:3]), BLACK, 1.0, 3
    else:
        bsdf, emission, alpha, sides = _read_tree(tree, table, warn)
    settings = getattr(material, 'cycles', None)  # absent where the Cycles add-on is disabled
    sampled = getattr(settings, 'emission_sampling', 'AUTO') != 'NONE'
    return Row(material.name, bsdf, emission, alpha, material.pass_index, sampled, sides)


def _read_tree(
    tree: bpy.types.NodeTree, table: MaterialTable, warn: Callable[[str], None]
) -> tuple[Bsdf, Color | Texture, float | Texture, int]:
    output = output_node(tree)
    inputs = node_inputs(output) if output is not None else {}
    reader = Reader(table.trees, warn, images=table.images, refracts=table.refracts)
    front = principled(read_closure(reader, inputs.get('Surface')), warn)
    for name in ('Volume', 'Displacement'):
        reader.leave_out_linked(inputs, name)
    reader.report()
    warn_missing_images(tree, warn)
    if not reader.asks_side:
        return *front, 3
    # A mix by Backfacing, as one-sided emitters are made: where only the emission differs, it gets its sides.
    behind = Reader(table.trees, _silent, back=1.0, images=table.images, refracts=table.refracts)
    back = principled(read_closure(behind, inputs['Surface']), _silent)
    if front[1] == back[1]:
        sides, emission = 3, front[1]
    elif back[1] == BLACK:
        sides, emission = 1, front[1]
    else:
        sides, emission = (2, back[1]) if front[1] == BLACK else (3, front[1])
    if (front[0], front[2]) != (back[0], back[2]) or (sides == 3 and front[1] != back[1]):
        warn('back faces that differ from front faces are not supported yet: they are rendered alike')
    return front[0], emission, front[2], sides


def _silent(text: str) -> None:
    """Messages about back faces: what they share with the front has been told."""


def _replace_not_finite(name: str, values: np.ndarray, rows: list[Row], log: Log) -> None:
    """A driver can set a socket to NaN or infinity: use the default material's value there."""
    bad = ~np.isfinite(values).reshape(len(rows), -1).all(axis=1)
    for index in np.flatnonzero(bad):
        log.warning(f'Material "{rows[index].name}": {name} is not a finite number; the default is used')
    values[bad] = values[0]
