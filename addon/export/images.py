# SPDX-License-Identifier: GPL-3.0-or-later
"""Images to arrays, in the depth of their files: from files, packed files, generated images, frames of sequences.

An image that cannot be read is None and a message: what is shown instead is told in addon/shader/nodes_texture.py.
"""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from ..log import Log
from .buffers import Image

# Formats of files that are kept; what else there is (32-bit integers, doubles) becomes float.
DTYPES = {'uint8': np.uint8, 'uint16': np.uint16, 'half': np.float16, 'float': np.float32}

REC709 = 'Linear Rec.709'


class ImageError(Exception):
    """An image that cannot be read; the text says why."""


@dataclass(frozen=True, slots=True)
class Loaded:
    """An image in the table. associated: its colours are multiplied by an alpha of its own."""

    index: int
    associated: bool
    bounded: bool


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


@dataclass
class ImageTable:
    """The images met so far, each content once. frame: of the scene, for sequences."""

    log: Log
    frame: int
    images: list[Image] = field(default_factory=list)
    uses: set[str] = field(default_factory=set)  # sources of the images that were asked for; whoever reads it clears it
    _by_user: dict[tuple, Loaded | str] = field(default_factory=dict)
    _by_content: dict[tuple, Loaded | str] = field(default_factory=dict)

    def load(self, image: bpy.types.Image | None, user: bpy.types.ImageUser, tile: int = 0) -> Loaded | str:
        """The image as this user sees it, or why it cannot be read. tile: of UDIM tiles; 0 = the first, for all."""
        if image is None:
            return 'no image is chosen'
        self.uses.add(image.source)
        frame = sequence_frame(user, self.frame) if image.source == 'SEQUENCE' else 0
        key = (image, frame, tile)
        if key not in self._by_user:
            self.log.checkpoint()
            self._by_user[key] = self._load(image, frame, tile)
        return self._by_user[key]

    def missing(self) -> int:
        """The index of an image of one pixel, which shows what Cycles shows where there is none."""
        key = ('missing',)
        self.uses.add('MISSING')
        if key not in self._by_content:
            self.images.append(Image('missing', np.array([[[255, 0, 255]]], np.uint8)))
            self._by_content[key] = Loaded(len(self.images) - 1, False, True)
        return self._by_content[key].index

    def computed(self, name: str, key: tuple, pixels: Callable[[], NDArray]) -> int:
        """The index of an image (H, W, 3), float32, linear Rec.709, that no file holds. key: what tells it apart."""
        self.uses.add('COMPUTED')
        if key not in self._by_content:
            found = pixels()
            if self.working_space != REC709:
                converted = _convert_colors(found, REC709, self.working_space, False)
                if isinstance(converted, str):
                    self.log.warning(f'Colours of "{name}" cannot be converted to "{self.working_space}" ({converted})')
                else:
                    found = np.ascontiguousarray(converted, np.float32)
            self.images.append(Image(name, found, False))
            self._by_content[key] = Loaded(len(self.images) - 1, False, False)
        return self._by_content[key].index

    def for_next(self, log: Log, frame: int) -> ImageTable | None:
        """The same images for another export, to which they keep their numbers; None where some may be others now.

        Blender's own pixels may be painted on without a word.
        """
        if any(key[0] == 'blender' for key in self._by_content):
            return None
        self.log, self.frame = log, frame
        self._by_user.clear()  # its keys are Blender's objects
        return self

    @cached_property
    def working_space(self) -> str:
        settings = getattr(bpy.data, 'colorspace', None)  # 5.0 and later
        return settings.working_space if settings is not None else REC709

    def _load(self, image: bpy.types.Image, frame: int, tile: int) -> Loaded | str:
        settings = image.colorspace_settings
        coding = Coding(settings.name, settings.is_data, image.alpha_mode)
        try:
            key, read = self._source(image, frame, tile)
            key = (*key, coding)
            if read is _read_blender and image.is_float:
                coding = replace(coding, space='scene_linear')  # as Blender holds all floats, whatever their file says
            if key not in self._by_content:
                self._by_content[key] = self._add(image, read(image), coding)
        except ImageError as error:
            return f'image "{image.name}" {error}'
        return self._by_content[key]

    def _source(
        self, image: bpy.types.Image, frame: int, tile: int
    ) -> tuple[tuple, Callable[[bpy.types.Image], NDArray]]:
        """What tells contents apart, and the function that reads the pixels.

        Blender's own copy counts where it was painted on or made in Blender, and where it is packed and no bytes.
        """

        def damaged(text: str) -> None:
            self.log.warning(f'Image "{image.name}" is damaged ({text}): what could be read of it is shown')

        if image.source == 'MOVIE':
            self.log.warning(f'Image "{image.name}": movies are not supported yet: one frame is shown')
        elif image.source == 'TILED' and tile == 0:
            self.log.warning(f'Image "{image.name}": UDIM tiles are not supported yet: the first is shown')
        if is_blenders(image) and tile in (0, first_tile(image)):
            return ('blender', image), _read_blender
        packed = image.packed_file if image.source != 'SEQUENCE' else None
        if tile:
            packed = next((found.packed_file for found in image.packed_files if found.tile_number == tile), None)
        if packed is not None and packed.size > 0:
            data = packed.data
            key = ('packed', hashlib.sha256(data).digest())
            if not tile and image.size[0] > 0 and image.is_float:  # asking for the size makes Blender load it
                return key, _read_blender
            return key, lambda image: _read_packed(data, image.filepath, damaged)
        path = image_path(image, frame, tile)
        if not os.path.isfile(path):
            shown = image.filepath if image.source == 'FILE' else path
            raise ImageError(f'has no file at "{shown}"')
        return ('file', path), lambda _image: _read_file(path, damaged)

    def _add(self, image: bpy.types.Image, pixels: NDArray, coding: Coding) -> Loaded:
        has_alpha = pixels.shape[2] in (2, 4)
        if has_alpha and coding.alpha_mode == 'NONE':
            pixels, has_alpha = np.ascontiguousarray(pixels[:, :, :-1]), False
        srgb = coding.space == 'sRGB' and self.working_space == REC709
        known = coding.data or srgb or coding.space in (self.working_space, 'scene_linear')
        associated = has_alpha and coding.associates
        multiplied = associated and coding.alpha_mode == 'PREMUL'
        if pixels.dtype.kind == 'f' and not (np.isfinite(pixels.min()) and np.isfinite(pixels.max())):
            self.log.warning(f'Image "{image.name}": some of its pixels are no finite numbers: 0 is used')
            np.nan_to_num(pixels, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
        if not known:
            pixels, multiplied = self._convert(image, pixels, coding, multiplied)
        if associated and not multiplied:
            _associate(pixels)
        self.images.append(Image(image.name, pixels, srgb))
        return Loaded(len(self.images) - 1, associated, pixels.dtype.kind == 'u')

    def _convert(
        self, image: bpy.types.Image, pixels: NDArray, coding: Coding, multiplied: bool
    ) -> tuple[NDArray, bool]:
        """Into the working space, as half floats, as Cycles does with what it has no short way for.

        multiplied: whether colours are multiplied by alpha; returned with the pixels, as it is then.
        """
        converted = _convert_colors(pixels, coding.space, self.working_space, multiplied)
        if isinstance(converted, str):
            self.log.warning(
                f'Image "{image.name}": colour space "{coding.space}" cannot be converted to '
                f'"{self.working_space}" ({converted}): its numbers are used as they are'
            )
            return pixels, multiplied
        return converted, False


def sequence_frame(user: bpy.types.ImageUser, frame: int) -> int:
    """The number in the file name that frame `frame` of the scene shows, as Blender counts."""
    count = user.frame_duration
    if count == 0:
        return 0
    at = frame - user.frame_start + 1
    if user.use_cyclic:
        at = at % count or count
    return min(max(at, 0), count) + user.frame_offset


def is_blenders(image: bpy.types.Image) -> bool:
    """Whether Blender's copy is the image: it was made or changed in Blender, and no file shows it."""
    return image.source in ('GENERATED', 'MOVIE') or (image.source != 'SEQUENCE' and image.is_dirty)


def first_tile(image: bpy.types.Image) -> int:
    return image.tiles[0].number if len(image.tiles) else 1001


def image_path(image: bpy.types.Image, frame: int = 0, tile: int = 0) -> str:
    """The absolute path of the file that an image shows. tile: of UDIM tiles; 0 = the first."""
    path = bpy.path.abspath(image.filepath, library=image.library)
    if os.sep == '/' and not os.path.exists(path):
        path = path.replace('\\', '/')  # from Windows
    if image.source == 'TILED':
        number = tile or first_tile(image)
        at = number - 1001
        return path.replace('<UDIM>', str(number)).replace('<UVTILE>', f'u{at % 10 + 1}_v{at // 10 + 1}')
    if image.source != 'SEQUENCE':
        return path
    folder, name = os.path.split(path)
    found = re.match(r'(.*?)(\d+)(\D*)$', name)  # the last digits of the name count the frames
    if found is None:
        return path
    head, digits, tail = found.groups()
    return os.path.join(folder, f'{head}{frame:0{len(digits)}d}{tail}')


# ---- Reading. All return (H, W, C), C from 1 to 4, the lowest row first.


def _read_file(path: str, damaged: Callable[[str], None]) -> NDArray:
    """A file in its own depth, alpha as it is stored."""
    import OpenImageIO as oiio  # late: a scene without images does without it

    config = oiio.ImageSpec()
    config.attribute('oiio:UnassociatedAlpha', 1)
    file = oiio.ImageInput.open(path, config)
    if file is None:
        raise ImageError(f'cannot be read from "{path}" ({_first_line(oiio.geterror())})')
    try:
        spec = file.spec()
        kind = str(spec.format) if str(spec.format) in DTYPES else 'float'
        if spec.width < 1 or spec.height < 1 or spec.nchannels < 1:
            raise ImageError(f'is empty: "{path}"')
        pixels = file.read_image(0, 0, 0, min(spec.nchannels, 4), kind)
        if pixels is None:
            raise ImageError(f'cannot be read from "{path}" ({_first_line(file.geterror())})')
        if file.has_error:
            damaged(_first_line(file.geterror()))
    finally:
        file.close()
    return _upside_down(np.asarray(pixels, DTYPES[kind]).reshape(spec.height, spec.width, -1))


def _read_packed(data: bytes, name: str, damaged: Callable[[str], None]) -> NDArray:
    """A packed file: OpenImageIO reads from disk only."""
    with tempfile.TemporaryDirectory(prefix='cotorra-') as folder:
        path = Path(folder) / (os.path.basename(name.replace('\\', '/')) or 'packed')
        path.write_bytes(data)
        try:
            return _read_file(str(path), damaged)
        except ImageError as error:
            raise ImageError(str(error).replace(str(path), f'packed file {path.name}')) from None


def _read_blender(image: bpy.types.Image) -> NDArray:
    """Generated images and movies: the pixels that Blender holds, whose bytes it hands out divided by 255."""
    width, height = image.size
    count = width * height * image.channels
    if count == 0 or len(image.pixels) != count:
        raise ImageError('has no pixels')
    pixels = np.empty(count, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)
    return pixels if image.is_float else np.rint(pixels * 255.0).astype(np.uint8)


def _upside_down(pixels: NDArray) -> NDArray:
    """Rows in the other order, in place: a huge image is not to be in memory twice."""
    pixels = np.require(pixels, requirements=['C', 'W'])
    half = len(pixels) // 2
    for row in range(half):
        pixels[[row, -1 - row]] = pixels[[-1 - row, row]]
    return pixels


def _associate(pixels: NDArray) -> None:
    """Multiply colours by alpha in place; bytes are rounded down, as in Cycles (measured with 5.2.3)."""
    for row in pixels:  # by rows: the products need more bits
        alpha = row[:, -1:]
        if pixels.dtype.kind == 'u':
            row[:, :-1] = row[:, :-1].astype(np.uint32) * alpha // np.uint32(np.iinfo(pixels.dtype).max)
        else:
            row[:, :-1] *= alpha


def _convert_colors(pixels: NDArray, space: str, target: str, multiplied: bool) -> NDArray | str:
    """Colours from one colour space of Blender to another, as half floats, not multiplied by alpha; or why not."""
    import OpenImageIO as oiio

    config = os.environ.get('OCIO') or os.path.join(
        bpy.utils.system_resource('DATAFILES'), 'colormanagement', 'config.ocio'
    )
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
        return _first_line(converted.geterror())
    parts = [converted.get_pixels(oiio.HALF)]
    if alpha is not None:
        parts.append((np.float32(1.0 / most) * alpha).astype(np.float16))
    return np.concatenate(parts, axis=2)


def _first_line(text: str) -> str:
    return text.strip().splitlines()[0] if text.strip() else 'no reason is given'
