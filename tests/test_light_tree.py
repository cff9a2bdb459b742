# SPDX-License-Identifier: GPL-3.0-or-later
"""The light tree: its probabilities (tests/native/light_tree_test.cpp), and pictures of many lights beside each alone.

Few lamps are all sampled, so that a picture of one is the truth that the tree's must add up to.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import native, stats

from light_scenes import assert_as_cycles, ball, box, corner, hang
from native_build import build_program, compiler
from render_calls import render_to
from scenes import build
from vulkan_jobs import TRACINGS, Job, compare, job_of, opened, require


@pytest.mark.skipif(compiler() is None, reason='no C++ compiler (on Debian: apt-get install g++)')
def test_frequencies_are_the_probabilities() -> None:
    program = build_program('light_tree_test', ['tests/native/light_tree_test.cpp', 'native/light_tree.cpp'])
    result = subprocess.run([program], capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stdout + result.stderr


def emitter(scene: bpy.types.Scene, name: str, triangles: int, strength: float) -> bpy.types.Object:
    """A strip of triangles that shine, above the corner's floor."""
    rng = np.random.default_rng(len(name))
    middles = rng.uniform((-2.0, -1.5, 0.8), (2.0, 1.5, 2.5), (triangles, 1, 3))
    corners = middles + rng.normal(scale=0.1, size=(triangles, 3, 3))
    faces = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(triangles)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners.reshape(-1, 3).tolist(), [], faces)
    mesh.materials.append(build.material(name, Emission_Color=(1.0, 0.8, 0.5, 1.0), Emission_Strength=strength))
    obj = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(obj)
    return obj


def many_lamps(scene: bpy.types.Scene, count: int = 12) -> list[bpy.types.Object]:
    """Lamps of each kind, near and far, wide and sharp; the sun is among them."""
    rng = np.random.default_rng(4)
    lamps = []
    for i in range(count):
        kind = ('POINT', 'SPOT', 'AREA', 'SUN')[i % 4]
        place = rng.uniform((-2.5, -2.0, 0.7), (2.5, 1.5, 3.0))
        turn = rng.uniform(-0.8, 0.8, 3)
        size = {'SUN': {'energy': 0.3, 'angle': 0.2}, 'AREA': {'size': 0.6, 'spread': 2.0}}
        own = size.get(kind, {'shadow_soft_size': 0.15 * (i % 3)})
        lamps.append(hang(scene, kind, tuple(place), tuple(turn), **{'energy': 15.0} | own))
    return lamps


def shiny(scene: bpy.types.Scene) -> None:
    box(scene)
    ball(scene, Base_Color=(0.9, 0.9, 0.9, 1.0), Metallic=1.0, Roughness=0.15)


def test_many_lamps_look_as_in_cycles(engine: None, tmp_path: Path) -> None:
    scene = corner()
    shiny(scene)
    many_lamps(scene)
    assert_as_cycles(scene, tmp_path)


def test_emitting_triangles_look_as_in_cycles(engine: None, tmp_path: Path) -> None:
    scene = corner()
    shiny(scene)
    emitter(scene, 'Sparks', 60, 30.0)
    assert_as_cycles(scene, tmp_path)


def one_sided(name: str, back: bool, textured: bool = False) -> bpy.types.Material:
    """Shines to the front alone, or to the back, as importers make it: Mix Shader by Geometry's Backfacing."""
    material = build.material(name)
    tree = material.node_tree
    emission = build.node(tree, 'Emission', Color=(1.0, 0.7, 0.4, 1.0), Strength=30.0)
    if textured:
        build.connect(tree, build.node(tree, 'TexCoord').outputs['Generated'], emission.inputs['Color'])
    mix = tree.nodes.new('ShaderNodeMixShader')
    build.connect(tree, build.node(tree, 'NewGeometry').outputs['Backfacing'], mix.inputs[0])
    black = build.node(tree, 'BsdfDiffuse', Color=(0.0, 0.0, 0.0, 1.0))
    for socket, node in zip(mix.inputs[1:], (black, emission) if back else (emission, black), strict=True):
        build.connect(tree, node.outputs[0], socket)
    output = next(node for node in tree.nodes if node.type == 'OUTPUT_MATERIAL')
    build.connect(tree, mix.outputs[0], output.inputs['Surface'])
    return material


@pytest.mark.parametrize('textured', [False, True])
def test_lights_of_one_side_look_as_in_cycles(engine: None, tmp_path: Path, textured: bool) -> None:
    """Triangles that turn every way: half of them shine away from any place. A mirrored object turns them over."""
    scene = corner()
    shiny(scene)
    for name, back, scale in (('Front', False, 1.0), ('To the back', True, 1.0), ('Over', False, -1.0)):
        obj = emitter(scene, name, 20, 0.0)
        obj.data.materials[0] = one_sided(name, back, textured)
        obj.scale.x = scale
    assert_as_cycles(scene, tmp_path)


def test_lights_of_one_side_are_constants(engine: None) -> None:
    """What is the same wherever it shines needs no program."""
    scene = corner()
    obj = emitter(scene, 'Sparks', 40, 0.0)
    obj.data.materials[0] = one_sided('Sparks', back=False)
    assert 'programs' not in job_of(native.load(), scene, samples=1).render('CPU')[1]['features']
    obj.data.materials[0] = one_sided('Varies', back=False, textured=True)
    assert 'programs' in job_of(native.load(), scene, samples=1).render('CPU')[1]['features']


def test_lamps_and_triangles_look_as_in_cycles(engine: None, tmp_path: Path) -> None:
    scene = corner()
    shiny(scene)
    many_lamps(scene, 9)
    emitter(scene, 'Sparks', 20, 30.0)
    assert_as_cycles(scene, tmp_path, bounces=2)


