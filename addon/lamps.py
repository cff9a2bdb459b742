# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes that show lamps one by one: which lamps a view layer has, and what their passes are called.

The names are asked for twice, when passes are registered and when a render is exported, and must be the same.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from .choices import LIGHT_PASS

PREFIX = 'Light '
NAME_BYTES = 63  # of a pass in Blender
PASSES_MAX = 64  # each takes 12 bytes a pixel
REST = PREFIX + '(others)'


def lamp_names(objects: Iterator[bpy.types.Object] | bpy.types.bpy_prop_collection) -> Iterator[str]:
    """Lamps among the objects, and in the collections that they instance; lamps of geometry nodes are not found."""
    for obj in objects:
        if obj.type == 'LIGHT':
            yield obj.name
        elif obj.instance_type == 'COLLECTION' and obj.instance_collection is not None:
            yield from lamp_names(obj.instance_collection.all_objects)


def lone_lamp(space: bpy.types.SpaceView3D | None) -> str | None:
    """Name of the lamp that a viewport shows alone; None where it shows something else."""
    own = space and space.shading.cotorra
    return own.light if own and own.render_pass == LIGHT_PASS and own.light else None


def pass_names(view_layer: bpy.types.ViewLayer) -> dict[str, str]:
    """The pass of each lamp of the view layer, by name; empty where it does not ask for them.

    A name is cut to what Blender takes, a dot, which would end it in an EXR file, becomes a line, and names that are
    then alike are numbered. Lamps beyond the number of passes share the last one.
    """
    if not view_layer.cotorra.use_pass_lights:
        return {}
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in sorted(set(lamp_names(view_layer.objects))):
        if len(taken) == PASSES_MAX - 1:
            found[name] = REST
            continue
        plain = PREFIX + name.replace('.', '_')
        unique, number = _cut(plain, ''), 1
        while unique in taken:
            number += 1
            unique = _cut(plain, f' {number}')
        taken.add(unique)
        found[name] = unique
    return found


def pass_numbers(view_layer: bpy.types.ViewLayer) -> dict[str, int]:
    """The native number of each pass."""
    return {name: number for number, name in enumerate(dict.fromkeys(pass_names(view_layer).values()))}


def _cut(text: str, end: str) -> str:
    return text.encode()[: NAME_BYTES - len(end)].decode(errors='ignore') + end
