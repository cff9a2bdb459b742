# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that hold on every device: all of their cases on the CPU, a few on Vulkan, where each session compiles kernels.

For a test without cases the fixture `device` (conftest.py) is enough.
"""

from __future__ import annotations

import cotorra_native
import pytest

# A whole build has many sets of kernels: one that lost those that count must not be skipped.
_SETS = {tuple(names) for _, names in cotorra_native.kernels()}
counts_bad_samples = pytest.mark.skipif(
    len(_SETS) == 1 and not any('numerical health' in names for names in _SETS),
    reason='this build has no kernels that count bad samples (COTORRA_FEATURE_SETS without health)',
)


def on_both(names: str, cases: list[tuple], vulkan: list[tuple]) -> pytest.MarkDecorator:
    """Parametrises a test with `device` and `names`, which take the values of each case."""
    values = [('CPU', *case) for case in cases] + [('VULKAN', *case) for case in vulkan]
    return pytest.mark.parametrize(f'device, {names}', values, indirect=['device'])
