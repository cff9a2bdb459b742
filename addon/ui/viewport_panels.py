# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands at the Rendered viewport: its sampling, what it shows, and the button that lets it rest.

The settings are defined in properties.py.
"""

from __future__ import annotations

import bpy

from .. import cycles_settings, settings, stats
from ..choices import ENGINE, LIGHT_GROUP_PASS, LIGHT_PASS
from .panel import CotorraPanel, setting, split_layout


class COTORRA_RENDER_PT_sampling_viewport(CotorraPanel, bpy.types.Panel):
    bl_label = 'Viewport'
    bl_parent_id = 'COTORRA_RENDER_PT_sampling'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        scene = context.scene
        adaptive = cycles_settings.inherited(scene, 'use_preview_adaptive_sampling')
        heading = layout.column(align=True, heading='Noise Threshold')
        row = heading.row(align=True)
        setting(row, scene, 'use_preview_adaptive_sampling', text='')
        threshold = row.row()
        threshold.active = adaptive
        setting(threshold, scene, 'preview_noise_threshold', text='')
        column = layout.column(align=True)
        setting(column, scene, 'preview_samples', text='Max Samples' if adaptive else 'Samples')
        if adaptive:
            setting(column, scene, 'preview_adaptive_min_samples', text='Min Samples')
        layout.prop(scene.render, 'preview_pixel_size', text='Pixel Size')


class COTORRA_RENDER_PT_sampling_viewport_denoise(CotorraPanel, bpy.types.Panel):
    bl_label = 'Denoise'
    bl_parent_id = 'COTORRA_RENDER_PT_sampling_viewport'
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.cotorra.integrator in settings.DENOISED

    def draw_header(self, context):
        setting(self.layout, context.scene, 'use_preview_denoising', text='')

    def draw(self, context):
        layout = split_layout(self)
        scene = context.scene
        layout.active = bool(cycles_settings.inherited(scene, 'use_preview_denoising'))
        setting(layout, scene, 'preview_denoising_inputs')
        if cycles_settings.inherited(scene, 'preview_denoising_inputs') != 'RGB':
            setting(layout, scene, 'preview_denoising_prefilter')
        setting(layout, scene, 'preview_denoising_quality')
        setting(layout, scene, 'preview_denoising_start_sample')


class COTORRA_VIEW3D_PT_shading_pass(bpy.types.Panel):
    """In the popover of the shading modes."""

    bl_space_type = 'VIEW_3D'
    bl_region_type = 'HEADER'
    bl_label = 'Render Pass'
    bl_parent_id = 'VIEW3D_PT_shading'

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE and context.space_data.shading.type == 'RENDERED'

    def draw(self, context):
        own = context.space_data.shading.cotorra
        self.layout.prop(own, 'render_pass', text='')
        if own.render_pass == LIGHT_PASS:
            self.layout.prop(own, 'light', text='', icon='LIGHT')
        elif own.render_pass == LIGHT_GROUP_PASS:
            self.layout.prop_search(own, 'light_group', context.view_layer, 'lightgroups', text='')


CLASSES = (
    COTORRA_RENDER_PT_sampling_viewport,
    COTORRA_RENDER_PT_sampling_viewport_denoise,
    COTORRA_VIEW3D_PT_shading_pass,
)


def draw_pause(self, context):
    """In the header of the 3D viewport."""
    if context.engine != ENGINE or context.space_data.shading.type != 'RENDERED':
        return
    found = len(stats.of_viewports(context.scene.name))
    if found:
        self.layout.label(text=f'Warnings: {found}', icon='ERROR')
    owner, name = cycles_settings.source(context.scene, 'preview_pause')
    self.layout.prop(owner, name, icon='PLAY' if getattr(owner, name) else 'PAUSE', text='')


def register_draws() -> None:
    bpy.types.VIEW3D_HT_header.append(draw_pause)


def unregister_draws() -> None:
    bpy.types.VIEW3D_HT_header.remove(draw_pause)
