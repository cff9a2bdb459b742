# SPDX-License-Identifier: GPL-3.0-or-later
"""Random trees of all shader nodes, as light and as surfaces, beside the pictures of Cycles.

COTORRA_TREES=300 scripts/test tests/test_random_shaders.py is the long run, COTORRA_TREES=300:600 one of other seeds;
how many CI tries is said here.
"""

from __future__ import annotations

import os
from pathlib import Path

import bpy
import pytest
from cotorra import stats
from cotorra.metrics import same_image

import test_shader_closures_rendered as rendered
from random_shaders import Thicket, dress

pytestmark = [
    pytest.mark.usefixtures('engine'),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='the nodes are those of Blender 5.2'),
]

FIRST, _, LAST = os.environ.get('COTORRA_TREES', '40').rpartition(':')
SEEDS = range(int(FIRST or 0), int(LAST))
# Of each half. Light has little noise, surfaces have more.
SAMPLES = {'emission': 12, 'surface': 32}
# What Cycles draws otherwise or not at all, by its seed; each was looked at.
KNOWN: dict[tuple[str, int], str] = {
    (
        'surface',
        187,
    ): 'where rough refraction and translucency mix, Cycles counts the directions that no facet refracts '
    'to among those that refraction samples, which dims the translucency: 30 % at roughness 0.88, IOR 1.76',
    ('surface', 433): 'white noise of the grey of a colour, which differs in its last bit',
    ('emission', 768): 'not understood yet: bricks in rows without a height, whose mortar is of less than no size',
    ('emission', 810): 'a wave whose octaves have a roughness of -1 and sum to no number in Cycles, which shows black',
    ('surface', 817): 'a normal map of the very grey that is no direction: what is left of it is rounding',
    ('surface', 819): 'a highlight of anisotropy 0.99, of which 32 samples find too little: right with 256',
}


def cases() -> list[object]:
    made = []
    for seed in SEEDS:
        case = ('emission', 'surface')[seed % 2], seed
        marks = pytest.mark.xfail(strict=True, reason=KNOWN[case]) if case in KNOWN else ()
        made.append(pytest.param(*case, marks=marks, id=f'{case[0]}-{seed}'))
    return made


@pytest.mark.parametrize('shown, seed', cases())
def test_a_tree_is_as_cycles_shows_it(shown: str, seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rendered, 'SAMPLES', SAMPLES[shown])
    scene = rendered.scene_of(getattr(Thicket(seed), shown))
    dress(scene.objects['Sphere'].data)
    tree = scene.objects['Sphere'].active_material.node_tree
    if any(made.bl_idname == 'ShaderNodeLightPath' for made in tree.nodes):
        # Cycles' light samples ask another path than its rays do; how both are mixed is its light tree's.
        scene.objects['Sphere'].active_material.cycles.emission_sampling = 'NONE'
    ours = rendered.picture(scene, 'COTORRA', tmp_path)
    warnings = [text for layer in stats.last(scene.name) for text in layer.warnings]
    theirs = rendered.picture(scene, 'CYCLES', tmp_path)
    same = same_image(ours, theirs, rendered.LIMIT, rendered.TILE)
    told = f'worst tile {same.worst}, of {[made.bl_idname for made in tree.nodes]}'
    assert same.bad == 0, told
    # What is not right is named.
    assert same.beyond_noise == 0 or warnings, told
