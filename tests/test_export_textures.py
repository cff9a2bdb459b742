# SPDX-License-Identifier: GPL-3.0-or-later
"""Images that feed shader inputs become slots: which image, which channel, behind which affine map.

Coordinates and normals: test_export_coordinates.py; files: test_export_images.py; Cycles: test_same_textures.py.
"""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from cotorra.export import buffers as B
from cotorra.log import Log

from scenes import build
from scenes.depsgraphs import exported
from scenes.textured import between, constants, picture, show, slot, textured

LUMINANCE = (0.2126390, 0.7151687, 0.0721923)


# ---- Which input reads what.


def test_layout() -> None:
    """As the kernels' TextureSlot."""
    assert B.TEXTURE_SLOT.itemsize == 96
    offsets = [B.TEXTURE_SLOT.fields[name][1] for name in ('scale', 'threshold', 'offset', 'image', 'channel', 'flags')]
    assert offsets == [32, 44, 48, 60, 64, 84]


def test_no_image_no_textures() -> None:
    build.new_scene()
    buffers, _ = show(build.material())
    assert buffers.materials.textures is None and buffers.images == () and buffers.instances.spaces is None
    assert buffers.uv_layers == ('',) and buffers.tangent_layers == () and buffers.meshes[0].tangents is None


def test_base_color_with_all_defaults() -> None:
    build.new_scene()
    buffers, warnings = show(textured()[0])
    found = slot(buffers)
    assert found['mapping_s'].tolist() == [1, 0, 0, 0] and found['mapping_t'].tolist() == [0, 1, 0, 0]
    assert found['scale'].tolist() == [1, 1, 1] and found['offset'].tolist() == [0, 0, 0]
    assert math.isnan(found['threshold']) and found['image'] == 0 and found['channel'] == B.CHANNEL_RGB
    assert (found['coordinates'], found['uv_layer'], found['flags']) == (B.COORDINATES_UV, 0, 0)
    assert (found['interpolation'], found['extension']) == (B.INTERPOLATION_LINEAR, B.EXTENSION_REPEAT)
    assert not warnings and len(buffers.images) == 1
    assert (buffers.materials.textures.inputs[0] == -1).all()


@pytest.mark.parametrize(
    ('target', 'name', 'channel'),
    [
        ('Base Color', 'base_color', B.CHANNEL_RGB),
        ('Metallic', 'metallic', B.CHANNEL_LUMINANCE),
        ('Roughness', 'roughness', B.CHANNEL_LUMINANCE),
        ('IOR', 'ior', B.CHANNEL_LUMINANCE),
        ('Specular IOR Level', 'specular_level', B.CHANNEL_LUMINANCE),
        ('Specular Tint', 'specular_tint', B.CHANNEL_RGB),
        ('Alpha', 'alpha', B.CHANNEL_LUMINANCE),
    ],
)
def test_each_input(target: str, name: str, channel: int) -> None:
    build.new_scene()
    buffers, warnings = show(textured(target)[0])
    assert slot(buffers, name)['channel'] == channel and not warnings
    assert (buffers.materials.textures.inputs >= 0).sum() == 1


@pytest.mark.parametrize('target', ['Base Color', 'Alpha'])
def test_alpha_output(target: str) -> None:
    build.new_scene()
    buffers, _ = show(textured(target, 'Alpha')[0])
    assert slot(buffers, 'base_color' if target == 'Base Color' else 'alpha')['channel'] == B.CHANNEL_A


def test_color_is_divided_by_alpha_where_alpha_is_used_too() -> None:
    """As in Cycles: without a link to Alpha an image is shown over black."""
    build.new_scene()
    material, node = textured()
    assert slot(show(material)[0])['flags'] == 0
    build.connect(material.node_tree, node.outputs['Alpha'], build.principled(material).inputs['Alpha'])
    assert slot(show(material)[0])['flags'] == B.TEXTURE_UNASSOCIATE
    node.image.colorspace_settings.name = 'Non-Color'
    assert slot(show(material)[0])['flags'] == 0


