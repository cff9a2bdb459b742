# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra's panels for integrators, among the Render properties: of each integrator its own settings, and no others.

The settings are defined in properties.py.
"""

from __future__ import annotations

import bpy

from .panel import CotorraPanel, split_layout


class COTORRA_RENDER_PT_integrator(CotorraPanel, bpy.types.Panel):
    bl_label = 'Integrator'

    def draw(self, context):
        layout = split_layout(self)
        settings = context.scene.cotorra
        layout.prop(settings, 'integrator')
        DRAW[settings.integrator](layout, settings)


class COTORRA_RENDER_PT_ambient(CotorraPanel, bpy.types.Panel):
    bl_label = 'Ambient Light'
    bl_parent_id = 'COTORRA_RENDER_PT_integrator'
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.cotorra.integrator in {'DIRECT', 'WHITTED'}

    def draw(self, context):
        layout = split_layout(self)
        settings = context.scene.cotorra
        layout.prop(settings, 'ambient_color', text='Color')
        layout.prop(settings, 'ambient_strength', text='Strength')
        occlusion = layout.column(align=True, heading='Occlusion')
        row = occlusion.row(align=True)
        row.prop(settings, 'use_ambient_occlusion', text='')
        distance = row.row()
        distance.active = settings.use_ambient_occlusion
        distance.prop(settings, 'ao_distance', text='')


class COTORRA_RENDER_PT_outlines(CotorraPanel, bpy.types.Panel):
    bl_label = 'Outlines'
    bl_parent_id = 'COTORRA_RENDER_PT_integrator'

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.cotorra.integrator == 'TOON'

    def draw_header(self, context):
        self.layout.prop(context.scene.cotorra, 'toon_outline', text='')

    def draw(self, context):
        layout = split_layout(self)
        settings = context.scene.cotorra
        layout.active = settings.toon_outline
        layout.prop(settings, 'outline_width')
        layout.prop(settings, 'outline_color')
        where = layout.column(align=True, heading='Where')
        where.prop(settings, 'outline_normal')
        where.prop(settings, 'outline_depth')
        where.prop(settings, 'outline_object')


def draw_direct(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    layout.prop(settings, 'transparent_bounces')


def draw_path(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    bounces = layout.column(align=True, heading='Bounces')
    bounces.prop(settings, 'max_bounces')
    bounces.prop(settings, 'diffuse_bounces')
    bounces.prop(settings, 'glossy_bounces')
    bounces.prop(settings, 'transmission_bounces')
    bounces.prop(settings, 'transparent_bounces')


def draw_whitted(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    rays = layout.column(align=True)
    rays.prop(settings, 'whitted_depth')
    rays.prop(settings, 'whitted_threshold')
    layout.prop(settings, 'use_transparent_shadows')


def draw_occlusion(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    layout.prop(settings, 'ao_distance')


def draw_toon(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    layout.label(text='Tones are set by the material, below Cotorra Model', icon='INFO')


DRAW = {
    'DIRECT': draw_direct,
    'PATH': draw_path,
    'WHITTED': draw_whitted,
    'AO': draw_occlusion,
    'TOON': draw_toon,
}

CLASSES = (COTORRA_RENDER_PT_integrator, COTORRA_RENDER_PT_ambient, COTORRA_RENDER_PT_outlines)
