# SPDX-License-Identifier: GPL-3.0-or-later
"""The Rendered viewport: what `view_update` and `view_draw` of the engine do.

    view.py         where one looks from: a region's view as a Camera
    preview.py      settings of the viewport, as RenderSettings
    progression.py  the native sessions behind one picture: coarse pixels first, then all of them
    building.py     the native scene, built while the window goes on
    drawing.py      the picture on the screen
    viewport.py     one viewport, from an edit to what is seen; ticking.py redraws it when there is something new

Nothing of `bpy` is touched but by the main thread, and no Blender object is kept between two calls but the engine.
"""
