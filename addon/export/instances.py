# SPDX-License-Identifier: GPL-3.0-or-later
"""What the depsgraph shows: groups of instances that differ in nothing but their transforms, and which rays see them.

There are few groups and many instances, so Python's work for an instance is one look into a dictionary.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ..log import Log
from .buffers import (
    F32,
    I32,
    VISIBLE_CAMERA,
    VISIBLE_DIFFUSE,
    VISIBLE_GLOSSY,
    VISIBLE_RAYCAST,
    VISIBLE_SHADOW,
    VISIBLE_TRANSMISSION,
    VISIBLE_VOLUME,
)

# Object data that need primitives of their own.
UNSUPPORTED = {'Curves': 'hair curves', 'PointCloud': 'point clouds', 'Volume': 'volumes'}


@dataclass(frozen=True, slots=True)
class Group:
    """Instances of one object with one data, made by one instancer.

    obj:    the object that is shown (for geometry nodes the object that carries the modifier).
    data:   what it shows: not always `obj.data`, which for curves is the curve and not its mesh.
    parent: the instancer; `obj` itself where it stands in the scene on its own.
    """

    obj: bpy.types.Object
    data: bpy.types.ID
    parent: bpy.types.Object
    is_instance: bool
    show_self: bool
    show_particles: bool


@dataclass(frozen=True, slots=True)
class Walk:
    """All instances of a depsgraph, N of them.

    group_of:   (N,) index into groups, -1 for objects without data (empties).
    transforms: (N, 3, 4) object-to-world.
    """

    groups: list[Group]
    group_of: I32
    transforms: F32


def walk(depsgraph: bpy.types.Depsgraph, space: bpy.types.SpaceView3D | None = None) -> Walk:
    """Read all instances. The items of the collection are gone after each step, what they point to is not.

    space: the 3D viewport that they are for: what its local view or its collections hide is taken as without data.
    """
    index: dict[tuple, int] = {}
    groups: list[Group] = []
    group_of: list[int] = []
    collection = depsgraph.object_instances
    for item in collection:
        shown = item.object
        data = shown.data
        if data is None or not (space is None or shown.visible_in_viewport_get(space)):
            group_of.append(-1)
            continue
        # `object` of an instance is a passing copy; `instance_object` is None for what is no instance.
        original = item.instance_object
        key = (shown, data) if original is None else (original, data, item.parent)
        at = index.get(key)
        if at is None:
            at = index[key] = len(groups)
            obj, parent = (shown, shown) if original is None else (original, item.parent or original)
            groups.append(Group(obj, data, parent, original is not None, item.show_self, item.show_particles))
        group_of.append(at)
    matrices = np.empty((len(group_of), 4, 4), np.float32)
    if group_of:
        collection.foreach_get('matrix_world', matrices.ravel())
    # Blender's matrices come by columns.
    return Walk(groups, np.array(group_of, np.int32), matrices.transpose(0, 2, 1)[:, :3])


def visibility(group: Group, view_layer: bpy.types.ViewLayer) -> int:
    """VISIBLE_* bits: what both object and instancer allow; 'indirect only' collections are hidden from the camera.

    Raycast nodes meet every mesh that any ray of a path sees, and no other: what the object's own switch for them says,
    Cycles 5.2.3 does not ask.
    """
    bits = _own_visibility(group.obj)
    if group.parent != group.obj:
        bits &= _own_visibility(group.parent)
    if group.parent.indirect_only_get(view_layer=view_layer):
        bits &= ~VISIBLE_CAMERA
    return bits | VISIBLE_RAYCAST if bits and not isinstance(group.data, bpy.types.Light) else bits


def _own_visibility(obj: bpy.types.Object) -> int:
    return (
        obj.visible_camera * VISIBLE_CAMERA
        | obj.visible_diffuse * VISIBLE_DIFFUSE
        | obj.visible_glossy * VISIBLE_GLOSSY
        | obj.visible_transmission * VISIBLE_TRANSMISSION
        | obj.visible_volume_scatter * VISIBLE_VOLUME
        | obj.visible_shadow * VISIBLE_SHADOW
    )


def light_group(group: Group, groups: dict[str, int]) -> int:
    """Index of the light group, -1 for none: the object's own, else that of its instancer."""
    return groups.get(group.obj.lightgroup or group.parent.lightgroup, -1)


def is_shown(group: Group) -> bool:
    """Whether a mesh or lamp of this group is to be rendered as such."""
    return group.show_self and not _gas_domain(group)


def warn_unsupported(group: Group, view_layer: bpy.types.ViewLayer, log: Log) -> None:
    """Name what this group would show in Cycles and does not show here."""
    name = group.obj.name
    kind = UNSUPPORTED.get(type(group.data).__name__)
    if kind and group.show_self:
        log.warning(f'Object "{name}": {kind} are not supported yet: left out')
    if _gas_domain(group):
        log.warning(f'Object "{name}": smoke and fire are not supported yet: left out')
    if group.show_particles and not group.is_instance:
        for system in group.obj.particle_systems:
            if system.settings.type == 'HAIR' and system.settings.render_type == 'PATH':
                log.warning(f'Object "{name}": hair of particle system "{system.name}" is not supported yet: left out')
    if not isinstance(group.data, bpy.types.Mesh):
        return
    if group.parent.holdout_get(view_layer=view_layer):
        log.warning(f'Object "{name}": holdout is not supported yet: it is rendered as an ordinary object')
    if group.obj.is_shadow_catcher or group.parent.is_shadow_catcher:
        log.warning(f'Object "{name}": shadow catcher is not supported yet: it is rendered as an ordinary object')


def _gas_domain(group: Group) -> bool:
    for modifier in group.obj.modifiers:
        if modifier.type == 'FLUID' and modifier.fluid_type == 'DOMAIN':
            return modifier.domain_settings.domain_type == 'GAS' and group.data == group.obj.data
    return False
