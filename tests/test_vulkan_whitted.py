# SPDX-License-Identifier: GPL-3.0-or-later
"""Whitted on the Vulkan device is Whitted on the CPU: mirrors, glass, media, shadows through panes, passes.

What the pictures must show is tested on the CPU (test_whitted.py); how near two devices are, test_vulkan_device.py
tells.
"""

from __future__ import annotations

import os
import time
from dataclasses import replace
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest
from cotorra import demos
from cotorra.export.buffers import RenderSettings

from classic_scenes import GLASS, MIRROR, Lamp, Material, box, camera, exported, quad, sphere
from scenes import build
from scenes.rich import rich_scene
from vulkan_jobs import ROUNDING, Job, compare, compare_tiles, job_of

pytestmark = pytest.mark.usefixtures('engine')

AMBIENT = {'ambient_color': (0.7, 0.85, 1.0), 'ambient_strength': 0.12}
WINE = replace(GLASS, base_color=(0.9, 0.6, 0.8), model={'absorption': (0.5, 2.0, 1.0)})
STUDY = Material(base_color=(0.3, 0.5, 0.2), model={'model': 1, 'kr': 0.3, 'kt': 0.5})
DATA = ('depth', 'normal', 'diffuse_color', 'emission', 'environment', 'shadow')


def table(module: ModuleType, size: tuple[int, int] = (64, 48), **settings: Any) -> Job:
    """Glass that is smooth, rough, tinted and absorbs, a mirror, and a sheet with the constants of the studies."""
    balls = [sphere((x, 0.2, 0.45), 0.4, made) for x, made in ((-0.9, GLASS), (0.0, MIRROR), (0.9, WINE))]
    block = box((-0.5, -1.0, 0.1), (0.5, -0.8, 0.6), replace(WINE, roughness=0.4))
    sheet = quad((-1.5, 0.9, 0.2), (3.0, 0.2, 0.0), (0.0, 0.0, 0.8), STUDY)
    floor = quad((-3, -3, 0), (6, 0, 0), (0, 6, 0), Material(base_color=(0.7, 0.6, 0.5), roughness=0.5))
    lamps = [Lamp('SUN', (3.0,) * 3, towards=(1, 1, -2)), Lamp('POINT', (60.0, 50.0, 40.0), (1, -2, 2), size=0.2)]
    buffers = exported([*balls, block, sheet, floor], lamps, world=(0.2, 0.3, 0.5))
    view = camera(size, (0, -4, 3), (0, 4, -2.6), up=(0, 0, 1), window=2.2, filter_width=1.5)
    chosen = {'samples': 8, 'integrator': 'WHITTED', 'passes': ('combined',)} | AMBIENT | settings
    return Job(module, buffers, view, RenderSettings(**chosen))


def both(job: Job, rounding: float = ROUNDING, mean: float = 0.0005) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Renders on both devices and compares; the Vulkan device's passes and figures."""
    cpu, cpu_stats = job.render('CPU')
    gpu, stats = job.render('VULKAN')
    assert 'Whitted' in stats['features']
    for name in job.settings.passes:
        compare(cpu[name], gpu[name], job.fragile(name), name, rounding)
        assert gpu[name].mean() == pytest.approx(cpu[name].mean(), rel=mean, abs=1e-7), name
    assert stats['samples'] == cpu_stats['samples'] and stats['rejected_samples'] == 0
    for kind, count in cpu_stats['rays'].items():
        assert stats['rays'][kind] == pytest.approx(count, rel=0.005), kind
    return gpu, stats


def test_the_demo_is_the_image_of_the_cpu(module: ModuleType, tracing: str) -> None:
    settings = {'integrator': 'WHITTED', 'ray_tracing': tracing} | AMBIENT
    job = job_of(module, demos.build('whitted_classic'), (96, 54), **settings)
    gpu, _ = both(job)
    cpu, _ = job.render('CPU')
    compare_tiles(cpu['combined'], gpu['combined'], 'whitted_classic')
    again, _ = job.render('VULKAN')
    assert np.array_equal(gpu['combined'], again['combined']), 'the same bits each time, whatever the queues hold'


