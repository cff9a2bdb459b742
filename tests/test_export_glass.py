# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass is read from Principled and Glass BSDF; what Whitted takes of it is its share of clear glass.

How it is rendered is tested in test_whitted.py.
"""

from __future__ import annotations

import bpy
import pytest

from scenes import build
from scenes.materials import shown

pytestmark = pytest.mark.usefixtures('engine')


def glass_bsdf(**values: object) -> bpy.types.Material:
    material = build.material('Bottle')
    tree = material.node_tree
    node = tree.nodes.new('ShaderNodeBsdfGlass')
    for name, value in values.items():
        node.inputs[name].default_value = value
    tree.links.new(node.outputs[0], build.output(tree).inputs['Surface'])
    return material


def test_principled_glass() -> None:
    build.new_scene()
    found = shown(build.material('Glass', Transmission_Weight=0.75, Roughness=0.0, IOR=1.33))
    assert found.constants['transmission'] == 0.75 and not found.warnings
    assert shown(None).constants['transmission'] == 0.0


@pytest.mark.parametrize('integrator', ['DIRECT', 'PATH', 'WHITTED', 'AO', 'TOON'])
def test_it_is_the_same_for_all_integrators(integrator: str) -> None:
    build.new_scene().cotorra.integrator = integrator
    found = shown(build.material('Glass', Transmission_Weight=1.0, Roughness=0.0))
    assert found.constants['transmission'] == 1.0 and not found.warnings


def test_glass_bsdf() -> None:
    build.new_scene()
    found = shown(glass_bsdf(Color=(0.5, 0.25, 1, 1), Roughness=0.0, IOR=2.5))
    assert found.constants['transmission'] == 1.0 and not found.warnings
    (closure,) = found.closures
    assert closure.name == 'glass' and closure.args[:3] == ((0.5, 0.25, 1.0), (0.0,) * 3, (2.5,) * 3)
