# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of scenes for tests: as the viewport sees them, and from inside a final render as an engine sees them.

The engine here renders nothing: it hands its depsgraph on. Cotorra is registered, since its settings are exported.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import cotorra
from cotorra import export
from cotorra.export.buffers import Camera, SceneBuffers
from cotorra.log import Log

cotorra.register()


def exported(scene: bpy.types.Scene, log: Log | None = None) -> SceneBuffers:
    """The scene as the viewport's depsgraph has it: no render is started."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return export.export_scene(depsgraph, depsgraph.scene_eval, depsgraph.view_layer_eval, log or Log())


def exported_camera(scene: bpy.types.Scene, log: Log | None = None) -> Camera | None:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = depsgraph.scene_eval
    return export.export_camera(evaluated, evaluated.camera, log or Log())


def messages(scene: bpy.types.Scene, level: str = 'WARNING') -> list[str]:
    log = Log()
    exported(scene, log)
    return log.texts(level)


def in_render(scene: bpy.types.Scene, look: Callable[[bpy.types.RenderEngine, bpy.types.Depsgraph], Any]) -> list[Any]:
    """What `look` returns for each view layer that a final render of the scene comes to."""
    found: list[Any] = []
    failures: list[BaseException] = []

    class LookEngine(bpy.types.RenderEngine):
        bl_idname = 'COTORRA_TEST_LOOK'
        bl_label = 'Look'

        def __init__(self, *arguments: Any, **named: Any) -> None:
            super().__init__(*arguments, **named)

        def render(self, depsgraph: bpy.types.Depsgraph) -> None:
            try:
                found.append(look(self, depsgraph))
            except BaseException as failure:  # none may leave `render`: Blender would crash
                failures.append(failure)

    bpy.utils.register_class(LookEngine)
    try:
        scene.render.engine = LookEngine.bl_idname
        bpy.ops.render.render()
    finally:
        bpy.utils.unregister_class(LookEngine)
    if failures:
        raise failures[0]
    return found


def exported_in_render(scene: bpy.types.Scene, log: Log | None = None) -> list[SceneBuffers]:
    """The scene of each view layer as a final render has it."""
    return in_render(
        scene,
        lambda engine, depsgraph: export.export_scene(
            depsgraph, depsgraph.scene_eval, depsgraph.view_layer_eval, log or Log()
        ),
    )
