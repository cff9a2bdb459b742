# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels for reflection models: of each model what it reads, for a material or for all at once; and their presets.

What the parameters mean is written where they are defined, in material_settings.py.
"""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .. import choices
from ..material_settings import CotorraMaterialSettings
from .data_panels import MaterialPanel
from .panel import CotorraPanel, split_layout, wrapped

PRESETS = 'cotorra/material'
ROOT = str(Path(__file__).resolve().parent.parent)

# Models without a highlight: a metal, which has nothing else, looks matt.
MATT = {'LAMBERT', 'OREN_NAYAR', 'TOON'}


class COTORRA_PT_material_presets(PresetPanel, bpy.types.Panel):
    bl_label = 'Material Presets'
    preset_subdir = PRESETS
    preset_operator = 'script.execute_preset'
    preset_add_operator = 'material.cotorra_preset_add'
    COMPAT_ENGINES = {choices.ENGINE}


class COTORRA_OT_material_preset_add(AddPresetBase, bpy.types.Operator):
    """Add or remove a preset of the reflection model"""

    bl_idname = 'material.cotorra_preset_add'
    bl_label = 'Add Material Preset'
    preset_menu = 'COTORRA_PT_material_presets'
    preset_subdir = PRESETS
    preset_defines = ['own = bpy.context.material.cotorra']
    preset_values = [f'own.{name}' for name in CotorraMaterialSettings.__annotations__ if name != 'use_auto']


class COTORRA_MATERIAL_PT_model(MaterialPanel, bpy.types.Panel):
    bl_label = 'Cotorra Model'

    def draw_header_preset(self, context):
        COTORRA_PT_material_presets.draw_panel_header(self.layout)

    def draw(self, context):
        layout = split_layout(self)
        own = context.material.cotorra
        scene = context.scene.cotorra
        if scene.use_model_override:
            wrapped(layout, context, 'The scene renders all materials with one model')
        draw_model(layout, own)
        if scene.integrator == 'AUTO':
            layout.prop(own, 'use_auto')
        if scene.integrator == 'WHITTED':
            draw_whitted(layout, own)
        elif scene.integrator == 'TOON' and own.model != 'TOON':
            draw_toon(layout, own)


class COTORRA_RENDER_PT_model_override(CotorraPanel, bpy.types.Panel):
    bl_label = 'Model Override'
    bl_options = {'DEFAULT_CLOSED'}

    def draw_header(self, context):
        self.layout.prop(context.scene.cotorra, 'use_model_override', text='')

    def draw(self, context):
        layout = split_layout(self)
        settings = context.scene.cotorra
        layout.active = settings.use_model_override
        draw_model(layout, settings.model_override)


def draw_model(layout: bpy.types.UILayout, own: bpy.types.PropertyGroup) -> None:
    """The model, and those of its parameters that the material's nodes do not have."""
    layout.prop(own, 'model')
    if own.model == 'OREN_NAYAR':
        layout.prop(own, 'oren_nayar_form')
        layout.prop(own, 'oren_nayar_sigma')
    elif own.model in {'PHONG', 'BLINN_PHONG'}:
        draw_phong(layout, own)
    elif own.model == 'COOK_TORRANCE':
        draw_cook_torrance(layout, own)
    elif own.model == 'TOON':
        draw_toon(layout, own)
    if own.model in MATT:
        layout.label(text='Has no highlight: a metal looks matt', icon='INFO')


def draw_phong(layout: bpy.types.UILayout, own: bpy.types.PropertyGroup) -> None:
    layout.prop(own, 'normalized')
    if not own.normalized:
        layout.label(text='May reflect more light than arrives', icon='INFO')
    parts = layout.column(align=True)
    parts.prop(own, 'kd')
    parts.prop(own, 'ks')
    layout.prop(own, 'specular_color')
    layout.prop(own, 'shininess')


def draw_cook_torrance(layout: bpy.types.UILayout, own: bpy.types.PropertyGroup) -> None:
    terms = layout.column(align=True)
    terms.prop(own, 'distribution')
    terms.prop(own, 'masking')
    terms.prop(own, 'fresnel')
    if own.fresnel in {'SCHLICK', 'F82'}:
        layout.prop(own, 'f0_mode')
        if own.f0_mode == 'COLOR':
            layout.prop(own, 'f0')
    if own.fresnel == 'F82':
        layout.prop(own, 'f82_tint')
    if own.fresnel == 'CONDUCTOR':
        layout.column().prop(own, 'conductor_n')
        layout.column().prop(own, 'conductor_k')
    layout.prop(own, 'split')


def draw_toon(layout: bpy.types.UILayout, own: bpy.types.PropertyGroup) -> None:
    layout.prop(own, 'toon_lit')
    layout.prop(own, 'toon_shade')
    layout.prop(own, 'toon_steps')


def draw_whitted(layout: bpy.types.UILayout, own: bpy.types.PropertyGroup) -> None:
    """What Whitted's formula has beside the model; a Principled node has its own mirror and transmission."""
    parts = layout.column(align=True)
    parts.prop(own, 'ka')
    if own.model != 'PRINCIPLED':
        parts.prop(own, 'kr')
        parts.prop(own, 'kt')
    layout.column().prop(own, 'absorption')


def register_presets() -> None:
    if hasattr(bpy.utils, 'register_preset_path'):  # else Blender shows the user's own presets alone
        bpy.utils.register_preset_path(ROOT)


def unregister_presets() -> None:
    if hasattr(bpy.utils, 'unregister_preset_path'):
        bpy.utils.unregister_preset_path(ROOT)


CLASSES = (
    COTORRA_PT_material_presets,
    COTORRA_OT_material_preset_add,
    COTORRA_MATERIAL_PT_model,
)
RENDER_CLASSES = (COTORRA_RENDER_PT_model_override,)
