# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: lobes and the layers of Principled.

That their formulas are right is test_closures.py's.
"""

from __future__ import annotations

import numpy as np

from kernel_cases import COLOR, DIRECTION, LIBRARY, NORMAL, SQUARE, UNIT
from kernel_inputs import LIGHTS, choices, directions, integers, principled_inputs, records, surfaces, uniform
from kernel_parity import Case, Tolerance
from kernel_source import constants

LOCAL = ('vec3', directions(upper=True))
INPUTS = ('PrincipledInputs', principled_inputs)
PART = ('float', uniform(0.1, 0.9))
INDEX = ('float', uniform(1.1, 2.0))
CHANNEL = ('uint', integers(3))
# Sines, powers and roots are each library's own, and divisions by small cosines enlarge what they differ by.
CLOSE = Tolerance(8192, 'powers, exponentials and sines, whose difference small cosines enlarge', absolute=2e-3)


def lobes(*kinds: str) -> tuple:
    """Records of such lobes, of moderate roughness."""

    def draw(rng: np.random.Generator, n: int) -> np.ndarray:
        known = constants()
        values = records(
            'Lobe',
            weight=uniform_colors,
            n=directions(upper=True),
            mode=choices(*range(8)),
            t=directions(),
            alpha_x=uniform(0.3, 0.9),
            alpha_y=uniform(0.3, 0.9),
            f0=uniform_colors,
            f1=uniform_colors,
            eta=choices(0.6, 1.4, 1.8),
            tint=uniform_colors,
            single=uniform(0.5, 1.0),
            film=choices(0.0, 0.0, 400.0),
            film_eta=uniform(1.1, 2.0),
        )(rng, n)
        values['kind'] = rng.choice([known[f'LOBE_{kind}'] for kind in kinds], n)
        return values

    return ('Lobe', draw)


def uniform_colors(rng: np.random.Generator, n: int) -> np.ndarray:
    return rng.uniform(0.1, 0.9, (n, 3)).astype(np.float32)


FACETS = lobes('REFLECTION', 'GLASS', 'REFRACTION', 'THIN_TRANSMISSION')
ANY = lobes('DIFFUSE', 'TRANSLUCENT', 'REFLECTION', 'GLASS', 'ASHIKHMIN_SHIRLEY', 'SHEEN', 'TOON_DIFFUSE')
TABLE = 'FloatBuffer table = scene.albedo; '

FRESNEL = [
    Case(
        'film_terms',
        TABLE + 'const vec2 a = complex_multiply(vec2(x, y), vec2(y, -x)); product = a.x + a.y; vec2 phase;'
        'size = amplitude(vec2(x, y), vec2(y, x), phase); vec2 r; vec2 s; vec2 p;'
        'root = interface_reflection(x, 1.0f, eta, y, r, s, p); both = r.x + r.y;'
        'series = film_series(table, channel, x, y, 500.0f, vec2(1.0f, 0.0f)); edge = F_82(x, y, z);'
        'film = film_reflectance(table, channel, 400.0f, eta, 1.5f, 0.0f, -1.0f, x);'
        'const vec2 metal = conductor_of_colors(x, y); n = metal.x;'
        'const vec2 means = table_film(table, channel, 900.0f * x); mean = means.x;'
        'float all; glass = table_glass(table, x, y, eta, all);',
        {'x': PART, 'y': PART, 'z': PART, 'eta': INDEX, 'channel': CHANNEL},
        dict.fromkeys(
            ('product', 'size', 'root', 'both', 'series', 'edge', 'film', 'n', 'mean', 'glass'),
            'float',
        ),
        CLOSE,
        scene=True,
    ),
    Case(
        'lobe_fresnel',
        TABLE + 'lobe_fresnel(table, l, c, r, t); one = lobe_film_channel(table, l, 1u, l.f0.y, l.f1.y, c);'
        'p = reflection_probability(r, t);',
        {'l': FACETS, 'c': PART},
        {'r': 'vec3', 't': 'vec3', 'one': 'float', 'p': 'float'},
        CLOSE,
        scene=True,
    ),
]

FACET = [
    Case(
        'facet_terms',
        TABLE + 'mirror = select(microfacet_is_mirror(l), 1u, 0u) + select(microfacet_is_straight(l), 2u, 0u);'
        'rough = microfacet_roughness(l); microfacet_frame(l, t, b); d = microfacet_distribution(l, o);'
        'lambda = microfacet_n_lambda(l, o, true); float visible; masked = microfacet_masking(l, o, i, visible);'
        'h = microfacet_half_vector(l, o, u); f = microfacet_eval_local(table, l, o, i, pdf);'
        'through = refracted(o, vec3(0.0f, 0.0f, 1.0f), o.z, 1.5f); Lobe set = l;'
        'microfacet_set_alpha(2.0f, 0.5f, set);'
        'alpha = set.alpha_x; Multiscatter m; microfacet_multiscatter(table, l, o, true, m); single = m.single;'
        'microfacet_preserve(table, o, true, l.f0, set); weight = set.weight; albedo = microfacet_albedo(table, l, o);'
        'whole = microfacet_eval(table, l, o, i, all);',
        {'l': FACETS, 'o': LOCAL, 'i': LOCAL, 'u': SQUARE},
        {'mirror': 'uint', 'rough': 'float', 't': 'vec3', 'b': 'vec3', 'd': 'float', 'lambda': 'float'}
        | {'masked': 'float', 'h': 'vec3', 'f': 'vec3', 'pdf': 'float', 'through': 'vec3', 'alpha': 'float'}
        | {'single': 'float', 'weight': 'vec3', 'albedo': 'vec3', 'whole': 'vec3', 'all': 'float'},
        CLOSE,
        scene=True,
    ),
    Case(
        'shirley_terms',
        'Lobe set = l; ashikhmin_shirley_limit(set); mirror = select(ashikhmin_shirley_is_mirror(set), 1u, 0u);'
        'e = phong_exponent(l.alpha_x); power_ = ashikhmin_shirley_power(l, o);'
        'f = ashikhmin_shirley_eval(l, o, i, pdf);'
        'BsdfSample s; ashikhmin_shirley_sample(l, o, u, s); wi = s.wi;',
        {'l': lobes('ASHIKHMIN_SHIRLEY'), 'o': LOCAL, 'i': LOCAL, 'u': SQUARE},
        {'mirror': 'uint', 'e': 'float', 'power_': 'float', 'f': 'vec3', 'pdf': 'float', 'wi': 'vec3'},
        CLOSE,
    ),
]

KINDS = [
    Case(
        'diffuse_lobes',
        'g = oren_nayar_G(x); Lobe l; diffuse_prepare(LOBE_DIFFUSE, color, color, x, n, o, l); many = l.f0;'
        'value = diffuse_value(l, o, i); f = diffuse_eval(l, o, i, pdf); BsdfSample s; diffuse_sample(l, o, u, s);'
        'wi = s.wi; mean = mean_component(color); kind = lobe_transmits(l) ? 1u : 0u; sample_clear(s); none = s.pdf;',
        {'x': PART, 'color': COLOR, 'n': NORMAL, 'o': LOCAL, 'i': LOCAL, 'u': SQUARE},
        {'g': 'float', 'many': 'vec3', 'value': 'vec3', 'f': 'vec3', 'pdf': 'float', 'wi': 'vec3', 'mean': 'float'}
        | {'kind': 'uint', 'none': 'float'},
        CLOSE,
    ),
    Case(
        'sheen_lobes',
        TABLE + 'albedo = sheen_number(table, 0u, 33u, p, q0); Lobe l;'
        'sheen_prepare(table, color, color, y, n, o, l); sheen_frame(l, t, b); density = sheen_density(l, i);'
        'f = sheen_eval(l, i, pdf); BsdfSample s; sheen_sample(l, u, s); wi = s.wi; Lobe v;'
        'velvet_prepare(color, color, y, vec3(0.0f, 0.0f, 1.0f), v); g = velvet_eval(v, o, i, q);'
        'velvet_sample(v, o, u, s); wj = s.wi;',
        {'p': PART, 'q0': PART, 'y': PART, 'color': COLOR, 'n': NORMAL, 'o': LOCAL, 'i': LOCAL, 'u': SQUARE},
        {
            'albedo': 'float',
            't': 'vec3',
            'b': 'vec3',
            'density': 'float',
            'f': 'vec3',
            'pdf': 'float',
        }
        | {'wi': 'vec3', 'g': 'vec3', 'q': 'float', 'wj': 'vec3'},
        CLOSE,
        scene=True,
    ),
    Case(
        'toon_lobes',
        'Lobe l; toon_prepare(false, color, color, x, y, vec3(0.0f, 0.0f, 1.0f), l); angle = toon_angle(l);'
        'cap = toon_cap(l); part = toon_intensity(l, x); axis = toon_axis(l, o); BsdfSample s; toon_sample(l, o, u, s);'
        'wi = s.wi; float pdf; f = toon_eval(l, o, vec3(0.0f, 0.0f, 1.0f), pdf);',
        {'x': PART, 'y': PART, 'color': COLOR, 'o': LOCAL, 'u': SQUARE},
        {'angle': 'float', 'cap': 'float', 'part': 'float', 'axis': 'vec3', 'wi': 'vec3', 'f': 'vec3'},
        CLOSE,
    ),
    Case(
        'glossy_lobes',
        TABLE + 'turned = rotate_about(i, n, x); Lobe l; lobe_clear(LOBE_REFLECTION, color, n, l);'
        'anisotropy_set(x, y, x, n, i, l); wide = l.alpha_x; glossy_anisotropy_set(x, y, x, i, l); narrow = l.alpha_x;'
        'film_set(x, 1.5f, l); metal_colors_set(color, color, l); edge = l.f1;'
        'average = conductor_average(color, color);'
        'glossy_prepare(table, CLOSURE_MULTI_GGX, color, color, x, y, x, n, n, i, n, l); a = l.weight;'
        'metallic_prepare(table, CLOSURE_GGX, color, color, color, x, y, x, n, n, i, n, 0.0f, 1.3f, l); b = l.f0;'
        'conductor_prepare(table, CLOSURE_GGX, color, color, color, x, y, x, n, n, i, n, 0.0f, 1.3f, l); c = l.f1;',
        {'x': PART, 'y': PART, 'color': COLOR, 'n': NORMAL, 'i': DIRECTION},
        {'turned': 'vec3', 'wide': 'float', 'narrow': 'float', 'edge': 'vec3', 'average': 'vec3', 'a': 'vec3'}
        | {'b': 'vec3', 'c': 'vec3'},
        CLOSE,
        scene=True,
    ),
    Case(
        'glass_lobes',
        TABLE + 'eta = relative_eta(ior, true); average = dielectric_average(color, ior); Lobe l;'
        'lobe_clear(LOBE_GLASS, color, n, l);'
        'glass_set(table, CLOSURE_MULTI_GGX, x, ior, false, color, color, color, 0.0f, 1.3f, n, l); a = l.weight;'
        'glass_prepare(table, CLOSURE_GGX, color, color, x, ior, n, n, n, true, 0.0f, 1.3f, l); b = l.eta;'
        'refraction_prepare(CLOSURE_BECKMANN, color, color, x, ior, n, n, n, false, l); c = l.alpha_x;'
        'lobe_clear(LOBE_REFLECTION, color, n, l); dielectric_layer_set(table, color, ior, true, n, l); d = l.weight;'
        'raised = power(color, x); alpha = thin_wall_alpha(x, ior);'
        'thin_wall_fresnel(table, color, color, ior, 0.0f, 1.3f, x, r, t);'
        'thin_wall_reflection_set(table, x, color, n, l); e = l.weight;'
        'thin_wall_transmission_set(table, x, ior, n, l);'
        'f = l.alpha_x;',
        {'x': PART, 'color': COLOR, 'n': NORMAL, 'ior': INDEX},
        {'eta': 'float', 'average': 'vec3', 'a': 'vec3', 'b': 'float', 'c': 'float', 'd': 'vec3', 'raised': 'vec3'}
        | {'alpha': 'float', 'r': 'vec3', 't': 'vec3', 'e': 'vec3', 'f': 'float'},
        CLOSE,
        scene=True,
    ),
    Case(
        'lobes',
        TABLE + 'f = lobe_eval(table, l, o, i, pdf); albedo = lobe_albedo(table, l, o); BsdfSample s;'
        'lobe_sample(table, l, o, u.x, u, s); wi = s.wi; microfacet_sample(table, l, o, u.y, u, s); wj = s.wi;'
        'sample_clear(s); microfacet_sample_local(table, l, o, u.y, u, s); wk = s.wi;',
        {'l': lobes('DIFFUSE', 'REFLECTION', 'SHEEN'), 'o': LOCAL, 'i': LOCAL, 'u': SQUARE},
        {'f': 'vec3', 'pdf': 'float', 'albedo': 'vec3', 'wi': 'vec3', 'wj': 'vec3', 'wk': 'vec3'},
        CLOSE,
        scene=True,
    ),
]

PRINCIPLED = [
    Case(
        'principled_layers',
        TABLE + 'LobePick p; pick_begin(u, p); taken = select(pick_next(0.5f, PICK_LOBE, p), 1u, 0u); rest = p.u;'
        'Lobe l; Lobe passed; weight = vec3(1.0f); principled_sheen(table, x, n, weight, l); Lobe kept = l;'
        'pick_lobe(table, l, n, p, kept); principled_coat(table, x, n, n, weight, l); a = l.weight;'
        'principled_metal_layer(table, x, n, n, weight, l); b = l.weight;'
        'principled_transmission(table, x, n, n, weight, l, passed); c = l.weight;'
        'principled_dielectric_layer(table, x, n, n, weight, l); d = l.weight;'
        'principled_base(x, n, weight, l, passed); e = l.weight + passed.weight; below = layer_below(a, weight);'
        'lacks = select(principled_lacks(x, CAUSTICS_REFLECTIVE), 1u, 0u); blurred = kept; lobe_blur(0.95f, blurred);'
        'plain = select(principled_is_plain(x), 1u, 0u); Material m; share = principled_material(x, m);'
        'float f0; eta = dielectric_eta(x.ior, x.specular_level, f0);',
        {'x': INPUTS, 'n': NORMAL, 'u': UNIT},
        {'taken': 'uint', 'rest': 'float', 'weight': 'vec3', 'a': 'vec3', 'b': 'vec3', 'c': 'vec3', 'd': 'vec3'}
        | {'e': 'vec3', 'below': 'vec3', 'plain': 'uint', 'share': 'float', 'eta': 'float'}
        | {'lacks': 'uint', 'blurred': 'Lobe'},
        CLOSE,
        scene=True,
    ),
    Case(
        'principled_surface',
        'x.n = n; x.coat_n = n; Bsdf bsdf; Lobe l; pick = principled_pick(scene, x, n, n, 0.0f, bsdf, l, scale);'
        'bsdf_prepare_nothing(n, n, bsdf); none = bsdf.p_glossy;'
        'glow = principled_emission(scene.albedo, x, n, n); albedo = principled_albedo(scene.albedo, x, n, n);',
        {'x': INPUTS, 'n': NORMAL},
        {'pick': 'uint', 'scale': 'vec3', 'none': 'float', 'glow': 'vec3', 'albedo': 'vec3'},
        CLOSE,
        scene=True,
    ),
    Case(
        'scattering',
        'Bsdf bsdf; bsdf_prepare_nothing(s.n, o, bsdf); has = select(has_lobe(l), 1u, 0u);'
        'through = select(scatters_through(l), 1u, 0u); diffuse = select(lobe_is_diffuse(l), 1u, 0u);'
        'kind = lobe_ray_kind(l, i); shadow = lobe_bump_shadowing(bsdf, l, i, u.x < 0.5f);'
        'seen = visible_scattering(scene, bsdf, l, o, i, VISIBLE_ALL, pdf);'
        'BsdfSample b; scattering_sample(scene, bsdf, l, o, 0.0f, u, b); wi = b.wi;'
        'const Light light = LOAD(scene.lights, lamp); LightSample sent; light_sample(light, s.p, s.n, u, sent);'
        'gain = lobe_light_contribution(scene, light, sent, bsdf, l, o, vec3(1.0f), 1.0f);',
        {'l': ANY, 's': ('Surface', surfaces), 'o': LOCAL, 'i': LOCAL, 'u': SQUARE, 'lamp': ('uint', integers(LIGHTS))},
        {'has': 'uint', 'through': 'uint', 'diffuse': 'uint', 'kind': 'uint', 'shadow': 'float', 'seen': 'vec3'}
        | {'pdf': 'float', 'wi': 'vec3', 'gain': 'vec3'},
        CLOSE,
        scene=True,
    ),
    Case(
        'beckmann_slopes',
        'a = N_LambdaBeckmannSlope(x, y); b = N_LambdaBeckmannSlopeExact(x, y); c = beckmann_slope(x, y);',
        {'x': PART, 'y': PART},
        {'a': 'float', 'b': 'float', 'c': 'float'},
        LIBRARY,
    ),
]

CASES = [*FRESNEL, *FACET, *KINDS, *PRINCIPLED]