def test_emission_color_and_constant_strength() -> None:
    build.new_scene()
    material, _ = textured('Emission Color')
    build.principled(material).inputs['Emission Strength'].default_value = 4
    buffers, warnings = show(material)
    assert slot(buffers, 'emission')['scale'].tolist() == [4, 4, 4] and not warnings
    assert buffers.materials.emission[1].tolist() == [2, 2, 2]  # mid-grey stands in: the material emits


def test_emission_strength_and_constant_color() -> None:
    build.new_scene()
    material, _ = textured('Emission Strength')
    build.principled(material).inputs['Emission Color'].default_value = (1, 0.5, 0.25, 1)
    found = slot(show(material)[0], 'emission')
    assert found['channel'] == B.CHANNEL_LUMINANCE and found['scale'].tolist() == [1, 0.5, 0.25]


def test_emission_without_strength_reads_no_image() -> None:
    build.new_scene()
    buffers, _ = show(textured('Emission Color')[0])
    assert buffers.materials.textures is None


def test_emission_of_two_images_keeps_the_color() -> None:
    build.new_scene()
    material, node = textured('Emission Color')
    build.connect(material.node_tree, node.outputs['Alpha'], build.principled(material).inputs['Emission Strength'])
    build.principled(material).inputs['Emission Strength'].default_value = 2
    buffers, warnings = show(material)
    assert slot(buffers, 'emission')['scale'].tolist() == [2, 2, 2]
    assert warnings == [
        'Material "Material": not supported yet: inputs that are no constants: '
        'Emission Strength (node "Image Texture", 2 is used)'
    ]


@pytest.mark.parametrize(('interpolation', 'code'), [('Closest', 0), ('Linear', 1), ('Cubic', 2), ('Smart', 2)])
@pytest.mark.parametrize(('extension', 'number'), [('REPEAT', 0), ('EXTEND', 1), ('CLIP', 2), ('MIRROR', 3)])
def test_interpolation_and_extension(interpolation: str, code: int, extension: str, number: int) -> None:
    build.new_scene()
    material, node = textured()
    node.interpolation, node.extension = interpolation, extension
    found = slot(show(material)[0])
    assert (found['interpolation'], found['extension']) == (code, number)


def test_projections_are_reported() -> None:
    build.new_scene()
    material, node = textured()
    node.projection = 'BOX'
    buffers, warnings = show(material)
    assert slot(buffers)['image'] == 0
    assert warnings == ['Material "Material": node "Image Texture": box projection is not supported yet: flat is used']


# ---- Sharing.


def test_one_image_however_many_materials() -> None:
    build.new_scene()
    first, node = textured()
    second, other = textured('Roughness')
    other.image = node.image
    buffers, _ = show(first, second)
    assert len(buffers.images) == 1 and len(buffers.materials.textures.slots) == 2
    third, same = textured()
    same.image = node.image
    buffers, _ = show(third)
    assert len(buffers.images) == 1 and len(buffers.materials.textures.slots) == 2
    assert sorted(buffers.materials.textures.inputs[:, 0]) == [-1, -1, 0, 0]


# ---- Values on their way.


def test_separate_color() -> None:
    """One image for roughness and metallic, as glTF packs them."""
    build.new_scene()
    material, node = textured()
    tree = material.node_tree
    parts = build.node(tree, 'SeparateColor')
    build.connect(tree, node.outputs['Color'], parts.inputs[0])
    for name, target in (('Green', 'Roughness'), ('Blue', 'Metallic'), ('Red', 'Specular Tint')):
        build.connect(tree, parts.outputs[name], build.principled(material).inputs[target])
    buffers, warnings = show(material)
    channels = [slot(buffers, name)['channel'] for name in ('roughness', 'metallic', 'specular_tint')]
    assert channels == [B.CHANNEL_G, B.CHANNEL_B, B.CHANNEL_R] and len(buffers.images) == 1 and not warnings


