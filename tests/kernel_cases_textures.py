# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: images and materials that read them."""

from __future__ import annotations

import numpy as np

from kernel_cases import POINT, ROUNDING, SURFACE, UINT, UNIT
from kernel_cases_path import DIRECTION, MATERIAL, NORMAL, WO
from kernel_inputs import INSTANCES, MATERIALS, TRIANGLES, choices, integers, points, records, uniform, vectors
from kernel_inputs_textures import SLOTS
from kernel_parity import Case, Tolerance

TEXTURE_INDEX = ('uint', integers(4))
SLOT_INDEX = ('uint', integers(SLOTS))
MATERIAL_INDEX = ('uint', integers(MATERIALS))
WORDS = ('uint', choices(0, 1, 2))
EXTENSION = ('uint', integers(4))
# Coordinates that lie inside, outside, far away, and that are no numbers a texel could have.
FAR = ('float', choices(*np.linspace(-3.0, 4.0, 701), -1e7, 1e8, 3e9, -1e30))
AT = (
    'TexturePoint',
    records(
        'TexturePoint',
        instance=integers(INSTANCES),
        triangle=integers(TRIANGLES),
        u=uniform(0.0, 0.5),
        v=uniform(0.0, 0.5),
    ),
)
POWER = Tolerance(256, "pow above 1 is each library's own, and rounding before it is enlarged", typical=16)
# A texel's edge or its neighbour: rounding of the coordinate may choose either.
STEPS = Tolerance(
    64, 'coordinates are sums whose rounding Vulkan leaves open, and weights their differences', absolute=2e-4
)
LAST = 'LastLookup last; last.texel = vec4(0.0f, 0.0f, 0.0f, 0.0f); last.lookup = INVALID_ID; '

TEXTURES = [
    Case(
        'texel_numbers',
        'decoded = srgb_decode(c); wide = float_from_half(h & 0x7bffu); low = texture_split(x, fraction);'
        'weights = cubic_weights(c - 0.5f); place = texture_wrap(int(h % 64u) - 32, 1 + int(h >> 28), extension);',
        {'c': ('float', uniform(-0.1, 1.0)), 'h': UINT, 'x': FAR, 'extension': EXTENSION},
        {'decoded': 'float', 'wide': 'float', 'low': 'int', 'fraction': 'float', 'weights': 'vec4', 'place': 'int'},
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
        'texel = texture_filtered(t, st, interpolation, extension);'
        'weights = texture_weights(interpolation, fraction); weight = texture_weight(weights, int(interpolation));',
        {
            'index': TEXTURE_INDEX,
            'st': ('vec2', vectors(FAR[1], 2)),
            'interpolation': WORDS,
            'extension': EXTENSION,
            'fraction': UNIT,
        },
        {'texel': 'vec4', 'weights': 'vec4', 'weight': 'float'},
        STEPS,
        scene=True,
    ),
    Case(
        'slots',
        'const TextureSlot slot = LOAD(scene.texture_slots, index); Texture t = LOAD(scene.textures, slot.image);'
        'const vec4 c = vec4(rgb.x, rgb.y, rgb.z, a); decoded = texture_decode(t, slot, c);'
        'linear = texture_linear(t, (slot.flags & TEXTURE_UNASSOCIATE) == 0u, c);'
        'value = texture_value(slot, c);',
        {'index': SLOT_INDEX, 'rgb': ('vec3', vectors(uniform(0.0, 1.0))), 'a': ('float', uniform(0.9, 1.0))},
        {'decoded': 'vec4', 'linear': 'vec4', 'value': 'vec3'},
        POWER,
        scene=True,
    ),
    Case(
        'lookups',
        'const TextureSlot slot = LOAD(scene.texture_slots, index); texel = texture_lookup(scene, slot, p);',
        {'index': SLOT_INDEX, 'p': ('vec3', points(1.0))},
        {'texel': 'vec4'},
        STEPS,
        scene=True,
    ),
]

COORDINATES = [
    Case(
        'texture_spaces',
        'const Instance instance = LOAD(scene.instances, at.instance); Mesh mesh = LOAD(scene.meshes, instance.mesh);'
        'MeshTextures more = LOAD(scene.mesh_textures, instance.mesh);'
        'uv = mesh_uv(mesh, more, layer, LOAD(mesh.corners, at.triangle), at.u, at.v);'
        'position = texture_position(instance, mesh, LOAD(mesh.triangles, at.triangle), at.u, at.v);'
        'own = object_space_point(LOAD(scene.object_spaces, at.instance), p);'
        'const TextureSlot slot = LOAD(scene.texture_slots, index); place = texture_coordinates(scene, slot, at);',
        {'at': AT, 'layer': WORDS, 'p': POINT, 'index': SLOT_INDEX},
        {'uv': 'vec2', 'position': 'vec3', 'own': 'vec3', 'place': 'vec3'},
        ROUNDING,
        scene=True,
    ),
]

