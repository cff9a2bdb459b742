# SPDX-License-Identifier: GPL-3.0-or-later
"""Light below 0, which Blender lets lamps, worlds and emissions have: it takes away what as much light would bring.

That Cycles shows it likewise is test_nodes_with_rays.py's, of emissions; the film sums what there is.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from cotorra import compat, demos, native

from scenes import build
from vulkan_jobs import job_of

pytestmark = pytest.mark.usefixtures('engine')


def picture(scene: bpy.types.Scene, device: str, **settings: object) -> np.ndarray:
    settings = {'integrator': 'PATH', 'max_bounces': 2, 'passes': ('combined',)} | settings
    return job_of(native.load(), scene, **settings).render(device)[0]['combined'][..., :3]


def assert_opposite(scene: bpy.types.Scene, turn: Callable[[], None], device: str) -> None:
    """The same bits, but for their sign."""
    bright = picture(scene, device)
    turn()
    assert bright.max() > 0.0
    assert np.array_equal(picture(scene, device), -bright)


def test_lamps(device: str) -> None:
    """A sun, a point and a spot light."""
    scene = demos.build('three_lights')
    scene.world = None
    lamps = [obj.data for obj in scene.objects if obj.type == 'LIGHT']

    def turn() -> None:
        for lamp in lamps:
            lamp.energy = -lamp.energy

    assert_opposite(scene, turn, device)


def floor() -> bpy.types.Scene:
    scene = build.new_scene()
    build.mesh_object(scene, 'Floor', vertices=[(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)])
    camera = build.camera(scene)
    camera.location = (0, 0, 5)
    return scene


# Graphics cards do not render area lights yet.
@pytest.mark.parametrize(
    ('kind', 'count', 'device'),
    [('AREA', 1, 'CPU'), ('AREA', 12, 'CPU'), ('POINT', 12, 'CPU'), ('POINT', 12, 'VULKAN')],
    indirect=['device'],
)
def test_lamps_all_and_picked(kind: str, count: int, device: str) -> None:
    scene = floor()
    lamps = [build.light(scene, kind, energy=30.0) for _ in range(count)]
    for k, lamp in enumerate(lamps):
        lamp.location = (0.4 * k - 2.0, 0.3, 2.0)

    def turn() -> None:
        for lamp in lamps:
            lamp.data.energy = -30.0

    assert_opposite(scene, turn, device)


def test_a_world(device: str) -> None:
    scene = floor()
    build.world(scene, (0.4, 0.4, 0.5))

    def turn() -> None:
        compat.background(scene.world).inputs['Strength'].default_value = -1.0

    assert_opposite(scene, turn, device)


def test_an_emission(device: str) -> None:
    """Rays alone find it, where light sampling finds as much light above 0: the sums are the same but for noise."""
    scene = floor()
    roof = build.mesh_object(scene, 'Roof', vertices=[(-3, -3, 2), (-1, -3, 2), (-1, 3, 2), (-3, 3, 2)])
    made = build.material()
    roof.data.materials.append(made)
    shine = build.node(made.node_tree, 'Emission')
    build.connect(made.node_tree, shine.outputs[0], build.output(made.node_tree).inputs['Surface'])
    bright = picture(scene, device, samples=64)
    shine.inputs['Strength'].default_value = -1.0
    dark = picture(scene, device, samples=64)
    assert bright.max() == pytest.approx(1.0) and dark.min() == pytest.approx(-1.0)
    assert dark.mean() == pytest.approx(-bright.mean(), rel=0.02)
