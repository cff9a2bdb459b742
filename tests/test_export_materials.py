# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader trees become constants where they can, sums of closures where not, and what cannot be rendered is named.

Values of nodes are test_ops_cycles.py's. What is expected of Mix, Add and the default material was measured with
Cycles 5.2.3.
"""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from cotorra.log import Log

from scenes import build
from scenes.depsgraphs import exported
from scenes.materials import shown
from shaders import PRINCIPLED, ops

pytestmark = pytest.mark.usefixtures('engine')


def tree_of(material: bpy.types.Material) -> tuple[bpy.types.NodeTree, bpy.types.NodeSocket]:
    """The tree, and the Surface input of its output."""
    return material.node_tree, build.output(material.node_tree).inputs['Surface']


# ---- Principled BSDF.


def test_new_material_and_no_material_are_alike() -> None:
    build.new_scene()
    made, default = shown(build.material('Made')), shown(None)
    assert not made.warnings and default.name == 'default material'
    assert made.constants == default.constants
    assert made['base_color'] == pytest.approx([0.8] * 3) and made['roughness'] == 0.5 and made['alpha'] == 1.0


def test_principled_constants() -> None:
    build.new_scene()
    material = build.material(
        'Full',
        Base_Color=(0.1, 0.2, 0.3, 1),
        Metallic=0.25,
        Roughness=0.75,
        IOR=1.25,
        Specular_IOR_Level=0.125,
        Specular_Tint=(0.5, 0.25, 1, 1),
        Emission_Color=(1, 0.5, 0.25, 1),
        Emission_Strength=8,
        Alpha=0.5,
    )
    material.pass_index = 3
    found = shown(material)
    assert found.constants == {
        'base_color': pytest.approx([0.1, 0.2, 0.3]),
        'metallic': 0.25,
        'roughness': 0.75,
        'ior': 1.25,
        'specular_level': 0.125,
        'specular_tint': [0.5, 0.25, 1],
        'emission': [8, 4, 2],
        'alpha': 0.5,
        'transmission': 0.0,
        'multi_ggx': True,
    }
    assert found.buffers.materials.pass_index.tolist() == [0, 3] and found.name == 'Full' and not found.warnings


def test_dtypes() -> None:
    buffers = exported(build.new_scene())
    materials = buffers.materials
    assert materials.pass_index.dtype == materials.shader.dtype == np.int32
    assert materials.emission_sampling.dtype == np.uint32 and materials.shader.tolist() == [-1]


def test_values_are_clamped_as_by_cycles() -> None:
    build.new_scene()
    found = shown(build.material(Base_Color=(-1, 2, 0, 1), Emission_Color=(1, 1, 1, 1), Emission_Strength=-2))
    assert found['base_color'] == [0, 2, 0] and found['emission'] == [-2, -2, -2]


@pytest.mark.parametrize(('distribution', 'flag'), [('GGX', 0), ('MULTI_GGX', 1)])
def test_distribution(distribution: str, flag: int) -> None:
    build.new_scene()
    material = build.material()
    build.principled(material).distribution = distribution
    assert shown(material)['multi_ggx'] == flag


@pytest.mark.parametrize('sampling', ['NONE', 'AUTO', 'FRONT', 'BACK', 'FRONT_BACK'])
def test_emission_sampling(sampling: str) -> None:
    build.new_scene()
    material = build.material()
    material.cycles.emission_sampling = sampling
    assert shown(material).buffers.materials.emission_sampling[1] == (0 if sampling == 'NONE' else 1)


def test_what_principled_cannot_do_yet_is_one_warning() -> None:
    build.new_scene()
    material = build.material(Transmission_Weight=1.0, Coat_Weight=0.5, Sheen_Weight=0.1, Subsurface_Weight=0.5)
    (warning,) = shown(material).warnings
    assert warning.startswith('Material "Material": node "Principled BSDF": subsurface scattering is not supported yet')


def test_what_no_constants_can_say_is_a_closure() -> None:
    build.new_scene()
    found = shown(build.material(Transmission_Weight=1.0, Coat_Weight=0.5, Sheen_Weight=0.25))
    assert not {'base_color', 'roughness'} & found.constants.keys()
    (closure,) = found.closures
    values = dict(zip(PRINCIPLED, closure.args, strict=True))
    assert closure.name == 'principled' and not found.warnings
    assert (values['transmission'][0], values['coat'][0], values['sheen'][0]) == (1.0, 0.5, 0.25)


# ---- Constants through nodes.


def test_constant_nodes_are_followed() -> None:
    build.new_scene()
    material = build.material()
    tree, node = material.node_tree, build.principled(material)
    color, value = build.node(tree, 'RGB'), build.node(tree, 'Value')
    reroute = tree.nodes.new('NodeReroute')
    color.outputs[0].default_value = (0.25, 0.5, 0.75, 1)
    value.outputs[0].default_value = 0.125
    build.connect(tree, color.outputs[0], reroute.inputs[0])
    build.connect(tree, reroute.outputs[0], node.inputs['Base Color'])
    build.connect(tree, value.outputs[0], node.inputs['Roughness'])
    build.connect(tree, value.outputs[0], node.inputs['Specular Tint'])
    build.connect(tree, color.outputs[0], node.inputs['Metallic'])
    found = shown(material)
    assert found['base_color'] == [0.25, 0.5, 0.75] and found['roughness'] == 0.125
    assert found['specular_tint'] == [0.125] * 3
    assert found['metallic'] == pytest.approx(0.2126 * 0.25 + 0.7152 * 0.5 + 0.0722 * 0.75, abs=1e-4)
    assert not found.warnings


def group_with(tree: bpy.types.NodeTree, name: str, kind: str) -> tuple[bpy.types.NodeTree, bpy.types.Node]:
    inner = bpy.data.node_groups.new(name, 'ShaderNodeTree')
    inner.interface.new_socket('Color', in_out='INPUT', socket_type='NodeSocketColor').default_value = (1, 0, 0, 1)
    inner.interface.new_socket('Out', in_out='OUTPUT', socket_type=kind)
    group = tree.nodes.new('ShaderNodeGroup')
    group.node_tree = inner
    return inner, group


@pytest.mark.parametrize('linked', [False, True])
def test_groups_are_looked_into(linked: bool) -> None:
    """A whole shader in a group in a group, whose colour comes from outside."""
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    middle, outer_group = group_with(tree, 'Middle', 'NodeSocketShader')
    inner, inner_group = group_with(middle, 'Inner', 'NodeSocketShader')
    for owner in (middle, inner):
        owner.nodes.new('NodeGroupInput').name = 'In'
        owner.nodes.new('NodeGroupOutput').name = 'Out'
    shader = build.node(inner, 'BsdfPrincipled', Roughness=0.25)
    build.connect(inner, inner.nodes['In'].outputs[0], shader.inputs['Base Color'])
    build.connect(inner, shader.outputs[0], inner.nodes['Out'].inputs[0])
    build.connect(middle, middle.nodes['In'].outputs[0], inner_group.inputs[0])
    build.connect(middle, inner_group.outputs[0], middle.nodes['Out'].inputs[0])
    build.connect(tree, outer_group.outputs[0], surface)
    outer_group.inputs[0].default_value = (0.25, 0.5, 0.75, 1)
    if linked:
        color = build.node(tree, 'RGB')
        color.outputs[0].default_value = (0, 0, 1, 1)
        build.connect(tree, color.outputs[0], outer_group.inputs[0])
    found = shown(material)
    assert found['base_color'] == ([0, 0, 1] if linked else [0.25, 0.5, 0.75])
    assert found['roughness'] == 0.25 and not found.warnings


def test_muted_nodes_and_links() -> None:
    build.new_scene()
    material = build.material(Roughness=0.25)
    tree, node = material.node_tree, build.principled(material)
    color = build.node(tree, 'RGB')
    color.outputs[0].default_value = (0.25, 0.5, 0.75, 1)
    gamma = build.node(tree, 'Gamma')
    gamma.mute = True  # passes the colour on
    build.connect(tree, color.outputs[0], gamma.inputs['Color'])
    build.connect(tree, gamma.outputs[0], node.inputs['Base Color'])
    value = build.node(tree, 'Value')
    tree.links.new(value.outputs[0], node.inputs['Roughness']).is_muted = True
    found = shown(material)
    assert found['base_color'] == [0.25, 0.5, 0.75] and found['roughness'] == 0.25 and not found.warnings


def test_a_node_that_is_not_read_is_one_warning_and_the_sockets_own_values() -> None:
    build.new_scene()
    material = build.material(Base_Color=(0.5, 0.25, 0.125, 1), Roughness=0.75, Emission_Strength=1)
    tree, node = material.node_tree, build.principled(material)
    unread = build.node(tree, 'ShaderToRGB')
    for name in ('Base Color', 'Roughness'):
        build.connect(tree, unread.outputs['Color'], node.inputs[name])
    found = shown(material)
    assert found['base_color'] == [0.5, 0.25, 0.125] and found['roughness'] == 0.75
    assert found.warnings == ['Material "Material": node "Shader to RGB": Cycles does not render it either']


@pytest.mark.parametrize('case', ['no image', 'no file'])
def test_missing_image(case: str) -> None:
    """Magenta, as Cycles shows it, and a warning that names the material, the node and the file."""
    build.new_scene()
    material = build.material()
    tree = material.node_tree
    texture = build.node(tree, 'TexImage')
    if case == 'no file':
        texture.image = bpy.data.images.new('Photo', 4, 4)
        texture.image.source = 'FILE'
        texture.image.filepath = '//nowhere/photo.png'
    build.connect(tree, texture.outputs['Color'], build.principled(material).inputs['Base Color'])
    found = shown(material)
    assert found['base_color'] == [1, 0, 1]
    expected = 'no image is chosen' if case == 'no image' else 'image "Photo" has no file at "//nowhere/photo.png"'
    assert f'Material "Material": node "Image Texture": {expected}' in found.warnings


def test_image_that_is_there_is_not_called_missing(tmp_path) -> None:
    build.new_scene()
    material = build.material()
    tree = material.node_tree
    texture = build.node(tree, 'TexImage')
    image = bpy.data.images.new('Photo', 4, 4)
    image.filepath_raw, image.file_format = str(tmp_path / 'photo.png'), 'PNG'
    image.save()
    texture.image = bpy.data.images.load(str(tmp_path / 'photo.png'))
    build.connect(tree, texture.outputs['Color'], build.principled(material).inputs['Base Color'])
    assert not any('Photo' in warning for warning in shown(material).warnings)


def test_driver_that_gives_no_number() -> None:
    build.new_scene()
    material = build.material('Driven', Metallic=0.5)
    build.principled(material).inputs['Roughness'].default_value = float('nan')
    found = shown(material)
    assert found['roughness'] == 0.0 and found['metallic'] == 0.5
    assert found.warnings == ['Material "Driven": node "Principled BSDF": Roughness is not a finite number: 0 is used']


def test_number_that_is_too_large_is_told_in_words() -> None:
    build.new_scene()
    found = shown(build.material('Bright', **{'Base Color': (3e38, 1.0, 1.0, 1.0)}))
    told = 'node "Principled BSDF": Base Color is beyond what can be rendered: 1e+15 is used'
    assert found.warnings == [f'Material "Bright": {told}']


# ---- Other shaders, and sums of them.


def test_diffuse() -> None:
    """No reflection: F0 is 0 whatever formula is used for it."""
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    build.connect(tree, build.node(tree, 'BsdfDiffuse', Color=(0.25, 0.5, 0.75, 1)).outputs[0], surface)
    found = shown(material)
    assert found['base_color'] == [0.25, 0.5, 0.75] and not found.warnings
    assert (found['metallic'], found['specular_level'], found['ior']) == (0, 0, 1)


@pytest.mark.skipif(not hasattr(bpy.types, 'ShaderNodeBsdfMetallic'), reason='this Blender has no Metallic BSDF')
def test_metallic() -> None:
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    metal = build.node(
        tree, 'BsdfMetallic', Base_Color=(0.5, 0.25, 0.125, 1), Edge_Tint=(1, 0.5, 0.75, 1), Roughness=0.25
    )
    metal.fresnel_type, metal.distribution = 'F82', 'GGX'
    build.connect(tree, metal.outputs[0], surface)
    found = shown(material)
    (closure,) = found.closures
    assert closure.name == 'metallic' and closure.mode == 0 and not found.warnings
    assert closure.args[:2] == ((0.5, 0.25, 0.125), (1.0, 0.5, 0.75)) and closure.args[4] == (0.25,) * 3


def test_glossy() -> None:
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    glossy = build.node(tree, 'BsdfAnisotropic', Color=(0.5, 0.25, 0, 1), Roughness=0.25)
    build.connect(tree, glossy.outputs[0], surface)
    found = shown(material)
    (closure,) = found.closures
    assert closure.name == 'glossy' and not found.warnings
    assert closure.args[:3] == ((0.5, 0.25, 0.0), (0.25,) * 3, (0.0,) * 3)


def test_emission_only() -> None:
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    build.connect(tree, build.node(tree, 'Emission', Color=(1, 0.5, 0.25, 1), Strength=4).outputs[0], surface)
    found = shown(material)
    assert found['emission'] == [4, 2, 1] and found['alpha'] == 1 and not found.warnings
    assert found['base_color'] == [0, 0, 0] and found['specular_level'] == 0


def mixed(kind: str, first: bpy.types.Node, second: bpy.types.Node, factor: float = 0.25) -> bpy.types.Node:
    tree = first.id_data
    node = build.node(tree, f'{kind}Shader')
    if kind == 'Mix':
        node.inputs[0].default_value = factor
    build.connect(tree, first.outputs[0], node.inputs[-2])
    build.connect(tree, second.outputs[0], node.inputs[-1])
    return node


def test_mix_with_transparent_is_alpha() -> None:
    build.new_scene()
    material = build.material(Alpha=0.5, Emission_Color=(1, 1, 1, 1), Emission_Strength=2, Metallic=0.5)
    tree, surface = tree_of(material)
    mix = mixed('Mix', build.node(tree, 'BsdfTransparent'), build.principled(material))
    build.connect(tree, mix.outputs[0], surface)
    found = shown(material)
    assert (
        found['alpha'] == 0.125 and found['emission'] == [2, 2, 2] and found['metallic'] == 0.5 and not found.warnings
    )


def test_mix_of_emission_and_diffuse() -> None:
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    mix = mixed(
        'Mix', build.node(tree, 'Emission', Strength=8), build.node(tree, 'BsdfDiffuse', Color=(1, 0.5, 0, 1)), 0.25
    )
    build.connect(tree, mix.outputs[0], surface)
    found = shown(material)
    assert found['emission'] == [6, 6, 6] and found['base_color'] == [0.25, 0.125, 0] and not found.warnings


def test_add_emission_to_principled() -> None:
    build.new_scene()
    material = build.material(Metallic=1.0, Emission_Color=(1, 0, 0, 1), Emission_Strength=1)
    tree, surface = tree_of(material)
    both = mixed('Add', build.node(tree, 'Emission', Strength=2), build.principled(material))
    build.connect(tree, both.outputs[0], surface)
    found = shown(material)
    assert found['emission'] == [3, 2, 2] and found['metallic'] == 1 and not found.warnings


@pytest.mark.parametrize(('factor', 'weights'), [(0.0, [1.0]), (1.0, [1.0]), (0.75, [0.25, 0.75])])
def test_mix_of_two_bsdfs(factor: float, weights: list[float]) -> None:
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    other = build.node(tree, 'BsdfPrincipled', Metallic=1.0)
    build.connect(tree, mixed('Mix', build.principled(material), other, factor).outputs[0], surface)
    found = shown(material)
    assert [closure.weight for closure in found.closures] == [(weight,) * 3 for weight in weights]
    assert [closure.args[1][0] for closure in found.closures] == ([0.0, 1.0] if 0.0 < factor < 1.0 else [factor])
    assert not found.warnings


def test_one_sided_emission() -> None:
    """As importers make it: Mix by Geometry's Backfacing. What it looks like is test_textures.py's."""
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    mix = mixed('Mix', build.node(tree, 'Emission', Strength=4), build.node(tree, 'BsdfDiffuse', Color=(0, 0, 0, 1)))
    build.connect(tree, build.node(tree, 'NewGeometry').outputs['Backfacing'], mix.inputs[0])
    build.connect(tree, mix.outputs[0], surface)
    found = shown(material)
    assert 'backfacing' in ops(found.shader)
    assert found['emission'] == [4, 4, 4] and found['base_color'] == [0, 0, 0]
    assert found.warnings == []


def test_back_faces_of_another_colour() -> None:
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    red, blue = (build.node(tree, 'BsdfDiffuse', Color=color) for color in ((1, 0, 0, 1), (0, 0, 1, 1)))
    mix = mixed('Mix', red, blue)
    build.connect(tree, build.node(tree, 'NewGeometry').outputs['Backfacing'], mix.inputs[0])
    build.connect(tree, mix.outputs[0], surface)
    found = shown(material)
    assert [closure.args[0] for closure in found.closures] == [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    assert 'backfacing' in ops(found.shader) and not found.warnings


def test_unsupported_shader_is_left_out() -> None:
    build.new_scene()
    material = build.material()
    tree, surface = tree_of(material)
    both = mixed('Add', build.node(tree, 'Emission', Strength=2), build.node(tree, 'VolumeScatter'))
    build.connect(tree, both.outputs[0], surface)
    found = shown(material)
    assert found['emission'] == [2, 2, 2] and [closure.name for closure in found.closures] == ['emission']
    assert found.warnings == ['Material "Material": node "Volume Scatter": volumes are not supported yet: left out']


def test_volume_and_displacement_are_reported() -> None:
    build.new_scene()
    material = build.material()
    material.displacement_method = 'DISPLACEMENT'
    tree, _ = tree_of(material)
    output = build.output(tree)
    build.connect(tree, build.node(tree, 'VolumeScatter').outputs[0], output.inputs['Volume'])
    build.connect(tree, build.node(tree, 'Displacement').outputs[0], output.inputs['Displacement'])
    assert shown(material).warnings == [
        'Material "Material": displacement is not supported yet: it is a bump map',
        'Material "Material": volumes are not supported yet: left out',
    ]


def test_output_for_cycles_goes_first() -> None:
    build.new_scene()
    material = build.material()
    tree, _ = tree_of(material)
    output = build.node(tree, 'OutputMaterial')
    output.target = 'CYCLES'
    build.connect(tree, build.node(tree, 'Emission', Strength=2).outputs[0], output.inputs['Surface'])
    assert shown(material)['emission'] == [2, 2, 2]


@pytest.mark.parametrize('how', ['nothing linked', 'no output'])
def test_tree_without_a_surface_is_black(how: str) -> None:
    build.new_scene()
    material = build.material()
    tree, _ = tree_of(material)
    tree.nodes.remove(build.principled(material) if how == 'nothing linked' else build.output(tree))
    found = shown(material)
    assert (
        found['base_color'] == [0, 0, 0]
        and found['emission'] == [0, 0, 0]
        and found['alpha'] == 1
        and not found.warnings
    )


@pytest.mark.skipif(bpy.app.version >= (5, 0, 0), reason='Blender 5 gives each material a tree')
def test_material_without_nodes_shows_its_viewport_colour() -> None:
    build.new_scene()
    material = bpy.data.materials.new('Plain')
    material.use_nodes = False
    material.diffuse_color = (0.25, 0.5, 0.75, 1)
    found = shown(material)
    assert found['base_color'] == [0.25, 0.5, 0.75] and found['specular_level'] == 0


# ---- Slots.


def test_slots_linked_to_the_object() -> None:
    scene = build.new_scene()
    data = build.mesh()
    data.materials.append(build.material('Of the data'))
    build.link(scene, 'First', data)
    second = build.link(scene, 'Second', data)
    second.material_slots[0].link = 'OBJECT'
    second.material_slots[0].material = build.material('Of the object')
    buffers = exported(scene)
    names = [buffers.materials.names[buffers.material_slots[base]] for base in buffers.instances.material_base]
    assert dict(zip(buffers.instances.names, names, strict=True)) == {
        'First': 'Of the data',
        'Second': 'Of the object',
    }
    assert len(buffers.meshes) == 1


def test_removed_and_empty_slots_show_the_default() -> None:
    scene = build.new_scene()
    obj = build.mesh_object(scene)
    gone = build.material('Gone')
    obj.data.materials.append(gone)
    obj.data.materials.append(build.material('Kept'))
    bpy.data.materials.remove(gone)
    buffers = exported(scene)
    assert [buffers.materials.names[slot] for slot in buffers.material_slots] == ['default material', 'Kept']


def test_each_material_is_read_once() -> None:
    scene = build.new_scene()
    material = build.material('Shared', Subsurface_Weight=1.0)
    for index in range(3):
        build.mesh_object(scene, f'Quad{index}').data.materials.append(material)
    log = Log()
    buffers = exported(scene, log)
    assert buffers.materials.names == ('default material', 'Shared') and buffers.material_slots.tolist() == [1]
    assert len(log.texts('WARNING')) == 1
