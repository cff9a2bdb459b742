# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine that Blender sees. Final renders keep nothing here, since their instances are short-lived; that of
a viewport lasts as long as what it shows, and has a Viewport.
"""

from __future__ import annotations

import bpy

from . import choices, final_render, passes, settings
from .sync import stores
from .viewport import ticking
from .viewport.viewport import Viewport


class CotorraRenderEngine(bpy.types.RenderEngine):
    bl_idname = choices.ENGINE
    bl_label = 'Cotorra'
    bl_use_preview = True
    bl_use_shading_nodes_custom = False  # materials are made of Blender's own nodes; without this the editor hides them
    bl_use_eevee_viewport = True  # EEVEE draws the viewport's material preview, as it does for Cycles

    viewport: Viewport | None = None  # of the instance that Blender makes for a 3D viewport; ends with it

    def update_render_passes(self, scene=None, renderlayer=None):
        denoised = settings.denoising(scene, renderlayer) is not None
        passes.register(self, scene, renderlayer, denoised, settings.reweights(scene))

    def render(self, depsgraph):
        final_render.render_view_layer(self, depsgraph)

    def view_update(self, context, depsgraph):
        if self.viewport is None:
            self.viewport = Viewport(self)
        self.viewport.update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        if self.viewport is None:
            self.view_update(context, depsgraph)
        self.viewport.draw(context, depsgraph)


def register() -> None:
    bpy.utils.register_class(CotorraRenderEngine)
    stores.register()


def unregister() -> None:
    ticking.stop()
    stores.unregister()
    bpy.utils.unregister_class(CotorraRenderEngine)
