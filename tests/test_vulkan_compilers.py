# SPDX-License-Identifier: GPL-3.0-or-later
"""AMD's compiler keeps every kernel in registers, and leaves out what a scene does not use. No card is needed.

What the kernels compute is tested in test_vulkan_device.py.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from cotorra import native

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
import registers


@pytest.fixture(scope='module')
def radv() -> None:
    try:
        registers.compile_for(registers.FAMILIES[0], registers.SETS['direct'])
    except RuntimeError as reason:
        if 'no RADV' not in str(reason) and 'cannot be used' not in str(reason):
            raise
        pytest.skip(str(reason))


@pytest.mark.parametrize('tracing', registers.TRACINGS)
@pytest.mark.parametrize('features', registers.SETS)
@pytest.mark.parametrize('family', registers.FAMILIES)
def test_no_register_is_spilled(radv: None, family: str, features: str, tracing: str) -> None:
    stages = registers.compile_for(family, registers.SETS[features], tracing)
    assert not registers.spilled(stages), registers.table(f'{family}, {features}, {tracing}', stages)
    assert all(0 < stage['statistics']['VGPRs'] <= 256 for stage in stages)


def test_unused_features_cost_no_instruction(radv: None) -> None:
    """A scene without a feature gets kernels without its code."""
    few, all_ = (registers.compile_for('navi31', registers.SETS[name]) for name in ('direct', 'everything'))
    for small, large in zip(few, all_, strict=True):
        assert small['stage'] == large['stage']
        assert small['statistics']['Instructions'] <= large['statistics']['Instructions']
    shade = next(i for i, stage in enumerate(few) if stage['stage'] == 'shade')
    assert few[shade]['statistics']['Instructions'] < 0.5 * all_[shade]['statistics']['Instructions']


def test_unknown_features_are_named() -> None:
    with pytest.raises(ValueError, match="no feature is called 'glitter'"):
        native.load().compile_kernels(['glitter'])
