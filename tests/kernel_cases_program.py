# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: ops of shading programs, one a kind.

What ops compute is compared with Cycles, on the CPU (test_ops_cycles.py); here, that the other language says the same.
"""

from __future__ import annotations

from kernel_inputs import choices, directions, integers, uniform, vectors
from kernel_parity import Case, Tolerance

COORDINATE = ('vec3', vectors(uniform(-6.0, 6.0)))
NUMBER = ('float', uniform(-3.0, 3.0))
SHARE = ('float', uniform())
SCALE = ('float', uniform(0.5, 4.0))
COLOR = ('vec3', vectors(uniform(-0.2, 1.5)))
NORMAL = ('vec3', directions())

ROUNDED = Tolerance(
    64, 'Vulkan lets compilers reorder constant factors; near 0 the error is absolute', absolute=2e-6, typical=16
)
LIBRARY = Tolerance(4096, "exp, pow and angles are each library's own", absolute=2e-5)
CELL = Tolerance(64, 'distances are roots of sums of differences', absolute=2e-6)
TEXEL = Tolerance(64, "weights are differences of coordinates, whose angles are each library's own", absolute=4e-3)
# A mode that is written out is constant in the shader, as in a loop over lanes.
FBM = '(2u | (NOISE_FBM << 2) | NOISE_NORMALIZE)'
RIDGED = '(1u | (NOISE_RIDGED_MULTIFRACTAL << 2))'

CASES = [
    Case(
        'program_hashes',
        'a = hash_float4_to_vec3(vec4(p, x)); b = pcg4(int(i), int(j), -int(i), 7);'
        'c = op_white_noise_v(2u, p, x); d = pcg2(int(i), -int(j)); e = lookup3_1(i) ^ lookup3_2(i, j);',
        {'p': COORDINATE, 'x': NUMBER, 'i': ('uint', integers(1000)), 'j': ('uint', integers())},
        {'a': 'vec3', 'b': 'vec4', 'c': 'vec3', 'd': 'vec2', 'e': 'uint'},
        program=True,
    ),
    Case(
        'program_numbers',
        'ProgramArguments a; for (int k = 0; k < 32; ++k) a.v[k] = 0.0f;'
        'a.v[0] = x; a.v[1] = y; a.v[2] = z; number = program_pure(OP_MATH, operation, a).x;',
        {
            'operation': ('uint', choices(*range(4), *range(12, 26), *range(32, 41))),
            'x': NUMBER,
            'y': NUMBER,
            'z': NUMBER,
        },
        {'number': 'float'},
        ROUNDED,
        program=True,
        ops=('math',),
    ),
    Case(
        'program_vectors',
        'moved = op_mapping(mode, p, q, r, s); turned = op_vector_rotate(4u, p, q, r, 0.5f, s);'
        'reflected = op_vector_math_v(6u, p, q, r, 1.0f);',
        {
            'mode': ('uint', integers(4)),
            'p': COORDINATE,
            'q': COORDINATE,
            'r': COORDINATE,
            's': ('vec3', vectors(uniform(0.5, 2.0))),
        },
        {'moved': 'vec3', 'turned': 'vec3', 'reflected': 'vec3'},
        Tolerance(256, 'sums of products cancel', absolute=1e-5, typical=16),
        program=True,
    ),
    Case(
        'program_colors',
        'mixed = op_mix_color(mode | MIX_CLAMP_FACTOR, t, p, q); hsl = op_separate_color(2u, p);'
        'warm = op_blackbody(0u, 800.0f + 9000.0f * t); pure = op_wavelength(0u, 380.0f + 390.0f * t);',
        {'mode': ('uint', integers(19)), 't': SHARE, 'p': COLOR, 'q': ('vec3', vectors(uniform(0.1, 1.0)))},
        {'mixed': 'vec3', 'hsl': 'vec3', 'warm': 'vec3', 'pure': 'vec3'},
        Tolerance(4096, 'saturations divide small differences, and hues those', absolute=4e-5, typical=64),
        program=True,
    ),
    Case(
        'program_noise',
        f'fbm = op_noise_f({FBM}, p, x, scale, 3.4f, share, 2.0f, 0.0f, 1.0f, 0.0f);'
        f'ridged = op_noise_v({RIDGED}, p, x, scale, 2.0f, share, 2.0f, 0.9f, 1.5f, 0.3f);'
        'wave = op_wave_f(33u, p, scale, 1.0f, 2.0f, 1.0f, share, x); magic = op_magic_v(3u, p, scale, 1.2f);',
        {'p': COORDINATE, 'x': NUMBER, 'scale': SCALE, 'share': SHARE},
        {'fbm': 'float', 'ridged': 'vec3', 'wave': 'float', 'magic': 'vec3'},
        Tolerance(1024, 'roundings of coordinates grow with frequency', absolute=1e-4, typical=64),
        program=True,
    ),
    Case(
        'program_cells',
        'f1 = op_voronoi_f(2u | VORONOI_NORMALIZE, p, x, scale, 1.5f, share, 2.0f, 1.0f, 0.5f, 1.0f);'
        'smooth_f1 = op_voronoi_f(1u | (VORONOI_SMOOTH_F1 << 2), p, x, scale, 0.0f, 0.5f, 2.0f, 1.0f, 0.5f, 1.0f);'
        'edge = op_voronoi_f(1u | (VORONOI_EDGE << 2), p, x, scale, 0.0f, 0.5f, 2.0f, 1.0f, 0.5f, 1.0f);',
        {'p': COORDINATE, 'x': NUMBER, 'scale': SCALE, 'share': SHARE},
        {'f1': 'float', 'smooth_f1': 'float', 'edge': 'float'},
        CELL,
        program=True,
    ),
    Case(
        'program_patterns',
        'checker = op_checker_f(0u, p, scale); '
        'brick = op_brick_f(770u, p, scale, 0.03f, 0.4f, 0.1f, 0.5f, 0.25f, 0.5f, 0.7f);'
        'gabor = op_gabor_f(0u, p, scale, 2.0f, share, 0.7f, p);'
        'tile = op_radial_tiling_v(0u, p, 5.5f, 0.4f); radial = op_gradient_f(4u, p);',
        {'p': COORDINATE, 'scale': SCALE, 'share': SHARE},
        {'checker': 'float', 'brick': 'vec3', 'gabor': 'float', 'tile': 'vec3', 'radial': 'float'},
        LIBRARY,
        program=True,
    ),
    Case(
        'program_tables',
        'ramp = op_ramp_v(scene, 0u, x, 0.0f, 257.0f); alpha = op_ramp_alpha(scene, 1u, share, 0.0f, 257.0f);'
        'curve = op_rgb_curve_v(scene, 1u, p, 3.0f, -1.0f, 1.0f, share);',
        {'x': ('float', uniform(-0.2, 1.2)), 'share': SHARE, 'p': ('vec3', vectors(uniform(-1.5, 1.5)))},
        {'ramp': 'vec3', 'alpha': 'float', 'curve': 'vec3'},
        Tolerance(256, 'differences of entries are multiplied by their number', absolute=1e-4, typical=64),
        scene=True,
        program=True,
    ),
    Case(
        'program_images',
        'box = op_image_v(scene, 17u, p, 0.0f, 0.4f, n); tube = op_image_f(scene, 53u, p, 0.0f, 0.0f, n);'
        'around = op_environment_v(scene, 1u, n, 0.0f); ball = op_environment_v(scene, 17u, n, 0.0f);',
        {'p': ('vec3', vectors(uniform(0.05, 0.95))), 'n': NORMAL},
        {'box': 'vec3', 'tube': 'float', 'around': 'vec3', 'ball': 'vec3'},
        TEXEL,
        scene=True,
        program=True,
    ),
]
