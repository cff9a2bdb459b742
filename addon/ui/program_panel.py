# SPDX-License-Identifier: GPL-3.0-or-later
"""What the material became, in the Material tab: the text of `cotorra explain`, section by section.

A press of a button reads the material; panels are drawn too often to do it by themselves.
"""

from __future__ import annotations

import bpy

from .. import explain
from .data_panels import MaterialPanel
from .panel import wrapped

# The sections that were read last, by the session's number of the material.
_told: dict[int, tuple] = {}


class COTORRA_OT_explain(bpy.types.Operator):
    """Read the node tree, and show the program that it becomes, what was left out of it, and its cost"""

    bl_idname = 'material.cotorra_explain'
    bl_label = 'Show Program'

    @classmethod
    def poll(cls, context):
        return getattr(context, 'material', None) is not None

    def execute(self, context):
        material = context.material
        try:
            told = explain.explain_material(material, context.scene, context.evaluated_depsgraph_get())
        except (ValueError, ImportError, OSError) as problem:
            self.report({'ERROR'}, f'Material "{material.name}": {problem}')
            return {'CANCELLED'}
        _told[material.session_uid] = told.sections
        return {'FINISHED'}


class COTORRA_MATERIAL_PT_program(MaterialPanel, bpy.types.Panel):
    bl_label = 'Program'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = self.layout
        sections = _told.get(context.material.session_uid, ())
        layout.operator('material.cotorra_explain', text='Read Again' if sections else 'Show Program', icon='FILE_TEXT')
        for section in sections:
            box = layout.box()
            wrapped(box, context, section.title, icon='DOT')
            if section.rows:
                draw_rows(box, context, section.rows)


def draw_rows(layout: bpy.types.UILayout, context: bpy.types.Context, rows: tuple) -> None:
    """Cells side by side; below them the last, which may be long."""
    for *head, last in rows:
        if head:
            row = layout.row(align=True)
            row.scale_y = 0.7
            for cell in head:
                row.label(text=cell)
        if last:
            wrapped(layout, context, last, icon='BLANK1')


def forget() -> None:
    """What was read of files that are closed is not shown again."""
    _told.clear()


CLASSES = (COTORRA_OT_explain, COTORRA_MATERIAL_PT_program)