def test_separate_hsv_is_not_read() -> None:
    build.new_scene()
    material, node = textured()
    parts = build.node(material.node_tree, 'SeparateColor')
    parts.mode = 'HSV'
    build.connect(material.node_tree, node.outputs['Color'], parts.inputs[0])
    between(material, parts, 'Roughness')
    buffers, warnings = show(material)
    assert constants(buffers, 'roughness') == 0.5
    assert warnings == [
        'Material "Material": not supported yet: inputs that are no constants: '
        'Roughness (node "Separate Color", 0.5 is used)'
    ]


def math_chain(output: str, *steps: tuple[str, int, float], clamp: bool = False) -> bpy.types.Material:
    """Alpha through Math nodes; each step is (operation, place of the image's value, the other value)."""
    material, node = textured()
    tree, value = material.node_tree, node.outputs[output]
    for operation, place, other in steps:
        step = build.node(tree, 'Math')
        step.operation, step.use_clamp = operation, clamp
        build.connect(tree, value, step.inputs[place])
        step.inputs[1 - place].default_value = other
        value = step.outputs[0]
    build.connect(tree, value, build.principled(material).inputs['Alpha'])
    return material


@pytest.mark.parametrize(
    ('steps', 'threshold', 'scale', 'offset'),
    [
        ([('MULTIPLY', 0, 0.5)], math.nan, 0.5, 0),
        ([('ADD', 1, 0.25)], math.nan, 1, 0.25),
        ([('SUBTRACT', 1, 1.0)], math.nan, -1, 1),
        ([('DIVIDE', 0, 4.0), ('ADD', 0, 0.5)], math.nan, 0.25, 0.5),
        ([('LESS_THAN', 0, 0.25)], 0.25, -1, 1),
        ([('GREATER_THAN', 1, 0.25)], 0.25, -1, 1),
        ([('GREATER_THAN', 0, 0.5)], float(np.nextafter(np.float32(0.5), np.float32(1))), 1, 0),
        # glTF's MASK: 1 - (alpha < 0.5)
        ([('LESS_THAN', 0, 0.5), ('SUBTRACT', 1, 1.0)], 0.5, 1, 0),
        # 1 - alpha < 0.25: alpha above 0.75
        ([('SUBTRACT', 1, 1.0), ('LESS_THAN', 0, 0.25)], float(np.nextafter(np.float32(0.75), np.float32(1))), 1, 0),
        ([('LESS_THAN', 0, 0.5), ('GREATER_THAN', 0, 0.5)], 0.5, -1, 1),
    ],
)
def test_math(steps: list, threshold: float, scale: float, offset: float) -> None:
    build.new_scene()
    buffers, warnings = show(math_chain('Alpha', *steps))
    found = slot(buffers, 'alpha')
    assert found['threshold'] == pytest.approx(threshold, abs=0, nan_ok=True)
    assert found['scale'].tolist() == [scale] * 3 and found['offset'].tolist() == [offset] * 3 and not warnings


def test_less_and_greater_at_the_limit_itself() -> None:
    """LESS_THAN 0.5 of 0.5 is 0, and so is GREATER_THAN: the slot's comparison is `value < threshold`."""
    for operation in ('LESS_THAN', 'GREATER_THAN'):
        build.new_scene()
        found = slot(show(math_chain('Alpha', (operation, 0, 0.5)))[0], 'alpha')
        step = np.float32(0.5) >= found['threshold']
        assert step * found['scale'][0] + found['offset'][0] == 0


def test_clamp_that_changes_nothing() -> None:
    build.new_scene()
    buffers, warnings = show(math_chain('Alpha', ('MULTIPLY', 0, 0.5), clamp=True))
    assert slot(buffers, 'alpha')['scale'][0] == 0.5 and not warnings


@pytest.mark.parametrize('steps', [[('MULTIPLY', 0, 2.0)], [('POWER', 0, 2.0)]])
def test_what_is_not_affine_is_named(steps: list) -> None:
    build.new_scene()
    buffers, warnings = show(math_chain('Alpha', *steps, clamp=True))
    assert constants(buffers, 'alpha') == 1
    assert warnings == [
        'Material "Material": not supported yet: inputs that are no constants: Alpha (node "Math", 1 is used)'
    ]


