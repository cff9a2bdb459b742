# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees become the sums of closures that they mean: mixes, conversions, bumps, drawn and inlined trees, bad ones.

What each node becomes is tested in test_shader_nodes.py; where links lead also in test_node_walks.py.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat, shader

import flat_scenes
import shader_reading
from flat_scenes import group, node
from random_trees import Forest
from scenes import build
from shader_reading import Read, Values, emitted, link, new_material, read, varying

IS_5 = bpy.app.version >= (5, 0, 0)


@pytest.fixture(autouse=True)
def empty(engine: None) -> None:
    build.new_scene()


# ---- Mixes and closures.


def test_mixes_share_out_weights() -> None:
    material, emission = new_material()
    tree = material.node_tree
    output = next(found for found in tree.nodes if found.type == 'OUTPUT_MATERIAL')
    outer, inner, diffuse = node(tree, 'MixShader'), node(tree, 'MixShader'), node(tree, 'BsdfDiffuse')
    both = node(tree, 'AddShader')
    outer.inputs[0].default_value = 0.25
    link(varying(tree), inner.inputs[0])
    link(diffuse.outputs[0], inner.inputs[1])
    link(emission.outputs[0], inner.inputs[2])
    link(inner.outputs[0], outer.inputs[1])
    link(emission.outputs[0], both.inputs[0])
    link(node(tree, 'BsdfTransparent').outputs[0], both.inputs[1])
    link(both.outputs[0], outer.inputs[2])
    link(outer.outputs[0], output.inputs['Surface'])
    found = Values(read(material), {'backfacing': 0.125, 'normal': (0, 0, 1)})
    weights = {name: found.weight(row)[0] for row, name in enumerate(found.read.closures)}
    # The emission is read once, with the weights of both ways.
    assert sorted(found.read.closures) == ['diffuse', 'emission', 'transparent']
    expected = {'diffuse': 0.75 * 0.875, 'emission': 0.75 * 0.125 + 0.25, 'transparent': 0.25}
    assert weights == pytest.approx(expected)


@pytest.mark.parametrize('factor', [0.0, 1.0, -3.0, 7.0])
def test_what_a_constant_mix_leaves_out_is_not_read(factor: float) -> None:
    material, _ = new_material()
    tree = material.node_tree
    output = next(found for found in tree.nodes if found.type == 'OUTPUT_MATERIAL')
    mix, kinds = node(tree, 'MixShader'), ('BsdfHair', 'BsdfDiffuse')
    mix.inputs[0].default_value = factor
    for index in range(2):
        made = node(tree, kinds[index if factor > 0.0 else 1 - index])
        link(made.outputs[0], mix.inputs[1 + index])
    link(mix.outputs[0], output.inputs['Surface'])
    found = read(material)
    assert found.closures == ['diffuse'] and not found.warnings


def test_sums_of_sums_are_read_once() -> None:
    """Twice the same, forty times: 2^40 ways to one emission."""
    material, emission = new_material()
    tree = material.node_tree
    output, at = next(found for found in tree.nodes if found.type == 'OUTPUT_MATERIAL'), emission.outputs[0]
    for _ in range(40):
        both = node(tree, 'AddShader')
        link(at, both.inputs[0])
        link(at, both.inputs[1])
        at = both.outputs[0]
    link(at, output.inputs['Surface'])
    found = Values(read(material))
    assert found.read.closures == ['emission']
    assert found.weight(0)[0] == 2.0**40


@pytest.mark.parametrize('distribution', ['GGX', 'MULTI_GGX', 'BECKMANN', 'ASHIKHMIN_SHIRLEY'])
def test_distributions(distribution: str) -> None:
    material, made = emitted('BsdfAnisotropic', distribution=distribution)
    output = next(found for found in material.node_tree.nodes if found.type == 'OUTPUT_MATERIAL')
    link(made.outputs[0], output.inputs['Surface'])
    found = read(material)
    names = ['GGX', 'MULTI_GGX', 'BECKMANN', 'ASHIKHMIN_SHIRLEY']
    assert found.shader.closures['mode'].tolist() == [names.index(distribution)]


