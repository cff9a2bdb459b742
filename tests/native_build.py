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
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / 'build' / 'tests'

WARNINGS = ('-Wall', '-Wextra', '-Wconversion', '-Wdouble-promotion', '-Werror')
# Contraction to fused multiply-add would give the CPU other bits than the order of operations that a kernel states.
FLAGS = ('-std=c++20', '-O2', '-g', '-ffp-contract=off', *WARNINGS)
SANITIZERS = ('-fsanitize=address,undefined', '-fno-sanitize-recover=all', '-fno-omit-frame-pointer')
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


def _compile(name: str, suffix: str, sources: Iterable[Path | str], flags: Sequence[str]) -> Path:
    command = compiler()
    assert command is not None, 'no C++ compiler: install g++, or name one in CXX'
    paths = [Path(source) if Path(source).is_absolute() else ROOT / source for source in sources]
    digest = hashlib.sha256(repr((command, flags)).encode())
    contents = {path: content for source in paths for path, content in included(source).items()}
    for path in sorted(contents):
        digest.update(str(path).encode() + b'\0' + contents[path])
    target = BUILD / f'{name}-{digest.hexdigest()[:16]}{suffix}'
    if target.exists():
        return target
    BUILD.mkdir(parents=True, exist_ok=True)
    for stale in BUILD.glob(f'{name}-{"[0-9a-f]" * 16}{suffix}'):
        stale.unlink(missing_ok=True)
    # Under another name first: a compilation that is stopped, or two at once, must not leave half a file to be found.
    partial = target.with_name(f'{target.name}.{os.getpid()}')
    result = subprocess.run(
        [*command, *flags, *map(str, paths), '-o', str(partial), '-ldl', '-pthread'], capture_output=True, text=True
    )
    assert result.returncode == 0, f'{name} does not compile:\n{result.stderr[:4000]}'
    partial.replace(target)
    return target


def build(name: str, sources: Iterable[Path | str], flags: Sequence[str] = ()) -> ctypes.CDLL:
    """Compiles the sources (paths from the project's root) to a shared library and opens it."""
    return ctypes.CDLL(str(_compile(name, '.so', sources, (*FLAGS, *INCLUDES, '-shared', '-fPIC', *flags))))


def build_program(name: str, sources: Iterable[Path | str], flags: Sequence[str] = ()) -> Path:
    """Compiles the sources to a program and returns its path; pass `SANITIZERS` for a build that checks itself."""
    return _compile(name, '', sources, (*FLAGS, *INCLUDES, *flags))
