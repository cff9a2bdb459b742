# SPDX-License-Identifier: GPL-3.0-or-later
"""Each node becomes the ops that it means: every type that Blender registers, numbers of choices, tables, mappings.

What ops compute is tested with the kernels, how nodes are put together in test_shader_reader.py.
"""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat
from cotorra.shader import CLOSURES, NEAREST, NOT_SUPPORTED, STRUCTURE, VALUES
from cotorra.shader.explain import unfolded
from cotorra.shader.nodes_texture import mapping_matrix

import shader_reading
from flat_scenes import node
from scenes import build
from shader_reading import Values, emitted, link, new_material, read, varying

BASES = frozenset(('ShaderNode', 'ShaderNodeTree'))
TYPES = sorted(name for name in dir(bpy.types) if name.startswith('ShaderNode') and name not in BASES)


@pytest.fixture(autouse=True)
def empty(engine: None) -> None:
    build.new_scene()


# ---- Every node.


@pytest.mark.parametrize('kind', TYPES)
def test_every_node_is_read_or_named(kind: str) -> None:
    assert kind in VALUES or kind in CLOSURES or kind in NOT_SUPPORTED or kind in STRUCTURE
    assert not (kind in NOT_SUPPORTED and (kind in CLOSURES))


@pytest.mark.parametrize('kind', [kind for kind in TYPES if kind != 'ShaderNodeCustomGroup'])
def test_every_output_is_read(kind: str) -> None:
    """Whatever a node's choices are: each output gives one value, or the node is named."""
    material, emission = new_material()
    made = material.node_tree.nodes.new(kind)
    surface = next(found for found in material.node_tree.nodes if found.type == 'OUTPUT_MATERIAL').inputs['Surface']
    for index in range(len(made.outputs)):
        for choice in choices(made):
            setattr(made, *choice)
            if not made.outputs[index].enabled or made.outputs[index].type == 'CUSTOM':
                continue
            is_shader = made.outputs[index].type == 'SHADER'
            link(made.outputs[index], surface if is_shader else emission.inputs['Color'])
            found = read(material)
            if kind in NOT_SUPPORTED:
                assert any(f'"{made.name}"' in text for text in found.warnings)
            elif kind in CLOSURES:
                assert len(found.closures) == 1
            elif kind in VALUES:
                assert not any('is not supported' in text for text in found.warnings) or kind in NEARLY
                assert found.closures == ['emission']
            told = unfolded(found.draft.resolved({name: 0 for _, name in found.draft.named}), shader_reading.TABLES)
            assert len(told.rows) == len(found.ops) + len(found.closures)


# A mix of rotations is named; Blender does not let one choose it.
NEARLY = frozenset((*NEAREST, 'ShaderNodeTexSky', 'ShaderNodeMix'))


def test_the_readme_says_what_is_not_read() -> None:
    lines = (Path(__file__).resolve().parent.parent / 'README.md').read_text().splitlines()
    for kind, why in (NOT_SUPPORTED | NEAREST).items():
        known = getattr(bpy.types, kind, None)
        if known is not None:
            assert any(known.bl_rna.name in line and why in line for line in lines if line[:1] == '|'), kind


def choices(made: bpy.types.Node) -> list[tuple[str, object]]:
    """All values of the node's own enumerations and switches, one property after the other."""
    known = {prop.identifier for prop in bpy.types.Node.bl_rna.properties}
    found: list[tuple[str, object]] = [('name', made.name)]
    for prop in made.bl_rna.properties:
        if prop.identifier in known or prop.is_readonly:
            continue
        if prop.type == 'ENUM':
            found += [(prop.identifier, item.identifier) for item in prop.enum_items if item.identifier not in FOREIGN]
        elif prop.type == 'BOOLEAN':
            found += [(prop.identifier, True), (prop.identifier, False)]
    return found


FOREIGN = frozenset(('ROTATION', 'RANDOM_WALK_LEGACY'))  # choices that shader nodes refuse


# ---- Numbers of choices.


@pytest.mark.parametrize('kind', ['Math', 'VectorMath', 'MixRGB', 'Mix'])
def test_operations_are_blenders_numbers(kind: str) -> None:
    name = 'operation' if 'Math' in kind else 'blend_type'
    material, made = emitted(kind)
    if kind == 'Mix':
        made.data_type = 'RGBA'
    for item in made.bl_rna.properties[name].enum_items:
        setattr(made, name, item.identifier)
        shown = next(out for out in made.outputs if out.enabled)
        inputs = [socket for socket in made.inputs if socket.enabled]
        for socket in inputs:
            link(varying(material.node_tree), socket)
        link(shown, next(found for found in material.node_tree.nodes if found.type == 'EMISSION').inputs['Color'])
        found = read(material)
        op = next(op for op in found.ops if op.startswith(('math', 'vector_math', 'mix_color')))
        assert found.modes(op)[0] & 0xFF == item.value


def test_clamps_are_bits() -> None:
    material, made = emitted('Math', use_clamp=True)
    link(varying(material.node_tree), made.inputs[0])
    assert read(material).modes('math') == [1 << 16]
    material, made = emitted('MixRGB', use_clamp=True)
    link(varying(material.node_tree), made.inputs[0])
    assert read(material).modes('mix_color') == [3 << 8]


def test_noise_types() -> None:
    material, made = emitted('TexNoise')
    order = ('MULTIFRACTAL', 'RIDGED_MULTIFRACTAL', 'HYBRID_MULTIFRACTAL', 'FBM', 'HETERO_TERRAIN')
    for number, kind in enumerate(order):
        made.noise_type, made.noise_dimensions = kind, '2D'
        assert read(material).modes('noise_f')[0] == 1 | number << 2 | made.normalize << 5


