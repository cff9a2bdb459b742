# SPDX-License-Identifier: GPL-3.0-or-later
"""Who shares what is kept: all viewports of one scene and view layer. It ends with the last of them.

Renders with Persistent Data keep theirs from frame to frame, and to the next render, until a file is loaded.
Whatever Blender does to all of its data at once (undo, redo, loading) makes shaders out of date; meshes have numbers.
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any

import bpy

from .kept import Kept, identity

if TYPE_CHECKING:
    from ..export.buffers import SceneBuffers


class Store:
    """What is kept, and the newest native scene, whose meshes and BVHs the next one takes over.

    buffers: what the scene was built of.
    """

    def __init__(self) -> None:
        self.kept = Kept()
        self.scene: Any = None
        self.buffers: SceneBuffers | None = None


_stores: weakref.WeakValueDictionary[tuple, Store] = weakref.WeakValueDictionary()
_of_renders: dict[tuple, Store] = {}


def store_of(depsgraph: bpy.types.Depsgraph) -> Store:
    """The one for the scene and view layer of a depsgraph of viewports; hold it for as long as it is of use."""
    key = (identity(depsgraph.scene), depsgraph.view_layer.name)
    found = _stores.get(key)
    if found is None:
        found = _stores[key] = Store()
    return found


def store_of_render(depsgraph: bpy.types.Depsgraph) -> Store | None:
    """The one for final renders of a scene and view layer; None where Persistent Data is off, and nothing is kept.

    Shaders are read each time: a render is not told what has changed.
    """
    key = (identity(depsgraph.scene), depsgraph.view_layer.name)
    if not depsgraph.scene.render.use_persistent_data:
        _of_renders.pop(key, None)
        return None
    found = _of_renders.setdefault(key, Store())
    found.kept.forget_shaders(images=False)
    return found


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    for store in list(_stores.values()):
        store.kept.forget_shaders()


@bpy.app.handlers.persistent
def _forget_renders(*_: object) -> None:
    _of_renders.clear()


HANDLERS = ('undo_post', 'redo_post', 'load_post')


def register() -> None:
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).append(_forget)
    bpy.app.handlers.load_pre.append(_forget_renders)


def unregister() -> None:
    for name in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if _forget in handlers:
            handlers.remove(_forget)
    if _forget_renders in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(_forget_renders)
    _stores.clear()
    _of_renders.clear()