def test_all_inputs_of_principled_arrive() -> None:
    """Each input has a value of its own, which shows up under the name of that input."""
    material = bpy.data.materials.new('Material')
    made = compat.principled(material)
    names = {
        'base': 'Base Color',
        'subsurface': 'Subsurface Weight',
        'specular_level': 'Specular IOR Level',
        'anisotropic': 'Anisotropic',
        'rotation': 'Anisotropic Rotation',
        'transmission': 'Transmission Weight',
        'coat': 'Coat Weight',
        'sheen': 'Sheen Weight',
        'film_thickness': 'Thin Film Thickness',
        'film_ior': 'Thin Film IOR',
        'subsurface_ior': 'Subsurface IOR',
    }
    expected = {}
    skipped = ('normal', 'tangent', 'coat_normal', 'emission', 'thin_wall')
    for index, name in enumerate(shader_reading.CLOSURE_ARGUMENTS['principled']):
        if name in skipped:
            continue
        title = name.replace('_', ' ').title().replace('Ior', 'IOR')
        socket = next(found for found in made.inputs if found.identifier == names.get(name, title))
        value = 0.02 * (index + 1)
        if isinstance(socket.default_value, float):
            socket.default_value, expected[name] = value, value
        else:
            row = [value, value + 0.005, value + 0.01]
            socket.default_value = row + [1.0] * (len(socket.default_value) - 3)
            expected[name] = row
    made.inputs['Emission Color'].default_value = (0.5, 1.0, 0.25, 1.0)
    made.inputs['Emission Strength'].default_value = 3.0
    expected['emission'] = [1.5, 3.0, 0.75]
    expected['thin_wall'] = 0.0
    if IS_5:
        made.inputs['Thin Wall'].default_value, expected['thin_wall'] = True, 1.0
    found = Values(read(material), {'normal': (0, 0, 1), 'geometry_tangent': (1, 0, 0)})
    for name, value in expected.items():
        assert np.allclose(found.closure(0, name), value, atol=1e-6), name
    assert found.closure(0, 'normal').tolist() == found.closure(0, 'coat_normal').tolist() == [0, 0, 1]
    assert found.closure(0, 'tangent').tolist() == [1, 0, 0]
    if IS_5:  # what a thin wall scatters is known
        assert not found.read.warnings
        made.inputs['Thin Wall'].default_value = False
    assert 'subsurface' in read(material).warnings[0]


@pytest.mark.parametrize(
    ('kind', 'named'),
    [
        ('SubsurfaceScattering', 'subsurface'),
        ('BsdfHair', 'hair'),
        ('BsdfHairPrincipled', 'hair'),
        ('BsdfRayPortal', 'portal'),
    ],
)
def test_what_is_not_built_is_named(kind: str, named: str) -> None:
    material, _ = new_material()
    output = next(found for found in material.node_tree.nodes if found.type == 'OUTPUT_MATERIAL')
    made = node(material.node_tree, kind, name='This one')
    link(made.outputs[0], output.inputs['Surface'])
    found = read(material)
    assert len(found.closures) == 1
    assert len(found.warnings) == 1 and named in found.warnings[0] and '"This one"' in found.warnings[0]


def test_nothing_at_the_output_is_black() -> None:
    material, _ = new_material()
    material.node_tree.links.clear()
    assert read(material).closures == []
    material.node_tree.nodes.clear()
    assert read(material).closures == []


def test_worlds_and_lamps() -> None:
    world = bpy.data.worlds.new('World')
    compat.background(world).inputs['Color'].default_value = (0.5, 0.25, 1.0, 1.0)
    assert Values(read(world)).emission().tolist() == [0.5, 0.25, 1.0]
    noise = node(world.node_tree, 'TexNoise')
    link(noise.outputs['Color'], compat.background(world).inputs['Color'])
    assert read(world).ops[:2] == ['position', 'noise_v']  # coordinates are directions there
    lamp = bpy.data.lights.new('Lamp', 'POINT')
    assert Values(read(lamp)).emission().tolist() == [1.0, 1.0, 1.0]


@pytest.mark.skipif(IS_5, reason='Blender 5 gives each material a tree')
def test_without_nodes() -> None:
    material = bpy.data.materials.new('Plain')
    material.diffuse_color = (0.5, 0.25, 0.125, 1.0)
    found = Values(read(material), {'normal': (0, 0, 1)})
    assert found.read.closures == ['diffuse'] and found.closure(0, 'color').tolist() == [0.5, 0.25, 0.125]


# ---- Conversions.


