# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders ask of the meshes that show them: UV maps, tangents, attributes; no mesh brings more.

How a mesh's arrays are read is geometry.py's.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy

from .attributes import is_of_instance

if TYPE_CHECKING:  # they use this file, or are not needed to run it
    from ..shader import Draft
    from .shapes import Shape


@dataclass(slots=True)
class Needs:
    """What one mesh must bring.

    uv_maps, tangents: names of UV maps, '' = the active render one.
    attributes:        names of layers that are no UV maps (attributes.py).
    """

    uv_maps: set[str] = field(default_factory=set)
    tangents: set[str] = field(default_factory=set)
    attributes: set[str] = field(default_factory=set)
    generated: bool = False

    @property
    def key(self) -> tuple:
        """What is equal where a mesh brings the same."""
        return frozenset(self.uv_maps), frozenset(self.tangents), frozenset(self.attributes), self.generated


@dataclass(frozen=True, slots=True)
class Layers:
    """The UV maps and other layers in use; see the fields of `SceneBuffers`.

    aliases: names that mean the active render UV map wherever they are used.
    attribute_layers, instance_layers: see `SceneBuffers`.
    """

    uv_layers: tuple[str, ...]
    tangent_layers: tuple[int, ...]
    aliases: frozenset[str]
    needs: dict[bpy.types.Mesh, Needs]
    attribute_layers: tuple[str, ...] = ('',)
    instance_layers: tuple[int, ...] = ()
    object_info: bool = False

    @property
    def key(self) -> tuple:
        """What is equal where layers have the same numbers in the arrays of meshes."""
        return self.uv_layers, self.tangent_layers, self.attribute_layers

    @property
    def numbers(self) -> dict[tuple[str, str], int]:
        """What shaders put in for the name of a 'layer' or of a 'tangent' layer."""
        found = {('layer', name): index for index, name in enumerate(self.attribute_layers)}
        found |= {('layer', name): 0 for name in self.aliases}
        for index, layer in enumerate(self.tangent_layers):
            found['tangent', self.uv_layers[layer]] = index
            if layer == 0:
                found |= {('tangent', name): index for name in self.aliases}
        return found


# Ops that read generated coordinates: those themselves, and the tangents that are made of them.
READ_GENERATED = frozenset(('generated', 'tangent', 'geometry_tangent'))
READ_OBJECT_INFO = frozenset(('object_info_v', 'object_info_f'))


def plan(shapes: Iterable[Shape], drafts: list[Draft], shader_of: list[int]) -> Layers:
    """What the shaders of materials ask of the meshes of the shapes.

    drafts: all shaders, the world's and the lamps' included; shader_of: those of the materials, -1 for none.
    """
    asked = [Needs() if index < 0 else _needs_of(drafts[index]) for index in shader_of]
    needs: dict[bpy.types.Mesh, Needs] = {}
    groups = set()
    for shape in shapes:
        mine = needs.setdefault(shape.data, Needs())
        for need in (asked[index] for index in shape.materials):
            mine.uv_maps |= need.uv_maps
            mine.tangents |= need.tangents
            mine.attributes |= need.attributes
            mine.generated |= need.generated
        if mine.attributes:
            groups.update(group.name for group in shape.obj.vertex_groups)
    others = _attributes_that_are_uv_maps(needs, groups)

    # Importers name the UV map even where there is but one: it shall not be there twice.
    foreign = {name for mesh, need in needs.items() for name in need.uv_maps | need.tangents if name != _active(mesh)}
    named = {name for need in asked for name in need.uv_maps | need.tangents} | others
    named |= {name for draft in drafts for name in draft.layers('tangent')}
    named.discard('')
    aliases = frozenset(named - foreign)
    for need in needs.values():
        need.uv_maps = {'' if name in aliases else name for name in need.uv_maps}
        need.tangents = {'' if name in aliases else name for name in need.tangents}
    tangents = {name for need in asked for name in need.tangents}
    tangents |= {name for draft in drafts for name in draft.layers('tangent')}
    tangents = {'' if name in aliases else name for name in tangents}
    uv_layers = ('', *sorted(named - aliases))
    rest = {name for draft in drafts for name in draft.layers('layer')} - aliases - set(uv_layers)
    of_instances = sorted(name for name in rest if is_of_instance(name))
    of_meshes = sorted(rest.difference(of_instances))
    first = len(uv_layers) + len(of_meshes)
    uses = frozenset().union(*(draft.uses for draft in drafts))
    return Layers(
        uv_layers=uv_layers,
        tangent_layers=tuple(index for index, name in enumerate(uv_layers) if name in tangents),
        aliases=aliases,
        needs=needs,
        attribute_layers=(*uv_layers, *of_meshes, *of_instances),
        instance_layers=tuple(range(first, first + len(of_instances))),
        object_info=bool(uses & READ_OBJECT_INFO),
    )


def _needs_of(draft: Draft) -> Needs:
    """What a shader asks for; whether an attribute is a UV map is found out when all are there."""
    return Needs(
        tangents=draft.layers('tangent'),
        attributes={name for name in draft.layers('layer') if not is_of_instance(name)},
        generated=bool(draft.uses & READ_GENERATED),
    )


def _attributes_that_are_uv_maps(needs: dict[bpy.types.Mesh, Needs], groups: set[str]) -> set[str]:
    """Move attributes that are UV maps of all meshes that have them to `uv_maps`; returns their names.

    groups: names of vertex groups, which are attributes as well.
    """
    names = {name for need in needs.values() for name in need.attributes}
    mixed = names & groups
    for mesh, need in needs.items():
        maps = {layer.name for layer in mesh.uv_layers}
        mixed |= {name for name in need.attributes - maps if name and (name[0] == '\x01' or name in mesh.attributes)}
    found = names - mixed
    for need in needs.values():
        need.uv_maps |= need.attributes & found
        need.attributes -= found
    return found


def _active(mesh: bpy.types.Mesh) -> str | None:
    return next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
