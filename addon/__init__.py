# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra, a render engine for Blender: an extension, and a package that scripts with the `bpy` module can import.

Only `register` and `unregister` stand here; nothing of Blender is loaded before `register` is called.
"""

from __future__ import annotations

import atexit

_registered = False


def register() -> None:
    """Make the engine known to Blender. Calling it again changes nothing."""
    global _registered
    if _registered:
        return
    import bpy

    from . import engine, properties, ui

    properties.register()
    engine.register()
    ui.register()
    if bpy.app.module:
        atexit.register(unregister)  # Blender 4.5 hangs at exit while a Python engine is registered
    _registered = True


def unregister() -> None:
    """Take the engine out of Blender again, with its panels and properties."""
    global _registered
    if not _registered:
        return
    from . import engine, properties, ui

    atexit.unregister(unregister)
    ui.unregister()
    engine.unregister()
    properties.unregister()
    _registered = False
