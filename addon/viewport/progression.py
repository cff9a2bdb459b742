# SPDX-License-Identifier: GPL-3.0-or-later
"""One picture as it gets better: a session with few large pixels first, then one with all of them.

It knows the native module and arrays, neither Blender's window nor its data. Rays are traced by the sessions' threads,
which are asked for what they have; where something is waited for, the interpreter is free.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any

import numpy as np

from ..export.buffers import PASSES, Camera, RenderSettings
from .view import coarser

# The pass with large pixels is to take no longer than this; how large they are follows from how fast the last was.
COARSE_SECONDS = 0.012
COARSEST = 16
COARSE_FIRST = 8  # before anything is known
SPEED_KEPT = 0.5  # of what was known of the speed, where a new pass tells another

# Pictures of all pixels: as soon as each has a sample, then less and less often, as far as drawing lets it.
PICTURE_SECONDS = 0.1
PICTURE_GROWTH = 1.2
PICTURE_SECONDS_MAX = 1.0


@dataclass(frozen=True, slots=True)
class Picture:
    """What there is to be seen.

    pixels: (height, width, 4) float32, row 0 is the bottom. place: x, y, width, height in pixels of the region.
    divisor: how many of the region's pixels stand along a side of each. samples: that each pixel has at least.
    features: what a denoiser is shown beside it, by native pass; none where pixels are large.
    """

    pixels: np.ndarray
    place: tuple[int, int, int, int]
    divisor: int
    samples: int
    features: dict[str, np.ndarray] = field(default_factory=dict)


class Progression:
    """The sessions of one viewport, one at a time."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module
        self._session: Any = None  # one after the other is restarted: what is on a graphics card stays there
        self._of: Any = None  # the scene that it is of
        self._working = False
        self._held = False
        self._divisors: list[int] = []  # of the sessions that are still to come
        self._divisor = 1
        self._shown_samples = 0
        self._next_picture, self._pause = 0.0, PICTURE_SECONDS
        self._scene: Any = None
        self._camera: Camera | None = None
        self._settings = RenderSettings()
        self._native = 'combined'
        self._features: tuple[str, ...] = ()
        self._features_from = 0
        self._seconds_per_pixel = 0.0

    def restart(
        self,
        scene: Any,
        camera: Camera,
        settings: RenderSettings,
        native_pass: str,
        finest: int,
        features: tuple[str, ...] = (),
        features_from: int = 0,
    ) -> None:
        """Begin anew. finest: pixels of the region along a side of each that is rendered in the end.

        features: native passes that pictures bring along from so many samples on.
        """
        self.stop()
        self._features, self._features_from = features, features_from
        self._scene, self._camera, self._settings, self._native = scene, camera, settings, native_pass
        self._divisors = [*self._coarse(camera, finest), finest]
        self._open()

    def hold(self) -> None:
        """Leave the processor to others until `resume`; what there is stays. Threads are not waited for."""
        if self._working and not self._held:
            self._session.cancel()
            self._held = True

    def resume(self) -> None:
        if self._held:
            self._session.resume()
            self._held = False

    def stop(self) -> None:
        """End the session at work, and wait for its threads while the interpreter is free."""
        working, self._working, self._divisors = self._working, False, []
        self._held = False
        if working:
            self._session.cancel()
            while not _ended(self._session):
                pass

    def close(self) -> None:
        self.stop()
        self._session = self._of = self._scene = None

    @property
    def working(self) -> bool:
        return self._working

    def wait(self, seconds: float) -> None:
        """Wait for the pass with large pixels, where that is the one at work."""
        if self._working and self._divisors and not self._held:
            self._session.wait(seconds)

    def take(self) -> Picture | None:
        """A picture that is newer than the one that was taken last, if there is one. Raises what a thread raised."""
        session = self._session
        if not self._working or self._held:
            return None
        ended = session.wait(0.0)
        samples = session.samples_done()
        now = time.perf_counter()
        picture = None
        due = ended or now >= self._next_picture
        if samples > 0 and due and (samples != self._shown_samples or ended):
            picture = self._read(session, samples)
            self._shown_samples = samples
            cost = time.perf_counter() - now
            self._next_picture = now + max(self._pause, 4.0 * cost)
            self._pause = min(self._pause * PICTURE_GROWTH, PICTURE_SECONDS_MAX)
        if ended:
            self._working = False
            if self._divisors:
                self._learn()
                self._open()
        return picture

    def has_news(self) -> bool:
        """Whether `take` would return a picture, or go on to the next session."""
        session = self._session
        if not self._working or self._held:
            return False
        if session.wait(0.0):
            return True
        return time.perf_counter() >= self._next_picture and session.samples_done() > self._shown_samples

    def figures(self) -> tuple[int, float]:
        """Samples that each pixel of the session at work has, and how much of it is done, 0 to 1."""
        if not self._working:
            return self._shown_samples, 1.0
        return self._session.samples_done(), self._session.progress()

    @property
    def coarse(self) -> bool:
        """Whether the session at work is one with large pixels."""
        return bool(self._divisors)

    def _coarse(self, camera: Camera, finest: int) -> list[int]:
        """The large pixels to begin with; none where all of them take no longer."""
        pixels = camera.region[2] * camera.region[3]
        if self._seconds_per_pixel > 0.0:
            divisor = 1
            while divisor < COARSEST and pixels / divisor**2 * self._seconds_per_pixel > COARSE_SECONDS:
                divisor *= 2
        else:
            divisor = COARSE_FIRST
        while divisor > 1 and min(camera.region[2:]) < 4 * divisor:
            divisor //= 2
        return [divisor] if divisor > finest else []

    def _open(self) -> None:
        divisor = self._divisors.pop(0)
        camera = coarser(self._camera, divisor)
        last = not self._divisors
        settings = self._settings if last else replace(self._settings, samples=1)
        self._divisor, self._shown_samples = divisor, 0
        self._next_picture, self._pause = time.perf_counter(), PICTURE_SECONDS
        try:
            if self._session is None or self._of is not self._scene:
                self._session, self._of = None, self._scene
                self._session = self._module.Session(self._scene, camera, settings, restarts=True)
            else:
                self._session.restart(camera, settings)
        except Exception:
            self._session = None
            raise
        self._session.start()
        self._working = True

    def _learn(self) -> None:
        width, height = coarser(self._camera, self._divisor).region[2:]
        spent = self._session.stats()['render_seconds'] / (width * height)
        known = self._seconds_per_pixel
        self._seconds_per_pixel = spent if known == 0.0 else SPEED_KEPT * known + (1.0 - SPEED_KEPT) * spent

    def _read(self, session: Any, samples: int) -> Picture:
        x, y, w, h = coarser(self._camera, self._divisor).region
        channels = PASSES.get(self._native, 3)
        out = np.empty((h, w, channels), np.float32)
        session.read(self._native, out)
        if channels != 4:
            pixels = np.ones((h, w, 4), np.float32)
            pixels[..., :3] = out
            out = pixels
        d = self._divisor
        features = {}
        if not self._divisors and samples >= self._features_from:
            for name in self._features:
                features[name] = np.empty((h, w, PASSES[name]), np.float32)
                session.read(name, features[name])
        return Picture(out, (x * d, y * d, w * d, h * d), d, samples, features)


def _ended(session: Any) -> bool:
    """Whether all threads have stopped; what they raised is of no interest any more."""
    try:
        return session.wait(0.1)
    except Exception:
        return True
