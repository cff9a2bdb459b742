# SPDX-License-Identifier: GPL-3.0-or-later
"""Redraws viewports when their sessions have something new: a timer of Blender's main thread, which looks often.

There is none while all viewports are at rest. Blender ends it when it loads a file, and engines with it.
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from .viewport import Viewport

SECONDS = 0.01

_viewports: weakref.WeakSet[Viewport] = weakref.WeakSet()


def watch(viewport: Viewport) -> None:
    """Look after this viewport from now on, until it is at rest."""
    _viewports.add(viewport)
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=SECONDS)


def forget(viewport: Viewport) -> None:
    _viewports.discard(viewport)


def stop() -> None:
    """End all viewports: the engine is taken out of Blender."""
    for viewport in list(_viewports):
        viewport.close()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)


def _tick() -> float | None:
    for viewport in list(_viewports):
        if not viewport.look():
            _viewports.discard(viewport)
    return SECONDS if _viewports else None
