# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's structs can be set to: the properties of lights, cameras, modifiers and settings, by their names.

It is read inside Blender, once, and handed on as plain data; which values are tried is said in descriptions.py.
"""

from __future__ import annotations

from typing import Any

import bpy
from cotorra import light_settings, material_settings
from cotorra import properties as own

from random_shaders import kinds

# Left as they are: what is no setting, what would make a render long, and what descriptions set by themselves.
LEFT_OUT = set(
    'name use_fake_user is_runtime_data tag use_extra_user preview_render_type device device_index graphics_card '
    'ray_tracing samples time_limit use_animated_seed sensor_fit_auto show_viewport show_render show_in_editmode '
    'adaptive_min_samples preview_samples threads filter_type library_unlink use_nodes'.split()
)
# Numbers of things that modifiers make; more take long, and are Blender's own work.
COUNTS = {
    'count': 6, 'levels': 2, 'render_levels': 2, 'quality': 2, 'segments': 4, 'iterations': 4, 'steps': 8,
    'render_steps': 8, 'octree_depth': 3, 'branch_smoothing': 1, 'resolution': 4, 'whitted_depth': 12,
}  # fmt: skip
MODIFIERS = (
    'ARRAY', 'BEVEL', 'BUILD', 'CAST', 'DECIMATE', 'DISPLACE', 'EDGE_SPLIT', 'MASK', 'MIRROR', 'SCREW', 'SIMPLE_DEFORM',
    'SMOOTH', 'SOLIDIFY', 'SUBSURF', 'TRIANGULATE', 'WAVE', 'WELD', 'WIREFRAME',
)  # fmt: skip
Setting = dict[str, Any]
# Open Shading Language asks for a library that the module does not bring, groups for a tree (random_trees.py).
NEVER = ('ShaderNodeScript', 'ShaderNodeGroup', 'ShaderNodeCustomGroup')


def properties(struct: Any) -> dict[str, Setting]:
    """Type, soft limits, length and items of each property that can be set, by name."""
    found = {}
    for prop in struct.bl_rna.properties:
        if prop.is_readonly or prop.identifier in LEFT_OUT or prop.type not in ('BOOLEAN', 'INT', 'FLOAT', 'ENUM'):
            continue
        if prop.type == 'ENUM':
            items = [item.identifier for item in prop.enum_items]
            if items and not prop.is_enum_flag:
                found[prop.identifier] = {'type': 'ENUM', 'items': items}
        elif prop.type == 'BOOLEAN':
            found[prop.identifier] = {'type': 'BOOLEAN', 'length': prop.array_length}
        else:
            most = COUNTS.get(prop.identifier)
            limits = [prop.soft_min, prop.soft_max] if most is None else [0, most]
            held = most is not None
            found[prop.identifier] = {'type': prop.type, 'length': prop.array_length, 'limits': limits, 'held': held}
    return found


def inputs(kind: str) -> dict[str, Setting]:
    """The inputs of a shader node, by name."""
    tree = bpy.data.node_groups.new('Catalogue', 'ShaderNodeTree')
    found = {}
    for socket in tree.nodes.new(kind).inputs:
        if socket.type in ('VALUE', 'RGBA', 'VECTOR') and not socket.hide_value:
            prop = socket.bl_rna.properties['default_value']
            limits = [prop.soft_min, prop.soft_max]
            found[socket.name] = {'type': 'FLOAT', 'length': prop.array_length, 'limits': limits, 'held': False}
    bpy.data.node_groups.remove(tree)
    return found


def modifiers() -> dict[str, dict[str, Setting]]:
    thing = bpy.data.objects.new('Catalogue', bpy.data.meshes.new('Catalogue'))
    known = {kind: properties(thing.modifiers.new('', kind)) for kind in MODIFIERS}
    bpy.data.objects.remove(thing)
    return known


def catalogue() -> dict[str, Any]:
    """All of them, as JSON can hold it."""
    scene = bpy.data.scenes[0]
    lights = {kind: getattr(bpy.types, f'{kind.title()}Light') for kind in ('POINT', 'SUN', 'SPOT', 'AREA')}
    return {
        'lights': {kind: properties(struct) for kind, struct in lights.items()},
        'light_settings': properties(light_settings.CotorraLightSettings),
        'material_settings': properties(material_settings.CotorraMaterialSettings),
        'scene_settings': properties(own.CotorraSceneSettings),
        'layer_settings': properties(own.CotorraViewLayerSettings),
        'layer': {name: set_ for name, set_ in properties(bpy.types.ViewLayer).items() if name.startswith('use_pass')},
        'cycles': properties(type(scene.cycles)),
        'camera': properties(bpy.types.Camera),
        'object': properties_of_objects(),
        'principled': inputs('ShaderNodeBsdfPrincipled'),
        'modifiers': modifiers(),
        'nodes': kinds(NEVER),
    }


def properties_of_objects() -> dict[str, Setting]:
    """Who sees an object, and what is told of it; where it stands is told by descriptions.py."""
    wanted = ('visible_', 'pass_index', 'is_', 'hide_', 'color', 'instance_')
    return {
        name: found
        for name, found in properties(bpy.types.Object).items()
        if name.startswith(wanted) and name != 'instance_type'
    }
