# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra's panels for integrators, among the Render properties: of each integrator its own settings, and no others.

The settings are defined in properties.py.
"""

from __future__ import annotations

import bpy

from .. import choices, cycles_settings, settings, stats
from .panel import CotorraPanel, HeadingPanel, setting, split_layout, wrapped


class COTORRA_RENDER_PT_integrator(CotorraPanel, bpy.types.Panel):
    bl_label = 'Integrator'

    def draw(self, context):
        layout = split_layout(self)
        settings = context.scene.cotorra
        layout.prop(settings, 'integrator')
        if settings.integrator == 'TOON':
            wrapped(layout, context, 'The tones are set in Material > Cotorra Model')
        elif settings.integrator in DRAW:
            DRAW[settings.integrator](layout, settings)


class COTORRA_RENDER_PT_auto(CotorraPanel, bpy.types.Panel):
    bl_label = 'Simplifications'
    bl_parent_id = 'COTORRA_RENDER_PT_integrator'

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.cotorra.integrator == 'AUTO'

    def draw(self, context):
        layout = self.layout
        settings = context.scene.cotorra
        column = layout.column()
        column.use_property_split, column.use_property_decorate = True, False
        column.prop(settings, 'auto_tolerance')
        found = last_auto(context.scene)
        rows = {row['key']: row for row in found.get('rows', ())}
        for key, _, _ in choices.AUTO_ROWS:
            line = layout.row()
            line.prop(settings, f'use_auto_{key}')
            if key in rows:
                line.label(text=told(rows[key]), icon='CHECKMARK' if rows[key]['simplified'] else 'BLANK1')
        for sentence in found.get('sentences', ()):
            wrapped(layout, context, sentence)


def last_auto(scene: bpy.types.Scene) -> dict:
    """What AUTO chose for the scene's last render; empty before the first."""
    return next((entry.auto for entry in reversed(stats.last(scene.name)) if entry.auto), {})


def told(row: dict) -> str:
    """What became of a row, in as few words as stand beside its switch."""
    return f'{row["chosen"]} of {row["asked"]}' if row['simplified'] else row['asked']


class BouncesPanel(CotorraPanel):
    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.cotorra.integrator in BOUNCES


class COTORRA_RENDER_PT_light_paths(BouncesPanel, HeadingPanel, bpy.types.Panel):
    bl_label = 'Light Paths'
    bl_options = {'DEFAULT_CLOSED'}


class COTORRA_RENDER_PT_light_paths_max_bounces(BouncesPanel, bpy.types.Panel):
    bl_label = 'Max Bounces'
    bl_parent_id = 'COTORRA_RENDER_PT_light_paths'

    def draw(self, context):
        settings = context.scene.cotorra
        BOUNCES[settings.integrator](split_layout(self), settings)


class COTORRA_RENDER_PT_light_paths_clamping(BouncesPanel, bpy.types.Panel):
    bl_label = 'Clamping'
    bl_parent_id = 'COTORRA_RENDER_PT_light_paths'

    def draw(self, context):
        column = split_layout(self).column(align=True)
        setting(column, context.scene, 'clamp_direct')
        if context.scene.cotorra.integrator in PATHS:
            setting(column, context.scene, 'clamp_indirect')
        own = context.scene.cotorra
        heading = split_layout(self).column(align=True, heading='Reweight Fireflies')
        row = heading.row(align=True)
        row.active = cycles_settings.holds_of_ours(context.scene, 'use_reweighting')  # else it is off
        row.prop(own, 'use_reweighting', text='')
        strength = row.row()
        strength.active = settings.reweights(context.scene)
        strength.prop(own, 'reweighting_strength')


class COTORRA_RENDER_PT_light_paths_caustics(BouncesPanel, bpy.types.Panel):
    bl_label = 'Caustics'
    bl_parent_id = 'COTORRA_RENDER_PT_light_paths'

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.cotorra.integrator in PATHS

    def draw(self, context):
        layout = split_layout(self)
        setting(layout, context.scene, 'filter_glossy')
        setting(layout, context.scene, 'light_threshold')
        column = layout.column(heading='Caustics', align=True)
        setting(column, context.scene, 'reflective_caustics')
        setting(column, context.scene, 'refractive_caustics')


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
        setting(distance, context.scene, 'ao_distance', text='')


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
    setting(layout, settings.id_data, 'transparent_bounces')


def draw_path(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    bounces = layout.column(align=True)
    for name in (
        'max_bounces',
        'diffuse_bounces',
        'glossy_bounces',
        'transmission_bounces',
        'transparent_bounces',
    ):
        setting(bounces, settings.id_data, name)


def draw_whitted(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    rays = layout.column(align=True)
    rays.prop(settings, 'whitted_depth')
    rays.prop(settings, 'whitted_threshold')
    layout.prop(settings, 'use_transparent_shadows')


def draw_occlusion(layout: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    setting(layout, settings.id_data, 'ao_distance')


DRAW = {'WHITTED': draw_whitted, 'AO': draw_occlusion}

# Integrators whose rays are counted, and the limits that they have.
BOUNCES = {'DIRECT': draw_direct, 'PATH': draw_path, 'AUTO': draw_path}
PATHS = ('PATH', 'AUTO')

CLASSES = (
    COTORRA_RENDER_PT_integrator,
    COTORRA_RENDER_PT_auto,
    COTORRA_RENDER_PT_ambient,
    COTORRA_RENDER_PT_outlines,
    COTORRA_RENDER_PT_light_paths,
    COTORRA_RENDER_PT_light_paths_max_bounces,
    COTORRA_RENDER_PT_light_paths_clamping,
    COTORRA_RENDER_PT_light_paths_caustics,
)
