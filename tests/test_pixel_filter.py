# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges look as they do in Cycles, with each pixel filter."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
import compare
from benchmark.fair import make_fair, set_job
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')


def edge() -> None:
    """A shining half plane, whose edge stands upright in the middle of a pixel."""
    scene = build.new_scene()
    build.camera(scene, type='ORTHO', ortho_scale=16.0).location = (0, 0, 3)
    data = build.grid(1)
    material = build.material()
    node = material.node_tree.nodes['Principled BSDF']
    node.inputs['Base Color'].default_value = (0, 0, 0, 1)
    node.inputs['Specular IOR Level'].default_value = 0.0
    node.inputs['Emission Color'].default_value, node.inputs['Emission Strength'].default_value = (1, 1, 1, 1), 1.0
    data.materials.append(material)
    obj = build.link(scene, 'Plane', data)
    obj.scale = (20, 20, 1)
    obj.location.x = 0.5 - 20.0 * max(vertex.co.x for vertex in data.vertices)


def profile(engine: str, kind: str, width: float, folder: Path) -> np.ndarray:
    """Mean of each column of 16 x 16 pixels."""
    scene = bpy.context.scene
    make_fair(scene, engine, 0, (16, 16), threads=2)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = kind, width
    path = folder / f'{engine}.exr'
    set_job(scene, 256, 1, str(path))
    bpy.ops.render.render(write_still=True)
    return compare.read_exr(path)[0][..., 0].mean(axis=0)


@pytest.mark.parametrize(
    ('kind', 'width'), [('BLACKMAN_HARRIS', 1.5), ('GAUSSIAN', 1.5), ('GAUSSIAN', 3.0), ('BOX', 3.0)]
)
def test_an_edge_is_as_soft_as_in_cycles(kind: str, width: float, tmp_path: Path) -> None:
    edge()
    ours, theirs = (profile(engine, kind, width, tmp_path) for engine in ('COTORRA', 'CYCLES'))
    assert ours[0] == pytest.approx(1.0) and ours[-1] == pytest.approx(0.0, abs=1e-6)
    soft = (theirs > 0.01) & (theirs < 0.99)
    assert soft.sum() == {'BOX': 1}.get(kind, soft.sum()) >= 1
    # 4,096 samples a column, stratified: measured 0.0005.
    np.testing.assert_allclose(ours, theirs, atol=0.004)
