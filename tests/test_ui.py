# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra's panels draw what exists, for every choice that changes what they show.

There is no window here: a stand-in for the layout checks each name against Blender's own description of the data.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy
import pytest
from cotorra import choices, ui

from scenes import build

pytestmark = pytest.mark.usefixtures('engine')


class Layout:
    """Takes what a panel draws: properties that do not exist fail here, as they would in the window's console."""

    def __init__(self, shown: list[str]) -> None:
        self.shown = shown
        self.active = self.enabled = True

    def prop(self, data: Any, name: str, **_options: Any) -> None:
        assert name in data.bl_rna.properties, f'{data.bl_rna.identifier} has no {name}'
        self.shown.append(name)

    def label(self, text: str = '', **_options: Any) -> None:
        self.shown.append(text)

    def popover(self, panel: str, **_options: Any) -> None:
        assert hasattr(bpy.types, panel)

    def row(self, **_options: Any) -> Layout:
        return Layout(self.shown)

    column = row


def drawn(name: str, **context: Any) -> list[str]:
    """What the panel shows, header included; nothing where it does not show itself."""
    panel = getattr(bpy.types, name)
    shown: list[str] = []
    context = SimpleNamespace(engine='COTORRA', scene=bpy.context.scene, view_layer=bpy.context.view_layer, **context)
    if not panel.poll(context):
        return shown
    # A registered class has its functions wrapped by Blender, which wants an instance that only Blender makes.
    cls = next(cls for cls in ui.CLASSES if cls.__name__ == name)
    for part in ('draw_header', 'draw_header_preset', 'draw'):
        if part in cls.__dict__:
            cls.__dict__[part](SimpleNamespace(layout=Layout(shown)), context)
    return shown


USED = {
    'PRINCIPLED': set(),
    'LAMBERT': set(),
    'OREN_NAYAR': {'oren_nayar_form', 'oren_nayar_sigma'},
    'PHONG': {'normalized', 'kd', 'ks', 'specular_color', 'shininess'},
    'BLINN_PHONG': {'normalized', 'kd', 'ks', 'specular_color', 'shininess'},
    'COOK_TORRANCE': {'distribution', 'masking', 'fresnel', 'split'},
    'TOON': {'toon_lit', 'toon_shade', 'toon_steps'},
}


@pytest.mark.parametrize('model', [identifier for identifier, _, _ in choices.MODELS])
def test_a_material_shows_what_its_model_uses(model):
    build.new_scene()
    material = bpy.data.materials.new('Made')
    material.cotorra.model = model
    found = drawn('COTORRA_MATERIAL_PT_model', material=material)
    parameters = set(found) & set(material.cotorra.bl_rna.properties.keys())
    wanted = USED[model] | {'model'}
    if model == 'COOK_TORRANCE':
        assert parameters == wanted | {'f0_mode'}  # Schlick is the default
    else:
        assert parameters == wanted
    assert any('a metal looks matt' in text for text in found) == (model in {'LAMBERT', 'OREN_NAYAR', 'TOON'})


def test_a_model_that_makes_energy_is_told_of():
    build.new_scene()
    own = bpy.data.materials.new('Made').cotorra
    own.model = 'PHONG'
    told = 'May reflect more light than arrives'
    assert told in drawn('COTORRA_MATERIAL_PT_model', material=own.id_data)
    own.normalized = True
    assert told not in drawn('COTORRA_MATERIAL_PT_model', material=own.id_data)
    assert 'reflects more light than arrives' in own.bl_rna.properties['normalized'].description