@pytest.mark.every(3)
@pytest.mark.parametrize(
    'depth, threshold, shadows', [(0, 0.0, False), (1, 0.0, True), (8, 0.003, False), (8, 0.1, True), (12, 0.0, True)]
)
def test_glass_mirrors_and_media(module: ModuleType, tracing: str, depth: int, threshold: float, shadows: bool) -> None:
    limits = {'whitted_depth': depth, 'whitted_threshold': threshold}
    both(table(module, **limits, use_transparent_shadows=shadows, ray_tracing=tracing))


def glassy(lamps: int) -> bpy.types.Scene:
    """rich_scene with glass in it, and a floor that is not all there."""
    scene = rich_scene(lamps)
    build.principled(bpy.data.materials['Plastic']).inputs['Transmission Weight'].default_value = 0.7
    build.principled(bpy.data.materials['Matte']).inputs['Alpha'].default_value = 0.8
    return scene


@pytest.mark.parametrize('lamps', [3, 11])
def test_passes_lamps_and_transparency(module: ModuleType, lamps: int) -> None:
    """Up to eight lamps are all sampled at each vertex, of more some are picked."""
    passes = ('combined', 'lightgroup:0', 'lightgroup:1', *DATA)
    job = job_of(module, glassy(lamps), integrator='WHITTED', samples=8, passes=passes, **AMBIENT)
    _, stats = both(job)
    assert {'transparency', 'light groups', 'data passes', 'emissive meshes'} <= set(stats['features'])


@pytest.mark.long
def test_occlusion_terms_and_single_lamps(module: ModuleType) -> None:
    passes = ('combined', 'ao', 'light:0', 'light:1', 'term_d', 'term_f')
    settings = {'use_ambient_occlusion': True, 'ao_distance': 1.0, 'use_transparent_shadows': True}
    _, stats = both(table(module, passes=passes, **settings))
    assert {'ambient occlusion', 'terms'} <= set(stats['features'])


@pytest.mark.long
def test_textures_and_models(module: ModuleType) -> None:
    """A texel's contrast enlarges rounding, and so does each reflection by a bent normal: one is enough."""
    scene = demos.build('model_pair')
    for made in bpy.data.materials:
        made.cotorra.kr = 0.3
    job = job_of(module, scene, integrator='WHITTED', whitted_depth=1, **AMBIENT)
    _, stats = both(job, 3.0 * ROUNDING, 0.001)
    assert {'programs', 'reflection models'} <= set(stats['features']) and stats['rays']['bounce'] > 0


@pytest.mark.parametrize('device', ['CPU', 'VULKAN'])
def test_shadows_through_panes_and_through_what_is_half_there(module: ModuleType, device: str) -> None:
    """A pane dims by its colour, a transparent surface by its alpha, and both cast the shadow of their product."""
    floor = quad((-5, -5, 0), (10, 0, 0), (0, 10, 0))
    pane = box((-5, -5, 1.0), (5, 5, 1.2), replace(GLASS, base_color=(0.9, 0.5, 0.2)))
    gauze = quad((-5, -5, 2.0), (10, 0, 0), (0, 10, 0), Material(alpha=0.25))
    view = camera((8, 8), (0, 0, 0.5), (0, 0, -1), window=0.1)
    buffers = exported([floor, pane, gauze], [Lamp('SUN', (2.0, 2.0, 2.0))])
    settings = RenderSettings(
        samples=1, integrator='WHITTED', use_transparent_shadows=True, passes=('combined', 'shadow')
    )
    image, _ = Job(module, buffers, view, settings).render(device)
    through = 0.96**2 * np.array((0.9, 0.5, 0.2)) * 0.75
    assert image['combined'][..., :3] == pytest.approx(np.broadcast_to(2.0 / np.pi * through, (8, 8, 3)), rel=1e-5)
    assert image['shadow'] == pytest.approx(0.75)


