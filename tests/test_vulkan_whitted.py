# SPDX-License-Identifier: GPL-3.0-or-later
"""Whitted on the Vulkan device is Whitted on the CPU: mirrors, glass, media, shadows through panes, passes.

What the pictures must show is tested on the CPU (test_whitted.py); how near two devices are, test_vulkan_device.py
tells.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from cotorra import demos
from cotorra.export.buffers import RenderSettings

import vulkan_jobs
from classic_scenes import GLASS, MIRROR, Lamp, Material, box, camera, exported, quad, sphere
from vulkan_jobs import Job, compare, job_of

pytestmark = pytest.mark.usefixtures('engine')

AMBIENT = {'ambient_color': (0.7, 0.85, 1.0), 'ambient_strength': 0.12}
WINE = replace(GLASS, base_color=(0.9, 0.6, 0.8), model={'absorption': (0.5, 2.0, 1.0)})
STUDY = Material(base_color=(0.3, 0.5, 0.2), model={'model': 1, 'kr': 0.3, 'kt': 0.5})
TILE = 16  # pixels: whose means are compared


@pytest.fixture(scope='module')
def module() -> Iterator[ModuleType]:
    yield from vulkan_jobs.opened()


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


def both(job: Job, flips: float, mean: float = 0.0005) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Renders on both devices and compares; the Vulkan device's passes and figures."""
    cpu, cpu_stats = job.render('CPU')
    gpu, stats = job.render('VULKAN')
    assert 'Whitted' in stats['features']
    for name in job.settings.passes:
        compare(cpu[name], gpu[name], flips, name)
        assert gpu[name].mean() == pytest.approx(cpu[name].mean(), rel=mean, abs=1e-7), name
    assert stats['samples'] == cpu_stats['samples'] and stats['rejected_samples'] == 0
    for kind, count in cpu_stats['rays'].items():
        assert stats['rays'][kind] == pytest.approx(count, rel=0.005), kind
    return gpu, stats


def tile_means(pixels: np.ndarray) -> np.ndarray:
    height, width = (side // TILE * TILE for side in pixels.shape[:2])
    return pixels[:height, :width, :3].reshape(height // TILE, TILE, width // TILE, TILE, 3).mean(axis=(1, 3))


def test_the_demo_is_the_image_of_the_cpu(module: ModuleType) -> None:
    job = job_of(module, demos.build('whitted_classic'), (96, 54), integrator='WHITTED', **AMBIENT)
    gpu, _ = both(job, 0.005)
    cpu, _ = job.render('CPU')
    assert tile_means(gpu['combined']) == pytest.approx(tile_means(cpu['combined']), rel=0.002)
    again, _ = job.render('VULKAN')
    assert np.array_equal(gpu['combined'], again['combined']), 'the same bits each time, whatever the queues hold'


@pytest.mark.parametrize('shadows', [False, True])
@pytest.mark.parametrize('depth, threshold', [(0, 0.0), (1, 0.0), (8, 0.003), (8, 0.1), (12, 0.0)])
def test_glass_mirrors_and_media(module: ModuleType, depth: int, threshold: float, shadows: bool) -> None:
    limits = {'whitted_depth': depth, 'whitted_threshold': threshold}
    both(table(module, **limits, use_transparent_shadows=shadows), 0.02)
