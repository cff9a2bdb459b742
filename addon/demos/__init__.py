# SPDX-License-Identifier: GPL-3.0-or-later
"""Demo scenes that code builds, alike on every machine: `build` empties the file and leaves one scene ready to render.

They use nothing but what the engine renders; no file is read. Each scene is a module with a function `build`.
"""

from __future__ import annotations

import importlib

import bpy

from .. import choices


def build(name: str) -> bpy.types.Scene:
    """Replace everything in memory by the demo of that name (see choices.DEMOS)."""
    if name not in choices.DEMOS:
        raise KeyError(name)
    demo = importlib.import_module(f'.{name}', __package__)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.name = name
    scene.render.engine = choices.ENGINE
    scene.cotorra.settings_from = 'COTORRA'
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    scene.render.resolution_percentage = 100
    scene.view_settings.look = 'AgX - Medium High Contrast'
    demo.build(scene)
    return scene
