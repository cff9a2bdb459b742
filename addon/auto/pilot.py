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
from numpy.typing import NDArray

from ..export.buffers import Camera, RenderSettings, SceneBuffers
from .measure import Pictures

POLL_SECONDS = 0.02
FARTHEST = 1e9  # metres; the depth of what is empty is 1e10
GOLDEN = 0x9E3779B9  # 2³² / golden ratio: seeds that are far apart


@dataclass(frozen=True, slots=True)
class Rendered:
    """pictures: (K, P, 3). rays: of all kinds, of all seeds. seconds: of all threads' work. empty: (P,) whether a pixel
    shows no surface, where that was asked.
    """

    pictures: Pictures
    rays: int
    seconds: float
    empty: NDArray[np.bool_] | None = None


def small_camera(
    camera: Camera, width: int, height: int, between: bool = False, shift: tuple[float, float] = (0.0, 0.0)
) -> Camera:
    """The rendered region in so few pixels, each as wide as the camera's own are and in the middle of its share.

    between: they are as wide as their share is, so that together they see all of the picture. shift: of all of them
    from that middle, in shares, from -0.5 to 0.5.
    """
    left, right, bottom, top = camera.window
    x0, y0, columns, rows = camera.region
    across, up = (right - left) / camera.resolution[0], (top - bottom) / camera.resolution[1]
    aside, above = shift[0] * columns / width, shift[1] * rows / height
    left, bottom = left + (x0 + aside) * across, bottom + (y0 + above) * up
    window = (left, left + columns * across, bottom, bottom + rows * up)
    share = (width / columns * height / rows) ** 0.5
    return replace(
        camera,
        window=window,
        resolution=(width, height),
        region=(0, 0, width, height),
        filter_width=camera.filter_width * (1.0 if between else share),
    )


def shift_of(seed: int) -> tuple[float, float]:
    """Where the pilot of a render with this seed has its pixels: no place of the picture is left out by all seeds.

    The additive recurrence of two dimensions by Roberts 2018; none for seed 0.
    """
    return tuple((seed * step + 0.5) % 1.0 - 0.5 for step in (0.7548776662466927, 0.5698402909980532))


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
        look: bool = False,
    ) -> Rendered:
        """One picture for each seed, all at once: they are too small to keep many threads at work one by one.

        scene, camera: others than the pilot's. look: for Rendered.empty.
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
                    sharing=False,  # what a pixel's noise is, is learned from pixels that are independent
                    passes=('combined', 'depth') if look else ('combined',),
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
        empty = None
        if look:
            depth = np.zeros((len(sessions), height, width, 1), np.float32)
            for session, seen in zip(sessions, depth, strict=True):
                session.read('depth', seen)
            empty = (depth > FARTHEST).all(axis=0).reshape(-1)
        figures = [session.stats() for session in sessions]
        self.wall += time.perf_counter() - began
        return Rendered(
            pictures=pictures[..., :3].reshape(len(sessions), -1, 3).astype(np.float64),
            rays=sum(sum(figure['rays'].values()) for figure in figures),
            seconds=sum(figure['busy_seconds'] for figure in figures),
            empty=empty,
        )
