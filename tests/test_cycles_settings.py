# SPDX-License-Identifier: GPL-3.0-or-later
"""Each setting that Cycles has is read, named where it changes the picture, or known to be of no effect here.

What is rendered of those that are read is judged by the tests of images, not here.
"""

from __future__ import annotations

from collections.abc import Callable
from fnmatch import fnmatchcase
from typing import Any

import bpy
import pytest
from cotorra import cycles_settings, settings, stats
from cotorra.log import Log

from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

# Kinds of properties that hold a value; others lead to groups and data of their own.
VALUES = {'BOOLEAN', 'INT', 'FLOAT', 'STRING', 'ENUM'}


@pytest.fixture
def scene() -> bpy.types.Scene:
    """A sphere under a lamp and a grey world, seen by a camera, with nothing that Cycles does and we do not."""
    made = build.new_scene()
    build.camera(made).location = (0.0, 0.0, 5.0)
    build.light(made, 'POINT').location = (2.0, 0.0, 3.0)
    build.world(made, (0.5, 0.5, 0.5))
    build.mesh_object(made, 'Square').data.materials.append(build.material('Clear', Alpha=0.5))
    made.render.engine = 'COTORRA'
    made.render.resolution_x = made.render.resolution_y = 8
    made.cotorra.samples = 1
    return made


def warnings(scene: bpy.types.Scene) -> list[str]:
    bpy.ops.render.render()
    return stats.last(scene.name)[0].warnings


# ---- The table


def registered() -> dict[str, set[str]]:
    """What this Blender registers, by the type of its group, without what the type's base has.

    All that Cycles hangs at data of Blender, and the types of Blender's own that the table has.
    """
    types = [getattr(bpy.types, name) for name in dir(bpy.types)]
    pointers = [
        entry.fixed_type
        for owner in types
        if hasattr(owner, 'bl_rna')
        for entry in owner.bl_rna.properties
        if entry.type == 'POINTER' and entry.fixed_type.identifier.startswith('Cycles')
    ]
    found = {rna.identifier: set(rna.properties.keys()) - {'rna_type', 'name'} for rna in pointers}
    for name in cycles_settings.GROUPS.keys() - found.keys():
        rna = getattr(bpy.types, name).bl_rna
        inherited = set(rna.base.properties.keys()) if rna.base else {'name'}
        pointer = {'POINTER'} if name == 'ObjectLightLinking' else set()
        found[name] = {
            entry.identifier
            for entry in rna.properties
            if entry.type in VALUES | pointer and not entry.is_readonly and entry.identifier not in inherited
        }
    return found


def kinds(group: cycles_settings.Group, name: str) -> list[str]:
    """Where the table has a name: once is right."""
    patterns = {'read': group.read, **group.idle}
    found = [kind for kind, names in patterns.items() if any(fnmatchcase(name, each) for each in names.split())]
    return found + ['named' for entry in group.named if entry.name == name]


def test_every_setting_has_its_place():
    """A setting that a new Blender brings fails here: read it, name it, or say why it does not matter."""
    build.new_scene()
    groups, found = cycles_settings.GROUPS, registered()
    assert {f'Cycles{of}Settings' for of in ('Render', 'Object', 'Light', 'Material', 'World')} <= found.keys()
    empty = cycles_settings.Group()
    assert not [f'{kind}.{name}' for kind in found for name in found[kind] if not kinds(groups.get(kind, empty), name)]


def test_no_setting_is_named_and_silent():
    """A pattern of names without effect must not swallow one that is named."""
    for group in cycles_settings.GROUPS.values():
        for entry in group.named:
            assert kinds(group, entry.name) == ['named']


# ---- What is named


def of_scene(name: str, value: Any) -> Callable[[bpy.types.Scene], None]:
    return lambda scene: setattr(scene.cycles, name, value)


def _cull(scene: bpy.types.Scene, how: str) -> None:
    scene.render.use_simplify = True
    setattr(scene.cycles, how, True)
    setattr(scene.objects['Square'].cycles, how, True)


def _glass_film(scene: bpy.types.Scene) -> None:
    scene.render.film_transparent = scene.cycles.film_transparent_glass = True


def _subdivide(scene: bpy.types.Scene) -> None:
    modifier = scene.objects['Square'].modifiers.new('Subdivision', 'SUBSURF')
    modifier.levels = modifier.render_levels = 1
    if hasattr(modifier, 'use_adaptive_subdivision'):
        modifier.use_adaptive_subdivision = True
    else:
        scene.cycles.feature_set = 'EXPERIMENTAL'
        scene.objects['Square'].cycles.use_adaptive_subdivision = True


def _threshold(scene: bpy.types.Scene) -> None:
    scene.view_layers[0].pass_alpha_threshold = 0.25
    scene.view_layers[0].use_pass_z = True


