# SPDX-License-Identifier: GPL-3.0-or-later
"""Lengths that depend on the camera, on a ball that leans away to its rim: wires in pixels, rays from the near clip.

Other outputs of the same nodes are test_ops_cycles.py's.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
from cotorra.metrics import same_image

import test_shader_closures_rendered as rendered
from flat_scenes import node

pytestmark = [
    pytest.mark.usefixtures('engine'),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='the scene is for Blender 5.2'),
]


def assert_as_cycles(scene: bpy.types.Scene, folder: Path, patch: pytest.MonkeyPatch, samples: int) -> None:
    patch.setattr(rendered, 'SAMPLES', samples)
    patch.setattr(rendered, 'BOUNCES', 0)
    bpy.data.materials['Surface'].cycles.emission_sampling = 'NONE'
    ours, theirs = (rendered.picture(scene, engine, folder) for engine in ('COTORRA', 'CYCLES'))
    same = same_image(ours, theirs, rendered.LIMIT, rendered.TILE)
    assert same.bad == 0 and same.beyond_noise == 0, (same.total, same.worst)


@pytest.mark.parametrize('size', [0.5, 2.0, -2.0])
def test_wires_in_pixels(size: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def wires(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        found = node(tree, 'Wireframe', use_pixel_size=True)
        found.inputs['Size'].default_value = size
        return found.outputs[0]

    assert_as_cycles(rendered.scene_of(wires), tmp_path, monkeypatch, 64)


@pytest.mark.parametrize('kind', ['PERSP', 'ORTHO'])
def test_rays_are_as_long_as_from_the_near_clip(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = rendered.scene_of(lambda tree: node(tree, 'LightPath').outputs['Ray Length'])
    scene.camera.data.type, scene.camera.data.clip_start = kind, 1.5
    assert_as_cycles(scene, tmp_path, monkeypatch, 4)
