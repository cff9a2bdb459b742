# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of movies as pixels, by Blender's own decoder. Which frame a texture shows is told in images.py.

Python reaches one frame of a movie only, the last that Blender read. Resizing an image reads a frame of one's choice
before it does; it is done to an image that no file holds, and to the size that it has.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from .image_files import ImageError


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame that was read, as an OpenImage of image_files.py; (H, W, C), uint8 or float32, the lowest row first."""

    pixels: NDArray

    @property
    def channels(self) -> int:
        return self.pixels.shape[2]

    def read(self) -> tuple[NDArray, str]:
        return self.pixels, ''


def read_frame(path: str, frame: int, deinterlace: bool) -> Frame:
    """Frame `frame` of a movie, from 1 on; beyond its ends the nearest. ImageError: there is none.

    On Blender's own thread only.
    """
    with bpy.data.temp_data() as data:
        try:
            movie = data.images.load(path)
            movie.source = 'MOVIE'
            movie.use_deinterlace = deinterlace
            width, height = movie.size
            if width * height == 0:
                raise ImageError('is no movie that Blender can read')
            movie.scale(width, height, frame=max(frame, 1))
            return Frame(pixels_of(movie))
        except RuntimeError as error:
            raise ImageError(f'cannot be read ({str(error).strip()})') from None


def pixels_of(image: bpy.types.Image) -> NDArray:
    """The pixels that Blender holds, whose bytes it hands out divided by 255: as Frame's. ImageError: it holds none."""
    width, height = image.size
    count = width * height * image.channels
    if count == 0 or len(image.pixels) != count:
        raise ImageError('has no pixels')
    pixels = np.empty(count, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)
    return pixels if image.is_float else np.rint(pixels * 255.0).astype(np.uint8)
