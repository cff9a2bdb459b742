# SPDX-License-Identifier: GPL-3.0-or-later
"""What users do in Blender's window, drawn at random: edits, undo, files, views, engines.

Imported in Blender by window_soak.py, which runs them one after the other and tells what came of it.
"""

from __future__ import annotations

import math
import os
import random
from collections.abc import Callable

import bpy
import gpu
from mathutils import Quaternion

from window_inside import EXTENSION, areas, scene, window, within

chance = random.Random()  # seeded by who runs them
rendered_with = 'COTORRA'

OPERATIONS: dict[str, tuple[int, Callable[[], None]]] = {}


def operation(weight: int) -> Callable[[Callable[[], None]], Callable[[], None]]:
    """Registers what is done so many times as often as what has weight 1."""

    def register(function: Callable[[], None]) -> Callable[[], None]:
        OPERATIONS[function.__name__] = weight, function
        return function

    return register


# ---- What is at hand


def begin(seed: int, engine: str) -> None:
    """Draw from a seed, and let this engine render."""
    global rendered_with
    chance.seed(seed)
    rendered_with = engine
    start()


def start() -> None:
    """The Rendered viewport is on again, as it is in most of the time."""
    if hasattr(scene(), 'cotorra'):
        scene().render.engine = rendered_with
    for area in areas():
        area.spaces.active.shading.type = 'RENDERED'


def inside():
    """The context of one of the 3D viewports."""
    return within(chance.choice(areas()))


def pick(kind: str = '') -> bpy.types.Object | None:
    found = [obj for obj in scene().objects if not kind or obj.type == kind]
    return chance.choice(found) if found else None


def object_mode() -> None:
    if bpy.context.mode != 'OBJECT':
        with inside():
            bpy.ops.object.mode_set(mode='OBJECT')


def push(name: str) -> None:
    with inside():
        bpy.ops.ed.undo_push(message=name)


# ---- Editing


@operation(6)
def move():
    obj = pick()
    if obj is not None:
        obj.location = [chance.uniform(-4.0, 4.0) for _ in range(3)]


@operation(2)
def scale():
    obj = pick('MESH')
    if obj is not None:
        obj.scale = [chance.choice((-1.0, 0.0, 0.5, 1.0, 2.0)) for _ in range(3)]


@operation(4)
def light():
    obj = pick('LIGHT')
    if obj is not None:
        obj.data.energy = chance.choice((0.0, 10.0, 1000.0))
        obj.data.color = [chance.random() for _ in range(3)]


@operation(1)
def kind_of_light():
    obj = pick('LIGHT')
    if obj is not None:
        obj.data.type = chance.choice(('POINT', 'SUN', 'SPOT', 'AREA'))


@operation(4)
def material():
    found = chance.choice(list(bpy.data.materials) or [None])
    node = found and next((node for node in found.node_tree.nodes if node.type == 'BSDF_PRINCIPLED'), None)
    if node:
        node.inputs['Base Color'].default_value = (*[chance.random() for _ in range(3)], 1.0)
        node.inputs['Roughness'].default_value = chance.random()
        node.inputs['Alpha'].default_value = chance.choice((1.0, 0.5))
        node.inputs['Emission Strength'].default_value = chance.choice((0.0, 0.0, 2.0))


@operation(2)
def texture():
    found = chance.choice(list(bpy.data.materials) or [None])
    node = found and next((node for node in found.node_tree.nodes if node.type == 'BSDF_PRINCIPLED'), None)
    if node:
        made = found.node_tree.nodes.new(
            chance.choice(('ShaderNodeTexImage', 'ShaderNodeTexNoise', 'ShaderNodeTexChecker', 'ShaderNodeTexCoord'))
        )
        if made.bl_idname == 'ShaderNodeTexImage':
            made.image = bpy.data.images.new('Painted', 16, 16)
            made.image.generated_type = 'COLOR_GRID'
        found.node_tree.links.new(made.outputs[0], node.inputs['Base Color'])


@operation(1)
def drop_images():
    for image in list(bpy.data.images)[:2]:
        bpy.data.images.remove(image)


@operation(2)
def world():
    if scene().world is None:
        scene().world = bpy.data.worlds.new('World')
    node = next((node for node in scene().world.node_tree.nodes if node.type == 'BACKGROUND'), None)
    if node:
        node.inputs['Strength'].default_value = chance.choice((0.0, 0.5, 2.0))


@operation(1)
def no_world():
    scene().world = None