@pytest.mark.parametrize(
    ('fresnel', 'shown'),
    [
        ('SCHLICK', {'f0_mode', 'f0'}),
        ('DIELECTRIC', set()),
        ('CONDUCTOR', {'conductor_n', 'conductor_k'}),
        ('F82', {'f0_mode', 'f0', 'f82_tint'}),
    ],
)
def test_fresnel_shows_its_own(fresnel, shown):
    build.new_scene()
    own = bpy.data.materials.new('Made').cotorra
    own.model, own.fresnel, own.f0_mode = 'COOK_TORRANCE', fresnel, 'COLOR'
    found = set(drawn('COTORRA_MATERIAL_PT_model', material=own.id_data))
    assert found & {'f0_mode', 'f0', 'f82_tint', 'conductor_n', 'conductor_k'} == shown


OWN = {
    'DIRECT': {'transparent_bounces', 'ambient_strength', 'use_ambient_occlusion', 'ao_distance'},
    'PATH': {'max_bounces', 'diffuse_bounces', 'glossy_bounces', 'transmission_bounces', 'transparent_bounces'},
    'WHITTED': {'whitted_depth', 'whitted_threshold', 'use_transparent_shadows', 'ambient_strength'},
    'AO': {'ao_distance'},
    'TOON': {'toon_outline', 'outline_width', 'outline_color', 'outline_normal', 'outline_depth', 'outline_object'},
}


@pytest.mark.parametrize('integrator', [identifier for identifier, _, _ in choices.INTEGRATORS])
def test_an_integrator_shows_its_own_settings(integrator):
    scene = build.new_scene()
    scene.cotorra.integrator = integrator
    panels = ('COTORRA_RENDER_PT_integrator', 'COTORRA_RENDER_PT_ambient', 'COTORRA_RENDER_PT_outlines')
    found = {name for panel in panels for name in drawn(panel)}
    assert OWN[integrator] <= found
    ambient = {'ambient_color', 'ambient_strength', 'use_ambient_occlusion', 'ao_distance'}
    for other, names in OWN.items():
        if other != integrator:
            assert not (names - OWN[integrator] - ambient) & found


def test_lamps_show_falloff_and_edge():
    build.new_scene()
    light = bpy.data.lights.new('Spot', 'SPOT')
    assert {'spot_edge', 'spot_size', 'spot_blend'} <= set(drawn('COTORRA_LIGHT_PT_beam_shape', light=light))
    light.cotorra.spot_edge = 'LINEAR'
    found = set(drawn('COTORRA_LIGHT_PT_beam_shape', light=light))
    assert {'inner_angle', 'outer_angle'} <= found and 'spot_size' not in found
    for falloff, names in (('PHYSICAL', set()), ('RANGED', {'range'}), ('POLYNOMIAL', {'c0', 'c1', 'c2'})):
        light.cotorra.falloff = falloff
        assert set(drawn('COTORRA_LIGHT_PT_falloff', light=light)) == {'falloff'} | names
    assert not drawn('COTORRA_LIGHT_PT_falloff', light=bpy.data.lights.new('Sun', 'SUN'))


def test_every_panel_draws():
    """What needs a node editor's templates or a window is Blender's own; the rest must draw on a new file."""
    scene = build.new_scene()
    light = bpy.data.lights.new('Spot', 'SPOT')
    names = [cls.__name__ for cls in ui.CLASSES if cls.__name__.startswith('COTORRA_RENDER')]
    names += ['COTORRA_VIEWLAYER_PT_passes_data', 'COTORRA_VIEWLAYER_PT_passes_light']
    for name in [*names, 'COTORRA_VIEWLAYER_PT_passes_terms', 'COTORRA_LIGHT_PT_light', 'COTORRA_LIGHT_PT_settings']:
        drawn(name, light=light)
    assert {'use_reinhard', 'reinhard_white'} <= set(drawn('COTORRA_RENDER_PT_film'))
    terms = {'use_pass_distribution', 'use_pass_masking', 'use_pass_fresnel', 'use_pass_lights'}
    assert set(drawn('COTORRA_VIEWLAYER_PT_passes_terms')) == terms
    scene.cotorra.use_model_override = True
    told = drawn('COTORRA_MATERIAL_PT_model', material=bpy.data.materials.new('Made'))
    assert any('renders all materials with one model' in text for text in told)
