# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of sampling, in the header of its panel: samples, noise threshold, time limit, denoising, weights of
fireflies.

A preset takes the settings away from Cycles', or it would change nothing that holds.
"""

from __future__ import annotations

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..choices import ENGINE

PRESETS = 'cotorra/sampling'
SETTINGS = (
    'settings_from',
    'samples',
    'use_adaptive_sampling',
    'noise_threshold',
    'adaptive_min_samples',
    'time_limit',
    'use_denoising',
    'denoising_inputs',
    'denoising_prefilter',
    'denoising_quality',
    'use_reweighting',
    'reweighting_strength',
    'use_sample_sharing',
)


class COTORRA_PT_sampling_presets(PresetPanel, bpy.types.Panel):
    bl_label = 'Sampling Presets'
    preset_subdir = PRESETS
    preset_operator = 'script.execute_preset'
    preset_add_operator = 'render.cotorra_sampling_preset_add'
    COMPAT_ENGINES = {ENGINE}


class COTORRA_OT_sampling_preset_add(AddPresetBase, bpy.types.Operator):
    """Add or remove a preset of sampling and denoising"""

    bl_idname = 'render.cotorra_sampling_preset_add'
    bl_label = 'Add Sampling Preset'
    preset_menu = 'COTORRA_PT_sampling_presets'
    preset_subdir = PRESETS
    preset_defines = ['own = bpy.context.scene.cotorra']
    preset_values = [f'own.{name}' for name in SETTINGS]


CLASSES = (COTORRA_PT_sampling_presets, COTORRA_OT_sampling_preset_add)
