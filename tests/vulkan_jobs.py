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
NUDGES = 6  # pictures of the CPU's whose camera and objects are moved
ULPS = 4.0  # by which each number of theirs moves at most: as far as a ray's roundings add up to
UNEXPLAINED = 0.002  # share of pixels that may flip though no nudge flipped them: there are but so many nudges
SIGMAS = 4.0


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


@dataclasses.dataclass(frozen=True, slots=True)
class Fragile:
    """Where a pass of the CPU's is at the mercy of rounding.

    mask:     pixels that flip when the camera and the objects move by a rounding error. (Of two surfaces in one plane
              the same one always wins on one device, wherever its camera stands; which one does, the objects decide.)
    variance: mean square of that change, of each pixel's mean over its channels.
    """

    mask: np.ndarray
    variance: np.ndarray


@dataclasses.dataclass
class Job:
    """A scene in the native module, and what to render of it."""

    module: ModuleType
    buffers: SceneBuffers
    camera: Camera
    settings: RenderSettings

    def __post_init__(self) -> None:
        self.scene = self.module.Scene(self.buffers, 0, native.embree_library())
        self.nudged: list[dict[str, np.ndarray]] = []

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

    def nudge(self, seed: int, ulps: float = ULPS) -> Job:
        """The same picture, had its camera and each object stood a rounding error away."""
        random = np.random.default_rng(seed)
        ulp = ulps * float(np.finfo(np.float32).eps)
        camera, instances = self.camera, self.buffers.instances
        view, shown = camera.transform.astype(np.float64), instances.transform.astype(np.float64)
        far = np.abs(view[:, 3]).max()
        size = np.ones((3, 4))
        size[:, 3] = far
        view += ulp * size * random.uniform(-1.0, 1.0, (3, 4))
        window = np.array(camera.window) * (1.0 + ulp * random.uniform(-1.0, 1.0, 4))
        shown[:, :, 3] += ulp * far * random.uniform(-1.0, 1.0, (len(shown), 3))
        return Job(
            self.module,
            dataclasses.replace(
                self.buffers, instances=dataclasses.replace(instances, transform=shown.astype(np.float32))
            ),
            dataclasses.replace(camera, transform=view.astype(np.float32), window=tuple(window.tolist())),
            self.settings,
        )

    def fragile(self, name: str) -> Fragile:
        """What the CPU's own picture owes to rounding."""
        if not self.nudged:
            self.nudged = [self.render('CPU')[0], *(self.nudge(seed).render('CPU')[0] for seed in range(NUDGES))]
        cpu, *others = (passes[name] for passes in self.nudged)
        changed = [other.astype(np.float64) - cpu for other in others]
        return Fragile(
            np.any([flips(cpu, other) for other in others], axis=0),
            np.mean([change.mean(axis=-1) ** 2 for change in changed], axis=0),
        )


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


def tiles(picture: np.ndarray) -> np.ndarray:
    """Means of the whole tiles of a picture, a channel each."""
    rows, columns = (side // TILE for side in picture.shape[:2])
    whole = picture[: rows * TILE, : columns * TILE].astype(np.float64)
    return whole.reshape(rows, TILE, columns, TILE, -1).mean(axis=(1, 3))


def compare_tiles(cpu: np.ndarray, gpu: np.ndarray, what: str) -> None:
    """The mean of each tile is the same, flipped pixels included."""
    wanted, found = (tiles(picture[..., :3]).mean(axis=-1) for picture in (cpu, gpu))
    assert np.abs(found / wanted - 1.0).max() < TILE_MEAN, f'{what}: tiles are off by {found / wanted - 1.0}'


def apart(cpu: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Greatest difference of a pixel's channels, over the mean of the CPU's picture."""
    scale = max(float(np.abs(cpu[np.abs(cpu) < 1e9]).mean()), 1e-6)
    return np.abs(cpu.astype(np.float64) - other).max(axis=-1) / scale


def flips(cpu: np.ndarray, other: np.ndarray) -> np.ndarray:
    return apart(cpu, other) > FLIPPED


def compare(cpu: np.ndarray, gpu: np.ndarray, fragile: Fragile, what: str, allowed: float = ROUNDING) -> None:
    """Fragile pixels may flip, all others differ by rounding alone, and the mean is the same.

    A flip is as likely to either side: the sum of the differences d_i of flipped pixels is 0 with the variance Σ v_i
    over the fragile ones, which the nudged pictures tell. Where they missed a flip, its own d_i² stands for v_i, and so
    it does for the largest of all: few nudges tell of the rare path that found a lamp, or not. All other pixels move
    the mean by no more than their root mean square, which is below `allowed`.
    """
    assert np.isfinite(gpu).all(), what
    flipped = flips(cpu, gpu)
    missed = flipped & ~fragile.mask
    rounding = float(np.sqrt((apart(cpu, gpu)[~flipped] ** 2).mean()))
    difference = (gpu.astype(np.float64) - cpu).mean(axis=-1)
    off = abs(float(difference[flipped].sum()))
    variance = np.where(missed, difference**2, np.where(fragile.mask, fragile.variance, 0.0))
    largest = np.unravel_index(np.argmax(np.where(flipped, abs(difference), 0.0)), flipped.shape)
    variance[largest] = max(variance[largest], difference[largest] ** 2)
    bound = SIGMAS * float(np.sqrt(variance.sum()))
    told = f'{what}: {flipped.sum()} pixels flipped, {missed.sum()} of them for no cause, rounding {rounding:.2g}'
    assert missed.mean() <= UNEXPLAINED and rounding < allowed, told
    assert off <= bound, f'{told}; their differences add up to {off:.3g}, more than {bound:.3g}'