def test_math_of_constants() -> None:
    build.new_scene()
    material = build.material()
    step = build.node(material.node_tree, 'Math')
    step.operation = 'MULTIPLY'
    step.inputs[0].default_value, step.inputs[1].default_value = 0.5, 0.25
    between(material, step, 'Roughness')
    buffers, warnings = show(material)
    assert constants(buffers, 'roughness') == 0.125 and not warnings


def mix_node(material: bpy.types.Material, blend: str, factor: float, other: tuple) -> bpy.types.Node:
    node = build.node(material.node_tree, 'Mix')
    node.data_type, node.blend_type = 'RGBA', blend
    inputs = [socket for socket in node.inputs if socket.enabled]
    inputs[0].default_value, inputs[2].default_value = factor, other
    image = next(found for found in material.node_tree.nodes if found.type == 'TEX_IMAGE')
    build.connect(material.node_tree, image.outputs['Color'], inputs[1])
    between(material, node, 'Base Color', next(socket for socket in node.outputs if socket.enabled))
    return node


@pytest.mark.parametrize(
    ('blend', 'factor', 'scale', 'offset'),
    [
        ('MULTIPLY', 1.0, [0.5, 0.25, 0], [0, 0, 0]),
        ('MULTIPLY', 0.5, [0.75, 0.625, 0.5], [0, 0, 0]),
        ('MIX', 0.25, [0.75] * 3, [0.125, 0.0625, 0]),
        ('ADD', 0.5, [1, 1, 1], [0.25, 0.125, 0]),
        ('SUBTRACT', 1.0, [1, 1, 1], [-0.5, -0.25, 0]),
    ],
)
def test_mix_with_a_constant(blend: str, factor: float, scale: list, offset: list) -> None:
    build.new_scene()
    material, _ = textured()
    mix_node(material, blend, factor, (0.5, 0.25, 0, 1))
    buffers, warnings = show(material)
    found = slot(buffers)
    assert found['scale'].tolist() == scale and found['offset'].tolist() == offset and not warnings


def test_mix_of_two_colors_by_an_image() -> None:
    build.new_scene()
    material, image = textured()
    node = build.node(material.node_tree, 'Mix')
    node.data_type = 'RGBA'
    share, first, second = (socket for socket in node.inputs if socket.enabled)
    first.default_value, second.default_value = (0.5, 0.5, 0.5, 1), (1, 0.5, 0, 1)
    build.connect(material.node_tree, image.outputs['Alpha'], share)
    between(material, node, 'Base Color', next(socket for socket in node.outputs if socket.enabled))
    found = slot(show(material)[0])
    assert found['channel'] == B.CHANNEL_A
    assert found['scale'].tolist() == [0.5, 0, -0.5] and found['offset'].tolist() == [0.5] * 3


def test_mix_with_a_node_that_has_no_share() -> None:
    build.new_scene()
    material, _ = textured()
    node = mix_node(material, 'MULTIPLY', 0.0, (1, 1, 1, 1))
    noise = build.node(material.node_tree, 'TexNoise')
    build.connect(material.node_tree, noise.outputs['Color'], [s for s in node.inputs if s.enabled][2])
    buffers, warnings = show(material)
    assert slot(buffers)['scale'].tolist() == [1, 1, 1] and not warnings


def test_what_is_not_understood_on_the_way_is_named() -> None:
    build.new_scene()
    material, _ = textured()
    node = mix_node(material, 'MULTIPLY', 1.0, (1, 1, 1, 1))
    noise = build.node(material.node_tree, 'TexNoise')
    build.connect(material.node_tree, noise.outputs['Color'], [s for s in node.inputs if s.enabled][2])
    buffers, warnings = show(material)
    assert constants(buffers, 'base_color') == pytest.approx([0.8] * 3)
    assert warnings == [
        'Material "Material": not supported yet: inputs that are no constants: '
        'Base Color (node "Noise Texture", 0.8 0.8 0.8 is used)'
    ]


