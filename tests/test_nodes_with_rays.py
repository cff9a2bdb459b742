# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that trace rays, and what Light Path tells where rays go through or light is sent, beside Cycles' pictures.

Which ops the nodes become is test_shader_nodes.py's.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat, stats
from mathutils import Vector

from beside_cycles import in_halves
from flat_scenes import node
from scenes import build

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import Reference, same_image

pytestmark = pytest.mark.usefixtures('engine')

SIZE = (48, 40)
TILE = 8
SAMPLES = 32  # of each half
BOUNCES = 3
# What a tile and the whole may differ by beside noise.
LIMIT = 0.03
TOTAL = 0.01

Tree = bpy.types.NodeTree
Socket = bpy.types.NodeSocket
Surface = Callable[[Tree], Socket]


def shining(value: Surface) -> Surface:
    """An emission of the value, which alone is seen of the surface."""

    def made(tree: Tree) -> Socket:
        emission = node(tree, 'Emission')
        tree.links.new(value(tree), emission.inputs['Color'])
        return emission.outputs[0]

    return made


def occlusion(
    output: str = 'AO', normal: Surface | None = None, linked: float | None = None, **values: object
) -> Surface:
    """An Ambient Occlusion node. linked: the distance, not typed in but linked."""

    def made(tree: Tree) -> Socket:
        found = node(tree, 'AmbientOcclusion')
        for name, value in values.items():
            if name[0].islower():
                setattr(found, name, value)
            else:
                found.inputs[name].default_value = value
        if normal is not None:
            tree.links.new(normal(tree), found.inputs['Normal'])
        if linked is not None:
            number = node(tree, 'Value')
            number.outputs[0].default_value = linked
            tree.links.new(number.outputs[0], found.inputs['Distance'])
        return found.outputs[output]

    return made


def bevelled(
    kind: str, radius: float = 0.25, samples: int = 8, normal: Surface | None = None, **values: object
) -> Surface:
    """A BSDF whose normal is that of a Bevel node."""

    def made(tree: Tree) -> Socket:
        bsdf, bevel = node(tree, kind), node(tree, 'Bevel', samples=samples)
        for name, value in values.items():
            bsdf.inputs[name].default_value = value
        bevel.inputs['Radius'].default_value = radius
        if normal is not None:
            tree.links.new(normal(tree), bevel.inputs['Normal'])
        tree.links.new(bevel.outputs['Normal'], bsdf.inputs['Normal'])
        return bsdf.outputs[0]

    return made


def cast(output: str, length: float = 2.0, direction: tuple[float, ...] | None = None, **values: object) -> Surface:
    def made(tree: Tree) -> Socket:
        found = node(tree, 'Raycast', **values)
        found.inputs['Length'].default_value = length
        if direction is not None:
            way = node(tree, 'CombineXYZ')
            for socket, part in zip(way.inputs, direction, strict=True):
                socket.default_value = part
            tree.links.new(way.outputs[0], found.inputs['Direction'])
        return found.outputs[output]

    return made


def absolute(value: Surface) -> Surface:
    """Vectors as colours: film and tiles know no light below 0."""

    def made(tree: Tree) -> Socket:
        found = node(tree, 'VectorMath', operation='ABSOLUTE')
        tree.links.new(value(tree), found.inputs[0])
        return found.outputs[0]

    return made


def waves(tree: Tree) -> Socket:
    """A normal that waves bend."""
    wave, bump = node(tree, 'TexWave'), node(tree, 'Bump')
    tree.links.new(node(tree, 'TexCoord').outputs['Object'], wave.inputs['Vector'])
    wave.inputs['Scale'].default_value = 2.0
    bump.inputs['Distance'].default_value = 0.1
    tree.links.new(wave.outputs['Fac'], bump.inputs['Height'])
    return bump.outputs['Normal']


def see_through(value: Surface) -> Surface:
    """Diffuse where the value is 1, transparent where it is 0."""

    def made(tree: Tree) -> Socket:
        mix = node(tree, 'MixShader')
        tree.links.new(value(tree), mix.inputs[0])
        tree.links.new(node(tree, 'BsdfTransparent').outputs[0], mix.inputs[1])
        tree.links.new(node(tree, 'BsdfDiffuse').outputs[0], mix.inputs[2])
        return mix.outputs[0]

    return made


def colored(value: Surface) -> Surface:
    def made(tree: Tree) -> Socket:
        found = node(tree, 'BsdfDiffuse')
        tree.links.new(value(tree), found.inputs['Color'])
        return found.outputs[0]

    return made


def bumped_by(value: Surface) -> Surface:
    """Diffuse, its normal bent by the value as a height."""

    def made(tree: Tree) -> Socket:
        found, bump = node(tree, 'BsdfDiffuse'), node(tree, 'Bump')
        bump.inputs['Distance'].default_value = 0.5
        tree.links.new(value(tree), bump.inputs['Height'])
        tree.links.new(bump.outputs['Normal'], found.inputs['Normal'])
        return found.outputs[0]

    return made


