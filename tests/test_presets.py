# SPDX-License-Identifier: GPL-3.0-or-later
"""Material presets: what they set follows from published optical constants, and Blender's menus find and run them.

The constants, with where they come from, stand in optical_constants.py.
"""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import cotorra
import numpy as np
import pytest
from cotorra import optics

import optical_constants as published
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

FOLDER = Path(cotorra.__file__).parent / 'presets' / 'cotorra' / 'material'
NAMES = sorted(path.stem for path in FOLDER.glob('*.py'))


def chosen(name: str, model: str = 'COOK_TORRANCE') -> bpy.types.Material:
    """A material after the preset was chosen in the menu, as an operator runs it."""
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    material = build.material('Made')
    material.cotorra.model = model
    obj.data.materials.append(material)
    with bpy.context.temp_override(object=obj, material=material):
        done = bpy.ops.script.execute_preset(
            filepath=str(FOLDER / f'{name}.py'), menu_idname='COTORRA_PT_material_presets'
        )
    assert done == {'FINISHED'}
    return material


def test_all_that_issue_3_names_are_there():
    metals = {'gold', 'copper', 'iron', 'silver', 'aluminium', 'titanium', 'chromium'}
    assert set(NAMES) == metals | {'plastic', 'ceramic', 'water', 'glass', 'diamond'}
    assert metals == set(published.METALS) and set(NAMES) - metals == set(published.SELLMEIER)


def test_blender_finds_them_and_forgets_them():
    paths = [Path(path).resolve() for path in bpy.utils.preset_paths('cotorra/material')]
    assert FOLDER.resolve() in paths
    cotorra.unregister()
    try:
        assert FOLDER.resolve() not in [Path(path).resolve() for path in bpy.utils.preset_paths('cotorra/material')]
    finally:
        cotorra.register()


@pytest.mark.parametrize('name', sorted(published.METALS))
def test_metals_are_as_published(name):
    wavelengths, n, k = published.METALS[name]
    own = chosen(name).cotorra
    n, k = published.rgb(wavelengths, n), published.rgb(wavelengths, k)
    assert tuple(own.conductor_n) == pytest.approx(n, abs=6e-4)
    assert tuple(own.conductor_k) == pytest.approx(k, abs=6e-4)
    f0 = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
    # F0 from the means of n and k, against the color of the whole spectrum of F0: gold and copper lie outside Rec. 709.
    spectrum = [np.interp(published.WAVELENGTHS / 1000.0, wavelengths, values) for values in published.METALS[name][1:]]
    whole = ((spectrum[0] - 1) ** 2 + spectrum[1] ** 2) / ((spectrum[0] + 1) ** 2 + spectrum[1] ** 2)
    color = published.rgb(tuple(published.WAVELENGTHS / 1000.0), tuple(whole))
    assert tuple(own.f0) == pytest.approx(f0, abs=1e-3) and f0 == pytest.approx(np.minimum(color, 1.0), abs=0.02)
    assert tuple(own.specular_color) == tuple(own.f0) and own.kd == 0.0 and own.fresnel == 'CONDUCTOR'


@pytest.mark.parametrize('name', sorted(published.SELLMEIER))
def test_dielectrics_are_as_published(name):
    material = chosen(name)
    n = published.refraction(name)
    assert build.principled(material).inputs['IOR'].default_value == pytest.approx(n, abs=1e-4)
    assert tuple(material.cotorra.f0) == pytest.approx([((n - 1) / (n + 1)) ** 2] * 3, abs=1e-4)
    assert material.cotorra.fresnel == 'DIELECTRIC'


@pytest.mark.parametrize('model', ['PRINCIPLED', 'LAMBERT', 'PHONG', 'BLINN_PHONG', 'COOK_TORRANCE', 'TOON'])
@pytest.mark.parametrize('name', NAMES)
def test_a_preset_suits_every_model(name, model):
    material = chosen(name, model)
    own, inputs = material.cotorra, build.principled(material).inputs
    assert own.model == model  # which model, is the user's choice
    metal = name in published.METALS
    assert inputs['Metallic'].default_value == float(metal)
    assert tuple(inputs['Base Color'].default_value)[:3] == pytest.approx(tuple(own.f0 if metal else own.toon_lit))
    for value in (*own.f0, *own.f82_tint, *own.specular_color, own.ks, own.kr, own.kt, *own.toon_lit):
        assert 0.0 <= value <= 1.0
    assert own.kr + own.kt <= 1.0 and math.pi * own.kd + max(own.f0) <= 1.0 + 1e-6
    assert 0.0 < own.shininess <= 1e6 and own.normalized
    clear = name in {'glass', 'water', 'diamond'}
    assert (own.kt > 0.8) == clear and (inputs['Transmission Weight'].default_value == 1.0) == clear
    assert any(own.absorption) == (name == 'water')


def test_fresnel_of_presets_at_known_points():
    """n + ik = 1.5: 0.04 head-on, and no reflection of half the light at Brewster's angle; a mirror at the edge."""
    assert optics.perpendicular(1.5) == pytest.approx(0.04)
    assert optics.conductor(1.0, 0.2, 3.0) == pytest.approx(optics.perpendicular(0.2, 3.0))
    assert optics.conductor(1e-9, 0.2, 3.0) == pytest.approx(1.0, abs=1e-6)
    brewster = math.cos(math.atan(1.5))
    s = ((brewster - 1.5 * math.sin(math.atan(1.5))) / (brewster + 1.5 * math.sin(math.atan(1.5)))) ** 2
    assert optics.conductor(brewster, 1.5, 0.0) == pytest.approx(s / 2.0)


def test_a_users_own_preset_is_kept_and_comes_back(tmp_path, monkeypatch):
    material = chosen('gold')
    material.cotorra.shininess = 77.0
    monkeypatch.setattr(bpy.utils, 'user_resource', lambda *_arguments, **_named: str(tmp_path))
    scene = bpy.context.scene
    with bpy.context.temp_override(object=scene.objects[0], material=material):
        assert bpy.ops.material.cotorra_preset_add(name='Mine') == {'FINISHED'}
        (path,) = tmp_path.glob('*.py')
        material.cotorra.shininess = 5.0
        material.cotorra.model = 'LAMBERT'
        bpy.ops.script.execute_preset(filepath=str(path), menu_idname='COTORRA_PT_material_presets')
    assert material.cotorra.shininess == 77.0 and material.cotorra.model == 'COOK_TORRANCE'
