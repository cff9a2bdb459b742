# SPDX-License-Identifier: GPL-3.0-or-later
"""Image files to arrays, in the depth of the file, through OpenImageIO; nothing of Blender, so any thread may do it.

What their numbers mean is told in pixels.py.
"""

from __future__ import annotations

import importlib.util
import os
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Formats of files that are kept; what else there is (32-bit integers, doubles) becomes float.
DTYPES = {'uint8': np.uint8, 'uint16': np.uint16, 'half': np.float16, 'float': np.float32}

ROWS_AT_ONCE = 16

PNG, JPEG = b'\x89PNG\r\n\x1a\n', b'\xff\xd8\xff'
PNG_DEPTH_AT = 24  # bits of a sample, in the chunk IHDR, which comes first


class ImageError(Exception):
    """An image that cannot be read; the text says why."""


@dataclass(frozen=True, slots=True)
class OpenImage:
    """A file whose head is read. shown: how it is called in messages; folder: goes away with it."""

    file: Any
    path: str
    shown: str
    kind: str
    folder: tempfile.TemporaryDirectory | None = None

    @property
    def channels(self) -> int:
        return min(self.file.spec().nchannels, 4)

    def read(self) -> tuple[NDArray, str]:
        """Pixels (H, W, C), C from 1 to 4, the lowest row first, alpha as it is stored; and what is damaged of them."""
        try:
            spec = self.file.spec()
            pixels = self.file.read_image(0, 0, 0, self.channels, self.kind)
            if pixels is None:
                raise ImageError(f'cannot be read from {self.shown} ({self._named(self.file.geterror())})')
            damage = self._named(self.file.geterror()) if self.file.has_error else ''
        finally:
            self.file.close()
            if self.folder is not None:
                self.folder.cleanup()
        rows = np.require(pixels, DTYPES[self.kind], 'CW').reshape(spec.height, spec.width, -1)
        turn_over(rows)
        return rows, damage

    def _named(self, text: str) -> str:
        return first_line(text).replace(self.path, self.shown.strip('"'))


def turn_over(rows: NDArray) -> None:
    """Put the last row first, in place: fresh memory as large costs more than moving the rows."""
    height = len(rows)
    for begin in range(0, height // 2, ROWS_AT_ONCE):
        end = min(begin + ROWS_AT_ONCE, height // 2)
        last = rows[height - end : height - begin]
        first = rows[begin:end].copy()
        rows[begin:end] = last[::-1]
        last[:] = first[::-1]


@cache
def available() -> bool:
    """Whether there is an OpenImageIO: Blender's own builds bring it, those of distributions may not."""
    return importlib.util.find_spec('OpenImageIO') is not None


def open_file(path: str, shown: str = '', folder: tempfile.TemporaryDirectory | None = None) -> OpenImage:
    """Read the head of a file; raises ImageError where it is none. shown: instead of the path in messages."""
    if not available():
        raise ImageError('cannot be read: this Blender has no OpenImageIO')
    import OpenImageIO as oiio  # late: a scene without images does without it

    shown = shown or f'"{path}"'
    config = oiio.ImageSpec()
    config.attribute('oiio:UnassociatedAlpha', 1)
    file = oiio.ImageInput.open(path, config)
    if file is None:
        reason = first_line(oiio.geterror()).replace(path, shown.strip('"'))
        raise ImageError(f'cannot be read from {shown} ({reason})')
    spec = file.spec()
    kind = str(spec.format) if str(spec.format) in DTYPES else 'float'
    if spec.width < 1 or spec.height < 1 or spec.nchannels < 1:
        file.close()
        raise ImageError(f'is empty: {shown}')
    return OpenImage(file, path, shown, kind, folder)


def open_packed(data: bytes, name: str) -> OpenImage:
    """The same for a packed file: OpenImageIO reads from disk only."""
    folder = tempfile.TemporaryDirectory(prefix='cotorra-')
    try:
        path = Path(folder.name) / (os.path.basename(name.replace('\\', '/')) or 'packed')
        path.write_bytes(data)
        return open_file(str(path), f'"packed file {path.name}"', folder)
    except BaseException:
        folder.cleanup()
        raise


def holds_bytes(data: bytes) -> bool:
    """Whether a file surely has 8 bits a sample at most, by its first bytes: Blender then holds no floats of it."""
    if data.startswith(JPEG):
        return True
    return data.startswith(PNG) and len(data) > PNG_DEPTH_AT and data[PNG_DEPTH_AT] <= 8


def first_line(text: str) -> str:
    return text.strip().splitlines()[0] if text.strip() else 'no reason is given'
