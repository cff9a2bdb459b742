# SPDX-License-Identifier: GPL-3.0-or-later
"""What all scripts need that run in Blender's window: its viewports, what the process holds, a report that is whole.

Imported there by window_soak.py and its neighbours; window_blender.py sends them.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import sys

import bpy

EXTENSION = 'bl_ext.user_default.cotorra'
TBBMALLOC_CLEAN_ALL_BUFFERS = 0  # of oneTBB's scalable_allocator.h


# ---- The window


def window() -> bpy.types.Window:
    return bpy.context.window_manager.windows[0]


def areas() -> list[bpy.types.Area]:
    """Its 3D viewports."""
    return [area for area in window().screen.areas if area.type == 'VIEW_3D']


def region(area: bpy.types.Area) -> bpy.types.Region:
    """The part of an area that shows what it is for, without headers and sidebars."""
    return next(region for region in area.regions if region.type == 'WINDOW')


def within(area: bpy.types.Area):
    """The context of an area, for operators."""
    return bpy.context.temp_override(window=window(), area=area, region=region(area))


def scene() -> bpy.types.Scene:
    return window().scene


# ---- The process


def memory() -> int:
    """Bytes that are resident."""
    with open('/proc/self/statm') as file:
        return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')


def give_back() -> None:
    """Memory that is free, though the process still has it, goes back to the system: of glibc, or of TBB's allocator,
    which distributions link in its place and which keeps large blocks for later.
    """
    gc.collect()
    for library, name, arguments in (
        (None, 'malloc_trim', (0,)),
        ('libtbbmalloc.so.2', 'scalable_allocation_command', (TBBMALLOC_CLEAN_ALL_BUFFERS, None)),
    ):
        try:
            getattr(ctypes.CDLL(library), name)(*arguments)
        except (OSError, AttributeError):  # not on this system
            continue


def threads() -> int:
    return len(os.listdir('/proc/self/task'))


def viewports() -> list[object]:
    """Cotorra's, of which each holds a picture and sessions."""
    module = sys.modules.get(f'{EXTENSION}.viewport.viewport')
    return [] if module is None else [found for found in gc.get_objects() if type(found) is module.Viewport]


def stores() -> list[object]:
    """What is kept of scenes: it ends with the last viewport."""
    module = sys.modules.get(f'{EXTENSION}.sync.stores')
    return [] if module is None else list(module._stores.values())


# ---- The report


def write(path: str, found: dict) -> None:
    """Whoever reads the file finds all of it or what was there before."""
    with open(f'{path}.part', 'w') as file:
        json.dump(found, file)
    os.replace(f'{path}.part', path)