@operation(3)
def add():
    object_mode()
    if len(scene().objects) > 40:
        return
    with inside():
        chance.choice(
            (
                lambda: bpy.ops.mesh.primitive_monkey_add(location=(chance.uniform(-3, 3), 0, 0)),
                lambda: bpy.ops.mesh.primitive_uv_sphere_add(location=(0, chance.uniform(-3, 3), 0)),
                lambda: bpy.ops.object.light_add(type='POINT', location=(1, 1, 3)),
                bpy.ops.object.text_add,
                bpy.ops.object.metaball_add,
                lambda: bpy.ops.object.camera_add(location=(0, -6, 2), rotation=(1.2, 0, 0)),
            )
        )()
    obj = bpy.context.view_layer.objects.active
    if obj is not None and obj.type == 'MESH':
        obj.data.materials.append(bpy.data.materials.new('Made'))


@operation(2)
def delete():
    object_mode()
    obj = pick()
    if obj is not None and len(scene().objects) > 3:
        bpy.data.objects.remove(obj)


@operation(1)
def purge():
    bpy.ops.outliner.orphans_purge(do_local_ids=True, do_recursive=True)


@operation(2)
def modifier():
    obj = pick('MESH')
    if obj is None:
        return
    if obj.modifiers:
        obj.modifiers.clear()
    else:
        obj.modifiers.new('Array', chance.choice(('ARRAY', 'SUBSURF', 'BEVEL', 'SOLIDIFY')))


@operation(2)
def vertices():
    obj = pick('MESH')
    if obj is not None and obj.mode == 'OBJECT' and len(obj.data.vertices):
        obj.data.vertices[0].co.z += 0.5
        obj.data.update()


@operation(2)
def edit_mode():
    obj = pick('MESH')
    if obj is None or not obj.visible_get():
        return
    object_mode()
    bpy.context.view_layer.objects.active = obj
    with inside():
        bpy.ops.object.mode_set(mode='EDIT')
        bpy.ops.mesh.select_all(action='SELECT')
        bpy.ops.transform.translate(value=(0.2, 0.0, 0.0))


@operation(1)
def leave_edit_mode():
    object_mode()


@operation(1)
def sculpt():
    obj = pick('MESH')
    if obj is not None and obj.visible_get():
        object_mode()
        bpy.context.view_layer.objects.active = obj
        with inside():
            bpy.ops.object.mode_set(mode='SCULPT')


@operation(2)
def hide():
    obj = pick()
    if obj is not None:
        obj.hide_set(not obj.hide_get())


@operation(2)
def select():
    obj = pick()
    if obj is not None:
        obj.select_set(not obj.select_get())


@operation(1)
def duplicate():
    object_mode()
    if len(scene().objects) < 40:
        with inside():
            bpy.ops.object.select_all(action='SELECT')
            bpy.ops.object.duplicate(linked=True)


@operation(1)
def collection():
    made = bpy.data.collections.new('Made')
    scene().collection.children.link(made)
    obj = pick()
    if obj is not None:
        made.objects.link(obj)
    made.hide_viewport = chance.random() < 0.5


# ---- Undo and files


@operation(5)
def undo():
    with inside():
        for _ in range(chance.randint(1, 3)):
            bpy.ops.ed.undo()


@operation(3)
def redo():
    with inside():
        bpy.ops.ed.redo()


@operation(1)
def save_and_load():
    object_mode()
    path = os.path.join(bpy.app.tempdir, 'soak.blend')
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    start()


@operation(1)
def new_file():
    bpy.ops.wm.read_homefile(use_factory_startup=False)
    start()


@operation(1)
def new_scene():
    object_mode()
    if len(bpy.data.scenes) < 3:
        with inside():
            bpy.ops.scene.new(type=chance.choice(('EMPTY', 'LINK_COPY', 'FULL_COPY')))
    else:
        window().scene = chance.choice(list(bpy.data.scenes))
    start()


# ---- Views


@operation(6)
def orbit():
    view = chance.choice(areas()).spaces.active.region_3d
    view.view_rotation = Quaternion((0.0, 0.0, 1.0), chance.uniform(0.0, 2.0 * math.pi)) @ view.view_rotation
    view.view_distance = chance.uniform(3.0, 20.0)


@operation(3)
def perspective():
    space = chance.choice(areas()).spaces.active
    space.region_3d.view_perspective = chance.choice(('PERSP', 'ORTHO', 'CAMERA'))
    space.region_3d.view_camera_zoom = chance.uniform(-20.0, 60.0)


