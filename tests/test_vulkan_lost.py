# SPDX-License-Identifier: GPL-3.0-or-later
"""A graphics card that is lost while it renders: what it rendered is kept, and the CPU takes what is missing.

A layer between the module and lavapipe (tests/native/lost_layer.cpp) loses the device. What a card may lack from the
start is tested in test_vulkan_device.py.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np
import pytest
from cotorra import demos, native, stats, watch
from cotorra.export.buffers import RenderSettings

import vulkan
import vulkan_jobs
from native_build import build_module, has_header
from render_calls import read_exr, render_to

pytestmark = pytest.mark.usefixtures('engine')

SAMPLES = 16
NAME = 'VK_LAYER_COTORRA_lost'


@pytest.fixture(scope='module')
def layer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the layer's manifest."""
    if vulkan.lavapipe_driver() is None:
        pytest.skip('lavapipe is not installed (on Debian: apt-get install mesa-vulkan-drivers)')
    if not has_header('vulkan/vk_layer.h'):
        pytest.skip("no headers for Vulkan's layers (on Debian: apt-get install libvulkan-dev)")
    library = build_module('lost_layer', ['tests/native/lost_layer.cpp'])
    manifest = {
        'name': NAME,
        'type': 'INSTANCE',
        'library_path': str(library),
        'api_version': '1.2.0',
        'implementation_version': '1',
        'description': 'loses the device',
        'functions': {'vkGetInstanceProcAddr': 'lost_get_instance', 'vkGetDeviceProcAddr': 'lost_get_device'},
    }
    folder = tmp_path_factory.mktemp('layer')
    (folder / 'lost.json').write_text(json.dumps({'file_format_version': '1.0.0', 'layer': manifest}))
    return folder


@pytest.fixture
def module(layer: Path) -> Iterator[ModuleType]:
    with vulkan.only(vulkan.lavapipe_driver()), pytest.MonkeyPatch.context() as patch:
        patch.setenv('VK_LAYER_PATH', str(layer))
        patch.setenv('VK_INSTANCE_LAYERS', NAME)
        yield native.load()


def submissions(module: ModuleType, job: vulkan_jobs.Job) -> int:
    """How many the whole render takes; the last but a few are of its last samples."""
    for count in range(8, 4096, 4):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv('COTORRA_TEST_LOST_AFTER', str(count))
            session = job.session('VULKAN')
            session.start()
            try:
                while not session.wait(1.0):
                    pass
            except module.DeviceError:
                if 4 <= session.samples_done() < SAMPLES:  # another run may have fewer, and two are needed below
                    return count
            else:
                break
    raise AssertionError('no number of submissions loses the device between the fourth sample and the last')


def mean(image: Path) -> float:
    """Of the colour channels."""
    return float(np.mean([pixels for channel, pixels in read_exr(image)[''].items() if channel in 'RGB']))


def test_samples_are_kept_and_the_cpu_goes_on(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    job = vulkan_jobs.job_of(module, demos.build('box_room'), samples=SAMPLES, integrator='PATH', passes=('combined',))
    whole, _ = job.render('CPU')
    monkeypatch.setenv('COTORRA_TEST_LOST_AFTER', str(submissions(module, job)))
    session = job.session('VULKAN')
    session.start()
    with pytest.raises(module.DeviceError, match='vkQueueSubmit: the device was lost'):
        while not session.wait(1.0):
            pass
    done = session.samples_done()
    assert 2 <= done < SAMPLES  # adaptive sampling, which stands in below, takes two
    # Adaptive sampling that is content with any noise stops there, and draws the numbers of all samples until then.
    settings = {'adaptive': True, 'noise_threshold': 1e9, 'adaptive_min_samples': done}
    early = dataclasses.replace(job, settings=dataclasses.replace(job.settings, **settings))
    fewer, _ = early.render('CPU')
    assert vulkan_jobs.flips(whole['combined'], fewer['combined']).mean() > 0.5, 'fewer samples are another picture'
    kept = job.read(session, 'combined')
    vulkan_jobs.compare(fewer['combined'], kept, early.fragile('combined'), f'{done} samples of the lost card')
    session.continue_on_cpu()
    session.start()
    while not session.wait(1.0):
        pass
    assert session.samples_done() == SAMPLES
    assert session.stats()['device'] == 'CPU'
    vulkan_jobs.compare(whole['combined'], job.read(session, 'combined'), job.fragile('combined'), 'the CPU went on')


def test_a_scene_without_a_bvh_is_refused_by_the_cpu(module: ModuleType) -> None:
    job = vulkan_jobs.job_of(module, demos.build('box_room'))
    scene = module.Scene(job.buffers, bvh=False)
    assert scene.stats()['bvh_bytes'] == 0
    with pytest.raises(ValueError, match='build_bvh'):
        module.Session(scene, job.camera, RenderSettings(samples=1))
    scene.build_bvh(1, native.embree_library())
    module.Session(scene, job.camera, RenderSettings(samples=1))


def test_blender_gets_the_whole_picture(module: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    scene = demos.build('box_room')
    scene.cotorra.samples = SAMPLES
    scene.cotorra.integrator = 'PATH'
    job = vulkan_jobs.job_of(module, scene, samples=SAMPLES, integrator='PATH')
    monkeypatch.setenv('COTORRA_TEST_LOST_AFTER', str(submissions(module, job)))
    scene.render.engine = 'COTORRA'
    scene.cotorra.device = 'VULKAN'
    told = []

    class Listener(watch.Watcher):
        def message(self, level: str, text: str) -> None:
            told.append(f'{level} {text}')

    with watch.attached(Listener()):
        lost = mean(render_to(scene, tmp_path / 'lost.exr'))
    assert any('The CPU renders instead of VULKAN' in text and 'the device was lost' in text for text in told), told
    (layer,) = stats.last(scene.name)
    assert layer.device.endswith('CPU') and layer.samples_done == SAMPLES
    scene.cotorra.device = 'CPU'
    assert lost == pytest.approx(mean(render_to(scene, tmp_path / 'whole.exr')), rel=0.005)
    scene.cotorra.device, scene.cotorra.use_device_fallback = 'VULKAN', False
    with pytest.raises(RuntimeError, match='VULKAN: .*the device was lost'):
        render_to(scene, tmp_path / 'none.exr')
    assert bpy.data.images['Render Result'] is not None
