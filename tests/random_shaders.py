# SPDX-License-Identifier: GPL-3.0-or-later
"""Random materials of any of Blender's shader nodes and closures, in any of their modes.

What they look like is compared with Cycles in test_random_shaders.py; links, groups and zones are random_trees.py's.
"""

from __future__ import annotations

import random
from collections.abc import Container

import bpy
import numpy as np

from flat_scenes import node

# Left out of random trees, each for a reason that is not that it fails.
LEFT_OUT = {
    'ShaderNodeScript': 'Open Shading Language',
    'ShaderNodeTexIES': 'is for lamps',
    'ShaderNodeTexSky': 'is for worlds',
    'ShaderNodeGroup': 'is of random_trees.py',
    'ShaderNodeHoldout': 'alpha is compared elsewhere',
    'ShaderNodeRayPortal': 'named in a warning',
    'ShaderNodeBsdfRayPortal': 'named in a warning',
    'ShaderNodeAmbientOcclusion': 'traces rays',
    'ShaderNodeBevel': 'traces rays',
    'ShaderNodeRaycast': 'traces rays',
    'ShaderNodeSubsurfaceScattering': 'named in a warning',
    'ShaderNodeBsdfHair': 'named in a warning',
    'ShaderNodeBsdfHairPrincipled': 'named in a warning',
    'ShaderNodeVolumeInfo': 'is for volumes',
    'ShaderNodeDisplacement': 'as a colour, Cycles shows it otherwise to the camera than to other surfaces',
    'ShaderNodeVectorDisplacement': 'as Displacement',
    'ShaderNodeParticleInfo': 'needs particles',
    'ShaderNodeHairInfo': 'needs hair',
    'ShaderNodePointInfo': 'needs points',
    'ShaderNodeEeveeSpecular': 'is EEVEE’s',
    'ShaderNodeShaderToRGB': 'is EEVEE’s',
    'ShaderNodeUVAlongStroke': 'is for line sets',
    'ShaderNodeLightFalloff': 'is for lamps',
    'ShaderNodeTexPointDensity': 'needs particles',
    'ShaderNodeCustomGroup': 'is for add-ons',
}
BASE = set(bpy.types.Node.bl_rna.properties.keys())
# Properties that say what is shown in the editor, or that need data of their own.
NOT_DRAWN = set(
    'image object bytecode script filepath mode uv_map attribute_name layer_name from_instancer image_user '
    'texture_mapping color_mapping mapping color_ramp parameterization axis_normalization use_custom_color'.split()
)


Kinds = tuple[list[str], list[str]]


def kinds(left_out: Container[str] = LEFT_OUT) -> Kinds:
    """Nodes that hand on values, and those that hand on closures, of this Blender."""
    values, closures = [], []
    tree = bpy.data.materials.new('Kinds')
    tree.use_nodes = True
    for name in sorted(dir(bpy.types)):
        if not name.startswith('ShaderNode') or name in left_out or 'Output' in name or 'Volume' in name:
            continue
        try:
            made = tree.node_tree.nodes.new(name)
        except RuntimeError:  # a base class
            continue
        if made.outputs:
            (closures if made.outputs[0].type == 'SHADER' else values).append(name)
    bpy.data.materials.remove(tree)
    return values, [name for name in closures if name not in ('ShaderNodeMixShader', 'ShaderNodeAddShader')]


