# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of Blender's from plain data (descriptions.py): materials, lights, worlds, camera and settings.

What Blender refuses to hold is left as it was; shapes are shapes.py's.
"""

from __future__ import annotations

import bpy
import numpy as np
from cotorra import compat

import ies_files
from flat_scenes import node
from random_shaders import Kinds, Thicket, picture
from random_trees import Forest
from scenes import build

from . import shapes
from .shapes import Description, apply

SIZE = (16, 12)
IES = (
    ies_files.STREET,
    '',
    ies_files.STREET[:150],
    ies_files.STREET.replace('120', 'nan'),
    ies_files.STREET.replace('120', '1e39'),
    ies_files.ies_text((0, 90), (0,), [[-1.0, 3e38]], factors=(-1.0, 0.0, 1e30)),
)


class WildThicket(Thicket):
    """Trees of all nodes, whose numbers may be any that single precision holds."""

    wild_numbers = (0.0, -0.0, -1.0, 1e-45, 1e-20, 1e20, 3.4e38, -3.4e38, float('inf'), float('-inf'), float('nan'))

    def __init__(self, seed: int, wild: bool, known: Kinds) -> None:
        super().__init__(seed, known)
        self.wild = wild

    def type_in(self, target: bpy.types.NodeSocket) -> None:
        super().type_in(target)
        if not self.wild or not hasattr(target, 'default_value') or self.dice.random() > 0.25:
            return
        if target.type == 'VALUE':
            target.default_value = self.dice.choice(self.wild_numbers)
        elif target.type in ('VECTOR', 'RGBA'):
            target.default_value = [self.dice.choice(self.wild_numbers) for _ in target.default_value]
        elif target.type == 'INT':
            target.default_value = self.dice.choice((0, -1, 2**31 - 1, -(2**31)))

    def limit(self, tree: bpy.types.NodeTree, target: bpy.types.NodeSocket) -> None:
        if not self.wild:
            super().limit(tree, target)

    def closure(self, tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        made = super().closure(tree)
        if self.wild:
            for target in made.node.inputs:
                if target.type not in ('SHADER', 'CUSTOM', 'MENU', 'STRING'):
                    self.type_in(target)
                    if self.dice.random() < 0.3 and not target.hide_value:
                        tree.links.new(self.dice.choice(self.found), target)
        return made

    def emission(self, tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        shown = super().emission(tree)
        if self.wild:  # past the nodes that hold it between 0 and 4
            for target in shown.node.inputs:
                if target.type in ('RGBA', 'VALUE'):
                    tree.links.new(self.dice.choice(self.found), target)
        return shown


def image(name: str) -> bpy.types.Image:
    """One that is lost, has no pixels, holds what is not finite, or is in order."""
    if name == 'spots':
        return picture()
    if name == 'wild':
        made = bpy.data.images.new('Wild', 8, 4, alpha=True, float_buffer=True)
        pixels = np.resize(np.array([0.0, 1.0, np.nan, np.inf, -np.inf, 3.4e38, -3.4e38, 1e-45], np.float32), 8 * 4 * 4)
        made.pixels.foreach_set(np.roll(pixels, 3))
        return made
    made = bpy.data.images.new('Lost', 4, 4)
    made.source, made.filepath = 'FILE', '//lost.png' if name == 'lost' else ''
    return made


class Builder:
    """known: the nodes that hand on values, and those that hand on closures."""

    def __init__(self, known: Kinds) -> None:
        self.known = known

    def scene(self, description: Description) -> bpy.types.Scene:
        scene = build.new_scene()
        scene.render.engine = 'COTORRA'
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        scene.render.threads_mode, scene.render.threads = 'FIXED', 2
        for index, thing in enumerate(description['objects']):
            shapes.add(scene, f'Object {index}', thing, [self.material(one) for one in thing['materials']])
        for index, light in enumerate(description['lights']):
            self.light(scene, f'Light {index}', light)
        self.world(scene, description['world'])
        camera = build.camera(scene)
        camera.location, camera.rotation_euler = (1.5, -5.0, 2.0), (1.2, 0.0, 0.3)
        if description['camera']:
            apply(camera.data, description['camera']['settings'])
            shapes.place(camera, description['camera']['place'])
        self.render(scene, description['render'])
        return scene

    def render(self, scene: bpy.types.Scene, wanted: Description) -> None:
        render = scene.render
        apply(scene.cycles, wanted['cycles'])
        apply(scene.cotorra, wanted['settings'])
        apply(scene.view_layers[0], wanted['layer'])
        apply(scene.view_layers[0].cotorra, wanted['layer_settings'])
        if wanted['override'] is not None:
            scene.cotorra.use_model_override = True
            apply(scene.cotorra.model_override, wanted['override'])
        scene.cotorra.integrator, scene.cotorra.samples = wanted['integrator'], wanted['samples']
        scene.cotorra.device = wanted.get('device', 'CPU')
        scene.cotorra.ray_tracing = wanted.get('ray_tracing', 'AUTO')
        render.film_transparent = wanted['transparent']
        if wanted['border']:
            render.use_border, (x0, y0, x1, y1) = True, wanted['border']
            render.border_min_x, render.border_max_x = min(x0, x1), max(x0, x1)
            render.border_min_y, render.border_max_y = min(y0, y1), max(y0, y1)

    def material(self, wanted: Description) -> bpy.types.Material | None:
        if wanted['kind'] == 'none':
            return None
        if wanted['kind'] != 'principled':
            made = build.with_nodes(bpy.data.materials.new('Tree'))
            self.tree(made.node_tree, wanted, 'OutputMaterial')
            return made
        made = build.material('Plain')
        shader = compat.principled(made)
        for name, value in wanted['inputs'].items():
            if shader.inputs.get(name) is not None:  # some stand there in other modes only
                apply(shader.inputs[name], {'default_value': value})
        apply(made.cotorra, wanted['model'])
        tree = made.node_tree
        if wanted['image']:
            texture = node(tree, 'TexImage', image=image(wanted['image']))
            tree.links.new(texture.outputs[0], shader.inputs['Base Color'])
            tree.links.new(texture.outputs[1], shader.inputs['Alpha'])
        if wanted['bump']:
            bump, noise = node(tree, 'Bump'), node(tree, 'TexNoise')
            apply(bump.inputs[0], {'default_value': wanted['bump'][0]})
            apply(bump.inputs[1], {'default_value': wanted['bump'][1]})
            apply(noise.inputs['Scale'], {'default_value': wanted['bump'][2]})
            tree.links.new(noise.outputs[0], bump.inputs['Height'])
            tree.links.new(bump.outputs[0], shader.inputs['Normal'])
        return made

    def tree(self, tree: bpy.types.NodeTree, wanted: Description, end: str) -> None:
        """Fills a tree from its seed."""
        tree.nodes.clear()
        output = node(tree, end)
        if wanted['kind'] == 'forest':
            emission = node(tree, 'Emission')
            forest = Forest(wanted['seed'])
            found = forest.fill(tree, [], 0)
            if found:
                tree.links.new(forest.look(tree, found[-1]), emission.inputs[0])
            tree.links.new(emission.outputs[0], output.inputs[0])
            return
        thicket = WildThicket(wanted['seed'], wanted['wild'], self.known)
        if wanted['kind'] == 'background':
            shader = node(tree, 'Background')
            thicket.grow(tree, 5)
            tree.links.new(thicket.dice.choice(thicket.found), shader.inputs[0])
            tree.links.new(shader.outputs[0], output.inputs[0])
            return
        tree.links.new(getattr(thicket, wanted['kind'])(tree), output.inputs[0])

    def light(self, scene: bpy.types.Scene, name: str, wanted: Description) -> None:
        thing = build.light(scene, wanted['kind'])
        thing.name = name
        thing.location = (0.5, -1.0, 3.0)
        apply(thing.data, wanted['settings'])
        apply(thing.data.cotorra, wanted.get('own'))
        shapes.place(thing, wanted['place'])
        if 'tree' in wanted or 'ies' in wanted:
            tree = build.with_nodes(thing.data).node_tree
            self.tree(tree, wanted.get('tree', {'kind': 'emission', 'seed': 0, 'wild': False}), 'OutputLight')
        if 'ies' in wanted:
            text = bpy.data.texts.new('IES')
            text.write(IES[wanted['ies'] % len(IES)])
            profile = node(tree, 'TexIES', ies=text)
            emission = next(one for one in tree.nodes if one.type == 'EMISSION')
            tree.links.new(profile.outputs[0], emission.inputs['Strength'])

    def world(self, scene: bpy.types.Scene, wanted: Description | None) -> None:
        if wanted is None:
            return
        plain = wanted['kind'] == 'plain'
        made = build.world(scene, wanted['color'] if plain else (1, 1, 1), wanted['strength'] if plain else 1.0)
        if plain:
            return
        tree = made.node_tree
        if wanted['kind'] in ('sky', 'image'):
            shader = compat.background(made)
            source = node(tree, 'TexSky' if wanted['kind'] == 'sky' else 'TexEnvironment')
            if wanted['kind'] == 'image':
                source.image = image(wanted['image'])
            else:
                thicket = WildThicket(wanted['seed'], wanted['wild'], self.known)
                thicket.draw(source)
                thicket.feed(tree, source, 0.0)
            tree.links.new(source.outputs[0], shader.inputs[0])
        else:
            self.tree(tree, wanted, 'OutputWorld')
