# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of the instances that geometry nodes make, as the node Attribute finds them by its type Instancer.

Of nested instances the innermost that has the attribute counts. Properties of objects are attributes.py's.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import bpy
import numpy as np
from numpy.typing import NDArray

from .attributes import attribute_values
from .buffers import F32, I32
from .instances import Walk

NO_LEVEL = 2**31 - 1  # fills up persistent numbers
NOT_FOUND = -1


@dataclass(slots=True)
class Made:
    """The instances of one geometry: where each shows what, and their attributes.

    references: what is instanced, and reference: (n,) which of it.
    ids:        (n,) by which the depsgraph's items know them.
    """

    references: list
    reference: I32
    ids: I32
    values: dict[str, F32]
    inner: dict[int, Made | None] = field(default_factory=dict)

    def places(self, asked: I32) -> I32:
        """The instance of each id. Ids that stand there twice are made new ones by Blender, which keep their order."""
        known, first = np.unique(self.ids, return_index=True)
        at = np.searchsorted(known, asked).clip(0, len(known) - 1)
        found = np.where(known[at] == asked, first[at], NOT_FOUND).astype(np.int32)
        strange = np.flatnonzero(found == NOT_FOUND)
        again = np.setdiff1d(np.arange(len(self.ids)), first)
        order: dict[int, int] = {}
        for number in asked[strange].tolist():
            order.setdefault(number, len(order))
        if len(order) == len(again):
            found[strange] = [again[order[number]] for number in asked[strange].tolist()]
        return found


@dataclass(slots=True)
class Reading:
    """Values by name that are being gathered, (I, 4) each, and which instances have one."""

    names: tuple[str, ...]
    values: dict[str, F32]
    known: dict[str, NDArray[np.bool_]]
    made: dict[bpy.types.Object, Made | None] = field(default_factory=dict)

    def of_object(self, obj: bpy.types.Object) -> Made | None:
        if obj not in self.made:
            self.made[obj] = _made(_geometry(obj), self.names)
        return self.made[obj]


def read(
    depsgraph: bpy.types.Depsgraph, walk: Walk, items: I32, names: Iterable[str]
) -> dict[str, tuple[F32, NDArray[np.bool_]]]:
    """Values (I, 4) of each name for the walk's instances `items`, and for which of them there is one."""
    names = tuple(names)
    count = len(items)
    reading = Reading(
        names,
        {name: np.zeros((count, 4), np.float32) for name in names},
        {name: np.zeros(count, bool) for name in names},
    )
    group_of = walk.group_of[items]
    makers = {index for index in np.unique(group_of).tolist() if walk.groups[index].is_instance}
    if not any(_makes(walk.groups[index], reading) for index in makers):
        return {name: (reading.values[name], reading.known[name]) for name in names}
    numbers = np.empty((len(walk.group_of), 8), np.int32)
    depsgraph.object_instances.foreach_get('persistent_id', numbers.ravel())
    numbers = numbers[items]
    for index in makers:
        group = walk.groups[index]
        members = np.flatnonzero(group_of == index)
        levels, depth = _levels(numbers[members])
        outer, own = reading.of_object(group.parent), reading.of_object(group.obj)
        if outer is not None:
            _gather(reading, outer, members, levels, depth, 0)
        elif own is not None:  # within an instance of a collection, whose object is the first level
            _gather(reading, own, members, levels, depth, 1)
    return {name: (reading.values[name], reading.known[name]) for name in names}


def _makes(group: object, reading: Reading) -> bool:
    return reading.of_object(group.parent) is not None or reading.of_object(group.obj) is not None


def _levels(numbers: I32) -> tuple[I32, I32]:
    """Persistent numbers with the outermost first, and how many each instance has."""
    depth = (numbers != NO_LEVEL).sum(axis=1).astype(np.int32)
    at = depth[:, None] - 1 - np.arange(numbers.shape[1])[None]
    return np.take_along_axis(numbers, at.clip(0), axis=1), depth


def _gather(reading: Reading, made: Made, members: I32, levels: I32, depth: I32, level: int) -> None:
    """Attributes of instances that `made` made, by their numbers at a level; then of what these instance in turn."""
    there = depth > level
    members, levels, depth = members[there], levels[there], depth[there]
    if not len(members):
        return
    place = made.places(levels[:, level])
    found = place != NOT_FOUND
    for name, values in made.values.items():
        reading.values[name][members[found]] = values[place[found]]
        reading.known[name][members[found]] = True
    reference = np.where(found, made.reference[place], NOT_FOUND)
    for number in np.unique(reference[found]).tolist():
        inner, is_geometry = _inner(reading, made, number)
        # The last number of what a geometry brings tells which of its parts it is.
        chosen = (reference == number) & (depth > level + (2 if is_geometry else 1))
        if inner is not None and chosen.any():
            _gather(reading, inner, members[chosen], levels[chosen], depth[chosen], level + 1)


def _inner(reading: Reading, made: Made, number: int) -> tuple[Made | None, bool]:
    """What a reference makes itself, and whether it is a geometry. Objects of collections are not told apart."""
    if not 0 <= number < len(made.references):
        return None, False
    reference = made.references[number]
    if isinstance(reference, bpy.types.Object):
        return reading.of_object(reference), False
    if isinstance(reference, bpy.types.Collection) or reference is None:
        return None, False
    if number not in made.inner:
        made.inner[number] = _made(reference, reading.names)
    return made.inner[number], True


def _geometry(obj: bpy.types.Object) -> object | None:
    """What geometry nodes made of an object; None of empties, which have none, and where Blender cannot tell."""
    try:
        return obj.evaluated_geometry()
    except (AttributeError, TypeError):
        return None


def _made(geometry: object, names: tuple[str, ...]) -> Made | None:
    """The instances of a geometry set; None where it has none."""
    points = None if geometry is None else geometry.instances_pointcloud()
    if points is None or not len(points.points):
        return None
    count = len(points.points)
    reference = _integers(points, '.reference_index', np.zeros(count, np.int32))
    ids = _integers(points, 'id', np.arange(count, dtype=np.int32))
    values = {}
    for name in names:
        found = points.attributes.get(name)
        read = None if found is None else attribute_values(found)
        if read is not None:
            values[name] = read
    return Made(list(geometry.instance_references()), reference, ids, values)


def _integers(points: bpy.types.PointCloud, name: str, otherwise: I32) -> I32:
    found = points.attributes.get(name)
    if found is None or found.data_type != 'INT' or len(found.data) != len(otherwise):
        return otherwise
    values = np.empty(len(otherwise), np.int32)
    found.data.foreach_get('value', values)
    return values
