# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra's panels among the View Layer properties: the passes that it can render, and no others.

Before them stand overrides, for which Blender 4.5 has no panel of its own; light groups are Blender's.
"""

from __future__ import annotations

import bpy
from bl_ui.properties_view_layer import ViewLayerLightgroupsPanelHelper

from ..choices import ENGINE
from .panel import CotorraPanel, HeadingPanel, split_layout


class COTORRA_VIEWLAYER_PT_override(CotorraPanel, bpy.types.Panel):
    bl_label = 'Override'
    bl_context = 'view_layer'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        layer = context.view_layer
        layout.prop(layer, 'material_override')
        if hasattr(layer, 'world_override'):
            layout.prop(layer, 'world_override')
        layout.prop(layer, 'samples')


class COTORRA_VIEWLAYER_PT_passes(HeadingPanel, bpy.types.Panel):
    bl_label = 'Passes'
    bl_context = 'view_layer'


class COTORRA_VIEWLAYER_PT_passes_data(CotorraPanel, bpy.types.Panel):
    bl_label = 'Data'
    bl_context = 'view_layer'
    bl_parent_id = 'COTORRA_VIEWLAYER_PT_passes'

    def draw(self, context):
        layout = split_layout(self)
        layer = context.view_layer
        include = layout.column(heading='Include', align=True)
        include.prop(layer, 'use_pass_combined')
        include.prop(layer, 'use_pass_z')
        include.prop(layer, 'use_pass_position')
        include.prop(layer, 'use_pass_normal')
        include.prop(layer, 'use_pass_uv')
        indices = layout.column(heading='Indexes', align=True)
        indices.prop(layer, 'use_pass_object_index')
        indices.prop(layer, 'use_pass_material_index')
        debug = layout.column(heading='Debug', align=True)
        debug.prop(layer.cotorra, 'use_pass_sample_count')
        debug.prop(layer.cotorra, 'use_pass_noise')
        debug.prop(layer.cotorra, 'use_pass_health')
        cycles = getattr(layer, 'cycles', None)
        if cycles is not None:  # read as it is in a file made for Cycles
            layout.column(heading='Denoising').prop(cycles, 'denoising_store_passes', text='Data')


class COTORRA_VIEWLAYER_PT_passes_light(CotorraPanel, bpy.types.Panel):
    bl_label = 'Light'
    bl_context = 'view_layer'
    bl_parent_id = 'COTORRA_VIEWLAYER_PT_passes'

    def draw(self, context):
        layout = split_layout(self)
        layer = context.view_layer
        layout.column(heading='Diffuse').prop(layer, 'use_pass_diffuse_color', text='Color')
        other = layout.column(heading='Other', align=True)
        other.prop(layer, 'use_pass_emit', text='Emission')
        other.prop(layer, 'use_pass_environment')
        other.prop(layer, 'use_pass_shadow')
        other.prop(layer, 'use_pass_ambient_occlusion')


class COTORRA_VIEWLAYER_PT_passes_terms(CotorraPanel, bpy.types.Panel):
    bl_label = 'Terms'
    bl_context = 'view_layer'
    bl_parent_id = 'COTORRA_VIEWLAYER_PT_passes'

    def draw(self, context):
        layout = split_layout(self)
        own = context.view_layer.cotorra
        terms = layout.column(heading='Highlight', align=True)
        terms.prop(own, 'use_pass_distribution')
        terms.prop(own, 'use_pass_masking')
        terms.prop(own, 'use_pass_fresnel')
        layout.column(heading='Lights').prop(own, 'use_pass_lights')


class COTORRA_VIEWLAYER_PT_passes_light_groups(ViewLayerLightgroupsPanelHelper, bpy.types.Panel):
    bl_parent_id = 'COTORRA_VIEWLAYER_PT_passes'
    COMPAT_ENGINES = {ENGINE}


CLASSES = (
    COTORRA_VIEWLAYER_PT_override,
    COTORRA_VIEWLAYER_PT_passes,
    COTORRA_VIEWLAYER_PT_passes_data,
    COTORRA_VIEWLAYER_PT_passes_light,
    COTORRA_VIEWLAYER_PT_passes_terms,
    COTORRA_VIEWLAYER_PT_passes_light_groups,
)
