# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra's panels draw what exists, for every choice that changes what they show.

There is no window here: a stand-in for the layout checks each name against Blender's own description of the data.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import pytest
from cotorra import choices, cycles_settings, devices, native, settings, stats, ui
from cotorra.ui import render_panels, sampling_presets, warnings_panel

from scenes import build

pytestmark = pytest.mark.usefixtures('engine')


class Layout:
    """Takes what a panel draws: properties that do not exist fail here, as they would in the window's console."""

    def __init__(self, shown: list[str]) -> None:
        self.shown = shown
        self.active = self.enabled = True
        self.scale_y = 1.0

    def prop(self, data: Any, name: str, **_options: Any) -> None:
        assert name in data.bl_rna.properties, f'{data.bl_rna.identifier} has no {name}'
        self.shown.append(name)

    def label(self, text: str = '', **_options: Any) -> None:
        self.shown.append(text)

    def popover(self, panel: str, **_options: Any) -> None:
        assert hasattr(bpy.types, panel)

    def row(self, **_options: Any) -> Layout:
        return Layout(self.shown)

    column = box = row

    def template_preview(self, owner: Any) -> None:
        assert isinstance(owner, bpy.types.ID)
        self.shown.append('preview')

    def operator(self, name: str, text: str = '', **_options: Any) -> SimpleNamespace:
        group, function = name.split('.')
        assert function in dir(getattr(bpy.ops, group))
        self.shown += [text] if text else []
        return SimpleNamespace()

    def progress(self, text: str = '', **_options: Any) -> None:
        self.shown.append(text)


def window(**context: Any) -> SimpleNamespace:
    """What a panel knows of the window that it stands in."""
    own = {'engine': 'COTORRA', 'scene': bpy.context.scene, 'view_layer': bpy.context.view_layer}
    own |= {'window_manager': bpy.context.window_manager, 'preferences': bpy.context.preferences}
    return SimpleNamespace(**{**own, **context}, region=SimpleNamespace(width=280))


def drawn(name: str, **context: Any) -> list[str]:
    """What the panel shows, header included; nothing where it does not show itself."""
    panel = getattr(bpy.types, name)
    shown: list[str] = []
    context = window(**context)
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


def test_a_material_tells_the_program_that_it_became():
    build.new_scene()
    material = bpy.data.materials.new('Made')
    if material.node_tree is None:  # before Blender 5
        material.use_nodes = True
    tree = material.node_tree
    noise = build.node(tree, 'TexNoise')
    build.connect(tree, noise.outputs[0], tree.nodes['Principled BSDF'].inputs['Base Color'])
    assert drawn('COTORRA_MATERIAL_PT_program', material=material) == ['Show Program']
    with bpy.context.temp_override(material=material):
        assert bpy.ops.material.cotorra_explain() == {'FINISHED'}
    found = drawn('COTORRA_MATERIAL_PT_program', material=material)
    assert 'noise 3D FBM normalized' in found and any(text.startswith('Surface: ') for text in found)


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
    'AUTO': {'max_bounces', 'diffuse_bounces', 'glossy_bounces', 'transmission_bounces', 'transparent_bounces'},
    'TOON': {'toon_outline', 'outline_width', 'outline_color', 'outline_normal', 'outline_depth', 'outline_object'},
}


@pytest.mark.parametrize('integrator', [identifier for identifier, _, _ in choices.INTEGRATORS])
def test_an_integrator_shows_its_own_settings(integrator):
    scene = build.new_scene()
    scene.cotorra.integrator, scene.cotorra.settings_from = integrator, 'COTORRA'
    own = ('integrator', 'ambient', 'outlines', 'light_paths', 'light_paths_max_bounces')
    panels = [f'COTORRA_RENDER_PT_{name}' for name in own]
    found = {name for panel in panels for name in drawn(panel)}
    assert OWN[integrator] <= found
    ambient = {'ambient_color', 'ambient_strength', 'use_ambient_occlusion', 'ao_distance'}
    for other, names in OWN.items():
        if other != integrator:
            assert not (names - OWN[integrator] - ambient) & found


def test_auto_shows_its_rows_and_what_became_of_them():
    scene = build.new_scene()
    scene.cotorra.integrator = 'AUTO'
    switches = {f'use_auto_{key}' for key, _, _ in choices.AUTO_ROWS}
    stats.clear(scene.name)
    found = drawn('COTORRA_RENDER_PT_auto')
    assert switches | {'auto_tolerance'} == set(found)
    row = {'key': 'diffuse', 'asked': '4', 'chosen': '2', 'simplified': True}
    entry = stats.LayerStats('ViewLayer', 1, auto={'rows': [row], 'sentences': ['AUTO: what it said']})
    stats.record(scene.name, entry)
    found = drawn('COTORRA_RENDER_PT_auto')
    stats.clear(scene.name)
    assert {'2 of 4', 'AUTO: what it said'} <= set(found)
    scene.cotorra.integrator = 'PATH'
    assert not drawn('COTORRA_RENDER_PT_auto')


