# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings that a .blend file keeps for Cotorra: `scene.cotorra` and `view_layer.cotorra`, and where all hang.

Defaults follow Cycles where a setting of Cycles has the same meaning. Which of Cycles' own settings are read beside
these, or in their place where they were never set, is told in cycles_settings.py and settings.py.
"""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import devices
from .choices import (
    AUTO_ROWS,
    BOUNCES_MAX,
    DENOISING_INPUTS,
    DENOISING_PREFILTERS,
    DENOISING_QUALITIES,
    DEVICE_INDEX_MAX,
    DEVICES,
    HEALTHS,
    INTEGRATORS,
    RAY_TRACINGS,
    REWEIGHTING_MAX,
    SAMPLES_MAX,
    SECONDS_MAX,
    SEED_MAX,
    SETTINGS_FROM,
    TOLERANCES,
    VIEWPORT_PASSES,
    WHITTED_DEPTH_MAX,
)
from .lamps import lamp_names
from .light_settings import CotorraLightSettings
from .material_settings import CotorraMaterialSettings, color
from .material_settings import tag_owner as tag_scene


def switch(name: str, description: str, default: bool = False) -> BoolProperty:
    return BoolProperty(name=name, description=description, default=default, update=tag_scene)


def bounces(name: str, description: str, default: int) -> IntProperty:
    return IntProperty(
        name=name, description=description, default=default, min=0, max=BOUNCES_MAX, soft_max=32, update=tag_scene
    )


def count(name: str, description: str, default: int, least: int = 0, soft_max: int = 4096) -> IntProperty:
    """Of samples."""
    return IntProperty(
        name=name,
        description=description,
        default=default,
        min=least,
        max=SAMPLES_MAX,
        soft_max=soft_max,
        update=tag_scene,
    )


def choice(name: str, description: str, items: tuple, default: str) -> EnumProperty:
    return EnumProperty(name=name, description=description, items=items, default=default, update=tag_scene)


def auto_row(key: str) -> BoolProperty:
    """The switch of something that integrator AUTO may simplify."""
    return next(switch(name, text, True) for row, name, text in AUTO_ROWS if row == key)


AS_CYCLES = "Until it is set, the scene's limit for Cycles holds"


# The choice of a graphics card by name. What is kept, and what scripts set, is its index.
def card_items(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> list[tuple[str, str, str, int]]:
    return devices.items(settings.device_index)


def card_number(settings: bpy.types.PropertyGroup) -> int:
    return settings.device_index + 1


def choose_card(settings: bpy.types.PropertyGroup, number: int) -> None:
    settings.device_index = number - 1


class CotorraSceneSettings(bpy.types.PropertyGroup):
    # Integrator AUTO
    auto_tolerance: FloatProperty(
        name='Tolerance',
        description='How far what AUTO leaves out may change the converged picture: root mean square over the pixels, '
        "as a part of the picture's mean",
        subtype='PERCENTAGE',
        default=1.0,
        min=TOLERANCES[0],
        max=TOLERANCES[1],
        soft_max=10.0,
        precision=2,
        update=tag_scene,
    )
    use_auto_integrator: auto_row('integrator')
    use_auto_bounces: auto_row('bounces')
    use_auto_diffuse: auto_row('diffuse')
    use_auto_glossy: auto_row('glossy')
    use_auto_transmission: auto_row('transmission')
    use_auto_transparent: auto_row('transparent')
    use_auto_models: auto_row('models')
    use_auto_light: auto_row('light')
    use_auto_sampling: auto_row('sampling')

    settings_from: choice(
        'Settings',
        'Whose settings hold for samples, bounces, clamping, caustics, denoising and the like',
        SETTINGS_FROM,
        'AUTO',
    )
    samples: count('Samples', 'Paths that start in each pixel. Four times as many halve the noise', 64, least=1)
    seed: IntProperty(
        name='Seed',
        description='Number that the noise pattern starts from. The same seed gives the same image, bit for bit',
        default=0,
        min=0,
        max=SEED_MAX,
        update=tag_scene,
    )
    use_animated_seed: switch(
        'Animate Seed', 'Add the frame number to the seed, so that the noise changes from frame to frame'
    )
    integrator: choice('Integrator', 'How much of the light in the scene is followed', INTEGRATORS, 'PATH')
    device: choice('Device', 'The processor that renders', DEVICES, 'CPU')
    device_index: IntProperty(
        name='Graphics Card',
        description='Which graphics card renders, counted from 0. -1: the best that can',
        default=-1,
        min=-1,
        max=DEVICE_INDEX_MAX,
        update=tag_scene,
    )
    graphics_card: EnumProperty(
        name='Graphics Card',
        description='Which graphics card renders',
        items=card_items,
        get=card_number,
        set=choose_card,
        options={'SKIP_SAVE'},
    )
    ray_tracing: choice(
        'Ray Tracing', 'What finds the surfaces that rays meet, on a graphics card', RAY_TRACINGS, 'AUTO'
    )
    use_device_fallback: switch(
        'Fall Back to CPU',
        'Where the graphics card cannot render the scene, or lacks the memory, let the CPU do it',
        True,
    )
    max_bounces: bounces(
        'Total', f'Reflections that light may take on its way at most, of all kinds together. {AS_CYCLES}', 12
    )
    diffuse_bounces: bounces('Diffuse', f'Diffuse reflections that light may take on its way at most. {AS_CYCLES}', 4)
    glossy_bounces: bounces('Glossy', f'Glossy reflections that light may take on its way at most. {AS_CYCLES}', 4)
    transmission_bounces: bounces(
        'Transmission', 'Passages of light through glass and other surfaces on its way at most', 12
    )
    transparent_bounces: bounces(
        'Transparent', f'Transparent surfaces that a ray may cross at most; the next one stops it. {AS_CYCLES}', 8
    )
    use_adaptive_sampling: switch(
        'Noise Threshold', 'Stop early in the parts of the image whose noise is already below the threshold'
    )
    noise_threshold: FloatProperty(
        name='Noise Threshold',
        description='Noise at which a pixel is finished. Lower is cleaner and takes longer',
        default=0.01,
        min=0.0001,
        max=1.0,
        soft_min=0.001,
        precision=4,
        update=tag_scene,
    )
    adaptive_min_samples: count(
        'Min Samples', 'Samples that each pixel takes before its noise is judged. 0 chooses by the threshold', 0
    )

    # The Rendered viewport
    preview_samples: count(
        'Viewport Samples', 'Paths that start in each pixel of the viewport. 0 goes on for as long as it is shown', 1024
    )
    use_preview_adaptive_sampling: switch(
        'Viewport Noise Threshold', 'Stop early in the parts of the viewport whose noise is below the threshold', True
    )
    preview_noise_threshold: FloatProperty(
        name='Viewport Noise Threshold',
        description='Noise at which a pixel of the viewport is finished. Lower is cleaner and takes longer',
        default=0.1,
        min=0.0,
        max=1.0,
        soft_min=0.001,
        precision=4,
        update=tag_scene,
    )
    preview_adaptive_min_samples: count(
        'Viewport Min Samples',
        'Samples that each pixel takes before its noise is judged. 0 chooses by the threshold',
        0,
    )
    use_preview_denoising: switch('Viewport Denoise', 'Take the noise out of the viewport with OpenImageDenoise')
    preview_denoising_start_sample: count(
        'Start Sample', 'Samples that the viewport takes before it is denoised', 1, soft_max=128
    )
    preview_denoising_inputs: choice('Passes', 'What tells noise from detail', DENOISING_INPUTS, 'RGB_ALBEDO')
    preview_denoising_prefilter: choice(
        'Prefilter', 'What is done about noise in albedo and normal', DENOISING_PREFILTERS, 'FAST'
    )
    preview_denoising_quality: choice(
        'Quality', 'Quality of the denoised viewport against time', DENOISING_QUALITIES, 'FAST'
    )
    preview_pause: switch('Pause Preview', 'Leave the Rendered viewport as it is')

    time_limit: FloatProperty(
        name='Time Limit',
        description='Stop after this time, at the first sample of each pixel at the earliest. 0 for no limit',
        subtype='TIME_ABSOLUTE',
        unit='TIME_ABSOLUTE',
        default=0.0,
        min=0.0,
        max=SECONDS_MAX,
        soft_max=3600.0,
        update=tag_scene,
    )

    # Against fireflies: all of them take light away
    clamp_direct: FloatProperty(
        name='Direct Light',
        description='Most light that one sample brings straight from a light, the mean of its channels. 0 for no limit',
        default=0.0,
        min=0.0,
        soft_max=100.0,
        update=tag_scene,
    )
    clamp_indirect: FloatProperty(
        name='Indirect Light',
        description='Most light that one sample brings after a bounce, the mean of its channels. 0 for no limit',
        default=0.0,
        min=0.0,
        soft_max=100.0,
        update=tag_scene,
    )
    light_threshold: FloatProperty(
        name='Light Threshold',
        description='Light below which shadow rays are traced at random, without a change of the mean. 0 traces all',
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=4,
        update=tag_scene,
    )
    filter_glossy: FloatProperty(
        name='Filter Glossy',
        description='Blur reflections that are seen by way of rough surfaces. 0 for none',
        default=0.0,
        min=0.0,
        soft_max=10.0,
        update=tag_scene,
    )
    use_reweighting: switch(
        'Reweight Fireflies',
        'Let samples that are far brighter than all around them count less, the less the fewer there are. The plain '
        'mean stays in the pass "Unweighted Image". While the settings are those for Cycles it has no effect',
        True,
    )
    reweighting_strength: FloatProperty(
        name='Strength',
        description='How strictly fireflies are held back. At 1 those of a brightness may add half of what is around '
        'them, at 2 a quarter',
        default=1.0,
        min=1.0 / REWEIGHTING_MAX,
        max=REWEIGHTING_MAX,
        soft_min=0.1,
        soft_max=10.0,
        update=tag_scene,
    )
    reflective_caustics: switch('Reflective', 'Light that mirrors and gloss throw onto rough surfaces', True)
    refractive_caustics: switch('Refractive', 'Light that glass throws onto rough surfaces', True)
    use_sample_sharing: switch(
        'Share Samples',
        'Let each sample count for all pixels whose filter reaches it, not for its own alone: the same picture with '
        'about half of the variance, whose noise is a little coarser. Not in pictures that are denoised or reweighted, '
        'nor beside passes that add up to them: light groups, single lamps, D, G, F',
        True,
    )

    # Denoising
    use_denoising: switch(
        'Denoise', 'Take the noise out of the picture with OpenImageDenoise, once it is rendered', True
    )
    denoising_inputs: choice('Passes', 'What tells noise from detail', DENOISING_INPUTS, 'RGB_ALBEDO_NORMAL')
    denoising_prefilter: choice(
        'Prefilter', 'What is done about noise in albedo and normal', DENOISING_PREFILTERS, 'ACCURATE'
    )
    denoising_quality: choice('Quality', 'Quality of the denoised picture against time', DENOISING_QUALITIES, 'HIGH')

    # One model for everything
    use_model_override: switch('Model Override', 'Render all materials with one reflection model, to compare models')
    model_override: PointerProperty(
        name='Model Override',
        description='The model, and its parameters. Base color, roughness and metallic stay those of each material',
        type=CotorraMaterialSettings,
    )

    # Ambient light and occlusion
    ambient_color: color('Ambient Color', 'Color of the light that is everywhere', (1.0, 1.0, 1.0))
    ambient_strength: FloatProperty(
        name='Ambient Strength',
        description='Strength of the light that is everywhere (Whitted and Direct)',
        default=0.0,
        min=0.0,
        soft_max=1.0,
        update=tag_scene,
    )
    use_ambient_occlusion: switch('Ambient Occlusion', 'Darken the ambient light where surfaces are near')
    ao_distance: FloatProperty(
        name='Distance',
        description="How far a surface may be to darken another. Until it is set, the world's distance holds",
        subtype='DISTANCE',
        default=10.0,
        min=0.0,
        soft_max=100.0,
        update=tag_scene,
    )

    # Whitted
    whitted_depth: IntProperty(
        name='Depth',
        description='Mirrors and glass surfaces, one after the other, that a ray may meet at most',
        default=8,
        min=0,
        max=WHITTED_DEPTH_MAX,
        soft_max=16,
        update=tag_scene,
    )
    whitted_threshold: FloatProperty(
        name='Threshold',
        description='Leave out rays that add less than this part to the picture',
        default=0.003,
        min=0.0,
        max=1.0,
        soft_max=0.1,
        precision=4,
        update=tag_scene,
    )
    use_transparent_shadows: switch(
        'Transparent Shadows', 'Let the light of lamps go straight through glass, as if it did not refract'
    )

    # Toon
    toon_outline: switch('Outlines', 'Draw lines where the surface turns, ends or changes', True)
    outline_width: FloatProperty(
        name='Width',
        description="Width of the lines, as a part of the picture's height",
        subtype='PERCENTAGE',
        default=0.3,
        min=0.0,
        max=10.0,
        soft_max=2.0,
        precision=2,
        update=tag_scene,
    )
    outline_color: color('Color', 'Color of the lines', (0.0, 0.0, 0.0))
    outline_normal: switch('Normal', 'Lines where the normal turns sharply', True)
    outline_depth: switch('Depth', 'Lines where the distance jumps', True)
    outline_object: switch('Object', 'Lines between objects', True)

    health: choice(
        'Numerical Health',
        'Whether bad samples are counted, on the CPU, and what becomes of a render that has some',
        HEALTHS,
        'OFF',
    )

    # Film
    use_reinhard: switch(
        'Reinhard',
        'Compress bright light into what a display shows (Reinhard et al. 2002). Combined is then no longer '
        'scene-linear: set the view transform to Standard, and do not light by it',
    )
    reinhard_white: FloatProperty(
        name='White',
        description='Luminance that becomes white; what is brighter burns out',
        default=4.0,
        min=0.01,
        soft_max=100.0,
        update=tag_scene,
    )


class CotorraViewLayerSettings(bpy.types.PropertyGroup):
    use_pass_sample_count: switch(
        'Sample Count',
        'The part of the samples that each pixel took; below 1 where adaptive sampling stopped early',
    )
    use_pass_noise: switch(
        'Noise', 'Pass "Cotorra Noise": the error that each pixel still has, as adaptive sampling estimates it'
    )
    use_pass_health: switch(
        'Numerical Health',
        'Pass "Cotorra Health": of each pixel the samples that are not finite (X), negative (Y) and fireflies (Z)',
    )
    use_pass_distribution: switch(
        'Distribution', 'Pass "Cotorra D": the distribution term of the surface, for each lamp above it, summed'
    )
    use_pass_masking: switch(
        'Masking', 'Pass "Cotorra G": the masking term of the surface, for each lamp above it, summed'
    )
    use_pass_fresnel: switch(
        'Fresnel', 'Pass "Cotorra F": the Fresnel term of the surface, for each lamp above it, summed'
    )
    use_pass_lights: switch(
        'Each Light', 'A pass for each light, which shows it alone; named "Light" and after the light'
    )


class CotorraShadingSettings(bpy.types.PropertyGroup):
    """Of one 3D viewport."""

    render_pass: EnumProperty(
        name='Pass',
        description='What the Rendered viewport shows',
        items=[(identifier, name, text) for identifier, _, name, text in VIEWPORT_PASSES],
        default='COMBINED',
    )
    light: StringProperty(
        name='Light',
        description='The light that is shown alone',
        search=lambda _, context, text: list(lamp_names(context.view_layer.objects)),
    )
    light_group: StringProperty(name='Light Group', description='The light group that is shown alone')


# Those that others refer to come first.
CLASSES = (
    CotorraMaterialSettings,
    CotorraLightSettings,
    CotorraSceneSettings,
    CotorraViewLayerSettings,
    CotorraShadingSettings,
)
OWNERS = (
    (bpy.types.Material, CotorraMaterialSettings),
    (bpy.types.Light, CotorraLightSettings),
    (bpy.types.Scene, CotorraSceneSettings),
    (bpy.types.ViewLayer, CotorraViewLayerSettings),
    (bpy.types.View3DShading, CotorraShadingSettings),
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for owner, cls in OWNERS:
        owner.cotorra = PointerProperty(type=cls)


def unregister() -> None:
    for owner, _ in OWNERS:
        del owner.cotorra
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