NAMED = {
    'fast GI': (of_scene('use_fast_gi', True), 'Scene "Scene": fast GI'),
    'subset': (of_scene('use_sample_subset', True), 'Scene "Scene": a sample subset'),
    'glass film': (_glass_film, 'Scene "Scene": transparent glass'),
    'motion blur': (lambda scene: setattr(scene.render, 'use_motion_blur', True), 'Scene "Scene": motion blur'),
    'camera culling': (lambda scene: _cull(scene, 'use_camera_cull'), 'Object "Square": camera culling'),
    'distance culling': (lambda scene: _cull(scene, 'use_distance_cull'), 'Object "Square": distance culling'),
    'terminator': (
        lambda scene: setattr(scene.objects['Square'], 'shadow_terminator_shading_offset', 0.5),
        'Object "Square": the shading offset of its shadow terminator (0.5)',
    ),
    'caustics caster': (
        lambda scene: setattr(scene.objects['Square'].cycles, 'is_caustics_caster', True),
        'Object "Square": it casts no shadow caustics',
    ),
    'subdivision': (_subdivide, 'Object "Square": adaptive subdivision'),
    'opaque shadows': (
        lambda scene: setattr(bpy.data.materials['Clear'], 'use_transparent_shadow', False),
        'Material "Clear": opaque shadows',
    ),
    'bump correction': (
        lambda scene: setattr(bpy.data.materials['Clear'].cycles, 'use_bump_map_correction', False),
        'Material "Clear": bump map correction',
    ),
    'world bounces': (
        lambda scene: setattr(scene.world.cycles, 'max_bounces', 1),
        'World "World": its light ends after',
    ),
    'alpha threshold': (_threshold, 'View layer "ViewLayer": the alpha threshold of its passes (0.25)'),
    'volume pass': (
        lambda scene: setattr(scene.view_layers[0].cycles, 'use_pass_volume_direct', True),
        'View layer "ViewLayer": pass "Volume Direct"',
    ),
    'subsurface pass': (
        lambda scene: setattr(scene.view_layers[0], 'use_pass_subsurface_color', True),
        'View layer "ViewLayer": pass "Subsurface Color"',
    ),
}


@pytest.mark.parametrize('case', NAMED)
def test_what_changes_the_picture_is_named(scene, case):
    change, words = NAMED[case]
    change(scene)
    found = warnings(scene)
    assert len(found) == 1 and found[0].startswith(words), found


def test_defaults_are_no_warnings():
    scene = factory_scene()
    shown = []
    settings.warn_left_out(scene, scene.view_layers[0], Log(lambda level, text: shown.append((level, text))))
    assert shown == []


def without_effect(scene: bpy.types.Scene) -> None:
    """Settings that need another one to matter."""
    square = scene.objects['Square']
    square.cycles.use_camera_cull = square.cycles.is_caustics_receiver = True
    scene.objects['Point'].data.cycles.is_caustics_light = True
    scene.cycles.film_transparent_glass = True
    scene.cycles.texture_limit_render = '128'
    scene.cycles.ao_bounces_render, scene.cycles.use_light_tree, scene.cycles.use_guiding = 5, False, True
    scene.view_layers[0].pass_alpha_threshold = 0.25
    bpy.data.materials['Clear'].node_tree.nodes['Principled BSDF'].inputs['Alpha'].default_value = 1.0
    bpy.data.materials['Clear'].use_transparent_shadow = False
    scene.cotorra.integrator = 'DIRECT'
    scene.world.cycles.max_bounces = 1


def test_what_changes_nothing_is_not_named(scene):
    without_effect(scene)
    assert warnings(scene) == []


def test_portals_give_no_light_and_are_no_fault(scene):
    build.light(scene, 'AREA').data.cycles.is_portal = True
    assert warnings(scene) == []


# ---- What is read in place of ours


def rendered_with(scene: bpy.types.Scene) -> Any:
    evaluated = scene.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return settings.render_settings(evaluated, scene.view_layers[0], ('combined',), Log())


# Another value than the default of both, for each of our settings that Cycles has, too.
OTHER = {
    'samples': 100,
    'use_adaptive_sampling': None,  # the two defaults differ
    'noise_threshold': 0.05,
    'adaptive_min_samples': 20,
    'time_limit': 9.0,
    'seed': 3,
    'use_animated_seed': True,
    'clamp_direct': 2.0,
    'clamp_indirect': 3.0,
    'filter_glossy': 0.5,
    'light_threshold': 0.25,
    'reflective_caustics': False,
    'refractive_caustics': False,
    'use_denoising': False,
    'denoising_inputs': 'RGB',
    'denoising_prefilter': 'FAST',
    'denoising_quality': 'BALANCED',
    'max_bounces': 7,
    'diffuse_bounces': 2,
    'glossy_bounces': 3,
    'transmission_bounces': 6,
    'transparent_bounces': 5,
    'ao_distance': 2.0,
    'preview_samples': 100,
    'use_preview_adaptive_sampling': False,
    'preview_noise_threshold': 0.05,
    'preview_adaptive_min_samples': 20,
    'use_preview_denoising': True,
    'preview_denoising_start_sample': 7,
    'preview_denoising_inputs': 'RGB',
    'preview_denoising_prefilter': 'ACCURATE',
    'preview_denoising_quality': 'BALANCED',
    'preview_pause': True,
}


