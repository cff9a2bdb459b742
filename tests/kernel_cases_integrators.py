# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: Whitted, occlusion, Toon, outlines.

Direct and Path stand in kernel_cases_path.py.
"""

from __future__ import annotations

from kernel_cases import CAMERA_RECORD, COLOR, DIRECTION, LIBRARY, NORMAL, POINT, ROUNDING, SQUARE, SURFACE
from kernel_cases_path import COSINE, ETA, FACING, LAMP, MATERIAL, PATH, WO
from kernel_inputs import choices, colors, directions, hits, integers, magnitudes, points, records, uniform
from kernel_parity import Case, Tolerance

CLASSIC = (
    'ClassicMaterial',
    records(
        'ClassicMaterial',
        absorption=colors(4.0),
        transmission=choices(0.0, 0.3, 1.0),
        toon_lit=colors(),
        toon_steps=integers(5),
        toon_shade=colors(),
        ka=uniform(),
        kr=uniform(),
        kt=uniform(),
        flags=integers(2),
    ),
)
OUTLINE_POINT = (
    'OutlinePoint',
    records('OutlinePoint', p=points(), n=directions(), ng=directions(), height=magnitudes(0.1, 10.0)),
)
DISTANCE = ('float', magnitudes(1e-3, 10.0))
# Near the critical angle the cosine beyond is the root of a difference.
CRITICAL = Tolerance(4096, 'near the critical angle the root of a difference enlarges its rounding', typical=16)

CASES = [
    Case(
        'whitted_rays',
        FACING + 'whitted_prepare(material, classic, bsdf); prepared = bsdf; WhittedChildren children;'
        'whitted_children(material, classic, s, bsdf, o, children); reflected = children.reflected;'
        'transmitted = children.transmitted; kr = children.reflected_weight; kt = children.transmitted_weight;'
        'WhittedChildren alone = children;'
        'whitted_principled(material, classic, bsdf, true, c, alone); kr_alone = alone.reflected_weight;'
        'share = glass_share(material, classic); shadow = whitted_shadow(material, classic, c);'
        'polished = select(is_smooth(material), 1u, 0u); light = classic.toon_lit;'
        'crosses = select(whitted_cross_pane(material, classic, s, o, c, light), 1u, 0u);'
        'medium = whitted_medium(classic, s, VISIBLE_TRANSMISSION);',
        {'material': MATERIAL, 'classic': CLASSIC, 's': SURFACE, 'wo': WO, 'c': COSINE},
        {'prepared': 'Bsdf', 'reflected': 'vec3', 'transmitted': 'vec3', 'kr': 'vec3', 'kt': 'vec3'}
        | {'kr_alone': 'vec3', 'share': 'float', 'shadow': 'vec3', 'polished': 'uint', 'light': 'vec3'}
        | {'crosses': 'uint', 'medium': 'uint'},
        ROUNDING,
        {'transmitted': CRITICAL, 'kr': CRITICAL, 'kt': CRITICAL, 'light': LIBRARY},
        scene=True,
    ),
    Case(
        'whitted_optics',
        'goes = select(refract_snell(wo, n, eta, beyond), 1u, 0u); f = glass_reflectance(tint, eta, eta, c);'
        'left = medium_transmittance(tint, distance); onward = path;'
        'worth = select(whitted_advance(onward, s, wo, tint, VISIBLE_TRANSMISSION, 0.1f, origin), 1u, 0u);',
        {
            'wo': WO,
            'n': NORMAL,
            'eta': ETA,
            'c': COSINE,
            'tint': COLOR,
            'distance': DISTANCE,
            'path': PATH,
            's': SURFACE,
        },
        {'goes': 'uint', 'beyond': 'vec3', 'f': 'vec3', 'left': 'vec3', 'onward': 'PathState', 'worth': 'uint'}
        | {'origin': 'vec3'},
        ROUNDING,
        {'beyond': CRITICAL, 'f': CRITICAL, 'left': LIBRARY},
    ),
    Case(
        'ambient',
        'occlusion_ray(scene, s, u, distance, ray);term = ambient_term(material, classic, light);',
        {'s': SURFACE, 'u': SQUARE, 'distance': DISTANCE, 'material': MATERIAL, 'classic': CLASSIC, 'light': COLOR},
        {'ray': 'ShadowRay', 'term': 'vec3'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'toon',
        'full = select(toon_light_ray(scene, lamp, s, ray), 1u, 0u);'
        'tone = toon_color(material, classic, min(lit, lamps), lamps);',
        {'lamp': LAMP, 's': SURFACE, 'material': MATERIAL, 'classic': CLASSIC}
        | {'lit': ('uint', integers(6)), 'lamps': ('uint', integers(6))},
        {'full': 'uint', 'ray': 'ShadowRay', 'tone': 'vec3'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'outlines',
        'x = sobel_x(number); y = sobel_y(number); height = outline_height(camera, 200.0f, p);'
        'outline_begin(sums); depth = outline_depth(middle, instance, p);'
        'outline_add(middle, number, instance, p, n, sums);'
        'found = select(outline_found(sums, kinds, reach), 1u, 0u); move = outline_move(number);'
        'next = outline_next(number);',
        {'number': ('uint', integers(9)), 'middle': OUTLINE_POINT, 'camera': CAMERA_RECORD, 'p': POINT}
        | {'n': DIRECTION, 'instance': ('uint', choices(0, 1, 0xFFFFFFFF)), 'kinds': ('uint', integers(8))}
        | {'reach': ('float', uniform(0.0, 0.05))},
        {'x': 'float', 'y': 'float', 'height': 'float', 'depth': 'float', 'sums': 'OutlineSums', 'found': 'uint'}
        | {'move': 'vec2', 'next': 'uint'},
        ROUNDING,
    ),
    Case(
        'outline_points',
        'outline_point(scene, camera, 200.0f, hit, d, point);',
        {'camera': CAMERA_RECORD, 'hit': ('Hit', hits), 'd': DIRECTION},
        {'point': 'OutlinePoint'},
        ROUNDING,
        scene=True,
    ),
]
