# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials ask of the meshes that show them: UV maps, tangents, generated coordinates; no mesh brings more.

How a mesh's arrays are read is geometry.py's.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import bpy

from .buffers import COORDINATES_GENERATED, COORDINATES_OBJECT, COORDINATES_UV, NORMAL_TANGENT
from .textures import NormalMap, Texture

if TYPE_CHECKING:  # both of them use this file
    from .materials import Row
    from .shapes import Shape


@dataclass(slots=True)
class Needs:
    """What one mesh must bring. uv_maps and tangents: names of UV maps, '' = the active render one."""

    uv_maps: set[str] = field(default_factory=set)
    tangents: set[str] = field(default_factory=set)
    generated: bool = False


@dataclass(frozen=True, slots=True)
class Layers:
    """The UV maps in use, in the order that slots count them; see the fields of `SceneBuffers`.

    aliases: names that mean the active render UV map wherever they are used.
    """

    uv_layers: tuple[str, ...]
    tangent_layers: tuple[int, ...]
    object_spaces: bool
    aliases: frozenset[str]
    needs: dict[bpy.types.Mesh, Needs]

    def resolved(self, texture: Texture) -> Texture:
        lookup = texture.lookup
        return replace(texture, lookup=replace(lookup, uv_map='')) if lookup.uv_map in self.aliases else texture

    def tangent(self, normal: NormalMap | None) -> int:
        """The place in `tangent_layers` that a normal map reads."""
        if normal is None or normal.space != NORMAL_TANGENT:
            return 0
        name = '' if normal.uv_map in self.aliases else normal.uv_map
        return self.tangent_layers.index(self.uv_layers.index(name))


def plan(shapes: Iterable[Shape], rows: list[Row]) -> Layers:
    """What the materials `rows` ask of the meshes of the shapes."""
    asked = [_needs_of_row(row) for row in rows]
    needs: dict[bpy.types.Mesh, Needs] = {}
    for shape in shapes:
        mine = needs.setdefault(shape.data, Needs())
        for need in (asked[index] for index in shape.materials):
            mine.uv_maps |= need.uv_maps
            mine.tangents |= need.tangents
            mine.generated |= need.generated

    # Importers name the UV map even where there is but one: it shall not be there twice.
    foreign = {name for mesh, need in needs.items() for name in need.uv_maps | need.tangents if name != _active(mesh)}
    named = {name for need in asked for name in need.uv_maps | need.tangents} - {''}
    aliases = frozenset(named - foreign)
    for need in needs.values():
        need.uv_maps = {'' if name in aliases else name for name in need.uv_maps}
        need.tangents = {'' if name in aliases else name for name in need.tangents}
    tangents = {'' if name in aliases else name for need in asked for name in need.tangents}
    uv_layers = ('', *sorted(named - aliases))
    return Layers(
        uv_layers=uv_layers,
        tangent_layers=tuple(index for index, name in enumerate(uv_layers) if name in tangents),
        object_spaces=any(_reads(row, COORDINATES_OBJECT) for row in rows),
        aliases=aliases,
        needs=needs,
    )


def _needs_of_row(row: Row) -> Needs:
    lookups = [texture.lookup for texture in row.textures().values()]
    normal = row.bsdf.normal
    return Needs(
        uv_maps={lookup.uv_map for lookup in lookups if lookup.coordinates == COORDINATES_UV},
        tangents={normal.uv_map} if normal is not None and normal.space == NORMAL_TANGENT else set(),
        generated=_reads(row, COORDINATES_GENERATED),
    )


def _reads(row: Row, coordinates: int) -> bool:
    return any(texture.lookup.coordinates == coordinates for texture in row.textures().values())


def _active(mesh: bpy.types.Mesh) -> str | None:
    return next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
