# SPDX-License-Identifier: GPL-3.0-or-later
"""*Speed and Accuracy* and *Compare with Cycles*, among the Render properties: start, watch, look and pick a row.

Processes beside this one do the work (lab/background.py); a timer asks after them, so that the window stays alive.
"""

from __future__ import annotations

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .. import compat, stats
from ..choices import ENGINE
from ..lab import background, pictures, plan, raster
from ..lab.apply import apply
from ..terminal import CommandError
from .panel import CotorraPanel, split_layout, wrapped

ASK_SECONDS = 0.5
PLOT_SIZE = (1100, 760)
MEASURES = (
    ('trimmed', 'relMSE, trimmed', 'Relative mean squared error, without the worst 0.1 % of pixels'),
    ('relmse', 'relMSE', 'Relative mean squared error (Rousselle et al. 2011)'),
    ('rmse', 'RMSE', 'Root of the mean squared error'),
)


# Blender keeps these from the class below: names, and not what they stand for, would be looked up elsewhere.
def plot_again(_settings, context):
    show_plot(context)


def compare_again(_settings, context):
    show_comparison(context)


class CotorraLabSettings(bpy.types.PropertyGroup):
    """Of the window manager: they are not kept in files."""

    budget: FloatProperty(
        name='Time',
        description='How long the chart may take, in all',
        subtype='TIME_ABSOLUTE',
        unit='TIME_ABSOLUTE',
        default=120.0,
        min=20.0,
        max=86400.0,
        soft_max=1800.0,
    )
    pixels: IntProperty(
        name='Width',
        description="Width of the pictures that are rendered for it; they keep the scene's shape",
        subtype='PIXEL',
        default=320,
        min=32,
        max=4096,
    )
    samples: IntProperty(
        name='Samples',
        description='Samples of both engines where they are compared',
        default=64,
        min=1,
        max=65536,
        soft_max=1024,
    )
    slide: BoolProperty(
        name='Slider',
        description='Show both in one picture, Cotorra left of the slider and Cycles right of it',
        update=compare_again,
    )
    split: FloatProperty(
        name='Cotorra | Cycles',
        description='How much of the picture is by Cotorra',
        subtype='FACTOR',
        default=0.5,
        min=0.0,
        max=1.0,
        update=compare_again,
    )
    measure: EnumProperty(
        name='Error',
        description='What is charted and listed',
        items=MEASURES,
        update=plot_again,
    )


def size_argument(scene: bpy.types.Scene, width: int) -> str:
    render = scene.render
    shape = render.resolution_y * render.pixel_aspect_y / (render.resolution_x * render.pixel_aspect_x)
    return f'{width}x{max(4, round(width * shape))}'


