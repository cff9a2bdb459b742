# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture on the screen: a texture, drawn with Blender's own colour management into the region that is drawn.

It is called by `view_draw` alone, where Blender has the right framebuffer bound.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

Place = tuple[int, int, int, int]


class Canvas:
    """The texture of one viewport, which lasts until there is a newer picture."""

    def __init__(self) -> None:
        self._texture: Any = None
        self._place: Place = (0, 0, 1, 1)
        self._size = (1, 1)

    def load(self, pixels: np.ndarray, place: Place, region_size: tuple[int, int]) -> None:
        """pixels: (height, width, 4) float32, alpha associated. place: where it lies in a region of that size."""
        import gpu  # not there in background mode

        height, width = pixels.shape[:2]
        data = gpu.types.Buffer('FLOAT', pixels.size, np.ascontiguousarray(pixels).reshape(-1))
        self._texture = gpu.types.GPUTexture((width, height), format='RGBA16F', data=data)
        self._place, self._size = place, region_size

    def draw(self, engine: bpy.types.RenderEngine, scene: bpy.types.Scene, region_size: tuple[int, int]) -> None:
        """Nothing where there is no picture yet. One of another region's size is stretched until there is a new one."""
        if self._texture is None:
            return
        import gpu
        from gpu_extras.presets import draw_texture_2d

        x, y, width, height = self._place
        across, up = (new / old for new, old in zip(region_size, self._size, strict=True))
        gpu.state.blend_set('ALPHA_PREMULT')
        engine.bind_display_space_shader(scene)
        try:
            draw_texture_2d(self._texture, (x * across, y * up), width * across, height * up)
        finally:
            engine.unbind_display_space_shader()
            gpu.state.blend_set('NONE')

    def clear(self) -> None:
        self._texture = None