@pytest.mark.parametrize('start', ['color', 'vector', 'float'])
@pytest.mark.parametrize('end', ['Color', 'Strength', 'Surface'])
def test_conversions(start: str, end: str) -> None:
    material, emission = new_material()
    tree = material.node_tree
    color = np.array((0.9, 0.1, 0.4))
    emission.inputs['Color'].default_value = (1.0, 1.0, 1.0, 1.0)
    geometry = node(tree, 'NewGeometry')
    if start == 'color':
        shown = node(tree, 'Invert')
        shown.inputs['Fac' if not IS_5 else 0].default_value = 0.0
        link(geometry.outputs['Position'], shown.inputs['Color'])
    elif start == 'vector':
        shown = node(tree, 'VectorMath')
        link(geometry.outputs['Position'], shown.inputs[0])
    else:
        shown = node(tree, 'SeparateXYZ')
        link(geometry.outputs['Position'], shown.inputs[0])
    output = next(found for found in tree.nodes if found.type == 'OUTPUT_MATERIAL')
    link(shown.outputs[0], (output if end == 'Surface' else emission).inputs[end])
    found = Values(read(material), {'position': color})
    numbers = {'color': shader_reading.LUMINANCE @ color, 'vector': color.mean(), 'float': 0.9}
    expected = color if end != 'Strength' and start != 'float' else np.full(3, numbers[start])
    assert found.emission() == pytest.approx(expected, rel=1e-6)


def test_unlinked_vectors_stand_for_coordinates() -> None:
    assert 'generated' in read(emitted('TexNoise')[0]).ops
    image = bpy.data.images.new('Image', 2, 2)
    assert 'attribute' in read(emitted('TexImage', image=image)[0]).ops
    environment = read(emitted('TexEnvironment', image=image)[0])
    assert environment.ops == ['position', 'environment_v']
    # White noise takes the value that is typed in, as in Cycles.
    assert read(emitted('TexWhiteNoise', 'Color')[0]).ops == ['white_noise_v']


# ---- Bumps.


def bumped(height: Callable[[bpy.types.NodeTree], bpy.types.NodeSocket]) -> tuple[bpy.types.Material, bpy.types.Node]:
    material, _ = new_material()
    tree = material.node_tree
    output = next(found for found in tree.nodes if found.type == 'OUTPUT_MATERIAL')
    bump, diffuse = node(tree, 'Bump'), node(tree, 'BsdfDiffuse')
    link(height(tree), bump.inputs['Height'])
    link(bump.outputs[0], diffuse.inputs['Normal'])
    link(diffuse.outputs[0], output.inputs['Surface'])
    return material, bump


