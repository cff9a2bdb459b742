# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's settings to `RenderSettings`, and what a scene asks for that is left out.

Reads the evaluated scene only, so that animated settings hold for the frame that is rendered.
"""

from __future__ import annotations

import bpy

from . import cycles_settings, native, passes, stats
from .export import bounds
from .export.buffers import RenderSettings
from .log import Log

# Fields of RenderSettings that are called as the scene's properties.
SAME_NAMES = (
    'adaptive_min_samples',
    'device',
    'device_index',
    'integrator',
    'ray_tracing',
    'use_ambient_occlusion',
    'whitted_depth',
    'use_transparent_shadows',
    'toon_outline',
    'outline_normal',
    'outline_depth',
    'outline_object',
)
# As those, numbers that Blender lets be NaN.
NUMBERS = ('noise_threshold', 'ambient_strength', 'whitted_threshold', 'outline_width')
BOUNCES = ('max_bounces', 'diffuse_bounces', 'glossy_bounces', 'transmission_bounces', 'transparent_bounces')
COLORS = ('ambient_color', 'outline_color')


def render_settings(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, native_passes: tuple[str, ...], log: Log
) -> RenderSettings:
    own = scene.cotorra
    return RenderSettings(
        samples=_samples(scene, view_layer),
        seed=own.seed + (scene.frame_current if own.use_animated_seed else 0) & 0xFFFFFFFF,
        adaptive=own.use_adaptive_sampling,
        transparent_film=scene.render.film_transparent,
        threads=scene.render.threads,
        passes=native_passes,
        cache=str(native.cache_folder()),
        ao_distance=_number(*cycles_settings.source(scene, 'ao_distance'), scene, log),
        **{name: cycles_settings.inherited(scene, name) for name in BOUNCES},
        **{name: getattr(own, name) for name in SAME_NAMES},
        **{name: _number(own, name, scene, log) for name in NUMBERS},
        **{name: _color(own, name, scene, log) for name in COLORS},
    )


def film(scene: bpy.types.Scene, log: Log) -> dict[str, float | None]:
    """What passes.write does with the light of the film: Cycles' exposure, and the white of Reinhard's curve."""
    own, cycles = scene.cotorra, getattr(scene, 'cycles', None)  # absent where the Cycles add-on is disabled
    return {
        'exposure': 1.0 if cycles is None else _number(cycles, 'film_exposure', scene, log),
        'white': _number(own, 'reinhard_white', scene, log) if own.use_reinhard else None,
    }


def _samples(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> int:
    """The scene's samples, or the view layer's, as Cycles' setting for these says."""
    scenes, layers = scene.cotorra.samples, view_layer.samples
    use = getattr(getattr(scene, 'cycles', None), 'use_layer_samples', 'USE')
    if layers == 0 or use == 'IGNORE':
        return scenes
    return min(scenes, layers) if use == 'BOUNDED' else layers


def _number(owner: bpy.types.bpy_struct, name: str, scene: bpy.types.Scene, log: Log) -> float:
    return bounds.of_property(owner, name, _warner(scene, log))


def _color(owner: bpy.types.bpy_struct, name: str, scene: bpy.types.Scene, log: Log) -> tuple[float, ...]:
    found = owner.bl_rna.properties[name]
    return bounds.color(getattr(owner, name), found.default_array, found.name, _warner(scene, log))


def _warner(scene: bpy.types.Scene, log: Log) -> bounds.Warn:
    return lambda text: log.warning(f'Scene "{scene.name}": {text}')


def warn_left_out(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, log: Log) -> None:
    """Name what the scene and the view layer ask for and will not get; objects and materials are the exporter's."""
    first = not stats.last(scene.name)  # of the frame's view layers
    cycles_settings.warn_scene(scene, view_layer, log, tell_defaults=first)
    for name in passes.missing(view_layer):
        log.warning(f'View layer "{view_layer.name}": pass "{name}" is not rendered yet')
