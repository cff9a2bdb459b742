# SPDX-License-Identifier: GPL-3.0-or-later
"""Each build of the CPU kernels that this processor runs shows the same picture, but for rounding.

What the picture must be is told elsewhere, by tests that run the newest of them.
"""

from __future__ import annotations

from typing import Any

import pytest
from cotorra import demos, native

from scenes.rich import rich_scene
from vulkan_jobs import ROUNDING, compare, job_of

# The newer ones fuse multiplication and addition; highlights of models are many times as bright as the mean.
ALLOWED = 3.0 * ROUNDING

SCENES: dict[str, Any] = {
    'lambert': lambda: demos.build('three_lights'),
    'path': lambda: demos.build('material_grid'),
    'models': lambda: demos.build('model_pair'),
    'everything': lambda: rich_scene(3),
}


@pytest.mark.parametrize('name', SCENES)
def test_instruction_sets_agree(name: str, engine: None, monkeypatch: pytest.MonkeyPatch) -> None:
    integrator = 'DIRECT' if name == 'lambert' else 'PATH'
    job = job_of(native.load(), SCENES[name](), integrator=integrator, passes=('combined',))
    pictures = {}
    for level in '234':
        monkeypatch.setenv('COTORRA_ISA', level)  # the highest that is used
        passes, stats = job.render('CPU')
        pictures[stats['isa']] = passes['combined']
    if len(pictures) < 2:
        pytest.skip(f'there is one alone: {", ".join(pictures)}')
    (_, wanted), *others = pictures.items()
    for isa, found in others:
        compare(wanted, found, job.fragile('combined'), isa, ALLOWED)
