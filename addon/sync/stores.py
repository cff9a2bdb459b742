# SPDX-License-Identifier: GPL-3.0-or-later
"""Who shares what is kept: all viewports of one scene and view layer. It ends with the last of them.

Whatever Blender does to all of its data at once (undo, redo, loading) makes shaders out of date; meshes have numbers.
"""

from __future__ import annotations

import weakref
from typing import Any

import bpy

from .kept import Kept, identity


class Store:
    """What is kept, and the newest native scene, whose meshes and BVHs the next one takes over."""

    def __init__(self) -> None:
        self.kept = Kept()
        self.scene: Any = None


_stores: weakref.WeakValueDictionary[tuple, Store] = weakref.WeakValueDictionary()


def store_of(depsgraph: bpy.types.Depsgraph) -> Store:
    """The one for the scene and view layer of a depsgraph of viewports; hold it for as long as it is of use."""
    key = (identity(depsgraph.scene), depsgraph.view_layer.name)
    found = _stores.get(key)
    if found is None:
        found = _stores[key] = Store()
    return found


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    for store in list(_stores.values()):
        store.kept.forget_shaders()


HANDLERS = ('undo_post', 'redo_post', 'load_post')


def register() -> None:
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).append(_forget)


def unregister() -> None:
    for name in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if _forget in handlers:
            handlers.remove(_forget)
    _stores.clear()
