# SPDX-License-Identifier: GPL-3.0-or-later
"""The native code, without Python, under AddressSanitizer (leaks too), UndefinedBehaviorSanitizer and ThreadSanitizer.

What is exercised is tests/native/session_test.cpp; one build of the CPU kernels, with every feature, stands for all.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from cotorra.native import embree_library

from native_build import BUILD, build_program, compiler

SOURCES = ('embree', 'scene', 'scene_bvh', 'film', 'session', 'features', 'cpu_kernels', 'cpu_kernel')
ALL_FEATURES = 511
MEMORY = ('-fsanitize=address,undefined', '-fno-sanitize-recover=all')
THREADS = ('-fsanitize=thread',)

# Embree and its TBB are not built with the sanitizer: it sees their memory, but not the atomics that order its use.
RACES_OF_OTHERS = 'race:libembree4\nrace:libtbb\n'


@pytest.fixture(scope='module')
def generated() -> Path:
    """A folder with the files that CMake would generate: the table of kernel builds, and the albedo tables."""
    maker = build_program('make_albedo_tables', ['native/tools/make_albedo_tables.cpp'])
    folder = BUILD / f'generated-{maker.name}'
    folder.mkdir(exist_ok=True)
    (folder / 'cpu_kernel_list.inc').write_text('COTORRA_KERNEL(cpu_kernel_test)\n')
    if not (folder / 'albedo_tables.h').exists():
        subprocess.run([maker, folder / 'albedo_tables.h'], check=True)
    return folder


@pytest.mark.skipif(compiler() is None, reason='no C++ compiler (on Debian: apt-get install g++)')
@pytest.mark.parametrize('sanitizers, level', [(MEMORY, 2), (THREADS, 3)], ids=['memory', 'threads'])
def test_sessions(sanitizers: tuple[str, ...], level: int, generated: Path, tmp_path: Path) -> None:
    """Level 2 traces packets of 4 rays, level 3 of 8 (x86-64-v2 and -v3)."""
    flags = ['-O1', *sanitizers, '-fno-omit-frame-pointer', f'-march=x86-64-v{level}', f'-iquote{generated}']
    flags += [f'-DCOTORRA_KERNEL_LEVEL={level}', f'-DCOTORRA_KERNEL_FEATURES={ALL_FEATURES}u']
    flags += ['-DCOTORRA_KERNEL_NAME=cpu_kernel_test', '-DCOTORRA_KERNEL_ISA="test"']
    sources = ['tests/native/session_test.cpp', *(f'native/{name}.cpp' for name in SOURCES)]
    program = build_program(f'session_test_v{level}', sources, flags)
    suppressions = tmp_path / 'suppressions'
    suppressions.write_text(RACES_OF_OTHERS)
    environment = {name: value for name, value in os.environ.items() if name != 'COTORRA_ISA'}
    environment['TSAN_OPTIONS'] = f'suppressions={suppressions}'
    result = subprocess.run([program, embree_library()], env=environment, capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stdout + result.stderr
