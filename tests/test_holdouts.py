# SPDX-License-Identifier: GPL-3.0-or-later
"""Holdout shaders: what they leave of the film, of what is added to them, and of their neighbours."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

from flat_scenes import Flat, assert_as_cycles, flat, node, shining
from render_calls import read_exr
from scenes import build

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from benchmark.fair import make_fair, set_job

pytestmark = pytest.mark.usefixtures('engine')


def picture(
    scene: bpy.types.Scene, engine: str, samples: int, folder: Path, sharing: bool = False
) -> dict[str, np.ndarray]:
    make_fair(scene, engine, 4, (4, 4), threads=1)
    path = folder / f'{engine}.exr'
    set_job(scene, samples, 1, str(path), sharing)
    bpy.ops.render.render(write_still=True)
    return read_exr(path)['']


def combined(made: Flat, kind: str, first: str, second: str) -> bpy.types.Node:
    """The square's surface: two shaders under a Mix or an Add Shader."""
    sum_ = made.node(kind)
    shaders = [socket for socket in sum_.inputs if socket.type == 'SHADER']
    for name, socket in zip((first, second), shaders, strict=True):
        made.link(made.node(name).outputs[0], socket)
    made.link(sum_.outputs[0], made.output.inputs['Surface'])
    return sum_


@pytest.mark.parametrize('transparent', [False, True], ids=['opaque', 'transparent'])
@pytest.mark.parametrize(('share', 'alpha'), [(0.0, 1.0), (0.4, 0.6), (1.0, 0.0)])
def test_a_holdout_leaves_nothing_of_the_film(share: float, alpha: float, transparent: bool, tmp_path: Path) -> None:
    made = flat()
    combined(made, 'MixShader', 'BsdfDiffuse', 'Holdout').inputs[0].default_value = share
    build.world(made.scene)
    made.scene.render.film_transparent = transparent
    for engine in ('COTORRA', 'CYCLES'):
        left = picture(made.scene, engine, 1024, tmp_path)['A'][1:3, 1:3].mean()
        assert left == pytest.approx(alpha, abs=0.02), engine  # 2.6 sigma of 4096 draws


@pytest.mark.parametrize('sharing', [False, True])
def test_an_opaque_film_without_holdouts_is_whole(sharing: bool, tmp_path: Path) -> None:
    """To the bit, however many samples there are, and where there is but the background."""
    made = flat()
    made.obj.scale = (0.1, 0.1, 0.1)
    build.world(made.scene)
    assert (picture(made.scene, 'COTORRA', 49, tmp_path, sharing)['A'] == 1.0).all()


@pytest.mark.parametrize('other', ['Emission', 'BsdfDiffuse', 'BsdfTransparent'])
def test_a_whole_holdout_shows_nothing_that_is_added_to_it(other: str, tmp_path: Path) -> None:
    made = flat()
    combined(made, 'AddShader', 'Holdout', other)
    build.world(made.scene)
    assert assert_as_cycles(tmp_path) == (0.0, 0.0, 0.0)


def test_a_part_of_a_holdout_leaves_what_is_added_to_it(tmp_path: Path) -> None:
    made = flat()
    half = combined(made, 'MixShader', 'Holdout', 'Holdout')
    made.tree.links.remove(half.inputs[2].links[0])
    half.inputs[0].default_value = 0.25
    sum_ = made.node('AddShader')
    made.link(half.outputs[0], sum_.inputs[0])
    made.link(made.emission.outputs[0], sum_.inputs[1])
    made.link(sum_.outputs[0], made.output.inputs['Surface'])
    assert assert_as_cycles(tmp_path) == pytest.approx((0.25, 0.5, 0.75), rel=1e-3)  # half floats


