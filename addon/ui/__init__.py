# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything of Cotorra that stands in the Properties editor.

Panels only show settings; what a setting does is written where it is defined or exported.
"""

from __future__ import annotations

import bpy

from . import (
    data_panels,
    integrator_panels,
    lab_panel,
    layer_panels,
    model_panels,
    program_panel,
    render_panels,
    standard_panels,
    viewport_panels,
)

# In the order in which Blender shows them; panels that stand in others come after them.
CLASSES = (
    *render_panels.FIRST_CLASSES,
    *viewport_panels.CLASSES,
    *integrator_panels.CLASSES,
    *model_panels.RENDER_CLASSES,
    *render_panels.LAST_CLASSES,
    *lab_panel.CLASSES,
    *layer_panels.CLASSES,
    *data_panels.CLASSES,
    *model_panels.CLASSES,
    *program_panel.CLASSES,
    *data_panels.LAST_CLASSES,
)


def register() -> None:
    standard_panels.register()
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    model_panels.register_presets()
    render_panels.register_draws()
    viewport_panels.register_draws()
    lab_panel.register()


def unregister() -> None:
    lab_panel.unregister()
    viewport_panels.unregister_draws()
    render_panels.unregister_draws()
    model_panels.unregister_presets()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    standard_panels.unregister()
    program_panel.forget()
