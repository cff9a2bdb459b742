# SPDX-License-Identifier: GPL-3.0-or-later
"""Images that feed shader inputs: which image, how it is read, and what becomes of its values on their way.

Coordinates and normals: test_export_coordinates.py; files: test_export_images.py; Cycles: test_same_textures.py.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from cotorra import native
from cotorra.export import buffers as B
from cotorra.export.buffers import SceneBuffers

from flat_scenes import node
from scenes import build
from scenes.depsgraphs import exported
from scenes.materials import constants
from scenes.textured import TEXELS, Lookup, between, lookups, picture, seen, shining_texels, show, textured
from shaders import emission_ops

pytestmark = pytest.mark.usefixtures('engine')

LUMINANCE = np.array((0.2126390, 0.7151687, 0.0721923))
R, G, B_, A = (TEXELS[:, channel] for channel in range(4))
GREY = TEXELS[:, :3] @ LUMINANCE


def shown(buffers: SceneBuffers) -> np.ndarray:
    """What is seen of each texel, (5, 3)."""
    picture = seen(buffers)
    assert np.abs(picture - picture[0]).max() < 1e-6
    return picture[0]


def reads(buffers: SceneBuffers) -> set[str]:
    """The inputs of the material that are no constants."""
    names = {'base_color', 'metallic', 'roughness', 'ior', 'specular_level', 'specular_tint', 'emission', 'alpha'}
    return names - constants(buffers, 1).keys()


# ---- Which input reads what.


def test_no_image_no_textures() -> None:
    build.new_scene()
    buffers, _ = show(build.material())
    assert buffers.images == () and lookups(buffers) == []
    assert buffers.uv_layers == ('',) and buffers.tangent_layers == () and buffers.meshes[0].tangents is None


def test_base_color_with_all_defaults() -> None:
    build.new_scene()
    buffers, warnings = show(textured()[0])
    linear, repeat = B.INTERPOLATION_LINEAR, B.EXTENSION_REPEAT
    assert lookups(buffers) == [Lookup('image_v', 0, linear, repeat, 0, False)]
    assert not warnings and len(buffers.images) == 1


@pytest.mark.parametrize(
    'target', ['Base Color', 'Metallic', 'Roughness', 'IOR', 'Specular IOR Level', 'Specular Tint', 'Alpha']
)
def test_each_input(target: str) -> None:
    build.new_scene()
    buffers, warnings = show(textured(target)[0])
    assert len(lookups(buffers)) == 1 and not warnings
    assert ('alpha' in reads(buffers)) == (target == 'Alpha') and 'emission' not in reads(buffers)


def test_channels() -> None:
    build.new_scene()
    material, image, color = shining_texels()
    np.testing.assert_allclose(shown(show(material)[0]), TEXELS[:, :3], atol=1e-6)
    build.connect(material.node_tree, image.outputs['Alpha'], color)
    np.testing.assert_allclose(shown(exported(bpy.context.scene)), np.repeat(A[:, None], 3, 1), atol=1e-6)
    strength = material.node_tree.nodes['Shine'].inputs['Strength']
    build.connect(material.node_tree, image.outputs['Color'], strength)
    np.testing.assert_allclose(shown(exported(bpy.context.scene)), np.repeat((A * GREY)[:, None], 3, 1), atol=1e-6)


def test_color_is_divided_by_alpha_where_alpha_is_used_too() -> None:
    """As in Cycles: without a link to Alpha an image is shown over black."""
    build.new_scene()
    material, node = textured()
    assert not lookups(show(material)[0])[0].divides_by_alpha
    build.connect(material.node_tree, node.outputs['Alpha'], build.principled(material).inputs['Alpha'])
    assert all(lookup.divides_by_alpha for lookup in lookups(show(material)[0]))
    node.image.colorspace_settings.name = 'Non-Color'
    assert not any(lookup.divides_by_alpha for lookup in lookups(show(material)[0]))


def test_emission_is_color_times_strength() -> None:
    build.new_scene()
    material, image, _ = shining_texels()
    shine = material.node_tree.nodes['Shine']
    shine.inputs['Strength'].default_value = 4
    np.testing.assert_allclose(shown(show(material)[0]), 4 * TEXELS[:, :3], atol=1e-5)
    build.connect(material.node_tree, image.outputs['Alpha'], shine.inputs['Strength'])
    np.testing.assert_allclose(shown(exported(bpy.context.scene)), A[:, None] * TEXELS[:, :3], atol=1e-6)


def test_emission_without_strength_is_none() -> None:
    build.new_scene()
    buffers, _ = show(textured('Emission Color')[0])
    assert constants(buffers, 1)['emission'] == [0, 0, 0]


@pytest.mark.parametrize(('interpolation', 'code'), [('Closest', 0), ('Linear', 1), ('Cubic', 2), ('Smart', 2)])
@pytest.mark.parametrize(('extension', 'number'), [('REPEAT', 0), ('EXTEND', 1), ('CLIP', 2), ('MIRROR', 3)])
def test_interpolation_and_extension(interpolation: str, code: int, extension: str, number: int) -> None:
    build.new_scene()
    material, node = textured()
    node.interpolation, node.extension = interpolation, extension
    (found,) = lookups(show(material)[0])
    assert (found.interpolation, found.extension) == (code, number)


@pytest.mark.parametrize(('projection', 'code'), [('FLAT', 0), ('BOX', 1), ('SPHERE', 2), ('TUBE', 3)])
def test_projections(projection: str, code: int) -> None:
    build.new_scene()
    material, node = textured()
    node.projection = projection
    buffers, warnings = show(material)
    assert lookups(buffers)[0].projection == code and not warnings


# ---- Sharing.


def test_one_image_however_many_materials() -> None:
    build.new_scene()
    first, node = textured()
    second, other = textured('Roughness')
    other.image = node.image
    buffers, _ = show(first, second)
    assert len(buffers.images) == 1 and len(buffers.shaders) == 2
    third, same = textured()
    same.image = node.image
    buffers, _ = show(third)
    assert len(buffers.images) == 1 and len(buffers.shaders) == 2
    assert buffers.materials.shader.tolist() in ([-1, 0, 1, 0], [-1, 0, 0, 1], [-1, 0, 1, 1])


# ---- Values on their way.


def test_separate_color() -> None:
    """One image for several inputs, as glTF packs them."""
    for channel, output in enumerate(('Red', 'Green', 'Blue')):
        build.new_scene()
        material, image, color = shining_texels()
        tree = material.node_tree
        parts = node(tree, 'SeparateColor')
        build.connect(tree, image.outputs['Color'], parts.inputs[0])
        build.connect(tree, parts.outputs[output], color)
        buffers, warnings = show(material)
        np.testing.assert_allclose(shown(buffers), np.repeat(TEXELS[:, channel, None], 3, 1), atol=1e-6)
        assert len(buffers.images) == 1 and not warnings


def math_chain(*steps: tuple[str, int, float], clamp: bool = False) -> tuple[SceneBuffers, list[str]]:
    """Alpha through Math nodes; each step is (operation, place of the image's value, the other value)."""
    build.new_scene()
    material, image, color = shining_texels()
    tree, value = material.node_tree, image.outputs['Alpha']
    for operation, place, other in steps:
        step = node(tree, 'Math', operation=operation, use_clamp=clamp)
        build.connect(tree, value, step.inputs[place])
        step.inputs[1 - place].default_value = other
        value = step.outputs[0]
    build.connect(tree, value, color)
    return show(material)


@pytest.mark.parametrize(
    ('steps', 'clamp', 'expected'),
    [
        ([('MULTIPLY', 0, 0.5)], False, A * 0.5),
        ([('MULTIPLY', 0, 0.5)], True, A * 0.5),
        ([('MULTIPLY', 0, 2.0)], True, np.minimum(A * 2.0, 1.0)),
        ([('POWER', 0, 2.0)], False, A**2),
        ([('ADD', 1, 0.25)], False, A + 0.25),
        ([('SUBTRACT', 1, 1.0)], False, 1 - A),
        ([('DIVIDE', 0, 4.0), ('ADD', 0, 0.5)], False, A / 4 + 0.5),
        ([('LESS_THAN', 0, 0.25)], False, A < 0.25),
        ([('GREATER_THAN', 1, 0.25)], False, A < 0.25),
        # At the limit itself both are 0.
        ([('LESS_THAN', 0, 0.5)], False, A < 0.5),
        ([('GREATER_THAN', 0, 0.5)], False, A > 0.5),
        # glTF's MASK: 1 - (alpha < 0.5)
        ([('LESS_THAN', 0, 0.5), ('SUBTRACT', 1, 1.0)], False, A >= 0.5),
        ([('SUBTRACT', 1, 1.0), ('LESS_THAN', 0, 0.3)], False, A > 0.7),
    ],
)
def test_math(steps: list, clamp: bool, expected: np.ndarray) -> None:
    buffers, warnings = math_chain(*steps, clamp=clamp)
    np.testing.assert_allclose(shown(buffers), np.repeat(np.array(expected, float)[:, None], 3, 1), atol=1e-6)
    assert not warnings


def test_math_of_constants() -> None:
    build.new_scene()
    material = build.material()
    step = node(material.node_tree, 'Math', operation='MULTIPLY')
    step.inputs[0].default_value, step.inputs[1].default_value = 0.5, 0.25
    between(material, step, 'Roughness')
    buffers, warnings = show(material)
    assert constants(buffers, 1)['roughness'] == 0.125 and not warnings


def mixed(blend: str, factor: float, other: tuple) -> tuple[bpy.types.Material, bpy.types.Node]:
    build.new_scene()
    material, image, color = shining_texels()
    tree = material.node_tree
    mix = node(tree, 'Mix', data_type='RGBA', blend_type=blend)
    inputs = [socket for socket in mix.inputs if socket.enabled]
    inputs[0].default_value, inputs[2].default_value = factor, other
    build.connect(tree, image.outputs['Color'], inputs[1])
    build.connect(tree, next(socket for socket in mix.outputs if socket.enabled), color)
    return material, mix


@pytest.mark.parametrize(
    ('blend', 'factor', 'expected'),
    [
        ('MULTIPLY', 1.0, lambda a, b: a * b),
        ('MULTIPLY', 0.5, lambda a, b: a * (0.5 + 0.5 * b)),
        ('MIX', 0.25, lambda a, b: 0.75 * a + 0.25 * b),
        ('ADD', 0.5, lambda a, b: a + 0.5 * b),
        ('SUBTRACT', 1.0, lambda a, b: a - b),
    ],
)
def test_mix_with_a_constant(blend: str, factor: float, expected: Callable) -> None:
    other = (0.5, 0.25, 0, 1)
    buffers, warnings = show(mixed(blend, factor, other)[0])
    np.testing.assert_allclose(shown(buffers), expected(TEXELS[:, :3], np.array(other[:3])), atol=1e-6)
    assert not warnings


def test_mix_of_two_colors_by_an_image() -> None:
    build.new_scene()
    material, image, color = shining_texels()
    mix = node(material.node_tree, 'Mix', data_type='RGBA')
    share, first, second = (socket for socket in mix.inputs if socket.enabled)
    first.default_value, second.default_value = (0.5, 0.5, 0.5, 1), (1, 0.5, 0, 1)
    build.connect(material.node_tree, image.outputs['Alpha'], share)
    build.connect(material.node_tree, next(socket for socket in mix.outputs if socket.enabled), color)
    expected = (1 - A[:, None]) * 0.5 + A[:, None] * np.array((1, 0.5, 0))
    np.testing.assert_allclose(shown(show(material)[0]), expected, atol=1e-6)


def test_what_is_not_understood_on_the_way_is_named() -> None:
    """The input keeps its own value, and all that is known goes on."""
    material, mix = mixed('MULTIPLY', 1.0, (0.5, 0.25, 1, 1))
    unread = node(material.node_tree, 'ShaderToRGB')
    build.connect(material.node_tree, unread.outputs['Color'], [s for s in mix.inputs if s.enabled][2])
    buffers, warnings = show(material)
    np.testing.assert_allclose(shown(buffers), TEXELS[:, :3] * (0.5, 0.25, 1), atol=1e-6)
    assert warnings == ['Material "Material": node "Shader to RGB": Cycles does not render it either']


def test_invert_and_combine() -> None:
    """A normal map whose green points the other way, mended by hand."""
    build.new_scene()
    material, image, color = shining_texels()
    tree = material.node_tree
    parts, whole, turned = (build.node(tree, kind) for kind in ('SeparateColor', 'CombineColor', 'Invert'))
    build.connect(tree, image.outputs['Color'], parts.inputs[0])
    build.connect(tree, parts.outputs['Green'], turned.inputs['Color'])
    for index, output in enumerate((parts.outputs['Red'], turned.outputs[0], parts.outputs['Blue'])):
        build.connect(tree, output, whole.inputs[index])
    build.connect(tree, whole.outputs[0], color)
    buffers, warnings = show(material)
    np.testing.assert_allclose(shown(buffers), np.stack([R, 1 - G, B_], axis=1), atol=1e-6)
    assert not warnings


def test_map_range_and_ramp() -> None:
    build.new_scene()
    material, image, color = shining_texels()
    tree = material.node_tree
    ranged = build.node(tree, 'MapRange', To_Min=0.25, To_Max=0.75)
    build.connect(tree, image.outputs['Alpha'], ranged.inputs['Value'])
    build.connect(tree, ranged.outputs[0], color)
    buffers, warnings = show(material)
    np.testing.assert_allclose(shown(buffers), np.repeat(0.25 + 0.5 * A[:, None], 3, 1), atol=1e-6)
    ramp = build.node(tree, 'ValToRGB')
    ramp.color_ramp.elements[0].color = (0.5, 0, 0, 1)
    build.connect(tree, image.outputs['Alpha'], ramp.inputs[0])
    build.connect(tree, ramp.outputs[0], color)
    expected = np.stack([0.5 + 0.5 * A, A, A], axis=1)
    np.testing.assert_allclose(shown(exported(bpy.context.scene)), expected, atol=1e-5)
    assert not warnings


@pytest.mark.parametrize('how', ['reroute', 'group', 'muted'])
def test_detours(how: str) -> None:
    build.new_scene()
    material, image, color = shining_texels()
    tree = material.node_tree
    if how == 'group':
        inner = bpy.data.node_groups.new('Inner', 'ShaderNodeTree')
        inner.interface.new_socket('Out', in_out='OUTPUT', socket_type='NodeSocketColor')
        end = inner.nodes.new('NodeGroupOutput')
        inside = node(inner, 'TexImage', image=image.image, interpolation='Closest')
        build.connect(inner, inside.outputs['Color'], end.inputs[0])
        group = tree.nodes.new('ShaderNodeGroup')
        group.node_tree = inner
        build.connect(tree, group.outputs[0], color)
    else:
        step = tree.nodes.new('NodeReroute') if how == 'reroute' else build.node(tree, 'Gamma')
        step.mute = how == 'muted'
        build.connect(tree, image.outputs['Color'], step.inputs[0])
        build.connect(tree, step.outputs[0], color)
    buffers, warnings = show(material)
    np.testing.assert_allclose(shown(buffers), TEXELS[:, :3], atol=1e-6)
    assert not warnings


# ---- Other shaders.


def test_mix_shader_with_transparent_by_an_image() -> None:
    build.new_scene()
    material, image, _ = shining_texels()
    tree = material.node_tree
    mix, clear = build.node(tree, 'MixShader'), build.node(tree, 'BsdfTransparent')
    build.connect(tree, image.outputs['Alpha'], mix.inputs[0])
    build.connect(tree, clear.outputs[0], mix.inputs[1])
    build.connect(tree, tree.nodes['Shine'].outputs[0], mix.inputs[2])
    build.connect(tree, mix.outputs[0], build.output(tree).inputs['Surface'])
    buffers, warnings = show(material)
    assert reads(buffers) == {'emission', 'alpha'} and not warnings
    # A ray goes on or sees all of the emission.
    picture = seen(buffers)
    assert not picture[:, 0].any()
    np.testing.assert_allclose(picture[:, 4], np.tile(TEXELS[4, :3], (5, 1)), atol=1e-6)


@pytest.mark.parametrize(
    ('kind', 'target'),
    [
        ('BsdfDiffuse', 'Color'),
        ('BsdfMetallic', 'Base Color'),
        ('BsdfMetallic', 'Edge Tint'),
        ('BsdfAnisotropic', 'Roughness'),
        ('Emission', 'Color'),
    ],
)
def test_shader(kind: str, target: str) -> None:
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
    assert [lookup.image for lookup in lookups(show(material)[0])] == [0]


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
    assert constants(buffers, 1)[name] == pytest.approx(expected)
    assert warnings == ['Material "Material": node "Image Texture": no image is chosen']


def test_image_in_the_world() -> None:
    scene = build.new_scene()
    world = build.world(scene, color=(0.5, 0.25, 0))
    image = node(world.node_tree, 'TexImage', image=picture())
    background = next(found for found in world.node_tree.nodes if found.type == 'BACKGROUND')
    build.connect(world.node_tree, image.outputs['Color'], background.inputs['Color'])
    buffers = exported(scene)
    ops = emission_ops(native.load().Scene(buffers, bvh=False).explain(buffers.world.shader))
    assert len(buffers.images) == 1 and ops[-1] == 'image_v'
