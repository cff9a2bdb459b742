# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion, Toon and the passes that take a picture apart: on the Vulkan device as on the CPU's.

What they show is tested against closed forms on the CPU (test_occlusion.py, test_toon.py, test_terms.py). Both devices
draw the same random numbers; see test_vulkan_device.py for where they may differ.
"""

from __future__ import annotations

import dataclasses
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest
from cotorra import demos

import vulkan_jobs
from scenes import build
from scenes.rich import rich_scene
from vulkan_jobs import ROUNDING, TILE_MEAN, Job, compare, job_of, tiles

pytestmark = [pytest.mark.early, pytest.mark.usefixtures('engine')]

MEAN = 0.002  # how far the mean of a picture may be off, beside what compare() says of its pixels
AMBIENT = {'ambient_color': (1.0, 0.7, 0.4), 'ambient_strength': 0.6, 'ao_distance': 2.0}
TERMS = ('term_d', 'term_g', 'term_f')
LINES = ('outline_normal', 'outline_depth', 'outline_object')


def same(job: Job, rounding: float = ROUNDING, bounces: bool = False) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Passes and figures of the Vulkan device, once they are those of the CPU's, and the same bits a second time.

    bounces: so few samples flip too many rays after several bounces for each tile to be as bright.
    """
    cpu, cpu_stats = job.render('CPU')
    gpu, stats = job.render('VULKAN')
    again, _ = job.render('VULKAN')
    for name in job.settings.passes:
        compare(cpu[name], gpu[name], job.fragile(name), name, rounding)
        assert np.array_equal(gpu[name], again[name]), f'{name}: the same bits each time, whatever the queues hold'
        if not bounces and name != 'depth':
            dark = 1e-3 * float(np.abs(cpu[name]).mean())
            assert tiles(gpu[name]) == pytest.approx(tiles(cpu[name]), rel=TILE_MEAN, abs=dark), name
        assert gpu[name].mean() == pytest.approx(cpu[name].mean(), rel=MEAN), name
        assert cpu[name].std() > 0.0, f'{name}: there is nothing to compare'
    assert stats['samples'] == cpu_stats['samples'] and stats['rejected_samples'] == 0
    for kind, count in cpu_stats['rays'].items():
        assert stats['rays'][kind] == pytest.approx(count, rel=0.005), kind
    return gpu, stats


def see_through(scene: bpy.types.Scene) -> bpy.types.Scene:
    """Makes the tiles of the rich scene half transparent."""
    build.principled(bpy.data.materials['Plastic']).inputs['Alpha'].default_value = 0.4
    return scene


# ---- Ambient light


@pytest.mark.every(2)
@pytest.mark.parametrize('demo', ['three_lights', 'model_pair'])
def test_the_picture_of_the_sky(module: ModuleType, demo: str) -> None:
    job = job_of(module, demos.build(demo), integrator='AO', passes=('combined', 'ao', 'diffuse_color'))
    found, stats = same(job)
    assert 'ambient occlusion' in stats['features']
    hit = found['combined'][..., :3] == found['ao']
    assert hit.all(axis=-1).mean() > 0.5, 'the pass is the picture, where a surface is'


def test_the_sky_through_what_is_half_transparent(module: ModuleType) -> None:
    scene = see_through(rich_scene(3))
    _, stats = same(job_of(module, scene, integrator='AO', ao_distance=3.0, samples=8, passes=('combined', 'ao')))
    assert 'transparency' in stats['features']


def test_the_picture_of_the_sky_knows_no_lamp(module: ModuleType) -> None:
    """Not even one that hangs in view."""
    pictures = []
    for visible in (False, True):
        scene = rich_scene(2)
        for lamp in (found for found in scene.objects if found.type == 'LIGHT'):
            lamp.visible_camera = visible
            lamp.location, lamp.data.shadow_soft_size = (0.0, 2.0, 1.5), 0.5
        job = job_of(module, scene, integrator='AO', passes=('combined', 'emission'))
        same(job)
        pictures += [job.render(device)[0]['combined'] for device in ('CPU', 'VULKAN')]
    for device in (0, 1):
        assert np.array_equal(pictures[device], pictures[2 + device])


def test_the_pass_of_paths(module: ModuleType) -> None:
    same(
        job_of(module, demos.build('material_grid'), integrator='PATH', passes=('combined', 'ao', 'shadow')),
        bounces=True,
    )