class Thicket:
    """Trees from one seed. known: the nodes that they are made of, as kinds() finds them."""

    def __init__(self, seed: int, known: Kinds | None = None) -> None:
        self.dice = random.Random(seed)
        self.values, self.closures = known or kinds()
        self.found: list[bpy.types.NodeSocket] = []

    def emission(self, tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        """What 3 to 12 nodes make of the point, as light between 0 and 4."""
        self.grow(tree, self.dice.randint(3, 12))
        least, most = (node(tree, 'VectorMath', operation=name) for name in ('MAXIMUM', 'MINIMUM'))
        tree.links.new(self.dice.choice(self.found[-4:]), least.inputs[0])
        least.inputs[1].default_value = (0.0, 0.0, 0.0)
        tree.links.new(least.outputs[0], most.inputs[0])
        most.inputs[1].default_value = (4.0, 4.0, 4.0)
        shine = node(tree, 'Emission')
        tree.links.new(most.outputs[0], shine.inputs['Color'])
        return shine.outputs[0]

    def surface(self, tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        """One to three closures, mixed or added, whose inputs 3 to 9 nodes make."""
        self.grow(tree, self.dice.randint(3, 9))
        shown = self.closure(tree)
        for _ in range(self.dice.choice((0, 0, 1, 1, 2))):
            mixed = node(tree, self.dice.choice(('MixShader', 'MixShader', 'MixShader', 'AddShader')))
            if mixed.bl_idname == 'ShaderNodeMixShader':
                mixed.inputs[0].default_value = round(self.dice.random(), 2)
                if self.dice.random() < 0.6:
                    tree.links.new(self.dice.choice(self.found), mixed.inputs[0])
            tree.links.new(shown, mixed.inputs[-2])
            tree.links.new(self.closure(tree), mixed.inputs[-1])
            shown = mixed.outputs[0]
            if mixed.bl_idname == 'ShaderNodeAddShader':  # no more than arrives: half of it with nothing
                half = node(tree, 'MixShader')
                half.inputs[0].default_value = 0.5
                tree.links.new(shown, half.inputs[1])
                shown = half.outputs[0]
        return shown

    def grow(self, tree: bpy.types.NodeTree, count: int) -> None:
        self.found = []
        for _ in range(count):
            made = tree.nodes.new(self.dice.choice(self.values))
            self.draw(made)
            self.feed(tree, made, 0.6)
            self.found += [out for out in made.outputs if out.enabled and out.type not in ('SHADER', 'CUSTOM')]

    def closure(self, tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        made = tree.nodes.new(self.dice.choice(self.closures))
        self.draw(made)
        self.feed(tree, made, 0.15)
        for target in made.inputs:
            if target.type in ('RGBA', 'VALUE') and target.is_linked:
                self.limit(tree, target)
            elif target.name.endswith('IOR') and target.type == 'VALUE':
                target.default_value = round(self.dice.uniform(1.05, 2.5), 2)
            elif target.name in ('IOR', 'Extinction'):  # a metal's, by colour
                target.default_value = [round(self.dice.uniform(0.2, 4.0), 2) for _ in range(3)]
            elif 'Strength' in target.name:
                target.default_value = abs(target.default_value)
                for link in list(target.links):
                    tree.links.remove(link)
        for name in ('Subsurface Weight', 'Subsurface Scale'):
            if name in made.inputs:
                for link in list(made.inputs[name].links):
                    tree.links.remove(link)
                made.inputs[name].default_value = 0.0
        return made.outputs[0]

    @staticmethod
    def limit(tree: bpy.types.NodeTree, target: bpy.types.NodeSocket) -> None:
        """No surface reflects more than arrives, nor less than nothing."""
        least, most = (node(tree, 'VectorMath', operation=name) for name in ('MAXIMUM', 'MINIMUM'))
        tree.links.new(target.links[0].from_socket, least.inputs[0])
        least.inputs[1].default_value, most.inputs[1].default_value = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
        tree.links.new(least.outputs[0], most.inputs[0])
        tree.links.new(most.outputs[0], target)

    def draw(self, made: bpy.types.Node) -> None:
        """Modes, tables and images."""
        dice = self.dice
        for prop in made.bl_rna.properties:
            if prop.identifier in BASE or prop.identifier in NOT_DRAWN or prop.is_readonly:
                continue
            if prop.type == 'ENUM' and not prop.is_enum_flag:
                choices = [item.identifier for item in prop.enum_items]
                if made.bl_idname == 'ShaderNodeMix' and prop.identifier == 'data_type':
                    choices = [name for name in choices if name in ('FLOAT', 'VECTOR', 'RGBA')]
                if prop.identifier == 'subsurface_method' or not choices:
                    continue
                try:
                    setattr(made, prop.identifier, dice.choice(choices))
                except TypeError:  # not for this node's other modes
                    continue
            elif prop.type == 'BOOLEAN':
                setattr(made, prop.identifier, dice.random() < 0.5)
            elif prop.type == 'INT':
                setattr(made, prop.identifier, dice.randint(max(prop.soft_min, 0), min(prop.soft_max, 6)))
            elif prop.type == 'FLOAT' and not prop.is_array:
                least, most = max(prop.soft_min, -2.0), min(prop.soft_max, 2.0)
                setattr(made, prop.identifier, round(dice.uniform(least, most), 2))
        if hasattr(made, 'color_ramp'):
            self.draw_ramp(made.color_ramp)
        if hasattr(made, 'mapping') and hasattr(made.mapping, 'curves'):
            for curve in made.mapping.curves:
                curve.points[0].location = (0.0, round(dice.uniform(0, 1), 2))
                curve.points.new(round(dice.uniform(0.2, 0.8), 2), round(dice.uniform(0, 1), 2))
            made.mapping.update()
        if hasattr(made, 'image'):
            made.image = picture()
        if made.bl_idname == 'ShaderNodeUVMap':
            made.uv_map = dice.choice(('', 'UVMap'))
        if made.bl_idname == 'ShaderNodeVertexColor':
            made.layer_name = dice.choice(('', 'Paint'))
        if made.bl_idname == 'ShaderNodeAttribute':
            made.attribute_name = dice.choice(('Paint', 'UVMap', 'Weight'))
            made.attribute_type = 'GEOMETRY'
        if made.bl_idname == 'ShaderNodeTangent' and made.direction_type == 'UV_MAP':
            made.uv_map = 'UVMap'

    def draw_ramp(self, ramp: bpy.types.ColorRamp) -> None:
        dice = self.dice
        ramp.color_mode = dice.choice(('RGB', 'RGB', 'HSV', 'HSL'))
        if ramp.color_mode == 'RGB':
            ramp.interpolation = dice.choice(('LINEAR', 'EASE', 'CONSTANT', 'CARDINAL', 'B_SPLINE'))
        for _ in range(dice.randint(0, 2)):
            ramp.elements.new(round(dice.uniform(0.1, 0.9), 2))
        for element in ramp.elements:
            element.color = [round(dice.random(), 2) for _ in range(4)]

    def feed(self, tree: bpy.types.NodeTree, made: bpy.types.Node, often: float) -> None:
        for target in made.inputs:
            if not target.enabled or target.type in ('SHADER', 'CUSTOM', 'MENU', 'STRING'):
                continue
            self.type_in(target)
            if target.name in ('Sides', 'Detail'):  # below 3 and below 0 Cycles gives what is not finite, or rounds up
                target.default_value = abs(target.default_value) + 3.0 * (target.name == 'Sides')
                continue
            if self.found and self.dice.random() < often and not target.hide_value | (target.name == 'Normal'):
                start = self.dice.choice(self.found)
                if target.name != 'Orientation':  # of length 0 it makes Cycles' Gabor noise no number
                    tree.links.new(start, target)
            elif target.hide_value and target.name == 'Vector' and self.dice.random() < 0.5:
                vectors = [out for out in self.found if out.type == 'VECTOR']
                if vectors:
                    tree.links.new(self.dice.choice(vectors), target)

    def type_in(self, target: bpy.types.NodeSocket) -> None:
        dice = self.dice
        if not hasattr(target, 'default_value'):
            return
        prop = target.bl_rna.properties['default_value']
        if target.type == 'RGBA':
            target.default_value = [round(dice.random(), 2) for _ in range(4)]
        elif target.type == 'VECTOR':
            target.default_value = [round(dice.uniform(-1.5, 1.5), 2) for _ in target.default_value]
        elif target.type == 'VALUE':
            least, most = prop.soft_min, prop.soft_max
            if most - least > 10.0:
                least, most = max(least, -1.0), min(most, 5.0)
            target.default_value = round(dice.uniform(least, most), 2)
        elif target.type == 'INT':
            target.default_value = dice.randint(0, 4)
        elif target.type == 'BOOLEAN':
            target.default_value = dice.random() < 0.5


def picture() -> bpy.types.Image:
    """Soft spots of colour, 32 by 16 texels, half of them half transparent."""
    if 'Spots' in bpy.data.images:
        return bpy.data.images['Spots']
    image = bpy.data.images.new('Spots', 32, 16, alpha=True, float_buffer=True)
    x, y = np.meshgrid(np.arange(32) / 32, np.arange(16) / 16)
    pixels = np.ones((16, 32, 4), np.float32)
    for channel, turns in enumerate((1, 2, 3)):
        pixels[..., channel] = 0.5 + 0.45 * np.sin(2 * np.pi * (turns * x + 0.2 * channel)) * np.sin(np.pi * y)
    pixels[:, 16:, 3] = 0.5
    image.pixels.foreach_set(pixels.ravel())
    return image


def dress(mesh: bpy.types.Mesh) -> None:
    """Gives a mesh what attribute nodes ask for: colours `Paint` and numbers `Weight`."""
    where = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get('co', where)
    where = where.reshape(-1, 3)
    paint = mesh.color_attributes.new('Paint', 'FLOAT_COLOR', 'POINT')
    colors = np.concatenate([0.5 + 0.5 * where, np.ones((len(where), 1), np.float32)], 1)
    paint.data.foreach_set('color', colors.ravel())
    weight = mesh.attributes.new('Weight', 'FLOAT', 'POINT')
    weight.data.foreach_set('value', np.ascontiguousarray(0.5 + 0.5 * where[:, 2]))
