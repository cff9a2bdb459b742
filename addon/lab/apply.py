# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives a scene the settings of a series: for the worker, and for the user who picks a row of a chart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import choices, cycles_settings
from ..terminal import CommandError
from . import plan

if TYPE_CHECKING:
    import bpy

EEVEE_NAMES = ('BLENDER_EEVEE', 'BLENDER_EEVEE_NEXT')


def apply(scene: bpy.types.Scene, series: plan.Series, samples: int) -> None:
    """Engine, integrator, model, device, samples, adaptive stop and denoising; the rest stays, but weights of fireflies
    are off where they were not set.

    CommandError where the engine is not there.
    """
    count = samples * plan.ADAPTIVE_REACH if series.adaptive else samples
    settings = {
        'samples': count,
        'use_adaptive_sampling': series.adaptive,
        'noise_threshold': max(0.0001, plan.ADAPTIVE_NOISE / samples**0.5),
        'use_denoising': series.denoised,
    }
    if not series.adaptive:
        del settings['noise_threshold']
    for layer in scene.view_layers:
        layer.samples = 0
        if series.denoised and hasattr(layer, 'cycles'):
            layer.cycles.use_denoising = True
    render = scene.render
    if series.engine == 'COTORRA':
        render.engine = choices.ENGINE
        for name, value in settings.items():
            cycles_settings.override(scene, name, value)
        if not scene.cotorra.is_property_set('use_reweighting'):  # a bias that nobody asked for
            scene.cotorra.use_reweighting = False
        scene.cotorra.integrator = series.integrator
        scene.cotorra.device = series.device
        scene.cotorra.use_model_override = bool(series.model)
        if series.model:
            scene.cotorra.model_override.model = series.model
    elif series.engine == 'CYCLES':
        if not hasattr(scene, 'cycles'):
            raise CommandError('Cycles is not there: its add-on is disabled')
        render.engine = 'CYCLES'
        scene.cycles.device = 'CPU'
        for name, value in settings.items():
            setattr(scene.cycles, cycles_settings.INHERITED[name].removeprefix('cycles.'), value)
    else:
        set_eevee(render)
        scene.eevee.taa_render_samples = samples


def set_eevee(render: bpy.types.RenderSettings) -> None:
    """By the name that this Blender has for it."""
    for name in EEVEE_NAMES:
        try:
            render.engine = name
            return
        except TypeError:
            continue
    raise CommandError('EEVEE is not there')
