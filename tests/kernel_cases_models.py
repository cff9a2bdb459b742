# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: reflection models beside Principled.

That their formulas are right is test_models.py's.
"""

from __future__ import annotations

import numpy as np

from kernel_cases import COLOR, DIRECTION, LIBRARY, NORMAL, POSITIVE, ROUNDING, SQUARE, UNIT
from kernel_inputs import (
    directions,
    integers,
    magnitudes,
    material_models,
    materials,
    records,
    uniform,
)
from kernel_parity import Case, Tolerance
from kernel_source import constants

COSINE = ('float', uniform(1e-3, 1.0))
ALPHA = ('float', magnitudes(1e-3, 1.0))
LOCAL = ('vec3', directions(upper=True))
KIND = ('uint', integers(3))
MODEL = ('MaterialModel', material_models)
HALF = (
    'HalfAngle',
    records(
        'HalfAngle',
        ni=uniform(0.01),
        nh=uniform(0.01),
        sin2=uniform(),
        oh=uniform(0.01),
        rv=uniform(-1.0),
        off_mirror=uniform(0.0, 2.0),
    ),
)


def modelled(rng: np.random.Generator, n: int) -> np.ndarray:
    """Materials whose models are those of the scene."""
    known = constants()
    values = materials(rng, n)
    values['roughness'] = rng.uniform(0.1, 1.0, n)
    index = rng.integers(0, 5, n).astype(np.uint32)
    values['flags'] = known['MATERIAL_MODEL'] | known['MATERIAL_SPECULAR'] | index << known['MATERIAL_INDEX_SHIFT']
    return values


MATERIAL = ('Material', modelled)
PREPARE = 'ModelBsdf m; albedo = model_prepare(material, model, n, n, o, m); '
# Powers and exponentials are each library's own, and exponents of a hundred enlarge what they differ by.
POWER = Tolerance(4096, "exp and log are each library's own, and exponents enlarge the difference", absolute=1e-4)
SLOPES = Tolerance(4096, 'an inverse of sums of exponentials: each step has its own rounding', absolute=2e-4)

NUMBERS = [
    Case(
        'model_numbers',
        'a = log_one_minus(x); f = log_near_one(x, 1.0f - x); b = one_minus_exp(y);'
        'c = pow_near_one(1.0f - x, x, y); d = erfc_scaled(y);'
        'e = acos_over_sine(x);',
        {'x': ('float', uniform(0.0, 0.999)), 'y': ('float', uniform(0.0, 8.0))},
        {'a': 'float', 'b': 'float', 'c': 'float', 'd': 'float', 'e': 'float', 'f': 'float'},
        LIBRARY,
    ),
    Case(
        'model_distributions',
        'a = D_Beckmann(x, sqrt(1.0f - x), alpha * alpha); b = D_BlinnPhong(x, sqrt(1.0f - x), alpha * alpha);',
        {'x': ('float', uniform(0.0, 0.99)), 'alpha': ('float', uniform(0.1, 1.0))},
        {'a': 'float', 'b': 'float'},
        POWER,
    ),
    Case(
        'model_masking',
        'a = N_LambdaGGX(no, alpha * alpha); b = N_LambdaBeckmann(no, alpha); c = N_LambdaBeckmannExact(no, alpha);'
        'd = V_SmithCorrelated(no, a, ni, b); e = V_Smith(no, a, ni, b); f = V_Cavity(no, ni, nh, oh);'
        'g = V_SchlickGGX(no, ni, alpha); h = V_CavityVisible(no, nh, oh); i = F_Conductor(oh, n, k);',
        {'no': COSINE, 'ni': COSINE, 'nh': COSINE, 'oh': COSINE, 'alpha': ALPHA, 'n': POSITIVE, 'k': POSITIVE},
        dict.fromkeys('abcdefghi', 'float'),
        ROUNDING,
        {'c': POWER, 'i': Tolerance(64, 'differences of squares enlarge the rounding', absolute=1e-5)},
    ),
    Case(
        'model_diffuse',
        'a = oren_nayar_shape(no, ni, oi); b = oren_nayar_A(x); c = oren_nayar_B(x); d = eon_A(x);'
        'e = eon_albedo_shape(no); f = eon_eval(color, x, no, ni, oi);',
        {'no': COSINE, 'ni': COSINE, 'oi': UNIT, 'x': UNIT, 'color': COLOR},
        {'a': 'float', 'b': 'float', 'c': 'float', 'd': 'float', 'e': 'float', 'f': 'vec3'},
        Tolerance(16, 'Vulkan lets compilers move constant factors', absolute=1e-6),
    ),
    Case(
        'model_half_vectors',
        'const vec2 disk = disk_from_square(u); r2 = disk_r2(disk); lobe = power_lobe(disk, n);'
        'h = half_vector_distribution(kind, disk, alpha); v = half_vector_cavity(kind, o, disk, side, alpha);'
        'slope = visible_slope_Beckmann(o.z, sqrt(1.0f - o.z * o.z), u.x); b = half_vector_Beckmann(o, alpha, u);'
        'i = hemisphere_mixture(0.3f, side, u);',
        {'u': ('vec2', lambda rng, n: rng.uniform(0.01, 0.99, (n, 2))), 'o': LOCAL, 'kind': KIND, 'alpha': ALPHA}
        | {'n': POSITIVE, 'side': UNIT},
        {'r2': 'float', 'lobe': 'vec3', 'h': 'vec3', 'v': 'vec3', 'slope': 'float', 'b': 'vec3', 'i': 'vec3'},
        SLOPES,
    ),
]

MODELS = [
    Case(
        'model_preparation',
        'model_clear(none); phong = select(model_is_phong(model.model), 1u, 0u); f0 = model_F0(material, model);'
        'albedo = model_prepare(material, model, n, n, o, m); mirror = select(model_is_mirror(m), 1u, 0u);'
        'smith = select(model_samples_smith(m), 1u, 0u); a = m; phong_albedo = model_prepare_phong(material, model, a);'
        'b = m; cook_albedo = model_prepare_cook_torrance(material, model, b);'
        'c = m; model_prepare_oren_nayar(model, o.z, c);',
        {'material': MATERIAL, 'model': MODEL, 'n': NORMAL, 'o': DIRECTION},
        {'none': 'ModelBsdf', 'phong': 'uint', 'f0': 'vec3', 'albedo': 'vec3', 'm': 'ModelBsdf', 'mirror': 'uint'}
        | {'smith': 'uint', 'a': 'ModelBsdf', 'b': 'ModelBsdf', 'c': 'ModelBsdf', 'phong_albedo': 'vec3'}
        | {'cook_albedo': 'vec3'},
        POWER,
    ),
    Case(
        'model_highlights',
        PREPARE + 'half_angle(n, o, wi, max(dot(n, wi), 0.0f), angles); f = model_fresnel(m, h.oh);'
        'd = model_distribution(m, h); lambda = model_n_lambda(m.distribution, h.ni, m.alpha);'
        'g = m.no > 0.0f ? model_masking(m, h) : 0.0f; s = model_eval_specular(m, h, pdf);'
        'const bool seen = h.ni > 0.0f && m.no > 0.0f && !model_is_mirror(m);'
        'power = vec3(0.0f); pdf_power = 0.0f;'
        'if (seen && model_is_phong(m.model)) power = model_eval_phong(m, h, pdf_power);'
        'facets = vec3(0.0f); pdf_facets = 0.0f;'
        'if (seen && m.model == MODEL_COOK_TORRANCE) facets = model_eval_cook_torrance(m, h, pdf_facets);'
        'term_d = 0.0f; term_g = 0.0f; term_f = vec3(0.0f);'
        'if (m.no > 0.0f) model_terms(m, h, term_d, term_g, term_f);',
        {'material': MATERIAL, 'model': MODEL, 'n': NORMAL, 'o': DIRECTION, 'wi': DIRECTION, 'h': HALF},
        {
            'albedo': 'vec3',
            'angles': 'HalfAngle',
            'f': 'vec3',
            'd': 'float',
            'power': 'vec3',
            'pdf_power': 'float',
            'facets': 'vec3',
            'pdf_facets': 'float',
            'lambda': 'float',
            'g': 'float',
            's': 'vec3',
        }
        | {'pdf': 'float', 'term_d': 'float', 'term_g': 'float', 'term_f': 'vec3'},
        POWER,
    ),
    Case(
        'model_evaluation',
        PREPARE + 'tone = toon_color(model.toon_lit, model.toon_shade, model.toon_steps, c);'
        'diffuse = model_eval_diffuse(m, n, o, wi, c, c);'
        'f = model_eval(m, n, n, max(dot(n, wi), 0.0f), o, wi, specular, pdf);'
        'pdf_diffuse = model_diffuse_pdf(m, dot(n, wi));',
        {'material': MATERIAL, 'model': MODEL, 'n': NORMAL, 'o': DIRECTION, 'wi': DIRECTION, 'c': COSINE},
        {'albedo': 'vec3', 'tone': 'vec3', 'diffuse': 'vec3', 'f': 'vec3', 'specular': 'vec3', 'pdf': 'float'}
        | {'pdf_diffuse': 'float'},
        POWER,
    ),
    Case(
        'model_sampling',
        PREPARE + 'bool glossy; wi = model_sample(m, n, n, o, u_lobe, u, glossy); lobe = select(glossy, 1u, 0u);'
        'local = vec3(0.0f); if (m.p_specular > 0.0f) local = model_sample_specular(m, up, u_lobe, u);'
        'half_vector = model_half_vector(m, up, disk_from_square(u), u_lobe, u);',
        {'material': MATERIAL, 'model': MODEL, 'n': NORMAL, 'o': DIRECTION, 'up': LOCAL, 'u_lobe': UNIT, 'u': SQUARE},
        {'albedo': 'vec3', 'wi': 'vec3', 'lobe': 'uint', 'local': 'vec3', 'half_vector': 'vec3'},
        SLOPES,
    ),
    Case(
        'model_bsdf',
        'Bsdf bsdf; bsdf_prepare(scene, material, n, n, o, bsdf);'
        'albedo = bsdf_prepare_model(scene, material, n, n, o, b);'
        'f = bsdf_eval_lobes(bsdf, o, wi, false, glossy, pdf); bsdf_sample(bsdf, o, u_lobe, u, drawn);'
        'bsdf_sample_model(b, o, u_lobe, u, again); weighed = again;'
        'bsdf_weigh_model(b, o, u_lobe < b.model.p_specular, weighed); bsdf_terms(bsdf, o, wi, d, g, term_f);',
        {'material': MATERIAL, 'n': NORMAL, 'o': DIRECTION, 'wi': DIRECTION, 'u_lobe': UNIT, 'u': SQUARE},
        {'albedo': 'vec3', 'b': 'Bsdf', 'f': 'vec3', 'glossy': 'vec3', 'pdf': 'float', 'drawn': 'BsdfSample'}
        | {'again': 'BsdfSample', 'weighed': 'BsdfSample', 'd': 'float', 'g': 'float', 'term_f': 'vec3'},
        SLOPES,
        scene=True,
    ),
]

CASES = [*NUMBERS, *MODELS]
