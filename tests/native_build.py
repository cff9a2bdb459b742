# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles small C++ libraries and programs for tests, with warnings as errors, and keeps them by content.

It is not how the native module is built: that is CMakeLists.txt's.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / 'build' / 'tests'

WARNINGS = ('-Wall', '-Wextra', '-Wconversion', '-Wdouble-promotion', '-Werror')
# Contraction to fused multiply-add would give the CPU other bits than the order of operations that a kernel states.
FLAGS = ('-std=c++20', '-O2', '-g', '-ffp-contract=off', *WARNINGS)
# For includes in quotes only: kernels/math.h must not stand in for the C library's.
FOLDERS = tuple(ROOT / folder for folder in ('kernels', 'native', 'tests/native'))
INCLUDES = tuple(f'-iquote{folder}' for folder in FOLDERS)

_INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


def compiler() -> list[str] | None:
    """The command of the C++ compiler ($CXX, else g++, else c++), or None where there is none."""
    for candidate in (os.environ.get('CXX', ''), 'g++', 'c++'):
        command = shlex.split(candidate)
        if command and shutil.which(command[0]):
            return command
    return None


def has_header(name: str) -> bool:
    """Whether the compiler finds a header of the system."""
    command = compiler()
    if command is None:
        return False
    tried = subprocess.run(
        [*command, '-E', '-x', 'c++', '-'], input=f'#include <{name}>', text=True, capture_output=True
    )
    return tried.returncode == 0


def included(source: Path, seen: dict[Path, bytes] | None = None) -> dict[Path, bytes]:
    """The file and every project header that it includes with quotes, with their contents."""
    seen = {} if seen is None else seen
    source = source.resolve()
    if source in seen:
        return seen
    seen[source] = source.read_bytes()
    for name in _INCLUDE.findall(seen[source].decode()):
        for folder in (source.parent, *FOLDERS):
            if (folder / name).is_file():
                included(folder / name, seen)
                break
    return seen


def _cached(stem: str, suffix: str, key: object, make: list[str], what: str) -> Path:
    """The file of this stem that `make` makes; the key, and nothing else, tells whether it has to be made again."""
    target = BUILD / f'{stem}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}{suffix}'
    if target.exists():
        return target
    target.parent.mkdir(parents=True, exist_ok=True)
    for stale in target.parent.glob(f'{target.name[: -17 - len(suffix)]}-{"[0-9a-f]" * 16}{suffix}'):
        stale.unlink(missing_ok=True)
    # Under another name first: a compilation that is stopped, or two at once, must not leave half a file to be found.
    partial = target.with_name(f'{target.name}.{os.getpid()}')
    result = subprocess.run([*make, '-o', str(partial)], capture_output=True, text=True)
    assert result.returncode == 0, f'{what} does not compile:\n{result.stderr[:4000]}'
    partial.replace(target)
    return target


def build_objects(name: str, sources: Iterable[Path | str], flags: Sequence[str]) -> list[Path]:
    """Compiles the sources (paths from the project's root), for libraries and programs that share them."""
    command = compiler()
    assert command is not None, 'no C++ compiler: install g++, or name one in CXX'
    flags = (*FLAGS, *INCLUDES, *flags)

    def compile_object(source: Path) -> Path:
        key = (command, flags, sorted((str(path), content) for path, content in included(source).items()))
        return _cached(f'{name}.o/{source.stem}', '.o', key, [*command, *flags, '-c', str(source)], source.name)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(compile_object, (ROOT / source for source in sources)))


def _link(name: str, suffix: str, objects: Iterable[Path], flags: Sequence[str]) -> Path:
    command, objects = compiler(), [str(path) for path in objects]
    flags = (*FLAGS, *flags)
    return _cached(name, suffix, (command, flags, objects), [*command, *objects, *flags, '-ldl', '-pthread'], name)


def build_module(
    name: str, sources: Iterable[Path | str], flags: Sequence[str] = (), objects: Iterable[Path] = ()
) -> Path:
    """Compiles the sources to a shared library, with objects that are there (made with -fPIC), and returns its path."""
    flags = ('-shared', '-fPIC', *flags)
    return _link(name, '.so', [*build_objects(name, sources, flags), *objects], flags)


def build(name: str, sources: Iterable[Path | str], flags: Sequence[str] = ()) -> ctypes.CDLL:
    """Compiles the sources to a shared library and opens it."""
    return ctypes.CDLL(str(build_module(name, sources, flags)))


def build_program(
    name: str, sources: Iterable[Path | str], flags: Sequence[str] = (), objects: Iterable[Path] = ()
) -> Path:
    """Compiles the sources to a program, with objects that are there, and returns its path."""
    return _link(name, '', [*build_objects(name, sources, flags), *objects], flags)
