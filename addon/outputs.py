# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that a render leaves: their names, whether they can be written, and how a new one takes an old one's place.

It holds no picture and writes none; what is written where is up to the caller.
"""

from __future__ import annotations

import os
import re
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .terminal import CommandError

# Blender's paths hold 1023 bytes; the rest is for the name of the file.
PATH_BYTES_MAX = 900


def frame_path(pattern: Path, frame: int | None, several: bool) -> Path:
    """The file of a frame: its number in place of the last run of #, else before the suffix if frames are several."""
    hashes = re.search(r'#+(?=[^#]*$)', pattern.name)
    if hashes is None and several:
        return pattern.with_name(f'{pattern.stem}{frame:04d}{pattern.suffix}')
    if hashes is None or frame is None:
        return pattern
    number = f'{frame:0{len(hashes[0])}d}'
    return pattern.with_name(pattern.name[: hashes.start()] + number + pattern.name[hashes.end() :])


def require_readable(path: Path) -> None:
    """Fail now if there is no file to open, and say what is there instead."""
    try:
        kind = os.stat(path).st_mode
        if stat.S_ISDIR(kind):
            raise CommandError(f'{path}: is a directory, not a file')
        if not stat.S_ISREG(kind):
            raise CommandError(f'{path}: is a device or pipe, not a file')
        with path.open('rb'):
            pass
    except FileNotFoundError as error:
        raise CommandError(f'{path}: there is no such file') from error
    except OSError as error:
        raise CommandError(f'{path}: cannot be read: {error.strerror}') from error


def require_writable(path: Path) -> None:
    """Fail now if the file cannot be written later; folders that are missing are made, as Blender does."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CommandError(f'{path}: the folder {path.parent} cannot be made: {error.strerror}') from error
    try:
        target = _target(path)
        if not target.exists():
            with _folder_beside(target):
                return
    except OSError as error:
        raise CommandError(f'{path}: cannot be written: {error.strerror}') from error
    if target.is_dir():
        raise CommandError(f'{path}: cannot be written: it is a directory')
    if not os.access(target, os.W_OK):
        raise CommandError(f'{path}: cannot be written: it is write-protected')


def require_apart(path: Path, others: list[Path], what: str) -> None:
    """Fail if the file that `path` names is one of the others, by whatever name."""
    for other in others:
        if _target(path) == _target(other) or (path.exists() and other.exists() and path.samefile(other)):
            raise CommandError(f'{path}: {what} would be written over {other}')


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A name to write to; where the block ends well, the file written there takes the place of the one at `path`.

    It lies beside `path`, so that the old file stays until the new one replaces it in one step. Only devices, and files
    in folders where no other may be made, are written over; then with what is known to be whole.
    """
    try:
        target = _target(path)
        beside = not target.exists() or (target.is_file() and os.access(target.parent, os.W_OK))
        with _folder_beside(target) if beside else tempfile.TemporaryDirectory(prefix='cotorra-') as folder:
            with _plain(folder) as plain:
                new = plain / f'new{path.suffix.lower()}'
                yield new
                _take_place(new, target)
    except OSError as error:
        raise CommandError(f'{path}: cannot be written: {error.strerror}') from error


def require_whole(image_path: Path, path: Path) -> tuple[int, int]:
    """Width and height of the image, which shall stand at `path`; fails if it breaks off.

    Where the disk is full, Blender writes half an image and tells of success.
    """
    import OpenImageIO as oiio

    image = oiio.ImageInput.open(str(image_path))
    part, size = 0, (0, 0)
    while image is not None and image.seek_subimage(part, 0):
        part += 1
        spec = image.spec()
        size = (spec.width, spec.height)
        if image.read_scanline(spec.y + spec.height - 1, 0, 'float') is None:
            part = 0
            break
    if part == 0:
        oiio.geterror()  # it would be told when the process ends
        raise CommandError(f'{path}: the image was not written to its end; is there space left?')
    return size


def _target(path: Path) -> Path:
    """The file itself, where `path` is a symbolic link: the link stays."""
    target = Path(os.path.realpath(path))
    try:
        os.stat(target)
    except FileNotFoundError:
        pass
    return target


def _folder_beside(target: Path) -> tempfile.TemporaryDirectory[str]:
    """A new folder in the target's, gone when it is closed."""
    return tempfile.TemporaryDirectory(prefix='.cotorra-', dir=target.parent, ignore_cleanup_errors=True)


@contextmanager
def _plain(folder: str) -> Iterator[Path]:
    """The folder, by a name that Blender and OpenImageIO take.

    On Linux and macOS names may hold backslashes and bytes that are no UTF-8, and be longer than Blender's: then a link
    leads there.
    """
    encoded = os.fsencode(folder)
    odd = '\\' in folder or encoded.decode('utf-8', 'replace') != folder or len(encoded) > PATH_BYTES_MAX
    if not odd or os.name != 'posix':
        yield Path(folder)
        return
    with tempfile.TemporaryDirectory(prefix='cotorra-') as links:
        link = Path(links) / 'folder'
        link.symlink_to(folder)
        yield link


def _take_place(new: Path, target: Path) -> None:
    with new.open('r+b') as source:
        os.fsync(source.fileno())  # some file systems tell only now that the disk is full
        if target.is_file() or not target.exists():
            try:
                if target.exists():
                    shutil.copymode(target, new)
                os.replace(new, target)
                return
            except OSError:
                pass  # it is on another file system, or another user's: it can only be written over
        with target.open('wb') as sink:
            shutil.copyfileobj(source, sink)
