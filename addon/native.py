# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the native module and the Embree library that it opens.

Nothing is downloaded or built here; what is missing is named in the error.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from ctypes.util import find_library
from pathlib import Path
from types import ModuleType

# Where the tools that make wheels put a library that the wheel carries, seen from the folder that holds `embreex/`.
WHEEL_PATTERNS = {
    'linux': ('embreex.libs/libembree4*.so*',),
    'win32': ('embreex.libs/embree4*.dll', 'embreex/embree4*.dll'),
    'darwin': ('embreex/.dylibs/libembree4*.dylib', 'embreex.dylibs/libembree4*.dylib'),
}


class NativeError(RuntimeError):
    """The native module or Embree cannot be used; the text says what is missing."""


# Blender loads no native module twice. After an upgrade in a running session it would go on with the old one.
RESTART = 'The engine was updated while Blender was running, which holds parts of the old version: restart Blender'


def load() -> ModuleType:
    """The module `cotorra_native`, if it is the one that is installed."""
    known = sys.modules.get('cotorra_native')
    try:
        module = importlib.import_module('cotorra_native')
    except ImportError as error:
        version = f'{sys.version_info.major}.{sys.version_info.minor}'
        raise NativeError(
            f'The native module cotorra_native cannot be loaded ({error}). '
            f'It must be built for Python {version} on {sys.platform}: '
            'install the Cotorra extension for this platform, or run ./scripts/setup in its sources'
        ) from error
    if not hasattr(module, 'cotorra_file'):
        # In an extension nobody else loads it: what is there without a mark is of an earlier version, which set none.
        stale = known is not None and __package__.startswith('bl_ext.')
        module.cotorra_file = () if stale else file_identity(module.__file__)
    if restart_needed():
        raise NativeError(RESTART)
    return module


def restart_needed() -> bool:
    """Whether the native module in memory is another than the installed one. Before the first use there is none."""
    module = sys.modules.get('cotorra_native')
    loaded = getattr(module, 'cotorra_file', None)
    return loaded is not None and loaded != file_identity(module.__file__)


def file_identity(path: str) -> tuple[int, ...]:
    """What tells a file from one that replaced it; empty where there is none."""
    try:
        found = os.stat(path)
    except OSError:
        return ()
    return found.st_ino, found.st_size, found.st_mtime_ns


def embree_library() -> str:
    """Path or name of the Embree 4 library: the embreex wheel's, then $COTORRA_EMBREE, then the system's."""
    looked = []
    spec = importlib.util.find_spec('embreex')
    if spec is not None and spec.origin is not None:
        folder = Path(spec.origin).parent.parent
        found = embree_in_wheel(folder, sys.platform)
        if found is not None:
            if sys.platform == 'win32':
                os.add_dll_directory(str(found.parent))  # Embree's own neighbour, TBB, lies there too
            return str(found)
        looked.append(f'the embreex package in {folder} carries no Embree')
    else:
        looked.append('the Python package embreex is not installed')

    path = os.environ.get('COTORRA_EMBREE', '')
    if path:
        if Path(path).is_file():
            return path
        looked.append(f'COTORRA_EMBREE names {path}, which is not a file')
    else:
        looked.append('COTORRA_EMBREE is not set')

    name = find_library('embree4')
    if name is not None:
        return name
    looked.append('the system has no library embree4')
    raise NativeError(f'Embree 4 was not found: {"; ".join(looked)}')


def cache_folder() -> Path:
    """Where compiled kernels of graphics cards are kept; it may be deleted at any time."""
    home = Path.home()
    if sys.platform == 'win32':
        base = Path(os.environ.get('LOCALAPPDATA') or home / 'AppData' / 'Local')
    elif sys.platform == 'darwin':
        base = home / 'Library' / 'Caches'
    else:
        base = Path(os.environ.get('XDG_CACHE_HOME') or home / '.cache')
    return base / 'cotorra'


def embree_in_wheel(folder: Path, platform: str) -> Path | None:
    """The Embree library of the embreex wheel installed in `folder`, or None."""
    for pattern in WHEEL_PATTERNS.get(platform, ()):
        for path in sorted(folder.glob(pattern)):
            return path
    return None
