# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables by which worlds are sampled: how fine they are, and that one which is known is taken over.

What light they bring is tested in test_world_light.py.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from cotorra import native

from flat_scenes import node
from scenes.depsgraphs import exported
from test_world_light import environment, over_floor, texels

Sky = Callable[[bpy.types.NodeTree], bpy.types.NodeSocket]
FULL, LEAST = 1024, 64  # cells around


def made(scene: bpy.types.Scene, previous: object = None) -> object:
    return native.load().Scene(exported(scene), bvh=False, previous=previous)


def textured(kind: str, output: int | str = 0, **values: object) -> Sky:
    return lambda tree: node(tree, kind, **values).outputs[output]


DEEP = {'feature': 'SMOOTH_F1', 'voronoi_dimensions': '4D', 'Detail': 15.0}


@pytest.mark.parametrize(
    'sky, least, most',
    [
        pytest.param(textured('TexNoise', Detail=15.0), FULL, FULL, id='noise'),
        pytest.param(textured('TexVoronoi', Detail=3.0), FULL, FULL, id='voronoi'),
        pytest.param(textured('TexVoronoi', 'Color', **DEEP), LEAST, FULL / 2, id='625 cells, 16 times'),
        pytest.param(
            textured('TexVoronoi', 'Color', distance='MINKOWSKI', **DEEP), LEAST, LEAST, id='the same, with powers'
        ),
        pytest.param(lambda tree: environment(tree, np.tile(texels(9.0), (16, 16, 1))), 512, 512, id='image'),
    ],
)
def test_a_table_is_as_fine_as_its_program_allows(sky: Sky, least: float, most: float) -> None:
    assert least <= made(over_floor(sky)).stats()['world_width'] <= most


def test_a_chosen_size_is_kept() -> None:
    scene = over_floor(textured('TexVoronoi', 'Color', **DEEP | {'Detail': 0.0}))
    scene.world.cycles.sampling_method, scene.world.cycles.sample_map_resolution = 'MANUAL', 200
    assert made(scene).stats()['world_width'] == 200


def test_the_kind_of_ray_counts_where_it_is_asked_for() -> None:
    def sky(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        mix = node(tree, 'MixRGB', blend_type='MULTIPLY')
        mix.inputs['Fac'].default_value = 1.0
        tree.links.new(node(tree, 'TexNoise').outputs['Color'], mix.inputs['Color1'])
        tree.links.new(node(tree, 'LightPath').outputs['Is Glossy Ray'], mix.inputs['Color2'])
        return mix.outputs[0]

    assert made(over_floor(sky)).stats()['world_width'] == 0  # nothing is there for diffuse rays, which come first


@pytest.mark.parametrize('image', [False, True])
def test_a_known_table_is_taken_over(image: bool) -> None:
    sky = (lambda tree: environment(tree, texels(9.0))) if image else textured('TexNoise', 'Color', Scale=2.0)
    scene = over_floor(sky)
    buffers = exported(scene)
    first = native.load().Scene(buffers, bvh=False)
    assert not first.stats()['world_taken_over']
    again = native.load().Scene(buffers, bvh=False, previous=first)
    assert again.stats()['world_taken_over'] and again.stats()['world_width'] == first.stats()['world_width']
    third = native.load().Scene(buffers, bvh=False, previous=again)
    assert third.stats()['world_taken_over']
    # 1. Another floor is no matter.
    bpy.data.materials['Floor'].node_tree.nodes['Diffuse BSDF'].inputs['Color'].default_value = (0.1, 0.2, 0.3, 1.0)
    if not image:  # of an image, another export has other memory
        assert made(scene, third).stats()['world_taken_over']
    # 2. Another world is.
    scene.world.node_tree.nodes['Background'].inputs['Strength'].default_value = 2.0
    assert not made(scene, third).stats()['world_taken_over']


def test_other_pixels_are_another_world() -> None:
    scene = over_floor(lambda tree: environment(tree, texels(9.0)))
    first = made(scene)
    bpy.data.images['Sky'].pixels[0] = 5.0
    assert not made(scene, first).stats()['world_taken_over']
