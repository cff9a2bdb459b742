# SPDX-License-Identifier: GPL-3.0-or-later
"""`material.cotorra`, the scene's override and the settings of integrators become buffers, unharmed.

What the models and integrators make of them is tested with each.
"""

from __future__ import annotations

import math
from dataclasses import fields

import bpy
import numpy as np
import pytest
from cotorra import choices, settings
from cotorra.export.buffers import MaterialModels, RenderSettings
from cotorra.export.models import LISTS
from cotorra.log import Log

from scenes import build
from scenes.depsgraphs import exported, messages
from scenes.materials import constants

pytestmark = pytest.mark.usefixtures('engine')


@pytest.fixture
def scene() -> bpy.types.Scene:
    made = build.new_scene()
    build.mesh_object(made).data.materials.append(build.material('Made'))
    return made


def models(scene: bpy.types.Scene) -> MaterialModels | None:
    return exported(scene).materials.models


def test_principled_materials_have_no_models(scene):
    assert models(scene) is None
    scene.cotorra.model_override.model = 'PHONG'  # not in use
    assert models(scene) is None
    bpy.data.materials.new('Not in use').cotorra.model = 'TOON'
    assert models(scene) is None


@pytest.mark.parametrize('integrator', [identifier for identifier, _, _ in choices.INTEGRATORS])
def test_some_integrators_read_parameters_of_all_materials(integrator, scene):
    scene.cotorra.integrator = integrator
    assert (models(scene) is not None) == (integrator in {'WHITTED', 'TOON'})


def test_every_setting_arrives(scene):
    """All properties, each with a value of its own."""
    own = bpy.data.materials['Made'].cotorra
    own.model = 'COOK_TORRANCE'
    wanted = {}
    for index, field in enumerate(fields(MaterialModels)):
        name = field.name
        if name in LISTS:
            wanted[name] = len(LISTS[name]) - 1 if name != 'model' else 5
            setattr(own, name, LISTS[name][wanted[name]][0])
        elif own.bl_rna.properties[name].type == 'BOOLEAN':
            own.normalized, wanted[name] = True, 1
        elif own.bl_rna.properties[name].type == 'INT':
            own.toon_steps = wanted[name] = 5
        elif own.bl_rna.properties[name].is_array:
            wanted[name] = [0.01 * index + 0.1 * part for part in (1, 2, 3)]
            setattr(own, name, wanted[name])
        else:
            wanted[name] = 0.01 * index + 0.5
            setattr(own, name, wanted[name])
    found = models(scene)
    for name, value in wanted.items():
        column = getattr(found, name)
        assert column.dtype == (np.float32 if isinstance(value, (list, float)) else np.uint32) and len(column) == 2
        assert column[1] == pytest.approx(value, rel=1e-6), name
        assert column.flags.c_contiguous


def test_every_property_has_a_place_and_every_place_a_property(scene):
    own = bpy.data.materials['Made'].cotorra
    # use_auto is no part of a model: integrator AUTO asks for it (addon/final_render.py).
    properties = set(own.bl_rna.properties.keys()) - {'rna_type', 'name', 'use_auto'}
    assert properties == {field.name for field in fields(MaterialModels)}


def test_an_object_without_material_has_the_defaults(scene):
    build.mesh_object(scene, 'Bare')
    bpy.data.materials['Made'].cotorra.model = 'PHONG'
    found = models(scene)
    assert found.model.tolist() == [0, 3]
    assert found.kd[0] == pytest.approx(1.0 / math.pi) and found.toon_steps[0] == 2
    assert found.conductor_n[0] == pytest.approx(tuple(bpy.data.materials['Made'].cotorra.conductor_n))


def test_the_override_is_for_all_materials_and_leaves_their_colors(scene):
    build.mesh_object(scene, 'Bare')
    bpy.data.materials['Made'].cotorra.model = 'TOON'
    override = scene.cotorra.model_override
    override.model, override.shininess = 'BLINN_PHONG', 99.0
    scene.cotorra.use_model_override = True
    buffers = exported(scene)
    assert buffers.materials.models.model.tolist() == [4, 4]
    assert buffers.materials.models.shininess.tolist() == [99.0, 99.0]
    assert all(constants(buffers, index)['base_color'] == pytest.approx([0.8] * 3) for index in (0, 1))
    override.model = 'PRINCIPLED'
    assert models(scene) is None


@pytest.mark.parametrize(('value', 'word'), [(math.nan, 'finite'), (math.inf, 'nearest'), (1e30, 'nearest')])
@pytest.mark.parametrize('name', ['kd', 'conductor_k', 'absorption'])
def test_absurd_values_are_told_and_replaced(name, value, word, scene):
    own = bpy.data.materials['Made'].cotorra
    own.model = 'COOK_TORRANCE'
    setattr(own, name, (value,) * 3 if own.bl_rna.properties[name].is_array else value)
    told = messages(scene)
    found = getattr(models(scene), name)
    assert np.isfinite(found).all() and found.max() <= 1e6
    assert any('Material "Made"' in text and name in text and word in text for text in told)


def test_an_absurd_override_names_the_scene(scene):
    scene.cotorra.use_model_override = True
    scene.cotorra.model_override.model = 'PHONG'
    scene.cotorra.model_override.ks = math.nan
    assert any(f'Scene "{scene.name}", model override: ks' in text for text in messages(scene))


def test_settings_of_integrators_arrive(scene):
    own = scene.cotorra
    wanted = {
        'integrator': 'TOON',
        'ambient_color': (0.25, 0.5, 0.75),
        'ambient_strength': 0.5,
        'use_ambient_occlusion': True,
        'ao_distance': 3.0,
        'whitted_depth': 5,
        'whitted_threshold': 0.125,
        'use_transparent_shadows': True,
        'toon_outline': False,
        'outline_width': 1.5,
        'outline_color': (1.0, 0.5, 0.0),
        'outline_normal': False,
        'outline_depth': False,
        'outline_object': False,
    }
    defaults = RenderSettings()
    new = settings.render_settings(scene, scene.view_layers[0], ('combined',), Log())
    for name, value in wanted.items():
        if name != 'integrator':
            assert getattr(new, name) == pytest.approx(getattr(defaults, name)), name
        setattr(own, name, value)
    found = settings.render_settings(scene, scene.view_layers[0], ('combined',), Log())
    for name, value in wanted.items():
        assert getattr(found, name) == value, name
