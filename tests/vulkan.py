# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs compute shaders on lavapipe, Mesa's Vulkan on the CPU, through tests/native/vulkan_runner.cpp.

It selects lavapipe and nothing else: a graphics card's own rounding is not what these tests compare with.
"""

from __future__ import annotations

import ctypes
import os
import weakref
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numpy as np

from native_build import build

_DRIVER = ('VK_DRIVER_FILES', 'VK_ICD_FILENAMES')
# lavapipe takes longer to optimise a stage than to run it for the few pixels of a test.
_UNOPTIMIZED = {'GALLIVM_PERF': 'nopt'}


def lavapipe_driver() -> Path | None:
    """The file by which the Vulkan loader knows lavapipe, or None where Mesa's Vulkan drivers are not installed.

    That which VK_DRIVER_FILES names (scripts/mesa) comes before the system's.
    """
    for name in os.environ.get('VK_DRIVER_FILES', '').split(':'):
        if Path(name).name.startswith('lvp') and Path(name).exists():
            return Path(name)
    folders = [Path(folder) for folder in os.environ.get('XDG_DATA_DIRS', '').split(':') if folder]
    for folder in (*folders, Path('/usr/local/share'), Path('/usr/share'), Path('/etc')):
        for path in sorted((folder / 'vulkan' / 'icd.d').glob('lvp_icd*.json')):
            return path
    return None


@contextmanager
def only(driver: Path) -> Iterator[None]:
    """The loader reads these variables when the instance is made; older loaders know the second name only."""
    wanted = dict.fromkeys(_DRIVER, str(driver)) | _UNOPTIMIZED
    saved = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in saved.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@cache
def _library() -> ctypes.CDLL:
    library = build('vulkan_runner', ['tests/native/vulkan_runner.cpp'])
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    signatures = {
        'runner_error': (ctypes.c_char_p,),
        'runner_open': (pointer, ctypes.c_char_p, ctypes.c_int),
        'runner_close': (None, pointer),
        'runner_device_name': (ctypes.c_char_p, pointer),
        'runner_validates': (ctypes.c_int, pointer),
        'runner_buffer': (pointer, pointer, size),
        'runner_buffer_free': (None, pointer),
        'runner_buffer_data': (pointer, pointer),
        'runner_buffer_address': (ctypes.c_uint64, pointer),
        'runner_run': (ctypes.c_int, pointer, pointer, size, pointer, size, pointer, size, ctypes.c_uint32),
    }
    for name, (result, *arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


class VulkanError(RuntimeError):
    """A Vulkan call failed, or the validation layer had something to say."""


class Buffer:
    """Device memory that the host sees: `data` is a writable array of bytes, `address` what a shader reads it by."""

    def __init__(self, runner: Runner, size: int) -> None:
        library = _library()
        handle = library.runner_buffer(runner.handle, max(size, 16))
        if not handle:
            raise VulkanError(library.runner_error().decode())
        self.address: int = library.runner_buffer_address(handle)
        self.data = np.ctypeslib.as_array((ctypes.c_uint8 * size).from_address(library.runner_buffer_data(handle)))
        # The runner is named so that it outlives the buffer.
        self.release = weakref.finalize(self, lambda _runner: library.runner_buffer_free(handle), runner)


class Runner:
    """One Vulkan device and its queue."""

    def __init__(self, driver: Path, loader: str = 'libvulkan.so.1', validate: bool = True) -> None:
        library = _library()
        with only(driver):
            self.handle = library.runner_open(loader.encode(), int(validate))
        if not self.handle:
            raise VulkanError(library.runner_error().decode())
        self.name: str = library.runner_device_name(self.handle).decode()
        self.validates = bool(library.runner_validates(self.handle))
        weakref.finalize(self, library.runner_close, self.handle)

    def upload(self, array: np.ndarray) -> Buffer:
        """A buffer with a copy of the array's bytes."""
        buffer = Buffer(self, array.nbytes)
        buffer.data[:] = np.ascontiguousarray(array).reshape(-1).view(np.uint8)
        return buffer

    def run(
        self,
        name: str,
        code: np.ndarray,
        addresses: Sequence[int],
        count: int,
        constants: dict[int, int] | None = None,
    ) -> None:
        """Runs a shader over `count` work items in groups of 64; push constants are the addresses, then the count.

        code:      the words of its SPIR-V module.
        constants: values of its specialization constants by their number.

        Raises VulkanError with the name.
        """
        push = np.concatenate([np.array([*addresses, count], np.uint64)])
        values = np.array(list((constants or {}).items()), np.uint32).reshape(-1, 2)
        library = _library()
        if not library.runner_run(
            self.handle,
            code.ctypes.data,
            code.size,
            values.ctypes.data,
            len(values),
            push.ctypes.data,
            push.nbytes,
            -(-count // 64),
        ):
            raise VulkanError(f'{name}: {library.runner_error().decode()}')


@cache
def open_lavapipe() -> Runner | str:
    """The lavapipe device, or why there is none."""
    driver = lavapipe_driver()
    if driver is None:
        return 'lavapipe is not installed (on Debian: apt-get install mesa-vulkan-drivers)'
    try:
        return Runner(driver)
    except VulkanError as error:
        return f'lavapipe cannot be opened: {error}'
