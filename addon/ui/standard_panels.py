# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own panels that are shown for Cotorra too, so that camera, output, colour and data look as in any engine.

Cycles' panels are left alone: they share one set of engines and ask their common base class, so none can be shown
singly; data_panels.py shows the same properties instead.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ..choices import ENGINE

# Panels open to any engine carry this engine's name, though it is long gone.
OPEN_TO_ALL = 'BLENDER_RENDER'

# ... but of these the settings mean nothing here, or data_panels.py shows them as Cycles reads them, or
# render_panels.py where users of Cycles look for them.
LEFT_OUT = {
    'DATA_PT_light',
    'DATA_PT_spot',
    'NODE_DATA_PT_light',
    'DATA_PT_context_lightprobe',
    'DATA_PT_lightprobe',
    'DATA_PT_lightprobe_display',
    'DATA_PT_lightprobe_parallax',
    'DATA_PT_lightprobe_visibility',
    'DATA_PT_volume_render',
    'RENDER_PT_simplify',
    'RENDER_PT_simplify_viewport',
    'RENDER_PT_simplify_render',
    'RENDER_PT_simplify_greasepencil',
}

# Panels that name their engines one by one and hold what Cotorra reads.
ADDED = {
    'EEVEE_MATERIAL_PT_context_material',
    'MATERIAL_PT_preview',
    'OBJECT_PT_shadow_terminator',
}

_shown: list[type] = []


def wanted() -> Iterator[type]:
    for panel in bpy.types.Panel.__subclasses__():
        engines = panel.__dict__.get('COMPAT_ENGINES')
        if engines is None or ENGINE in engines:
            continue
        if panel.__name__ in ADDED or (OPEN_TO_ALL in engines and panel.__name__ not in LEFT_OUT):
            yield panel


def register() -> None:
    for panel in wanted():
        panel.COMPAT_ENGINES.add(ENGINE)
        _shown.append(panel)


def unregister() -> None:
    for panel in _shown:
        panel.COMPAT_ENGINES.discard(ENGINE)
    _shown.clear()
