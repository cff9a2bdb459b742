# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine that Blender sees. Instances are short-lived, so nothing is kept here: each call hands over.

Rendering in the viewport is not offered yet: without `view_update` and `view_draw` Blender leaves the view as it is.
"""

from __future__ import annotations

import bpy

from . import choices, final_render, passes, settings


class CotorraRenderEngine(bpy.types.RenderEngine):
    bl_idname = choices.ENGINE
    bl_label = 'Cotorra'
    bl_use_preview = True
    bl_use_shading_nodes_custom = False  # materials are made of Blender's own nodes; without this the editor hides them
    bl_use_eevee_viewport = True  # EEVEE draws the viewport's material preview, as it does for Cycles

    def update_render_passes(self, scene=None, renderlayer=None):
        passes.register(self, scene, renderlayer, settings.denoising(scene, renderlayer) is not None)

    def render(self, depsgraph):
        final_render.render_view_layer(self, depsgraph)


def register() -> None:
    bpy.utils.register_class(CotorraRenderEngine)


def unregister() -> None:
    bpy.utils.unregister_class(CotorraRenderEngine)
