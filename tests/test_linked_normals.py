# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors of any length and direction in the Normal of each closure, value for value as Cycles shows them.

Each facet of a plane has a vector of its own; a sun without size from above or below shines without noise. Normal maps
and bumps, whose vectors are unit length, are test_normal_maps.py's.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Vector

from flat_scenes import node
from render_calls import read_exr
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

SIDE = 12  # facets
PIXELS, WINDOW = 96, 3.2
VIEW = Vector((0.4, -0.7, 1.0)).normalized()
ABOVE, BELOW = ((0.5, 0.6, 0.7), (-0.6, 0.2, 0.25)), ((-0.3, 0.6, -1.0), (-0.7, 0.3, -0.1))
CLOSURES = {
    'diffuse': ('BsdfDiffuse', {}, {}),
    'diffuse, rough': ('BsdfDiffuse', {}, {'Roughness': 0.8}),
    'translucent': ('BsdfTranslucent', {}, {}),
    'glossy': ('BsdfAnisotropic', {}, {'Roughness': 0.6}),
    'glossy, Ashikhmin-Shirley': ('BsdfAnisotropic', {'distribution': 'ASHIKHMIN_SHIRLEY'}, {'Roughness': 0.6}),
    'glass': ('BsdfGlass', {}, {'Roughness': 0.6}),
    'refraction': ('BsdfRefraction', {}, {'Roughness': 0.6}),
    'metallic': ('BsdfMetallic', {}, {'Roughness': 0.6}),
    'sheen': ('BsdfSheen', {}, {'Roughness': 0.6}),
    'sheen, Ashikhmin': ('BsdfSheen', {'distribution': 'ASHIKHMIN'}, {'Roughness': 0.6}),
    'toon': ('BsdfToon', {}, {'Size': 0.9, 'Smooth': 0.5}),
    'toon, glossy': ('BsdfToon', {'component': 'GLOSSY'}, {'Size': 0.9, 'Smooth': 0.5}),
    'metal': ('BsdfPrincipled', {}, {'Roughness': 0.6, 'Metallic': 1.0}),
    'principled': ('BsdfPrincipled', {}, {'Roughness': 0.6, 'Specular IOR Level': 0.0}),
}
OTHERS_IN_4 = ('sheen, Ashikhmin', 'toon, glossy')


def vectors() -> np.ndarray:
    """One for each facet: half of them far from unit length, a third below the plane, one null."""
    dice = np.random.default_rng(7)
    made = dice.normal(size=(SIDE * SIDE, 3))
    made[::3, 2] = np.abs(made[::3, 2])
    made[1::3, 2] = np.abs(made[1::3, 2])
    made[::4] *= 40.0
    made[1::4] *= 0.01
    made[5] = 0.0
    return made.astype(np.float32)


def scene_of(kind: str, properties: dict[str, str], values: dict[str, float]) -> bpy.types.Scene:
    scene = build.new_scene()
    mesh = build.grid(SIDE)
    bent = mesh.attributes.new('Bent', 'FLOAT_VECTOR', 'FACE')
    bent.data.foreach_set('vector', vectors().ravel())
    build.link(scene, 'Plane', mesh)
    material = build.material()
    tree = material.node_tree
    tree.nodes.clear()
    closure, output, vector = node(tree, kind, **properties), node(tree, 'OutputMaterial'), node(tree, 'Attribute')
    vector.attribute_name = 'Bent'
    for name, value in values.items():
        closure.inputs[name].default_value = value
    tree.links.new(vector.outputs['Vector'], closure.inputs['Normal'])
    tree.links.new(closure.outputs[0], output.inputs['Surface'])
    mesh.materials.append(material)
    camera = build.camera(scene, type='ORTHO', ortho_scale=WINDOW)
    camera.location, camera.rotation_euler = 4.0 * VIEW, VIEW.to_track_quat('Z', 'Y').to_euler()
    build.light(scene, 'SUN', energy=np.pi, angle=0.0)
    return scene


def values(scene: bpy.types.Scene, sun: tuple[float, float, float], engine: str, folder: Path) -> np.ndarray:
    """What the middle of each facet sends to the camera."""
    scene.objects['Sun'].rotation_euler = Vector(sun).to_track_quat('Z', 'Y').to_euler()
    scene.render.engine = engine
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.resolution_percentage = 100
    scene.cycles.samples = scene.cotorra.samples = 1
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = 'GAUSSIAN', 0.01
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cotorra.use_denoising = scene.cotorra.use_adaptive_sampling = False
    scene.cycles.max_bounces = scene.cotorra.max_bounces = 0
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = 'OPEN_EXR', '32'
    scene.render.filepath = str(folder / f'{engine}.exr')
    bpy.ops.render.render(write_still=True)
    image = read_exr(folder / f'{engine}.exr')['']['R']
    axes = np.array(VIEW.to_track_quat('Z', 'Y').to_matrix())
    middle = (np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE)), -1).reshape(-1, 2) + 0.5) * 2 / SIDE - 1
    x, y = ((middle @ axes[:2, :2] / WINDOW + 0.5) * PIXELS).T.astype(int)
    return image[PIXELS - 1 - y, x]


@pytest.mark.parametrize('name', CLOSURES)
def test_a_vector_as_a_normal_is_as_in_cycles(name: str, tmp_path: Path) -> None:
    if bpy.app.version < (5, 0, 0) and name in OTHERS_IN_4:
        pytest.skip('of the 144 vectors Cycles 4.5 lights one that 5.2 leaves black')
    scene = scene_of(*CLOSURES[name])
    lit = 0
    for sun in ABOVE + BELOW:
        ours, theirs = (values(scene, sun, engine, tmp_path) for engine in ('COTORRA', 'CYCLES'))
        assert ours == pytest.approx(theirs, rel=2e-3, abs=1e-4)
        lit += np.count_nonzero(theirs > 1e-3)
    assert lit > 30
