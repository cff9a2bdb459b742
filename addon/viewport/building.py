# SPDX-License-Identifier: GPL-3.0-or-later
"""The native scene of a viewport, built on a thread of its own, so that the window goes on meanwhile.

It works on arrays; nothing of `bpy` is known here.
"""

from __future__ import annotations

import threading
from types import ModuleType
from typing import Any

from ..export.buffers import SceneBuffers


class Build:
    """One scene on its way. Its thread ends by itself; `cancel` makes that soon."""

    def __init__(
        self, module: ModuleType, buffers: SceneBuffers, threads: int, embree: str | None, previous: Any
    ) -> None:
        """embree: the library by which the CPU traces rays; None where a graphics card does.

        previous: a native scene from before, of which it takes over the meshes that did not change; or None.
        """
        self.scene: Any = None
        self.for_cpu = embree is not None
        self.error: BaseException | None = None
        self._module = module
        self._arguments = (buffers, threads, embree, previous)
        self._cancelled = threading.Event()
        self._thread = threading.Thread(target=self._run, name='cotorra viewport build', daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        self._cancelled.set()

    def done(self, seconds: float = 0.0) -> bool:
        """Whether there is a scene or an error; waits for so long. The interpreter is free meanwhile."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def _run(self) -> None:
        buffers, threads, embree, previous = self._arguments
        stop = self._cancelled.is_set
        try:
            self.scene = self._module.Scene(
                buffers,
                threads,
                embree or '',
                should_cancel=stop,
                bvh=embree is not None,
                editable=True,
                previous=previous,
            )
        except self._module.Cancelled:
            pass
        except BaseException as error:
            self.error = error
        finally:
            self._arguments = None