def test_invert_and_combine() -> None:
    """A normal map whose green points the other way, mended by hand."""
    build.new_scene()
    material, image = textured()
    tree = material.node_tree
    parts, whole, turned = (build.node(tree, kind) for kind in ('SeparateColor', 'CombineColor', 'Invert'))
    build.connect(tree, image.outputs['Color'], parts.inputs[0])
    build.connect(tree, parts.outputs['Green'], turned.inputs['Color'])
    for index, output in enumerate((parts.outputs['Red'], turned.outputs[0], parts.outputs['Blue'])):
        build.connect(tree, output, whole.inputs[index])
    between(material, whole, 'Base Color')
    buffers, warnings = show(material)
    found = slot(buffers)
    assert found['channel'] == B.CHANNEL_RGB and not warnings
    assert found['scale'].tolist() == [1, -1, 1] and found['offset'].tolist() == [0, 1, 0]


def test_map_range_and_ramp() -> None:
    build.new_scene()
    material, image = textured()
    tree = material.node_tree
    ranged = build.node(tree, 'MapRange', To_Min=0.25, To_Max=0.75)
    build.connect(tree, image.outputs['Alpha'], ranged.inputs['Value'])
    between(material, ranged, 'Roughness')
    ramp = build.node(tree, 'ValToRGB')
    ramp.color_ramp.elements[0].color = (0.5, 0, 0, 1)
    build.connect(tree, image.outputs['Alpha'], ramp.inputs[0])
    between(material, ramp, 'Base Color')
    buffers, warnings = show(material)
    found = slot(buffers, 'roughness')
    assert (found['scale'][0], found['offset'][0]) == (0.5, 0.25) and not warnings
    found = slot(buffers)
    assert found['scale'].tolist() == [0.5, 1, 1] and found['offset'].tolist() == [0.5, 0, 0]


@pytest.mark.parametrize('how', ['reroute', 'group', 'muted'])
def test_detours(how: str) -> None:
    build.new_scene()
    material, image = textured()
    tree, target = material.node_tree, build.principled(material).inputs['Base Color']
    if how == 'group':
        inner = bpy.data.node_groups.new('Inner', 'ShaderNodeTree')
        inner.interface.new_socket('Out', in_out='OUTPUT', socket_type='NodeSocketColor')
        end = inner.nodes.new('NodeGroupOutput')
        inside = build.node(inner, 'TexImage')
        inside.image = image.image
        build.connect(inner, inside.outputs['Color'], end.inputs[0])
        group = tree.nodes.new('ShaderNodeGroup')
        group.node_tree = inner
        build.connect(tree, group.outputs[0], target)
    else:
        step = tree.nodes.new('NodeReroute') if how == 'reroute' else build.node(tree, 'Gamma')
        step.mute = how == 'muted'
        build.connect(tree, image.outputs['Color'], step.inputs[0])
        build.connect(tree, step.outputs[0], target)
    buffers, warnings = show(material)
    assert slot(buffers)['image'] == 0 and not warnings


# ---- Other shaders.


def test_mix_shader_with_transparent_by_an_image() -> None:
    build.new_scene()
    material, image = textured()
    tree = material.node_tree
    mix, clear = build.node(tree, 'MixShader'), build.node(tree, 'BsdfTransparent')
    build.connect(tree, image.outputs['Alpha'], mix.inputs[0])
    build.connect(tree, clear.outputs[0], mix.inputs[1])
    build.connect(tree, build.principled(material).outputs[0], mix.inputs[2])
    build.connect(tree, mix.outputs[0], build.output(tree).inputs['Surface'])
    buffers, warnings = show(material)
    assert slot(buffers, 'alpha')['channel'] == B.CHANNEL_A and slot(buffers)['channel'] == B.CHANNEL_RGB
    assert not warnings
    build.principled(material).inputs['Alpha'].default_value = 0.5
    assert slot(show(material)[0], 'alpha')['scale'][0] == 0.5
    tree.links.remove(mix.inputs[0].links[0])
    mix.inputs[0].default_value = 0.5
    build.connect(tree, image.outputs['Alpha'], build.principled(material).inputs['Alpha'])
    assert slot(show(material)[0], 'alpha')['scale'][0] == 0.5


