# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's depsgraph to the arrays of buffers.py: the only part of Cotorra that reads the objects of a scene.

What it keeps between two calls is in addon/sync/, and no Blender object leaves it.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import bpy
import numpy as np

from .. import cycles_settings
from ..lamps import lone_lamp
from ..log import Log
from ..sync.kept import Kept
from . import camera, far, instance_info, instances, layers, lights, linking, materials, shapes, studio, world
from .buffers import I32, Camera, SceneBuffers
from .images import ImageTable
from .nodes import Trees
from .shaders import ShaderTable


def export_camera(
    scene: bpy.types.Scene,
    camera_object: bpy.types.Object | None,
    log: Log,
    region: tuple[int, int, int, int] | None = None,
) -> Camera | None:
    """The camera of an evaluated scene; None, with an error in the log, where there is none that can be used.

    region: x0, y0, width, height in pixels; by default the render border, or everything.
    """
    if camera_object is None:
        log.error(f'Scene "{scene.name}" has no camera')
        return None
    return camera.read_camera(scene, camera_object, log, region)


def export_scene(
    depsgraph: bpy.types.Depsgraph,
    engine_scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    log: Log,
    space: bpy.types.SpaceView3D | None = None,
    kept: Kept | None = None,
) -> SceneBuffers:
    """Everything that one view layer shows. `engine_scene` is the depsgraph's evaluated scene.

    space: the 3D viewport that shows it, which may leave out objects and lamps.
    kept:  what earlier exports left, which is not read again; it was told what has changed.
    """
    kept = kept or Kept()
    executor = ThreadPoolExecutor(image_threads(engine_scene), 'cotorra images')
    failed: dict[tuple, str] = {}
    try:
        while True:
            known, frame = kept.images, engine_scene.frame_current
            images = known.for_next(log, frame, executor) if known else ImageTable(log, frame, executor, failed)
            if images is not known:
                kept.forget_images()  # shaders have numbers of images
                kept.images = images
            found = _export(depsgraph, engine_scene, view_layer, images, space, kept)
            if images.finish():
                return replace(found, images=tuple(images.images))
            failed = images.failed
            kept.forget_images()
    except BaseException:
        kept.forget_images()  # some may lack their pixels
        raise
    finally:
        executor.shutdown(wait=False, cancel_futures=True)


def image_threads(scene: bpy.types.Scene) -> int:
    """How many files are decoded at once: as many as the render has threads, while this one reads the scene."""
    return scene.render.threads if scene.render.threads_mode == 'FIXED' else os.cpu_count() or 1


def _export(
    depsgraph: bpy.types.Depsgraph,
    engine_scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    images: ImageTable,
    space: bpy.types.SpaceView3D | None,
    kept: Kept,
) -> SceneBuffers:
    """All but the images, whose pixels may come later."""
    log = images.log
    kept.begin()
    trees = Trees(log.checkpoint)
    light_groups = {group.name: index for index, group in enumerate(view_layer.lightgroups)}
    walk = instances.walk(depsgraph, space)
    lit = space is None or space.shading.use_scene_lights_render
    log.checkpoint()

    # What each group is: a lamp, or a mesh with its materials, or nothing.
    shaders = ShaderTable(log, trees, images, engine_scene, depsgraph.view_layer_eval, kept)
    table = materials.MaterialTable(log, shaders)
    lamps: list[lights.Lamp] = []
    found: list[shapes.Shape] = []
    lamp_of_group = np.full(len(walk.groups), -1, np.int32)
    shape_of_group = np.full(len(walk.groups), -1, np.int32)
    evaluated_layer = depsgraph.view_layer_eval
    for index, group in enumerate(walk.groups):
        instances.warn_unsupported(group, evaluated_layer, log)
        cycles_settings.warn_object(group.obj, group.parent, engine_scene, log)
        if not instances.is_shown(group):
            continue
        visibility = instances.visibility(group, evaluated_layer)
        group_of_lights = instances.light_group(group, light_groups)
        if isinstance(group.data, bpy.types.Light):
            if not lit:
                continue
            lamp = lights.read_lamp(group.obj, visibility, group_of_lights, log, shaders)
            if lamp is not None:
                lamp_of_group[index] = len(lamps)
                lamps.append(lamp)
        elif isinstance(group.data, bpy.types.Mesh) and visibility and view_layer.use_solid:
            shape_of_group[index] = len(found)
            found.append(shapes.read_shape(group, visibility, group_of_lights, view_layer.material_override, table))

    # The arrays.
    background = world.read_world(engine_scene, view_layer, light_groups, log, shaders, studio.read_studio(space))
    needed = layers.plan(found, shaders.drafts, [row.shader for row in table.rows])
    meshes = shapes.read_meshes(found, needed, log, kept)
    shown, shape_of = _members(walk.group_of, shape_of_group)
    shining, lamp_of = _members(walk.group_of, lamp_of_group)
    objects, items = shapes.instance_arrays(found, meshes, shape_of, walk.transforms[shown], table, log)
    far.warn_far(objects, meshes.arrays, log)
    objects = instance_info.with_info(objects, walk, shown[items], needed, depsgraph)
    surfaces, slots = materials.material_arrays(table, engine_scene)
    links = linking.read_links(walk.groups, log)
    if links is not None and engine_scene.cotorra.integrator == 'TOON':
        log.warning(f'Scene "{engine_scene.name}": Toon leaves out light linking: lights light all objects there')
    shining, lamp_of = lights.usable(lamps, walk.transforms, shining, lamp_of, log)
    kept.end()
    return SceneBuffers(
        meshes=tuple(meshes.arrays),
        instances=objects,
        materials=surfaces,
        material_slots=slots,
        lights=lights.light_arrays(lamps, walk.transforms[shining], lamp_of, view_layer, lone_lamp(space)),
        world=background,
        light_groups=tuple(light_groups),
        uv_layers=needed.uv_layers,
        tangent_layers=needed.tangent_layers,
        shaders=shaders.resolved(needed.numbers),
        attribute_layers=needed.attribute_layers,
        instance_layers=needed.instance_layers,
        linking=links and links.arrays(walk.group_of[shining], walk.group_of[shown[items]]),
    )


def _members(group_of: I32, number_of_group: I32) -> tuple[I32, I32]:
    """The instances whose group has a number (a shape's or a lamp's), and that number for each."""
    numbers = np.append(number_of_group, np.int32(-1))[group_of]  # group -1, objects without data, has none
    chosen = np.flatnonzero(numbers >= 0)
    return chosen, numbers[chosen]
