# SPDX-License-Identifier: GPL-3.0-or-later
"""A 3D viewport for tests, without a window: what Blender hands to `view_update` and `view_draw`, as plain objects.

The space is a real one. What is drawn ends in a list. Matrices are Blender's own, those of a camera object.
"""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
from cotorra.viewport import viewport as viewport_module
from cotorra.viewport.viewport import Viewport

SIZE = (96, 64)


def looking_through(camera: bpy.types.Object, size: tuple[int, int], zoom: float = 1.0, **changes: Any) -> Any:
    """A RegionView3D in that camera's view, whose frame fills `zoom` of the region's width or height."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    projection = np.array(camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1]))
    projection[:2] *= zoom
    found = {
        'view_perspective': 'CAMERA',
        'window_matrix': projection,
        'view_matrix': np.linalg.inv(np.array(camera.evaluated_get(depsgraph).matrix_world.normalized())),
    }
    return SimpleNamespace(**(found | changes))


def space(render_pass: str = 'COMBINED', lights: bool = True, alone: str = '', **changes: Any) -> bpy.types.SpaceView3D:
    """The 3D viewport of the file's screen: it is there without a window, too."""
    spaces = (area.spaces.active for screen in bpy.data.screens for area in screen.areas)
    found = next(space for space in spaces if space.type == 'VIEW_3D')
    shading = found.shading
    shading.cotorra.render_pass, shading.use_scene_lights_render = render_pass, lights
    shading.cotorra.light = shading.cotorra.light_group = alone
    for name, value in ({'use_render_border': False} | changes).items():
        setattr(found, name, value)
    return found


class Engine:
    """What a viewport asks of the engine."""

    is_preview = False

    def __init__(self) -> None:
        self.words: list[tuple[str, str]] = []
        self.tags = 0

    def update_stats(self, stats: str, info: str) -> None:
        self.words.append((stats, info))

    def tag_redraw(self) -> None:
        self.tags += 1


class Canvas:
    """Takes the pictures that would be drawn."""

    def __init__(self) -> None:
        self.loaded: list[tuple[np.ndarray, tuple[int, int, int, int]]] = []

    def load(self, pixels: np.ndarray, place: tuple[int, int, int, int], _size: tuple[int, int]) -> None:
        self.loaded.append((pixels, place))

    def draw(self, *_: Any) -> None:
        pass

    def clear(self) -> None:
        pass


class Window:
    """One viewport that looks through the scene's camera; `view` and `space` may be set to others."""

    def __init__(self, monkeypatch: Any, size: tuple[int, int] = SIZE) -> None:
        monkeypatch.setattr(viewport_module, 'Canvas', Canvas)
        self.engine = Engine()
        self.viewport = Viewport(self.engine)
        self.size = size
        self.space = space()
        self.zoom = 1.0

    @property
    def depsgraph(self) -> bpy.types.Depsgraph:
        return bpy.context.evaluated_depsgraph_get()

    @property
    def context(self) -> Any:
        return SimpleNamespace(
            region=SimpleNamespace(width=self.size[0], height=self.size[1]),
            region_data=looking_through(bpy.context.scene.camera, self.size, self.zoom),
            space_data=self.space,
            preferences=bpy.context.preferences,
        )

    @property
    def pictures(self) -> list[tuple[np.ndarray, tuple[int, int, int, int]]]:
        return self.viewport._canvas.loaded

    @property
    def said(self) -> str:
        return self.engine.words[-1][1]

    def update(self) -> None:
        self.viewport.update(self.context, self.depsgraph)

    def draw(self) -> None:
        self.viewport.draw(self.context, self.depsgraph)

    def settle(self, seconds: float = 60.0) -> None:
        """Redraw whenever the viewport asks for it, until it is at rest."""
        end = time.perf_counter() + seconds
        self.draw()
        tags = self.engine.tags
        while self.viewport.look():
            assert time.perf_counter() < end, f'it does not come to rest: {self.said}'
            if self.engine.tags != tags:
                tags = self.engine.tags
                self.draw()
            time.sleep(0.002)
        self.draw()