@pytest.mark.parametrize('settings_from', ['AUTO', 'COTORRA'])
def test_the_settings_that_hold_are_shown(settings_from):
    """Cycles' own properties, where these are read: what is changed there counts."""
    scene = build.new_scene()
    scene.cotorra.settings_from, scene.cotorra.max_bounces = settings_from, 3
    panels = ('sampling', 'sampling_denoise', 'sampling_seed', 'light_paths_max_bounces', 'light_paths_clamping')
    panels += ('light_paths_caustics', 'sampling_viewport', 'sampling_viewport_denoise')
    found = {name for panel in panels for name in drawn(f'COTORRA_RENDER_PT_{panel}')}
    shown = {cycles_settings.source(scene, name)[1] for name in cycles_settings.INHERITED}
    if not scene.cycles.use_adaptive_sampling:
        shown.discard(cycles_settings.source(scene, 'adaptive_min_samples')[1])
    shown.discard('preview_pause')  # a button of the 3D viewport
    assert found & shown == shown - {'ao_distance', 'distance'}, shown - found
    assert ('max_bounces' in found) and ('blur_glossy' in found) == (settings_from == 'AUTO')


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
    names += ['COTORRA_VIEWLAYER_PT_override', 'COTORRA_VIEWLAYER_PT_passes_data', 'COTORRA_VIEWLAYER_PT_passes_light']
    for name in [*names, 'COTORRA_VIEWLAYER_PT_passes_terms', 'COTORRA_LIGHT_PT_light', 'COTORRA_LIGHT_PT_settings']:
        drawn(name, light=light)
    assert {'use_reinhard', 'reinhard_white'} <= set(drawn('COTORRA_RENDER_PT_film'))
    terms = {'use_pass_distribution', 'use_pass_masking', 'use_pass_fresnel', 'use_pass_lights'}
    assert set(drawn('COTORRA_VIEWLAYER_PT_passes_terms')) == terms
    scene.cotorra.use_model_override = True
    told = drawn('COTORRA_MATERIAL_PT_model', material=bpy.data.materials.new('Made'))
    assert 'renders all materials with one model' in ' '.join(told)


def shown_in(context: str) -> list[str]:
    """Labels of the panels of one tab, in the order in which Blender shows them."""
    own = list(ui.CLASSES)
    blenders = [cls for cls in bpy.types.Panel.__subclasses__() if 'COTORRA' in getattr(cls, 'COMPAT_ENGINES', ())]
    panels = [cls for cls in blenders if cls not in own] + own
    at = [cls for cls in panels if getattr(cls, 'bl_context', '') == context and not hasattr(cls, 'bl_parent_id')]
    return [cls.bl_label for cls in sorted(at, key=lambda cls: getattr(cls, 'bl_order', 0)) if cls.bl_label]


def in_order(labels: list[str], *wanted: str) -> bool:
    places = [labels.index(label) for label in wanted]
    return places == sorted(places)


def test_panels_stand_where_users_of_cycles_look_for_them():
    render = shown_in('render')
    assert render[:2] == ['Warnings', 'Sampling']
    assert in_order(render, 'Sampling', 'Integrator', 'Light Paths', 'Film', 'Performance', 'Simplify')
    assert render.count('Simplify') == 1
    assert in_order(shown_in('view_layer'), 'Override', 'Passes')
    material = ('Preview', 'Surface', 'Cotorra Model', 'Volume', 'Displacement', 'Settings', 'Animation')
    assert in_order(shown_in('material'), *material)
    assert in_order(shown_in('data'), 'Preview', 'Light', 'Nodes', 'Settings')
    assert in_order(shown_in('world'), 'Preview', 'Surface', 'Ray Visibility', 'Settings')


def test_no_name_is_a_letter():
    """D, G, F, n and k are what the papers say; the names beside the fields say what they are."""
    for owner in (bpy.types.Material, bpy.types.Light, bpy.types.Scene, bpy.types.ViewLayer):
        for setting in owner.bl_rna.properties['cotorra'].fixed_type.properties:
            assert len(setting.name) > 2 and '()' not in setting.description, setting.identifier


CARDS = [
    {'name': 'Big', 'driver': 'Some 1.2', 'memory_bytes': 2**33, 'ray_query': True, 'problem': ''},
    {'name': 'Old', 'driver': 'Other', 'memory_bytes': 0, 'ray_query': False, 'problem': 'it has no Vulkan 1.2'},
]


def device_panel() -> list[str]:
    shown: list[str] = []
    render_panels.draw_device(SimpleNamespace(layout=Layout(shown)), window())
    return shown


