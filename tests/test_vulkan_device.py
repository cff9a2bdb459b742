# SPDX-License-Identifier: GPL-3.0-or-later
"""The Vulkan device renders what the CPU device renders, on lavapipe (Vulkan on the CPU), under the validation layer.

Both draw the same random numbers. They round differently, so that a ray may pass an edge on the other side, or meet the
other one of two surfaces in one plane: vulkan_jobs.compare() lets pixels flip for that alone.
"""

from __future__ import annotations

import os
import time
from dataclasses import replace
from types import ModuleType

import bpy
import numpy as np
import pytest
from cotorra import demos
from cotorra.export.buffers import Image, RenderSettings

import texture_scenes
from scenes import build
from scenes.rich import rich_scene
from vulkan_jobs import Job, compare, compare_tiles, flips, job_of

pytestmark = [pytest.mark.early, pytest.mark.usefixtures('engine')]

# Passes that the device has beside Combined.
DATA = ('depth', 'position', 'normal', 'uv', 'object_index', 'material_index', 'diffuse_color')
DATA += ('emission', 'environment', 'shadow')


DEMOS = [('three_lights', 'DIRECT'), ('box_room', 'PATH'), ('material_grid', 'PATH'), ('model_pair', 'DIRECT')]


@pytest.mark.every(2)
@pytest.mark.parametrize('demo, integrator', DEMOS)
def test_demo_is_the_image_of_the_cpu(module: ModuleType, tracing: str, demo: str, integrator: str) -> None:
    job = job_of(module, demos.build(demo), integrator=integrator, ray_tracing=tracing)
    cpu, cpu_stats = job.render('CPU')
    gpu, stats = job.render('VULKAN')
    compare(cpu['combined'], gpu['combined'], job.fragile('combined'), demo)
    mean = 0.002 if demo == 'box_room' else 0.0005  # each of its many bounces makes rounding grow
    assert abs(gpu['combined'].mean() / cpu['combined'].mean() - 1.0) < mean
    assert stats['samples'] == cpu_stats['samples'] and stats['rejected_samples'] == 0
    for kind, count in cpu_stats['rays'].items():
        assert stats['rays'][kind] == pytest.approx(count, rel=0.005), kind
    again, _ = job.render('VULKAN')
    assert np.array_equal(gpu['combined'], again['combined']), 'the same bits each time, whatever the queues hold'


@pytest.mark.every(2)
@pytest.mark.parametrize('demo, integrator', DEMOS)
def test_tiles_of_a_demo_are_as_bright(module: ModuleType, tracing: str, demo: str, integrator: str) -> None:
    """With samples enough that one flipped ray does not show in a tile (box_room, 4 samples: 1.5 % in one tile)."""
    job = job_of(module, demos.build(demo), integrator=integrator, samples=64, ray_tracing=tracing)
    compare_tiles(job.render('CPU')[0]['combined'], job.render('VULKAN')[0]['combined'], demo)


def test_models_transparency_and_falloffs(module: ModuleType, tracing: str) -> None:
    """What materials and lamps can be beyond Blender's own."""
    scene = rich_scene(3)
    models = ('PHONG', 'OREN_NAYAR', 'COOK_TORRANCE')
    for made, model in zip((m for m in bpy.data.materials if m.name != 'Glow'), models, strict=True):
        made.cotorra.model = model
    build.principled(bpy.data.materials['Plastic']).inputs['Alpha'].default_value = 0.4
    bpy.data.lights['Point'].cotorra.falloff = 'RANGED'
    bpy.data.lights['Point'].cotorra.range = 6.0
    job = job_of(module, scene, integrator='PATH', samples=8, passes=('combined', 'shadow'), ray_tracing=tracing)
    cpu, _ = job.render('CPU')
    gpu, stats = job.render('VULKAN')
    assert {'transparency', 'reflection models', 'light shapes'} <= set(stats['features'])
    for name in job.settings.passes:
        compare(cpu[name], gpu[name], job.fragile(name), name)
        assert gpu[name].mean() == pytest.approx(cpu[name].mean(), rel=0.002)


@pytest.mark.parametrize('lamps', [3, 11])
def test_a_scene_with_everything(module: ModuleType, tracing: str, lamps: int) -> None:
    """Up to eight lamps are all sampled at each vertex, of more some are picked."""
    job = job_of(
        module, rich_scene(lamps), integrator='PATH', samples=8, transparent_film=lamps > 8, ray_tracing=tracing
    )
    assert len(job.settings.passes) == 3
    cpu, _ = job.render('CPU')
    gpu, stats = job.render('VULKAN')
    assert {'emissive meshes', 'light groups', 'world', 'bounces'} <= set(stats['features'])
    for name in job.settings.passes:
        compare(cpu[name], gpu[name], job.fragile(name), name)
        assert gpu[name].mean() == pytest.approx(cpu[name].mean(), rel=0.001)


