# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of each setting that Cycles has: read, named in a warning where it changes the picture, or of no effect.

It renders nothing and reads no object: those who export an object, light, material or world ask here what to say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache

import bpy

from .log import Log

# Our settings in whose place the file's own for Cycles are read, by their path in the scene; see `source`.
INHERITED = {
    'samples': 'cycles.samples',
    'use_adaptive_sampling': 'cycles.use_adaptive_sampling',
    'noise_threshold': 'cycles.adaptive_threshold',
    'adaptive_min_samples': 'cycles.adaptive_min_samples',
    'time_limit': 'cycles.time_limit',
    'seed': 'cycles.seed',
    'use_animated_seed': 'cycles.use_animated_seed',
    'clamp_direct': 'cycles.sample_clamp_direct',
    'clamp_indirect': 'cycles.sample_clamp_indirect',
    'filter_glossy': 'cycles.blur_glossy',
    'light_threshold': 'cycles.light_sampling_threshold',
    'reflective_caustics': 'cycles.caustics_reflective',
    'refractive_caustics': 'cycles.caustics_refractive',
    'use_denoising': 'cycles.use_denoising',
    'denoising_inputs': 'cycles.denoising_input_passes',
    'denoising_prefilter': 'cycles.denoising_prefilter',
    'denoising_quality': 'cycles.denoising_quality',
    'max_bounces': 'cycles.max_bounces',
    'diffuse_bounces': 'cycles.diffuse_bounces',
    'glossy_bounces': 'cycles.glossy_bounces',
    'transmission_bounces': 'cycles.transmission_bounces',
    'transparent_bounces': 'cycles.transparent_max_bounces',
    'ao_distance': 'world.light_settings.distance',
    'preview_samples': 'cycles.preview_samples',
    'use_preview_adaptive_sampling': 'cycles.use_preview_adaptive_sampling',
    'preview_noise_threshold': 'cycles.preview_adaptive_threshold',
    'preview_adaptive_min_samples': 'cycles.preview_adaptive_min_samples',
    'use_preview_denoising': 'cycles.use_preview_denoising',
    'preview_denoising_start_sample': 'cycles.preview_denoising_start_sample',
    'preview_denoising_inputs': 'cycles.preview_denoising_input_passes',
    'preview_denoising_prefilter': 'cycles.preview_denoising_prefilter',
    'preview_denoising_quality': 'cycles.preview_denoising_quality',
    'preview_pause': 'cycles.preview_pause',
}


@dataclass(frozen=True, slots=True)
class Named:
    """A setting that changes Cycles' picture and not ours.

    text:    what is said where it was changed.
    same:    the values with which both pictures are alike.
    matters: whether it can change the picture at all, by its owner and the scene.
    """

    name: str
    text: str
    same: tuple[object, ...] = (False,)
    matters: Callable[[bpy.types.bpy_struct, bpy.types.Scene], bool] | None = None


@dataclass(frozen=True, slots=True)
class Group:
    """All that Blender registers in one group of settings, names separated by spaces; * stands for any end of a name.

    read: what is rendered as Cycles does, or reported by whoever reads it.
    idle: what changes no picture here, by reason.
    """

    read: str = ''
    named: tuple[Named, ...] = ()
    idle: dict[str, str] = field(default_factory=dict)


def _simplified(_: bpy.types.bpy_struct, scene: bpy.types.Scene) -> bool:
    return scene.render.use_simplify


def _missed_pass(name: str, title: str) -> Named:
    return Named(name, f'pass "{title}" is not rendered yet')


# Reasons that many settings share.
NOISE = 'noise and time only'
OWN = 'Cotorra has a setting of its own'
VIEWPORT = 'the viewport only'
EEVEE = 'EEVEE and other engines only'
EDITING = 'how it is edited and drawn'
VOLUMES = 'volumes are named with their object, material or world'
BLENDER = "Blender's own work, before or after the engine's"
WITH_MOTION_BLUR = 'works with motion blur only, which is named'
WITH_FAST_GI = 'works with fast GI only, which is named'
WITH_CASTERS = 'works with casters of caustics only, which are named'
WITH_SUBDIVISION = 'works with adaptive subdivision only, which is named'

