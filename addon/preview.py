# SPDX-License-Identifier: GPL-3.0-or-later
"""Previews and icons of materials, worlds and lights, which Blender asks the engine for: small pictures, soon.

Blender renders them as a scene of its own with the datablock in it; what differs from a final render is told here.
"""

from __future__ import annotations

import dataclasses

from .export.buffers import RenderSettings

SAMPLES_MAX = 64  # of a picture of 128 pixels this is a tenth of a second to a second
SECONDS_MAX = 4.0  # nobody waits longer for an icon, whatever the material costs


def smaller(render_settings: RenderSettings) -> RenderSettings:
    """The settings of Blender's scene for previews, with few samples, on the CPU: a card is not woken for an icon."""
    return dataclasses.replace(
        render_settings, samples=min(render_settings.samples, SAMPLES_MAX), adaptive=False, device='CPU'
    )