def test_a_bump_asks_for_heights_aside() -> None:
    """Height x² at x = 2, one pixel being 0.25 in x: a step of a tenth of it, and what is the same is there once."""

    def height(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        square, parts = node(tree, 'Math', operation='MULTIPLY'), node(tree, 'SeparateXYZ')
        link(node(tree, 'NewGeometry').outputs['Position'], parts.inputs[0])
        link(parts.outputs[0], square.inputs[0])
        link(parts.outputs[0], square.inputs[1])
        return square.outputs[0]

    material, bump = bumped(height)
    bump.inputs['Distance'].default_value = 0.5
    width = 0.1 if 'Filter Width' in bump.inputs else 1.0
    if width != 1.0:
        bump.inputs['Filter Width'].default_value = width
    given = {
        'position': lambda step: np.array((2.0 + 0.25 * step[0], 0.0, 0.0)),
        'normal': (0, 0, 1),
        'bump': (0, 0, 1),
    }
    found = Values(read(material), given)
    assert sorted(mode >> 30 for mode in found.read.modes('position')) == [0, 1, 2]
    index = found.read.ops.index('bump')
    count = [len(shader_reading.TABLES.ops[name].arguments) for name in found.read.ops[:index]]
    refs = found.read.shader.args[sum(count) : sum(count) + 6].tolist()
    heights = [found.value(ref, 'f') for ref in refs[:5]]
    width = float(np.float16(width))  # as modes hold it
    assert heights == pytest.approx([4.0, (2.0 + 0.25 * width) ** 2, 4.0, 1.0, 0.5 / width], rel=1e-6)
    assert found.read.modes('math').count(2) == 3  # one product in each place


def test_bump_without_height_is_the_normal() -> None:
    material, _ = bumped(varying)
    assert 'bump' in read(material).ops
    material.node_tree.links.remove(next(found for found in material.node_tree.links if found.to_node.type == 'BUMP'))
    assert read(material).ops == ['normal']


def test_bumps_within_bumps() -> None:
    def height(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        inner, fresnel = node(tree, 'Bump'), node(tree, 'Fresnel')
        link(node(tree, 'TexNoise').outputs[0], inner.inputs['Height'])
        link(inner.outputs[0], fresnel.inputs['Normal'])
        return fresnel.outputs[0]

    found = read(bumped(height)[0])
    assert found.ops.count('bump') == 2 and found.ops.count('noise_f') == 3


def test_displacement_bends_every_normal() -> None:
    material, _ = new_material()
    tree = material.node_tree
    output = next(found for found in tree.nodes if found.type == 'OUTPUT_MATERIAL')
    made, diffuse = node(tree, 'Displacement'), node(tree, 'BsdfDiffuse')
    link(node(tree, 'TexNoise').outputs[0], made.inputs['Height'])
    link(made.outputs[0], output.inputs['Displacement'])
    link(diffuse.outputs[0], output.inputs['Surface'])
    found = read(material)
    assert found.ops[found.argument(0, 'normal')] == 'bump' and not found.warnings
    assert found.ops.count('noise_f') == 3
    material.displacement_method = 'DISPLACEMENT'
    assert 'displacement' in read(material).warnings[0]


# ---- Trees as drawn and as inlined.


@pytest.mark.skipif(not IS_5, reason='4.5 has no inliner')
@pytest.mark.parametrize('seed', range(40))
def test_drawn_trees_mean_what_inlined_ones_mean(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Random trees of groups, muted nodes, menus and zones: Blender's inliner is right, and our own walk agrees.

    It computes constants itself, with weights of luminance that differ from Cycles' in the fifth digit.
    """
    Forest(seed).scene()
    material = bpy.data.materials['Material']
    inlined = Values(read(material)).emission()
    monkeypatch.setattr(compat, 'inlined', lambda owner: None)
    assert Values(read(material)).emission() == pytest.approx(inlined, rel=1e-4, abs=1e-6)


# ---- Bad trees.


@pytest.mark.skipif(bpy.app.version < (5, 2), reason='vectors of two numbers are 5.2’s')
def test_a_vector_of_two_numbers_is_one_of_three() -> None:
    material, made = emitted('RadialTiling', 'Segment Coordinates')
    made.inputs['Vector'].default_value = (0.5, 0.25)
    link(varying(material.node_tree), made.inputs['Sides'])
    assert [0.5, 0.25, 0.0] in read(material).shader.constants.tolist()


def test_a_loop_is_named_and_read() -> None:
    material, emission = new_material()
    tree = material.node_tree
    made = node(tree, 'Math', name='Round')
    link(made.outputs[0], made.inputs[0])
    link(made.outputs[0], emission.inputs['Strength'])
    found = read(material)
    assert found.closures == ['emission'] and '"Round"' in found.warnings[0]


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_values_that_are_no_numbers(bad: float) -> None:
    material, emission = new_material()
    emission.inputs['Strength'].default_value = bad
    if math.isfinite(emission.inputs['Strength'].default_value):
        pytest.skip('Blender does not take it')
    found = read(material)
    assert np.isfinite(found.shader.constants).all()
    assert 'Strength' in found.warnings[0] and f'"{emission.name}"' in found.warnings[0]


def test_a_group_without_a_tree() -> None:
    material, emission = new_material()
    made = node(material.node_tree, 'Group')
    made.node_tree = group('Gone', ('Float',), ('Float',), flat_scenes.through)
    link(made.outputs[0], emission.inputs['Strength'])
    bpy.data.node_groups.remove(made.node_tree)
    assert read(material).closures == ['emission']


def test_images_that_are_missing_are_named() -> None:
    material, _ = emitted('TexImage', name='Picture')
    found = Values(read(material))
    assert found.emission().tolist() == [1.0, 0.0, 1.0]
    assert found.read.warnings == ['node "Picture": no image is chosen']


def chain(steps: int) -> bpy.types.Material:
    """A line of nodes: groups of a hundred, of which each is within the next, since Blender links slowly."""
    material, emission = new_material()

    def hundred(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        at = start.outputs[0]
        for _ in range(100):
            made = node(tree, 'Math', operation='ADD')
            made.inputs[1].default_value = 0.5
            tree.links.new(at, made.inputs[0])
            at = made.outputs[0]
        tree.links.new(at, end.inputs[0])

    inner = group('Hundred', ('Float',), ('Float',), hundred)
    at = varying(material.node_tree)
    for _ in range(steps // 100):
        made = node(material.node_tree, 'Group', node_tree=inner)
        link(at, made.inputs[0])
        at = made.outputs[0]
    link(at, emission.inputs['Strength'])
    return material


@pytest.mark.parametrize('is_drawn', [False, True])
def test_ten_thousand_nodes_in_a_line(is_drawn: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    material = chain(10_000)
    if is_drawn:
        monkeypatch.setattr(compat, 'inlined', lambda owner: None)
    found = read(material)
    assert found.ops.count('math') == 10_000 and not found.warnings
    assert Values(found, {'backfacing': 1.0}).emission() == pytest.approx(np.full(3, 5001.0))


def test_groups_within_groups_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten groups, each twice within the next, and a lower limit, since Blender itself is slow to nest them."""
    monkeypatch.setattr(shader, 'NODES_MAX', 1000)

    def doubled(inner: bpy.types.NodeTree) -> Callable:
        def fill(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
            both = node(tree, 'Math')
            for index in range(2):
                made = node(tree, 'Group', node_tree=inner)
                tree.links.new(start.outputs[0], made.inputs[0])
                tree.links.new(made.outputs[0], both.inputs[index])
            tree.links.new(both.outputs[0], end.inputs[0])

        return fill

    inner = group('Group', ('Float',), ('Float',), flat_scenes.through)
    for _ in range(10):
        inner = group('Group', ('Float',), ('Float',), doubled(inner))
    material, emission = new_material()
    made = node(material.node_tree, 'Group', node_tree=inner)
    link(varying(material.node_tree), made.inputs[0])
    link(made.outputs[0], emission.inputs['Strength'])
    found = read(material)
    assert found.closures == ['diffuse'] and 'nodes' in found.warnings[0]


def test_ten_thousand_mixes() -> None:
    def hundred(tree: bpy.types.NodeTree, start: bpy.types.Node, end: bpy.types.Node) -> None:
        at = start.outputs[0]
        for _ in range(100):
            made = node(tree, 'MixShader')
            tree.links.new(start.outputs[1], made.inputs[0])
            tree.links.new(at, made.inputs[1])
            tree.links.new(start.outputs[0], made.inputs[2])
            at = made.outputs[0]
        tree.links.new(at, end.inputs[0])

    inner = group('Hundred', ('Shader', 'Float'), ('Shader',), hundred)
    material, emission = new_material()
    tree = material.node_tree
    at = emission.outputs[0]
    for _ in range(100):
        made = node(tree, 'Group', node_tree=inner)
        link(at, made.inputs[0])
        link(varying(tree), made.inputs[1])
        at = made.outputs[0]
    link(at, next(found for found in tree.nodes if found.type == 'OUTPUT_MATERIAL').inputs['Surface'])
    found = Values(read(material), {'backfacing': 0.25})
    assert found.read.closures == ['emission']
    assert found.weight(0)[0] == pytest.approx(1.0)


def test_equal_materials_are_equal() -> None:
    first, second = (emitted('TexNoise')[0] for _ in range(2))
    assert read(first).draft.key == read(second).draft.key
    second.node_tree.nodes['Noise Texture'].inputs['Scale'].default_value = 9.0
    assert read(first).draft.key != read(second).draft.key


def test_reading_is_fast() -> None:
    """Two hundred materials of sixty nodes are to be read in well under a second: here are six, by processor time."""
    materials = [chain(0) for _ in range(6)]
    for material in materials:
        tree, at = material.node_tree, varying(material.node_tree)
        for _ in range(60):
            made = node(tree, 'Mix', data_type='RGBA')
            link(at, made.inputs['Factor_Float' if 'Factor_Float' in made.inputs else 0])
            at = made.outputs['Result_Color' if 'Result_Color' in made.outputs else 2]
        link(at, next(found for found in tree.nodes if found.type == 'EMISSION').inputs['Color'])
    start = time.process_time()
    found: list[Read] = [read(material) for material in materials]
    assert time.process_time() - start < 6 * 0.03
    assert all(one.ops.count('mix_color') == 60 for one in found)


def test_others_materials_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """Materials by others: the walk through groups agrees with the inliner about closures and layers."""
    folder = Path(__file__).resolve().parents[2] / 'shared' / 'materials'
    files = sorted(folder.glob('*.blend'))
    if not files or not IS_5:
        pytest.skip('there are no materials by others, or they are too new')
    inline = compat.inlined
    for path in files:
        bpy.ops.wm.open_mainfile(filepath=str(path))
        for material in bpy.data.materials:
            monkeypatch.setattr(compat, 'inlined', inline)
            found = read(material)
            monkeypatch.setattr(compat, 'inlined', lambda owner: None)
            drawn = read(material)
            assert set(found.closures) <= set(drawn.closures), path
            assert {name for _, name in found.draft.named} == {name for _, name in drawn.draft.named}, path