ADAPTIVE = 'adaptive subdivision is not supported yet: the levels of its modifier are used'

# By the identifier of the group's type. Names of 4.5 and 5.2 stand side by side.
GROUPS = {
    'CyclesRenderSettings': Group(
        read='max_bounces diffuse_bounces glossy_bounces transmission_bounces transparent_max_bounces '
        'film_exposure filter_width pixel_filter_type use_layer_samples use_camera_cull use_distance_cull '
        'samples use_adaptive_sampling adaptive_threshold adaptive_min_samples time_limit seed use_animated_seed '
        'sample_clamp_direct sample_clamp_indirect blur_glossy caustics_reflective caustics_refractive use_denoising '
        'denoising_input_passes denoising_prefilter denoising_quality light_sampling_threshold',
        named=(
            Named('use_fast_gi', 'fast GI approximation is not supported yet: light bounces as it does without'),
            Named(
                'film_transparent_glass',
                'transparent glass is not supported yet: glass before a transparent film is opaque',
                matters=lambda _, scene: scene.render.film_transparent,
            ),
            Named('use_sample_subset', 'a sample subset is not supported yet: all samples are rendered'),
            Named('use_pixel_jitter', 'pixel jitter is not supported yet'),
            Named(
                'texture_limit_render',
                'images are not limited to {value} pixels yet (Simplify)',
                ('OFF',),
                matters=_simplified,
            ),
            Named(
                'texture_resolution_render',
                'the resolution of images is not reduced to {value:g} yet (Simplify)',
                (1.0,),
                matters=_simplified,
            ),
        ),
        idle={
            NOISE: 'use_light_tree min_light_bounces min_transparent_bounces *guiding* '
            'sampling_pattern *scrambling_distance',
            OWN: 'device',
            VIEWPORT: 'preview_* use_preview_* texture_resolution texture_limit ao_bounces volume_preview_step_rate',
            'OpenImageDenoise on the CPU denoises': 'denoiser denoising_use_gpu',
            'without a sample subset, which is named': 'sample_offset sample_subset_length',
            'speed and memory': 'debug_* use_auto_tile tile_size',
            'read by builds for debugging only': 'direct_light_sampling_type',
            'script nodes are named with their material': 'shading_system',
            'glass in front of a transparent film is opaque': 'film_transparent_roughness',
            'culling is named with its object': 'camera_cull_margin distance_cull_margin',
            VOLUMES: 'volume_*',
            WITH_SUBDIVISION: 'dicing_* max_subdivisions offscreen_dicing_scale feature_set',
            WITH_MOTION_BLUR: 'rolling_shutter_*',
            WITH_FAST_GI: 'fast_gi_method ao_bounces_render',
            'baking': 'bake_type',
        },
    ),
    'CyclesView3DShadingSettings': Group(idle={VIEWPORT: 'render_pass show_active_pixels'}),
    'CyclesCurveRenderSettings': Group(idle={'hair curves are named with their object': 'shape subdivisions'}),
    'CyclesObjectSettings': Group(
        named=(
            Named(
                'use_camera_cull',
                'camera culling is not supported yet: it is rendered wherever it stands',
                matters=lambda _, scene: scene.render.use_simplify and scene.cycles.use_camera_cull,
            ),
            Named(
                'use_distance_cull',
                'distance culling is not supported yet: it is rendered however far it is',
                matters=lambda _, scene: scene.render.use_simplify and scene.cycles.use_distance_cull,
            ),
            Named('is_caustics_caster', 'it casts no shadow caustics: these are not supported yet'),
            Named(
                'use_adaptive_subdivision',
                ADAPTIVE,
                matters=lambda _, scene: getattr(scene.cycles, 'feature_set', '') == 'EXPERIMENTAL',
            ),
        ),
        idle={
            WITH_MOTION_BLUR: 'use_motion_blur use_deform_motion motion_steps',
            WITH_FAST_GI: 'ao_distance',
            WITH_CASTERS: 'is_caustics_receiver',
            WITH_SUBDIVISION: 'dicing_rate',
            "replaced by the object's own shadow_terminator_*": 'shadow_terminator_*',
        },
    ),
    'ObjectLightLinking': Group(
        read='receiver_collection blocker_collection',
    ),
    'Object': Group(
        read='visible_camera visible_diffuse visible_glossy visible_transmission visible_volume_scatter visible_shadow '
        'is_holdout is_shadow_catcher lightgroup pass_index shadow_terminator_geometry_offset matrix_world',
        named=(
            Named(
                'shadow_terminator_shading_offset',
                'the shading offset of its shadow terminator ({value:g}) is not supported yet',
                (0.0,),
            ),
        ),
        idle={
            'Cycles 5.2.3 does not ask it: its Raycast node meets what any other ray does': 'visible_raycast',
            'in the matrix': 'location rotation_* scale delta_* dimensions matrix_* parent_* use_camera_lock_parent '
            'use_parent_final_indices track_axis up_axis instance_* use_instance_*',
            'in the depsgraph': 'hide_render hide_viewport show_instancer_* add_rest_position_attribute '
            'use_simulation_cache active_shape_key_index show_only_shape_key use_shape_key_edit_mode',
            'nodes that read it are named with their material': 'color',
            EEVEE: 'hide_probe_* shadow_terminator_normal_offset use_grease_pencil_lights',
            EDITING: 'active_* display_* empty_* hide_select hide_surface_pick lock_* show_* use_empty_image_alpha '
            'use_mesh_mirror_*',
        },
    ),
    'CyclesLightSettings': Group(
        read='max_bounces use_multiple_importance_sampling is_portal', idle={WITH_CASTERS: 'is_caustics_light'}
    ),
    'Light': Group(
        read='type color use_temperature temperature exposure normalize use_shadow use_nodes',
        idle={
            EEVEE: 'diffuse_factor specular_factor transmission_factor volume_factor use_custom_distance '
            'cutoff_distance',
        },
    ),
    'PointLight': Group(
        read='energy shadow_soft_size use_soft_falloff', idle={EEVEE: 'shadow_* use_shadow_jitter use_absolute_*'}
    ),
    'SpotLight': Group(
        read='energy shadow_soft_size use_soft_falloff spot_size spot_blend',
        idle={EEVEE: 'shadow_* use_shadow_jitter use_absolute_*', EDITING: 'show_cone use_square'},
    ),
    'SunLight': Group(read='energy angle', idle={EEVEE: 'shadow_* use_shadow_jitter use_absolute_*'}),
    'AreaLight': Group(
        read='energy shape size size_y spread', idle={EEVEE: 'shadow_* use_shadow_jitter use_absolute_*'}
    ),
    'CyclesMaterialSettings': Group(
        read='emission_sampling',
        named=(
            # Cycles turns normals of smooth meshes by it, too: 1.2 % of a tile of a sphere without bump (5.2.3).
            Named('use_bump_map_correction', 'bump map correction cannot be switched off yet', (True,)),
        ),
        idle={
            VOLUMES: 'volume_* homogeneous_volume',
            'displacement is named where it is linked': 'displacement_method',
        },
    ),
    'Material': Group(
        read='diffuse_color pass_index use_nodes',
        named=(
            Named(
                'use_transparent_shadow',
                'opaque shadows of transparent surfaces are not supported yet: light goes through them',
                (True,),
            ),
        ),
        idle={
            'displacement is named where it is linked': 'displacement_method',
            EEVEE: 'surface_render_method blend_method alpha_threshold use_transparency_overlap show_transparent_back '
            'use_backface_culling* use_raytrace_refraction use_screen_refraction use_sss_translucency refraction_depth '
            'thickness_mode use_thickness_from_shadow volume_intersection_method max_vertex_displacement',
            EDITING: 'preview_* use_preview_world paint_* metallic roughness specular_* line_*',
        },
    ),
    'CyclesWorldSettings': Group(
        read='sampling_method sample_map_resolution',
        named=(
            Named(
                'max_bounces',
                'its light ends after {value} bounces; Cycles keeps the part of it there that bounces find',
                (1024,),
                matters=lambda world, scene: (
                    scene.cotorra.integrator in ('PATH', 'AUTO') and world.max_bounces < inherited(scene, 'max_bounces')
                ),
            ),
            Named('use_shadows', 'its light is shadowed: that cannot be switched off yet', (True,)),
        ),
        idle={
            VOLUMES: 'volume_* homogeneous_volume',
            WITH_CASTERS: 'is_caustics_light',
        },
    ),
    'CyclesVisibilitySettings': Group(
        read='camera diffuse glossy transmission scatter', idle={'Cycles does not read it of a world': 'shadow'}
    ),
    'World': Group(
        read='color lightgroup use_nodes', idle={EEVEE: 'probe_resolution sun_* use_sun_* use_eevee_finite_volume'}
    ),
    'WorldLighting': Group(read='distance', idle={WITH_FAST_GI: 'ao_factor'}),
    'Camera': Group(
        read='type lens sensor_fit sensor_width sensor_height ortho_scale shift_x shift_y clip_start clip_end',
        idle={
            'in lens': 'angle angle_x angle_y lens_unit',
            'panoramas and cameras with code are named': 'panorama_type fisheye_* latitude_* longitude_* '
            'central_cylindrical_* custom_*',
            EDITING: 'display_size passepartout_alpha show_* composition_*',
        },
    ),
    'CameraDOFSettings': Group(
        read='use_dof',
        idle={
            'works with depth of field only, which is named': 'aperture_* focus_distance focus_subtarget',
        },
    ),
    'CyclesRenderLayerSettings': Group(
        read='pass_debug_sample_count use_denoising denoising_store_passes',
        named=(
            _missed_pass('pass_render_time', 'Render Time'),
            _missed_pass('use_pass_volume_direct', 'Volume Direct'),
            _missed_pass('use_pass_volume_indirect', 'Volume Indirect'),
            _missed_pass('use_pass_volume_scatter', 'Volume Scatter'),
            _missed_pass('use_pass_volume_transmit', 'Volume Transmit'),
            _missed_pass('use_pass_volume_majorant', 'Volume Majorant'),
            _missed_pass('use_pass_shadow_catcher', 'Shadow Catcher'),
        ),
        idle={'nothing in Blender shows it': 'denoising_pass_*'},
    ),
    'ViewLayer': Group(
        read='use use_solid use_sky samples use_pass_*',
        named=(
            Named(
                'pass_alpha_threshold',
                'the alpha threshold of its passes ({value:g}) is not supported yet',
                (0.5,),
                matters=lambda layer, _: any(getattr(layer, name) for name in ALPHA_PASSES),
            ),
        ),
        idle={
            WITH_FAST_GI: 'use_ao',
            VOLUMES: 'use_volumes',
            WITH_MOTION_BLUR: 'use_motion_blur',
            'hair is named with its object': 'use_strand',
            BLENDER: 'use_freestyle use_grease_pencil',
            'Cryptomatte is named': 'pass_cryptomatte_depth',
            EDITING: 'active_*',
        },
    ),
    'RenderSettings': Group(
        read='border_* engine film_transparent filter_size pixel_aspect_x pixel_aspect_y resolution_* threads '
        'threads_mode use_border use_crop_to_border use_persistent_data use_single_layer use_simplify',
        named=(
            Named('use_motion_blur', 'motion blur is not rendered yet'),
            Named('use_multiview', 'stereo views are not rendered yet, each view gets the same picture'),
        ),
        idle={
            BLENDER: 'compositor_* dither_intensity filepath fps fps_base frame_map_* line_thickness* metadata_input '
            'ppm_* save_output sequencer_gl_preview simplify_* stamp_* use_stamp* use_compositing use_file_extension '
            'use_freestyle use_lock_interface use_overwrite use_placeholder use_render_cache use_sequencer* '
            'use_simplify_normals views_format',
            WITH_MOTION_BLUR: 'motion_blur_*',
            'speed and memory': 'use_texture_cache use_auto_generate_texture_cache',
            VIEWPORT: 'preview_pixel_size',
            EEVEE: 'anisotropic_filter hair_* use_high_quality_normals',
            'baking': 'bake_* use_bake_*',
        },
    ),
}

