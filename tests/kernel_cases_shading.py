# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: whole programs, and what surfaces draw.

Ops by themselves stand in kernel_cases_program.py; that their values are Cycles' is test_ops_cycles.py's.
"""

from __future__ import annotations

from kernel_cases import COLOR, DIRECTION, LIBRARY, SQUARE, UINT, UNIT
from kernel_inputs import MATERIALS, choices, integers, magnitudes, materials, paths, points, surfaces, uniform
from kernel_inputs_programs import GROUPS, KINDS, number
from kernel_parity import Case, Tolerance

SURFACE = ('Surface', surfaces)
NUMBER = ('float', uniform(-3.0, 3.0))
# Sines of programs, and the roots and powers of lobes, are each library's own.
LOBES = Tolerance(8192, 'powers, exponentials and sines, whose difference small cosines enlarge', absolute=2e-3)
SUMS = Tolerance(256, 'sums of products cancel, and their compilers contract them', absolute=2e-5, typical=16)
SPREAD = Tolerance(8192, 'quotients of differences of coordinates', absolute=2e-3)

# Any value of the point that a ray meets; the last bits of `mode` ask for it one pixel aside.
POINT = (
    'ShaderPoint at = shader_point(s, o, t); at.footprint = 0.01f; at.ray_kind = kind; at.bounce = kind & 3u;'
    'ProgramArguments a; for (int k = 0; k < 32; ++k) a.v[k] = 0.3f;'
)
POINT_INPUTS = {
    's': SURFACE,
    'o': DIRECTION,
    't': ('float', magnitudes(0.1, 100.0)),
    'kind': ('uint', choices(*(1 << bit for bit in range(9)))),
}
ONE = 0x3C00  # a share of a pixel, as a half float
MODES = (0, 1, 2, 3)
SHIFTED = (0, 1 << 30 | ONE, 2 << 30 | ONE)


def by_number(*names: str) -> tuple:
    """Draws numbers of ops."""
    return ('uint', choices(*(number(name) for name in names)))


def pure(name: str, names: tuple[str, ...], groups: tuple[str, ...], tolerance: Tolerance) -> Case:
    """Ops by their numbers, as interpreters call them; arguments are any numbers."""
    return Case(
        name,
        'ProgramArguments a; for (int k = 0; k < 32; ++k) a.v[k] = y;'
        'a.v[0] = p.x; a.v[1] = p.y; a.v[2] = p.z; a.v[3] = q.x; a.v[4] = q.y; a.v[5] = q.z; a.v[6] = x;'
        'value = program_pure(op, mode, a);',
        {'op': by_number(*names), 'mode': ('uint', integers(3)), 'p': COLOR, 'q': COLOR, 'x': NUMBER, 'y': UNIT},
        {'value': 'vec3'},
        tolerance,
        program=True,
        groups=groups,
        ops=names,
    )


NUMBERS = ('luminance', 'average', 'component', 'clamp_f', 'mix_f', 'vector_math_f', 'map_range_f')
VECTORS = ('splat', 'combine', 'mix_v', 'affine', 'map_range_v')
COLORS = ('combine_color', 'hsv', 'gamma', 'bright_contrast', 'invert')
PATTERNS = ('white_noise_f', 'gradient_f', 'checker_f')
GEOMETRY = ('normal', 'true_normal', 'incoming', 'backfacing', 'object_info_v', 'object_info_f')
GEOMETRY += ('light_path', 'light_falloff')
PLACES = ('position', 'parametric', 'generated', 'object_position', 'attribute', 'attribute_alpha', 'attribute_fac')
VIEWS = ('camera_position', 'window', 'camera_z', 'camera_distance', 'object_transform')
LOOKS = ('fresnel', 'layer_weight', 'layers', 'wireframe')
RAYS = ('ao', 'bevel', 'raycast', 'raycast_normal')
BENT = ('tangent', 'geometry_tangent', 'uv_tangent', 'normal_map', 'bump')


def context(
    name: str, names: tuple[str, ...], modes: tuple[int, ...], groups: tuple[str, ...], tolerance: Tolerance
) -> Case:
    """Ops that read the point, with colours and numbers for arguments; the layers of meshes are 0 to 2."""
    return Case(
        name,
        POINT + 'a.v[0] = x; a.v[4] = x; if (op == OP_FRESNEL) a.v[0] = 1.3f;'
        'value = program_context(scene, at, op, mode, a); variants = program_variants(op, mode);',
        {'op': by_number(*names), 'mode': ('uint', choices(*modes)), 'x': ('float', choices(0.0, 1.0, 2.0))}
        | POINT_INPUTS,
        {'value': 'vec3', 'variants': 'uint'},
        tolerance,
        scene=True,
        program=True,
        groups=groups,
        ops=names,
    )


OPS = [
    pure('pure_numbers', NUMBERS, ('GROUP_MATH',), SUMS),
    pure('pure_vectors', VECTORS, ('GROUP_VECTOR',), SUMS),
    pure('pure_colors', COLORS, ('GROUP_COLOR',), Tolerance(4096, 'powers, and hues of small differences', 4e-5)),
    pure('pure_patterns', PATTERNS, ('GROUP_PATTERN',), LIBRARY),
    context('context_geometry', GEOMETRY, MODES, ('GROUP_POINT',), SUMS),
    context('context_places', PLACES, SHIFTED, ('GROUP_COORDINATES',), SPREAD),
    context('context_views', VIEWS, SHIFTED, ('GROUP_COORDINATES', 'GROUP_POINT'), SPREAD),
    context('context_looks', LOOKS, (0, 1), ('GROUP_POINT', 'GROUP_LAYERS'), LOBES),
    context('context_bent', BENT, MODES, ('GROUP_NORMAL',), SPREAD),
    Case(
        'context_rays',  # which meet nothing here
        POINT
        + 'at.rays = bits; at.random = bits; a.v[0] = u; value = program_context(scene, at, op, mode | 3u << 8, a);'
        'radius = bevel_radius(u); drawn = ray_pair(at, bits, kind & 7u, ray_bits(kind & 7u));',
        {'op': by_number(*RAYS), 'mode': ('uint', choices(0, 1, 2, 3)), 'u': UNIT, 'bits': UINT} | POINT_INPUTS,
        {'value': 'vec3', 'radius': 'float', 'drawn': 'vec2'},
        SUMS,
        scene=True,
        program=True,
        groups=('GROUP_RAYS',),
        ops=RAYS,
    ),
    Case(
        'table_ops',
        'ProgramArguments a; for (int k = 0; k < 32; ++k) a.v[k] = share;'
        'a.v[0] = p.x; a.v[1] = p.y; a.v[2] = p.z; a.v[3] = 3.0f; a.v[4] = -1.0f; a.v[5] = 1.0f;'
        'vectors = program_table(scene, OP_VECTOR_CURVE_V, 1u, a);'
        'curve = op_curve_f(scene, 1u, p.x, 3.0f, -1.0f, 1.0f, share);',
        {'share': UNIT, 'p': ('vec3', points(0.7))},
        {'vectors': 'vec3', 'curve': 'float'},
        Tolerance(256, 'differences of entries are multiplied by their number', absolute=1e-4, typical=64),
        scene=True,
        program=True,
        ops=('vector_curve_v',),
    ),
    Case(
        'cells_and_tiles',
        'value = op_voronoi_v(1u, p, x, 1.0f, 0.0f, 0.5f, 2.0f, 1.0f, 0.5f, 1.0f);'
        'tile = op_radial_tiling_f(0u, p, 5.5f, 0.4f);',
        {'p': ('vec3', points()), 'x': NUMBER},
        {'value': 'vec3', 'tile': 'float'},
        LIBRARY,
        program=True,
    ),
]

WHICH = ('uint', integers(len(KINDS)))
BEGIN = (
    f'const uint material = {MATERIALS}u + which; const MaterialProgram program = LOAD(scene.programs, material);'
    'ShaderPoint at = shader_point(s, o, 1.0f); PROGRAM_BEGIN_MEMORY;'
    'program_run(scene, at, program.surface, program.constants PROGRAM_SAME_MEMORY);'
)
SURFACES = [
    Case(
        'program_value',
        f'const MaterialProgram program = LOAD(scene.programs, {MATERIALS}u + which);'
        'ShaderPoint at = shader_point(s, o, 1.0f);'
        'value = program_value(scene, at, program.emission, program.constants);'
        'Material m = LOAD(scene.materials, 0u); varies = select(surface_varies(scene, s, m), 1u, 0u);'
        'normal_at = closure_normal(which);',
        {'s': SURFACE, 'o': DIRECTION, 'which': WHICH},
        {'value': 'vec3', 'varies': 'uint', 'normal_at': 'uint'},
        LIBRARY,
        scene=True,
        program=True,
        groups=GROUPS,
    ),
    Case(
        'world_program',
        f'const MaterialProgram program = LOAD(scene.programs, {MATERIALS}u);'
        'scene.world_program = program.emission; scene.world_constants = program.constants;'
        'sky = path_escape(scene, path, d, world_radiance(scene, path_background(path, d)));'
        'Bsdf bsdf; bsdf_prepare(scene, m, s.n, s.ng, o, bsdf); Lobe lobe;'
        'lobe_clear(LOBE_NONE, vec3(0.0f), s.n, lobe);'
        'shown = world_radiance(scene, path_world_point(scene, path, lobe, d)); ShadowRay ray;'
        'path_sample_world(scene, path, s, bsdf, lobe, o, u, ray); to = ray.direction;',
        {'path': ('PathState', paths), 'd': DIRECTION, 's': SURFACE, 'o': DIRECTION, 'm': ('Material', materials)}
        | {'u': SQUARE},
        {'sky': 'vec3', 'shown': 'vec3', 'to': 'vec3'},
        LIBRARY,
        scene=True,
        program=True,
        groups=GROUPS,
    ),
    Case(
        'surface_draw',
        BEGIN + 'const SurfacePick drawn = surface_draw(scene, program, u PROGRAM_SAME_MEMORY);'
        'kind = drawn.kind; weight = drawn.weight; rest = drawn.u; color = vec3(0.0f); n = at.n; share = 0.0f;'
        'if (kind != CLOSURE_HOLDOUT) color = pick_vector(scene, drawn, 0u PROGRAM_SAME_MEMORY);'
        'if (kind == CLOSURE_DIFFUSE) { share = pick_number(scene, drawn, 1u PROGRAM_SAME_MEMORY);'
        ' n = pick_normal(scene, drawn, at, 2u PROGRAM_SAME_MEMORY); } own = at.n;'
        'if (drawn.own_normal == CLOSURE_BENT_NORMAL) own = pick_own_normal(scene, drawn, at PROGRAM_SAME_MEMORY);',
        {'s': SURFACE, 'o': DIRECTION, 'which': WHICH, 'u': UNIT},
        {
            'own': 'vec3',
            'kind': 'uint',
            'weight': 'vec3',
            'rest': 'float',
            'color': 'vec3',
            'n': 'vec3',
            'share': 'float',
        },
        Tolerance(4096, "sines are each library's own; what is left of u divides by probabilities", absolute=2e-5),
        scene=True,
        program=True,
        groups=GROUPS,
    ),
    Case(
        'surface_principled',
        f'const uint which = {KINDS.index("principled")}u;' + BEGIN + 'const ClosureRow row = LOAD('
        'scene.program_closures, program.surface.result); SurfacePick drawn; drawn.kind = row.kind; drawn.u = 0.5f;'
        'drawn.mode = row.mode; drawn.arguments = row.arguments; drawn.constants = program.constants;'
        'drawn.weight = vec3(1.0f); Material m = LOAD(scene.materials, material);'
        'pick_principled(scene, drawn, m PROGRAM_SAME_MEMORY); base = m.base_color;'
        'PrincipledInputs p; pick_principled_inputs(scene, drawn, at, m, s.n, p PROGRAM_SAME_MEMORY); coat = p.coat;'
        'asks = select(principled_asks_lobes(p), 1u, 0u); tint = p.sheen_tint; coat_n = p.coat_n;'
        'pick_nearest(scene, drawn, 0.5f, m PROGRAM_SAME_MEMORY); nearest = m.base_color;',
        {'s': SURFACE, 'o': DIRECTION},
        {'base': 'vec3', 'coat': 'float', 'asks': 'uint', 'tint': 'vec3', 'coat_n': 'vec3', 'nearest': 'vec3'},
        LIBRARY,
        scene=True,
        program=True,
        groups=GROUPS,
    ),
    Case(
        'surface_lobes',
        BEGIN + 'const ClosureRow row = LOAD(scene.program_closures,'
        ' program.surface.result); SurfacePick drawn; drawn.kind = row.kind; drawn.u = 0.5f; drawn.mode = row.mode;'
        'drawn.arguments = row.arguments; drawn.constants = program.constants; drawn.weight = vec3(1.0f);'
        'lobe_clear(LOBE_NONE, vec3(0.0f), s.n, l);'
        'if (row.kind != CLOSURE_HOLDOUT) pick_lobe_of(scene, drawn, at, s, 0.4f, l PROGRAM_SAME_MEMORY);',
        {'s': SURFACE, 'o': DIRECTION, 'which': WHICH},
        {'l': 'Lobe'},
        LOBES,
        scene=True,
        program=True,
        groups=GROUPS,
    ),
    # Both ways to a surface's closure: as graphics cards go it, and as the CPU takes it after its programs have run.
    Case(
        'surface_shading',
        f'scene.lobes = lobes; Surface at_surface = s; at_surface.material = {MATERIALS}u + which;'
        'ShaderPoint at = shader_point(at_surface, o, 1.0f); Bsdf bsdf;'
        'surface_shading(scene, at, u, at_surface, shading, bsdf, l); n = at_surface.n; smooth_n = bsdf.n_smooth;',
        {'s': SURFACE, 'o': DIRECTION, 'which': WHICH, 'u': UNIT, 'lobes': ('uint', integers(2))},
        {'shading': 'SurfaceShading', 'l': 'Lobe', 'n': 'vec3', 'smooth_n': 'vec3'},
        LOBES,
        scene=True,
        program=True,
        groups=GROUPS,
    ),
    Case(
        'surface_take',
        'Surface at_surface = s; ' + BEGIN + 'at_surface.material = material; Bsdf bsdf; Lobe l;'
        'surface_begin(scene, at_surface, shading);'
        'surface_take(scene, program, at, u, at_surface, shading, bsdf, l PROGRAM_SAME_MEMORY); n = at_surface.n;',
        {'s': SURFACE, 'o': DIRECTION, 'which': WHICH, 'u': UNIT},
        {'shading': 'SurfaceShading', 'n': 'vec3'},
        LOBES,
        scene=True,
        program=True,
        groups=GROUPS,
    ),
]

CASES = [*OPS, *SURFACES]
