# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: falloffs, spot edges, terms toward lamps.

What Blender's own lamps need stands in kernel_cases.py.
"""

from __future__ import annotations

from kernel_cases import DIRECTION, LIGHT, NORMAL, POINT, POSITIVE, ROUNDING, SQUARE
from kernel_cases_models import SLOPES
from kernel_cases_path import MATERIAL
from kernel_inputs import LIGHTS, choices, integers, light_shapes, magnitudes, uniform
from kernel_parity import Case, Tolerance

SHAPE = ('LightShape', light_shapes)
# A ramp's slope enlarges the rounding of where on it a direction lies: by up to 1e3 in these inputs.
RAMP = Tolerance(16, 'Vulkan may take 1 / sqrt for normalize, and a steep ramp enlarges it', absolute=2e-4)

CASES = [
    Case(
        'light_falloffs',
        'a = angle_from_versine(v); b = light_falloff(shape, d);',
        {'v': ('float', uniform(0.0, 2.0)), 'shape': SHAPE, 'd': POSITIVE},
        {'a': 'float', 'b': 'float'},
        ROUNDING,
    ),
    Case(
        'light_edges',
        'a = light_spot_edge(shape, light, wi); b = light_shape(shape, light, light.position + wi * d, wi);',
        {'shape': SHAPE, 'light': LIGHT, 'wi': DIRECTION, 'd': ('float', magnitudes(1e-3, 30.0))},
        {'a': 'float', 'b': 'float'},
        RAMP,
    ),
    Case(
        'scene_light_shapes',
        'a = scene_light_shape(scene, index, LOAD(scene.lights, index), p, wi);',
        {'index': ('uint', integers(LIGHTS)), 'p': POINT, 'wi': DIRECTION},
        {'a': 'float'},
        RAMP,
        scene=True,
    ),
    Case(
        'world_directions',
        'square = world_square(d); back = world_direction(square, across);',
        {'d': DIRECTION},
        {'square': 'vec2', 'back': 'vec3', 'across': 'float'},
        Tolerance(64, "angles are each library's own", absolute=2e-6),
    ),
    Case(
        'world_table',
        'float v = u.x; cell = world_search(scene.world_table, 0u, 13u, v, share); rest = v;'
        'again = world_share(scene.world_table, 0u, cell); density = world_density(scene, share, u.y);'
        'table = world_table_pdf(scene, d); sun = world_sun_pdf(scene, d); pdf = world_pdf(scene, d);',
        {'u': SQUARE, 'd': DIRECTION},
        {'cell': 'uint', 'share': 'float', 'rest': 'float', 'again': 'float', 'density': 'float'}
        | {'table': 'float', 'sun': 'float', 'pdf': 'float'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'world_samples',
        'float density; wi = world_sample(scene, u, density); from_table = world_table_sample(scene, u, density);'
        'across = density * sqrt(from_table.x * from_table.x + from_table.y * from_table.y);',
        {'u': SQUARE},
        {'wi': 'vec3', 'from_table': 'vec3', 'across': 'float'},
        Tolerance(4096, "sines are each library's own, and near the poles little is left of them", absolute=2e-6),
        scene=True,
    ),
    Case(
        'lamp_passes',
        'a = light_pass(number); b = light_group(number);',
        {'number': ('int', choices(-1, 0x1FFFF, 0x10002, 0x7FFF0000, 5))},
        {'a': 'int', 'b': 'int'},
    ),
    Case(
        'lamp_terms',
        'Bsdf bsdf; bsdf_prepare(scene, material, n, n, n, bsdf); lamp_terms(scene, p, bsdf, n, d, g, f);',
        {'material': MATERIAL, 'n': NORMAL, 'p': POINT},
        {'d': 'float', 'g': 'float', 'f': 'vec3'},
        SLOPES,
        scene=True,
    ),
]
