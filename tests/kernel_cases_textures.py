# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: images, and points of shaders."""

from __future__ import annotations

import numpy as np

from kernel_cases import POINT, ROUNDING, SURFACE, UINT, UNIT
from kernel_cases_path import DIRECTION, MATERIAL, NORMAL, PATH, WO
from kernel_inputs import choices, hits, integers, uniform, vectors
from kernel_parity import Case, Tolerance

TEXTURE_INDEX = ('uint', integers(4))
WORDS = ('uint', choices(0, 1, 2))
EXTENSION = ('uint', integers(4))
# Coordinates that lie inside, outside, far away, and that are no numbers a texel could have.
FAR = ('float', choices(*np.linspace(-3.0, 4.0, 701), -1e7, 1e8, 3e9, -1e30))
POWER = Tolerance(256, "pow above 1 is each library's own, and rounding before it is enlarged", typical=16)
# A texel's edge or its neighbour: rounding of the coordinate may choose either.
STEPS = Tolerance(
    64, 'coordinates are sums whose rounding Vulkan leaves open, and weights their differences', absolute=2e-4
)

TEXTURES = [
    Case(
        'texel_numbers',
        'decoded = srgb_decode(c); unit = srgb_decode_unit(c); bytes = texel_bytes(h & 3u);'
        'taps = texture_taps(h & 3u); wide = float_from_half(h & 0x7bffu); low = texture_split(x, fraction);'
        'weights = cubic_weights(c - 0.5f); place = texture_wrap(int(h % 64u) - 32, 1 + int(h >> 28), extension);',
        {'c': ('float', uniform(-0.1, 1.0)), 'h': UINT, 'x': FAR, 'extension': EXTENSION},
        {'decoded': 'float', 'wide': 'float', 'low': 'int', 'fraction': 'float', 'weights': 'vec4', 'place': 'int'}
        | {'unit': 'float', 'bytes': 'uint', 'taps': 'int'},
        ROUNDING,
    ),
    Case(
        'texels',
        'Texture t = LOAD(scene.textures, index); number = texture_component(t, which % (t.width * t.height));'
        'texel = texture_texel(t, int(which % (t.width + 1u)) - 1, int((which >> 8) % t.height));',
        {'index': TEXTURE_INDEX, 'which': UINT},
        {'number': 'float', 'texel': 'vec4'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'texture_filters',
        'Texture t = LOAD(scene.textures, index);'
        'texel = texture_filtered(t, st, interpolation, extension); place = texture_place(t, st, interpolation);'
        'same = texture_gather(t, place, interpolation, extension);'
        'weights = texture_weights(interpolation, fraction); weight = texture_weight(weights, int(interpolation));',
        {
            'index': TEXTURE_INDEX,
            'st': ('vec2', vectors(FAR[1], 2)),
            'interpolation': WORDS,
            'extension': EXTENSION,
            'fraction': UNIT,
        },
        {'texel': 'vec4', 'same': 'vec4', 'place': 'TexturePlace', 'weights': 'vec4', 'weight': 'float'},
        STEPS,
        scene=True,
    ),
    Case(
        'texels_linear',
        'Texture t = LOAD(scene.textures, index); const vec4 c = vec4(rgb.x, rgb.y, rgb.z, a);'
        'decoded = texture_linear(t, divides != 0u, c); straight = texture_straight(divides != 0u, c);',
        {'index': TEXTURE_INDEX, 'rgb': ('vec3', vectors(uniform(0.0, 1.0))), 'a': ('float', uniform(0.9, 1.0))}
        | {'divides': ('uint', integers(2))},
        {'decoded': 'vec4', 'straight': 'vec3'},
        POWER,
        scene=True,
    ),
]

COORDINATES = [
    Case(
        'points_of_shaders',
        'bare = mesh_point(hit, wo);'
        'at = shader_point(s, wo, t); at.footprint = 0.01f; shifted = at; point_shift(scene, shift, 0.5f, shifted);'
        'point_differentials(at, dx, dy); const Instance instance = LOAD(scene.instances, s.instance);'
        'corner = triangle_corner(scene, instance, 1u); own = point_generated(scene, at);'
        'read = point_attribute(scene, layer, at, components);'
        'const ObjectSpace space = LOAD(scene.object_spaces, s.instance); place = object_space_point(space, wo);'
        'way = object_space_vector(space, wo); Mesh mesh = LOAD(scene.meshes, instance.mesh);'
        'MeshTextures more = LOAD(scene.mesh_textures, instance.mesh);'
        'uv = mesh_uv(mesh, more, layer, LOAD(mesh.corners, s.triangle), s.u, s.v);',
        {'s': SURFACE, 'wo': WO, 't': UNIT, 'shift': WORDS, 'layer': WORDS, 'hit': ('Hit', hits)},
        {'at': 'ShaderPoint', 'shifted': 'ShaderPoint', 'dx': 'vec3', 'dy': 'vec3', 'corner': 'vec3', 'own': 'vec3'}
        | {'bare': 'ShaderPoint', 'read': 'vec4', 'components': 'uint', 'place': 'vec3', 'way': 'vec3', 'uv': 'vec2'},
        STEPS,
        scene=True,
    ),
]

INPUTS = [
    Case(
        'materials_without_programs',
        'const ShaderPoint at = shader_point(s, wo, 1.0f); const Material material = LOAD(scene.materials, s.material);'
        'varies = select(material_varies(material), 1u, 0u); bounded = unit_clamp(wo.x); number = light_number(wo.y);'
        'numbers = light_numbers(wo); emitted = material_emission(scene, s.material, material, at);'
        'through = material_transparency(scene, s.material, at); share = closure_share(wo);'
        'surface_begin(scene, s, shading); material_diffuse(wo, shading.material);',
        {'s': SURFACE, 'wo': WO},
        {'varies': 'uint', 'bounded': 'float', 'number': 'float', 'numbers': 'vec3', 'emitted': 'vec3'}
        | {'through': 'vec3', 'share': 'float', 'shading': 'SurfaceShading'},
        scene=True,
    ),
]

NORMALS = [
    Case(
        'normal_frames',
        'const Instance instance = LOAD(scene.instances, s.instance); Mesh mesh = LOAD(scene.meshes, instance.mesh);'
        'MeshTextures more = LOAD(scene.mesh_textures, instance.mesh); frame = normal_frame(instance, more);'
        'const ShaderPoint at = shader_point(s, s.ng, 1.0f);'
        'there = normal_to_world(frame, n); back = normal_to_object(frame, n);'
        'base = tangent_space_normal(mesh, more, frame, at); tangent = mesh_tangent(mesh, more, layer, at);'
        'frame_here = point_frame(scene, at); way = vector_to_world(frame, n);'
        'unit = normalize_or(n * gate, s.n);',
        {'s': SURFACE, 'n': POINT, 'layer': WORDS, 'gate': ('float', choices(0.0, 1.0, 1e20))},
        {'frame': 'NormalFrame', 'there': 'vec3', 'back': 'vec3', 'base': 'vec3', 'tangent': 'vec4', 'unit': 'vec3'}
        | {'frame_here': 'NormalFrame', 'way': 'vec3'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'mapped_normals',
        'const ShaderPoint at = shader_point(s, s.ng, 1.0f); bent = tangent_normal(scene, 0u, at, c, 0.8f);'
        'n = normal_map(scene, at, space, 0.5f * c + vec3(0.5f), 0.8f, 0u); about = tangent_about(s.n, c);'
        'tangent = uv_tangent(scene, at, 0u);',
        {'s': SURFACE, 'c': POINT, 'space': ('uint', integers(5))},
        {'bent': 'vec3', 'n': 'vec3', 'about': 'vec3', 'tangent': 'vec3'},
        Tolerance(512, 'a sum of vectors of any direction cancels', absolute=2e-3),
        scene=True,
    ),
    Case(
        'transparency',
        'index = triangle_material(scene, hit.instance, hit.triangle);'
        'through = hit_transparency(scene, hit, wo, path, false, 1u);'
        'alpha = hit_alpha(scene, hit, wo, path, true, 2u);'
        'number = alpha_number(bits, bounce, seed, hit.instance, hit.triangle);'
        'passes = select(lets_through(scene, hit, wo, path, 1u, seed), 1u, 0u);',
        {'hit': ('Hit', hits), 'wo': WO, 'bits': UINT, 'bounce': ('uint', integers(20)), 'seed': UINT} | {'path': PATH},
        {'index': 'uint', 'through': 'vec3', 'alpha': 'float', 'number': 'float', 'passes': 'uint'},
        STEPS,
        scene=True,
    ),
    Case(
        'normals_bent_by_maps',
        'Bsdf bsdf; bsdf_prepare(scene, material, n, ng, wo, bsdf); bsdf.n_smooth = ng;'
        'kept = bump_shadowing(bsdf, wi); either = bump_shadowing_of(n, ng, wi);',
        {'material': MATERIAL, 'n': NORMAL, 'ng': NORMAL, 'wo': WO, 'wi': DIRECTION},
        {'kept': 'float', 'either': 'float'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'emitters_textured',
        'PathState path; path_begin(1u, path);'
        'Surface s; s.t = 2.0f; const vec2 b = vec2(0.5f * u, 0.5f * v);'
        'radiance = emitter_radiance(scene, path, s, wo, LOAD(scene.emitters, index), b, wo, 1.0f);',
        {'index': ('uint', integers(7)), 'u': UNIT, 'v': UNIT, 'wo': WO},
        {'radiance': 'vec3'},
        STEPS,
        scene=True,
    ),
]

CASES = [*TEXTURES, *COORDINATES, *INPUTS, *NORMALS]
