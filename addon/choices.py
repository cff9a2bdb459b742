# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and limits that Blender's settings and the command line share.

It imports nothing, so that the command line can answer before Blender is loaded.
"""

from __future__ import annotations

ENGINE = 'COTORRA'

# identifier, name, description
INTEGRATORS = (
    ('DIRECT', 'Direct', 'Light that comes straight from lights and the world, with shadows; nothing reflects'),
    ('PATH', 'Path', 'Light that also bounces between surfaces, and light from emitting surfaces'),
)
DEVICES = (('CPU', 'CPU', "All processor cores that Blender's thread setting allows"),)

DEMOS = {
    'three_lights': 'thirty twice-subdivided monkeys under a sun, a point and a spot light',
    'box_room': 'a cone, a cube and a sphere in a room under three lights',
    'material_grid': 'spheres over roughness and metallic under three lights',
}

SAMPLES_MAX = 2**24
SEED_MAX = 2**31 - 1  # the largest integer of Blender's properties
BOUNCES_MAX = 1024
THREADS_MAX = 1024
SIZE_MAX = 65536
FRAME_MAX = 1048574  # as in Blender
