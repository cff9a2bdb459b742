# SPDX-License-Identifier: GPL-3.0-or-later
"""Images to arrays, in the depth of their files: from files, packed files, generated images, sequences and movies.

An image that cannot be read is None and a message: what is shown instead is told in addon/shader/nodes_texture.py.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable
from concurrent.futures import Executor, Future, wait
from dataclasses import dataclass, field, replace
from functools import cached_property

import bpy
import numpy as np
from numpy.typing import NDArray

from ..log import Log
from . import image_files
from .buffers import Image
from .image_files import ImageError
from .movies import Frame, pixels_of, read_frame
from .pixels import REC709, Coding, convert_colors, prepare

POLL_SECONDS = 0.05
ANIMATED = frozenset(('SEQUENCE', 'MOVIE'))  # sources of which each frame of the scene may show another picture


@dataclass(frozen=True, slots=True)
class Loaded:
    """An image in the table. associated: its colours are multiplied by an alpha of its own."""

    index: int
    associated: bool


@dataclass
class ImageTable:
    """The images met so far, each content once. frame: of the scene, for sequences.

    executor: decodes the files while the export goes on, where there is one; `images` are all there after `finish`.
    failed:   contents that could not be decoded when the export was tried before, and why.
    """

    log: Log
    frame: int
    executor: Executor | None = None
    failed: dict[tuple, str] = field(default_factory=dict)
    images: list[Image | None] = field(default_factory=list)
    uses: set[str] = field(default_factory=set)  # sources of the images that were asked for; whoever reads it clears it
    _by_user: dict[tuple, Loaded | str] = field(default_factory=dict)
    _by_content: dict[tuple, Loaded | str] = field(default_factory=dict)
    _frames: set[tuple] = field(default_factory=set)  # contents that are frames of sequences and movies
    _shown: set[tuple] = field(default_factory=set)  # those that this export asked for
    _pending: list[tuple[tuple, int, Future]] = field(default_factory=list)
    _notes: list[str] = field(default_factory=list)

    def load(self, image: bpy.types.Image | None, user: bpy.types.ImageUser, tile: int = 0) -> Loaded | str:
        """The image as this user sees it, or why it cannot be read. tile: of UDIM tiles; 0 = the first, for all."""
        if image is None:
            return 'no image is chosen'
        self.uses.add(image.source)
        frame = sequence_frame(user, self.frame) if image.source in ANIMATED else 0
        key = (image, frame, tile)
        if key not in self._by_user:
            self.log.checkpoint()
            self._by_user[key] = self._load(image, frame, tile)
        return self._by_user[key]

    def finish(self) -> bool:
        """Wait for the pixels. False where some cannot be decoded, which `failed` tells: export again, knowing that.

        A file's head, which tells what shaders must know of an image, may be whole where the rest is not.
        """
        waiting = {future for _key, _index, future in self._pending}
        while waiting:
            self.log.checkpoint()
            waiting = wait(waiting, POLL_SECONDS).not_done
        good = True
        for key, index, future in self._pending:
            try:
                self._put(index, future.result())
            except ImageError as error:
                self.failed[key] = str(error)
                good = False
        self._pending.clear()
        for note in self._notes:
            self.log.warning(note)
        return good

    def load_file(self, path: str) -> Loaded | str:
        """An image that no block of data is of, linear Rec.709; or why it cannot be read."""
        name = os.path.basename(path)
        self.uses.add('FILE')
        if not path:
            return 'there is no image'
        coding = Coding(REC709, False, 'STRAIGHT')
        key = ('file', path, coding)
        try:
            if key in self.failed:
                raise ImageError(self.failed[key])
            if key not in self._by_content:
                self._by_content[key] = self._add(key, name, None, lambda: image_files.open_file(path), coding)
        except ImageError as error:
            return f'image "{name}" {error}'
        return self._by_content[key]

    def missing(self) -> int:
        """The index of an image of one pixel, which shows what Cycles shows where there is none."""
        key = ('missing',)
        self.uses.add('MISSING')
        if key not in self._by_content:
            self.images.append(Image('missing', np.array([[[255, 0, 255]]], np.uint8)))
            self._by_content[key] = Loaded(len(self.images) - 1, False)
        return self._by_content[key].index

    def computed(self, name: str, key: tuple, pixels: Callable[[], NDArray]) -> int:
        """The index of an image (H, W, 3), float32, linear Rec.709, that no file holds. key: what tells it apart."""
        self.uses.add('COMPUTED')
        if key not in self._by_content:
            found = pixels()
            if self.working_space != REC709:
                converted = convert_colors(found, REC709, self.working_space, False, color_config())
                if isinstance(converted, str):
                    self.log.warning(f'Colours of "{name}" cannot be converted to "{self.working_space}" ({converted})')
                else:
                    found = np.ascontiguousarray(converted, np.float32)
            self.images.append(Image(name, found, False))
            self._by_content[key] = Loaded(len(self.images) - 1, False)
        return self._by_content[key].index

    def for_next(self, log: Log, frame: int, executor: Executor | None = None) -> ImageTable:
        """The table for another export: this one, where images keep their numbers; else one with those of files.

        Blender's own pixels may be painted on without a word; frames that are not shown any more would pile up.
        """
        stale = {key for key in self._by_content if key[0] == 'blender'} | (self._frames - self._shown)
        if stale:
            table = ImageTable(log, frame, executor, self.failed, _frames=self._frames & self._shown)
            for key, found in self._by_content.items():
                if key not in stale:
                    table.images.append(self.images[found.index])
                    table._by_content[key] = replace(found, index=len(table.images) - 1)
            return table
        self.log, self.frame, self.executor = log, frame, executor
        self._by_user.clear()  # its keys are Blender's objects
        self._shown.clear()
        return self

    @cached_property
    def working_space(self) -> str:
        settings = getattr(bpy.data, 'colorspace', None)  # 5.0 and later
        return settings.working_space if settings is not None else REC709

    def _load(self, image: bpy.types.Image, frame: int, tile: int) -> Loaded | str:
        settings = image.colorspace_settings
        if not settings.name:  # of a movie that Blender has not opened yet, which asking for the size makes it do
            _ = image.size[0]
        coding = Coding(settings.name, settings.is_data, image.alpha_mode)
        try:
            key, source = self._source(image, frame, tile)
            key = (*key, coding)
            if source is None and image.is_float:
                coding = replace(coding, space='scene_linear')  # as Blender holds all floats, whatever their file says
            if image.source in ANIMATED:
                self._frames.add(key)
                self._shown.add(key)
            if key not in self._by_content:
                if key in self.failed:
                    raise ImageError(self.failed[key])
                self._by_content[key] = self._add(key, image.name, image, source, coding)
        except ImageError as error:
            return f'image "{image.name}" {error}'
        return self._by_content[key]

    def _source(
        self, image: bpy.types.Image, frame: int, tile: int
    ) -> tuple[tuple, Callable[[], image_files.OpenImage | Frame] | None]:
        """What tells contents apart, and what opens the file; None where the pixels are Blender's own.

        Blender's own copy counts where it was painted on or made in Blender, and where it is packed and no bytes.
        """
        if image.source == 'MOVIE':
            path, deinterlace = image_path(image), image.use_deinterlace
            if not os.path.isfile(path):
                raise ImageError(f'has no file at "{image.filepath}"')
            key = ('movie', path, os.path.getmtime(path), frame, deinterlace)
            return key, lambda: read_frame(path, frame, deinterlace)
        if image.source == 'TILED' and tile == 0:
            self.log.warning(f'Image "{image.name}": UDIM tiles are not supported yet: the first is shown')
        if (is_blenders(image) or not image_files.available()) and tile in (0, first_tile(image)):
            return ('blender', image), None
        packed = image.packed_file if image.source != 'SEQUENCE' else None
        if tile:
            packed = next((found.packed_file for found in image.packed_files if found.tile_number == tile), None)
        if packed is not None and packed.size > 0:
            data = packed.data
            key = ('packed', hashlib.sha256(data).digest())
            # Asking Blender for the size makes it decode the file.
            if not tile and not image_files.holds_bytes(data) and image.size[0] > 0 and image.is_float:
                return key, None
            return key, lambda: image_files.open_packed(data, image.filepath)
        path = image_path(image, frame, tile)
        if not os.path.isfile(path):
            shown = image.filepath if image.source == 'FILE' else path
            raise ImageError(f'has no file at "{shown}"')
        return ('file', path), lambda: image_files.open_file(path)

    def _add(
        self,
        key: tuple,
        name: str,
        image: bpy.types.Image | None,
        source: Callable[[], image_files.OpenImage | Frame] | None,
        coding: Coding,
    ) -> Loaded:
        """A place in the table, which its pixels fill at once or in `finish`."""
        target = self.working_space
        config = color_config()
        if source is None:
            pixels = pixels_of(image)
            channels = pixels.shape[2]
            self.images.append(None)
            self._put(-1, prepare(name, pixels, coding, target, config))
        else:
            file = source()
            channels = file.channels

            def decode() -> tuple[Image, list[str]]:
                pixels, damage = file.read()
                found, notes = prepare(name, pixels, coding, target, config)
                if damage:
                    notes.insert(0, f'Image "{name}" is damaged ({damage}): what could be read of it is shown')
                return found, notes

            self.images.append(None)
            if self.executor is None:
                self._put(-1, decode())
            else:
                self._pending.append((key, len(self.images) - 1, self.executor.submit(decode)))
        has_alpha = channels in (2, 4) and coding.alpha_mode != 'NONE'
        return Loaded(len(self.images) - 1, has_alpha and coding.associates)

    def _put(self, index: int, found: tuple[Image, list[str]]) -> None:
        """What is to be said of an image is said in each export that shows it."""
        self.images[index], notes = found
        self._notes += notes
        for note in notes:
            self.log.warning(note)


def color_config() -> str:
    """The OpenColorIO configuration that Blender uses."""
    return os.environ.get('OCIO') or os.path.join(
        bpy.utils.system_resource('DATAFILES'), 'colormanagement', 'config.ocio'
    )


def sequence_frame(user: bpy.types.ImageUser, frame: int) -> int:
    """The number in the file name or in the movie that frame `frame` of the scene shows, as Blender counts."""
    count = user.frame_duration
    if count == 0:
        return 0
    at = frame - user.frame_start + 1
    if user.use_cyclic:
        at = at % count or count
    return min(max(at, 0), count) + user.frame_offset


def is_blenders(image: bpy.types.Image) -> bool:
    """Whether Blender's copy is the image: it was made or changed in Blender, and no file shows it."""
    return image.source == 'GENERATED' or (image.source != 'SEQUENCE' and image.is_dirty)


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
