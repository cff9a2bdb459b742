# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders ask of instances: colour and random number, particles, properties of objects and instancers.

Which instances there are is instances.py's; nothing is read that no shader asks for.
"""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np
from numpy.typing import NDArray

from . import instance_attributes
from .attributes import (
    INSTANCER_GENERATED,
    INSTANCER_PREFIX,
    INSTANCER_UV,
    PARTICLE_LAYERS,
    Rgba,
    instance_value,
    object_random,
    property_value,
    unit_hash,
)
from .buffers import F32, I32, InstanceInfo, Instances
from .instances import Walk
from .layers import Layers


def with_info(objects: Instances, walk: Walk, items: I32, layers: Layers, depsgraph: bpy.types.Depsgraph) -> Instances:
    """The instances with what the shaders ask for. items: (I,) which of the walk's instances they are."""
    info = _object_info(walk, items, depsgraph) if layers.object_info else None
    attributes = _attributes(walk, items, layers, depsgraph) if layers.instance_layers else None
    return replace(objects, info=info, attributes=attributes)


def _object_info(walk: Walk, items: I32, depsgraph: bpy.types.Depsgraph) -> InstanceInfo:
    group_of = walk.group_of[items]
    # Blender gives an instance the colour of what made it; what stands on its own is its own instancer.
    colors = np.array([group.parent.color for group in walk.groups], np.float32).reshape(-1, 4)[group_of]
    ids = np.empty(len(walk.group_of), np.int32)
    depsgraph.object_instances.foreach_get('random_id', ids)
    own = np.array([object_random(group.obj.name) for group in walk.groups], np.uint32)[group_of]
    is_instance = np.array([group.is_instance for group in walk.groups], bool)[group_of]
    random = np.where(is_instance, ids.view(np.uint32)[items], own) / np.float64(0xFFFFFFFF)
    return InstanceInfo(np.nan_to_num(colors), random.astype(np.float32))


def _attributes(walk: Walk, items: I32, layers: Layers, depsgraph: bpy.types.Depsgraph) -> F32:
    found = np.zeros((len(layers.instance_layers), len(items), 4), np.float32)
    group_of = walk.group_of[items]
    is_instance = np.array([group.is_instance for group in walk.groups], bool)[group_of]
    asked = {layers.attribute_layers[index] for index in layers.instance_layers}
    particles = _particles(depsgraph)[:, items] if asked.intersection(PARTICLE_LAYERS) else None
    names = [layer.removeprefix(INSTANCER_PREFIX) for layer in asked if layer.startswith(INSTANCER_PREFIX)]
    before = _before_properties(depsgraph, walk, items, names) if names else {}
    for values, index in zip(found, layers.instance_layers, strict=True):
        layer = layers.attribute_layers[index]
        if layer == INSTANCER_UV:
            values[:, :2] = _of_items(depsgraph, 'uv', 2, items) * is_instance[:, None]
            values[:, 3] = 1.0
        elif layer == INSTANCER_GENERATED:
            values[:, :3] = (_of_items(depsgraph, 'orco', 3, items) * 0.5 - 0.5) * is_instance[:, None]  # as in Cycles
            values[:, 3] = 1.0
        elif layer in PARTICLE_LAYERS:
            values[:] = particles[PARTICLE_LAYERS.index(layer)]
        else:
            of_groups = [instance_value(layer, group.obj, group.parent) for group in walk.groups]
            values[:] = np.array(of_groups, np.float32).reshape(-1, 4)[group_of]
            if layer.startswith(INSTANCER_PREFIX):
                for found_values, known in before[layer.removeprefix(INSTANCER_PREFIX)]:
                    values[known] = found_values[known]
    return found


def _before_properties(
    depsgraph: bpy.types.Depsgraph, walk: Walk, items: I32, names: list[str]
) -> dict[str, list[tuple[F32, NDArray[np.bool_]]]]:
    """What counts before properties of instancer and object, the last one most: values, and where there are some."""
    found = {name: [pair] for name, pair in instance_attributes.read(depsgraph, walk, items, names).items()}
    of_system: dict[tuple, Rgba | None] = {}
    values = {name: np.zeros((len(walk.group_of), 4), np.float32) for name in names}
    known = {name: np.zeros(len(walk.group_of), bool) for name in names}
    if not any(group.parent.particle_systems for group in walk.groups if group.is_instance):
        return found
    for at, item in enumerate(depsgraph.object_instances):
        system = item.particle_system
        if system is None:
            continue
        for name in names:
            key = (system.settings, name)
            if key not in of_system:
                of_system[key] = property_value(system.settings, name)
            value = of_system[key]
            if value is not None:
                values[name][at], known[name][at] = np.nan_to_num(value, posinf=0.0, neginf=0.0), True
    for name in names:
        found[name].append((values[name][items], known[name][items]))
    return found


def _of_items(depsgraph: bpy.types.Depsgraph, name: str, width: int, items: I32) -> F32:
    values = np.empty((len(depsgraph.object_instances), width), np.float32)
    depsgraph.object_instances.foreach_get(name, values.ravel())
    return np.nan_to_num(values)[items]


def _particles(depsgraph: bpy.types.Depsgraph) -> F32:
    """(4, count, 4): PARTICLE_LAYERS of all instances; ages are frames, all else is of world space.

    What no particle made is particle 0 of no system to Cycles: all is 0 but its random number.
    """
    found = np.zeros((4, len(depsgraph.object_instances), 4), np.float32)
    found[0, :, 1] = _random(0)
    frame = depsgraph.scene.frame_current_final
    for at, item in enumerate(depsgraph.object_instances):
        system = item.particle_system
        if system is None:
            continue
        index = item.persistent_id[0]
        if not 0 <= index < len(system.particles):
            continue
        particle = system.particles[index]
        found[0, at] = index, _random(index), frame - particle.birth_time, particle.lifetime
        found[1, at] = *particle.location, particle.size
        found[2, at, :3], found[3, at, :3] = particle.velocity, particle.angular_velocity
    return np.nan_to_num(found)


def _random(index: int) -> float:
    """Of a particle, as Cycles hashes its number."""
    return float(unit_hash(np.array([index], np.uint32), 0)[0])
