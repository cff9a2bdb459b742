# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole road, from a scene through the real native module to the pixels that Blender saves, where they are known.

Noise, materials and equality with Cycles are other tests'.
"""

from __future__ import annotations

import math
import threading
import time
from pathlib import Path

import bpy
import numpy as np
import pytest
from cotorra import demos, stats, watch

from render_calls import here, read_exr, render_to
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')


@pytest.fixture
def scene() -> bpy.types.Scene:
    """A square of side 2 at the origin, seen from 5 m above by an orthographic camera 4 m wide."""
    made = build.new_scene()
    camera = build.camera(made, type='ORTHO', ortho_scale=4.0)
    camera.location = (0.0, 0.0, 5.0)
    square = build.mesh_object(made, 'Square', vertices=[], faces=[])
    square.data = build.grid(1)
    square.pass_index = 3
    square.data.materials.append(build.material('Red', Base_Color=(0.5, 0.25, 0.125, 1), Roughness=1.0))
    square.data.materials[0].pass_index = 7
    made.render.engine = 'COTORRA'
    made.render.resolution_x = made.render.resolution_y = 64
    made.cotorra.samples = 4
    return made


def image(scene: bpy.types.Scene, path: Path) -> dict[str, np.ndarray]:
    """Combined, top row first."""
    return read_exr(render_to(scene, path / 'image.exr'))['']


INSIDE = (slice(20, 44), slice(20, 44))  # of the square, off its edges
OUTSIDE = (slice(0, 12), slice(0, 64))


def test_data_passes_hold_what_their_names_say(scene, tmp_path):
    layer = scene.view_layers[0]
    for name in ('z', 'position', 'normal', 'uv', 'object_index', 'material_index', 'diffuse_color', 'environment'):
        setattr(layer, f'use_pass_{name}', True)
    build.world(scene, (0.2, 0.4, 0.8), 0.5)
    found = read_exr(render_to(scene, tmp_path / 'image.exr', multilayer=True))

    def values(name, channel, where):
        return found[f'ViewLayer.{here(name)}'][channel][where]

    # Pixel x of 64 sees -2 + 4 (x + 1/2) / 64 m, give or take the filter's width of 1.5 pixels.
    across = np.broadcast_to(-2.0 + (np.arange(64) + 0.5) / 16.0, (64, 64))
    pixel = 1.5 / 16.0
    assert np.all(values('Depth', 'Z', INSIDE) == pytest.approx(5.0, abs=1e-4))
    assert np.abs(values('Position', 'X', INSIDE) - across[INSIDE]).max() < pixel
    assert np.abs(values('Position', 'Y', INSIDE) - across.T[::-1][INSIDE]).max() < pixel
    assert np.abs(values('Position', 'Z', INSIDE)).max() < 1e-5
    for channel, value in zip('XYZ', (0.0, 0.0, 1.0), strict=True):
        assert np.all(values('Normal', channel, INSIDE) == pytest.approx(value, abs=1e-5))
    assert np.abs(values('UV', 'U', INSIDE) - (across[INSIDE] + 1.0) / 2.0).max() < pixel / 2.0
    assert np.abs(values('UV', 'V', INSIDE) - (across.T[::-1][INSIDE] + 1.0) / 2.0).max() < pixel / 2.0
    assert np.all(values('UV', 'A', INSIDE) == 1.0)
    assert np.all(values('Object Index', 'X', INSIDE) == 3.0)
    assert np.all(values('Material Index', 'X', INSIDE) == 7.0)
    assert np.all(values('Object Index', 'X', OUTSIDE) == 0.0)
    assert values('Diffuse Color', 'R', INSIDE).mean() == pytest.approx(0.5, rel=0.1)
    assert np.all(values('Depth', 'Z', OUTSIDE) > 1e9)
    for channel, value in zip('RGB', (0.1, 0.2, 0.4), strict=True):
        assert np.all(values('Environment', channel, OUTSIDE) == pytest.approx(value, rel=1e-5))
        assert np.all(values('Environment', channel, INSIDE) == 0.0)
        assert np.all(values('Combined', channel, OUTSIDE) == pytest.approx(value, rel=1e-5))


def test_a_transparent_film_has_alpha(scene, tmp_path):
    build.world(scene, (1.0, 1.0, 1.0))
    opaque = image(scene, tmp_path)
    assert np.all(opaque['A'] == 1.0) and np.all(opaque['R'][OUTSIDE] == 1.0)
    scene.render.film_transparent = True
    through = image(scene, tmp_path)
    assert np.all(through['A'][OUTSIDE] == 0.0) and np.all(through['R'][OUTSIDE] == 0.0)
    assert np.all(through['A'][INSIDE] == 1.0)
    assert np.array_equal(through['R'][INSIDE], opaque['R'][INSIDE])


def test_light_groups_add_up_to_the_image(scene, tmp_path):
    layer = scene.view_layers[0]
    build.world(scene, (0.2, 0.4, 0.8)).lightgroup = 'World'
    sun = build.light(scene, 'SUN', energy=2.0)
    point = build.light(scene, 'POINT', energy=100.0)
    point.location = (0.5, 0.5, 2.0)
    sun.lightgroup, point.lightgroup = 'Sun', 'Point'
    for name in ('Sun', 'Point', 'World'):
        layer.lightgroups.add(name=name)
    found = read_exr(render_to(scene, tmp_path / 'image.exr', multilayer=True))
    for channel in 'RGB':
        groups = [found[f'ViewLayer.Combined_{name}'][channel] for name in ('Sun', 'Point', 'World')]
        assert all(group[INSIDE].min() > 0.0 for group in groups)
        assert np.allclose(sum(groups), found['ViewLayer.Combined'][channel], rtol=1e-4, atol=1e-5)


def test_view_layers_show_their_own_collections(scene, tmp_path):
    other = bpy.data.collections.new('Other')
    scene.collection.children.link(other)
    square = bpy.data.objects['Square']
    scene.collection.objects.unlink(square)
    other.objects.link(square)
    without = scene.view_layers.new('Without')
    without.layer_collection.children['Other'].exclude = True
    scene.render.film_transparent = True
    found = read_exr(render_to(scene, tmp_path / 'image.exr', multilayer=True))
    assert np.all(found['ViewLayer.Combined']['A'][INSIDE] == 1.0)
    assert np.all(found['Without.Combined']['A'] == 0.0)


def test_frames_of_an_animation_differ(scene, tmp_path):
    square = bpy.data.objects['Square']
    square.keyframe_insert('location', frame=1)
    square.location.x = 10.0
    square.keyframe_insert('location', frame=2)
    scene.render.film_transparent = True
    scene.frame_set(1)
    assert np.all(image(scene, tmp_path)['A'][INSIDE] == 1.0)
    scene.frame_set(2)
    assert np.all(image(scene, tmp_path)['A'] == 0.0)


def test_same_bits_whatever_the_threads(tmp_path):
    scene = demos.build('box_room')
    scene.render.resolution_x, scene.render.resolution_y = 96, 54
    scene.cotorra.samples = 4
    scene.render.threads_mode = 'FIXED'
    images = []
    for threads in (1, 2, 3):
        scene.render.threads = threads
        images.append(image(scene, tmp_path))
    for channel in 'RGBA':
        assert np.array_equal(images[0][channel], images[1][channel])
        assert np.array_equal(images[0][channel], images[2][channel])
    scene.cotorra.seed = 1
    assert not np.array_equal(images[0]['R'], image(scene, tmp_path)['R'])


@pytest.mark.parametrize('integrator', ['DIRECT', 'PATH'])
def test_a_real_render_stops_soon_and_keeps_its_image(tmp_path, integrator):
    class Impatient(watch.Watcher):
        stop_time = math.inf
        spent = math.inf  # seconds of all cores, when the wish was seen

        @property
        def stop(self):
            if time.perf_counter() <= self.stop_time:
                return False
            self.spent = min(self.spent, time.process_time())
            return True

        def progress(self, state):
            if state.phase == 'Rendering' and self.stop_time == math.inf:
                self.stop_time = time.perf_counter() + 1.0

    scene = demos.build('box_room')
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    scene.cotorra.samples = 100000
    scene.cotorra.integrator = integrator
    scene.render.threads_mode, scene.render.threads = 'FIXED', 2
    late = math.inf
    for _ in range(3):
        with watch.attached(Impatient()) as watcher:
            bpy.ops.render.render()
            late = min(late, time.process_time() - watcher.spent)
        if late < 0.4:
            break
    # 0.2 s of two cores. Seconds of the clock would tell what else the machine does, which can only delay it.
    assert late < 0.4
    (entry,) = stats.last(scene.name)
    assert entry.interrupted and 0.0 < entry.progress < 1.0
    assert not any(thread.name == 'cotorra build' for thread in threading.enumerate())