# Passes that Cycles writes for surfaces of enough alpha only.
ALPHA_PASSES = (
    'use_pass_z',
    'use_pass_position',
    'use_pass_normal',
    'use_pass_uv',
    'use_pass_object_index',
    'use_pass_material_index',
)


def source(scene: bpy.types.Scene, name: str) -> tuple[bpy.types.bpy_struct, str]:
    """Whose property holds one of INHERITED, and its name; `settings_from` of our settings decides.

    AUTO: ours where it was set, else the one for Cycles; a scene that was never set up for us is rendered as Cycles
    would.
    """
    own = scene.cotorra
    if own.settings_from == 'COTORRA' or (own.settings_from == 'AUTO' and own.is_property_set(name)):
        return own, name
    owner = scene
    *path, last = INHERITED[name].split('.')
    for part in path:
        owner = getattr(owner, part, None)  # there may be no world, and the Cycles add-on may be disabled
    return (own, name) if owner is None else (owner, last)


def inherited(scene: bpy.types.Scene, name: str) -> float:
    return getattr(*source(scene, name))


def holds_of_ours(scene: bpy.types.Scene, name: str) -> bool:
    """Whether a setting of ours that Cycles has none of holds: not where the file's settings for Cycles do."""
    own = scene.cotorra
    return own.settings_from == 'COTORRA' or (own.settings_from == 'AUTO' and own.is_property_set(name))


