# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a scene on the CPU device and on the Vulkan device, which is lavapipe under validation, and compares the two.

What is rendered, and how near the pictures must be, the tests say.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest
from cotorra import export, native
from cotorra.export.buffers import PASSES, Camera, RenderSettings, SceneBuffers
from cotorra.log import Log

import vulkan

SIZE = (48, 32)
TRACINGS = {'SOFTWARE': 'software', 'HARDWARE': 'ray query'}  # builds of the stages that trace, and their names
TILE = 16  # pixels
TILE_MEAN = 0.002
FLIPPED = 1e-3  # of the mean: a larger difference is another surface or shadow, not rounding
ROUNDING = 1e-4  # of the mean, root mean square: what rounding alone may do


def opened() -> Iterator[ModuleType]:
    """The native module, whose Vulkan is lavapipe under validation: for a fixture of scope 'module'."""
    driver = vulkan.lavapipe_driver()
    if driver is None:
        pytest.skip('lavapipe is not installed (on Debian: apt-get install mesa-vulkan-drivers)')
    loaded = native.load()
    with vulkan.only(driver), pytest.MonkeyPatch.context() as patch:
        patch.setenv('COTORRA_VULKAN_VALIDATE', '1')
        try:
            loaded.devices()
        except loaded.DeviceError as error:
            if 'layer' not in str(error):
                pytest.skip(str(error))
            patch.delenv('COTORRA_VULKAN_VALIDATE')
        yield loaded


def require(module: ModuleType, tracing: str) -> None:
    """Skip the test where lavapipe cannot trace so."""
    (device,) = module.devices()
    if tracing == 'HARDWARE' and not device['ray_query']:
        pytest.skip(f'{device["driver"]} has no ray queries (scripts/mesa fetches a newer one)')


@dataclasses.dataclass
class Job:
    """A scene in the native module, and what to render of it."""

    module: ModuleType
    buffers: SceneBuffers
    camera: Camera
    settings: RenderSettings

    def __post_init__(self) -> None:
        self.scene = self.module.Scene(self.buffers, 0, native.embree_library())

    def session(self, device: str, **changes: Any) -> Any:
        settings = dataclasses.replace(self.settings, device=device, **changes)
        return self.module.Session(self.scene, self.camera, settings)

    def render(self, device: str, **changes: Any) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Passes by name, and the session's figures."""
        session = self.session(device, **changes)
        session.start()
        while not session.wait(1.0):
            pass
        stats = session.stats()
        assert stats['device_messages'] == [], 'the validation layer has something to say'
        assert device == 'CPU' or stats['isa'] == TRACINGS.get(self.settings.ray_tracing, stats['isa'])
        return {name: self.read(session, name) for name in self.settings.passes}, stats

    def read(self, session: Any, name: str) -> np.ndarray:
        width, height = self.camera.region[2:]
        pixels = np.full((height, width, PASSES.get(name, 3)), np.nan, np.float32)
        session.read(name, pixels)
        return pixels


def job_of(module: ModuleType, scene: bpy.types.Scene, size: tuple[int, int] = SIZE, **settings: Any) -> Job:
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    # What is exported of a material depends on it.
    settings = {'integrator': 'DIRECT', 'samples': 4} | settings
    scene.cotorra.integrator = settings['integrator']
    depsgraph = bpy.context.evaluated_depsgraph_get()
    log = Log()
    camera = export.export_camera(scene, scene.camera, log)
    buffers = export.export_scene(depsgraph, scene, bpy.context.view_layer, log)
    groups = tuple(f'lightgroup:{i}' for i in range(len(buffers.light_groups)))
    settings = {'passes': ('combined', *groups)} | settings
    return Job(module, buffers, camera, RenderSettings(**settings))


def compare_tiles(cpu: np.ndarray, gpu: np.ndarray, what: str) -> None:
    """The mean of each tile is the same, flipped pixels included."""
    height, width = (side // TILE * TILE for side in cpu.shape[:2])
    means = [
        picture[:height, :width, :3].astype(np.float64).reshape(height // TILE, TILE, width // TILE, TILE, 3)
        for picture in (cpu, gpu)
    ]
    wanted, found = (tiles.mean(axis=(1, 3, 4)) for tiles in means)
    assert np.abs(found / wanted - 1.0).max() < TILE_MEAN, f'{what}: tiles are off by {found / wanted - 1.0}'


def compare(cpu: np.ndarray, gpu: np.ndarray, flips: float, what: str, allowed: float = ROUNDING) -> None:
    """All but the share `flips` of the pixels differ by rounding alone, and the mean is the same."""
    assert np.isfinite(gpu).all(), what
    scale = max(float(np.abs(cpu[np.abs(cpu) < 1e9]).mean()), 1e-6)
    apart = np.abs(cpu.astype(np.float64) - gpu).max(axis=-1) / scale
    flipped = apart > FLIPPED
    rounding = float(np.sqrt((apart[~flipped] ** 2).mean()))
    told = f'{what}: {flipped.mean():.4f} of the pixels flipped, rounding {rounding:.2g}'
    assert flipped.mean() <= flips and rounding < allowed, told