@pytest.mark.parametrize('device', ['CPU', 'VULKAN'])
def test_panes_are_counted(module: ModuleType, device: str) -> None:
    """The seventeenth stops a shadow ray; surfaces with alpha below 1 have a count of their own."""
    floor = quad((-5, -5, 0), (10, 0, 0), (0, 10, 0))
    sheets = [quad((-5, -5, 0.1 + 0.1 * i), (10, 0, 0), (0, 10, 0), replace(GLASS, ior=1.0)) for i in range(17)]
    view = camera((8, 8), (0, 0, 0.05), (0, 0, -1), window=0.1)
    settings = RenderSettings(samples=1, integrator='WHITTED', use_transparent_shadows=True)

    def light(count: int) -> float:
        buffers = exported([floor, *sheets[:count]], [Lamp('SUN', (2.0, 2.0, 2.0))])
        image, _ = Job(module, buffers, view, settings).render(device)
        return float(image['combined'][..., :3].max())

    assert light(16) == pytest.approx(2.0 / np.pi, rel=1e-4)
    assert light(17) == 0.0


@pytest.mark.parametrize('device', ['CPU', 'VULKAN'])
def test_transparent_surfaces_are_counted_beside_panes(module: ModuleType, device: str) -> None:
    floor = quad((-5, -5, 0), (10, 0, 0), (0, 10, 0))
    pane = quad((-5, -5, 1.0), (10, 0, 0), (0, 10, 0), replace(GLASS, ior=1.0))
    gauze = [quad((-5, -5, 0.1 + 0.1 * i), (10, 0, 0), (0, 10, 0), Material(alpha=0.5)) for i in range(3)]
    view = camera((8, 8), (0, 0, 0.05), (0, 0, -1), window=0.1)

    def light(limit: int) -> float:
        settings = RenderSettings(
            samples=1, integrator='WHITTED', use_transparent_shadows=True, transparent_bounces=limit
        )
        buffers = exported([floor, pane, *gauze], [Lamp('SUN', (2.0, 2.0, 2.0))])
        image, _ = Job(module, buffers, view, settings).render(device)
        return float(image['combined'][..., :3].max())

    assert light(3) == pytest.approx(2.0 / np.pi / 8.0, rel=1e-4)
    assert light(2) == 0.0


def test_adaptive_sampling_stops_at_the_same_pixels(module: ModuleType) -> None:
    settings = {'samples': 32, 'adaptive': True, 'noise_threshold': 0.05, 'passes': ('combined', 'sample_count')}
    job = table(module, **settings)
    cpu, _ = job.render('CPU')
    gpu, _ = job.render('VULKAN')
    counts = cpu['sample_count']
    assert counts.min() < counts.max(), 'nothing was adaptive'
    compare(counts, gpu['sample_count'], job.fragile('sample_count'), 'sample_count')
    assert (counts == gpu['sample_count']).mean() > 0.98


def test_a_smaller_batch_is_the_same_picture(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """No result depends on how many lanes there are, nor on where a pass is cut; a deep tree leaves room for few."""
    job = table(module, use_transparent_shadows=True)
    whole, whole_stats = job.render('VULKAN')
    monkeypatch.setenv('COTORRA_VULKAN_MEMORY', str(96 << 20))
    small, stats = job.render('VULKAN')
    assert np.array_equal(whole['combined'], small['combined'])
    assert stats['device_bytes'] < whole_stats['device_bytes']


def test_cancel_ends_a_tree_that_does_not_end(module: ModuleType) -> None:
    """Between two half mirrors each ray becomes two, 64 times over."""
    sheet = Material(model={'model': 1, 'kr': 0.5, 'kt': 0.5})
    sheets = [quad((-50, -50, z), (100, 0, 0), (0, 100, 0), sheet) for z in np.linspace(0.0, 1.0, 70)]
    view = camera((64, 64), (0, 0, 0.5), (0, 0, -1), window=0.1)
    settings = RenderSettings(integrator='WHITTED', whitted_depth=64, whitted_threshold=0.0, passes=('combined',))
    job = Job(module, exported(sheets), view, settings)
    for _ in ('until the driver has compiled what it leaves to the first dispatch', 'in earnest'):
        session = job.session('VULKAN')
        session.start()
        while session.stats()['compile_seconds'] == 0.0:  # until then nothing is traced
            assert not session.wait(0.01)
        assert not session.wait(1.0) and session.samples_done() == 0
        began = time.process_time()
        session.cancel()
        assert session.wait(60.0)
    # As test_vulkan_device.py measures it.
    assert time.process_time() - began < 0.3 * (os.cpu_count() or 1)