def factory_scene() -> bpy.types.Scene:
    """A scene as Blender makes it, with all of Cycles' defaults."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    made = bpy.context.scene
    made.world = bpy.data.worlds.new('World')
    return made


def test_all_that_may_be_inherited_is_tried():
    assert OTHER.keys() == cycles_settings.INHERITED.keys()


@pytest.mark.parametrize('name', OTHER)
def test_a_file_made_for_cycles_has_its_own_settings(name):
    """Untouched, as if we had none; where they were set, ours; and either for who asks for it."""
    scene = factory_scene()
    default = scene.cotorra.bl_rna.properties[name].default
    theirs, path = cycles_settings.source(scene, name)
    assert theirs != scene.cotorra
    if OTHER[name] is not None:
        setattr(theirs, path, OTHER[name])
    value = pytest.approx(OTHER[name]) if isinstance(OTHER[name], float) else getattr(theirs, path)
    assert value != default
    assert cycles_settings.inherited(scene, name) == value
    scene.cotorra.settings_from = 'COTORRA'
    assert cycles_settings.inherited(scene, name) == default
    scene.cotorra.settings_from = 'AUTO'
    setattr(scene.cotorra, name, default)  # it was set, though to the default
    assert cycles_settings.inherited(scene, name) == default
    scene.cotorra.settings_from = 'CYCLES'
    assert cycles_settings.inherited(scene, name) == value


@pytest.mark.parametrize('settings_from', ['AUTO', 'CYCLES', 'COTORRA'])
def test_what_the_command_line_says_holds(settings_from):
    scene = factory_scene()
    scene.cotorra.settings_from = settings_from
    cycles_settings.override(scene, 'samples', 17)
    assert rendered_with(scene).samples == 17


def test_cycles_own_defaults_are_rendered():
    """What presses on a new file: Cycles' values, in our words."""
    scene = factory_scene()
    found, cycles = rendered_with(scene), scene.cycles
    assert found.integrator == 'PATH'
    assert (found.samples, found.adaptive) == (cycles.samples, cycles.use_adaptive_sampling)
    assert found.clamp_indirect == cycles.sample_clamp_indirect > 0.0 == found.clamp_direct
    assert found.filter_glossy == cycles.blur_glossy > 0.0
    assert found.light_threshold == pytest.approx(cycles.light_sampling_threshold) and found.light_threshold > 0.0
    assert settings.denoising(scene, scene.view_layers[0]) is not None


def test_a_threshold_of_0_suits_the_samples(scene):
    """As Cycles has it: 1 over the samples, but 0.001 at least."""
    scene.cycles.adaptive_threshold = 0.0
    for samples, threshold in ((50, 0.02), (4096, 0.001)):
        scene.cotorra.samples = samples
        assert rendered_with(scene).noise_threshold == pytest.approx(threshold)


def test_a_view_layer_may_stay_noisy(scene):
    scene.cycles.use_denoising = True
    layer = scene.view_layers[0]
    assert settings.denoising(scene, layer) is not None
    layer.cycles.use_denoising = False
    assert settings.denoising(scene, layer) is None
    scene.cotorra.use_denoising = True  # ours has no such switch
    assert settings.denoising(scene, layer) is not None
    scene.cotorra.integrator = 'TOON'
    assert settings.denoising(scene, layer) is None


def test_animated_limits_hold(scene):
    scene.cotorra.max_bounces = 3
    scene.cotorra.keyframe_insert('max_bounces', frame=1)
    scene.frame_set(1)
    assert rendered_with(scene).max_bounces == 3


def test_the_worlds_distance_of_occlusion_holds_until_ours_is_set(scene):
    scene.world.light_settings.distance = 2.0
    assert rendered_with(scene).ao_distance == 2.0
    scene.cotorra.ao_distance = 10.0
    assert rendered_with(scene).ao_distance == 10.0
    scene.cotorra.property_unset('ao_distance')
    scene.world = None
    assert rendered_with(scene).ao_distance == 10.0


@pytest.mark.parametrize('use, layer, samples', [('USE', 9, 9), ('BOUNDED', 9, 4), ('BOUNDED', 2, 2), ('IGNORE', 9, 4)])
def test_samples_of_view_layers_are_used_as_in_cycles(scene, use, layer, samples):
    scene.cotorra.samples, scene.cycles.use_layer_samples = 4, use
    assert rendered_with(scene).samples == 4
    scene.view_layers[0].samples = layer
    assert rendered_with(scene).samples == samples
