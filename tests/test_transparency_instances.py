# SPDX-License-Identifier: GPL-3.0-or-later
"""What objects that share a mesh let through depends on the direction that rays have in the world, not in the mesh.

Squares whose backs are clear lie above a floor, each turned in its own way; the camera and the sun are above.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, radians
from pathlib import Path

import bpy
import numpy as np
import pytest

from beside_cycles import in_halves
from flat_scenes import Flat, flat
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

SIZE = 32
FLOOR = 0.5  # its colour; a sun of energy pi gives a white floor radiance 1
SHADOW = 4.0  # metres that the sun moves shadows along y
TURNS = [(0.0, 0.0, 0.0), (pi, 0.0, 0.0), (0.0, pi, 0.3), (radians(100), 0.0, 0.0)]
SCALES = [(1.0, 1.0, 1.0), (1.2, 0.7, 3.0), (1.0, 1.0, -1.0)]


def squares(turns: Sequence[tuple[float, float, float]], scale: tuple[float, float, float]) -> Flat:
    """Squares of one mesh, a metre wide, at x = 0, 2, 4 and so on, half a metre above the floor."""
    made = flat()
    scene = made.scene
    made.obj.scale = (0.16, 0.16, 1.0)
    data = build.mesh('Shared', vertices=[(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)])
    data.materials.append(made.obj.data.materials[0])
    scene.collection.objects.unlink(made.obj)
    for index, turn in enumerate(turns):
        obj = build.link(scene, f'Square {index}', data)
        obj.location, obj.rotation_euler, obj.scale = (2.0 * index, 0.0, 0.5), turn, scale
    floor = build.mesh_object(scene, 'Floor', vertices=[(-9, -9, 0), (19, -9, 0), (19, 9, 0), (-9, 9, 0)])
    floor.data.materials.append(build.material('Floor', Base_Color=(FLOOR,) * 3 + (1,), Specular_IOR_Level=0.0))
    return made


def clear_behind(made: Flat) -> None:
    mixed, clear = made.node('MixShader'), made.node('BsdfTransparent')
    made.link(made.node('NewGeometry').outputs['Backfacing'], mixed.inputs['Fac'])
    made.link(made.emission.outputs[0], mixed.inputs[1])
    made.link(clear.outputs[0], mixed.inputs[2])
    made.link(mixed.outputs[0], made.output.inputs['Surface'])


def clear_by_incoming(made: Flat) -> None:
    """As clear as the ray is steep."""
    mixed, clear = made.node('MixShader'), made.node('BsdfTransparent')
    apart = made.node('SeparateXYZ')
    made.link(made.node('NewGeometry').outputs['Incoming'], apart.inputs[0])
    made.link(apart.outputs['Z'], mixed.inputs['Fac'])
    made.link(made.emission.outputs[0], mixed.inputs[1])
    made.link(clear.outputs[0], mixed.inputs[2])
    made.link(mixed.outputs[0], made.output.inputs['Surface'])


def lit(made: Flat, tilt: float) -> None:
    """A sun that leans by `tilt` along y, and a camera that looks straight down on all that there is."""
    build.light(made.scene, 'SUN', energy=pi, angle=0.0).rotation_euler.x = tilt
    camera = made.scene.camera
    camera.location = (3.0, 0.0, 9.0)
    camera.data.type, camera.data.ortho_scale = 'ORTHO', 8.0


def picture(engine: str, folder: Path, samples: int = 32) -> np.ndarray:
    return in_halves(bpy.context.scene, engine, folder, 0, (SIZE, SIZE), samples).image


def at(image: np.ndarray, x: float, y: float) -> np.ndarray:
    """The pixels around a place on the floor."""
    column, row = (round((place + 4.0) * SIZE / 8.0) for place in (x - 3.0, -y))
    return image[row - 1 : row + 1, column - 1 : column + 1].mean((0, 1))


def test_backs_are_clear_to_the_camera_and_fronts_to_the_sun(tmp_path: Path) -> None:
    """Seen from above; light that comes up from the floor to the sun meets the other side."""
    made = squares([(0.0, 0.0, 0.0), (pi, 0.0, 0.0)], (1.0, 1.0, 1.0))
    clear_behind(made)
    made.emission.inputs['Color'].default_value = (0.0, 0.0, 0.0, 1.0)  # it would light the floor
    lit(made, np.arctan(SHADOW))
    seen = picture('COTORRA', tmp_path)
    assert not at(seen, 0.0, 0.0).any()
    sun = FLOOR / np.sqrt(1.0 + SHADOW**2)
    np.testing.assert_allclose(at(seen, 2.0, 0.0), sun, rtol=1e-2)
    # The sun leans along y, on the side that its rotation says: shadows lie half of SHADOW away.
    for x, light in ((0.0, sun), (2.0, 0.0)):
        beside = [at(seen, x, y).max() for y in (-0.5 * SHADOW, 0.5 * SHADOW)]
        np.testing.assert_allclose(min(beside), light, rtol=1e-2, atol=1e-6)


@pytest.mark.parametrize('clear', [clear_behind, clear_by_incoming])
@pytest.mark.parametrize('scale', SCALES)
def test_as_cycles_shows_them(clear: object, scale: tuple[float, float, float], tmp_path: Path) -> None:
    made = squares(TURNS, scale)
    clear(made)
    lit(made, 0.6)
    ours, theirs = (picture(engine, tmp_path, 64) for engine in ('COTORRA', 'CYCLES'))
    means = [image.reshape(8, 4, 8, 4, 3).mean((1, 3)) for image in (ours, theirs)]
    np.testing.assert_allclose(*means, rtol=0.05, atol=0.02)
