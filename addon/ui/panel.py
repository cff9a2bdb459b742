# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cotorra's panels have in common: where they stand, and that they show for this engine only.

No panel is defined here.
"""

from __future__ import annotations

import textwrap

import bpy

from .. import cycles_settings
from ..choices import ENGINE

LETTER_WIDTH = 6.5  # of Blender's font in pixels, on average and at a scale of 1


class CotorraPanel:
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    bl_context = 'render'
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class HeadingPanel(CotorraPanel):
    """Nothing but a heading: what stands below it are panels of their own."""

    def draw(self, context):
        pass


def split_layout(panel: bpy.types.Panel) -> bpy.types.UILayout:
    """The panel's layout with names to the left of their values."""
    layout = panel.layout
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def setting(layout: bpy.types.UILayout, scene: bpy.types.Scene, name: str, text: str | None = None) -> None:
    """One of cycles_settings.INHERITED, whoever's it is: what is shown is what holds."""
    owner, theirs = cycles_settings.source(scene, name)
    layout.prop(owner, theirs, text=scene.cotorra.bl_rna.properties[name].name if text is None else text)


def wrapped(layout: bpy.types.UILayout, context: bpy.types.Context, text: str, icon: str = 'INFO') -> None:
    """A text of any length, broken into lines: a label would be cut at the region's edge."""
    region, preferences = getattr(context, 'region', None), context.preferences
    width = (region.width if region is not None else 400) / (preferences.system.ui_scale or 1.0)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(textwrap.wrap(text, max(20, int((width - 60) / LETTER_WIDTH)))):
        column.label(text=line, icon=icon if number == 0 else 'BLANK1')


def light_group(layout: bpy.types.UILayout, owner: bpy.types.ID, view_layer: bpy.types.ViewLayer) -> None:
    """The light group of an object or a world, with a button that adds a group that the view layer lacks."""
    row = layout.row(align=True)
    row.prop_search(owner, 'lightgroup', view_layer, 'lightgroups', text='Light Group', results_are_suggestions=True)
    add = row.column(align=True)
    add.enabled = bool(owner.lightgroup) and owner.lightgroup not in view_layer.lightgroups
    add.operator('scene.view_layer_add_lightgroup', icon='ADD', text='').name = owner.lightgroup


def node_input(layout: bpy.types.UILayout, owner: bpy.types.ID, name: str) -> bool:
    """The nodes behind one input of the output node that Cycles would use; False where there are no nodes."""
    from bpy_extras.node_utils import find_node_input

    if owner.node_tree is None:
        return False
    node = owner.node_tree.get_output_node('CYCLES')
    socket = find_node_input(node, name) if node is not None else None
    if socket is None:
        layout.label(text='No output node')
    else:
        layout.template_node_view(owner.node_tree, node, socket)
    return True
