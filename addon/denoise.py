# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the noise out of a picture with Intel's OpenImageDenoise, the library that Blender itself carries.

It finds the library, opens it through the few functions of its C interface that are declared here, and works on arrays;
which picture, and when, is told by the final render. Nothing is downloaded: where there is no library, the error says
where one was looked for.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable
from ctypes.util import find_library
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import bpy
import numpy as np

# File names by platform, seen from the folder that Blender is in. Its module `bpy` is laid out as the program is.
LIBRARY_PATTERNS = {
    'linux': ('lib/libOpenImageDenoise.so.2*',),
    'win32': ('blender.shared/OpenImageDenoise.dll', 'OpenImageDenoise.dll'),
    'darwin': ('lib/libOpenImageDenoise.2*.dylib',),
}

# Values of the published enumerations (version 2).
DEVICE_CPU = 1
FORMAT_FLOAT3 = 3
ERROR_CANCELLED = 6
QUALITIES = {'FAST': 4, 'BALANCED': 5, 'HIGH': 6}
FAST_SINCE = 20300  # before version 2.3.0 there are the other two only

PROGRESS = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.c_double)

# Results and arguments of the functions in use.
_HANDLE, _NAME, _SIZE = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t
_IMAGE = (_HANDLE, _NAME, ctypes.c_void_p, ctypes.c_int, _SIZE, _SIZE, _SIZE, _SIZE, _SIZE)
FUNCTIONS = {
    'oidnNewDevice': (_HANDLE, (ctypes.c_int,)),
    'oidnReleaseDevice': (None, (_HANDLE,)),
    'oidnSetDeviceInt': (None, (_HANDLE, _NAME, ctypes.c_int)),
    'oidnSetDeviceBool': (None, (_HANDLE, _NAME, ctypes.c_bool)),
    'oidnGetDeviceInt': (ctypes.c_int, (_HANDLE, _NAME)),
    'oidnCommitDevice': (None, (_HANDLE,)),
    'oidnGetDeviceError': (ctypes.c_int, (_HANDLE, ctypes.POINTER(ctypes.c_char_p))),
    'oidnNewFilter': (_HANDLE, (_HANDLE, _NAME)),
    'oidnReleaseFilter': (None, (_HANDLE,)),
    'oidnSetSharedFilterImage': (None, _IMAGE),
    'oidnSetFilterBool': (None, (_HANDLE, _NAME, ctypes.c_bool)),
    'oidnSetFilterInt': (None, (_HANDLE, _NAME, ctypes.c_int)),
    'oidnSetFilterProgressMonitorFunction': (None, (_HANDLE, PROGRESS, ctypes.c_void_p)),
    'oidnCommitFilter': (None, (_HANDLE,)),
    'oidnExecuteFilter': (None, (_HANDLE,)),
}


class DenoiseError(RuntimeError):
    """The picture cannot be denoised; the text says why."""


@dataclass(frozen=True, slots=True)
class Denoising:
    """How a picture is denoised, in the words of Cycles' settings.

    inputs:    RGB, RGB_ALBEDO or RGB_ALBEDO_NORMAL.
    prefilter: ACCURATE: albedo and normal are denoised first; FAST: with the picture; NONE: they count as clean.
    quality:   FAST, BALANCED or HIGH.
    threads:   0: all.
    """

    inputs: str = 'RGB_ALBEDO_NORMAL'
    prefilter: str = 'ACCURATE'
    quality: str = 'HIGH'
    threads: int = 0

    def features(self) -> tuple[str, ...]:
        """The native passes that it asks for beside the picture."""
        return {
            'RGB': (),
            'RGB_ALBEDO': ('denoising_albedo',),
            'RGB_ALBEDO_NORMAL': ('denoising_albedo', 'denoising_normal'),
        }[self.inputs]


def denoised(
    color: np.ndarray,
    features: dict[str, np.ndarray],
    settings: Denoising,
    should_cancel: Callable[[], bool] = lambda: False,
) -> np.ndarray | None:
    """The picture without noise, a new array (height, width, 3); None where `should_cancel` stopped it.

    color: scene-linear. features: by native pass, those of settings.features(). All are (height, width, 3) float32.
    The interpreter is free meanwhile: call it on a thread of its own where others shall go on.
    """
    with _Device(settings.threads) as device:
        quality = settings.quality
        if quality == 'FAST' and device.version < FAST_SINCE:
            quality = 'BALANCED'
        images = {name.removeprefix('denoising_'): features[name] for name in settings.features()}
        clean = settings.prefilter == 'NONE'
        if settings.prefilter == 'ACCURATE':
            for name, image in images.items():
                filtered = device.run({name: image}, quality, should_cancel)
                if filtered is None:
                    return None
                images[name] = filtered
            clean = True
        flags = {'hdr': True, 'cleanAux': clean and bool(images)}
        return device.run({'color': color, **images}, quality, should_cancel, flags)