def picture(job: Job, **changes: object) -> np.ndarray:
    return job.render('CPU', **changes)[0]['combined'][..., :3].astype(np.float64)


def test_the_tree_adds_up_to_each_lamp_alone(engine: None) -> None:
    """Twelve pictures of one lamp each, and one of all twelve."""
    scene = corner()
    shiny(scene)
    lamps = many_lamps(scene)
    module = native.load()
    settings = {'integrator': 'PATH', 'max_bounces': 1, 'diffuse_bounces': 1, 'glossy_bounces': 1, 'samples': 256}
    together = job_of(module, scene, **settings)
    pictures = [picture(together, seed=seed) for seed in (1, 2, 3, 4)]
    alone = np.zeros_like(pictures[0])
    for kept in lamps:
        for lamp in lamps:
            lamp.hide_viewport = lamp is not kept  # this depsgraph is a viewport's
        alone += picture(job_of(module, scene, **settings))
    mean = np.mean(pictures, axis=0)
    noise = np.abs(pictures[0] - pictures[1]).mean() / mean.mean()
    tiles = [image.reshape(4, 8, 6, 8, 3).mean(axis=(1, 3, 4)) for image in (mean, alone)]
    assert np.abs(tiles[0] / tiles[1] - 1.0).max() < 0.03, f'{tiles[0] / tiles[1] - 1.0}, noise {noise}'
    assert abs(mean.mean() / alone.mean() - 1.0) < 0.005


def test_what_bounces_find_is_weighed_as_it_is_sampled(engine: None) -> None:
    """Sampled by the tree and found by bounces alone, triangles give the same light."""
    scene = corner({'Roughness': 0.3, 'Specular_IOR_Level': 0.5})
    obj = emitter(scene, 'Sparks', 40, 40.0)
    obj.scale = (1.0, 1.0, 1.0)
    module = native.load()
    settings = {'integrator': 'PATH', 'max_bounces': 0, 'samples': 256}
    sampled = picture(job_of(module, scene, **settings))
    obj.data.materials[0].cycles.emission_sampling = 'NONE'
    found = np.mean(
        [picture(job_of(module, scene, **settings | {'samples': 1024, 'seed': s})) for s in range(4)], axis=0
    )
    assert abs(sampled.mean() / found.mean() - 1.0) < 0.02


def test_few_lights_have_no_tree(engine: None, tmp_path: Path) -> None:
    scene = corner()
    many_lamps(scene, 8)
    job = job_of(native.load(), scene)
    assert 'light tree' not in job.render('CPU')[1]['features']
    many_lamps(scene, 1)
    assert 'light tree' in job_of(native.load(), scene).render('CPU')[1]['features']


module = pytest.fixture(scope='module')(opened)


@pytest.mark.parametrize('tracing', TRACINGS)
def test_a_graphics_card_picks_the_same(tracing: str, module, engine: None) -> None:
    require(module, tracing)
    scene = corner()
    shiny(scene)
    many_lamps(scene)
    emitter(scene, 'Sparks', 30, 30.0)
    job = job_of(
        module,
        scene,
        integrator='PATH',
        max_bounces=2,
        diffuse_bounces=2,
        glossy_bounces=2,
        samples=8,
        ray_tracing=tracing,
    )
    cpu, gpu = (job.render(device)[0]['combined'] for device in ('CPU', 'VULKAN'))
    compare(cpu, gpu, job.fragile('combined'), 'many lights')


def test_statistics_tell_of_the_tree(engine: None) -> None:
    scene = corner()
    emitter(scene, 'Sparks', 1000, 1.0)
    told = job_of(native.load(), scene).scene.stats()
    assert told['emitters'] == 1000
    assert 48 * 1000 < told['light_bytes'] < 250 * 1000
    assert 0.0 < told['light_tree_seconds'] < 5.0


def test_a_great_many_lights_are_told_of(engine: None, tmp_path: Path, capfd) -> None:
    """A mesh of 120,000 triangles that emit: what it costs stands in the log, and stays small."""
    scene = corner()
    emitter(scene, 'Sparks', 120_000, 0.001)
    scene.render.engine, scene.cotorra.samples = 'COTORRA', 1
    render_to(scene, tmp_path / 'many.exr')
    (layer,) = stats.last(scene.name)
    assert '0 lamps and 120000 triangles that emit take' in capfd.readouterr().out
    assert layer.scene['light_bytes'] < 140 * 120_000


def test_weak_shadow_rays_are_fewer_and_the_light_the_same(engine: None) -> None:
    """The light threshold leaves out rays at random; the mean stays, sample by sample of the same paths."""
    scene = corner()
    shiny(scene)
    many_lamps(scene)
    emitter(scene, 'Sparks', 30, 30.0)
    bounces = dict.fromkeys(('max_bounces', 'diffuse_bounces', 'glossy_bounces'), 3)
    job = job_of(native.load(), scene, integrator='PATH', samples=256, **bounces)
    (all_of_them, every), (some, fewer) = (job.render('CPU', light_threshold=limit) for limit in (0.0, 0.1))
    assert fewer['rays']['shadow'] < 0.8 * every['rays']['shadow']
    pictures = [found['combined'][..., :3].astype(np.float64) for found in (some, all_of_them)]
    tiles = [image.reshape(4, 8, 6, 8, 3).mean(axis=(1, 3, 4)) for image in pictures]
    assert np.abs(tiles[0] / tiles[1] - 1.0).max() < 0.02
    assert abs(pictures[0].mean() / pictures[1].mean() - 1.0) < 0.003