EVERY_VERSION: dict[str, Surface] = {
    'occlusion': shining(occlusion()),
    'occlusion, near': shining(occlusion(Distance=0.3, samples=3)),
    'occlusion, of the world': shining(occlusion(Distance=0.0)),
    'occlusion, colour': shining(occlusion('Color', Color=(0.9, 0.4, 0.1, 1.0))),
    'occlusion, inside': shining(occlusion(inside=True, samples=5)),
    'occlusion, only local': shining(occlusion(only_local=True, Distance=3.0)),
    'occlusion, inside, only local': shining(occlusion(inside=True, only_local=True, samples=1)),
    'occlusion, bent': shining(occlusion(normal=waves)),
    'occlusion as a colour': colored(occlusion()),
    'occlusion as a height': bumped_by(occlusion()),
    'occlusion lets through': see_through(occlusion()),
    'bevel of diffuse': bevelled('BsdfDiffuse'),
    'bevel of glossy': bevelled('BsdfAnisotropic', samples=16, Roughness=0.3),
    'bevel of a mirror': bevelled('BsdfAnisotropic', Roughness=0.0),
    'bevel, bent': bevelled('BsdfDiffuse', normal=waves),
    'bevel of Principled': bevelled('BsdfPrincipled', Roughness=0.3, Metallic=0.5),
}
UP, ASIDE = (0.15, 0.1, 1.0), (0.6, -0.2, 0.4)
NEW_SURFACES: dict[str, Surface] = {
    'raycast, is hit': shining(cast('Is Hit')),
    'raycast, self hit': shining(cast('Self Hit', length=5.0, direction=ASIDE)),
    'raycast, only local': shining(cast('Is Hit', length=5.0, direction=ASIDE, only_local=True)),
    'raycast, distance': shining(cast('Hit Distance', direction=ASIDE)),
    'raycast, position': shining(absolute(cast('Hit Position', direction=ASIDE))),
    'raycast, normal': shining(absolute(cast('Hit Normal', direction=UP, length=5.0))),
    'raycast as a height': bumped_by(cast('Hit Distance', direction=ASIDE)),
}
SURFACES = EVERY_VERSION | (NEW_SURFACES if hasattr(bpy.types, 'ShaderNodeRaycast') else {})


def path_says(output: str) -> Surface:
    def made(tree: Tree) -> Socket:
        return node(tree, 'LightPath').outputs[output]

    return made


def dimmed(value: Surface, strength: float = -0.1) -> Surface:
    """Diffuse that takes light away, but not all of it."""

    def made(tree: Tree) -> Socket:
        both = node(tree, 'AddShader')
        tree.links.new(node(tree, 'BsdfDiffuse').outputs[0], both.inputs[0])
        tree.links.new(bright(value, strength)(tree), both.inputs[1])
        return both.outputs[0]

    return made


def noise(tree: Tree) -> Socket:
    return node(tree, 'TexNoise').outputs[0]


def bright(value: Surface, strength: float = 3.0) -> Surface:
    """An emission so strong that it lights what is around."""

    def made(tree: Tree) -> Socket:
        emission = node(tree, 'Emission')
        emission.inputs['Strength'].default_value = strength
        tree.links.new(value(tree), emission.inputs['Color'])
        return emission.outputs[0]

    return made


# Of the roof alone, which stands between the sun and the rest.
ROOFS: dict[str, Surface] = {
    'depth lets through': see_through(path_says('Ray Depth')),
    'diffuse depth lets through': see_through(path_says('Diffuse Depth')),
    'transparent depth lets through': see_through(path_says('Transparent Depth')),
    'depth emits': bright(path_says('Ray Depth')),
    'camera rays see it emit': bright(path_says('Is Camera Ray')),
    'diffuse rays see it emit': bright(path_says('Is Diffuse Ray')),
    'occlusion emits': bright(occlusion()),
    'dark corners emit': bright(occlusion(inside=True)),
    'takes light away': dimmed(noise),
}
# What Cycles' light samples see otherwise than its rays do: its picture with rays alone is compared.
BY_RAYS = frozenset(('diffuse rays see it emit', 'occlusion emits', 'dark corners emit'))

# Warnings of emission that light samples cannot tell. Dim ones show Cycles' picture all the same.
NAMED = dict.fromkeys(
    (
        *('occlusion', 'occlusion, near', 'occlusion, of the world', 'occlusion, colour', 'occlusion, inside'),
        *('occlusion, only local', 'occlusion, inside, only local', 'occlusion, bent'),
        *('occlusion emits', 'dark corners emit'),
    ),
    ('Ambient Occlusion',),
) | {'diffuse rays see it emit': ('Is Diffuse Ray',)}