class LabOperator:
    """Starts a process and asks after it until it ends. Without a window it waits for nothing."""

    bl_options = {'REGISTER'}
    kind = ''

    @classmethod
    def poll(cls, context):
        if context.scene.camera is None:
            cls.poll_message_set('The scene has no camera')
            return False
        task = background.tasks.get(cls.kind)
        return task is None or not task.running

    def execute(self, context):
        arguments, seconds = self.arguments(context)
        try:
            background.start(context.scene, self.kind, arguments, seconds)
        except (OSError, RuntimeError) as error:
            self.report({'ERROR'}, f'Cotorra: {background.KINDS[self.kind]} could not be started: {error}')
            return {'CANCELLED'}
        if context.window is None:
            return {'FINISHED'}
        self.timer = context.window_manager.event_timer_add(ASK_SECONDS, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {'RUNNING_MODAL'}

    def modal(self, context, event):
        if event.type != 'TIMER':
            return {'PASS_THROUGH'}
        task = background.tasks.get(self.kind)
        if task is not None and task.poll():
            redraw(context)
            return {'PASS_THROUGH'}
        context.window_manager.event_timer_remove(self.timer)
        if task is not None and task.error:
            self.report({'ERROR'}, f'Cotorra: {task.error}')
        elif task is not None:
            self.finished(context, task)
        redraw(context)
        return {'FINISHED'}


class COTORRA_OT_speed_accuracy(LabOperator, bpy.types.Operator):
    """Render the scene by many settings and by Cycles, small and in the background, and chart seconds against error"""

    bl_idname = 'cotorra.speed_accuracy'
    bl_label = 'Chart Speed and Accuracy'
    kind = 'chart'

    def arguments(self, context):
        settings = context.window_manager.cotorra_lab
        size = size_argument(context.scene, settings.pixels)
        return ['--budget', f'{settings.budget:g}', '--size', size], settings.budget

    def finished(self, context, task):
        show_plot(context)


class COTORRA_OT_compare(LabOperator, bpy.types.Operator):
    """Render the scene by Cotorra and by Cycles, small and in the background, and show their difference"""

    bl_idname = 'cotorra.compare'
    bl_label = 'Compare with Cycles'
    kind = 'compare'

    def arguments(self, context):
        settings = context.window_manager.cotorra_lab
        integrator = context.scene.cotorra.integrator.lower()
        size = size_argument(context.scene, settings.pixels)
        return ['--samples', str(settings.samples), '--size', size, '--integrator', integrator], None

    def finished(self, context, task):
        show_comparison(context)


class COTORRA_OT_lab_stop(bpy.types.Operator):
    """End it with what is there"""

    bl_idname = 'cotorra.lab_stop'
    bl_label = 'Stop'

    kind: StringProperty()

    def execute(self, _context):
        task = background.tasks.get(self.kind)
        if task is not None:
            task.stop()
        return {'FINISHED'}


class COTORRA_OT_lab_apply(bpy.types.Operator):
    """Give the scene the settings of this row"""

    bl_idname = 'cotorra.lab_apply'
    bl_label = 'Use These Settings'
    bl_options = {'REGISTER', 'UNDO'}

    line: IntProperty()
    point: IntProperty()

    def execute(self, context):
        task = background.tasks.get('chart')
        try:
            entry = task.plot['lines'][self.line]
            samples = entry['points'][self.point]['samples']
        except (AttributeError, TypeError, IndexError):
            self.report({'ERROR'}, 'Cotorra: the chart has no such row')
            return {'CANCELLED'}
        try:
            apply(context.scene, plan.Series(**entry['series']), samples)
        except CommandError as error:
            self.report({'ERROR'}, f'Cotorra: {error}')
            return {'CANCELLED'}
        self.report({'INFO'}, f'{entry["name"]}, {samples} samples')
        return {'FINISHED'}


def redraw(context):
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {'PROPERTIES', 'IMAGE_EDITOR'}:
                area.tag_redraw()


def named(image: bpy.types.Image, name: str) -> bpy.types.Image:
    """The image, under this name; one that had it goes, and its users take the new one."""
    old = bpy.data.images.get(name)
    if old is not None and old != image:
        old.user_remap(image)
        bpy.data.images.remove(old)
    image.name = name
    return image


def show_image(context, image: bpy.types.Image) -> None:
    """In the first image editor that is open."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == 'IMAGE_EDITOR':
                area.spaces.active.image = image
                return


def show_comparison(context) -> bpy.types.Image | None:
    """The three pictures, or two of them behind a slider, as an image; None where nothing was compared."""
    task = background.tasks.get('compare')
    if task is None or task.running or not task.picture().exists():
        return None
    image = bpy.data.images.load(str(task.picture()))
    settings, size = context.window_manager.cotorra_lab, task.size()
    if settings.slide and size is not None:
        width, height = image.size
        whole = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(whole)
        whole = np.round(255.0 * whole.reshape(height, width, 4)[::-1, :, :3]).astype(np.uint8)
        bpy.data.images.remove(image)
        image = filled(pictures.wiped(whole, size, settings.split))
    image.pack()  # the file goes when Blender ends
    image = named(image, background.KINDS['compare'])
    show_image(context, image)
    return image


def filled(shown: pictures.Bytes) -> bpy.types.Image:
    """An image of these pixels, the first row above."""
    height, width = shown.shape[:2]
    image = bpy.data.images.new('picture', width, height)
    values = np.ones((height, width, 4), np.float32)
    values[..., :3] = shown[::-1] / 255.0
    image.pixels.foreach_set(values.ravel())
    return image


def show_plot(context) -> bpy.types.Image | None:
    """The chart of the measure that is chosen, as an image; None where there is none, or no letters for it."""
    task = background.tasks.get('chart')
    if task is None or task.plot is None or not compat.can_draw_text():
        return None
    title = f'{task.scene}: speed against accuracy'
    measure = context.window_manager.cotorra_lab.measure
    image = filled(raster.plot(task.plot, measure, title, *PLOT_SIZE, compat.text_coverage))
    image.pack()
    named(image, background.KINDS['chart'])
    show_image(context, image)
    return image


def rows(plot: dict, measure: str) -> list[tuple[int, int, dict]]:
    """(line, point, its figures) of the plot, the nearest to the reference first."""
    found = [
        (index, number, point)
        for index, line in enumerate(plot['lines'])
        for number, point in enumerate(line['points'])
        if point[measure] is not None
    ]
    return sorted(found, key=lambda row: row[2][measure])


def draw_running(layout, task) -> None:
    share = task.share()
    if share is not None:
        layout.progress(factor=share, type='BAR', text=f'{share:.0%} of the time')
    column = layout.column(align=True)
    column.label(text=task.state()[:80])
    stop = layout.row()
    stop.enabled = not task.stop_asked
    stop.operator('cotorra.lab_stop', icon='CANCEL').kind = task.kind


class COTORRA_RENDER_PT_speed_accuracy(CotorraPanel, bpy.types.Panel):
    bl_label = 'Speed and Accuracy'
    bl_options = {'DEFAULT_CLOSED'}
    COMPAT_ENGINES = {ENGINE, 'CYCLES'}  # a row may have been Cycles'

    def draw(self, context):
        layout = split_layout(self)
        settings = context.window_manager.cotorra_lab
        task = background.tasks.get('chart')
        if task is not None and task.running:
            draw_running(layout, task)
            return
        column = layout.column(align=True)
        column.prop(settings, 'budget')
        column.prop(settings, 'pixels')
        layout.operator('cotorra.speed_accuracy', icon='GRAPH')
        if task is None:
            return
        if task.error:
            wrapped(layout, context, task.error, 'ERROR')
        if task.plot is None:
            return
        layout.prop(settings, 'measure')
        image = bpy.data.images.get(background.KINDS['chart'])
        if image is not None:
            wrapped(layout, context, f'The plot is the image "{image.name}", in any Image Editor', 'IMAGE_DATA')
        table = layout.column(align=True)
        for index, number, point in rows(task.plot, settings.measure):
            line = task.plot['lines'][index]
            best = settings.measure in point['front']
            row = table.row(align=True)
            picked = row.operator('cotorra.lab_apply', text=f'{line["name"]}, {point["samples"]}', emboss=True)
            picked.line, picked.point = index, number
            figures = row.row(align=True)
            figures.alignment = 'RIGHT'
            figures.label(text=f'{point["seconds"]:.2g} s')
            figures.label(text=f'{point[settings.measure]:.2g}', icon='CHECKMARK' if best else 'BLANK1')
        wrapped(layout, context, 'Marked: nothing is both faster and nearer. A click takes the settings')


class COTORRA_RENDER_PT_compare(CotorraPanel, bpy.types.Panel):
    bl_label = 'Compare with Cycles'
    bl_parent_id = 'COTORRA_RENDER_PT_speed_accuracy'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        task = background.tasks.get('compare')
        if task is not None and task.running:
            draw_running(layout, task)
            return
        layout.prop(context.window_manager.cotorra_lab, 'samples')
        layout.operator('cotorra.compare', icon='MOD_MIRROR')
        if task is None:
            return
        if task.error:
            wrapped(layout, context, task.error, 'ERROR')
        if bpy.data.images.get(background.KINDS['compare']) is not None:
            settings = context.window_manager.cotorra_lab
            row = layout.row(align=True)
            row.prop(settings, 'slide', text='', icon='ARROW_LEFTRIGHT')
            slider = row.row(align=True)
            slider.active = settings.slide
            slider.prop(settings, 'split', slider=True)
            wrapped(layout, context, f'The picture is the image "{background.KINDS["compare"]}"', 'IMAGE_DATA')
        for line in task.lines:
            wrapped(layout, context, line, 'DOT')


class COTORRA_RENDER_PT_health(CotorraPanel, bpy.types.Panel):
    bl_label = 'Numerical Health'
    bl_parent_id = 'COTORRA_RENDER_PT_speed_accuracy'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        layout.prop(context.scene.cotorra, 'health', text='Bad Samples')
        layout.prop(context.view_layer.cotorra, 'use_pass_health', text='Pass')
        for text in (text for entry in stats.last(context.scene.name) for text in entry.health):
            wrapped(layout, context, text, 'DOT')


CLASSES = (
    CotorraLabSettings,
    COTORRA_OT_speed_accuracy,
    COTORRA_OT_compare,
    COTORRA_OT_lab_stop,
    COTORRA_OT_lab_apply,
    COTORRA_RENDER_PT_speed_accuracy,
    COTORRA_RENDER_PT_compare,
    COTORRA_RENDER_PT_health,
)


def register() -> None:
    bpy.types.WindowManager.cotorra_lab = PointerProperty(type=CotorraLabSettings)


def unregister() -> None:
    background.end_all()
    del bpy.types.WindowManager.cotorra_lab
