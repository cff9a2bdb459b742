# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lights of each shape, near and far, spread out and narrow, in mirrors and behind glass, beside Cycles.

What the exporter makes of their settings is test_export_lights.py's, and how they are sampled test_area_sampling.py's.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi, radians
from pathlib import Path

import bpy
import pytest

from light_scenes import assert_as_cycles, ball, box, corner, hang, square
from scenes import build

pytestmark = pytest.mark.usefixtures('engine')

GLOSSY = {'Roughness': 0.35, 'Metallic': 1.0}
MIRROR = {'Roughness': 0.0, 'Metallic': 1.0}


def plain(**settings: object) -> Callable[[], bpy.types.Scene]:
    def made() -> bpy.types.Scene:
        scene = corner()
        box(scene)
        hang(scene, 'AREA', **settings)
        return scene

    return made


def on(floor: dict[str, float], **settings: object) -> Callable[[], bpy.types.Scene]:
    """Over a floor that shows the light."""

    def made() -> bpy.types.Scene:
        scene = corner(floor)
        hang(scene, 'AREA', rotation=(-0.9, 0, 0), location=(0.2, 1.5, 1.5), **settings)
        return scene

    return made


def in_a_ball(**inputs: object) -> Callable[[], bpy.types.Scene]:
    def made() -> bpy.types.Scene:
        scene = corner()
        ball(scene, **inputs)
        hang(scene, 'AREA', shape='DISK', size=1.5)
        return scene

    return made


def near_a_wall(**settings: object) -> Callable[[], bpy.types.Scene]:
    """A centimetre from the wall, along it or toward it."""

    def made() -> bpy.types.Scene:
        scene = corner()
        hang(scene, 'AREA', location=(0.0, 1.99, 1.2), energy=20.0, **settings)
        return scene

    return made


def behind_glass() -> bpy.types.Scene:
    scene = corner()
    glass = build.material('Glass', Transmission_Weight=1.0, Roughness=0.0)
    square(scene, 'Pane', 3, glass).location = (0, 0, 2.0)
    hang(scene, 'AREA', size=1.0, location=(0.3, -0.5, 3.0))
    return scene


def seen_by_the_camera(**settings: object) -> Callable[[], bpy.types.Scene]:
    def made() -> bpy.types.Scene:
        scene = corner()
        hang(scene, 'AREA', rotation=(radians(70), 0.3, 0), location=(0, 1.0, 1.2), energy=30.0, seen=True, **settings)
        return scene

    return made


def by_kind(**flags: bool) -> Callable[[], bpy.types.Scene]:
    def made() -> bpy.types.Scene:
        scene = corner({'Roughness': 0.3, 'Specular_IOR_Level': 0.8})
        obj = hang(scene, 'AREA', size=1.0)
        for name, value in flags.items():
            setattr(obj, name, value)
        hang(scene, 'SUN', energy=0.5)
        return scene

    return made


def without_multiple_importance() -> bpy.types.Scene:
    scene = corner({'Roughness': 0.3, 'Specular_IOR_Level': 0.8})
    obj = hang(scene, 'AREA', size=0.6, seen=True, rotation=(radians(70), 0.3, 0), location=(0, 1.0, 1.2))
    obj.data.cycles.use_multiple_importance_sampling = False
    return scene


def with_two_bounces(bounces: int) -> Callable[[], bpy.types.Scene]:
    def made() -> bpy.types.Scene:
        scene = corner()
        box(scene)
        hang(scene, 'AREA', size=0.7).data.cycles.max_bounces = bounces
        return scene

    return made


def many() -> bpy.types.Scene:
    """More than are all sampled at the first vertex."""
    scene = corner({'Roughness': 0.4, 'Specular_IOR_Level': 0.5})
    for k in range(12):
        shape = ('SQUARE', 'ELLIPSE')[k % 2]
        hang(
            scene,
            'AREA',
            location=(k % 4 - 1.5, k // 4 - 1.0, 1.0 + 0.2 * k),
            rotation=(0.3 * k, 0.1 * k, 0),
            shape=shape,
            size=0.3,
            size_y=0.6,
            spread=pi - 0.2 * k,
            energy=10.0,
        )
    return scene


SCENES: dict[str, Callable[[], bpy.types.Scene]] = {
    'square': plain(size=0.7),
    'rectangle': plain(shape='RECTANGLE', size=2.0, size_y=0.2),
    'disk': plain(shape='DISK', size=1.0),
    'ellipse': plain(shape='ELLIPSE', size=0.4, size_y=1.6),
    'far away': plain(shape='DISK', size=0.5, location=(0, -20, 20), rotation=(pi / 4, 0, 0), energy=5000.0),
    'large': plain(size=9.0, location=(0, 0, 3.0), rotation=(0, 0, 0), energy=300.0),
    'not normalized': plain(size=0.7, normalize=False, energy=20.0),
    'scaled': plain(shape='RECTANGLE', size=0.5, size_y=0.5, scale=(3.0, 0.5, 2.0)),
    'turned over by its scale': plain(size=0.7, scale=(1.0, 1.0, -1.0), rotation=(pi, 0.3, 0.0)),
    'spread 120': plain(size=0.7, spread=radians(120)),
    'spread 60, ellipse': plain(shape='ELLIPSE', size=0.7, size_y=1.4, spread=radians(60)),
    'spread 20, disk': plain(shape='DISK', size=1.0, spread=radians(20)),
    'spread 3': plain(size=1.0, spread=radians(3)),
    'spread 0.5': plain(shape='DISK', size=1.5, spread=radians(0.5)),
    'spread 0': plain(shape='DISK', size=1.5, spread=0.0),
    'no shadow': plain(size=0.7, use_shadow=False),
    'along a wall': near_a_wall(size=0.5, rotation=(0, 0, 0)),
    'toward a wall': near_a_wall(size=0.5, rotation=(-pi / 2, 0, 0)),
    'toward a wall, disk': near_a_wall(shape='DISK', size=0.5, rotation=(-pi / 2, 0, 0)),
    'glossy floor': on(GLOSSY, size=1.0),
    'glossy floor, spread': on(GLOSSY, shape='ELLIPSE', size=1.0, size_y=0.5, spread=radians(90)),
    'coated floor': on({'Roughness': 0.5, 'Coat_Weight': 1.0, 'Specular_IOR_Level': 0.5}, shape='DISK', size=1.0),
    'mirror': on(MIRROR, size=1.0),
    'mirror ball': in_a_ball(**MIRROR),
    'glass ball': in_a_ball(Transmission_Weight=1.0, Roughness=0.1),
    'plastic ball': in_a_ball(Base_Color=(0.8, 0.1, 0.1, 1), Roughness=0.3),
    'behind glass': behind_glass,
    'seen': seen_by_the_camera(shape='RECTANGLE', size=1.5, size_y=0.5),
    'seen, spread': seen_by_the_camera(shape='ELLIPSE', size=1.5, size_y=1.0, spread=radians(120)),
    'seen from behind': plain(size=1.0, rotation=(-radians(70), 0, 0), location=(0, 0.5, 1.2), seen=True),
    'without multiple importance': without_multiple_importance,
    'hidden from diffuse rays': by_kind(visible_diffuse=False),
    'hidden from glossy rays': by_kind(visible_glossy=False),
    'one bounce': with_two_bounces(0),
    'many': many,
}


@pytest.mark.every(4)
@pytest.mark.parametrize('name', SCENES)
def test_an_area_light_is_as_cycles_shows_it(name: str, tmp_path: Path) -> None:
    assert_as_cycles(SCENES[name](), tmp_path)