INPUTS = [
    Case(
        'material_inputs',
        f'{LAST}first = material_input(scene, int(index), at, last);'
        'second = material_input(scene, int(other), at, last);'
        'alone = material_slot(scene, int(index), at); bounded = unit_clamp(first.x);',
        {'index': SLOT_INDEX, 'other': SLOT_INDEX, 'at': AT},
        {'first': 'vec3', 'second': 'vec3', 'alone': 'vec3', 'bounded': 'float'},
        STEPS,
        scene=True,
    ),
    Case(
        'material_inputs_by_number',
        'const MaterialInputs inputs = LOAD(scene.material_inputs, s.material);'
        'slot = uint(material_input_slot(inputs, number)); material = LOAD(scene.materials, s.material);'
        'material_set_input(number, value, material);',
        {'s': SURFACE, 'number': ('uint', integers(7)), 'value': POINT},
        {'slot': 'uint', 'material': 'Material'},
        scene=True,
    ),
    Case(
        'materials_resolved',
        'const TexturePoint at = texture_point(s); material = LOAD(scene.materials, s.material);'
        'const Material constant = material; material_resolve(scene, s.material, at, material);'
        'material_fetch(scene, s, fetched); emitted = material_emission(scene, s.material, constant, at);'
        'alpha = material_alpha(scene, s.material, at);',
        {'s': SURFACE},
        {'material': 'Material', 'fetched': 'Material', 'emitted': 'vec3', 'alpha': 'float'},
        STEPS,
        scene=True,
    ),
]

NORMALS = [
    Case(
        'normal_frames',
        'const Instance instance = LOAD(scene.instances, s.instance); Mesh mesh = LOAD(scene.meshes, instance.mesh);'
        'MeshTextures more = LOAD(scene.mesh_textures, instance.mesh); frame = normal_frame(instance, more);'
        'there = normal_to_world(frame, n); back = normal_to_object(frame, n);'
        'base = tangent_space_normal(mesh, more, frame, s); tangent = mesh_tangent(mesh, more, layer, s);'
        'unit = normalize_or(n * gate, s.n);',
        {'s': SURFACE, 'n': POINT, 'layer': WORDS, 'gate': ('float', choices(0.0, 1.0, 1e20))},
        {'frame': 'NormalFrame', 'there': 'vec3', 'back': 'vec3', 'base': 'vec3', 'tangent': 'vec4', 'unit': 'vec3'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'mapped_normals',
        'const Instance instance = LOAD(scene.instances, s.instance); Mesh mesh = LOAD(scene.meshes, instance.mesh);'
        'MeshTextures more = LOAD(scene.mesh_textures, instance.mesh);'
        'const MaterialInputs from = LOAD(scene.material_inputs, s.material);'
        'const NormalFrame frame = normal_frame(instance, more);'
        'bent = tangent_normal(mesh, more, frame, from, s, c); n = material_normal(scene, s);',
        {'s': SURFACE, 'c': POINT},
        {'bent': 'vec3', 'n': 'vec3'},
        Tolerance(512, 'a sum of vectors of any direction cancels, and the texel is a difference', absolute=2e-3),
        scene=True,
    ),
    Case(
        'transparency',
        'index = triangle_material(scene, at.instance, at.triangle); alpha = alpha_at(scene, at);'
        'number = alpha_number(bits, bounce, seed, at.instance, at.triangle);',
        {'at': AT, 'bits': UINT, 'bounce': ('uint', integers(20)), 'seed': UINT},
        {'index': 'uint', 'alpha': 'float', 'number': 'float'},
        STEPS,
        scene=True,
    ),
    Case(
        'normals_bent_by_maps',
        'Bsdf bsdf; bsdf_prepare(scene, material, n, ng, wo, bsdf); bsdf.n_smooth = ng;'
        'kept = bump_shadowing(bsdf, wi);',
        {'material': MATERIAL, 'n': NORMAL, 'ng': NORMAL, 'wo': WO, 'wi': DIRECTION},
        {'kept': 'float'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'emitters_textured',
        'radiance = emitter_radiance(scene, LOAD(scene.emitters, index), vec2(0.5f * u, 0.5f * v));',
        {'index': ('uint', integers(7)), 'u': UNIT, 'v': UNIT},
        {'radiance': 'vec3'},
        STEPS,
        scene=True,
    ),
]

CASES = [*TEXTURES, *COORDINATES, *INPUTS, *NORMALS]
