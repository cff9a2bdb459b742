# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra's panels among the Render properties, but for integrators.

The settings are defined in properties.py, or are Blender's own.
"""

from __future__ import annotations

import bpy
from bl_ui.properties_grease_pencil_common import GreasePencilSimplifyPanel

from .. import cycles_settings, devices, settings
from ..choices import ENGINE
from . import sampling_presets, warnings_panel
from .panel import CotorraPanel, HeadingPanel, setting, split_layout, wrapped


def draw_device(self, context):
    """Below Blender's choice of the engine."""
    if context.engine != ENGINE:
        return
    layout = split_layout(self)
    own = context.scene.cotorra
    layout.prop(own, 'device')
    if own.device != 'CPU':
        layout.prop(own, 'graphics_card')
        problem = devices.problem(own.device_index)
        if problem:
            wrapped(layout, context, problem, 'ERROR')


class COTORRA_RENDER_PT_sampling(CotorraPanel, bpy.types.Panel):
    bl_label = 'Sampling'

    def draw_header_preset(self, _context):
        sampling_presets.COTORRA_PT_sampling_presets.draw_panel_header(self.layout)

    def draw(self, context):
        layout = split_layout(self)
        scene = context.scene
        layout.prop(scene.cotorra, 'settings_from')
        adaptive = cycles_settings.inherited(scene, 'use_adaptive_sampling')
        heading = layout.column(align=True, heading='Noise Threshold')
        row = heading.row(align=True)
        setting(row, scene, 'use_adaptive_sampling', text='')
        threshold = row.row()
        threshold.active = adaptive
        setting(threshold, scene, 'noise_threshold', text='')

        column = layout.column(align=True)
        if adaptive:
            setting(column, scene, 'samples', text='Max Samples')
            setting(column, scene, 'adaptive_min_samples')
        else:
            setting(column, scene, 'samples')
        setting(column, scene, 'time_limit')
        if context.view_layer.samples:
            wrapped(layout, context, f'The view layer sets {context.view_layer.samples} samples')


class COTORRA_RENDER_PT_sampling_denoise(CotorraPanel, bpy.types.Panel):
    bl_label = 'Denoise'
    bl_parent_id = 'COTORRA_RENDER_PT_sampling'
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.cotorra.integrator in settings.DENOISED

    def draw_header(self, context):
        setting(self.layout, context.scene, 'use_denoising', text='')

    def draw(self, context):
        layout = split_layout(self)
        layout.active = bool(cycles_settings.inherited(context.scene, 'use_denoising'))
        setting(layout, context.scene, 'denoising_inputs')
        if cycles_settings.inherited(context.scene, 'denoising_inputs') != 'RGB':
            setting(layout, context.scene, 'denoising_prefilter')
        setting(layout, context.scene, 'denoising_quality')


class COTORRA_RENDER_PT_sampling_seed(CotorraPanel, bpy.types.Panel):
    bl_label = 'Seed'
    bl_parent_id = 'COTORRA_RENDER_PT_sampling'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        row = layout.row(align=True)
        setting(row, context.scene, 'seed')
        animated, name = cycles_settings.source(context.scene, 'use_animated_seed')
        row.prop(animated, name, text='', icon='TIME')


class COTORRA_RENDER_PT_film(CotorraPanel, bpy.types.Panel):
    bl_label = 'Film'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        cycles = getattr(context.scene, 'cycles', None)
        if cycles is not None:  # read as it is in a file made for Cycles
            layout.prop(cycles, 'film_exposure')
        layout.prop(context.scene.render, 'film_transparent')
        own = context.scene.cotorra
        tone = layout.column(align=True, heading='Reinhard')
        row = tone.row(align=True)
        row.prop(own, 'use_reinhard', text='')
        white = row.row()
        white.active = own.use_reinhard
        white.prop(own, 'reinhard_white', text='')


class COTORRA_RENDER_PT_film_pixel_filter(CotorraPanel, bpy.types.Panel):
    bl_label = 'Pixel Filter'
    bl_parent_id = 'COTORRA_RENDER_PT_film'

    @classmethod
    def poll(cls, context):
        return super().poll(context) and hasattr(context.scene, 'cycles')

    def draw(self, context):
        cycles = context.scene.cycles
        layout = split_layout(self)
        layout.prop(cycles, 'pixel_filter_type', text='Type')
        if cycles.pixel_filter_type != 'BOX':
            layout.prop(cycles, 'filter_width', text='Width')
        layout.prop(context.scene.cotorra, 'use_sample_sharing')