class _Device:
    """The processor as OpenImageDenoise has it, with the threads of its own."""

    def __init__(self, threads: int) -> None:
        self._library = open_library()
        self._handle = self._library.oidnNewDevice(DEVICE_CPU)
        if not self._handle:
            raise DenoiseError(f'OpenImageDenoise cannot use this processor: {self._error(None)[1]}')
        self._library.oidnSetDeviceInt(self._handle, b'numThreads', threads)
        self._library.oidnSetDeviceBool(self._handle, b'setAffinity', False)  # these threads are not its own
        self._library.oidnCommitDevice(self._handle)
        self.version = self._library.oidnGetDeviceInt(self._handle, b'version')
        if self.version // 10000 != 2:
            self.__exit__()
            raise DenoiseError(f'OpenImageDenoise {_version(self.version)} is none of version 2')

    def __enter__(self) -> _Device:
        return self

    def __exit__(self, *_: object) -> None:
        self._library.oidnReleaseDevice(self._handle)

    def run(
        self,
        images: dict[str, np.ndarray],
        quality: str,
        should_cancel: Callable[[], bool],
        flags: dict[str, bool] | None = None,
    ) -> np.ndarray | None:
        """What the filter for ray tracing makes of these images, by their names there; None where it was stopped."""
        first = next(iter(images.values()))
        height, width = first.shape[:2]
        out = np.empty((height, width, 3), np.float32)
        bound = {name: np.ascontiguousarray(image, np.float32) for name, image in images.items()} | {'output': out}
        library, handle = self._library, self._library.oidnNewFilter(self._handle, b'RT')
        # Held until the filter is gone.
        monitor = PROGRESS(lambda _data, _done: not should_cancel())
        try:
            for name, image in bound.items():
                assert image.shape == out.shape, (name, image.shape)
                library.oidnSetSharedFilterImage(
                    handle, name.encode(), image.ctypes.data, FORMAT_FLOAT3, width, height, 0, 0, 0
                )
            for name, value in (flags or {}).items():
                library.oidnSetFilterBool(handle, name.encode(), value)
            library.oidnSetFilterInt(handle, b'quality', QUALITIES[quality])
            library.oidnSetFilterProgressMonitorFunction(handle, monitor, None)
            library.oidnCommitFilter(handle)
            library.oidnExecuteFilter(handle)
            code, text = self._error(self._handle)
        finally:
            library.oidnReleaseFilter(handle)
        if code == ERROR_CANCELLED:
            return None
        if code != 0:
            raise DenoiseError(f'OpenImageDenoise: {text}')
        return out

    def _error(self, handle: int | None) -> tuple[int, str]:
        text = ctypes.c_char_p()
        code = self._library.oidnGetDeviceError(handle, ctypes.byref(text))
        return code, (text.value or b'').decode('utf-8', 'replace')


def _version(number: int) -> str:
    return f'{number // 10000}.{number // 100 % 100}.{number % 100}'


def candidates() -> list[str]:
    """Paths and names under which a library may be: Blender's own, then $COTORRA_OIDN, then the system's."""
    folders = [Path(bpy.utils.resource_path('LOCAL')).parent, Path(bpy.app.binary_path or sys.executable).parent]
    found = [
        str(path)
        for folder in dict.fromkeys(folders)
        for pattern in LIBRARY_PATTERNS.get(sys.platform, ())
        for path in sorted(folder.glob(pattern))
    ]
    chosen = os.environ.get('COTORRA_OIDN', '')
    system = find_library('OpenImageDenoise')
    return found + ([chosen] if chosen else []) + ([system] if system else [])


@cache
def open_library() -> ctypes.CDLL:
    """OpenImageDenoise with its functions declared. Raises DenoiseError, which is not remembered."""
    tried = []
    for path in candidates():
        try:
            library = ctypes.CDLL(path)
            for name, (result, arguments) in FUNCTIONS.items():
                function = getattr(library, name)
                function.restype, function.argtypes = result, arguments
        except (OSError, AttributeError) as error:
            tried.append(f'{path}: {error}')
            continue
        return library
    raise DenoiseError(
        'OpenImageDenoise was not found: '
        + ('; '.join(tried) if tried else 'this Blender carries none, COTORRA_OIDN is not set, and the system has none')
    )
