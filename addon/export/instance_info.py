# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders ask of instances: colour and random number, particles, properties of objects and instancers.

Which instances there are is instances.py's; nothing is read that no shader asks for.
"""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from .attributes import INSTANCER_GENERATED, INSTANCER_UV, instance_value, object_random, unit_hash
from .buffers import F32, I32, InstanceInfo, InstanceParticles, Instances
from .instances import Walk
from .layers import Layers


def with_info(objects: Instances, walk: Walk, items: I32, layers: Layers, depsgraph: bpy.types.Depsgraph) -> Instances:
    """The instances with what the shaders ask for. items: (I,) which of the walk's instances they are."""
    info = _object_info(walk, items, depsgraph) if layers.object_info else None
    particles = _particles(len(walk.group_of), items, depsgraph) if layers.particles else None
    attributes = _attributes(walk, items, layers, depsgraph) if layers.instance_layers else None
    return replace(objects, info=info, particles=particles, attributes=attributes)


def _object_info(walk: Walk, items: I32, depsgraph: bpy.types.Depsgraph) -> InstanceInfo:
    group_of = walk.group_of[items]
    colors = np.array([group.obj.color for group in walk.groups], np.float32).reshape(-1, 4)[group_of]
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
    for values, index in zip(found, layers.instance_layers, strict=True):
        layer = layers.attribute_layers[index]
        if layer == INSTANCER_UV:
            values[:, :2] = _of_items(depsgraph, 'uv', 2, items) * is_instance[:, None]
            values[:, 3] = 1.0
        elif layer == INSTANCER_GENERATED:
            values[:, :3] = (_of_items(depsgraph, 'orco', 3, items) * 0.5 + 0.5) * is_instance[:, None]
            values[:, 3] = 1.0
        else:
            of_groups = [instance_value(layer, group.obj, group.parent) for group in walk.groups]
            values[:] = np.array(of_groups, np.float32).reshape(-1, 4)[group_of]
    return found


def _of_items(depsgraph: bpy.types.Depsgraph, name: str, width: int, items: I32) -> F32:
    values = np.empty((len(depsgraph.object_instances), width), np.float32)
    depsgraph.object_instances.foreach_get(name, values.ravel())
    return np.nan_to_num(values)[items]


def _particles(count: int, items: I32, depsgraph: bpy.types.Depsgraph) -> InstanceParticles:
    numbers = np.zeros((count, 5), np.float32)
    vectors = np.zeros((count, 3, 3), np.float32)
    frame = depsgraph.scene.frame_current_final
    for at, item in enumerate(depsgraph.object_instances):
        system = item.particle_system
        if system is None:
            continue
        index = item.persistent_id[0]
        if not 0 <= index < len(system.particles):
            continue
        particle = system.particles[index]
        random = float(unit_hash(np.array([index], np.uint32), 0)[0])
        numbers[at] = index, random, frame - particle.birth_time, particle.lifetime, particle.size
        vectors[at] = particle.location, particle.velocity, particle.angular_velocity
    numbers, vectors = np.nan_to_num(numbers[items]), np.nan_to_num(vectors[items])
    columns = [np.ascontiguousarray(numbers[:, column]) for column in range(5)]
    return InstanceParticles(*columns, *(np.ascontiguousarray(vectors[:, column]) for column in range(3)))
