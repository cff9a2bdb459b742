# SPDX-License-Identifier: GPL-3.0-or-later
"""Links lead where Blender says: past muted nodes, reroutes, groups, menus and zones, with conversions; and they end.

Each tree is rendered by both engines on a few pixels. What shader nodes mean is tested in test_export_materials.py.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra.export.nodes import Input, Trees, source
from cotorra.log import Cancelled

import flat_scenes
from flat_scenes import Flat, flat, group, node, shown, through
from random_trees import Forest

AGAINST_CYCLES = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='4.5 converts otherwise, and has no inliner')

pytestmark = pytest.mark.usefixtures('engine')

TYPED = {
    'Color': (0.9, 0.1, 2.2, 1.0),
    'Float': 2.7,
    'Int': 3,
    'Bool': True,
    'Vector': (1.5, 0.2, -2.3),  # true, though its mean is negative
}


# ---- One tree each; Cycles says what is right.


def muted_typed_in(made: Flat) -> bpy.types.Node:
    hue = made.node('HueSaturation', mute=True)
    hue.inputs['Color'].default_value = (0.9, 0.1, 0.2, 1.0)
    return hue


def muted(made: Flat) -> None:
    made.link(muted_typed_in(made).outputs[0], made.emission.inputs[0])


def muted_then_reroute(made: Flat) -> None:
    reroute = made.node('NodeReroute')
    made.link(muted_typed_in(made).outputs[0], reroute.inputs[0])
    made.link(reroute.outputs[0], made.emission.inputs[0])


def muted_without_way(made: Flat) -> None:
    made.link(made.node('RGB', mute=True).outputs[0], made.emission.inputs[0])


def muted_into_node(made: Flat) -> None:
    invert = made.node('Invert')
    invert.inputs['Color'].default_value = (0.1, 0.2, 0.3, 1.0)
    made.link(muted_typed_in(made).outputs[0], invert.inputs['Color'])
    made.link(invert.outputs[0], made.emission.inputs[0])


def reroute_alone(made: Flat) -> None:
    made.link(made.node('NodeReroute').outputs[0], made.emission.inputs[0])


def in_group(made: Flat, fill: Callable, inputs: tuple = (), outputs: tuple = ('Color',)) -> bpy.types.Node:
    found = made.node('Group', node_tree=group('Group', inputs, outputs, fill))
    made.link(found.outputs[0], made.emission.inputs[0])
    return found


def muted_in_group(made: Flat) -> None:
    def fill(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        tree.links.new(node(tree, 'HueSaturation', mute=True).outputs[0], end.inputs[0])
        end.inputs[0].default_value = (0.3, 0.3, 0.9, 1.0)

    in_group(made, fill)


def muted_group(made: Flat) -> None:
    found = in_group(made, through, ('Color',))
    found.inputs[0].default_value = (0.9, 0.1, 0.1, 1.0)
    found.mute = True


def group_without_tree(made: Flat) -> None:
    bpy.data.node_groups.remove(in_group(made, through, ('Color',)).node_tree)


def group_without_output(made: Flat) -> None:
    nodes = in_group(made, through, ('Color',)).node_tree.nodes
    nodes.remove(next(found for found in nodes if found.type == 'GROUP_OUTPUT'))


def two_group_outputs(made: Flat) -> None:
    def fill(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        end.inputs[0].default_value = (0.9, 0.1, 0.1, 1.0)
        node(tree, 'NodeGroupOutput', is_active_output=True).inputs[0].default_value = (0.1, 0.9, 0.1, 1.0)

    in_group(made, fill)


def one_tree_within_itself_twice(made: Flat) -> None:
    def adds(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        step = node(tree, 'Math')
        step.inputs[1].default_value = 0.125
        tree.links.new(start.outputs[0], step.inputs[0])
        tree.links.new(step.outputs[0], end.inputs[0])

    inner = group('Inner', ('Float',), ('Float',), adds)

    def fill(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        first, second = node(tree, 'Group', node_tree=inner), node(tree, 'Group', node_tree=inner)
        tree.links.new(start.outputs[0], first.inputs[0])
        tree.links.new(first.outputs[0], second.inputs[0])
        tree.links.new(second.outputs[0], end.inputs[0])

    in_group(made, fill, ('Float',), ('Float',)).inputs[0].default_value = 0.5


def menu(made: Flat) -> None:
    found = made.node('GeometryNodeMenuSwitch', data_type='RGBA')
    found.inputs[1].default_value, found.inputs[2].default_value = (0.1, 0.9, 0.1, 1.0), (0.9, 0.9, 0.1, 1.0)
    found.inputs[0].default_value = 'B'
    made.link(found.outputs[0], made.emission.inputs[0])
    made.link(found.outputs[2], made.emission.inputs[1])


def closure(made: Flat) -> None:
    start, end = made.node('NodeClosureInput'), made.node('NodeClosureOutput')
    start.pair_with_output(end)
    end.input_items.new('FLOAT', 'x')
    end.output_items.new('FLOAT', 'y')
    step = made.node('Math')
    step.inputs[1].default_value = 0.25
    made.link(start.outputs[0], step.inputs[0])
    made.link(step.outputs[0], end.inputs[0])
    use = made.node('NodeEvaluateClosure')
    use.input_items.new('FLOAT', 'x')
    use.output_items.new('FLOAT', 'y')
    use.inputs[1].default_value = 0.5
    made.link(end.outputs[0], use.inputs[0])
    made.link(use.outputs[0], made.emission.inputs[0])


def bundle(made: Flat) -> None:
    tied, untied = made.node('NodeCombineBundle'), made.node('NodeSeparateBundle')
    for at in (tied, untied):
        at.bundle_items.new('RGBA', 'color')
    tied.inputs[0].default_value = (0.2, 0.8, 0.4, 1.0)
    made.link(tied.outputs[0], untied.inputs[0])
    made.link(untied.outputs[0], made.emission.inputs[0])


def output_of_another_engine(made: Flat) -> None:
    made.output.target = 'EEVEE'


def output_for_cycles(made: Flat) -> None:
    other = made.node('Emission')
    other.inputs[0].default_value = (0.1, 0.1, 0.9, 1.0)
    made.link(other.outputs[0], made.node('OutputMaterial', target='CYCLES').inputs[0])


def value_into_shader(made: Flat) -> None:
    found = made.node('Value')
    found.outputs[0].default_value = 0.7
    made.link(found.outputs[0], made.output.inputs[0])


def group_color_into_shader(made: Flat) -> None:
    found = made.node('Group', node_tree=group('Group', ('Color',), ('Shader',), through))
    found.inputs[0].default_value = (0.2, 0.6, 0.9, 1.0)
    made.link(found.outputs[0], made.output.inputs[0])


def color_into_mix_shader(made: Flat) -> None:
    color, mix = made.node('RGB'), made.node('MixShader')
    color.outputs[0].default_value = (0.2, 0.6, 0.9, 1.0)
    made.link(color.outputs[0], mix.inputs[1])
    made.link(made.emission.outputs[0], mix.inputs[2])
    made.link(mix.outputs[0], made.output.inputs[0])


def color_into_world(made: Flat) -> None:
    made.obj.hide_render = True
    world = made.scene.world = bpy.data.worlds.new('World')
    color = node(world.node_tree, 'RGB')
    color.outputs[0].default_value = (0.1, 0.3, 0.5, 1.0)
    world.node_tree.links.new(color.outputs[0], world.node_tree.get_output_node('CYCLES').inputs[0])


def coordinates(made: Flat, hide: bool) -> None:
    """A group's vector input that is not linked is (0, 0, 0), unless it shows no value."""
    image = bpy.data.images.new('Picture', 2, 2, float_buffer=True)
    image.pixels.foreach_set([0.1, 0.2, 0.3, 1, 0.9, 0.1, 0.1, 1, 0.4, 0.9, 0.4, 1, 0.2, 0.2, 0.9, 1])

    def fill(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        texture = node(tree, 'TexImage', image=image, interpolation='Closest')
        tree.links.new(start.outputs[0], texture.inputs[0])
        tree.links.new(texture.outputs[0], end.inputs[0])
        tree.interface.items_tree['Vector0'].hide_value = hide

    in_group(made, fill, ('Vector',))


def vector_of_group(made: Flat) -> None:
    coordinates(made, hide=False)


def hidden_vector_of_group(made: Flat) -> None:
    coordinates(made, hide=True)


CASES = (
    *(muted, muted_then_reroute, muted_without_way, muted_into_node, reroute_alone, muted_in_group, muted_group),
    *(group_without_tree, group_without_output, two_group_outputs, one_tree_within_itself_twice, menu, closure, bundle),
    *(output_of_another_engine, output_for_cycles, value_into_shader, group_color_into_shader, color_into_mix_shader),
    *(color_into_world, vector_of_group, hidden_vector_of_group),
)


@AGAINST_CYCLES
@pytest.mark.parametrize('case', CASES, ids=lambda case: case.__name__)
def test_as_cycles(case: Callable[[Flat], None], tmp_path: Path) -> None:
    case(flat())
    flat_scenes.assert_as_cycles(tmp_path)


@AGAINST_CYCLES
@pytest.mark.parametrize('end', list(TYPED))
@pytest.mark.parametrize('start', list(TYPED))
def test_conversions_within_groups(start: str, end: str, tmp_path: Path) -> None:
    in_group(flat(), through, (start,), (end,)).inputs[0].default_value = TYPED[start]
    flat_scenes.assert_as_cycles(tmp_path)


@AGAINST_CYCLES
@pytest.mark.parametrize('kind', ['RGB', 'Value'])
@pytest.mark.parametrize('end', ['Float', 'Int', 'Bool'])
def test_conversions_of_what_nodes_give(kind: str, end: str, tmp_path: Path) -> None:
    """Blender knows the number of a node Value and converts it; the colour of a node RGB it leaves to the engine."""

    def fill(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        found = node(tree, kind)
        found.outputs[0].default_value = TYPED['Color' if kind == 'RGB' else 'Float']
        tree.links.new(found.outputs[0], end.inputs[0])

    in_group(flat(), fill, (), (end,))
    flat_scenes.assert_as_cycles(tmp_path)


@AGAINST_CYCLES
def test_random_trees(tmp_path: Path) -> None:
    colors = set()
    for seed in range(60):
        Forest(seed).scene()
        colors.add(flat_scenes.assert_as_cycles(tmp_path, which=f'seed {seed}'))
    assert len(colors) > 20  # they are not all black


def test_group_that_its_library_lacks_is_named(tmp_path: Path) -> None:
    made = flat()
    library, scene = tmp_path / 'library.blend', tmp_path / 'scene.blend'
    kept = group('Kept', ('Color',), ('Color',), through)
    bpy.data.libraries.write(str(library), {kept}, fake_user=True)
    bpy.data.node_groups.remove(kept)
    with bpy.data.libraries.load(str(library), link=True) as (found, wanted):
        wanted.node_groups = found.node_groups
    linked = made.node('Group', node_tree=wanted.node_groups[0])
    linked.inputs[0].default_value = (0.9, 0.1, 0.2, 1.0)
    made.link(linked.outputs[0], made.emission.inputs[0])
    color, warnings = shown('COTORRA', tmp_path)
    np.testing.assert_allclose(color, (0.9, 0.1, 0.2), rtol=1e-5)
    assert not warnings
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    library.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(scene))
    color, warnings = shown('COTORRA', tmp_path)
    assert color.tolist() == [0.0, 0.0, 0.0]  # as Cycles
    assert warnings == ['Material "Material": node "Group": group "Kept" is missing from its library: 0 is used']


# ---- Loops.


def loop_of_math(made: Flat) -> str:
    found = made.node('Math')
    made.link(found.outputs[0], found.inputs[0])
    made.link(found.outputs[0], made.emission.inputs[1])
    return found.name


def loop_of_muted(made: Flat) -> str:
    name = loop_of_math(made)
    made.tree.nodes[name].mute = True
    return name


def loop_of_reroute(made: Flat) -> str:
    found = made.node('NodeReroute')
    made.link(found.outputs[0], found.inputs[0])
    made.link(found.outputs[0], made.emission.inputs[0])
    return found.name


def loop_of_shader(made: Flat) -> str:
    found = made.node('AddShader')
    made.link(found.outputs[0], found.inputs[0])
    made.link(made.emission.outputs[0], found.inputs[1])
    made.link(found.outputs[0], made.output.inputs[0])
    return found.name


def loop_of_group(made: Flat) -> str:
    found = in_group(made, through, ('Color',))
    made.link(found.outputs[0], found.inputs[0])
    return found.name


def loop_in_group(made: Flat) -> str:
    def fill(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        found = node(tree, 'Math')
        tree.links.new(found.outputs[0], found.inputs[0])
        tree.links.new(found.outputs[0], end.inputs[0])

    in_group(made, fill)
    return 'group "Group": node "Math'


def loop_of_two(made: Flat) -> str:
    first, second = made.node('Math'), made.node('Math')
    made.link(second.outputs[0], first.inputs[0])
    made.link(first.outputs[0], second.inputs[0])
    made.link(first.outputs[0], made.emission.inputs[1])
    return first.name


def loop_apart(made: Flat) -> str:
    found = made.node('Math')
    made.link(found.outputs[0], found.inputs[0])
    return found.name


LOOPS = (
    *(loop_of_math, loop_of_muted, loop_of_reroute, loop_of_shader),
    *(loop_of_group, loop_in_group, loop_of_two, loop_apart),
)


@pytest.mark.parametrize('case', LOOPS, ids=lambda case: case.__name__)
def test_loops_are_named_and_end(case: Callable[[Flat], str], tmp_path: Path) -> None:
    name = case(flat())
    color, warnings = shown('COTORRA', tmp_path)
    assert np.isfinite(color).all()
    assert [text for text in warnings if text.startswith('Material "Material"') and name in text and 'left out' in text]


def test_loop_leaves_the_rest_alone(tmp_path: Path) -> None:
    loop_of_shader(flat())
    color, _ = shown('COTORRA', tmp_path)
    np.testing.assert_allclose(color, flat_scenes.OWN[:3], rtol=1e-5)


# ---- Depth.


def nested(made: Flat, kind: str, socket: str, steps: int = 100) -> bpy.types.Node:
    """steps × steps nodes one after the other: a chain in a group, and a chain of that group in another."""
    inner: bpy.types.NodeTree | None = None
    for level in range(2):

        def fill(
            tree: bpy.types.NodeTree,
            start: bpy.types.Node,
            end: bpy.types.Node,
            inner: bpy.types.NodeTree | None = inner,
        ) -> None:
            at = start.outputs[0]
            for _ in range(steps):
                step = node(tree, kind) if inner is None else node(tree, 'Group', node_tree=inner)
                if step.type == 'MATH':
                    step.inputs[1].default_value = 1e-4
                tree.links.new(at, step.inputs['Normal'] if step.type == 'BUMP' else step.inputs[0])
                at = step.outputs[0]
            tree.links.new(at, end.inputs[0])

        inner = group(f'Level{level}', (socket,), (socket,), fill)
    return made.node('Group', node_tree=inner)


@pytest.mark.parametrize('kind', ['Math', 'NodeReroute', 'AddShader', 'VectorMath', 'Bump'])
def test_ten_thousand_nodes_in_a_row(kind: str, tmp_path: Path) -> None:
    made = flat()
    sockets = {'AddShader': 'Shader', 'VectorMath': 'Vector', 'Bump': 'Vector'}
    found = nested(made, kind, sockets.get(kind, 'Float'))
    expected = np.array(flat_scenes.OWN[:3])
    if kind == 'AddShader':
        made.link(made.emission.outputs[0], found.inputs[0])
        made.link(found.outputs[0], made.output.inputs[0])
    elif kind == 'VectorMath':
        texture = made.node('TexImage', image=bpy.data.images.new('Black', 2, 2))
        made.link(made.node('TexCoord').outputs['UV'], found.inputs[0])
        made.link(found.outputs[0], texture.inputs[0])
        made.link(texture.outputs[0], made.emission.inputs[0])
        expected[:] = 0.0
    elif kind == 'Bump':
        diffuse, both = made.node('BsdfDiffuse'), made.node('AddShader')
        made.link(found.outputs[0], diffuse.inputs['Normal'])
        made.link(diffuse.outputs[0], both.inputs[0])
        made.link(made.emission.outputs[0], both.inputs[1])
        made.link(both.outputs[0], made.output.inputs[0])
    else:
        found.inputs[0].default_value = 0.5
        made.link(found.outputs[0], made.emission.inputs[0])
        expected[:] = 1.5 if kind == 'Math' else 0.5
    color, _ = shown('COTORRA', tmp_path)
    np.testing.assert_allclose(color, expected, rtol=1e-3)


@pytest.mark.parametrize('kind', ['Math', 'AddShader'])
def test_sums_of_sums_are_read_once(kind: str, tmp_path: Path) -> None:
    """Twice the same, forty times: 2^40 ways through the tree."""
    made = flat()
    at = made.node('Value').outputs[0] if kind == 'Math' else made.emission.outputs[0]
    for _ in range(40):
        step = made.node(kind)
        made.link(at, step.inputs[0])
        made.link(at, step.inputs[1])
        at = step.outputs[0]
    made.emission.inputs[1].default_value = 2.0**-40
    made.link(at, made.emission.inputs[0] if kind == 'Math' else made.output.inputs[0])
    if kind == 'Math':
        made.tree.nodes['Value'].outputs[0].default_value = 1.0
    color, _ = shown('COTORRA', tmp_path)
    np.testing.assert_allclose(color, (1.0,) * 3 if kind == 'Math' else flat_scenes.OWN[:3], rtol=1e-3)


def test_a_walk_sees_the_wish_to_stop() -> None:
    made = flat()
    found = nested(made, 'Math', 'Float', steps=30)
    made.link(found.outputs[0], made.emission.inputs[1])

    def stop() -> None:
        raise Cancelled

    trees = Trees(stop)
    with pytest.raises(Cancelled):
        trees.folded(source(trees, Input(made.emission.inputs[1])))
