# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: falloffs, spot edges, terms toward lamps.

What Blender's own lamps need stands in kernel_cases.py.
"""

from __future__ import annotations

from kernel_cases import DIRECTION, LIGHT, NORMAL, POINT, POSITIVE, ROUNDING, SIGNED, SQUARE, SURFACE, UNIT
from kernel_cases_models import SLOPES
from kernel_cases_path import MATERIAL, PATH
from kernel_cases_program import LIBRARY
from kernel_inputs import (
    INSTANCES,
    LIGHTS,
    TRIANGLES,
    area_lights,
    choices,
    directions,
    integers,
    light_shapes,
    magnitudes,
    points,
    records,
    uniform,
)
from kernel_inputs_programs import GROUPS
from kernel_parity import Case, Tolerance

AREA = ('Light', area_lights)
LAMP = ('uint', integers(LIGHTS))
# Cuts of a rectangle are differences of sines, which a lamp that shows edge on enlarges; others keep all digits.
CUTS = Tolerance(4096, 'a lamp seen edge on is cut by differences of sines', absolute=2e-4, typical=64)
SHAPE = ('LightShape', light_shapes)
# A ramp's slope enlarges the rounding of where on it a direction lies: by up to 1e3 in these inputs.
RAMP = Tolerance(16, 'Vulkan may take 1 / sqrt for normalize, and a steep ramp enlarges it', absolute=2e-4)

AREAS = [
    Case(
        'area_views',
        'AreaView v; area_light_view(light, p, v); angle = angle_of_point(x, abs(y));'
        'a = vec3(v.a0, v.a1, v.b0); b = vec3(v.b1, v.nearest2, v.height); foot = vec2(v.x, v.y);'
        'empty = select(area_view_empty(v), 1u, 0u); solid = 0.0f;'
        'if (empty == 0u) solid = area_view_solid_angle(v);'
        'spread = area_light_spread(light, abs(x));',
        {'light': AREA, 'p': POINT, 'x': SIGNED, 'y': SIGNED},
        {'a': 'vec3', 'b': 'vec3', 'foot': 'vec2', 'empty': 'uint', 'solid': 'float', 'spread': 'float'}
        | {'angle': 'float'},
        ROUNDING,
        {'solid': CUTS},
    ),
    Case(
        'area_samples',
        # Toward the light, or it would be edge on or behind more often than in scenes.
        'const vec3 p = light.position + light.axis * far + aside; AreaView v; area_light_view(light, p, v);'
        'technique = area_view_technique(light, v); pdf = area_view_empty(v) ? 0.0f : area_view_pdf(light, v, far);'
        'q = area_view_spherical(v, area_view_solid_angle(v), u); area_light_sample(light, p, u, drawn);'
        'area_light_sample_spread(light, p, u, spread); area_light_beam(light, p, beam);'
        'covers = select(area_light_covers(light, aside.x, aside.y), 1u, 0u);'
        'rounds = select(area_light_rounds(light, aside.x, aside.y), 1u, 0u);'
        'if (technique != AREA_SPHERICAL) q = vec2(0.0f, 0.0f);',
        {'light': AREA, 'far': ('float', magnitudes(0.2, 20.0)), 'aside': ('vec3', points(0.1)), 'u': SQUARE},
        {'technique': 'uint', 'pdf': 'float', 'q': 'vec2', 'drawn': 'LightSample', 'spread': 'LightSample'}
        | {'beam': 'LightSample', 'covers': 'uint', 'rounds': 'uint'},
        CUTS,
    ),
    Case(
        'area_intersections',
        'float len; vec3 d = safe_normalize(light.position - p + lean, len);'
        'hit = select(area_light_intersect(light, p, d, t_max, radiance, pdf), 1u, 0u);'
        'if (hit == 0u) { radiance = vec3(0.0f); pdf = 0.0f; }'
        'far = light_distance(light, p, d); asks = select(light_asks_lanes(light), 1u, 0u);'
        'below = select(light_is_below(light, p, d), 1u, 0u);',
        {'light': AREA, 'p': POINT, 'lean': ('vec3', points(0.05)), 't_max': ('float', choices(1.0, 5.0, 1e30))},
        {'hit': 'uint', 'radiance': 'vec3', 'pdf': 'float', 'far': 'float', 'asks': 'uint', 'below': 'uint'},
        CUTS,
    ),
]

PROGRAMS = [
    Case(
        'light_programs',
        'Light light = LOAD(scene.lights, lamp); light.flags |= LIGHT_PROGRAM;'
        'const LightProgram program = LOAD(scene.light_programs, lamp);'
        'uv = light_uv(light, program, p, d, d); at = light_point(lamp, light, program, p, d, far);'
        'sent = path_light_program(scene, lamp, light, path, p, d, far);',
        {'lamp': LAMP, 'p': POINT, 'd': DIRECTION, 'far': POSITIVE, 'path': PATH},
        {'uv': 'vec2', 'at': 'ShaderPoint', 'sent': 'vec3'},
        LIBRARY,
        scene=True,
        program=True,
        groups=GROUPS,
    ),
    Case(
        'light_places',
        'ShaderPoint at = background_point(d); at.p = p; there = select(has_object(at), 1u, 0u); at.light = lamp;'
        'here = select(has_object(at), 1u, 0u); place = object_position(scene, at); frame = point_frame(scene, at);'
        'const ObjectSpace space = point_space(scene, at); origin = space.origin;'
        'turned = object_transform(scene, at, 2u | 1u << 4u, d);',
        {'lamp': LAMP, 'p': POINT, 'd': DIRECTION},
        {'there': 'uint', 'here': 'uint', 'place': 'vec3', 'frame': 'NormalFrame', 'origin': 'vec3', 'turned': 'vec3'},
        ROUNDING,
        scene=True,
        program=True,
        groups=GROUPS,
    ),
    Case(
        'luminaires',
        'strength = op_ies_f(scene, d, 1028.0f, 11.0f, 9.0f); cell = ies_cell(scene, 1028, 11, x * 6.0f);'
        'curve = ies_spline(x, 1.0f - x, 0.5f * x, x * x, x);',
        {'d': ('vec3', directions()), 'x': ('float', uniform())},
        {'strength': 'float', 'cell': 'int', 'curve': 'float'},
        LIBRARY,
        {'strength': Tolerance(4096, "angles are each library's own, and slopes enlarge them", absolute=2e-2)},
        scene=True,
        program=True,
        groups=('GROUP_TABLE',),
    ),
]

RECEIVER = (
    'LightReceiver',
    records('LightReceiver', p=points(), n=directions(), both_sides=integers(2), set=integers(64)),
)
PLACE = ('uint', integers(16))

TREE = [
    Case(
        'light_bounds',
        'const int child = int(place % LIGHT_FANOUT); const uint node = place / LIGHT_FANOUT;'
        'bound = light_bound(scene.light_nodes, node, child, at); few = light_bounds(scene, node, at);'
        'weights = light_weights(scene, node, at); sum = light_weights_sum(weights);'
        'near = select(light_child_near(scene.light_nodes, node, child, at), 1u, 0u);'
        'less = cos_less(a, sqrt(1.0f - a * a), b, sqrt(1.0f - b * b));'
        'bits = light_child(scene.light_nodes, node, child);'
        'row = light_row(scene.light_nodes, node, LIGHT_ROW_COS, child);'
        'axis = light_row_vector(scene.light_nodes, node, LIGHT_ROW_AXIS, child);',
        {'place': PLACE, 'at': RECEIVER, 'a': SIGNED, 'b': SIGNED},
        {'bound': 'float', 'few': 'LightWeights', 'weights': 'LightWeights', 'sum': 'float', 'near': 'uint'}
        | {'less': 'float', 'bits': 'uint', 'row': 'float', 'axis': 'vec3'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'light_picks',
        'const LightWeights root = light_weights(scene, 0u, at);'
        'float left = u; light = light_tree_pick(scene, at, root, left, fresh, probability);'
        'chance = light_tree_probability(scene, place, at); of_lamp = light_place_of_lamp(scene, lamp);'
        'of_triangle = light_place_of_triangle(scene, instance, triangle);',
        {
            'at': RECEIVER,
            'u': UNIT,
            'fresh': UNIT,
            'place': PLACE,
            'lamp': LAMP,
            'instance': ('uint', integers(INSTANCES)),
        }
        | {'triangle': ('uint', integers(TRIANGLES))},
        {'light': 'uint', 'probability': 'float', 'chance': 'float', 'of_lamp': 'uint', 'of_triangle': 'uint'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'light_walks',
        'uint place = 0u; first = light_tree_next(scene, p, d, t_max, place); came = place;'
        'second = light_tree_next(scene, p, d, t_max, place);'
        'met = select(light_child_met(scene.light_nodes, 0u, int(lamp), p, d, t_max), 1u, 0u);',
        {'p': POINT, 'd': DIRECTION, 't_max': ('float', choices(2.0, 1e30)), 'lamp': LAMP},
        {'first': 'uint', 'came': 'uint', 'second': 'uint', 'met': 'uint'},
        scene=True,
    ),
    Case(
        'light_chances',
        'picks = found_picks(scene, path);'
        'chance = found_probability(scene, path, place, p, d, far);'
        'links = select(has_links(scene), 1u, 0u); set = receiver_set(scene, s.instance);'
        'lights = select(light_lights(scene, place % 11u, other), 1u, 0u); shadows = light_shadows(scene, place % 11u);'
        'came = path_set(path); apart = select(path_unlinked(scene, path, place % 11u), 1u, 0u);'
        'holds = select(sets_hold(uvec2(other * 77u, other << 27u), other), 1u, 0u);',
        {'s': SURFACE, 'path': PATH, 'place': PLACE, 'p': POINT, 'd': DIRECTION, 'far': POSITIVE}
        | {'other': ('uint', integers(64))},
        {'picks': 'float', 'chance': 'float', 'links': 'uint', 'set': 'uint', 'lights': 'uint'}
        | {'shadows': 'uint', 'came': 'uint', 'apart': 'uint', 'holds': 'uint'},
        ROUNDING,
        scene=True,
    ),
]

TRIANGLES_SEEN = [
    Case(
        'triangle_lights',
        'TriangleView view; triangle_view(to, e1, e2, view);'
        'shown = view.solid_angle; way = vec3(0.0f); if (shown > 0.0f) way = spherical_triangle_sample(view, u);'
        'b = triangle_light_sample(view, to, e1, e2, u); pdf = triangle_light_pdf(view, length(cross(e1, e2)), d, c);',
        {'to': POINT, 'e1': POINT, 'e2': POINT, 'u': SQUARE, 'd': POSITIVE, 'c': UNIT},
        {'shown': 'float', 'way': 'vec3', 'b': 'vec2', 'pdf': 'float'},
        ROUNDING,
    ),
]

CASES = [
    *AREAS,
    *TRIANGLES_SEEN,
    *PROGRAMS,
    *TREE,
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
