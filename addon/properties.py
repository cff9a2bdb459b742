# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings that a .blend file keeps for Cotorra: `scene.cotorra` and `view_layer.cotorra`.

Defaults follow Cycles where a setting of Cycles has the same meaning; nothing is read from Cycles' own settings.
"""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from .choices import BOUNCES_MAX, DEVICES, INTEGRATORS, SAMPLES_MAX, SEED_MAX


def tag_scene(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Blender does not see changes of an add-on's properties: with persistent data it would render the old ones."""
    settings.id_data.update_tag()


class CotorraSceneSettings(bpy.types.PropertyGroup):
    samples: IntProperty(
        name='Samples',
        description='Rays sent through each pixel. Twice the noise takes a quarter of the samples',
        default=64,
        min=1,
        max=SAMPLES_MAX,
        soft_max=4096,
        update=tag_scene,
    )
    seed: IntProperty(
        name='Seed',
        description='Number that the noise pattern starts from. The same seed gives the same image, bit for bit',
        default=0,
        min=0,
        max=SEED_MAX,
        update=tag_scene,
    )
    use_animated_seed: BoolProperty(
        name='Animate Seed',
        description='Add the frame number to the seed, so that the noise changes from frame to frame',
        default=False,
        update=tag_scene,
    )
    integrator: EnumProperty(
        name='Integrator',
        description='How much of the light in the scene is followed',
        items=INTEGRATORS,
        default='DIRECT',
        update=tag_scene,
    )
    device: EnumProperty(
        name='Device',
        description='What renders',
        items=DEVICES,
        default='CPU',
        update=tag_scene,
    )
    max_bounces: IntProperty(
        name='Total',
        description='Reflections that light may take on its way at most, of all kinds together',
        default=12,
        min=0,
        max=BOUNCES_MAX,
        soft_max=32,
        update=tag_scene,
    )
    diffuse_bounces: IntProperty(
        name='Diffuse',
        description='Diffuse reflections that light may take on its way at most',
        default=4,
        min=0,
        max=BOUNCES_MAX,
        soft_max=32,
        update=tag_scene,
    )
    glossy_bounces: IntProperty(
        name='Glossy',
        description='Glossy reflections that light may take on its way at most',
        default=4,
        min=0,
        max=BOUNCES_MAX,
        soft_max=32,
        update=tag_scene,
    )
    transparent_bounces: IntProperty(
        name='Transparent',
        description='Transparent surfaces that a ray may cross at most; the next one stops it',
        default=8,
        min=0,
        max=BOUNCES_MAX,
        soft_max=32,
        update=tag_scene,
    )
    use_adaptive_sampling: BoolProperty(
        name='Noise Threshold',
        description='Stop early in the parts of the image whose noise is already below the threshold',
        default=False,
        update=tag_scene,
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
    adaptive_min_samples: IntProperty(
        name='Min Samples',
        description='Samples that each pixel takes before its noise is judged. 0 chooses by the threshold',
        default=0,
        min=0,
        max=SAMPLES_MAX,
        soft_max=4096,
        update=tag_scene,
    )


class CotorraViewLayerSettings(bpy.types.PropertyGroup):
    use_pass_sample_count: BoolProperty(
        name='Sample Count',
        description='The part of the samples that each pixel took; below 1 where adaptive sampling stopped early',
        default=False,
        update=tag_scene,
    )


CLASSES = (CotorraSceneSettings, CotorraViewLayerSettings)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.cotorra = PointerProperty(type=CotorraSceneSettings)
    bpy.types.ViewLayer.cotorra = PointerProperty(type=CotorraViewLayerSettings)


def unregister() -> None:
    del bpy.types.ViewLayer.cotorra
    del bpy.types.Scene.cotorra
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
