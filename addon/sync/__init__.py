# SPDX-License-Identifier: GPL-3.0-or-later
"""What was exported before and need not be again.

    kept.py     meshes, shaders and images from one export to the next, and what makes them out of date
    stores.py   who shares what is kept: the viewports of one scene and view layer
    changes.py  whether two exports differ

Blender's word on what changed is taken for shaders and images only. A mesh is known by the number that Blender gives
each evaluation of it, and all else is exported each time: it is little, and no update that fails to come can spoil it.
"""