# ---- Tables.


@pytest.mark.parametrize('interpolation', ['LINEAR', 'EASE', 'CARDINAL', 'B_SPLINE', 'CONSTANT'])
@pytest.mark.parametrize('mode', ['RGB', 'HSV', 'HSL'])
def test_ramps(interpolation: str, mode: str) -> None:
    material, made = emitted('ValToRGB')
    ramp = made.color_ramp
    ramp.color_mode = mode
    if mode == 'RGB':
        ramp.interpolation = interpolation
    ramp.elements[0].color = (0.9, 0.1, 0.2, 0.5)
    ramp.elements.new(0.4).color = (0.1, 0.8, 0.3, 1.0)
    link(varying(material.node_tree), made.inputs[0])
    found = read(material)
    table = found.shader.tables.reshape(-1, 4)
    assert table.shape == (257, 4)
    for place in (0.0, 0.2, 0.4, 1.0):
        assert table[round(place * 256)] == pytest.approx(ramp.evaluate(round(place * 256) / 256), abs=1e-6)
    assert found.modes('ramp_v') == [int(ramp.interpolation == 'CONSTANT')]


def test_curves() -> None:
    material, made = emitted('RGBCurve')
    mapping = made.mapping
    mapping.curves[3].points.new(0.5, 0.8)
    mapping.curves[0].points.new(0.3, 0.1)
    mapping.extend = 'HORIZONTAL'
    mapping.update()
    link(varying(material.node_tree), made.inputs['Color'])
    found = read(material)
    table = found.shader.tables.reshape(-1, 3)
    mapping.initialize()
    for index in (0, 60, 200, 256):
        after = mapping.evaluate(mapping.curves[3], index / 256)
        expected = [mapping.evaluate(mapping.curves[channel], after) for channel in range(3)]
        assert table[index] == pytest.approx(expected, abs=1e-6)
    assert found.modes('rgb_curve_v') == [0]


def test_curves_of_one_point() -> None:
    material, made = emitted('FloatCurve')
    points = made.mapping.curves[0].points
    while len(points) > 1:
        try:
            points.remove(points[-1])
        except RuntimeError:
            break  # Blender keeps two
    made.mapping.update()
    link(varying(material.node_tree), made.inputs['Value'])
    assert np.isfinite(read(material).shader.tables).all()


def test_equal_tables_stand_once() -> None:
    material, made = emitted('ValToRGB')
    other = node(material.node_tree, 'ValToRGB')
    link(varying(material.node_tree), made.inputs[0])
    link(made.outputs[0], other.inputs[0])
    link(other.outputs[0], next(f for f in material.node_tree.nodes if f.type == 'EMISSION').inputs['Color'])
    assert len(read(material).shader.tables) == 257 * 4


# ---- A texture's own mapping.


def test_own_mapping() -> None:
    material, made = emitted('TexGradient', 'Fac')
    made.texture_mapping.scale = (2.0, 3.0, 4.0)
    made.texture_mapping.translation = (0.5, 0.0, 0.0)
    found = Values(read(material), {'generated': (1.0, 1.0, 1.0), 'gradient_f': 0.0})
    assert found.found[found.read.ops.index('affine')].tolist() == [2.5, 3.0, 4.0]


@pytest.mark.parametrize(
    ('kind', 'expected'), [('POINT', 1.2429042), ('TEXTURE', 0.3071180), ('VECTOR', 1.1429042), ('NORMAL', 0.4729163)]
)
def test_kinds_of_mapping(kind: str, expected: float) -> None:
    """The x that Cycles 5.2.3 shows of such a node, measured (of NORMAL before it is made a unit vector)."""
    matrix = mapping_matrix(kind, (0.1, 0.2, 0.3), (0.4, 0.5, 0.6), (1.5, 0.7, 1.2), ('Y', 'X', 'Z'))
    assert (matrix @ (0.3, 0.8, 0.5, 1.0))[0] == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize('output', ['Is Camera Ray', 'Ray Depth', 'Is Diffuse Ray', 'Glossy Depth'])
def test_light_by_the_kind_of_ray_is_named(output: str) -> None:
    """Samples of lights are of no kind, in Cycles as well: what is found depends on how lights are sampled."""
    asks_kind = output in ('Is Diffuse Ray', 'Glossy Depth')

    def told(owner: bpy.types.ID, made: bpy.types.Node, name: str) -> list[str]:
        tree = made.id_data
        halved = node(tree, 'Math', operation='MULTIPLY')
        link(node(tree, 'LightPath').outputs[output], halved.inputs[1])
        link(halved.outputs[0], made.inputs[name])
        return [text for text in read(owner).warnings if output in text]

    material, emission = new_material()
    assert len(told(material, emission, 'Strength')) == asks_kind
    shaded = bpy.data.materials.new('Shaded')
    surface = compat.principled(shaded)
    assert not told(shaded, surface, 'Roughness')
    mixed = node(shaded.node_tree, 'MixShader')
    link(surface.outputs[0], mixed.inputs[1])
    link(mixed.outputs[0], next(found for found in shaded.node_tree.nodes if found.type == 'OUTPUT_MATERIAL').inputs[0])
    assert not told(shaded, mixed, 'Fac' if 'Fac' in mixed.inputs else 'Factor')
    assert len(told(shaded, surface, 'Emission Strength')) == asks_kind
    world = bpy.data.worlds.new('World')
    assert len(told(world, compat.background(world), 'Strength')) == asks_kind
