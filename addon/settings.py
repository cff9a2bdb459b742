# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's settings to `RenderSettings`, and what a scene asks for that is left out.

Reads the evaluated scene only, so that animated settings hold for the frame that is rendered.
"""

from __future__ import annotations

import bpy
import numpy as np

from . import choices, cycles_settings, native, passes
from .denoise import Denoising
from .export import bounds
from .export.buffers import Camera, RenderSettings
from .log import Log

# Fields of RenderSettings that are called as the scene's properties.
SAME_NAMES = (
    'device',
    'device_index',
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
NUMBERS = ('ambient_strength', 'whitted_threshold', 'outline_width')
# Those in whose place Cycles' may hold; the second ones are numbers, too.
INHERITED = (
    'adaptive_min_samples',
    'reflective_caustics',
    'refractive_caustics',
    'max_bounces',
    'diffuse_bounces',
    'glossy_bounces',
    'transmission_bounces',
    'transparent_bounces',
)
INHERITED_NUMBERS = ('ao_distance', 'clamp_direct', 'clamp_indirect', 'filter_glossy', 'light_threshold')
DENOISED = ('PATH', 'DIRECT', 'AUTO')  # integrators whose pictures are noisy in the way that denoisers know
COLORS = ('ambient_color', 'outline_color')


def render_settings(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, native_passes: tuple[str, ...], log: Log
) -> RenderSettings:
    own = scene.cotorra
    samples = _samples(scene, view_layer)
    animated = cycles_settings.inherited(scene, 'use_animated_seed')
    return RenderSettings(
        # What AUTO leaves out is decided later, where there is a scene to look at.
        integrator='PATH' if own.integrator == 'AUTO' else own.integrator,
        samples=samples,
        seed=cycles_settings.inherited(scene, 'seed') + (scene.frame_current if animated else 0) & 0xFFFFFFFF,
        adaptive=cycles_settings.inherited(scene, 'use_adaptive_sampling'),
        noise_threshold=_noise_threshold(scene, samples, log),
        transparent_film=scene.render.film_transparent,
        threads=scene.render.threads,
        passes=native_passes,
        cache=str(native.cache_folder()),
        health=own.health != 'OFF' or 'health' in native_passes,
        firefly_limit=_firefly_limit(scene, samples),
        reweighting=reweighting(scene, log),
        white=_white(scene),
        sharing=shares_samples(scene, native_passes, denoising(scene, view_layer)),
        **{name: cycles_settings.inherited(scene, name) for name in INHERITED},
        **{name: inherited_number(scene, name, log) for name in INHERITED_NUMBERS},
        **{name: getattr(own, name) for name in SAME_NAMES},
        **{name: _number(own, name, scene, log) for name in NUMBERS},
        **{name: _color(own, name, scene, log) for name in COLORS},
    )


def reweights(scene: bpy.types.Scene) -> bool:
    """Whether fireflies are held back by their weight."""
    own = scene.cotorra
    holds = cycles_settings.holds_of_ours(scene, 'use_reweighting') and own.integrator in DENOISED
    return holds and own.use_reweighting


def reweighting(scene: bpy.types.Scene, log: Log) -> float:
    """How strictly; 0: not at all."""
    strength = _number(scene.cotorra, 'reweighting_strength', scene, log)
    return strength if reweights(scene) else 0.0


def shares_samples(scene: bpy.types.Scene, native_passes: tuple[str, ...], how: Denoising | None) -> bool:
    """Whether samples count for all pixels around them.

    Denoisers know noise that is another in each pixel; passes that add up to Combined have each pixel's own samples.
    """
    parts = any(name.startswith(('lightgroup:', 'light:', 'term_')) for name in native_passes)
    return scene.cotorra.use_sample_sharing and how is None and not parts


def _white(scene: bpy.types.Scene) -> float:
    """Radiance that is shown as white: by the exposures of Cycles' film and of the view."""
    exposure = getattr(getattr(scene, 'cycles', None), 'film_exposure', 1.0) * 2.0**scene.view_settings.exposure
    return min(max(1.0 / exposure, 1e-6), 1e6) if exposure > 0.0 else 1.0


def _firefly_limit(scene: bpy.types.Scene, samples: int) -> float:
    """Radiance of a sample that alone turns its pixel white."""
    exposure = getattr(getattr(scene, 'cycles', None), 'film_exposure', 1.0)
    return samples / exposure if exposure > 0.0 else 1e30


def film(scene: bpy.types.Scene, camera: Camera, log: Log) -> passes.Film:
    """Cycles' exposure, the white of Reinhard's curve, and the camera's space: x to the right, y up, z forward."""
    own, cycles = scene.cotorra, getattr(scene, 'cycles', None)  # absent where the Cycles add-on is disabled
    return passes.Film(
        exposure=1.0 if cycles is None else _number(cycles, 'film_exposure', scene, log),
        white=_number(own, 'reinhard_white', scene, log) if own.use_reinhard else None,
        view=(camera.transform[:, :3] * np.array((1.0, 1.0, -1.0), np.float32)).T,
    )


def denoising(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Denoising | None:
    """How the picture is denoised; None where it stays as it is."""
    owner, name = cycles_settings.source(scene, 'use_denoising')
    layer = getattr(view_layer, 'cycles', None)
    # Cycles has a switch for each view layer, beside the scene's.
    wanted = getattr(owner, name) and (owner == scene.cotorra or layer is None or layer.use_denoising)
    if not wanted or scene.cotorra.integrator not in DENOISED:
        return None
    how = {name: cycles_settings.inherited(scene, f'denoising_{name}') for name in ('inputs', 'prefilter', 'quality')}
    return Denoising(threads=scene.render.threads, **how)


def time_limit(scene: bpy.types.Scene, log: Log) -> float:
    """Seconds after which rendering stops; 0: none."""
    return inherited_number(scene, 'time_limit', log)


def auto_tolerance(scene: bpy.types.Scene, log: Log) -> float:
    """As a share of the picture's mean."""
    return _number(scene.cotorra, 'auto_tolerance', scene, log) / 100.0


def auto_rows(own: bpy.types.PropertyGroup) -> frozenset[str]:
    """The rows of AUTO that are on, by their keys in choices.AUTO_ROWS."""
    return frozenset(key for key, _, _ in choices.AUTO_ROWS if getattr(own, f'use_auto_{key}'))


def _noise_threshold(scene: bpy.types.Scene, samples: int, log: Log) -> float:
    """Where it is 0, Cycles takes one that suits the samples."""
    return inherited_number(scene, 'noise_threshold', log) or max(0.001, 1.0 / samples)


def inherited_number(scene: bpy.types.Scene, name: str, log: Log) -> float:
    """Ours or Cycles', whichever holds, within what can be rendered; a warning where it is not."""
    return _number(*cycles_settings.source(scene, name), scene, log)


def _samples(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> int:
    """The scene's samples, or the view layer's, as Cycles' setting for these says."""
    scenes, layers = cycles_settings.inherited(scene, 'samples'), view_layer.samples
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
    cycles_settings.warn_scene(scene, view_layer, log)
    for name in passes.missing(view_layer):
        log.warning(f'View layer "{view_layer.name}": pass "{name}" is not rendered yet')
