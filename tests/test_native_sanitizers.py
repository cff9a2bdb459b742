# SPDX-License-Identifier: GPL-3.0-or-later
"""The native code under AddressSanitizer, UndefinedBehaviorSanitizer and ThreadSanitizer.

What is exercised stands in tests/native/session_test.cpp, without Python (and with leaks), and in module_border.py. One
build of the CPU kernels, with every feature, stands for all.
"""

from __future__ import annotations

import functools
import operator
import os
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

import nanobind
import pytest
from cotorra.native import embree_library

import kernel_source as kernels
from native_build import BUILD, ROOT, build_module, build_objects, build_program, compiler

# Without the Vulkan device, whose kernels CMake compiles; device_no_vulkan.cpp stands in for it.
VULKAN = re.compile(r'vulkan_\w+|device_vulkan|wide_bvh|binary_tree')
SOURCES = sorted(path for path in (ROOT / 'native').glob('*.cpp') if not VULKAN.fullmatch(path.stem))
PYTHON = [
    path for path in SOURCES if '#include <nanobind' in path.read_text() or '"python_arrays.h"' in path.read_text()
]
NATIVE = [path for path in SOURCES if path not in PYTHON]
ALL_FEATURES = functools.reduce(operator.or_, (v for k, v in kernels.constants().items() if k.startswith('FEATURE_')))
ALONE = {'cpu_kernel', 'cpu_kernels', 'cpu_program', 'cpu_textures', 'device_no_vulkan'}  # defined by macros
GROUPS = 6
MEMORY = ('-fsanitize=address,undefined,float-cast-overflow', '-fno-sanitize-recover=all')
THREADS = ('-fsanitize=thread',)

# Embree and its TBB are not built with the sanitizer: it sees their memory, but not the atomics that order its use.
RACES_OF_OTHERS = 'race:libembree4\nrace:libtbb\n'

pytestmark = pytest.mark.early
needs_compiler = pytest.mark.skipif(compiler() is None, reason='no C++ compiler (on Debian: apt-get install g++)')


# GCC 12's LeakSanitizer stops all threads from a tracer process, which crashes now and then while a thread of TBB's is
# ending: it says so in these words, after the program has ended well. Nothing was found or ruled out: run it again.
TRACER_CRASHED = 'LeakSanitizer has encountered a fatal error'
TRIES = 4


def run(command: list[str | Path], **environment: str) -> str:
    """Runs a program to its good end and returns what it printed."""
    inherited = {name: value for name, value in os.environ.items() if name != 'COTORRA_ISA'}
    for _ in range(TRIES):
        result = subprocess.run(command, env=inherited | environment, capture_output=True, text=True, timeout=600)
        if TRACER_CRASHED not in result.stderr:
            break
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope='module')
def generated() -> Path:
    """A folder with the files that CMake would generate: the table of kernel builds, and the albedo tables."""
    maker = build_program('make_albedo_tables', ['native/tools/make_albedo_tables.cpp'])
    folder = BUILD / f'generated-{maker.name}'
    folder.mkdir(exist_ok=True)
    (folder / 'cpu_kernel_list.inc').write_text(
        'COTORRA_KERNEL(cpu_kernel_test)\nCOTORRA_PROGRAM(COTORRA_PROGRAM_NAME, 2u)\n'
    )
    if not (folder / 'albedo_tables.h').exists():
        subprocess.run([maker, folder / 'albedo_tables.h'], check=True)
    return folder


def kernel_flags(level: int, generated: Path, sanitizers: tuple[str, ...]) -> list[str]:
    """Flags for one build of the kernels. Level 2 traces packets of 4 rays, level 3 of 8 (x86-64-v2 and -v3).

    Nothing is optimised: what is rendered is small, and the compiler takes a third of the time.
    """
    flags = ['-O0', '-g1', *sanitizers, '-fno-omit-frame-pointer', f'-march=x86-64-v{level}', f'-iquote{generated}']
    flags += [f'-DCOTORRA_KERNEL_LEVEL={level}', f'-DCOTORRA_KERNEL_FEATURES={ALL_FEATURES}u']
    return [
        *flags,
        '-DCOTORRA_KERNEL_NAME=cpu_kernel_test',
        '-DCOTORRA_PROGRAM_NAME=cpu_program_test',
        '-DCOTORRA_KERNEL_ISA="test"',
    ]


def native_objects(level: int, generated: Path, sanitizers: tuple[str, ...]) -> list[Path]:
    """What knows no Python; the program and the module under the same sanitizers share it."""
    sources = [path for path in NATIVE if path.stem in ALONE] + together(
        [path for path in NATIVE if path.stem not in ALONE]
    )
    return build_objects(f'native_v{level}', sources, ('-fPIC', *kernel_flags(level, generated, sanitizers)))


def together(sources: list[Path]) -> list[Path]:
    """Files that include several of them each: most of the compiler's time are headers that all share."""
    folder = BUILD / 'together'
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for index in range(GROUPS):
        text = ''.join(f'#include "{path}"\n' for path in sources[index::GROUPS])
        made.append(folder / f'group_{index}.cpp')
        if not made[-1].exists() or made[-1].read_text() != text:
            made[-1].write_text(text)
    return made


@needs_compiler
@pytest.mark.parametrize('sanitizers, level', [(MEMORY, 2), (THREADS, 3)], ids=['memory', 'threads'])
def test_sessions(sanitizers: tuple[str, ...], level: int, generated: Path, tmp_path: Path) -> None:
    objects = native_objects(level, generated, sanitizers)
    flags = kernel_flags(level, generated, sanitizers)
    program = build_program(f'session_test_v{level}', ['tests/native/session_test.cpp'], flags, objects)
    suppressions = tmp_path / 'suppressions'
    suppressions.write_text(RACES_OF_OTHERS)
    run([program, embree_library()], TSAN_OPTIONS=f'suppressions={suppressions}')


@needs_compiler
def test_module(generated: Path) -> None:
    """The module's border with Python; leaks are not looked for, because the interpreter's own are many."""
    # nanobind's sources are not ours to warn about: the compiler sees them as a system's header.
    library = generated / 'nanobind_library.cpp'
    library.write_text('#include <nb_combined.cpp>\n')
    package = Path(nanobind.include_dir()).parent
    folders = (package / 'include', package / 'src', package / 'ext/robin_map/include', sysconfig.get_path('include'))
    flags = [*kernel_flags(2, generated, MEMORY), *(f'-isystem{path}' for path in folders)]
    flags += ['-DCOTORRA_VERSION="test"', '-fvisibility=hidden', '-fno-strict-aliasing']
    objects = native_objects(2, generated, MEMORY)
    built = build_module('cotorra_native', [*PYTHON, library], flags, objects)
    command = [sys.executable, ROOT / 'tests' / 'module_border.py', built, embree_library()]
    runtime = subprocess.run([*compiler(), '-print-file-name=libasan.so'], capture_output=True, text=True, check=True)
    standard = subprocess.run(
        [*compiler(), '-print-file-name=libstdc++.so'], capture_output=True, text=True, check=True
    )
    preload = f'{runtime.stdout.strip()} {standard.stdout.strip()}'
    assert 'the border holds' in run(command, LD_PRELOAD=preload, ASAN_OPTIONS='detect_leaks=0')
