# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's settings to `RenderSettings`, and what a scene asks for that is left out.

Reads the evaluated scene only, so that animated settings hold for the frame that is rendered.
"""

from __future__ import annotations

import bpy

from . import native, passes
from .export.buffers import RenderSettings
from .log import Log

# Fields of RenderSettings that are called as the scene's properties.
SAME_NAMES = (
    'ambient_strength',
    'use_ambient_occlusion',
    'ao_distance',
    'whitted_depth',
    'whitted_threshold',
    'use_transparent_shadows',
    'toon_outline',
    'outline_width',
    'outline_normal',
    'outline_depth',
    'outline_object',
)


def render_settings(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, native_passes: tuple[str, ...]
) -> RenderSettings:
    own = scene.cotorra
    return RenderSettings(
        integrator=own.integrator,
        samples=view_layer.samples or own.samples,
        seed=own.seed + (scene.frame_current if own.use_animated_seed else 0) & 0xFFFFFFFF,
        max_bounces=own.max_bounces,
        diffuse_bounces=own.diffuse_bounces,
        glossy_bounces=own.glossy_bounces,
        transmission_bounces=own.transmission_bounces,
        transparent_bounces=own.transparent_bounces,
        adaptive=own.use_adaptive_sampling,
        noise_threshold=own.noise_threshold,
        adaptive_min_samples=own.adaptive_min_samples,
        transparent_film=scene.render.film_transparent,
        threads=scene.render.threads,
        passes=native_passes,
        device=own.device,
        device_index=own.device_index,
        ray_tracing=own.ray_tracing,
        cache=str(native.cache_folder()),
        ambient_color=tuple(own.ambient_color),
        outline_color=tuple(own.outline_color),
        **{name: getattr(own, name) for name in SAME_NAMES},
    )


def warn_left_out(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, log: Log) -> None:
    """Name what the scene and the view layer ask for and will not get; objects and materials are the exporter's."""
    render = scene.render
    if render.use_motion_blur:
        log.warning(f'Scene "{scene.name}": motion blur is not rendered yet')
    if render.use_multiview:
        log.warning(f'Scene "{scene.name}": stereo views are not rendered yet, each view gets the same picture')
    for name in passes.missing(view_layer):
        log.warning(f'View layer "{view_layer.name}": pass "{name}" is not rendered yet')