@pytest.mark.every(2)
@pytest.mark.parametrize('passes', [('combined',), ('combined', 'ao')])
@pytest.mark.parametrize('occluded', [False, True])
def test_the_ambient_term(module: ModuleType, occluded: bool, passes: tuple[str, ...]) -> None:
    settings = AMBIENT | {'use_ambient_occlusion': occluded, 'passes': passes}
    _, stats = same(job_of(module, demos.build('three_lights'), integrator='DIRECT', **settings))
    assert 'ambient occlusion' in stats['features']


@pytest.mark.long
def test_the_ambient_term_of_images_and_models(module: ModuleType) -> None:
    scene = demos.build('model_pair')
    same(job_of(module, scene, integrator='DIRECT', use_ambient_occlusion=True, **AMBIENT), 3.0 * ROUNDING)


@pytest.mark.every(2)
@pytest.mark.parametrize('panes', [False, True])
def test_the_occluded_term_of_whitted(module: ModuleType, panes: bool) -> None:
    """At each surface of the recursion; glass hides the sky even where shadow rays see through it."""
    scene = demos.build('whitted_classic')
    settings = AMBIENT | {'use_ambient_occlusion': True, 'use_transparent_shadows': panes}
    _, stats = same(job_of(module, scene, integrator='WHITTED', passes=('combined', 'ao'), **settings))
    assert {'Whitted', 'ambient occlusion'} <= set(stats['features'])


def test_the_shadow_behind_a_colored_pane(module: ModuleType) -> None:
    """What it takes of each colour, the pass tells as luminance."""
    scene = build.new_scene()
    build.mesh_object(scene, 'Floor', vertices=[(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)])
    pane = build.mesh_object(scene, 'Pane', vertices=[(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)])
    glass = build.material()
    pane.data.materials.append(glass)
    clear = build.node(glass.node_tree, 'BsdfTransparent', Color=(0.9, 0.3, 0.1, 1.0))
    build.connect(glass.node_tree, clear.outputs[0], build.output(glass.node_tree).inputs['Surface'])
    build.light(scene, 'SUN', energy=2.0, color=(0.4, 1.0, 0.8)).rotation_euler = (0.6, 0.2, 0.0)
    build.camera(scene).location = (0, 0, 6)
    found, _ = same(job_of(module, scene, integrator='PATH', samples=8, passes=('combined', 'shadow')))
    assert found['shadow'].min() < 0.5 < found['shadow'].max()


# ---- Toon


@pytest.mark.parametrize('lines', [(), *((name,) for name in LINES), LINES])
def test_toon_with_each_kind_of_line(module: ModuleType, lines: tuple[str, ...]) -> None:
    scene = see_through(rich_scene(3))
    own = bpy.data.materials['Matte'].cotorra
    own.model, own.toon_lit, own.toon_shade, own.toon_steps = 'TOON', (0.9, 0.8, 0.1), (0.1, 0.0, 0.3), 3
    settings = {name: name in lines for name in LINES} | {'toon_outline': bool(lines), 'outline_width': 8.0}
    job = job_of(module, scene, integrator='TOON', samples=8, transparent_film=True, passes=('combined',), **settings)
    found, stats = same(job)
    assert 'toon' in stats['features'] and stats['rays']['camera'] == stats['samples'] * (9 if lines else 1)
    black = (found['combined'][..., :3] == 0.0).all(axis=-1) & (found['combined'][..., 3] == 1.0)
    assert black.any() == bool(lines)


@pytest.mark.every(2)
@pytest.mark.parametrize('kind', ['PERSP', 'ORTHO'])
def test_toon_of_images_and_its_passes(module: ModuleType, kind: str) -> None:
    scene = demos.build('model_pair')
    scene.camera.data.type, scene.camera.data.ortho_scale = kind, 4.0
    passes = ('combined', 'normal', 'diffuse_color', 'depth', 'ao')
    same(job_of(module, scene, integrator='TOON', outline_color=(0.9, 0.1, 0.2), outline_width=1.0, passes=passes))


