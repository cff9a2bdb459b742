# SPDX-License-Identifier: GPL-3.0-or-later
"""Filter Glossy, which is on in new files, widens rays where they bounce, so that bump maps look flatter in them.

A floor sees a ceiling that shines by how flat its bump is; the camera sees the floor alone, so its light is what
bounced rays met. Both engines render it, with Filter Glossy and without.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from flat_scenes import node, shining
from render_calls import read_exr, render_to
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

HEIGHT = 4.0  # of the ceiling, metres
SAMPLES = 128


def bumpy(scale: float, distance: float) -> bpy.types.Material:
    """Shines by the cosine between the bent and the true normal."""
    made = shining('Ceiling')
    made.cycles.emission_sampling = 'NONE'  # such samples have no rays that a bounce could widen
    tree = made.node_tree
    geometry, noise = node(tree, 'NewGeometry'), node(tree, 'TexNoise')
    bump, cosine = node(tree, 'Bump'), node(tree, 'VectorMath', operation='DOT_PRODUCT')
    noise.inputs['Scale'].default_value, noise.inputs['Detail'].default_value = scale, 0.0
    bump.inputs['Distance'].default_value = distance
    tree.links.new(geometry.outputs['Position'], noise.inputs['Vector'])
    tree.links.new(noise.outputs[0], bump.inputs['Height'])
    tree.links.new(bump.outputs[0], cosine.inputs[0])
    tree.links.new(geometry.outputs['True Normal'], cosine.inputs[1])
    tree.links.new(cosine.outputs['Value'], tree.nodes['Shine'].inputs['Color'])
    return made


def surface(kind: str, **inputs: object) -> bpy.types.Material:
    made = build.with_nodes(bpy.data.materials.new(kind))
    tree = made.node_tree
    tree.nodes.clear()
    closure = build.node(tree, kind, Color=(1.0, 1.0, 1.0, 1.0), **inputs)
    if hasattr(closure, 'distribution'):
        closure.distribution = 'GGX'
    tree.links.new(closure.outputs[0], node(tree, 'OutputMaterial').inputs['Surface'])
    return made


def scene_of(
    scale: float, distance: float, closure: str = 'BsdfDiffuse', view: str = 'ORTHO', **inputs: object
) -> bpy.types.Scene:
    scene = build.new_scene()
    build.mesh_object(scene, 'Floor').data.materials.append(surface(closure, **inputs))
    far = 20.0
    corners = [(-far, -far, HEIGHT), (-far, far, HEIGHT), (far, far, HEIGHT), (far, -far, HEIGHT)]
    ceiling = build.mesh_object(scene, 'Ceiling', vertices=corners)
    ceiling.data.materials.append(bumpy(scale, distance))
    ceiling.visible_camera = False
    camera = build.camera(scene, type=view, ortho_scale=1.0)
    camera.location.z = 2.0
    return scene


def light(engine: str, strength: float, folder: Path) -> float:
    """The mean of what the floor shows."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x = scene.render.resolution_y = 24
    scene.cycles.samples, scene.cycles.blur_glossy = SAMPLES, strength
    scene.cotorra.settings_from, scene.cotorra.integrator = 'CYCLES', 'PATH'
    scene.cotorra.use_sample_sharing = False
    channels = read_exr(render_to(scene, folder / f'{engine}.exr'))['']
    return float(np.mean([channels[name].mean() for name in 'RGB']))


# Fine, middling and broad bumps, of which the widened rays see nothing, little and most.
BUMPS = [(50.0, 0.05), (8.0, 0.25), (2.0, 1.0)]


@pytest.mark.parametrize(('scale', 'distance'), BUMPS)
@pytest.mark.parametrize('strength', [0.1, 1.0, 10.0])
def test_bump_behind_a_diffuse_bounce(scale: float, distance: float, strength: float, tmp_path: Path) -> None:
    scene_of(scale, distance)
    theirs, ours = (light(engine, strength, tmp_path) for engine in ('CYCLES', 'COTORRA'))
    assert ours == pytest.approx(theirs, rel=0.01)
    without = light('COTORRA', 0.0, tmp_path)
    assert without == pytest.approx(light('CYCLES', 0.0, tmp_path), rel=0.01)
    if strength >= 1.0:
        assert ours > 1.05 * without, 'it makes a difference'


@pytest.mark.parametrize('roughness', [0.0, 0.3, 0.6])
@pytest.mark.parametrize('view', ['ORTHO', 'PERSP'])
def test_bump_behind_a_glossy_bounce(roughness: float, view: str, tmp_path: Path) -> None:
    """In proportion to alpha: a mirror widens nothing."""
    scene_of(*BUMPS[1], 'BsdfAnisotropic', view, Roughness=roughness)
    theirs, ours = (light(engine, 1.0, tmp_path) for engine in ('CYCLES', 'COTORRA'))
    assert ours == pytest.approx(theirs, rel=0.01)


def test_the_widest_bounce_counts(tmp_path: Path) -> None:
    """A pane in between, which bends nothing, leaves rays as wide as they are."""
    scene = scene_of(*BUMPS[1])
    pane = build.mesh_object(scene, 'Pane', vertices=[(-9, -9, 1), (-9, 9, 1), (9, 9, 1), (9, -9, 1)])
    pane.data.materials.append(surface('BsdfRefraction', Roughness=0.0, IOR=1.0001))
    pane.visible_camera = False
    theirs, ours = (light(engine, 0.1, tmp_path) for engine in ('CYCLES', 'COTORRA'))
    assert ours == pytest.approx(theirs, rel=0.01)
