# SPDX-License-Identifier: GPL-3.0-or-later
"""One set of render settings for both engines, so that they solve the same problem with the same means.

It runs in Blender. What is measured is not here; what is rendered is in `scenes.py`.
"""

from __future__ import annotations

import bpy

# What is set and why, for the head of the report.
RULES = (
    'same scene, resolution, threads, pixel filter, bounces (total = diffuse = glossy = transmission) for both',
    'off for both: adaptive sampling, denoising, clamping, Filter Glossy, time limit; in Cotorra: weights of fireflies',
    'off in Cycles: light threshold, guiding, fast GI, tiling',
    'on in Cycles: caustics, light tree (its default), automatic sampling pattern (its default)',
    'off for both: motion blur, compositor, sequencer, simplify, persistent data',
)


def make_fair(scene: bpy.types.Scene, engine: str, bounces: int, size: tuple[int, int], threads: int) -> None:
    """Everything but samples, seed and file name."""
    render = scene.render
    render.engine = engine
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100
    render.use_border = False
    render.threads_mode, render.threads = 'FIXED', threads
    render.use_motion_blur = False
    render.use_compositing = False
    render.use_sequencer = False
    render.use_simplify = False
    render.use_persistent_data = False
    image = render.image_settings
    if hasattr(image, 'media_type'):  # Blender 5: a file set to video or multilayer refuses the formats of images
        image.media_type = 'IMAGE'
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = 'OPEN_EXR', 'RGBA', '32', 'ZIP'

    cycles = scene.cycles
    cycles.device = 'CPU'
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.use_preview_denoising = False
    cycles.use_guiding = False
    cycles.use_fast_gi = False
    cycles.use_auto_tile = False
    cycles.use_sample_subset = False
    cycles.time_limit = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.light_sampling_threshold = 0
    cycles.min_light_bounces = cycles.min_transparent_bounces = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.use_light_tree = True
    cycles.sampling_pattern = 'AUTOMATIC'
    cycles.pixel_filter_type, cycles.filter_width = 'BLACKMAN_HARRIS', 1.5
    # A mesh light or the world may have a limit of its own; that is the scene's business. These are the scene's limits.
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 8

    cycles.use_layer_samples = 'IGNORE'
    for layer in scene.view_layers:
        layer.samples = 0

    if hasattr(scene, 'cotorra'):
        ours = scene.cotorra
        ours.device = 'CPU'
        ours.integrator = 'PATH' if bounces else 'DIRECT'
        ours.settings_from = 'COTORRA'
        ours.use_adaptive_sampling = ours.use_denoising = ours.use_reweighting = False
        ours.time_limit = 0
        ours.clamp_direct = ours.clamp_indirect = ours.filter_glossy = ours.light_threshold = 0
        ours.reflective_caustics = ours.refractive_caustics = True
        ours.max_bounces = ours.diffuse_bounces = ours.glossy_bounces = ours.transmission_bounces = bounces
        ours.transparent_bounces = 8


def as_shipped(scene: bpy.types.Scene) -> None:
    """What Cycles has on where nobody touched it, of what changes how long an error takes and not the picture."""
    cycles = scene.cycles
    cycles.use_adaptive_sampling, cycles.adaptive_threshold, cycles.adaptive_min_samples = True, 0.01, 0
    cycles.light_sampling_threshold = 0.01
    cycles.use_light_tree = True


def set_job(scene: bpy.types.Scene, samples: int, seed: int, output: str, sharing: bool = False) -> None:
    """What changes from one render to the next. sharing: our samples count for all pixels that their filter reaches, as
    is our default. What is compared tile by tile, references too, does without: its pixels are taken as independent."""
    if hasattr(scene, 'cotorra'):
        scene.cotorra.use_sample_sharing = sharing
    scene.render.filepath = output
    scene.render.use_file_extension = False
    for settings in (scene.cycles, getattr(scene, 'cotorra', scene.cycles)):
        settings.samples, settings.seed = samples, seed