def override(scene: bpy.types.Scene, name: str, value: float) -> None:
    """Set one of INHERITED so that it holds, whoever's property that is."""
    if scene.cotorra.settings_from != 'CYCLES':
        setattr(scene.cotorra, name, value)
    else:
        owner, theirs = source(scene, name)
        setattr(owner, theirs, value)


def differences(settings: bpy.types.bpy_struct | None, scene: bpy.types.Scene | None) -> Iterator[tuple[Named, object]]:
    """Settings of a group that change Cycles' picture and not ours, with their value.

    scene: None where no setting of the group asks for it.
    """
    if settings is None:  # the Cycles add-on is disabled
        return
    for entry in _named(type(settings)):
        value = getattr(settings, entry.name, entry.same[0])  # not each Blender has all of them
        if value in entry.same:
            continue
        if entry.matters is None or entry.matters(settings, scene):
            yield entry, value


@cache
def _named(kind: type[bpy.types.bpy_struct]) -> tuple[Named, ...]:
    """What is named of a type of group. There may be many objects: they are asked for nothing else."""
    return GROUPS[kind.bl_rna.identifier].named


def warn_owner(owner: str, settings: bpy.types.bpy_struct | None, scene: bpy.types.Scene | None, log: Log) -> None:
    """Name the settings of `owner` ('Object "Cube"') whose picture we do not render."""
    for entry, value in differences(settings, scene):
        log.warning(f'{owner}: {entry.text.format(value=value)}')


def warn_object(obj: bpy.types.Object, parent: bpy.types.Object, scene: bpy.types.Scene, log: Log) -> None:
    """An object, and what it takes from its instancer, which is itself where it stands on its own."""
    kind = 'Light' if obj.type == 'LIGHT' else 'Object'
    for settings in (obj, getattr(obj, 'cycles', None)):
        warn_owner(f'{kind} "{obj.name}"', settings, scene, log)
    for modifier in obj.modifiers:
        if getattr(modifier, 'use_adaptive_subdivision', False) and modifier.show_render:
            log.warning(f'{kind} "{obj.name}": {ADAPTIVE}')


def warn_world(world: bpy.types.World, scene: bpy.types.Scene, log: Log) -> None:
    warn_owner(f'World "{world.name}"', getattr(world, 'cycles', None), scene, log)


def warn_scene(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, log: Log) -> None:
    """The scene and the view layer."""
    owner = f'Scene "{scene.name}"'
    warn_owner(owner, getattr(scene, 'cycles', None), scene, log)
    warn_owner(owner, scene.render, scene, log)
    layer = f'View layer "{view_layer.name}"'
    warn_owner(layer, view_layer, scene, log)
    warn_owner(layer, getattr(view_layer, 'cycles', None), scene, log)
