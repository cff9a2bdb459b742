# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra's panels among the Render properties: sampling, film, performance.

The settings are defined in properties.py, or are Blender's own.
"""

from __future__ import annotations

import bpy

from .panel import CotorraPanel, split_layout


class COTORRA_RENDER_PT_sampling(CotorraPanel, bpy.types.Panel):
    bl_label = 'Sampling'

    def draw(self, context):
        layout = split_layout(self)
        settings = context.scene.cotorra
        layout.prop(settings, 'device')
        if settings.device != 'CPU':
            layout.prop(settings, 'device_index')
            layout.prop(settings, 'ray_tracing')
            layout.prop(settings, 'use_device_fallback')

        heading = layout.column(align=True, heading='Noise Threshold')
        row = heading.row(align=True)
        row.prop(settings, 'use_adaptive_sampling', text='')
        threshold = row.row()
        threshold.active = settings.use_adaptive_sampling
        threshold.prop(settings, 'noise_threshold', text='')

        column = layout.column(align=True)
        if settings.use_adaptive_sampling:
            column.prop(settings, 'samples', text='Max Samples')
            column.prop(settings, 'adaptive_min_samples', text='Min Samples')
        else:
            column.prop(settings, 'samples')
        if context.view_layer.samples:
            layout.label(text=f'The view layer sets {context.view_layer.samples} samples', icon='INFO')


class COTORRA_RENDER_PT_sampling_seed(CotorraPanel, bpy.types.Panel):
    bl_label = 'Seed'
    bl_parent_id = 'COTORRA_RENDER_PT_sampling'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        settings = context.scene.cotorra
        row = layout.row(align=True)
        row.prop(settings, 'seed')
        row.prop(settings, 'use_animated_seed', text='', icon='TIME')


class COTORRA_RENDER_PT_film(CotorraPanel, bpy.types.Panel):
    bl_label = 'Film'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        layout.prop(context.scene.render, 'film_transparent')
        cycles = getattr(context.scene, 'cycles', None)
        if cycles is not None:  # read as they are in a file made for Cycles
            layout.prop(cycles, 'film_exposure')
            layout.prop(cycles, 'filter_width')
        settings = context.scene.cotorra
        tone = layout.column(align=True, heading='Reinhard')
        row = tone.row(align=True)
        row.prop(settings, 'use_reinhard', text='')
        white = row.row()
        white.active = settings.use_reinhard
        white.prop(settings, 'reinhard_white', text='')


class COTORRA_RENDER_PT_performance(CotorraPanel, bpy.types.Panel):
    bl_label = 'Performance'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        render = context.scene.render
        column = layout.column()
        column.prop(render, 'threads_mode')
        threads = column.column(align=True)
        threads.enabled = render.threads_mode == 'FIXED'
        threads.prop(render, 'threads')
        layout.prop(render, 'use_persistent_data', text='Persistent Data')


CLASSES = (
    COTORRA_RENDER_PT_sampling,
    COTORRA_RENDER_PT_sampling_seed,
    COTORRA_RENDER_PT_film,
    COTORRA_RENDER_PT_performance,
)