def test_a_smaller_batch_is_the_same_picture(module: ModuleType, tracing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """No result depends on how many lanes there are, nor on where a pass is cut."""
    job = job_of(module, demos.build('material_grid'), integrator='DIRECT', ray_tracing=tracing)
    whole, _ = job.render('VULKAN')
    monkeypatch.setenv('COTORRA_VULKAN_MEMORY', str(96 << 20))
    small, _ = job.render('VULKAN')
    assert np.array_equal(whole['combined'], small['combined'])


def test_passes_are_those_of_the_cpu(module: ModuleType, tracing: str) -> None:
    job = job_of(
        module, demos.build('material_grid'), integrator='DIRECT', passes=('combined', *DATA), ray_tracing=tracing
    )
    cpu, _ = job.render('CPU')
    gpu, _ = job.render('VULKAN')
    for name in DATA:
        compare(cpu[name], gpu[name], job.fragile(name), name)


def test_normal_maps(module: ModuleType) -> None:
    """The diffuse lobe knows the bent normal and the smooth one (kernels/bsdf.h, bump_shadowing)."""
    normals = np.random.default_rng(1).uniform(0.0, 1.0, (8, 8, 3)).astype(np.float32)
    normals[..., 2] = 1.0
    bent = texture_scenes.NormalMap(texture_scenes.Slot())
    mesh = replace(texture_scenes.plane(), tangents=np.tile(np.float32([1, 0, 0, 1]), (4, 1)))
    buffers = texture_scenes.scene(
        (mesh,),
        texture_scenes.materials(normal=[bent]),
        images=(Image('normals', normals),),
        lights=texture_scenes.lights(((0.8, 0.3, -0.4), 3.0)),
    )
    job = Job(module, buffers, texture_scenes.camera(0.9, 32), RenderSettings(integrator='DIRECT'))
    cpu, _ = job.render('CPU')
    gpu, _ = job.render('VULKAN')
    compare(cpu['combined'], gpu['combined'], job.fragile('combined'), 'normal maps')
    assert not flips(cpu['combined'], gpu['combined']).any()
    assert cpu['combined'].std() > 0.1


def test_adaptive_sampling_stops_at_the_same_pixels(module: ModuleType, tracing: str) -> None:
    settings = {'samples': 64, 'adaptive': True, 'noise_threshold': 0.05, 'passes': ('combined', 'sample_count')}
    job = job_of(module, demos.build('material_grid'), integrator='DIRECT', ray_tracing=tracing, **settings)
    cpu, _ = job.render('CPU')
    gpu, _ = job.render('VULKAN')
    counts = cpu['sample_count']
    assert counts.min() < counts.max(), 'nothing was adaptive'
    compare(counts, gpu['sample_count'], job.fragile('sample_count'), 'sample_count')
    assert (counts == gpu['sample_count']).mean() > 0.98


def test_out_of_memory_says_how_much(module: ModuleType, tracing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('COTORRA_VULKAN_MEMORY', str(1 << 20))
    session = job_of(module, demos.build('box_room'), ray_tracing=tracing).session('VULKAN')
    session.start()
    with pytest.raises(module.DeviceError, match=r'out of device memory: \d+ MiB for .* has 1 MiB'):
        while not session.wait(1.0):
            pass


def test_cancel_is_quick(module: ModuleType, tracing: str) -> None:
    job = job_of(module, demos.build('box_room'), size=(320, 180), integrator='PATH', samples=4096, ray_tracing=tracing)
    session = job.session('VULKAN')
    session.start()
    while session.samples_done() < 1:
        assert not session.wait(0.01)
    began = time.process_time()
    session.cancel()
    assert session.wait(10.0)
    # 0.2 s for what was under way, and what it takes to give the device back. Lavapipe works on all processors, this
    # clock counts them all, and nothing of other programs.
    assert time.process_time() - began < 0.3 * (os.cpu_count() or 1)
    assert 1 <= session.samples_done() < 4096
    assert np.isfinite(job.read(session, 'combined')).all()


def test_devices_are_listed(module: ModuleType) -> None:
    (device,) = module.devices()
    assert 'llvmpipe' in device['name'] and device['type'] == 'cpu' and device['problem'] == ''
    assert device['memory_bytes'] > 1 << 20 and isinstance(device['ray_query'], bool)


def test_an_unknown_device_is_named(module: ModuleType) -> None:
    job = job_of(module, demos.build('box_room'))
    with pytest.raises(module.DeviceError, match='Vulkan device 7 of 1 cannot be used'):
        job.session('VULKAN', device_index=7)
    with pytest.raises(ValueError, match='CPU or VULKAN'):
        job.session('ABACUS')
    with pytest.raises(ValueError, match='AUTO, SOFTWARE or HARDWARE'):
        job.session('VULKAN', ray_tracing='MAGIC')