def test_graphics_cards_are_chosen_by_name(monkeypatch):
    own = build.new_scene().cotorra
    monkeypatch.setattr(devices, '_cards', CARDS)
    monkeypatch.setattr(devices, '_items', {})
    assert device_panel() == ['device']
    own.device = 'VULKAN'
    assert device_panel() == ['device', 'graphics_card']
    assert own.graphics_card == 'AUTO' and own.device_index == -1
    assert [words[:3] for words in devices.items(-1)][1:] == [
        ('0', 'Big', 'Some 1.2, 8.0 GiB, ray tracing in hardware'),
        ('1', 'Old', 'Other, it has no Vulkan 1.2'),
    ]
    own.graphics_card = '1'
    assert own.device_index == 1
    assert ' '.join(device_panel()[2:]) == 'Old: it has no Vulkan 1.2'
    own.device_index = 4  # of a file from another machine
    assert own.graphics_card == '4' and 'no such graphics card' in ' '.join(device_panel()[2:])


def test_a_machine_without_vulkan_says_so_beside_the_choice(monkeypatch):
    own = build.new_scene().cotorra
    own.device = 'VULKAN'

    def fail():
        raise RuntimeError('this build of Cotorra has no Vulkan')

    monkeypatch.setattr(devices, '_cards', None)
    monkeypatch.setattr(devices, '_problem', '')
    monkeypatch.setattr(devices, '_items', {})
    monkeypatch.setattr(native, 'load', lambda: SimpleNamespace(devices=fail))
    assert own.graphics_card == 'AUTO'
    assert ' '.join(device_panel()[2:]) == 'this build of Cotorra has no Vulkan'


def test_warnings_stay_in_sight():
    scene = build.new_scene()
    stats.clear(scene.name)
    assert not drawn('COTORRA_RENDER_PT_warnings')
    text = 'Material "Glass": node "Wave Texture" is not understood, and its inputs are left out of the picture'
    entry = stats.LayerStats('ViewLayer', 1, warnings=[text, 'Object "Cube": has no faces'], error='No camera')
    stats.record(scene.name, entry)
    stats.record(scene.name, stats.LayerStats('Other', 1, warnings=[text]))
    shown = drawn('COTORRA_RENDER_PT_warnings')
    assert ' '.join(shown).split(' ') == f' No camera {text} Object "Cube": has no faces'.split(' ')
    assert max(map(len, shown)) < 40, 'lines are broken where the region ends'
    header: list[str] = []
    redrawn: list[str] = []
    areas = [
        SimpleNamespace(type=kind, tag_redraw=lambda kind=kind: redrawn.append(kind))
        for kind in ('VIEW_3D', 'PROPERTIES')
    ]
    windows = SimpleNamespace(windows=[SimpleNamespace(screen=SimpleNamespace(areas=areas))])
    area = SimpleNamespace(image=SimpleNamespace(type='RENDER_RESULT'))
    context = window(space_data=area, window_manager=windows)
    for _ in range(2):
        header.clear()
        warnings_panel.draw_mark(SimpleNamespace(layout=Layout(header)), context)
    assert header == ['3 in Render Properties > Warnings'] and redrawn == ['PROPERTIES']
    stats.clear(scene.name)


def test_a_click_on_a_warning_selects_what_it_is_about():
    scene = build.new_scene()
    layer = bpy.context.view_layer
    material = bpy.data.materials.new('Glass "thin": 3')
    items = [bpy.data.objects.new(name, bpy.data.meshes.new(name)) for name in ('A', 'B', 'C')]
    for item in items:
        scene.collection.objects.link(item)
    for item in items[:2]:
        item.data.materials.append(material)
    lamp = bpy.data.objects.new('Lamp', bpy.data.lights.new('Its Data', 'POINT'))
    scene.collection.objects.link(lamp)
    layer.update()

    def selected_by(text: str) -> set[str]:
        assert bpy.ops.object.cotorra_select_named(text=text) == {'FINISHED'}
        return {item.name for item in layer.objects if item.select_get()}

    assert selected_by(f'Material "{material.name}": node "X" is left out') == {'A', 'B'}
    assert selected_by('Object "C": has no faces') == {'C'} and layer.objects.active == items[2]
    assert selected_by('Light "Its Data": it lights nothing') == {'Lamp'}
    items[2].hide_set(True)
    for text in ('Object "C": has no faces', 'Object "Gone": has no faces', 'Scene "S": it is so'):
        assert bpy.ops.object.cotorra_select_named(text=text) == {'CANCELLED'}


@pytest.mark.parametrize('name', ['draft', 'good', 'reference'])
def test_a_preset_of_sampling_holds(name):
    """Also where the settings were Cycles'."""
    scene = build.new_scene()
    path = Path(ui.__file__).parent.parent / 'presets' / sampling_presets.PRESETS / f'{name}.py'
    scene.cycles.samples = 7
    exec(compile(path.read_text(encoding='utf-8'), str(path), 'exec'), {})
    assert cycles_settings.inherited(scene, 'samples') == scene.cotorra.samples != 7
    assert settings.reweights(scene) == (name != 'reference')
    assert scene.cotorra.use_sample_sharing == (name != 'reference')  # mixing leaves a bias of 0.01 %
