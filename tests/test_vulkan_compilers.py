# SPDX-License-Identifier: GPL-3.0-or-later
"""AMD's compiler keeps every kernel in registers, and leaves out what a scene does not use. No card is needed.

What the kernels compute is tested in test_vulkan_device.py.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from cotorra import native

import kernel_source as kernels
from native_build import BUILD

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
import registers

STAGES = sorted(path.stem for path in kernels.STAGES.glob('*.comp'))


@pytest.mark.parametrize('query', [False, True], ids=['software', 'ray query'])
@pytest.mark.parametrize('stage', STAGES)
def test_stages_trace_at_one_place_or_none(stage: str, query: bool) -> None:
    """Drivers inline all calls: each more would be another traversal to compile and to keep in registers."""
    target = BUILD / 'spirv' / f'wave_{stage}{"-query" * query}.spv'
    target.parent.mkdir(parents=True, exist_ok=True)
    options = ('-V', '--target-env', 'vulkan1.2', *(['-DRAY_QUERY'] * query), f'-I{kernels.KERNELS}')
    kernels.run_tool('glslang', *options, '-o', str(target), str(kernels.STAGES / f'{stage}.comp'))
    kernels.run_tool('spirv-val', '--target-env', 'vulkan1.2', '--scalar-block-layout', str(target))
    listing = kernels.run_tool('spirv-dis', '--raw-id', str(target))
    tracing = re.findall(r'OpName (%\d+) "trace\(', listing)
    calls = sum(len(re.findall(rf'OpFunctionCall %\d+ {name}\b', listing)) for name in tracing)
    assert calls == (1 if stage in ('trace', 'shade', 'shadow') else 0)
    assert listing.count('OpRayQueryInitializeKHR') == (calls if query else 0)


@pytest.fixture(scope='module')
def radv() -> None:
    try:
        registers.compile_for(registers.FAMILIES[0], registers.SETS['direct'])
    except RuntimeError as reason:
        if 'no RADV' not in str(reason) and 'cannot be used' not in str(reason):
            raise
        pytest.skip(str(reason))


@pytest.mark.every(3)
@pytest.mark.parametrize('tracing', registers.TRACINGS)
@pytest.mark.parametrize('features', [name for name in registers.SETS if name != 'programs'])
@pytest.mark.parametrize('family', registers.FAMILIES)
def test_no_register_is_spilled(radv: None, family: str, features: str, tracing: str) -> None:
    stages = registers.compile_for(family, registers.SETS[features], tracing)
    assert not registers.spilled(stages), registers.table(f'{family}, {features}, {tracing}', stages)
    assert all(0 < stage['statistics']['VGPRs'] <= 256 for stage in stages)


@pytest.mark.long  # a minute of the compiler's; ./scripts/registers prints the same
def test_programs_need_memory_only_where_they_run(radv: None) -> None:
    """Their registers are numbered at run time, which no card's registers are: they lie in memory."""
    stages = registers.compile_for('navi31', registers.SETS['programs'])
    assert set(registers.spilled(stages)) <= {'trace', 'shade', 'light', 'shadow'}


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
