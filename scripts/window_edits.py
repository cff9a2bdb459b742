# SPDX-License-Identifier: GPL-3.0-or-later
"""three_lights and a mesh of 16,200 triangles in one viewport of 960×540, and the kinds of edit that are made there.

Each kind goes to and fro between two states, which can be told from each other in the picture. Runs in Blender.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable

import bpy
import numpy as np
from mathutils import Quaternion

from window_inside import EXTENSION, areas, region, scene, window, within

SIZE = 960, 540
SEGMENTS = 90  # of the mesh that is edited, along a side: 2 × 90² triangles
LEVELS = 2  # of subdivision: 472,320 triangles, as in the demo's final render
FRAMES = 1, 11


def build() -> None:
    """The scene, in place of what the file has."""
    for obj in list(scene().objects):
        bpy.data.objects.remove(obj)
    importlib.import_module(f'{EXTENSION}.demos.three_lights').build(scene())
    for obj in monkeys():
        obj.modifiers['Subdivision'].levels = LEVELS
    mesh = bpy.data.meshes.new('Edited')
    side = np.linspace(-2.0, 2.0, SEGMENTS + 1)
    corners = np.arange(SEGMENTS) + (SEGMENTS + 1) * np.arange(SEGMENTS)[:, None]
    faces = (corners[..., None] + [0, 1, SEGMENTS + 2, SEGMENTS + 1]).reshape(-1, 4)
    x, y = np.meshgrid(side, side)
    mesh.from_pydata(np.stack([x, y, 0.0 * x], -1).reshape(-1, 3).tolist(), [], faces.tolist())
    edited = bpy.data.objects.new('Edited', mesh)
    edited.location = (-1.0, -4.0, 1.0)
    scene().collection.objects.link(edited)
    scene().cycles.preview_samples = 1024


def arrange() -> bpy.types.Area:
    """The one 3D viewport that is left, as nearly of SIZE as the window lets it, without overlays.

    No editor stays that has previews rendered: setting the engine while one is at work locks Blender up.
    """
    for axis, direction in enumerate(('VERTICAL', 'HORIZONTAL')):
        area = max(areas(), key=_pixels)
        for other in window().screen.areas:
            if other != area and other.type in ('VIEW_3D', 'PROPERTIES'):
                other.type = 'TEXT_EDITOR'
        space = area.spaces.active
        space.show_region_toolbar = space.show_region_ui = space.show_region_tool_header = False
        size = (area.width, area.height)[axis]
        wanted = SIZE[axis] + size - (region(area).width, region(area).height)[axis]
        if size > wanted:
            with within(area):
                bpy.ops.screen.area_split(direction=direction, factor=wanted / size)
    area = min(areas(), key=_misfit)
    for other in areas():
        if other != area:
            other.type = 'TEXT_EDITOR'
    space = area.spaces.active
    space.overlay.show_overlays = space.show_gizmo = False
    space.region_3d.view_perspective = 'CAMERA'
    bpy.context.view_layer.update()
    camera = scene().camera.matrix_world
    space.region_3d.view_perspective = 'PERSP'
    space.region_3d.view_matrix = camera.inverted()
    return area


def _pixels(area: bpy.types.Area) -> int:
    return area.width * area.height


def _misfit(area: bpy.types.Area) -> int:
    return abs(area.width - SIZE[0]) + abs(area.height - SIZE[1])


def monkeys() -> list[bpy.types.Object]:
    return [obj for obj in scene().objects if obj.name.startswith('Monkey')]


# ---- Kinds of edit, each from one state (0) to another (1) and back

KINDS: dict[str, Callable[[int], None]] = {}


def kind(name: str) -> Callable[[Callable[[int], None]], Callable[[int], None]]:
    def register(function: Callable[[int], None]) -> Callable[[int], None]:
        KINDS[name] = function
        return function

    return register


@kind('camera')
def turn_view(state: int) -> None:
    view = areas()[0].spaces.active.region_3d
    turned = Quaternion((0.0, 0.0, 1.0), math.radians((0.0, 20.0)[state]))
    view.view_rotation = turned @ scene().camera.matrix_world.to_quaternion()


@kind('light')
def color_light(state: int) -> None:
    bpy.data.objects['Sun'].data.color = ((1.0, 0.2, 0.1), (0.1, 0.4, 1.0))[state]


@kind('material')
def color_material(state: int) -> None:
    nodes = bpy.data.materials['Ground'].node_tree.nodes
    principled = next(node for node in nodes if node.type == 'BSDF_PRINCIPLED')
    principled.inputs['Base Color'].default_value = ((0.6, 0.1, 0.1, 1.0), (0.1, 0.1, 0.6, 1.0))[state]


@kind('object')
def move_object(state: int) -> None:
    bpy.data.objects['Monkey 9'].location.z = (0.98, 4.0)[state]


@kind('mesh')
def shape_mesh(state: int) -> None:
    found = bpy.data.objects['Edited'].data
    points = np.empty(3 * len(found.vertices), np.float32)
    found.vertices.foreach_get('co', points)
    points[2::3] = (0.0, 1.5)[state] * np.cos(2.0 * points[0::3]) * np.cos(2.0 * points[1::3])
    found.vertices.foreach_set('co', points)
    found.update()


@kind('frame')
def change_frame(state: int) -> None:
    """Thirty objects move: they get their keys where they have none yet."""
    if monkeys()[0].animation_data is None:
        for obj in monkeys():
            for at, height in zip(FRAMES, (0.98, 3.0), strict=True):
                obj.location.z = height
                obj.keyframe_insert('location', index=2, frame=at)
    scene().frame_set(FRAMES[state])


def forget_keys() -> None:
    """Objects stand where they stood."""
    for obj in monkeys():
        obj.animation_data_clear()
        obj.location.z = 0.98
