# SPDX-License-Identifier: GPL-3.0-or-later
"""Trees that are read as they are drawn, without Blender's inliner: they give what it gives."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import pytest
from cotorra import shader
from cotorra.shader import CLOSURES, PLAIN, VALUES
from cotorra.shader.feeds import plain_feeds
from cotorra.shader.layout import inputs, layout, socket_type

from random_shaders import Thicket
from shader_reading import emitted, link, new_material, read
from test_shader_closures_rendered import scene_of

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='4.5 does not inline trees')

SEEDS = 60


@pytest.mark.parametrize('shown', ['emission', 'surface'])
def test_a_plain_tree_is_what_blender_inlines(shown: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = 0
    for seed in range(SEEDS):
        material = scene_of(getattr(Thicket(seed), shown)).objects['Sphere'].active_material
        if plain_feeds(material.node_tree, PLAIN) is None:
            continue
        plain += 1
        ours = read(material)
        with monkeypatch.context() as patched:
            patched.setattr(shader, 'plain_feeds', lambda tree, kinds: None)
            inlined = read(material)
        assert ours.draft.key == inlined.draft.key, seed
        assert ours.shader.labels == inlined.shader.labels and ours.warnings == inlined.warnings, seed
    assert plain > SEEDS / 4  # else nothing was compared


def test_what_blender_resolves_is_left_to_it() -> None:
    def is_plain(material: bpy.types.Material) -> bool:
        return plain_feeds(material.node_tree, PLAIN) is not None

    material, math = emitted('Math')
    assert not is_plain(material)  # computed from nothing but constants
    tree = material.node_tree
    noise = tree.nodes.new('ShaderNodeTexNoise')
    link(noise.outputs[0], math.inputs[0])
    assert is_plain(material)
    math.mute = True
    assert not is_plain(material)
    math.mute = False
    tree.links[-1].is_muted = True
    assert not is_plain(material)
    tree.links[-1].is_muted = False
    link(math.outputs[0], math.inputs[1])  # a loop that Blender calls valid
    assert all(each.is_valid for each in tree.links) and not is_plain(material)
    tree.links.remove(tree.links[-1])
    assert is_plain(material)
    second = tree.nodes.new('ShaderNodeOutputMaterial')
    assert not is_plain(material)
    tree.nodes.remove(second)
    for kind in ('NodeReroute', 'ShaderNodeGroup', 'ShaderNodeValue', 'ShaderNodeRGB', 'GeometryNodeRepeatOutput'):
        other = tree.nodes.new(kind)
        assert not is_plain(material), kind
        tree.nodes.remove(other)
    assert is_plain(material)


def choices(node: bpy.types.Node) -> Iterator[str]:
    """Give each property of a node that is a choice or a switch each of its values."""
    yield 'as made'
    for known in type(node).bl_rna.properties:
        if known.is_readonly or known.identifier in bpy.types.Node.bl_rna.properties:
            continue
        if known.type == 'ENUM' and not known.is_enum_flag:
            values = [item.identifier for item in known.enum_items]
        elif known.type == 'BOOLEAN' and not known.is_array:
            values = [False, True]
        else:
            continue
        for value in values:
            try:
                setattr(node, known.identifier, value)
            except TypeError:
                continue  # choices that depend on others
            yield f'{known.identifier} = {value}'


@pytest.mark.parametrize('kind', sorted({*VALUES, *CLOSURES}))
def test_nodes_of_a_type_have_the_same_inputs(kind: str) -> None:
    tree = new_material()[0].node_tree
    try:
        first, node = tree.nodes.new(kind), tree.nodes.new(kind)
    except RuntimeError:
        pytest.skip(f'this Blender has no {kind}, which another one has')
    layout(first)  # it is asked
    for choice in choices(node):
        assert list(inputs(node)) == [socket.identifier for socket in node.inputs], choice
        assert layout(node).type == node.type and layout(node).kind == kind, choice
        sockets = (*node.inputs, *node.outputs)
        assert [socket_type(socket) for socket in sockets] == [socket.type for socket in sockets], choice
