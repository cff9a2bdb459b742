# SPDX-License-Identifier: GPL-3.0-or-later
"""Cotorra's panels for lights, worlds, materials and objects: what it reads of them, Cycles' own settings included.

Panels that Blender shows for every engine are left to standard_panels.py.
"""

from __future__ import annotations

import bpy

from .panel import CotorraPanel, HeadingPanel, light_group, node_input, split_layout, wrapped

GEOMETRY_TYPES = {'MESH', 'CURVE', 'SURFACE', 'FONT', 'META', 'CURVES', 'POINTCLOUD', 'VOLUME'}


class LightPanel(CotorraPanel):
    bl_context = 'data'

    @classmethod
    def poll(cls, context):
        return context.light is not None and super().poll(context)


class COTORRA_LIGHT_PT_light(LightPanel, bpy.types.Panel):
    bl_label = 'Light'

    def draw(self, context):
        light = context.light
        self.layout.row().prop(light, 'type', expand=True)
        layout = self.layout
        layout.use_property_split = True

        color = layout.column(align=True, heading='Temperature')
        row = color.row(align=True)
        row.prop(light, 'use_temperature', text='')
        temperature = row.row()
        temperature.active = light.use_temperature
        temperature.prop(light, 'temperature', text='')
        layout.prop(light, 'color', text='Tint' if light.use_temperature else 'Color')

        strength = layout.column()
        strength.prop(light, 'energy')
        strength.prop(light, 'exposure')
        strength.prop(light, 'normalize')

        shape = layout.column()
        if light.type in {'POINT', 'SPOT'}:
            shape.prop(light, 'shadow_soft_size', text='Radius')
            shape.prop(light, 'use_soft_falloff')
        elif light.type == 'SUN':
            shape.prop(light, 'angle')
        else:
            shape.prop(light, 'shape')
            two = light.shape in {'RECTANGLE', 'ELLIPSE'}
            sizes = shape.column(align=True)
            sizes.prop(light, 'size', text='Size X' if two else 'Size')
            if two:
                sizes.prop(light, 'size_y', text='Y')
            shape.prop(light, 'spread')


class COTORRA_LIGHT_PT_beam_shape(LightPanel, bpy.types.Panel):
    bl_label = 'Beam Shape'
    bl_parent_id = 'COTORRA_LIGHT_PT_light'

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light.type == 'SPOT'

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        light = context.light
        own = light.cotorra
        layout.prop(own, 'spot_edge')
        if own.spot_edge == 'BLENDER':
            layout.prop(light, 'spot_size', text='Angle')
            layout.prop(light, 'spot_blend', text='Blend', slider=True)
        else:
            angles = layout.column(align=True)
            angles.prop(own, 'inner_angle')
            angles.prop(own, 'outer_angle')
        layout.prop(light, 'show_cone')


class COTORRA_LIGHT_PT_falloff(LightPanel, bpy.types.Panel):
    bl_label = 'Falloff'
    bl_parent_id = 'COTORRA_LIGHT_PT_light'

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light.type in {'POINT', 'SPOT'}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        own = context.light.cotorra
        layout.prop(own, 'falloff', text='Type')
        if own.falloff == 'RANGED':
            layout.prop(own, 'range')
        elif own.falloff == 'POLYNOMIAL':
            terms = layout.column(align=True)
            terms.prop(own, 'c0')
            terms.prop(own, 'c1')
            terms.prop(own, 'c2')


class COTORRA_LIGHT_PT_nodes(LightPanel, bpy.types.Panel):
    bl_label = 'Nodes'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        self.layout.use_property_split = True
        if not node_input(self.layout, context.light, 'Surface'):
            self.layout.label(text='This light has no nodes')


class COTORRA_LIGHT_PT_settings(LightPanel, bpy.types.Panel):
    bl_label = 'Settings'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        light = context.light
        cycles = getattr(light, 'cycles', None)
        if cycles is not None:
            layout.prop(cycles, 'max_bounces')
        flags = layout.column(align=True)
        flags.prop(light, 'use_shadow', text='Cast Shadow')
        if cycles is not None:
            flags.prop(cycles, 'use_multiple_importance_sampling', text='Multiple Importance')


class COTORRA_WORLD_PT_preview(CotorraPanel, bpy.types.Panel):
    bl_label = 'Preview'
    bl_context = 'world'
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return context.world is not None and super().poll(context)

    def draw(self, context):
        self.layout.template_preview(context.world)


class COTORRA_WORLD_PT_surface(CotorraPanel, bpy.types.Panel):
    bl_label = 'Surface'
    bl_context = 'world'

    @classmethod
    def poll(cls, context):
        return context.world is not None and super().poll(context)

    def draw(self, context):
        self.layout.use_property_split = True
        if not node_input(self.layout, context.world, 'Surface'):
            self.layout.prop(context.world, 'color')


