# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of Blender data with much in it, for tests that compare two ways to render the same.

It shows nothing that anyone would look for.
"""

from __future__ import annotations

import bpy
import numpy as np

from . import build


def rich_scene(lamps: int) -> bpy.types.Scene:
    """What the demos lack: light groups, an emitter, instances, a mirror, UV maps, lamps without and with a size."""
    scene = build.new_scene()
    camera = build.camera(scene)
    camera.location, camera.rotation_euler = (0.0, -5.0, 3.0), (1.05, 0.0, 0.0)
    for name in ('Lamps', 'Emitter'):
        bpy.context.view_layer.lightgroups.add(name=name)
    build.world(scene, (0.2, 0.3, 0.5), 0.5)
    floor = build.link(scene, 'Floor', build.grid(8))
    floor.scale = (6.0, 6.0, 1.0)
    floor.location = (-3.0, -3.0, 0.0)
    floor.data.materials.append(build.material('Matte', Base_Color=(0.6, 0.5, 0.4, 1.0), Roughness=0.6))
    mirror = build.mesh_object(scene, 'Mirror')
    mirror.location, mirror.rotation_euler = (0.3, 1.2, 0.9), (1.2, 0.2, 0.0)
    mirror.data.materials.append(build.material('Mirror', Metallic=1.0, Roughness=0.0))
    glow = build.mesh_object(scene, 'Glow')
    glow.location, glow.rotation_euler, glow.scale = (-1.6, 0.0, 1.2), (0.3, 1.9, 0.0), (0.4, 0.3, 1.0)
    glow.data.materials.append(build.material('Glow', Emission_Color=(1.0, 0.6, 0.2, 1.0), Emission_Strength=8.0))
    glow.lightgroup = 'Emitter'
    shown = build.mesh_object(scene, 'Tile')
    shown.scale = (0.15, 0.15, 0.15)
    shown.data.materials.append(build.material('Plastic', Base_Color=(0.1, 0.5, 0.2, 1.0), Roughness=0.2))
    points = np.stack(np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 4), [0.25]), axis=-1).reshape(-1, 3)
    parent = build.vertex_instances(scene, shown, points)
    parent.rotation_euler = (0.1, 0.2, 0.5)
    for index in range(lamps):
        lamp = build.light(scene, ('POINT', 'SPOT', 'SUN')[index % 3], energy=2.0 if index % 3 == 2 else 40.0)
        lamp.location = (3.0 * np.cos(index), 3.0 * np.sin(index), 2.5)
        lamp.rotation_euler = (0.3, 0.2 * index, 0.0)
        if index % 2:
            setattr(lamp.data, 'angle' if index % 3 == 2 else 'shadow_soft_size', 0.2)
        lamp.lightgroup = 'Lamps'
    return scene
