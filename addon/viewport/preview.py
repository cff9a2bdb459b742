# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport renders by: the scene's settings, with samples and noise threshold of its own, and what it shows.

Final renders read settings.py alone.
"""

from __future__ import annotations

from dataclasses import replace

import bpy

from .. import cycles_settings, settings
from ..choices import LIGHT_GROUP_PASS, LIGHT_PASS, SAMPLES_MAX, VIEWPORT_PASSES
from ..denoise import Denoising
from ..export.buffers import RenderSettings
from ..lamps import lone_lamp
from ..log import Log

COMBINED = 'combined'
NATIVE_PASSES = {identifier: native for identifier, native, *_ in VIEWPORT_PASSES}


def render_settings(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, shown: str, log: Log) -> RenderSettings:
    """For the viewport. scene and view_layer are the evaluated ones; shown: the native pass."""
    how = denoising(scene, shown)
    features = () if how is None else how.features()
    native_passes = tuple(dict.fromkeys((COMBINED, shown, *features)))
    found = settings.render_settings(scene, view_layer, native_passes, log)
    return replace(
        found,
        sharing=settings.shares_samples(scene, native_passes, how),
        # As in Cycles, 0 goes on for as long as one looks.
        samples=cycles_settings.inherited(scene, 'preview_samples') or SAMPLES_MAX,
        adaptive=cycles_settings.inherited(scene, 'use_preview_adaptive_sampling'),
        noise_threshold=settings.inherited_number(scene, 'preview_noise_threshold', log) or 0.01,
        adaptive_min_samples=cycles_settings.inherited(scene, 'preview_adaptive_min_samples'),
    )


def denoising(scene: bpy.types.Scene, shown: str) -> Denoising | None:
    """How the viewport is denoised; None where it shows what there is."""
    wanted = cycles_settings.inherited(scene, 'use_preview_denoising')
    if not wanted or shown != COMBINED or scene.cotorra.integrator not in settings.DENOISED:
        return None
    names = ('inputs', 'prefilter', 'quality')
    how = {name: cycles_settings.inherited(scene, f'preview_denoising_{name}') for name in names}
    return Denoising(threads=scene.render.threads, **how)


def denoising_start(scene: bpy.types.Scene) -> int:
    """Samples from which on the viewport is denoised."""
    return cycles_settings.inherited(scene, 'preview_denoising_start_sample')


def shown_pass(space: bpy.types.SpaceView3D, view_layer: bpy.types.ViewLayer) -> tuple[str, str]:
    """The native pass that a 3D viewport shows, and why that is Combined where another is wanted."""
    own = space.shading.cotorra
    if own.render_pass == LIGHT_PASS:
        alone = lone_lamp(space)
        if alone is None:
            return COMBINED, 'No light is chosen'
        return 'light:0', '' if alone in view_layer.objects else f'There is no light "{alone}"'
    if own.render_pass == LIGHT_GROUP_PASS:
        index = view_layer.lightgroups.find(own.light_group)
        if index < 0:
            name = own.light_group
            return COMBINED, f'There is no light group "{name}"' if name else 'No light group is chosen'
        return f'lightgroup:{index}', ''
    return NATIVE_PASSES[own.render_pass], ''


def paused(scene: bpy.types.Scene) -> bool:
    return cycles_settings.inherited(scene, 'preview_pause')


def pixel_size(scene: bpy.types.Scene, preferences: bpy.types.Preferences) -> int:
    """Screen pixels along a side of each rendered one, at rest: Blender's setting."""
    wanted = scene.render.preview_pixel_size
    if wanted != 'AUTO':
        return int(wanted)
    return 2 if preferences.system.pixel_size > 1.5 else 1
