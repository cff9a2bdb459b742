# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking and shadow linking: which lights light which objects, and which objects shadow them, as bit masks.

Objects that are lit by the same lights make a set, and so do those that shadow the same (as Cycles has it): a light
names sets, an object one of them. Set 0 is lit, or shadows, wherever nothing is linked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import numpy as np

from ..log import Log
from .buffers import I32, U32, Linking
from .instances import Group

LIGHT_SETS = 64  # of Cycles
SHADOW_SETS = 24  # each is a bit of the masks of rays
Membership = Callable[[Group], bool]


@dataclass(frozen=True, slots=True)
class _Sets:
    """of: (G,) set of each group; masks: (G,) uint64, the sets that each group's light names."""

    of: U32
    masks: np.ndarray


@dataclass(frozen=True, slots=True)
class GroupLinks:
    """Linking of the G groups of a depsgraph."""

    light: _Sets
    shadow: _Sets

    def arrays(self, lights: I32, instances: I32) -> Linking:
        """For lights and instances whose groups are given, by index."""
        both = np.concatenate((lights, instances))
        return Linking(
            receiver=self.light.of[instances],
            blocker=self.shadow.of[instances],
            light_sets=np.ascontiguousarray(self.light.masks[both]).view(np.uint32).reshape(-1, 2),
            shadow_sets=self.shadow.masks[both].astype(np.uint32),
        )


def read_links(groups: list[Group], log: Log) -> GroupLinks | None:
    """None where no light is linked."""
    receivers = [_collection(group, 'receiver_collection') for group in groups]
    blockers = [_collection(group, 'blocker_collection') for group in groups]
    if not any(receivers) and not any(blockers):
        return None
    return GroupLinks(
        _sets(groups, receivers, LIGHT_SETS, 'light linking', log),
        _sets(groups, blockers, SHADOW_SETS, 'shadow linking', log),
    )


def _collection(group: Group, name: str) -> bpy.types.Collection | None:
    """Of the object itself: what its instancer links is of no effect, as in Cycles."""
    if not isinstance(group.data, bpy.types.Light | bpy.types.Mesh):
        return None
    return getattr(group.obj.original.light_linking, name)


def _sets(groups: list[Group], collections: list[bpy.types.Collection | None], most: int, what: str, log: Log) -> _Sets:
    """What groups belong to which set, and what sets the collection of each group's light asks for."""
    distinct = list(dict.fromkeys(collection for collection in collections if collection is not None))
    members = [_members(collection) for collection in distinct]
    numbers: dict[tuple[bool, ...], int] = {(True,) * len(distinct): 0}
    of = np.zeros(len(groups), np.uint32)
    for index, group in enumerate(groups):
        pattern = tuple(belongs(group) for belongs in members)
        number = numbers.setdefault(pattern, len(numbers))
        if number >= most:
            log.warning(
                f'Object "{group.obj.name}": {what} knows {most} kinds of objects: it is one as if never linked'
            )
            number = 0
        of[index] = number
    patterns = list(numbers)[:most]
    masks = {None: (1 << 64) - 1}
    for place, collection in enumerate(distinct):
        masks[collection] = sum(1 << number for number, pattern in enumerate(patterns) if pattern[place])
    return _Sets(of, np.array([masks[collection] for collection in collections], np.uint64))


def _members(collection: bpy.types.Collection) -> Membership:
    """Whether a group is in. What a collection does not name is in where it includes nothing.

    Objects of a child collection take that collection's state; what the collection itself says of an object holds. An
    object that is not named is in as its instancer is.
    """
    states: dict[bpy.types.Object, bool] = {}
    for entry, child in zip(collection.collection_children, collection.children, strict=True):
        for obj in child.all_objects:
            states[obj] = entry.light_linking.link_state == 'INCLUDE'
    for entry, obj in zip(collection.collection_objects, collection.objects, strict=True):
        states[obj] = entry.light_linking.link_state == 'INCLUDE'
    otherwise = not any(states.values())

    def belongs(group: Group) -> bool:
        own = states.get(group.obj.original)
        return states.get(group.parent.original, otherwise) if own is None else own

    return belongs