def test_whether_a_holdout_is_whole_may_vary(tmp_path: Path) -> None:
    """A factor that the square computes: 1 at the right, where nothing is left of what is added."""
    made = flat()
    half = combined(made, 'MixShader', 'BsdfTransparent', 'Holdout')
    split, above = made.node('SeparateXYZ'), made.node('Math', operation='GREATER_THAN')
    made.link(made.node('TexCoord').outputs['UV'], split.inputs[0])
    made.link(split.outputs[0], above.inputs[0])
    made.link(above.outputs[0], half.inputs[0])
    sum_ = made.node('AddShader')
    made.link(half.outputs[0], sum_.inputs[0])
    made.link(made.emission.outputs[0], sum_.inputs[1])
    made.link(sum_.outputs[0], made.output.inputs['Surface'])
    for engine in ('COTORRA', 'CYCLES'):
        shown = picture(made.scene, engine, 64, tmp_path)['G'].mean(0)
        assert shown[0] == pytest.approx(0.5, rel=0.01), engine  # each sample shows it; 1 % is the filter's edge
        assert shown[3] == 0.0, engine


def test_other_rays_than_the_cameras_see_what_is_added_to_a_holdout(tmp_path: Path) -> None:
    """A lit wall is as bright as under the emitter alone."""
    made = flat()
    made.link(made.node('BsdfDiffuse').outputs[0], made.output.inputs['Surface'])
    lamp = bpy.data.meshes.new('Lamp')
    lamp.from_pydata([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], [], [(0, 1, 2, 3)])
    build.link(made.scene, 'Lamp', lamp).location = (0, 0, 5)
    lamp.materials.append(shining('Shining'))
    alone = picture(made.scene, 'COTORRA', 64, tmp_path)['G'].mean()
    tree = lamp.materials[0].node_tree
    sum_ = node(tree, 'AddShader')
    tree.links.new(node(tree, 'Holdout').outputs[0], sum_.inputs[0])
    tree.links.new(tree.nodes['Shine'].outputs[0], sum_.inputs[1])
    tree.links.new(sum_.outputs[0], tree.nodes['Out'].inputs['Surface'])
    # Ours draws the same samples as before, up to which closure is drawn; Cycles' noise comes on top.
    assert picture(made.scene, 'COTORRA', 64, tmp_path)['G'].mean() == pytest.approx(alone, rel=0.01)
    assert picture(made.scene, 'CYCLES', 64, tmp_path)['G'].mean() == pytest.approx(alone, rel=0.02)


def test_a_surface_without_code_is_no_part_of_its_neighbours_program(tmp_path: Path) -> None:
    """A holdout computes nothing, and another surface's code may stand at the same place: they are shaded apart."""
    made = flat()
    rough = made.node('BsdfDiffuse', Roughness=0.5)
    made.link(made.node('TexCoord').outputs['UV'], rough.inputs['Color'])
    made.link(rough.outputs[0], made.output.inputs['Surface'])
    build.world(made.scene)
    wall = made.obj.data.materials[0]
    hole = bpy.data.materials.new('Hole')
    tree = build.with_nodes(hole).node_tree
    tree.nodes.clear()
    tree.links.new(node(tree, 'Holdout').outputs[0], node(tree, 'OutputMaterial').inputs['Surface'])
    data = bpy.data.meshes.new('Cover')
    data.from_pydata([(-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    data.materials.append(hole)
    cover = build.link(made.scene, 'Cover', data)
    cover.location = (0, 0, 1)
    made.obj.data.materials.clear()
    for material in (hole, wall):  # the code of the one that is read next begins where the hole's ends
        made.obj.data.materials.append(material)
    made.obj.data.polygons[0].material_index = 1
    covered = picture(made.scene, 'COTORRA', 64, tmp_path)
    cover.visible_camera = False
    free = picture(made.scene, 'COTORRA', 64, tmp_path)
    for name in 'RG':
        np.testing.assert_array_equal(covered[name][:, 3], free[name][:, 3])
        assert covered[name][1:3, 1].mean() < 0.5 * free[name][1:3, 1].mean()