class COTORRA_RENDER_PT_performance(HeadingPanel, bpy.types.Panel):
    bl_label = 'Performance'
    bl_options = {'DEFAULT_CLOSED'}


class COTORRA_RENDER_PT_performance_threads(CotorraPanel, bpy.types.Panel):
    bl_label = 'Threads'
    bl_parent_id = 'COTORRA_RENDER_PT_performance'

    def draw(self, context):
        render = context.scene.render
        column = split_layout(self).column()
        column.prop(render, 'threads_mode')
        threads = column.column(align=True)
        threads.enabled = render.threads_mode == 'FIXED'
        threads.prop(render, 'threads')


class COTORRA_RENDER_PT_performance_card(CotorraPanel, bpy.types.Panel):
    bl_label = 'Graphics Card'
    bl_parent_id = 'COTORRA_RENDER_PT_performance'

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.cotorra.device != 'CPU'

    def draw(self, context):
        layout = split_layout(self)
        own = context.scene.cotorra
        layout.prop(own, 'ray_tracing')
        layout.prop(own, 'use_device_fallback')


class COTORRA_RENDER_PT_performance_final_render(CotorraPanel, bpy.types.Panel):
    bl_label = 'Final Render'
    bl_parent_id = 'COTORRA_RENDER_PT_performance'

    def draw(self, context):
        split_layout(self).prop(context.scene.render, 'use_persistent_data', text='Persistent Data')


class COTORRA_RENDER_PT_simplify(CotorraPanel, bpy.types.Panel):
    """Blender's own stands above all that add-ons bring."""

    bl_label = 'Simplify'
    bl_options = {'DEFAULT_CLOSED'}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, 'use_simplify', text='')

    def draw(self, context):
        layout = split_layout(self)
        render = context.scene.render
        layout.active = render.use_simplify
        if hasattr(render, 'use_simplify_normals'):
            layout.prop(render, 'use_simplify_normals', text='Normals')


def draw_limits(panel, context, suffix):
    """Of the viewport, or of renders, whose properties' names end so."""
    layout = split_layout(panel)
    render = context.scene.render
    layout.active = render.use_simplify
    layout.prop(render, f'simplify_subdivision{suffix}', text='Max Subdivision')
    layout.prop(render, f'simplify_child_particles{suffix}', text='Max Child Particles')


class COTORRA_RENDER_PT_simplify_viewport(CotorraPanel, bpy.types.Panel):
    bl_label = 'Viewport'
    bl_parent_id = 'COTORRA_RENDER_PT_simplify'

    def draw(self, context):
        draw_limits(self, context, '')


class COTORRA_RENDER_PT_simplify_render(CotorraPanel, bpy.types.Panel):
    bl_label = 'Render'
    bl_parent_id = 'COTORRA_RENDER_PT_simplify'

    def draw(self, context):
        draw_limits(self, context, '_render')


class COTORRA_RENDER_PT_simplify_greasepencil(CotorraPanel, GreasePencilSimplifyPanel, bpy.types.Panel):
    bl_label = 'Grease Pencil'
    bl_parent_id = 'COTORRA_RENDER_PT_simplify'
    bl_options = {'DEFAULT_CLOSED'}


# Among these come the panels of integrator_panels.py.
FIRST_CLASSES = (
    *sampling_presets.CLASSES,
    *warnings_panel.CLASSES,
    COTORRA_RENDER_PT_sampling,
    COTORRA_RENDER_PT_sampling_denoise,
    COTORRA_RENDER_PT_sampling_seed,
)
LAST_CLASSES = (
    COTORRA_RENDER_PT_film,
    COTORRA_RENDER_PT_film_pixel_filter,
    COTORRA_RENDER_PT_performance,
    COTORRA_RENDER_PT_performance_threads,
    COTORRA_RENDER_PT_performance_card,
    COTORRA_RENDER_PT_performance_final_render,
    COTORRA_RENDER_PT_simplify,
    COTORRA_RENDER_PT_simplify_viewport,
    COTORRA_RENDER_PT_simplify_render,
    COTORRA_RENDER_PT_simplify_greasepencil,
)


def register_draws() -> None:
    bpy.types.RENDER_PT_context.append(draw_device)
    bpy.types.IMAGE_HT_header.append(warnings_panel.draw_mark)


def unregister_draws() -> None:
    bpy.types.RENDER_PT_context.remove(draw_device)
    bpy.types.IMAGE_HT_header.remove(warnings_panel.draw_mark)
