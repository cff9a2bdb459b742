# SPDX-License-Identifier: GPL-3.0-or-later
"""Each value of each property and some of each input of a shader node, alone: pages of small surfaces, one a variant.

How they compare with Cycles' pictures is test_node_variants.py's; which nodes there are is random_shaders.py's.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import bpy
from cotorra import compat

from flat_scenes import node
from random_shaders import BASE, LEFT_OUT, NOT_DRAWN, dress, kinds, picture
from scenes import build

# Left out of random trees, and not here.
ALONE = frozenset(
    f'ShaderNode{name}'
    for name in (
        'AmbientOcclusion Bevel Raycast LightFalloff TexSky Displacement VectorDisplacement ParticleInfo HairInfo '
        'PointInfo VolumeInfo'
    ).split()
)
VARIES = 'varies'  # of an input: noise is linked to it
PLACE = 'place'  # of a vector that stands for something else: a position is

Choice = tuple[str, object]


class Variant(NamedTuple):
    """choice: a property and its value; inputs: by number, values or what is linked; output: its number."""

    kind: str
    choice: Choice | None
    inputs: tuple[tuple[int, object], ...]
    output: int


def every_kind() -> tuple[list[str], list[str]]:
    """Nodes that hand on values, and those that hand on closures."""
    return kinds(set(LEFT_OUT) - ALONE)


def variants(kind: str) -> list[Variant]:
    owner = bpy.data.materials.new('Probe')
    compat.principled(owner)
    tree = owner.node_tree
    found = []
    for choice in [None, *dict.fromkeys(_choices(tree.nodes.new(kind)))]:
        made = tree.nodes.new(kind)
        try:
            if choice is not None:
                setattr(made, *choice)
        except TypeError:  # not for this node's other modes
            continue
        outputs = [k for k, out in enumerate(made.outputs) if out.enabled and out.type not in ('CUSTOM', 'STRING')]
        if not outputs:
            continue
        if made.outputs[outputs[0]].type == 'SHADER':
            outputs = outputs[:1]
        found += [Variant(kind, choice, (), output) for output in outputs]
        for k, target in enumerate(made.inputs):
            for value in _tried(target, choice is None) if target.enabled else ():
                found.append(Variant(kind, choice, ((k, value),), outputs[len(found) % len(outputs)]))
    bpy.data.materials.remove(owner)
    return found


def _choices(made: bpy.types.Node) -> Iterator[Choice]:
    for prop in made.bl_rna.properties:
        name = prop.identifier
        if name in BASE or name in NOT_DRAWN or prop.is_readonly:
            continue
        if prop.type == 'ENUM' and not prop.is_enum_flag:
            yield from ((name, item.identifier) for item in prop.enum_items)
        elif prop.type == 'BOOLEAN':
            yield name, not getattr(made, name)
        elif prop.type == 'INT':
            least = max(prop.soft_min, 1)
            yield name, least if getattr(made, name) != least else min(prop.soft_max, 4)
        elif prop.type == 'FLOAT' and not prop.is_array:
            least, most = max(prop.soft_min, -2.0), min(prop.soft_max, 2.0)
            yield name, least + 0.62 * (most - least)


def _tried(target: bpy.types.NodeSocket, all_of_them: bool) -> list[object]:
    """Values of an input; fewer where a property is tried, too."""
    if not hasattr(target, 'default_value'):
        return []
    linked = [VARIES] if all_of_them and not target.hide_value else []
    match target.type:
        case 'VALUE' if target.name in ('Sides', 'Detail'):  # others divide by zero in Cycles, or are rounded
            return [5.0] if target.name == 'Sides' else [1.3]
        case 'VALUE':
            prop = target.bl_rna.properties['default_value']
            least, most = prop.soft_min, prop.soft_max
            if most - least > 10.0:
                least, most = max(least, -1.5), min(most, 6.0)
            return [least + share * (most - least) for share in ((0.17, 0.77) if all_of_them else (0.6,))] + linked
        case 'RGBA':
            return [(0.2, 0.7, 0.4, 1.0), *linked]
        case 'VECTOR' if target.hide_value:
            return [PLACE] if all_of_them and target.name == 'Vector' else []
        case 'VECTOR':
            return [(0.6, -0.35, 1.2, 0.4)[: len(target.default_value)]]
        case 'INT':
            return [3]
        case 'BOOLEAN':
            return [not target.default_value]
    return []


def material(variant: Variant, name: str) -> bpy.types.Material:
    """A closure as it is; of a value its size, up to 4, as light."""
    made = bpy.data.materials.new(name)
    compat.principled(made)
    tree = made.node_tree
    tree.nodes.clear()
    found = tree.nodes.new(variant.kind)
    if variant.choice is not None:
        setattr(found, *variant.choice)
    _furnish(found)
    output = node(tree, 'OutputMaterial')
    given = dict(variant.inputs)
    shows = found.outputs[variant.output]
    if shows.type != 'SHADER' and not variant.kind.startswith('ShaderNodeTex'):
        _spread(tree, found, given)
    for k, value in given.items():
        if value == VARIES:
            noise = node(tree, 'TexNoise')
            noise.inputs['Scale'].default_value = 3.0
            tree.links.new(noise.outputs[0], found.inputs[k])
        elif value == PLACE:
            tree.links.new(node(tree, 'NewGeometry').outputs['Position'], found.inputs[k])
        else:
            found.inputs[k].default_value = value
    if shows.type == 'SHADER':
        tree.links.new(shows, output.inputs['Surface'])
        return made
    size, most = node(tree, 'VectorMath', operation='ABSOLUTE'), node(tree, 'VectorMath', operation='MINIMUM')
    most.inputs[1].default_value = (4.0, 4.0, 4.0)
    shine = node(tree, 'Emission')
    tree.links.new(shows, size.inputs[0])
    tree.links.new(size.outputs[0], most.inputs[0])
    tree.links.new(most.outputs[0], shine.inputs['Color'])
    tree.links.new(shine.outputs[0], output.inputs['Surface'])
    made.cycles.emission_sampling = 'NONE'
    return made


def _furnish(made: bpy.types.Node) -> None:
    """Images, names, tables."""
    if hasattr(made, 'image'):
        made.image = picture()
    named = {'ShaderNodeUVMap': ('uv_map', 'UVMap'), 'ShaderNodeVertexColor': ('layer_name', 'Paint')}
    named['ShaderNodeAttribute'] = ('attribute_name', 'Paint')
    if made.bl_idname in named:
        setattr(made, *named[made.bl_idname])
    if made.bl_idname == 'ShaderNodeTangent' and made.direction_type == 'UV_MAP':
        made.uv_map = 'UVMap'
    if hasattr(made, 'color_ramp'):
        made.color_ramp.elements.new(0.4).color = (0.9, 0.3, 0.1, 1.0)
    if hasattr(made, 'mapping') and hasattr(made.mapping, 'curves'):
        for curve in made.mapping.curves:
            curve.points.new(0.3, 0.7)
        made.mapping.update()


def _spread(tree: bpy.types.NodeTree, made: bpy.types.Node, given: dict[int, object]) -> None:
    """Makes the first input that is not given vary over the surface."""
    for k, target in enumerate(made.inputs):
        if not target.enabled or target.hide_value or target.type not in ('VALUE', 'VECTOR', 'RGBA') or k in given:
            continue
        found = node(tree, 'TexCoord')
        if target.type == 'VALUE':
            parts = node(tree, 'SeparateXYZ')
            tree.links.new(found.outputs['UV'], parts.inputs[0])
            tree.links.new(parts.outputs[0], target)
        else:
            tree.links.new(found.outputs['Object'], target)
        return


def page(shown: list[Variant], side: int, closures: bool) -> bpy.types.Scene:
    """Rows of `side` squares that lean, or balls in a soft sun, seen from above; number k has material `V` and k."""
    scene = build.new_scene()
    scene.world = bpy.data.worlds.new('World')
    compat.background(scene.world).inputs['Color'].default_value = (0.5, 0.5, 0.5, 1.0)
    if closures:
        bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.45)
        build.light(scene, 'SUN', energy=2.0, angle=0.3).rotation_euler = (0.6, 0.3, 0.0)
    else:
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3, size=0.96)
    first = next(obj for obj in scene.objects if obj.type == 'MESH')
    mesh = first.data
    if not closures:
        for vertex in mesh.vertices:
            vertex.co.z = 0.1 * (vertex.co.x**2 - vertex.co.y)
    mesh.shade_smooth()
    dress(mesh)
    mesh.materials.append(None)
    bpy.data.objects.remove(first)
    for k, variant in enumerate(shown):
        obj = bpy.data.objects.new(f'Cell {k}', mesh)
        scene.collection.objects.link(obj)
        obj.location = (k % side - 0.5 * (side - 1), k // side - 0.5 * (side - 1), 0.0)
        obj.rotation_euler = (0.0, 0.0, 0.0) if closures else (0.15, 0.1, 0.0)
        obj.material_slots[0].link = 'OBJECT'
        obj.material_slots[0].material = material(variant, f'V{k}')
    camera = build.camera(scene)
    camera.data.type, camera.data.ortho_scale, camera.location = 'ORTHO', side, (0.0, 0.0, 6.0)
    return scene