def scene_of(surface: Surface) -> bpy.types.Scene:
    """Floor, two boxes, one of them turned over and twice there, and a ball, all of the surface; a roof that is not."""
    scene = build.new_scene()
    scene.world = bpy.data.worlds.new('World')
    compat.background(scene.world).inputs['Color'].default_value = (0.4, 0.4, 0.5, 1.0)
    scene.world.light_settings.distance = 0.8
    material = bpy.data.materials.new('Surface')
    compat.principled(material)
    tree = material.node_tree
    tree.nodes.clear()
    output = node(tree, 'OutputMaterial')
    tree.links.new(surface(tree), output.inputs['Surface'])

    build.mesh_object(scene, 'Floor', vertices=[(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)])
    bpy.ops.mesh.primitive_cube_add(size=1.2, location=(-0.9, 0, 0.6), rotation=(0, 0, 0.5))
    bpy.ops.mesh.primitive_cube_add(size=0.9, location=(0.7, -0.6, 0.45), rotation=(0, 0, 0.3))
    box = bpy.context.object
    box.scale.z = -1.4
    build.link(scene, 'Again', box.data).location = (1.0, 0.9, 0.6)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.4, location=(0, 0.3, 0.35))
    bpy.context.object.data.shade_smooth()
    for obj in scene.objects:
        if not obj.data.materials:
            obj.data.materials.append(material)
    roof = build.mesh_object(scene, 'Roof', vertices=[(-1, 0, 1.9), (0.3, 0, 1.9), (0.3, 1.4, 1.9), (-1, 1.4, 1.9)])
    roof.data.materials.append(bpy.data.materials.new('Roof'))

    build.light(scene, 'SUN', energy=2.0, angle=0.3).rotation_euler = (0.6, 0.3, 0.0)
    camera = build.camera(scene)
    camera.location = (0, -4, 2.6)
    camera.rotation_euler = (Vector((0, 0, 0.5)) - camera.location).to_track_quat('-Z', 'Y').to_euler()
    return scene


def picture(scene: bpy.types.Scene, engine: str, folder: Path, samples: int = SAMPLES) -> Reference:
    return in_halves(scene, engine, folder, BOUNCES, SIZE, samples)


def assert_as_cycles(
    scene: bpy.types.Scene, folder: Path, by_rays: tuple[bpy.types.Material, ...] = (), named: tuple[str, ...] = ()
) -> None:
    """by_rays: materials whose emission Cycles shall not sample. named: what Cotorra says that emission depends on."""
    ours = picture(scene, 'COTORRA', folder)
    warnings = [text for layer in stats.last(scene.name) for text in layer.warnings]
    for material in by_rays:
        material.cycles.emission_sampling = 'NONE'
    theirs = picture(scene, 'CYCLES', folder)
    same = same_image(ours, theirs, LIMIT, TILE)
    told = f'in total {same.total:+.4f} ± {same.total_noise:.4f}, worst tile {same.worst}, noise {same.noise:.4f}'
    assert [text.partition('emission by ')[2].partition(':')[0] for text in warnings] == list(named)
    assert same.bad == 0, told
    assert same.beyond_noise == 0, f'{told}\n{np.round(100 * same.tiles).astype(int)} %'
    assert abs(same.total) <= TOTAL + 3 * same.total_noise, told


@pytest.mark.every(3)
@pytest.mark.parametrize('name', SURFACES)
def test_a_surface_is_as_cycles_shows_it(name: str, tmp_path: Path) -> None:
    assert_as_cycles(scene_of(SURFACES[name]), tmp_path, named=NAMED.get(name, ()))


@pytest.mark.parametrize('name', ROOFS)
def test_a_roof_is_as_cycles_shows_it(name: str, tmp_path: Path) -> None:
    scene = scene_of(bsdf_of_floor)
    material = scene.objects['Roof'].data.materials[0]
    compat.principled(material)
    tree = material.node_tree
    tree.nodes.clear()
    tree.links.new(ROOFS[name](tree), node(tree, 'OutputMaterial').inputs['Surface'])
    assert_as_cycles(scene, tmp_path, (material,) if name in BY_RAYS else (), NAMED.get(name, ()))


@pytest.mark.skipif(not hasattr(bpy.types, 'ShaderNodeRaycast'), reason='Blender 4.5 has no Raycast node')
@pytest.mark.parametrize('seen', ['all but raycast', 'raycast', 'shadow'])
def test_raycast_nodes_meet_what_any_ray_sees(seen: str, tmp_path: Path) -> None:
    scene = scene_of(SURFACES['raycast, is hit'])
    for ray in ('camera', 'diffuse', 'glossy', 'transmission', 'volume_scatter', 'shadow', 'raycast'):
        setattr(
            scene.objects['Roof'], f'visible_{ray}', seen == ray or (seen == 'all but raycast' and ray != 'raycast')
        )
    assert_as_cycles(scene, tmp_path)


def bsdf_of_floor(tree: Tree) -> Socket:
    return node(tree, 'BsdfDiffuse').outputs[0]
