# SPDX-License-Identifier: GPL-3.0-or-later
"""A sphere of each BSDF node, of Principled with each of its layers and of sums of them, beside the pictures of Cycles.

What each node's values are is test_ops_cycles.py's, and what a closure does by itself test_closures_cycles.py's.
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
from flat_scenes import assert_as_cycles as assert_flat_as_cycles
from flat_scenes import flat, node
from render_calls import read_exr
from scenes import build

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'scripts'))
from cotorra.metrics import Reference, same_image

from benchmark.fair import make_fair, set_job

pytestmark = [
    pytest.mark.usefixtures('engine'),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason='the nodes are those of Blender 5.2'),
]

SIZE = (64, 48)
TILE = 8
SAMPLES = 96  # of each half
BOUNCES = 6
# What a tile and the whole may differ by beside noise.
LIMIT = 0.03
TOTAL = 0.01

Surface = Callable[[bpy.types.NodeTree], bpy.types.NodeSocket]


def bsdf(kind: str, **values: object) -> Surface:
    """A node alone: `values` are properties of it or, by their names, inputs."""

    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        found = node(tree, kind)
        for name, value in values.items():
            if name[0].islower():
                setattr(found, name, value)
            else:
                found.inputs[name.replace('_', ' ')].default_value = value
        return found.outputs[0]

    return made


def principled(**values: object) -> Surface:
    return bsdf('BsdfPrincipled', **{'Base_Color': (0.7, 0.3, 0.2, 1.0), **values})


def mix(factor: Surface | float, first: Surface, second: Surface) -> Surface:
    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        found = node(tree, 'MixShader')
        if callable(factor):
            tree.links.new(factor(tree), found.inputs[0])
        else:
            found.inputs[0].default_value = factor
        tree.links.new(first(tree), found.inputs[1])
        tree.links.new(second(tree), found.inputs[2])
        return found.outputs[0]

    return made


def add(first: Surface, second: Surface) -> Surface:
    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        found = node(tree, 'AddShader')
        tree.links.new(first(tree), found.inputs[0])
        tree.links.new(second(tree), found.inputs[1])
        return found.outputs[0]

    return made


def waves(tree: bpy.types.NodeTree, scale: float) -> bpy.types.NodeSocket:
    found = node(tree, 'TexWave')
    found.inputs['Scale'].default_value = scale
    tree.links.new(node(tree, 'TexCoord').outputs['Object'], found.inputs['Vector'])
    return found.outputs['Fac']


def bumped(scale: float, kind: str, **values: object) -> Surface:
    """A node whose normal is bent by waves."""

    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        socket = bsdf(kind, **values)(tree)
        bump = node(tree, 'Bump')
        bump.inputs['Distance'].default_value = 0.02
        tree.links.new(waves(tree, scale), bump.inputs['Height'])
        tree.links.new(bump.outputs['Normal'], socket.node.inputs['Normal'])
        return socket

    return made


def displaced(scale: float, height: float, surface: Surface) -> Surface:
    """A surface that waves displace, which is a bump map of its own."""

    def made(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        displacement = node(tree, 'Displacement')
        displacement.inputs['Scale'].default_value = height
        tree.links.new(waves(tree, scale), displacement.inputs['Height'])
        output = tree.get_output_node('CYCLES')
        tree.links.new(displacement.outputs['Displacement'], output.inputs['Displacement'])
        return surface(tree)

    return made


def backfacing(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    return node(tree, 'NewGeometry').outputs['Backfacing']


def checks(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    found = node(tree, 'TexChecker')
    found.inputs['Scale'].default_value = 4.0
    tree.links.new(node(tree, 'TexCoord').outputs['Object'], found.inputs['Vector'])
    return found.outputs['Fac']


BLUE = (0.1, 0.3, 0.8, 1.0)
DIFFUSE = bsdf('BsdfDiffuse', Color=BLUE)
GLOSSY = bsdf('BsdfAnisotropic', Roughness=0.2)
RED_GLASS = (0.9, 0.2, 0.1, 1.0)

SURFACES: dict[str, Surface] = {
    'diffuse': DIFFUSE,
    'diffuse, rough': bsdf('BsdfDiffuse', Roughness=0.7),
    'translucent': bsdf('BsdfTranslucent'),
    'glossy': bsdf('BsdfAnisotropic', Roughness=0.3),
    'glossy, GGX': bsdf('BsdfAnisotropic', distribution='GGX', Roughness=0.6),
    'glossy, Beckmann': bsdf('BsdfAnisotropic', distribution='BECKMANN', Roughness=0.3),
    'glossy, Ashikhmin-Shirley': bsdf('BsdfAnisotropic', distribution='ASHIKHMIN_SHIRLEY', Roughness=0.3),
    'glossy, anisotropic': bsdf('BsdfAnisotropic', Roughness=0.4, Anisotropy=0.7, Rotation=0.1),
    'glass, smooth': bsdf('BsdfGlass', Roughness=0.0),
    'glass, rough': bsdf('BsdfGlass', Roughness=0.4),
    'glass, film': bsdf('BsdfGlass', Roughness=0.2, Thin_Film_Thickness=400.0),
    'refraction': bsdf('BsdfRefraction', Roughness=0.3),
    'metallic': bsdf('BsdfMetallic', Roughness=0.4),
    'metallic, physical': bsdf('BsdfMetallic', fresnel_type='PHYSICAL_CONDUCTOR', Roughness=0.4),
    'sheen': bsdf('BsdfSheen'),
    'sheen, Ashikhmin': bsdf('BsdfSheen', distribution='ASHIKHMIN'),
    'toon': bsdf('BsdfToon', Smooth=0.2),
    'toon, glossy': bsdf('BsdfToon', component='GLOSSY', Smooth=0.2),
    'transparent, red': bsdf('BsdfTransparent', Color=RED_GLASS),
    'principled': principled(),
    'principled, coat': principled(Coat_Weight=1.0, Coat_Tint=(1.0, 0.8, 0.5, 1.0)),
    'principled, sheen': principled(Sheen_Weight=1.0),
    'principled, transmission': principled(Transmission_Weight=1.0),
    'principled, half transmission': principled(Transmission_Weight=0.5, Roughness=0.2),
    'principled, thin wall': principled(Transmission_Weight=0.6, Subsurface_Weight=0.5, Thin_Wall=True),
    'principled, anisotropic': principled(Metallic=1.0, Anisotropic=0.8),
    'principled, film': principled(Thin_Film_Thickness=400.0),
    'principled, diffuse roughness': principled(Diffuse_Roughness=1.0),
    'principled, alpha': principled(Alpha=0.5),
    'principled, emission': principled(Emission_Strength=1.0, Coat_Weight=1.0, Coat_Tint=(1.0, 0.5, 0.2, 1.0)),
    'mix': mix(0.4, DIFFUSE, bsdf('BsdfGlass', Roughness=0.2)),
    'mix by Fresnel': mix(bsdf('Fresnel'), DIFFUSE, GLOSSY),
    'mix by Layer Weight': mix(bsdf('LayerWeight', Blend=0.4), principled(), bsdf('BsdfSheen')),
    'mix by backfacing': mix(backfacing, bsdf('BsdfTransparent', Color=RED_GLASS), DIFFUSE),
    'bump, fine': bumped(150.0, 'BsdfDiffuse', Color=BLUE),
    'displacement, fine': displaced(150.0, 0.02, GLOSSY),
    'displacement, steep': displaced(3.0, 1.0, DIFFUSE),
    'displacement, steep, and bumps': displaced(3.0, 1.0, bumped(40.0, 'BsdfDiffuse', Color=BLUE)),
    'displacement, steep, and bumps of Principled': displaced(
        3.0, 1.0, bumped(40.0, 'BsdfPrincipled', Base_Color=BLUE, Roughness=0.7)
    ),
    'displacement, steep, and bumps under a coat': displaced(
        3.0, 1.0, bumped(40.0, 'BsdfPrincipled', Base_Color=BLUE, Roughness=0.7, Coat_Weight=0.5, Coat_Roughness=0.4)
    ),
    'displacement, steep, and glossy bumps': displaced(
        3.0, 1.0, bumped(40.0, 'BsdfAnisotropic', Color=BLUE, Roughness=0.5)
    ),
    'displacement, steep, and bumps of metal': displaced(3.0, 1.0, bumped(40.0, 'BsdfMetallic', Roughness=0.6)),
    'displacement, steep, and bumps of glass': displaced(3.0, 1.0, bumped(40.0, 'BsdfGlass', Roughness=0.3)),
    'displacement, steep, and translucent bumps': displaced(3.0, 1.0, bumped(40.0, 'BsdfTranslucent')),
    'displacement and translucent bumps': displaced(3.0, 0.2, bumped(40.0, 'BsdfTranslucent')),
    'displacement, steep, and bumps of velvet': displaced(
        3.0, 1.0, bumped(40.0, 'BsdfSheen', distribution='ASHIKHMIN')
    ),
    'displacement, steep, and bumps of microfibers': displaced(3.0, 1.0, bumped(40.0, 'BsdfSheen')),
    'displacement, steep, and bumps of toon': displaced(
        3.0, 1.0, bumped(40.0, 'BsdfToon', component='GLOSSY', Smooth=0.2)
    ),
    'displacement, steep, of cloth': displaced(3.0, 1.0, bsdf('BsdfSheen', distribution='ASHIKHMIN')),
    'add': add(DIFFUSE, bsdf('Emission', Color=RED_GLASS, Strength=0.5)),
    'add beside what is clear in places': add(
        mix(checks, DIFFUSE, bsdf('BsdfTransparent')), bsdf('Emission', Color=RED_GLASS, Strength=0.3)
    ),
    'refraction that bends nothing': bsdf('BsdfRefraction', Roughness=0.5, IOR=1.0),
    'glass, roughest': bsdf('BsdfGlass', Roughness=0.9),
    'add of glossy and transparent': add(bsdf('BsdfAnisotropic', Color=BLUE, Roughness=0.4), bsdf('BsdfTransparent')),
}


def sky_of_gradient(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    ramp, place = node(tree, 'TexGradient'), node(tree, 'TexCoord')
    turned = node(tree, 'Mapping')
    turned.inputs['Rotation'].default_value = (0.0, 1.2, 0.3)
    tree.links.new(place.outputs['Generated'], turned.inputs[0])
    tree.links.new(turned.outputs[0], ramp.inputs[0])
    return ramp.outputs['Color']


def sky_of_image(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """A few soft clouds, 32 by 16 texels."""
    image = bpy.data.images.new('Sky', 32, 16, float_buffer=True)
    x, y = np.meshgrid(np.arange(32) / 32, np.arange(16) / 16)
    pixels = np.ones((16, 32, 4), np.float32)
    for channel, turns in enumerate((1, 2, 3)):
        pixels[..., channel] = 0.6 + 0.4 * np.sin(2 * np.pi * (turns * x + 0.2 * channel)) * np.sin(np.pi * y)
    image.pixels.foreach_set(pixels.ravel())
    return node(tree, 'TexEnvironment', image=image).outputs['Color']


def sky_with_a_sun(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    """An image with a bright spot, turned and tilted."""
    image = bpy.data.images.new('Sun', 64, 32, float_buffer=True)
    pixels = np.full((32, 64, 4), (0.2, 0.3, 0.5, 1.0), np.float32)
    pixels[24:26, 20:22, :3] = (900.0, 800.0, 600.0)
    image.pixels.foreach_set(pixels.ravel())
    turned = node(tree, 'Mapping')
    turned.inputs['Rotation'].default_value = (0.3, 0.2, 1.0)
    tree.links.new(node(tree, 'TexCoord').outputs['Generated'], turned.inputs['Vector'])
    environment = node(tree, 'TexEnvironment', image=image)
    tree.links.new(turned.outputs['Vector'], environment.inputs['Vector'])
    return environment.outputs['Color']


def sky_of_mirror_ball(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    color = sky_of_image(tree)
    color.node.projection = 'MIRROR_BALL'
    return color


def sky_of_air(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
    sky = node(tree, 'TexSky', sky_type='MULTIPLE_SCATTERING', sun_elevation=0.6, sun_rotation=2.0)
    return _scaled(tree, sky.outputs['Color'], 0.05)


def _scaled(tree: bpy.types.NodeTree, color: bpy.types.NodeSocket, factor: float) -> bpy.types.NodeSocket:
    scaled = node(tree, 'VectorMath', operation='SCALE')
    scaled.inputs['Scale'].default_value = factor
    tree.links.new(color, scaled.inputs[0])
    return scaled.outputs[0]


def _split(output: str, others: Surface) -> Surface:
    """Rays of one kind see a plain red sky."""

    def sky(tree: bpy.types.NodeTree) -> bpy.types.NodeSocket:
        mixed = node(tree, 'Mix', data_type='RGBA')
        inputs = {socket.identifier: socket for socket in mixed.inputs}
        tree.links.new(node(tree, 'LightPath').outputs[output], inputs['Factor_Float'])
        tree.links.new(others(tree), inputs['A_Color'])
        inputs['B_Color'].default_value = (0.8, 0.1, 0.1, 1.0)
        return next(socket for socket in mixed.outputs if socket.identifier == 'Result_Color')

    return sky


SKIES: dict[str, Surface] = {
    'gradient': sky_of_gradient,
    'image': sky_of_image,
    'a sun': sky_with_a_sun,
    'mirror ball': sky_of_mirror_ball,
    'air': sky_of_air,
    'the camera sees another': _split('Is Camera Ray', sky_with_a_sun),
}


def scene_of(surface: Surface, sky: Surface | None = None) -> bpy.types.Scene:
    """A sphere of the surface over an ochre floor, in a soft sun and a grey or other sky."""
    scene = build.new_scene()
    scene.world = bpy.data.worlds.new('World')
    background = compat.background(scene.world)
    background.inputs['Color'].default_value = (0.5, 0.5, 0.5, 1.0)
    if sky is not None:
        tree = scene.world.node_tree
        tree.links.new(sky(tree), background.inputs['Color'])

    floor = build.mesh_object(scene, 'Floor', vertices=[(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)])
    floor.data.materials.append(bpy.data.materials.new('Floor'))
    ground = compat.principled(floor.data.materials[0])
    ground.inputs['Base Color'].default_value, ground.inputs['Roughness'].default_value = (0.6, 0.5, 0.3, 1.0), 1.0

    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, location=(0, 0, 1.2))
    sphere = bpy.context.object
    sphere.data.shade_smooth()
    material = bpy.data.materials.new('Surface')
    compat.principled(material)
    tree = material.node_tree
    tree.nodes.clear()
    output = node(tree, 'OutputMaterial')
    tree.links.new(surface(tree), output.inputs['Surface'])
    sphere.data.materials.append(material)

    build.light(scene, 'SUN', energy=2.0, angle=0.3).rotation_euler = (0.6, 0.3, 0.0)
    camera = build.camera(scene)
    camera.location = (0, -5, 2.5)
    camera.rotation_euler = (Vector((0, 0, 1)) - camera.location).to_track_quat('-Z', 'Y').to_euler()
    return scene


def picture(scene: bpy.types.Scene, engine: str, folder: Path) -> Reference:
    return in_halves(scene, engine, folder, BOUNCES, SIZE, SAMPLES)


def assert_as_cycles(scene: bpy.types.Scene, folder: Path) -> None:
    ours = picture(scene, 'COTORRA', folder)
    warnings = [text for layer in stats.last(scene.name) for text in layer.warnings]
    assert not warnings
    assert_same(ours, picture(scene, 'CYCLES', folder))


def assert_same(ours: Reference, theirs: Reference) -> None:
    same = same_image(ours, theirs, LIMIT, TILE)
    told = f'in total {same.total:+.4f} ± {same.total_noise:.4f}, worst tile {same.worst}, noise {same.noise:.4f}'
    assert same.bad == 0, told
    assert same.beyond_noise == 0, f'{told}\n{np.round(100 * same.tiles).astype(int)} %'
    assert abs(same.total) <= TOTAL + 3 * same.total_noise, told


@pytest.mark.every(3)
@pytest.mark.parametrize('name', SURFACES)
def test_a_surface_is_as_cycles_shows_it(name: str, tmp_path: Path) -> None:
    assert_as_cycles(scene_of(SURFACES[name]), tmp_path)


@pytest.mark.every(3)
@pytest.mark.parametrize('name', SKIES)
def test_a_world_with_nodes_is_as_cycles_shows_it(name: str, tmp_path: Path) -> None:
    assert_as_cycles(scene_of(principled(Roughness=0.4), SKIES[name]), tmp_path)


def test_glossy_rays_may_see_another_world(tmp_path: Path) -> None:
    """Cycles samples then what no kind of ray sees: it is right where bounces alone find its world."""
    scene = scene_of(principled(Roughness=0.4, Metallic=0.5), _split('Is Glossy Ray', sky_of_image))
    ours = picture(scene, 'COTORRA', tmp_path)
    scene.world.cycles.sampling_method = 'NONE'
    assert_same(ours, picture(scene, 'CYCLES', tmp_path))


@pytest.mark.parametrize(
    ('output', 'surface'),
    [
        ('Is Glossy Ray', bsdf('BsdfGlass', Roughness=0.3)),
        ('Is Glossy Ray', bsdf('BsdfRefraction', Roughness=0.0)),
        ('Is Diffuse Ray', bsdf('BsdfTranslucent')),
    ],
    ids=['rough glass', 'refraction', 'translucent'],
)
def test_rays_that_went_through_are_of_their_lobe(output: str, surface: Surface, tmp_path: Path) -> None:
    scene = scene_of(surface, _split(output, sky_of_image))
    ours = picture(scene, 'COTORRA', tmp_path)
    scene.world.cycles.sampling_method = 'NONE'
    assert_same(ours, picture(scene, 'CYCLES', tmp_path))


def test_the_world_is_one_bounce_on(tmp_path: Path) -> None:
    made = flat()
    made.obj.hide_render = True
    build.world(made.scene)
    tree = made.scene.world.node_tree
    background = compat.background(made.scene.world)
    tree.links.new(node(tree, 'LightPath').outputs['Ray Depth'], background.inputs['Color'])
    background.inputs['Strength'].default_value = 1.0
    assert assert_flat_as_cycles(tmp_path) == pytest.approx((1.0, 1.0, 1.0))


def test_the_film_behind_a_tint(tmp_path: Path) -> None:
    """Of a transparent film a surface covers as much as it takes of the light that goes through."""
    made = flat()
    clear = made.node('BsdfTransparent')
    clear.inputs['Color'].default_value = (0.9, 0.4, 0.2, 1.0)
    made.link(clear.outputs[0], made.output.inputs['Surface'])
    build.world(made.scene)
    made.scene.render.film_transparent = True
    alphas = []
    for engine in ('COTORRA', 'CYCLES'):
        make_fair(made.scene, engine, BOUNCES, (4, 4), threads=1)
        path = tmp_path / f'{engine}.exr'
        set_job(made.scene, 4, 1, str(path))
        bpy.ops.render.render(write_still=True)
        alphas.append(read_exr(path)['']['A'][1:3, 1:3].mean())
    assert alphas == pytest.approx([0.5, 0.5], rel=1e-4)
