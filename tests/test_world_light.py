# SPDX-License-Identifier: GPL-3.0-or-later
"""The world as a light: what a bright spot of it brings to a floor, in closed form, and how much noise is left.

Worlds beside those of Cycles stand in test_shader_closures_rendered.py, skies in test_sky.py.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import compat, native, stats

import render_calls
from flat_scenes import node
from scenes import build
from scenes.depsgraphs import exported

pytestmark = pytest.mark.usefixtures('engine')

ALBEDO = 0.8
WIDTH, HEIGHT = 32, 16  # of the environment image


def texels(bright: float) -> np.ndarray:
    """A dim sky with one bright texel in its upper half, the lowest row first."""
    pixels = np.full((HEIGHT, WIDTH, 3), (0.2, 0.3, 0.5), np.float32)
    pixels[12, 9] += bright
    return pixels


def environment(tree: bpy.types.NodeTree, pixels: np.ndarray) -> bpy.types.NodeSocket:
    image = bpy.data.images.new('Sky', pixels.shape[1], pixels.shape[0], float_buffer=True)
    image.pixels.foreach_set(np.dstack((pixels, np.ones(pixels.shape[:2], np.float32))).ravel())
    return node(tree, 'TexEnvironment', image=image).outputs['Color']


def over_floor(sky: Callable[[bpy.types.NodeTree], bpy.types.NodeSocket]) -> bpy.types.Scene:
    """A diffuse floor that fills the picture, below this world."""
    scene = build.new_scene()
    floor = build.mesh_object(scene, 'Floor', vertices=[(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)])
    material = bpy.data.materials.new('Floor')
    compat.principled(material)
    tree = material.node_tree
    tree.nodes.clear()
    diffuse = node(tree, 'BsdfDiffuse')
    diffuse.inputs['Color'].default_value = (ALBEDO, ALBEDO, ALBEDO, 1.0)
    tree.links.new(diffuse.outputs[0], node(tree, 'OutputMaterial').inputs['Surface'])
    floor.data.materials.append(material)
    build.camera(scene).location = (0, 0, 3)
    world = scene.world = bpy.data.worlds.new('World')
    background = compat.background(world)
    world.node_tree.links.new(sky(world.node_tree), background.inputs['Color'])
    scene.render.engine = 'COTORRA'
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.resolution_percentage = 100
    scene.cotorra.integrator, scene.cotorra.samples = 'DIRECT', 16
    scene.cotorra.use_adaptive_sampling = False
    return scene


def picture(scene: bpy.types.Scene, folder: Path, device: str = 'CPU') -> np.ndarray:
    scene.cotorra.device = device
    channels = render_calls.read_exr(render_calls.render_to(scene, folder / 'world.exr'))['']
    return np.stack([channels[name] for name in 'RGB'], axis=-1)


def floor_radiance(pixels: np.ndarray, fine: int = 16) -> np.ndarray:
    """What a diffuse floor shows of the image, filtered between texels: the sum over `fine` points of each in both
    directions."""
    height, width = pixels.shape[0] * fine, pixels.shape[1] * fine
    latitude = np.pi * ((np.arange(height) + 0.5) / height - 0.5)

    def between(values: np.ndarray, count: int, axis: int) -> np.ndarray:
        at = (np.arange(count) + 0.5) * values.shape[axis] / count - 0.5
        low = np.floor(at).astype(int)
        share = (at - low).reshape((-1, 1, 1) if axis == 0 else (1, -1, 1))
        one = np.take(values, low % values.shape[axis], axis)
        return one + share * (np.take(values, (low + 1) % values.shape[axis], axis) - one)

    shown = between(between(pixels.astype(float), height, 0), width, 1)
    cosine = np.maximum(np.sin(latitude), 0.0) * np.cos(latitude)
    solid_angle = (np.pi / height) * (2.0 * np.pi / width)
    return ALBEDO / np.pi * (shown * cosine[:, None, None]).sum(axis=(0, 1)) * solid_angle


@pytest.mark.every(6)
@pytest.mark.parametrize(('method', 'resolution'), [('AUTOMATIC', 0), ('MANUAL', 64), ('MANUAL', 1024)])
def test_a_bright_texel_lights_a_floor(method: str, resolution: int, device: str, tmp_path: Path) -> None:
    pixels = texels(3000.0)
    scene = over_floor(lambda tree: environment(tree, pixels))
    scene.world.cycles.sampling_method = method
    if resolution:
        scene.world.cycles.sample_map_resolution = resolution
    shown = picture(scene, tmp_path, device)
    # 4096 samples in all: what is left of the noise is far below a percent.
    np.testing.assert_allclose(shown.mean(axis=(0, 1)), floor_radiance(pixels), rtol=0.01)
    # 16 samples see a light that fills a four-hundredth of the sky with less noise than a fifth of the mean.
    assert shown.std(axis=(0, 1)).max() < 0.2 * shown.mean()


def test_without_sampling_bounces_find_the_world(tmp_path: Path) -> None:
    scene = over_floor(lambda tree: environment(tree, texels(3000.0)))
    scene.world.cycles.sampling_method = 'NONE'
    assert exported(scene).world.resolution == -1
    shown = picture(scene, tmp_path)
    assert shown.std(axis=(0, 1)).max() > shown.mean()


@pytest.mark.every(4)
@pytest.mark.parametrize('size', [0.001, 0.05])
def test_a_sun_is_sampled_by_itself(size: float, device: str, tmp_path: Path) -> None:
    elevation = 1.0
    is_old = bpy.app.version < (5, 0, 0)

    def sky(disc: bool) -> Callable[[bpy.types.NodeTree], bpy.types.NodeSocket]:
        values = {'sun_elevation': elevation, 'sun_size': size, 'sun_disc': disc, 'altitude': 100.0}
        kind = 'NISHITA' if is_old else 'MULTIPLE_SCATTERING'
        return lambda tree: node(tree, 'TexSky', sky_type=kind, **values).outputs['Color']

    shown = picture(over_floor(sky(True)), tmp_path, device)
    without = picture(over_floor(sky(False)), tmp_path, device)
    # The disc's mean radiance, of which the dark edge leaves 1 - 0.6 / 3, over its solid angle.
    _, low, high = native.load().sky(not is_old, elevation, size, 100.0, 1.0, 1.0, 1.0)
    radiance = (1.0 - 0.6 / 3.0) * 0.5 * (np.array(low) + high)
    sun = ALBEDO / np.pi * radiance * (np.pi * (0.5 * size) ** 2) * np.sin(elevation)
    np.testing.assert_allclose((shown - without).mean(axis=(0, 1)), sun, rtol=0.01)
    assert shown.std(axis=(0, 1)).max() < 0.2 * shown.mean()


@pytest.mark.parametrize(('bright', 'sampled'), [(0.0, False), (0.02, False), (3000.0, True)])
def test_a_world_that_hardly_varies_is_not_sampled(bright: float, sampled: bool, tmp_path: Path) -> None:
    scene = over_floor(lambda tree: environment(tree, texels(bright)))
    picture(scene, tmp_path)
    (layer,) = stats.last(scene.name)
    assert ('world as a light' in layer.features) == sampled


@pytest.mark.parametrize('bad', [np.nan, np.inf, -1e6, 1e30])
def test_texels_of_no_number_leave_a_picture(bad: float, tmp_path: Path) -> None:
    pixels = texels(3000.0)
    pixels[13, 20] = bad
    shown = picture(over_floor(lambda tree: environment(tree, pixels)), tmp_path)
    assert np.isfinite(shown).all()


def test_an_image_of_one_texel_is_a_plain_world(tmp_path: Path) -> None:
    scene = over_floor(lambda tree: environment(tree, np.full((1, 1, 3), 0.5, np.float32)))
    np.testing.assert_allclose(picture(scene, tmp_path), ALBEDO * 0.5, rtol=1e-3)
