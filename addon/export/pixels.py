# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of a file to what kernels read: colour spaces and alpha as Cycles has them; any thread may do it.

How pixels are read is told in image_files.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import image_files
from .buffers import Image
from .image_files import first_line

REC709 = 'Linear Rec.709'


@dataclass(frozen=True, slots=True)
class Coding:
    """How the numbers of a file become colours: what two uses of one file must agree in to share its pixels."""

    space: str
    data: bool
    alpha_mode: str

    @property
    def associates(self) -> bool:
        """Cycles multiplies by alpha before it filters, save for data and images whose alpha is a fourth channel."""
        return not self.data and self.alpha_mode in ('STRAIGHT', 'PREMUL')


def prepare(name: str, pixels: NDArray, coding: Coding, working_space: str, config: str) -> tuple[Image, list[str]]:
    """The image, and what is to be said of it. pixels: (H, W, C), which may be changed; config: OpenColorIO's file."""
    notes = []
    has_alpha = pixels.shape[2] in (2, 4)
    if has_alpha and coding.alpha_mode == 'NONE':
        pixels, has_alpha = np.ascontiguousarray(pixels[:, :, :-1]), False
    srgb = coding.space == 'sRGB' and working_space == REC709
    known = coding.data or srgb or coding.space in (working_space, 'scene_linear')
    # Grey with alpha is not multiplied, though it is divided where its alpha is used (Cycles 5.2.3).
    associated = has_alpha and coding.associates and pixels.shape[2] == 4
    multiplied = associated and coding.alpha_mode == 'PREMUL'
    if pixels.dtype.kind == 'f' and not (np.isfinite(pixels.min()) and np.isfinite(pixels.max())):
        notes.append(f'Image "{name}": some of its pixels are no finite numbers: 0 is used')
        np.nan_to_num(pixels, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
    if not known:
        # Into the working space, as half floats, as Cycles does with what it has no short way for.
        converted = convert_colors(pixels, coding.space, working_space, multiplied, config)
        if isinstance(converted, str):
            notes.append(
                f'Image "{name}": colour space "{coding.space}" cannot be converted to '
                f'"{working_space}" ({converted}): its numbers are used as they are'
            )
        else:
            pixels, multiplied = converted, False
    if associated and not multiplied:
        _associate(pixels)
    return Image(name, pixels, srgb), notes


def _associate(pixels: NDArray) -> None:
    """Multiply colours by alpha in place; bytes are rounded down, as in Cycles (measured with 5.2.3)."""
    if pixels.dtype.kind == 'u' and pixels[:, :, -1].min() == np.iinfo(pixels.dtype).max:
        return
    for row in pixels:  # by rows: the products need more bits
        alpha = row[:, -1:]
        if pixels.dtype.kind == 'u':
            row[:, :-1] = row[:, :-1].astype(np.uint32) * alpha // np.uint32(np.iinfo(pixels.dtype).max)
        else:
            row[:, :-1] *= alpha


def convert_colors(pixels: NDArray, space: str, target: str, multiplied: bool, config: str) -> NDArray | str:
    """Colours from one colour space of Blender to another, as half floats, not multiplied by alpha; or why not.

    multiplied: whether they are multiplied by alpha; config: the file of OpenColorIO that knows both spaces.
    """
    if not image_files.available():
        return 'this Blender has no OpenImageIO'
    import OpenImageIO as oiio

    most = np.iinfo(pixels.dtype).max if pixels.dtype.kind == 'u' else 1.0
    colors = np.float32(1.0 / most) * pixels[:, :, :3]
    if pixels.shape[2] < 3:
        colors = np.repeat(colors[:, :, :1], 3, axis=2)
    alpha = pixels[:, :, 3:] if pixels.shape[2] == 4 else pixels[:, :, 1:2] if pixels.shape[2] == 2 else None
    if multiplied:
        share = np.float32(1.0 / most) * alpha
        colors = np.divide(colors, share, out=np.array(colors, np.float32), where=share > 0.0)
    source = oiio.ImageBuf(np.ascontiguousarray(colors, np.float32))
    converted = oiio.ImageBufAlgo.colorconvert(source, space, target, False, colorconfig=config)
    if converted.has_error:
        return first_line(converted.geterror())
    parts = [converted.get_pixels(oiio.HALF)]
    if alpha is not None:
        parts.append((np.float32(1.0 / most) * alpha).astype(np.float16))
    return np.concatenate(parts, axis=2)
