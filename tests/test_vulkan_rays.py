# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that trace rays, on the Vulkan device beside the CPU's: occlusion, bevel, ray cast, in both trace builds.

What the nodes show is compared with Cycles in test_nodes_with_rays.py.
"""

from __future__ import annotations

from types import ModuleType

import bpy
import pytest

from test_nodes_with_rays import SURFACES, scene_of
from vulkan_jobs import compare, job_of

pytestmark = pytest.mark.usefixtures('engine')

NAMES = (
    'occlusion',
    'occlusion, inside, only local',
    'occlusion lets through',
    'bevel of diffuse',
    'bevel of a mirror',
    'raycast, distance',
    'raycast, normal',
    'raycast as a height',
)


@pytest.mark.every(3)
@pytest.mark.parametrize('name', NAMES)
def test_rays_of_programs_are_the_same(name: str, module: ModuleType, tracing: str) -> None:
    if name not in SURFACES:
        pytest.skip(f'{bpy.app.version_string} has no such node')
    job = job_of(module, scene_of(SURFACES[name]), integrator='PATH', max_bounces=2, ray_tracing=tracing)
    cpu, gpu = (job.render(device)[0]['combined'] for device in ('CPU', 'VULKAN'))
    compare(cpu, gpu, job.fragile('combined'), name)