@pytest.mark.parametrize(
    ('kind', 'target', 'name'),
    [
        ('BsdfDiffuse', 'Color', 'base_color'),
        ('BsdfMetallic', 'Base Color', 'base_color'),
        ('BsdfMetallic', 'Edge Tint', 'specular_tint'),
        ('BsdfAnisotropic', 'Roughness', 'roughness'),
        ('Emission', 'Color', 'emission'),
    ],
)
def test_shader(kind: str, target: str, name: str) -> None:
    if not hasattr(bpy.types, f'ShaderNode{kind}'):
        pytest.skip(f'this Blender has no {kind}')
    build.new_scene()
    material, image = textured()
    tree = material.node_tree
    shader = build.node(tree, kind)
    if kind == 'BsdfMetallic':
        shader.fresnel_type = 'F82'
    build.connect(tree, image.outputs['Color'], shader.inputs[target])
    build.connect(tree, shader.outputs[0], build.output(tree).inputs['Surface'])
    assert slot(show(material)[0], name)['image'] == 0


def test_mix_of_diffuse_with_an_image_and_a_color() -> None:
    build.new_scene()
    material, image = textured()
    tree = material.node_tree
    first, second = (build.node(tree, 'BsdfDiffuse', Color=(0.5, 0.25, 0, 1)) for _ in range(2))
    mix = build.node(tree, 'MixShader')
    mix.inputs[0].default_value = 0.25
    build.connect(tree, image.outputs['Color'], first.inputs['Color'])
    build.connect(tree, first.outputs[0], mix.inputs[1])
    build.connect(tree, second.outputs[0], mix.inputs[2])
    build.connect(tree, mix.outputs[0], build.output(tree).inputs['Surface'])
    buffers, warnings = show(material)
    found = slot(buffers)
    assert found['scale'].tolist() == [0.75] * 3 and found['offset'].tolist() == [0.125, 0.0625, 0] and not warnings


# ---- Missing images, and the world.


@pytest.mark.parametrize(
    ('target', 'output', 'name', 'expected'),
    [
        ('Base Color', 'Color', 'base_color', [1, 0, 1]),
        ('Roughness', 'Color', 'roughness', LUMINANCE[0] + LUMINANCE[2]),
        ('Alpha', 'Alpha', 'alpha', 1.0),
    ],
)
def test_no_image_is_magenta(target: str, output: str, name: str, expected: object) -> None:
    build.new_scene()
    material, node = textured(target, output)
    node.image = None
    buffers, warnings = show(material)
    assert constants(buffers, name) == pytest.approx(expected)
    assert warnings == ['Material "Material": node "Image Texture": no image is chosen']


def test_no_image_behind_math_nodes() -> None:
    build.new_scene()
    material = math_chain('Alpha', ('LESS_THAN', 0, 0.5), ('SUBTRACT', 1, 1.0))
    next(node for node in material.node_tree.nodes if node.type == 'TEX_IMAGE').image = None
    assert constants(show(material)[0], 'alpha') == 1


def test_image_in_the_world_is_not_read() -> None:
    scene = build.new_scene()
    world = build.world(scene, color=(0.5, 0.25, 0))
    node = build.node(world.node_tree, 'TexImage')
    node.image = picture()
    background = next(found for found in world.node_tree.nodes if found.type == 'BACKGROUND')
    build.connect(world.node_tree, node.outputs['Color'], background.inputs['Color'])
    log = Log()
    buffers = exported(scene, log)
    assert buffers.images == () and buffers.world.color == (0.5, 0.25, 0)
    assert 'Color (node "Image Texture", 0.5 0.25 0 is used)' in log.texts('WARNING')[0]
