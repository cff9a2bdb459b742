# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: materials and the stages of a path.

What needs no material stands in kernel_cases.py.
"""

from __future__ import annotations

from kernel_cases import COLOR, DIRECTION, DISTANCE, NORMAL, POINT, POSITIVE, ROUNDING, SQUARE, SURFACE, UINT, UNIT
from kernel_inputs import (
    LIGHTS,
    choices,
    directions,
    integers,
    magnitudes,
    materials,
    paths,
    records,
    uniform,
)
from kernel_parity import Case

COSINE = ('float', uniform(1e-3, 1.0))
ALPHA2 = ('float', magnitudes(1e-9, 1.0))
ETA = ('float', choices(0.5, 0.8, 1.0, 1.33, 1.5, 2.4))
MATERIAL = ('Material', materials)
PATH = ('PathState', paths)
WO = ('vec3', directions())
LAMP = ('uint', integers(LIGHTS))
INTEGRATOR = (
    'IntegratorData',
    records(
        'IntegratorData',
        max_bounces=integers(5),
        diffuse_bounces=integers(5),
        glossy_bounces=integers(5),
        roulette_start=integers(4),
        transparent_bounces=choices(0, 1, 3, 256),
        transmission_bounces=integers(5),
        clamp_direct=choices(0.5, 1e30),
        clamp_indirect=choices(0.1, 3.0),
        filter_glossy=choices(0.0, 1.0, 4.0),
        shadow_roulette=choices(0.0, 100.0),
    ),
)
# Without the feature nothing fills in a model: two outputs would differ by what was in memory before.
NO_MODEL = 'if (!FEATURE(FEATURE_MODELS)) {{ model_clear({0}.model); }} '
# The viewer is on the side of the triangle that its normals are on, as after surface_from_hit.
FACING = (
    'vec3 o = dot(s.ng, wo) < 0.0f ? -wo : wo; Bsdf bsdf; bsdf_prepare(scene, material, s.n, s.ng, o, bsdf);'
    'Lobe lobe; lobe_clear(LOBE_NONE, vec3(0.0f), s.n, lobe);'
)

MICROFACET = [
    Case(
        'microfacet_terms',
        'd = D_GGX(xy2, h2, alpha2); so = S_SmithGGX(no, alpha2); si = S_SmithGGX(ni, alpha2);'
        'v = V_SmithGGXCorrelated(no, so, ni, si); visible = V_SmithGGXVisible(no, so);',
        {'xy2': UNIT, 'h2': ('float', uniform(1.0, 4.0)), 'alpha2': ALPHA2, 'no': COSINE, 'ni': COSINE},
        {'d': 'float', 'so': 'float', 'si': 'float', 'v': 'float', 'visible': 'float'},
    ),
    Case(
        'fresnel',
        'a = F0_from_ior(eta); b = ior_from_F0(c); d = F_Dielectric(c, c * c, eta); e = F_DielectricAverage(eta);'
        'w = F_SchlickWeight(c);',
        {'c': COSINE, 'eta': ETA},
        {'a': 'float', 'b': 'float', 'd': 'float', 'e': 'float', 'w': 'float'},
    ),
    Case(
        'fresnel_metal',
        'edge = F_Schlick82Edge(f0, tint); f = F_Schlick82(f0, range, edge, c); mean = F_Schlick82Average(f0, edge);',
        {'f0': COLOR, 'range': COLOR, 'tint': COLOR, 'c': COSINE},
        {'edge': 'vec3', 'f': 'vec3', 'mean': 'vec3'},
        tolerances={'mean': ROUNDING},
    ),
    Case(
        'visible_normals',
        'h = half_vector_GGX(o, alpha, S_SmithGGX(o.z, alpha * alpha), disk_from_square(u));',
        {'o': ('vec3', directions(upper=True)), 'alpha': ('float', magnitudes(1e-4, 1.0)), 'u': SQUARE},
        {'h': 'vec3'},
        ROUNDING,
    ),
    Case(
        'albedo_tables',
        'axis = albedo_ior_axis(eta); cell = albedo_cell(mu, 16u, t); row = albedo_row(scene.albedo, cell, t);'
        'slice = albedo_fresnel_slice(scene.albedo, cell, t, t);'
        'e = albedo_reflectance(scene.albedo, roughness, mu, mean);'
        'metal = albedo_schlick(scene.albedo, roughness, mu);'
        'dielectric = albedo_dielectric(scene.albedo, roughness, mu, eta);',
        {'roughness': UNIT, 'mu': UNIT, 'eta': ETA},
        {'axis': 'float', 'cell': 'uint', 't': 'float', 'row': 'float', 'slice': 'float', 'e': 'float', 'mean': 'float'}
        | {'metal': 'float', 'dielectric': 'float'},
        scene=True,
    ),
]

MATERIALS = [
    Case(
        'principled',
        'eta = principled_eta(material, f0); metal = principled_metal(material, rest);'
        'flags = principled_flags(material);'
        'Multiscatter m; m.single = 0.5f + 0.5f * u.x; m.missing = 1.0f / m.single - 1.0f; m.mean = 0.5f + 0.5f * u.y;'
        'scale = multiscatter_scale(m, material.base_color);',
        {'material': MATERIAL, 'u': SQUARE},
        {'eta': 'float', 'f0': 'float', 'metal': 'float', 'rest': 'float', 'flags': 'uint', 'scale': 'vec3'},
        tolerances={'scale': ROUNDING},
    ),
    Case(
        'bsdf_preparation',
        'albedo = bsdf_prepare_albedo(scene, material, n, ng, wo, full);'
        'bsdf_prepare(scene, material, n, ng, wo, bsdf);'
        + NO_MODEL.format('full')
        + NO_MODEL.format('bsdf')
        + 'cleared = full; bsdf_clear_glossy(cleared); glossy = full; left = 0.5f;'
        'Multiscatter m; m.single = 0.5f; m.missing = 1.0f; m.mean = 0.6f; part = full;'
        'metal = bsdf_prepare_metal(scene, material, m, 0.3f, part);'
        'coating = bsdf_prepare_coating(scene, material, m, 0.4f, 1.4f, 0.04f, part);'
        'glossy_albedo = bsdf_prepare_glossy(scene, material, 0.25f, left, glossy);',
        {'material': MATERIAL, 'n': NORMAL, 'ng': NORMAL, 'wo': WO},
        {'albedo': 'vec3', 'full': 'Bsdf', 'bsdf': 'Bsdf', 'cleared': 'Bsdf', 'glossy': 'Bsdf', 'glossy_albedo': 'vec3'}
        | {'left': 'float', 'part': 'Bsdf', 'metal': 'vec3', 'coating': 'vec3'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'bent_normals',
        'bent = normal_for_reflection(n, dot(ng, wo) < 0.0f ? -ng : ng, wo); Bsdf bsdf;'
        'bsdf_prepare(scene, material, n, ng, wo, bsdf); cosine = glossy_cosine(bsdf, dot(bsdf.n, wi), wi, false);'
        'bsdf.n_smooth = ng; smooth_n = bsdf_smooth_normal(bsdf); drawn = glossy_cosine(bsdf, 0.0f, wi, true);'
        'hides = select(bsdf_hides(bsdf, bsdf.n_glossy, wi), 1u, 0u);',
        {'material': MATERIAL, 'n': NORMAL, 'ng': NORMAL, 'wo': WO, 'wi': DIRECTION},
        {'bent': 'vec3', 'cosine': 'float', 'smooth_n': 'vec3', 'drawn': 'float', 'hides': 'uint'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'bsdf_evaluation',
        'Bsdf bsdf; bsdf_prepare(scene, material, n, ng, wo, bsdf); fresnel = bsdf_fresnel(bsdf, c, c * c);'
        'pdf_glossy = 0.25f; alone = bsdf_eval_glossy(bsdf, c, 1.5f, 0.1f, c * c, pdf_glossy);'
        'diffuse = bsdf_eval_lobes(bsdf, wo, wi, false, glossy, pdf_lobes); f = bsdf_eval(bsdf, wo, wi, pdf);'
        'pdf_diffuse = bsdf_diffuse_pdf(bsdf, wi);',
        {'material': MATERIAL, 'n': NORMAL, 'ng': NORMAL, 'wo': WO, 'wi': DIRECTION, 'c': COSINE},
        {
            'alone': 'vec3',
            'pdf_glossy': 'float',
            'fresnel': 'vec3',
            'diffuse': 'vec3',
            'glossy': 'vec3',
            'pdf_lobes': 'float',
            'f': 'vec3',
            'pdf': 'float',
            'pdf_diffuse': 'float',
        },
        ROUNDING,
        scene=True,
    ),
    Case(
        'bsdf_sampling',
        'Bsdf bsdf; bsdf_prepare(scene, material, n, ng, wo, bsdf);'
        'half_vector = bsdf_sample_half_vector(bsdf, wo, u); bsdf_sample(bsdf, wo, u_lobe, u, drawn);',
        {'material': MATERIAL, 'n': NORMAL, 'ng': NORMAL, 'wo': WO, 'u_lobe': UNIT, 'u': SQUARE},
        {'drawn': 'BsdfSample', 'half_vector': 'vec3'},
        ROUNDING,
        scene=True,
    ),
]

STAGES = [
    Case(
        'path_starts',
        'pair = vertex_pair(bounce, number); path_begin(bits, path); weight = found_weight(state.pdf, pdf);'
        'last = select(path_is_last(integrator, state), 1u, 0u); most = path_crossings(integrator);'
        'ended = select(path_crossed_too_many(integrator, bounce), 1u, 0u);'
        'kept = shadow_kept(integrator, bounce, 0.5f);',
        {'bounce': ('uint', integers(100)), 'number': ('uint', integers(256)), 'bits': UINT, 'state': PATH}
        | {'pdf': ('float', magnitudes(1e-3, 1e3)), 'integrator': INTEGRATOR},
        {'pair': 'uint', 'path': 'PathState', 'weight': 'float', 'last': 'uint', 'most': 'uint', 'ended': 'uint'}
        | {'kept': 'float'},
    ),
    Case(
        'path_finds',
        'light = path_meet_light(scene, lamp, path, p, d, t_max, group); '
        'sky = path_escape(scene, path, d, world_radiance(scene, path_background(path, d)));'
        'glow = path_emission(scene, path, s, material, d, t_max); at = path_point(scene, path, s, d, t_max);'
        'counted = background_point(d); path_counts(path, counted);'
        'sees = select(path_sees_world(scene, path), 1u, 0u);'
        'through = found_throughput(scene, path, mask, found_pdf);'
        'dark = select(material_is_dark(material, s.side), 1u, 0u);',
        {'lamp': LAMP, 'path': PATH, 'p': POINT, 'd': DIRECTION, 't_max': ('float', magnitudes(0.1, 100.0))}
        | {'s': SURFACE, 'material': MATERIAL, 'mask': ('uint', integers(64))},
        {
            'light': 'vec3',
            'group': 'int',
            'sky': 'vec3',
            'at': 'ShaderPoint',
            'counted': 'ShaderPoint',
            'glow': 'vec3',
            'through': 'vec3',
        }
        | {'found_pdf': 'float', 'dark': 'uint', 'sees': 'uint'},
        tolerances={
            'sky': ROUNDING,
            'light': ROUNDING,
        },  # its weight is by world_pdf, whose angles have this bound in world_table as well
        scene=True,
    ),
    Case(
        'world_shadow',
        'share = world_share(f, a, b); sent = select(world_shadow_ray(scene, s, wi, f, ray), 1u, 0u);',
        {'f': COLOR, 'a': UNIT, 'b': ('float', choices(0.0, 0.3, 20.0)), 's': SURFACE, 'wi': DIRECTION},
        {'share': 'vec3', 'sent': 'uint', 'ray': 'ShadowRay'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'shadow_origins',
        'amount = terminator_amount(cutoff, a, b); origin = shadow_ray_origin(scene, s, wi);'
        'start = surface_start(scene, s, wi); left = surface_left(scene, s, start, wi); begin = ray_begin(left, a);'
        'at_point = select(starts_at_point(scene, s.instance), 1u, 0u);',
        {'cutoff': ('float', choices(0.05, 0.1, 0.5)), 'a': UNIT, 'b': UNIT, 's': SURFACE, 'wi': DIRECTION},
        {'amount': 'float', 'origin': 'vec3', 'start': 'vec3', 'left': 'uvec2', 'begin': 'float', 'at_point': 'uint'},
        scene=True,
    ),
    Case(
        'light_stage',
        FACING + 'seen = visible_bsdf(bsdf, o, wi, mask, pdf);'
        'const Light light = LOAD(scene.lights, lamp); LightSample l; light_sample(light, s.p, s.n, u, l);'
        'gain = light_contribution(light, l, bsdf, o, path.throughput, 2.0f);'
        'casts = select(light_shadow_ray(scene, light, s, path.bounce, l.wi, l.distance, gain, shadow), 1u, 0u);'
        'lit = select(path_sample_light(scene, lamp, path, s, bsdf, lobe, o, u, 2.0f, ray), 1u, 0u);'
        'const LightWeights root = path_light_weights(scene, s, lobe); receives = light_receiver(scene, s, lobe);'
        'vec2 left = u; pick = path_pick_light(scene, s, lobe, root, 1u, 3u, fresh, left, scale);'
        'const Surface start = smooth_surface(s, bsdf); smooth_n = start.n;',
        {'material': MATERIAL, 's': SURFACE, 'wo': WO, 'wi': DIRECTION, 'mask': ('uint', integers(64)), 'lamp': LAMP}
        | {'path': PATH, 'u': SQUARE, 'fresh': UNIT},
        {'seen': 'vec3', 'pdf': 'float', 'lit': 'uint', 'ray': 'ShadowRay', 'receives': 'LightReceiver', 'pick': 'uint'}
        | {'scale': 'float', 'gain': 'vec3', 'casts': 'uint', 'shadow': 'ShadowRay', 'smooth_n': 'vec3'},
        ROUNDING,
        dict.fromkeys(('ray.t_max', 'shadow.t_max'), DISTANCE),
        scene=True,
    ),
    Case(
        'emitter_stage',
        FACING + 'lit = select(path_sample_emitter(scene, index, path, s, bsdf, lobe, o, u, scale, ray), 1u, 0u);'
        'const uint light = LIGHT_CHILD_LEAF | select(lamp != 0u, LIGHT_CHILD_LAMPS, 0u) | index;'
        'sent = select(path_sample_picked(scene, light, path, s, bsdf, lobe, o, u, scale, picked), 1u, 0u);',
        {'material': MATERIAL, 's': SURFACE, 'wo': WO, 'path': PATH, 'scale': POSITIVE, 'u': SQUARE}
        | {'index': ('uint', integers(LIGHTS)), 'lamp': ('uint', integers(2))},
        {'lit': 'uint', 'ray': 'ShadowRay', 'sent': 'uint', 'picked': 'ShadowRay'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'bounce_stage',
        FACING + 'BsdfSample b; bsdf_sample(bsdf, o, choice.x, u, b); onward = state;'
        'advanced = select(path_advance(scene, integrator, onward, s, b, choice.y, start), 1u, 0u);'
        'apart = state; path_note_kind(bsdf, lobe, o, wi, apart); left = state;'
        'path_leave(scene, path_spread(scene, left, o), left, s);'
        'through = state;'
        'passes = select(path_pass(scene, through, s, o, beyond), 1u, 0u);',
        {'integrator': INTEGRATOR, 'state': PATH, 's': SURFACE, 'material': MATERIAL, 'wo': WO, 'u': SQUARE}
        | {'choice': SQUARE, 'wi': DIRECTION},
        {
            'apart': 'PathState',
            'advanced': 'uint',
            'onward': 'PathState',
            'start': 'vec3',
            'left': 'PathState',
            'through': 'PathState',
        }
        | {'passes': 'uint', 'beyond': 'vec3'},
        ROUNDING,
        scene=True,
    ),
]

# What a file asks for against fireflies, and what a denoiser is shown.
FINISH = [
    Case(
        'fireflies',
        FACING + 'kept = clamped_light(light, light_limit(integrator, path.bounce));'
        'found = clamped_light(light, found_limit(integrator, path));'
        'alpha = glossy_blur(integrator.filter_glossy, path.min_pdf);'
        'blurred = bsdf; bsdf_blur(0.3f, blurred); filtered = bsdf;'
        'path_filter_glossy(integrator, path, filtered, lobe);'
        + NO_MODEL.format('blurred')
        + NO_MODEL.format('filtered')
        + 'BsdfSample b; b.wi = wo; b.weight = light; b.pdf = 1.0f; b.lobe = path.vertex % 16u;'
        'rough = sampled_alpha(bsdf, lobe, b); PathState wide = path; path_widen(integrator, rough, wide);'
        'spread = wide.spread;'
        'left_out = caustics_left_out(scene, path.ray_kind); bare = material;'
        'material_leave_out_caustics(scene, path.ray_kind, bare);',
        {'integrator': INTEGRATOR, 'path': PATH, 's': SURFACE, 'material': MATERIAL, 'wo': WO, 'light': COLOR},
        {'kept': 'vec3', 'found': 'vec3', 'alpha': 'float', 'blurred': 'Bsdf', 'filtered': 'Bsdf', 'left_out': 'uint'}
        | {'bare': 'Material', 'rough': 'float', 'spread': 'float'},
        ROUNDING,
        scene=True,
    ),
    Case(
        'features',
        FACING + 'Features f; shown = select(path_shows_features(path), 1u, 0u);'
        'counts = select(path_features(scene, path, bsdf, lobe, o, f), 1u, 0u); albedo = f.albedo; normal = f.normal;'
        'glow = light_features(light * 3.0f);',
        {'path': PATH, 's': SURFACE, 'material': MATERIAL, 'wo': WO, 'light': COLOR},
        {'shown': 'uint', 'counts': 'uint', 'albedo': 'vec3', 'normal': 'vec3', 'glow': 'vec3'},
        ROUNDING,
        scene=True,
    ),
]

CASES = [*MICROFACET, *MATERIALS, *STAGES, *FINISH]
