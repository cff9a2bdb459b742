# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a viewport without noise: made on a thread of its own, the newest one that there is, one at a time.

It works on arrays; how noise is taken out is told in addon/denoise.py.
"""

from __future__ import annotations

import threading
from dataclasses import replace

from .. import denoise
from .progression import Picture


class Denoiser:
    """Takes noisy pictures and gives clean ones. A thread ends with its picture; `cancel` makes that soon."""

    def __init__(self) -> None:
        self._waiting: tuple[Picture, denoise.Denoising] | None = None
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._clean: Picture | None = None
        self.error = ''  # why there is none, once that is known

    def offer(self, picture: Picture, how: denoise.Denoising) -> None:
        """The newest picture: what waited before is of no interest any more."""
        self._waiting = picture, how
        self._go_on()

    def take(self) -> Picture | None:
        """A clean picture that was not taken before, if there is one."""
        self._go_on()
        clean, self._clean = self._clean, None
        return clean

    @property
    def busy(self) -> bool:
        return self._running() or self._waiting is not None

    @property
    def has_news(self) -> bool:
        return self._clean is not None

    def cancel(self) -> None:
        """Nothing of what was offered is wanted any more."""
        self._stop.set()
        self._stop = threading.Event()
        self._waiting = self._clean = None

    def _running(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def _go_on(self) -> None:
        if self._running() or self._waiting is None:
            return
        (picture, how), self._waiting = self._waiting, None
        self._thread = threading.Thread(
            target=self._run, args=(picture, how, self._stop), name='cotorra viewport denoise', daemon=True
        )
        self._thread.start()

    def _run(self, picture: Picture, how: denoise.Denoising, stop: threading.Event) -> None:
        try:
            clean = denoise.denoised(picture.pixels[..., :3], picture.features, how, stop.is_set)
        except denoise.DenoiseError as error:
            self.error = str(error)
            return
        if clean is None or stop.is_set():
            return
        pixels = picture.pixels.copy()
        pixels[..., :3] = clean
        self._clean = replace(picture, pixels=pixels, features={})
