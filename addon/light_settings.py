# SPDX-License-Identifier: GPL-3.0-or-later
"""`light.cotorra`: how a light falls off with distance and at the edge of its cone, where that is not Blender's way.

Color, strength and size are the light's own; how they reach the native module is told in export/lights.py.
"""

from __future__ import annotations

import math

import bpy
from bpy.props import FloatProperty

from .choices import FALLOFFS, SPOT_EDGES
from .material_settings import choice, number, tag_owner


def angle(name: str, description: str, degrees: float) -> FloatProperty:
    return FloatProperty(
        name=name,
        description=description,
        subtype='ANGLE',
        default=math.radians(degrees),
        min=0.0,
        max=math.pi / 2,
        update=tag_owner,
    )


class CotorraLightSettings(bpy.types.PropertyGroup):
    falloff: choice('Falloff', 'How the light gets weaker with distance', FALLOFFS, 'PHYSICAL')
    range: FloatProperty(
        name='Range',
        description='Distance from which on nothing is lit',
        subtype='DISTANCE',
        default=10.0,
        min=0.0,
        soft_max=1000.0,
        update=tag_owner,
    )
    c0: number('Constant', 'c0 of 1 / (c0 + c1 d + c2 d²), d in metres', 0.0)
    c1: number('Linear', 'c1 of 1 / (c0 + c1 d + c2 d²), d in metres', 0.0)
    c2: number('Quadratic', 'c2 of 1 / (c0 + c1 d + c2 d²), d in metres', 1.0)
    spot_edge: choice('Edge', 'How the light of a spot fades toward the edge of its cone', SPOT_EDGES, 'BLENDER')
    inner_angle: angle('Inner Angle', 'Angle from the axis up to which the spot is fully bright', 15.0)
    outer_angle: angle('Outer Angle', 'Angle from the axis at which the spot ends', 22.5)
