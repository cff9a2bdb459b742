# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render had to say, where the user finds it again: a panel above the Render properties, and a mark.

A message begins with what it is about, as `Object "Name": `; a click there selects it.
"""

from __future__ import annotations

import re

import bpy
from bpy.props import StringProperty

from .. import native, stats
from ..choices import ENGINE
from .panel import CotorraPanel, wrapped

SHOWN_WARNINGS = 20
ABOUT = re.compile(r'(Object|Light|Camera|Material) "')

_marked: list[str] = []  # what the mark in the image editor told last


def problems(scene: bpy.types.Scene) -> list[str]:
    """What the user should know of the scene's last render and its viewport, errors first, each once."""
    layers = stats.last(scene.name)
    restart = [native.RESTART] if native.restart_needed() else []
    errors = [entry.error for entry in layers if entry.error]
    warnings = [text for entry in layers for text in entry.warnings]
    return list(dict.fromkeys([*restart, *errors, *warnings, *stats.of_viewports(scene.name)]))


def about(text: str, view_layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    """The objects of the view layer that a message is about: itself, or all that have the material or the light."""
    found = ABOUT.match(text)
    if found is None:
        return []
    # A name may hold what ends it, too: the shortest that something has is meant.
    ends = [place.start() for place in re.finditer('": ', text)]
    return next(filter(None, (named(found.group(1), text[found.end() : end], view_layer) for end in ends)), [])


def named(kind: str, name: str, view_layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    if kind == 'Material':
        return [item for item in view_layer.objects if any(slot.name == name for slot in item.material_slots)]
    item = view_layer.objects.get(name)
    if item is not None:
        return [item]
    return [item for item in view_layer.objects if item.type == 'LIGHT' and item.data.name == name]


class COTORRA_OT_select_named(bpy.types.Operator):
    """Select what the message is about: the object, or the objects that have the material"""

    bl_idname = 'object.cotorra_select_named'
    bl_label = 'Select'
    bl_options = {'UNDO', 'INTERNAL'}

    text: StringProperty(options={'SKIP_SAVE'})

    @classmethod
    def poll(cls, context):
        return context.mode == 'OBJECT'

    def execute(self, context):
        layer = context.view_layer
        items = [item for item in about(self.text, layer) if item.visible_get(view_layer=layer)]
        if not items:
            self.report({'WARNING'}, 'It is not in this view layer, or hidden there')
            return {'CANCELLED'}
        for item in layer.objects:
            item.select_set(item in items)
        layer.objects.active = items[0]
        return {'FINISHED'}


class COTORRA_RENDER_PT_warnings(CotorraPanel, bpy.types.Panel):
    bl_label = 'Warnings'

    @classmethod
    def poll(cls, context):
        return super().poll(context) and bool(problems(context.scene))

    def draw_header_preset(self, _context):
        self.layout.label(text='', icon='ERROR')

    def draw(self, context):
        found = problems(context.scene)
        for text in found[:SHOWN_WARNINGS]:
            row = self.layout.row()
            wrapped(row, context, text, 'DOT')
            if ABOUT.match(text):
                row.operator(COTORRA_OT_select_named.bl_idname, text='', icon='RESTRICT_SELECT_OFF').text = text
        if len(found) > SHOWN_WARNINGS:
            self.layout.label(text=f'{len(found) - SHOWN_WARNINGS} more in the Info editor')


def draw_mark(self, context):
    """In the header of the image editor, over the render result."""
    global _marked
    image = context.space_data.image
    if context.engine != ENGINE or image is None or image.type != 'RENDER_RESULT':
        return
    found = problems(context.scene)
    if found:
        self.layout.label(text=f'{len(found)} in Render Properties > Warnings', icon='ERROR')
    # A render draws the image editor anew and not the panel; it may not do so itself, in a thread of its own.
    if found != _marked:
        _marked = found
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == 'PROPERTIES':
                    area.tag_redraw()


CLASSES = (COTORRA_OT_select_named, COTORRA_RENDER_PT_warnings)
