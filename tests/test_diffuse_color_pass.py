# SPDX-License-Identifier: GPL-3.0-or-later
"""The pass Diffuse Color tells of diffuse closures alone, as Cycles does, whatever a surface is made of."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from flat_scenes import Flat, flat
from render_calls import here, read_exr, render_to
from scenes import build

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from benchmark.fair import make_fair, set_job

pytestmark = pytest.mark.usefixtures('engine')
COLOR = (0.2, 0.5, 0.8, 1.0)


def of(kind: str, **inputs: object) -> Callable[[Flat], bpy.types.Node]:
    def made(scene: Flat) -> bpy.types.Node:
        surface = scene.node(kind)
        for socket in surface.inputs:
            if socket.name in ('Color', 'Base Color'):
                socket.default_value = COLOR
            elif socket.name.replace(' ', '_') in inputs:
                socket.default_value = inputs[socket.name.replace(' ', '_')]
        return surface

    return made


def mixed(first: Callable, second: Callable) -> Callable[[Flat], bpy.types.Node]:
    def made(scene: Flat) -> bpy.types.Node:
        mix = scene.node('MixShader')
        mix.inputs[0].default_value = 0.25
        for index, shader in enumerate((first, second)):
            scene.link(shader(scene).outputs[0], mix.inputs[1 + index])
        return mix

    return made


def glossy_toon(scene: Flat) -> bpy.types.Node:
    surface = of('BsdfToon')(scene)
    surface.component = 'GLOSSY'
    return surface


SURFACES = {
    'diffuse': of('BsdfDiffuse'),
    'rough diffuse': of('BsdfDiffuse', Roughness=0.7),
    'translucent': of('BsdfTranslucent'),
    'glossy': of('BsdfAnisotropic', Roughness=0.4),
    'glass': of('BsdfGlass', Roughness=0.3),
    'refraction': of('BsdfRefraction'),
    'toon': of('BsdfToon'),
    'glossy toon': glossy_toon,
    'principled': of('BsdfPrincipled'),
    'metal': of('BsdfPrincipled', Metallic=1.0),
    'half metal': of('BsdfPrincipled', Metallic=0.5),
    'principled glass': of('BsdfPrincipled', Transmission_Weight=1.0, Roughness=0.2),
    'half glass': of('BsdfPrincipled', Transmission_Weight=0.5),
    'coated': of('BsdfPrincipled', Coat_Weight=1.0),
    'diffuse and glass': mixed(of('BsdfDiffuse'), of('BsdfGlass')),
    'glass and diffuse': mixed(of('BsdfGlass'), of('BsdfDiffuse')),
}


@pytest.mark.parametrize('name', SURFACES)
def test_diffuse_color_tells_of_diffuse_closures_alone(name: str, tmp_path: Path) -> None:
    made = flat()
    made.link(SURFACES[name](made).outputs[0], made.output.inputs['Surface'])
    build.world(made.scene)
    bpy.context.view_layer.use_pass_diffuse_color = True
    shown = {}
    for engine in ('COTORRA', 'CYCLES'):
        make_fair(made.scene, engine, 2, (4, 4), threads=1)
        set_job(made.scene, 1024, 1, '')
        layers = read_exr(render_to(made.scene, tmp_path / f'{engine}.exr', multilayer=True))
        found = next(channels for name, channels in layers.items() if name.endswith(here('Diffuse Color')))
        shown[engine] = np.array([found[channel][1:3, 1:3].mean() for channel in 'RGB'])
    # Ours draws one closure a sample: of 4,096 draws a quarter has a sigma of 2.7 %. What is 0 is 0.
    assert shown['COTORRA'] == pytest.approx(shown['CYCLES'], rel=0.04, abs=1e-6)
