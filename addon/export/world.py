# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: its shader, and which rays see it.

What its node tree says is told in addon/shader/.
"""

from __future__ import annotations

import bpy

from .. import cycles_settings
from ..log import Log
from .buffers import (
    VISIBLE_CAMERA,
    VISIBLE_DIFFUSE,
    VISIBLE_GLOSSY,
    VISIBLE_SHADOW,
    VISIBLE_TRANSMISSION,
    VISIBLE_VOLUME,
    World,
)
from .shaders import ShaderTable
from .studio import Studio, studio_shader

NO_SUN = (0.0, 0.0, 1.0, 0.0)
MAX_BOUNCES = 1024

VISIBILITY = {
    'camera': VISIBLE_CAMERA,
    'diffuse': VISIBLE_DIFFUSE,
    'glossy': VISIBLE_GLOSSY,
    'transmission': VISIBLE_TRANSMISSION,
    'scatter': VISIBLE_VOLUME,
}


def read_world(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    groups: dict[str, int],
    log: Log,
    shaders: ShaderTable,
    studio: Studio | None = None,
) -> World:
    """The world of a view layer; black where there is none or the layer leaves it out ('Environment' in its filter).

    studio: what a viewport shows instead.
    """
    world = getattr(view_layer, 'world_override', None) or scene.world  # 5.x can override it
    if studio is not None:
        color = tuple(world.color) if world is not None else (0.0, 0.0, 0.0)
        draft = studio_shader(studio, color, shaders.images, lambda text: log.warning(f'Studio light: {text}'))
        return World((1.0, 1.0, 1.0), shader=shaders.add(draft, []), name='studio light')
    if world is None or not view_layer.use_sky:
        return World()
    cycles_settings.warn_world(world, scene, log)
    flags = getattr(world, 'cycles_visibility', None)  # absent where the Cycles add-on is disabled
    visibility = VISIBLE_SHADOW | sum(bit for name, bit in VISIBILITY.items() if getattr(flags, name, True))
    group = groups.get(world.lightgroup, -1)

    def warn(text: str) -> None:
        log.warning(f'World "{world.name}": {text}')

    shader = shaders.index(world, warn)
    settings = getattr(world, 'cycles', None)
    sun = next(iter(shaders.suns[shader]), NO_SUN)
    return World(
        (1.0, 1.0, 1.0), visibility, group, shader, world.name, _resolution(settings), _max_bounces(settings), sun
    )


def _resolution(settings: object | None) -> int:
    """Of the table by which the world is sampled: 0 = as its images have it, -1 = it is not."""
    match getattr(settings, 'sampling_method', 'AUTOMATIC'):
        case 'NONE':
            return -1
        case 'MANUAL':
            return settings.sample_map_resolution
    return 0


def _max_bounces(settings: object | None) -> int:
    """Cycles limits the samples of the world alone: where there are none, there is no limit."""
    if getattr(settings, 'sampling_method', 'NONE') == 'NONE':
        return MAX_BOUNCES
    return settings.max_bounces
