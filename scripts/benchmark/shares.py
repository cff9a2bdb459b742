# SPDX-License-Identifier: GPL-3.0-or-later
"""`./scripts/bench --shares`: of what the variance of a pixel is made. It runs in the worker's Blender; `runner` asks.

Each lamp, the world and the emitting meshes are a light group of their own. Their variance is that of direct light
without a pixel filter; what the filter and the bounces add is the difference of whole renders.
"""

from __future__ import annotations

import dataclasses
from types import ModuleType
from typing import Any

import numpy as np

SEEDS, SAMPLES = 8, 4
MOST_LAMPS = 24  # those beyond share a group
NARROW = 1e-3  # pixels
FLOOR = 0.1  # of the mean, as for relMSE


def grouped(buffers: Any) -> tuple[Any, list[str]]:
    """The scene with its lights in groups, and what these are."""
    lamps = len(buffers.lights.type)
    alone = min(lamps, MOST_LAMPS)
    names = [buffers.lights.names[i] if i < len(buffers.lights.names) else f'lamp {i}' for i in range(alone)]
    if lamps > alone:
        names.append(f'{lamps - alone} other lamps')
    of_lamp = np.minimum(np.arange(lamps), MOST_LAMPS).astype(np.int32)
    lights = dataclasses.replace(buffers.lights, light_group=of_lamp)
    world = dataclasses.replace(buffers.world, light_group=len(names))
    meshes = np.full(len(buffers.instances.mesh), len(names) + 1, np.int32)
    instances = dataclasses.replace(buffers.instances, light_group=meshes)
    names += ['world', 'emitting meshes']
    return dataclasses.replace(
        buffers, lights=lights, world=world, instances=instances, light_groups=tuple(names)
    ), names


def variances(
    module: ModuleType, scene: Any, camera: Any, settings: Any, passes: list[str]
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Of each pass by pixel, the mean over its channels, (h, w); and the mean of `combined`, (h, w)."""
    width, height = camera.region[2:]
    sums = {name: np.zeros((2, height, width, 3)) for name in passes}
    for seed in range(SEEDS):
        session = module.Session(scene, camera, dataclasses.replace(settings, seed=101 + seed, passes=tuple(passes)))
        session.start()
        while not session.wait(0.5):
            pass
        for name, total in sums.items():
            out = np.zeros((height, width, 4 if name == 'combined' else 3), np.float32)
            session.read(name, out)
            pixels = out[..., :3].astype(np.float64)
            total += np.stack([pixels, pixels**2])
    found = {}
    for name, (first, second) in sums.items():
        found[name] = np.maximum(second - first**2 / SEEDS, 0.0).mean(axis=2) / (SEEDS - 1)
    return found, sums['combined'][0].mean(axis=2) / SEEDS


def measure(module: ModuleType, buffers: Any, camera: Any, settings: Any, embree: str) -> dict[str, float]:
    """Shares of the relative variance of a pixel, in the order in which they are told; they sum to 1."""
    buffers, names = grouped(buffers)
    scene = module.Scene(buffers, threads=settings.threads, embree=embree)
    settings = dataclasses.replace(settings, samples=SAMPLES)
    groups = [f'lightgroup:{index}' for index in range(len(names))]
    direct = dataclasses.replace(settings, integrator='DIRECT')
    narrow = dataclasses.replace(camera, filter_width=NARROW)
    whole, mean = variances(module, scene, camera, settings, ['combined'])
    plain, _ = variances(module, scene, camera, direct, ['combined'])
    sharp, _ = variances(module, scene, narrow, direct, ['combined', *groups])

    weight = 1.0 / (mean**2 + (FLOOR * mean.mean()) ** 2 + 1e-30)

    def relative(variance: np.ndarray) -> float:
        values = np.sort((variance * weight).ravel())
        return float(values[: max(1, round(0.999 * values.size))].mean())  # without fireflies

    total = max(relative(whole['combined']), 1e-30)
    unfiltered = relative(sharp['combined'])
    found = {'bounces': relative(whole['combined']) - relative(plain['combined'])}
    found['pixel filter'] = relative(plain['combined']) - unfiltered
    parts = {name: relative(sharp[group]) for name, group in zip(names, groups, strict=True)}
    found |= dict(sorted(parts.items(), key=lambda item: -item[1]))
    found['light together'] = unfiltered - sum(parts.values())  # they are not quite independent
    return {name: value / total for name, value in found.items()}


def text(name: str, shares: dict[str, float]) -> str:
    """What is above half a percent."""
    told = ', '.join(f'{what} {share:.1%}' for what, share in shares.items() if abs(share) >= 0.005)
    return f'{name}: of the variance of a pixel, {told}'
