# SPDX-License-Identifier: GPL-3.0-or-later
"""Glass is read for Whitted, from Principled and Glass BSDF, and left out by name for integrators that do not refract.

How it is rendered is tested in test_whitted.py.
"""

from __future__ import annotations

import bpy
import pytest
from cotorra.export.buffers import Materials
from cotorra.log import Log

from scenes import build
from scenes.depsgraphs import exported

pytestmark = pytest.mark.usefixtures('engine')


def read(material: bpy.types.Material, integrator: str = 'WHITTED') -> tuple[Materials, list[str]]:
    """The arrays, whose last row is the material's, and the warnings."""
    scene = bpy.context.scene
    scene.cotorra.integrator = integrator
    build.mesh_object(scene).data.materials.append(material)
    log = Log()
    return exported(scene, log).materials, log.texts('WARNING')


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
    found, warnings = read(build.material('Glass', Transmission_Weight=0.75, Roughness=0.0, IOR=1.33))
    assert found.transmission[-1] == 0.75 and found.transmission[0] == 0.0 and not warnings
    assert found.ior[-1] == pytest.approx(1.33)


@pytest.mark.parametrize('integrator', ['DIRECT', 'PATH', 'AO', 'TOON'])
def test_who_does_not_refract_leaves_it_out(integrator: str) -> None:
    build.new_scene()
    found, warnings = read(build.material('Glass', Transmission_Weight=1.0, Roughness=0.0), integrator)
    assert found.transmission is None
    assert warnings == ['Material "Glass": not supported yet: Transmission Weight left out']


def test_glass_bsdf() -> None:
    build.new_scene()
    found, warnings = read(glass_bsdf(Color=(1, 1, 1, 1), Roughness=0.0, IOR=2.4))
    assert found.transmission[-1] == 1.0 and found.ior[-1] == pytest.approx(2.4) and not warnings
    # Each crossing of Principled's glass tints by the root of its base colour.
    found, warnings = read(glass_bsdf(Color=(0.5, 0.25, 1, 1), Roughness=0.0))
    assert found.base_color[-1] == pytest.approx((0.25, 0.0625, 1.0))
    assert len(warnings) == 1 and 'is not tinted' in warnings[0]
    _, warnings = read(glass_bsdf(Roughness=0.0), 'PATH')
    assert len(warnings) >= 1 and 'not supported yet: grey is used instead' in warnings[-1]


def test_rough_glass_is_told_to_be_rendered_clear() -> None:
    build.new_scene()
    _, warnings = read(build.material('Frosted', Transmission_Weight=1.0, Roughness=0.4))
    assert warnings == [
        'Material "Frosted": node "Principled BSDF": rough glass lets light through as if it were smooth'
    ]
