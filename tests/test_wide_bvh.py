# SPDX-License-Identifier: GPL-3.0-or-later
"""The BVH of graphics cards, built and traversed on the CPU, against brute force (tests/native/wide_bvh_test.cpp).

On Vulkan it is traversed in tests/test_vulkan_device.py.
"""

from __future__ import annotations

import subprocess

import pytest

from native_build import build_program, compiler


@pytest.mark.skipif(compiler() is None, reason='no C++ compiler (on Debian: apt-get install g++)')
def test_rays_meet_what_brute_force_finds() -> None:
    program = build_program(
        'wide_bvh_test', ['tests/native/wide_bvh_test.cpp', 'native/wide_bvh.cpp', 'native/binary_tree.cpp']
    )
    result = subprocess.run([program], capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stdout + result.stderr