def test_toon_counts_every_lamp(module: ModuleType) -> None:
    """More than are sampled at once elsewhere, with sizes and without."""
    scene = rich_scene(11)
    bpy.data.materials['Matte'].cotorra.model = 'TOON'
    bpy.data.materials['Matte'].cotorra.toon_steps = 12
    same(job_of(module, scene, integrator='TOON', passes=('combined',)))


# ---- Passes that take a picture apart


def apart(module: ModuleType, scene: bpy.types.Scene, integrator: str, **settings: Any) -> Job:
    scene.view_layers[0].cotorra.use_pass_lights = True
    count = sum(found.type == 'LIGHT' for found in scene.objects)
    lamps = tuple(f'light:{number}' for number in range(count))
    return job_of(module, scene, integrator=integrator, passes=('combined', *TERMS, *lamps), **settings)


def sum_of_lamps(found: dict[str, np.ndarray]) -> np.ndarray:
    return sum(pixels for name, pixels in found.items() if name.startswith('light:'))


def test_terms_and_lamps_of_direct_light(module: ModuleType) -> None:
    scene = demos.build('three_lights')
    scene.world = None
    found, stats = same(apart(module, scene, 'DIRECT'))
    assert 'terms' in stats['features']
    # The same float32 terms, summed in another order.
    assert np.allclose(sum_of_lamps(found), found['combined'][..., :3], rtol=1e-4, atol=1e-6)


def test_lamps_over_normal_maps(module: ModuleType) -> None:
    """Shadow rays are lifted off the smooth surface, not off the one that the map shows."""
    scene = demos.build('model_pair')
    job = apart(module, scene, 'DIRECT', samples=16)
    names = tuple(name for name in job.settings.passes if name not in TERMS)
    same(Job(module, job.buffers, job.camera, dataclasses.replace(job.settings, passes=names)))


def test_terms_and_lamps_of_paths(module: ModuleType) -> None:
    """Beside light groups, which share a lamp's number with its pass."""
    scene = see_through(rich_scene(3))
    scene.view_layers[0].cotorra.use_pass_lights = True
    job = job_of(module, scene, integrator='PATH', samples=8)
    names = (*job.settings.passes, *TERMS, 'light:0', 'light:1', 'light:2')
    found, _ = same(Job(module, job.buffers, job.camera, dataclasses.replace(job.settings, passes=names)), bounces=True)
    lamps, groups = sum_of_lamps(found), found['lightgroup:0']
    # The same float32 terms, summed in another order.
    assert np.allclose(lamps, groups, rtol=1e-4, atol=1e-5), 'all lamps are in one light group'


@pytest.mark.every(2)
@pytest.mark.parametrize('integrator', ['AO', 'TOON'])
def test_terms_are_those_of_the_surface_whoever_renders(module: ModuleType, integrator: str) -> None:
    scene = demos.build('model_pair')
    job = job_of(module, scene, integrator=integrator, passes=('combined', *TERMS))
    found, _ = same(job, 3.0 * ROUNDING)  # at its peaks D is a hundred times its mean
    direct, _ = job_of(module, scene, integrator='DIRECT', passes=('combined', *TERMS)).render('VULKAN')
    for name in TERMS:
        assert np.array_equal(found[name], direct[name]), name


@pytest.mark.parametrize('integrator', ['AO', 'TOON'])
def test_rays_by_the_hardware(module: ModuleType, integrator: str) -> None:
    vulkan_jobs.require(module, 'HARDWARE')
    settings = {'samples': 8, 'outline_width': 3.0, 'ray_tracing': 'HARDWARE', 'passes': ('combined', 'ao')}
    same(job_of(module, see_through(rich_scene(3)), integrator=integrator, **settings))


def test_a_smaller_batch_is_the_same_picture(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what the stages keep beside the lanes, too: no result depends on how many lanes there are."""
    jobs = [
        job_of(module, rich_scene(3), integrator='TOON', samples=8, passes=('combined', 'ao')),
        apart(module, rich_scene(3), 'DIRECT', samples=8, use_ambient_occlusion=True, **AMBIENT),
    ]
    whole = [job.render('VULKAN')[0] for job in jobs]
    monkeypatch.setenv('COTORRA_VULKAN_MEMORY', str(96 << 20))
    for job, large in zip(jobs, whole, strict=True):
        small, _ = job.render('VULKAN')
        for name in job.settings.passes:
            assert np.array_equal(large[name], small[name]), name