@operation(2)
def border():
    space = chance.choice(areas()).spaces.active
    space.use_render_border = scene().render.use_border = chance.random() < 0.5
    space.render_border_min_x, space.render_border_max_x = chance.choice(((0.2, 0.6), (0.5, 0.5), (0.0, 1.0)))
    scene().render.border_min_y, scene().render.border_max_y = chance.choice(((0.1, 0.9), (0.7, 0.2)))


@operation(3)
def shading():
    space = chance.choice(areas()).spaces.active
    space.shading.type = chance.choice(('SOLID', 'WIREFRAME', 'RENDERED', 'RENDERED'))


@operation(2)
def render_pass():
    settings = getattr(chance.choice(areas()).spaces.active.shading, 'cotorra', None)
    if settings is not None:
        items = settings.bl_rna.properties['render_pass'].enum_items
        settings.render_pass = chance.choice(items.keys())


@operation(1)
def scene_lights():
    found = chance.choice(areas()).spaces.active.shading
    found.use_scene_lights_render = not found.use_scene_lights_render
    found.use_scene_world_render = not found.use_scene_world_render


@operation(1)
def local_view():
    object_mode()
    with inside():
        bpy.ops.view3d.localview()


@operation(2)
def split():
    if len(areas()) > 3:
        area = areas()[-1]
        with bpy.context.temp_override(window=window(), area=area):
            bpy.ops.screen.area_close()
    else:
        with inside():
            bpy.ops.screen.area_split(direction=chance.choice(('VERTICAL', 'HORIZONTAL')), factor=0.5)


@operation(1)
def quad_view():
    with inside():
        bpy.ops.screen.region_quadview()


@operation(1)
def maximize():
    with inside():
        bpy.ops.screen.screen_full_area()


@operation(1)
def sidebar():
    space = chance.choice(areas()).spaces.active
    space.show_region_ui = not space.show_region_ui


# ---- Engines and settings


@operation(2)
def engine():
    """EEVEE is not among them, nor its Material Preview: in software it takes a minute for a picture."""
    scene().render.engine = chance.choice((rendered_with, rendered_with, 'CYCLES', 'BLENDER_WORKBENCH'))


@operation(2)
def settings():
    own = getattr(scene(), 'cotorra', None)
    if own is None:
        return
    own.preview_samples = chance.choice((0, 1, 4, 64))
    own.integrator = chance.choice(('PATH', 'DIRECT', 'WHITTED', 'AO', 'TOON'))
    own.preview_pause = chance.random() < 0.2
    scene().render.film_transparent = chance.random() < 0.5
    scene().render.preview_pixel_size = chance.choice(('AUTO', '1', '4'))
    own.use_preview_adaptive_sampling = chance.random() < 0.5


@operation(2)
def frame():
    scene().frame_set(chance.randint(1, 50))


@operation(1)
def keys():
    obj = pick()
    if obj is not None:
        obj.keyframe_insert('location', frame=chance.randint(1, 50))


@operation(2)
def play():
    with inside():
        bpy.ops.screen.animation_play()


@operation(1)
def render():
    """As F12 does, beside the viewport."""
    object_mode()
    render = scene().render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 160, 90, 100
    scene().cycles.samples = 4
    with inside():
        bpy.ops.render.render('INVOKE_DEFAULT')


@operation(1)
def no_camera():
    scene().camera = None
    chance.choice(areas()).spaces.active.region_3d.view_perspective = 'CAMERA'


@operation(1)
def offscreen():
    """A viewport is drawn as small and as large as can be, in the middle of its own drawing."""
    size = chance.choice(((1, 1), (1, 200), (7, 3), (2000, 1), (7680, 4320)))
    space, found = chance.choice(areas()).spaces.active, []

    def draw() -> None:
        bpy.types.SpaceView3D.draw_handler_remove(found[0], 'WINDOW')
        view, layer = bpy.context.region_data, bpy.context.view_layer
        matrices = view.view_matrix.copy(), view.window_matrix.copy()
        target = gpu.types.GPUOffScreen(*size)
        target.draw_view3d(scene(), layer, bpy.context.space_data, bpy.context.region, *matrices)
        target.free()

    found.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), 'WINDOW', 'POST_PIXEL'))
    space.shading.type = 'RENDERED'


@operation(1)
def extension():
    """It is switched off while it draws, and on again."""
    bpy.ops.preferences.addon_disable(module=EXTENSION)
    bpy.ops.preferences.addon_enable(module=EXTENSION)
    scene().render.engine = rendered_with