class COTORRA_WORLD_PT_ray_visibility(CotorraPanel, bpy.types.Panel):
    bl_label = 'Ray Visibility'
    bl_context = 'world'
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return hasattr(context.world, 'cycles_visibility') and super().poll(context)

    def draw(self, context):
        layout = split_layout(self)
        visibility = context.world.cycles_visibility
        for name in ('camera', 'diffuse', 'glossy', 'transmission', 'scatter'):
            layout.prop(visibility, name)


class COTORRA_WORLD_PT_settings(HeadingPanel, bpy.types.Panel):
    bl_label = 'Settings'
    bl_context = 'world'
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return context.world is not None and super().poll(context)


class COTORRA_WORLD_PT_light_group(CotorraPanel, bpy.types.Panel):
    bl_label = 'Light Group'
    bl_context = 'world'
    bl_parent_id = 'COTORRA_WORLD_PT_settings'

    @classmethod
    def poll(cls, context):
        return context.world is not None and super().poll(context)

    def draw(self, context):
        light_group(split_layout(self), context.world, context.view_layer)


class MaterialPanel(CotorraPanel):
    bl_context = 'material'

    @classmethod
    def poll(cls, context):
        material = context.material
        return material is not None and not material.grease_pencil and super().poll(context)


class COTORRA_MATERIAL_PT_surface(MaterialPanel, bpy.types.Panel):
    bl_label = 'Surface'

    def draw(self, context):
        self.layout.use_property_split = True
        if not node_input(self.layout, context.material, 'Surface'):
            self.layout.prop(context.material, 'diffuse_color')


class COTORRA_MATERIAL_PT_volume(MaterialPanel, bpy.types.Panel):
    bl_label = 'Volume'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        self.layout.use_property_split = True
        node_input(self.layout, context.material, 'Volume')
        wrapped(self.layout, context, 'Volumes are not rendered yet')


class COTORRA_MATERIAL_PT_displacement(MaterialPanel, bpy.types.Panel):
    bl_label = 'Displacement'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        self.layout.use_property_split = True
        node_input(self.layout, context.material, 'Displacement')
        wrapped(self.layout, context, 'Bends the normal, and does not move the surface yet')


class COTORRA_MATERIAL_PT_settings(MaterialPanel, bpy.types.Panel):
    bl_label = 'Settings'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = split_layout(self)
        material = context.material
        layout.prop(material, 'pass_index')
        cycles = getattr(material, 'cycles', None)
        if cycles is not None:
            layout.prop(cycles, 'emission_sampling')


class COTORRA_OBJECT_PT_light_group(CotorraPanel, bpy.types.Panel):
    bl_label = 'Light Group'
    bl_context = 'object'
    bl_parent_id = 'OBJECT_PT_shading'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        light_group(split_layout(self), context.object, context.view_layer)


class COTORRA_OBJECT_PT_ray_visibility(CotorraPanel, bpy.types.Panel):
    bl_label = 'Ray Visibility'
    bl_context = 'object'
    bl_parent_id = 'OBJECT_PT_visibility'

    @classmethod
    def poll(cls, context):
        item = context.object
        return item is not None and item.type in {*GEOMETRY_TYPES, 'LIGHT'} and super().poll(context)

    def draw(self, context):
        layout = split_layout(self)
        item = context.object
        column = layout.column()
        column.prop(item, 'visible_camera', text='Camera')
        column.prop(item, 'visible_diffuse', text='Diffuse')
        column.prop(item, 'visible_glossy', text='Glossy')
        column.prop(item, 'visible_transmission', text='Transmission')
        column.prop(item, 'visible_volume_scatter', text='Volume Scatter')
        if item.type != 'LIGHT':
            column.prop(item, 'visible_shadow', text='Shadow')


CLASSES = (
    COTORRA_LIGHT_PT_light,
    COTORRA_LIGHT_PT_falloff,
    COTORRA_LIGHT_PT_beam_shape,
    COTORRA_LIGHT_PT_nodes,
    COTORRA_LIGHT_PT_settings,
    COTORRA_WORLD_PT_preview,
    COTORRA_WORLD_PT_surface,
    COTORRA_WORLD_PT_ray_visibility,
    COTORRA_WORLD_PT_settings,
    COTORRA_WORLD_PT_light_group,
    COTORRA_MATERIAL_PT_surface,
    COTORRA_OBJECT_PT_light_group,
    COTORRA_OBJECT_PT_ray_visibility,
)

# These of the material come after its model, of model_panels.py.
LAST_CLASSES = (COTORRA_MATERIAL_PT_volume, COTORRA_MATERIAL_PT_displacement, COTORRA_MATERIAL_PT_settings)
