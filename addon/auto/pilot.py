# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the small pictures of a pilot with the native module: the same seeds for all settings that are compared.

Each pixel of a small picture has the size of one of the whole: it is a pixel of the picture that will be rendered, one
of a regular grid of them, so that differences and noise are the whole picture's. What they mean is measure.py's.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import numpy as np

from ..export.buffers import Camera, RenderSettings, SceneBuffers
from .measure import Pictures

POLL_SECONDS = 0.02
GOLDEN = 0x9E3779B9  # 2³² / golden ratio: seeds that are far apart


@dataclass(frozen=True, slots=True)
class Rendered:
    """pictures: (K, P, 3). rays: of all kinds, of all seeds. seconds: of all threads' work."""

    pictures: Pictures
    rays: int
    seconds: float


def small_camera(camera: Camera, width: int, height: int, between: bool = False) -> Camera:
    """The rendered region in so few pixels, each as wide as the camera's own are and in the middle of its share.

    between: they are as wide as their share is, so that together they see all of the picture.
    """
    left, right, bottom, top = camera.window
    x0, y0, columns, rows = camera.region
    across, up = (right - left) / camera.resolution[0], (top - bottom) / camera.resolution[1]
    window = (left + x0 * across, left + (x0 + columns) * across, bottom + y0 * up, bottom + (y0 + rows) * up)
    share = (width / columns * height / rows) ** 0.5
    return replace(
        camera,
        window=window,
        resolution=(width, height),
        region=(0, 0, width, height),
        filter_width=camera.filter_width * (1.0 if between else share),
    )


def seeds(first: int, count: int, part: int) -> list[int]:
    """Seeds of one part of a pilot, other than those of all other parts and than the render's own."""
    return [(first + GOLDEN * (1 + part * count + index)) & 0xFFFFFFFF for index in range(count)]


class Pilot:
    """The scene, as it is rendered small.

    stop:  raises where the user asked to stop. build: makes a scene of other buffers, with its BVH.
    paths: camera paths so far, and what else was done, in paths. wall: seconds so far.
    """

    def __init__(
        self,
        module: ModuleType,
        scene: Any,
        camera: Camera,
        stop: Callable[[], None],
        build: Callable[[SceneBuffers], Any] | None = None,
    ) -> None:
        self.module, self.scene, self.camera = module, scene, camera
        self.stop, self.build = stop, build
        self.paths = 0
        self.wall = 0.0

    def built(self, buffers: SceneBuffers, work: int) -> Any:
        """Another scene; work: what it costs, in paths."""
        began = time.perf_counter()
        made = self.build(buffers)
        self.paths += work
        self.wall += time.perf_counter() - began
        return made

    def render(
        self,
        settings: RenderSettings,
        samples: int,
        numbers: list[int],
        scene: Any = None,
        camera: Camera | None = None,
    ) -> Rendered:
        """One picture for each seed, all at once: they are too small to keep many threads at work one by one.

        scene, camera: others than the pilot's.
        """
        began = time.perf_counter()
        camera = camera or self.camera
        width, height = camera.resolution
        threads = settings.threads or os.cpu_count() or 1
        sessions = [
            self.module.Session(
                scene or self.scene,
                camera,
                replace(
                    settings,
                    samples=samples,
                    seed=number,
                    adaptive=False,
                    reweighting=0.0,
                    passes=('combined',),
                    threads=max(1, threads // len(numbers)),
                ),
            )
            for number in numbers
        ]
        try:
            at_once = max(1, min(len(sessions), threads))
            for first in range(0, len(sessions), at_once):
                group = sessions[first : first + at_once]
                for session in group:
                    session.start()
                for session in group:
                    while not session.wait(POLL_SECONDS):
                        self.stop()
        finally:
            for session in sessions:
                session.cancel()
        self.paths += samples * width * height * len(numbers)
        pictures = np.zeros((len(sessions), height, width, 4), np.float32)
        for session, picture in zip(sessions, pictures, strict=True):
            session.read('combined', picture)
        figures = [session.stats() for session in sessions]
        self.wall += time.perf_counter() - began
        return Rendered(
            pictures=pictures[..., :3].reshape(len(sessions), -1, 3).astype(np.float64),
            rays=sum(sum(figure['rays'].values()) for figure in figures),
            seconds=sum(figure['busy_seconds'] for figure in figures),
        )
