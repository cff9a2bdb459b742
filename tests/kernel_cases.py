# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on: from built-ins to lights and surfaces.

Materials and the stages of a path stand in kernel_cases_path.py.
"""

from __future__ import annotations

from dataclasses import replace

from kernel_inputs import (
    INSTANCES,
    TRIANGLES,
    choices,
    colors,
    directions,
    hits,
    integers,
    lights,
    magnitudes,
    points,
    records,
    surfaces,
    uniform,
    vectors,
)
from kernel_parity import Case, Tolerance

# An input is a kernel type and how it is drawn.
UINT = ('uint', integers())
BIT_COUNT = ('uint', integers(33))
UNIT = ('float', uniform())
SIGNED = ('float', uniform(-1.0, 1.0))
SQUARE = ('vec2', vectors(uniform(), 2))
DIRECTION = ('vec3', directions())
NORMAL = ('vec3', directions())
POINT = ('vec3', points())
COLOR = ('vec3', colors())
POSITIVE = ('float', magnitudes(1e-3, 1e3))
LIGHT = ('Light', lights)
SURFACE = ('Surface', surfaces)

# Bounds are about four times what was measured over 262,144 inputs on Mesa 22.3 (LLVM 15).
ROUNDING = Tolerance(16, 'Vulkan lets compilers move constant factors and take 1 / sqrt for normalize')
LIBRARY = Tolerance(
    128, "exp, log and pow are each library's own; near log(1) = 0 the error is absolute", absolute=4e-6
)
ANGLE = Tolerance(4, "acos and atan are Mesa's polynomials: Vulkan asks for no more than 4096 ULP", absolute=5e-4)
SILHOUETTE = Tolerance(256, 'near the outline of a sphere the root of a difference enlarges its rounding', typical=8)
# As that, where what is near is told by two places some metres off: as far apart as these may be rounded.
DISTANCE = replace(SILHOUETTE, absolute=5e-7)

BUILT_INS = [
    Case(
        'bits',
        'reversed = bitfieldReverse(a); f = uintBitsToFloat((a >> 9) | 0x3f800000u); back = floatBitsToUint(f);',
        {'a': UINT},
        {'reversed': 'uint', 'f': 'float', 'back': 'uint'},
    ),
    Case(
        'arithmetic',
        'quotient = a / b; root = sqrt(abs(b)); low = floor(a); blend = mix(a, b, t);'
        'bounded = clamp(a, -0.5f, 0.5f); s = sign(a);',
        {'a': SIGNED, 'b': POSITIVE, 't': UNIT},
        {'quotient': 'float', 'root': 'float', 'low': 'float', 'blend': 'float', 'bounded': 'float', 's': 'float'},
    ),
    Case(
        'geometry',
        'd = dot(a, b); c = cross(a, b); len = length(a); unit = normalize(a); lowest = min(a, b);highest = max(a, b);',
        {'a': POINT, 'b': POINT},
        {'d': 'float', 'c': 'vec3', 'len': 'float', 'unit': 'vec3', 'lowest': 'vec3', 'highest': 'vec3'},
        tolerances={'unit': ROUNDING},
    ),
    Case(
        'transcendental',
        'a = exp(x); b = exp2(x); c = log(p); d = log2(p); e = pow(p, x);',
        {'x': ('float', uniform(-5.0, 5.0)), 'p': POSITIVE},
        {'a': 'float', 'b': 'float', 'c': 'float', 'd': 'float', 'e': 'float'},
        LIBRARY,
    ),
    Case(
        'trigonometry',
        'a = sin(x); b = cos(x); c = acos(y); d = atan(y, p);',
        {'x': ('float', uniform(-7.0, 7.0)), 'y': SIGNED, 'p': POSITIVE},
        {'a': 'float', 'b': 'float', 'c': 'float', 'd': 'float'},
        ANGLE,
    ),
]

MATH = [
    Case(
        'math_scalars',
        'a = sqr(x); b = one_minus_cos_from_sin2(x); c = sin_quarter(angle); d = cos_quarter(angle);'
        'e = smoothstep01(x);',
        {'x': ('float', uniform(-0.5, 1.5)), 'angle': ('float', uniform(-0.785, 0.785))},
        {'a': 'float', 'b': 'float', 'c': 'float', 'd': 'float', 'e': 'float'},
    ),
    Case(
        'math_lanes',
        'a = exp_lanes(-y); b = log_lanes(y); c = angle_lanes(d.y, d.x);',
        {'y': ('float', uniform(1e-6, 90.0)), 'd': DIRECTION},
        {'a': 'float', 'b': 'float', 'c': 'float'},
    ),
    Case(
        'math_colors',
        'a = max_component(rgb); b = luminance(rgb); c = select(is_black(rgb * gate), 1u, 0u);'
        'd = select(carries_light(rgb * gate), 1u, 0u);',
        {'rgb': COLOR, 'gate': ('float', choices(0.0, 1.0, -1.0))},
        {'a': 'float', 'b': 'float', 'c': 'uint', 'd': 'uint'},
    ),
    Case(
        'math_vectors',
        'unit = safe_normalize(p * gate, len); orthonormal_basis(n, t, b); w = to_world(p, t, b, n);',
        {'p': POINT, 'gate': ('float', choices(0.0, 1.0)), 'n': NORMAL},
        {'unit': 'vec3', 'len': 'float', 't': 'vec3', 'b': 'vec3', 'w': 'vec3'},
    ),
]

SAMPLING = [
    Case(
        'hashes',
        'a = hash_uint(x); b = hash_combine(x, y); c = owen_hash(x, y);',
        {'x': UINT, 'y': UINT},
        {'a': 'uint', 'b': 'uint', 'c': 'uint'},
    ),
    Case(
        'morton',
        'a = morton_spread(x); b = morton_encode(x, y);',
        {'x': UINT, 'y': UINT},
        {'a': 'uint', 'b': 'uint'},
    ),
    Case(
        'sampler',
        'side = sampler_block_bits(bits); index = sampler_index(x, y, number, bits);'
        'block = sampler_block_seed(x, y, bits, seed);'
        'own = sampler_pair_seed(block, pair); value = sampler_pair(index, own); f = unit_float(seed);',
        {'x': ('uint', integers(16384)), 'y': ('uint', integers(16384)), 'number': UINT, 'bits': BIT_COUNT}
        | {'seed': UINT, 'pair': ('uint', integers(2000))},
        {'side': 'uint', 'index': 'uint', 'block': 'uint', 'own': 'uint', 'value': 'vec2', 'f': 'float'},
    ),
    Case(
        'warps',
        'disk = disk_from_square(u); cone = cone_from_square(u, h); upper = cosine_hemisphere_from_square(u);'
        'triangle = triangle_from_square(u);',
        {'u': SQUARE, 'h': ('float', magnitudes(1e-7, 1.0))},
        {'disk': 'vec2', 'cone': 'vec3', 'upper': 'vec3', 'triangle': 'vec2'},
    ),
    Case(
        'weights',
        'w = power_heuristic(a, b);',
        {'a': ('float', magnitudes(1e-12, 1e22)), 'b': ('float', magnitudes(1e-12, 1e22))},
        {'w': 'float'},
    ),
]

CAMERA_RECORD = (
    'CameraData',
    records(
        'CameraData',
        origin=points(10.0),
        kind=choices(0, 1),
        x_axis=directions(),
        y_axis=directions(),
        z_axis=directions(),
        window_left=uniform(-1.0, 0.0),
        window_bottom=uniform(-1.0, 0.0),
        pixel_width=magnitudes(1e-4, 1e-2),
        pixel_height=magnitudes(1e-4, 1e-2),
        clip_start=magnitudes(1e-3, 1.0),
        clip_end=magnitudes(10.0, 1e4),
    ),
)
FILM_PIXEL = ('FilmPixel', records('FilmPixel', radiance=colors(50.0), alpha=uniform(0.0, 9.0)))

CAMERA = [
    Case(
        'camera_rays',
        'camera_ray(camera, x, y, ray); depth = camera_depth(camera, p);',
        {
            'camera': CAMERA_RECORD,
            'x': ('float', uniform(0.0, 4096.0)),
            'y': ('float', uniform(0.0, 4096.0)),
            'p': POINT,
        },
        {'ray': 'CameraRay', 'depth': 'float'},
    ),
    Case(
        'filter',
        'offset = filter_sample(scene.filter_table, u);',
        {'u': UNIT},
        {'offset': 'float'},
        scene=True,
    ),
    Case(
        'sharing',
        'SampleShares shares; sample_shares(scene.filter_table, radius, at * radius, sampled | 4096u, shares);'
        'first = shares.first; row = vec3(shares.weights[0], shares.weights[4], shares.weights[8]);'
        'other = vec3(shares.weights[1], shares.weights[5], shares.weights[6]);'
        'density = filter_density(scene.filter_table, at.x);'
        'sum = start; shared_add(sum, radiance, 0.5f, shares.weights[4]);',
        {'radius': ('float', uniform(0.6, 1.5)), 'at': ('vec2', vectors(uniform(-1.0, 1.0), 2))}
        | {'sampled': ('uint', integers(1 << 25)), 'radiance': COLOR}
        | {'start': ('SharedSum', records('SharedSum', weight=uniform(0.0, 9.0)))},
        {'first': 'uint', 'row': 'vec3', 'other': 'vec3', 'density': 'float', 'sum': 'SharedSum'},
        scene=True,
        tolerances={'row': ROUNDING, 'other': ROUNDING, 'sum': ROUNDING},
    ),
    Case(
        'film',
        'pixel = start; kept = radiance * gate; finite = select(film_add(pixel, kept, alpha), 1u, 0u);'
        'error = film_error(start.radiance, n, start.radiance * 0.4f, 0.5f * n);'
        'number = film_number(radiance.x * gate); vector = film_vector(radiance * gate);',
        {'start': FILM_PIXEL, 'radiance': COLOR, 'gate': ('float', choices(1.0, 1.0, 1e31))}
        | {'alpha': UNIT, 'n': ('float', uniform(2.0, 100.0))},
        {'pixel': 'FilmPixel', 'kept': 'vec3', 'finite': 'uint', 'error': 'float', 'number': 'float', 'vector': 'vec3'},
        tolerances={'error': ROUNDING},
    ),
    Case(
        'reweighting',
        'size = brightness(light) * gate; sum = start; bright_add(sum, light * gate, size, cascade, white);'
        'level = cascade_level(cascade, white);',
        {
            'start': ('BrightSum', records('BrightSum', light=colors(50.0), count=uniform(0.0, 9.0))),
            'light': COLOR,
            'gate': ('float', choices(0.0, 1.0, 30.0, 1e3)),
            'cascade': ('uint', choices(0, 1, 2)),
            'white': ('float', choices(0.01, 1.0, 50.0)),
        },
        {'sum': 'BrightSum', 'size': 'float', 'level': 'float'},
        tolerances={'sum': ROUNDING},
    ),
    Case(
        'health',
        'kind = bad_light(light * gate - vec3(shade), limit); bad = select(bad_number(light.x * gate), 1u, 0u);',
        {'light': COLOR, 'gate': ('float', choices(1.0, 1e16, 1e31)), 'shade': ('float', choices(0.0, 0.5))}
        | {'limit': ('float', choices(0.5, 1e30))},
        {'kind': 'uint', 'bad': 'uint'},
    ),
]

LIGHTS = [
    Case(
        'light_geometry',
        'spot = spot_attenuation(light, wi); cap = point_light_cap(light, d * d);'
        'versine = spot_direction_versine(light, wi); t = point_light_distance(light, d, c);',
        {'light': LIGHT, 'wi': DIRECTION, 'd': POSITIVE, 'c': SIGNED},
        {'spot': 'float', 'versine': 'float', 'cap': 'float', 't': 'float'},
    ),
    Case(
        'light_samples',
        'point_light_sample(light, p, n, u, a); sun_light_sample(light, u, b); light_sample(light, p, n, u, c);',
        {'light': LIGHT, 'p': POINT, 'n': NORMAL, 'u': SQUARE},
        {'a': 'LightSample', 'b': 'LightSample', 'c': 'LightSample'},
        ROUNDING,
        {'a.distance': SILHOUETTE, 'c.distance': SILHOUETTE},
    ),
    Case(
        'light_intersections',
        # Aim near the light, or hardly any ray would meet one.
        'float len; vec3 d = light.type == LIGHT_SUN ? -light.axis : light.position - p;'
        'd = safe_normalize(d + lean, len);'
        'hit = select(light_intersect(light, p, d, t_max, n, radiance, pdf), 1u, 0u);'
        'if (hit == 0u) { radiance = vec3(0.0f); pdf = 0.0f; }',
        {
            'light': LIGHT,
            'p': POINT,
            'lean': ('vec3', points(0.05)),
            't_max': ('float', choices(1.0, 5.0, 1e30)),
            'n': NORMAL,
        },
        {'hit': 'uint', 'radiance': 'vec3', 'pdf': 'float'},
        tolerances={'pdf': ROUNDING},
    ),
]

TRIANGLE = ('uint', integers(TRIANGLES))
INSTANCE = ('uint', integers(INSTANCES))

SURFACES = [
    Case(
        'instances',
        'Instance i = LOAD(scene.instances, index); p = instance_point(i, a); v = instance_vector(i, a);'
        'n = instance_normal(i, a);'
        'Mesh mesh = LOAD(scene.meshes, i.mesh);'
        'ids = mesh_normal_indices(mesh, triangle, LOAD(mesh.triangles, triangle));',
        {'index': INSTANCE, 'triangle': TRIANGLE, 'a': POINT},
        {'p': 'vec3', 'v': 'vec3', 'n': 'vec3', 'ids': 'uvec3'},
        scene=True,
    ),
    Case(
        'surface_hits',
        'surface_from_hit(scene, hit, d, s); uv = surface_uv(scene, s);'
        'origin = surface_ray_origin(s.p, s.ng, s.epsilon, wi);'
        'surface_fetch(scene, hit.instance, hit.triangle, triangle);'
        'rounding = surface_shape(triangle, hit.u, hit.v, wi, p, ng, n, side);',
        {'hit': ('Hit', hits), 'd': DIRECTION, 'wi': DIRECTION},
        {'s': 'Surface', 'uv': 'vec2', 'origin': 'vec3', 'triangle': 'SurfaceTriangle', 'rounding': 'float'}
        | {'p': 'vec3', 'ng': 'vec3', 'n': 'vec3', 'side': 'float'},
        scene=True,
    ),
    Case(
        'surface_lifts',
        'height = plane_height(a, n, b, c, p, side);'
        'const bool smooth_mesh = LOAD(scene.meshes, LOAD(scene.instances, s.instance).mesh).flags != 0u;'
        'lift = vec3(0.0f);'
        'if (smooth_mesh) lift = surface_smooth_lift(scene, s.instance, s.triangle, s.u, s.v, s.ng);',
        {
            'a': POINT,
            'n': NORMAL,
            'b': POINT,
            'c': POINT,
            'p': POINT,
            'side': ('float', choices(-1.0, 1.0)),
            's': SURFACE,
        },
        {'height': 'float', 'lift': 'vec3'},
        scene=True,
    ),
]

CASES = [*BUILT_INS, *MATH, *SAMPLING, *CAMERA, *LIGHTS, *SURFACES]
