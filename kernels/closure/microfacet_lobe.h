// SPDX-License-Identifier: GPL-3.0-or-later
// Lobes of microfacets, GGX or Beckmann, isotropic or not: reflection, glass, refraction, and the light through a thin
// wall. Evaluates and samples all of them; how each is prepared stands in glossy.h, glass.h and thin_wall.h.
#ifndef COTORRA_MICROFACET_LOBE_H
#define COTORRA_MICROFACET_LOBE_H

#include "../model_half_vectors.h"
#include "fresnel.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Below this difference from 1 an index of refraction bends nothing (Cycles).
const float STRAIGHT_ETA = 1e-4f;

FN bool microfacet_is_mirror(IN(Lobe) l) { return l.alpha_x * l.alpha_y <= MIRROR_ALPHA2; }
FN bool microfacet_is_straight(IN(Lobe) l) { return abs(l.eta - 1.0f) < STRAIGHT_ETA; }

// Sets both alphas, between a mirror and the roughest surface.
FN void microfacet_set_alpha(float alpha_x, float alpha_y, INOUT(Lobe) l) {
  l.alpha_x = clamp(alpha_x, MIRROR_ALPHA, 1.0f);
  l.alpha_y = clamp(alpha_y, MIRROR_ALPHA, 1.0f);
}

// Roughness of the isotropic surface that tables take this one for.
FN float microfacet_roughness(IN(Lobe) l) {
  const float roughness = sqrt(sqrt(l.alpha_x * l.alpha_y));
  return microfacet_is_mirror(l) ? 0.0f : roughness;
}

// ---- Terms, in the frame whose z is the normal and whose x is the tangent

FN void microfacet_frame(IN(Lobe) l, OUT(vec3) t, OUT(vec3) b) {
  orthonormal_basis(l.n, t, b);
  const vec3 across = cross(l.n, l.t);
  const float d2 = dot(across, across);
  if (l.alpha_x == l.alpha_y || !(d2 > 1e-20f)) return;
  b = across * (1.0f / sqrt(d2));
  t = cross(b, l.n);
}

// D for a half vector of any length, anisotropic (Heitz 2014, eq. 85; Beckmann likewise).
FN float microfacet_distribution(IN(Lobe) l, vec3 h) {
  const float scale = INV_PI / (l.alpha_x * l.alpha_y);
  const float slope2 = sqr(h.x / l.alpha_x) + sqr(h.y / l.alpha_y);
  const float h2 = dot(h, h);
  const float z2 = h.z * h.z;
  if ((l.mode & LOBE_BECKMANN) == 0u) return scale * sqr(h2 / max(slope2 + z2, 1e-30f));
  const float cos2 = max(z2, 1e-12f * h2);
  return scale * exp(-slope2 / cos2) * sqr(h2 / cos2);
}

// nx Lambda(x), as in model_microfacet.h; `exact`: as half vectors are sampled.
FN float microfacet_n_lambda(IN(Lobe) l, vec3 x, bool exact) {
  const float slope2 = sqr(l.alpha_x * x.x) + sqr(l.alpha_y * x.y);
  const float nx = abs(x.z);
  if ((l.mode & LOBE_BECKMANN) == 0u) return 0.5f * slope2 / max(sqrt(slope2 + nx * nx) + nx, 1e-20f);
  const float slope = max(sqrt(slope2), 1e-20f);
  if (exact) return N_LambdaBeckmannSlopeExact(nx, slope);
  return N_LambdaBeckmannSlope(nx, slope);
}

// A half vector that the viewer sees, unit length: that of a surface with alpha 1 in stretched space (Heitz 2018).
FN vec3 microfacet_half_vector(IN(Lobe) l, vec3 o, vec2 u) {
  if (microfacet_is_mirror(l)) return vec3(0.0f, 0.0f, 1.0f);
  const vec3 v = normalize(vec3(l.alpha_x * o.x, l.alpha_y * o.y, o.z));
  vec3 h;
  if ((l.mode & LOBE_BECKMANN) != 0u) {
    h = half_vector_Beckmann(v, 1.0f, u);
  } else {
    h = half_vector_GGX(v, 1.0f, 1.0f, disk_from_square(u));
  }
  float len;
  return safe_normalize(vec3(l.alpha_x * h.x, l.alpha_y * h.y, h.z), len);
}

// G2 / (4 no) over the density's G1 / (4 no), which is `visible`; 0 where o or i lies on no side at all.
FN float microfacet_masking(IN(Lobe) l, vec3 o, vec3 i, OUT(float) visible) {
  visible = 0.25f / max(o.z + microfacet_n_lambda(l, o, true), 1e-20f);
  return V_SmithCorrelated(o.z, microfacet_n_lambda(l, o, false), abs(i.z), microfacet_n_lambda(l, i, false));
}

// ---- Evaluation

// Share of reflection among samples at a facet.
FN float reflection_probability(vec3 reflected, vec3 transmitted) {
  const float r = mean_component(reflected);
  const float sum = r + mean_component(transmitted);
  return sum > 0.0f ? r / sum : 0.0f;
}

// f cos for local directions, o above the surface. Light from the same side, or through the surface.
FN vec3 microfacet_eval_local(FloatBuffer table, IN(Lobe) l, vec3 o, vec3 i, OUT(float) pdf) {
  pdf = 0.0f;
  const bool through = i.z < 0.0f;
  if (!(o.z > 0.0f) || i.z == 0.0f || microfacet_is_mirror(l)) return vec3(0.0f);
  if (through && l.kind == LOBE_REFLECTION) return vec3(0.0f);
  // 1. The facet that leads from one to the other: mirrors, or refracts (Walter et al. 2007, eq. 13 and 16).
  vec3 h = through ? o + i * l.eta : o + i;
  if (h.z < 0.0f) h = -h;
  const float h2 = max(dot(h, h), 1e-20f);
  const float inverse = 1.0f / sqrt(h2);
  float c_o = min(dot(o, h) * inverse, 1.0f);
  float c_i = dot(i, h) * inverse;
  // Cycles shines light through rough glass even between directions that no facet on this side refracts to each other,
  // with the same formula: up to 13 % more; and where it bends no light. Samples never go there: the density is 0.
  const bool stray = through && (microfacet_is_straight(l) || !(c_o > 0.0f && c_i < 0.0f));
  if (stray) {
    c_o = min(abs(c_o), 1.0f);
    c_i = -abs(c_i);
  }
  if (!(c_o > 0.0f)) return vec3(0.0f);
  // 2. How much of each it sends on.
  vec3 reflected;
  vec3 transmitted;
  lobe_fresnel(table, l, c_o, reflected, transmitted);
  const float p = reflection_probability(reflected, transmitted);
  // 3. How many such facets are seen: eq. 17's change of measure is 4 c_o times that of a reflection.
  float visible;
  const float masking = microfacet_masking(l, o, i, visible);
  float d = microfacet_distribution(l, h);
  if (through) d *= 4.0f * c_o * -c_i * l.eta * l.eta / h2;
  const float density = d * visible * (through ? 1.0f - p : p);
  pdf = stray ? 0.0f : density;
  const vec3 share = select(through, transmitted, reflected);
  return share * (density > 0.0f ? d * masking : 0.0f);
}

// The viewer and light in the lobe's frame. Light through a thin wall is that of a reflection, mirrored.
FN vec3 microfacet_eval(FloatBuffer table, IN(Lobe) l, vec3 wo, vec3 wi, OUT(float) pdf) {
  vec3 t;
  vec3 b;
  microfacet_frame(l, t, b);
  const vec3 o = vec3(dot(wo, t), dot(wo, b), dot(wo, l.n));
  vec3 i = vec3(dot(wi, t), dot(wi, b), dot(wi, l.n));
  Lobe bare = l;
  if (l.kind == LOBE_THIN_TRANSMISSION) {
    bare.kind = LOBE_REFLECTION;
    i.z = -i.z;
  }
  return microfacet_eval_local(table, bare, o, i, pdf) * l.weight;
}

// ---- Sampling

// The direction that facet h, of a cosine c to the viewer, refracts toward.
FN vec3 refracted(vec3 o, vec3 h, float c, float eta) {
  const float inverse = 1.0f / eta;
  const float cos_t = sqrt(max(1.0f - (1.0f - c * c) * inverse * inverse, 0.0f));
  return h * (c * inverse - cos_t) - o * inverse;
}

// In the lobe's frame; s.wi is local on return.
FN void microfacet_sample_local(FloatBuffer table, IN(Lobe) l, vec3 o, float u_lobe, vec2 u, INOUT(BsdfSample) s) {
  const vec3 h = microfacet_half_vector(l, o, u);
  const float c = min(dot(o, h), 1.0f);
  if (!(c > 0.0f)) return;
  vec3 reflected;
  vec3 transmitted;
  lobe_fresnel(table, l, c, reflected, transmitted);
  const float p = reflection_probability(reflected, transmitted);
  const bool through = !(u_lobe < p);
  const float chance = through ? 1.0f - p : p;
  const vec3 share = select(through, transmitted, reflected);
  if (!(max_component(share) > 0.0f) || !(chance > 0.0f)) return;
  vec3 i = h * (2.0f * c) - o;
  if (through) i = refracted(o, h, c, l.eta);
  const bool straight = through && microfacet_is_straight(l);
  if (straight) i = -o;
  if (through ? !(i.z < 0.0f) : !(i.z > 0.0f)) return;
  s.wi = i;
  s.lobe = BSDF_GLOSSY | (through ? BSDF_TRANSMIT : 0u);
  s.weight = share * (1.0f / chance);
  s.pdf = chance;
  if (straight || microfacet_is_mirror(l)) {
    s.lobe |= BSDF_SINGULAR;
    return;
  }
  float visible;
  const float masking = microfacet_masking(l, o, i, visible);
  s.weight *= masking / visible;
  s.pdf *= microfacet_distribution(l, h) * visible;
  if (through) {
    const float c_i = abs(dot(i, h));
    s.pdf *= 4.0f * c * c_i * sqr(l.eta / max(abs(l.eta * c_i - c), 1e-10f));
  }
}

FN void microfacet_sample(FloatBuffer table, IN(Lobe) l, vec3 wo, float u_lobe, vec2 u, OUT(BsdfSample) s) {
  sample_clear(s);
  vec3 t;
  vec3 b;
  microfacet_frame(l, t, b);
  const vec3 o = vec3(dot(wo, t), dot(wo, b), dot(wo, l.n));
  if (!(o.z > 0.0f)) return;
  Lobe bare = l;
  const bool mirrored = l.kind == LOBE_THIN_TRANSMISSION;
  if (mirrored) bare.kind = LOBE_REFLECTION;
  microfacet_sample_local(table, bare, o, u_lobe, u, s);
  if (!(s.pdf > 0.0f)) return;
  vec3 i = s.wi;
  if (mirrored) {
    i.z = -i.z;
    s.lobe |= BSDF_TRANSMIT;
  }
  s.wi = to_world(i, t, b, l.n);
  if (mirrored && microfacet_is_mirror(l)) s.wi = -wo;
  s.weight *= l.weight;
}

// ---- Energy

// What single scattering loses, by tables; nothing where `preserve` is false.
FN void microfacet_multiscatter(FloatBuffer table, IN(Lobe) l, vec3 wo, bool preserve, OUT(Multiscatter) m) {
  const float mu = max(dot(l.n, wo), 0.0f);
  float single;
  if (l.kind == LOBE_GLASS) {
    single = table_glass(table, microfacet_roughness(l), mu, l.eta, m.mean);
  } else {
    single = albedo_reflectance(table, microfacet_roughness(l), mu, m.mean);
  }
  m.single = preserve ? max(single, 1e-4f) : 1.0f;
  m.missing = 1.0f / m.single - 1.0f;
}

// Multiplies the weight by what multiple scattering adds, for a mean Fresnel term. Beyond 1.5, where colours are no
// longer ones of surfaces, the series would not converge.
FN void microfacet_preserve(FloatBuffer table, vec3 wo, bool preserve, vec3 f_average, INOUT(Lobe) l) {
  Multiscatter m;
  microfacet_multiscatter(table, l, wo, preserve, m);
  l.single = m.single;
  l.weight = l.weight * multiscatter_scale(m, clamp(f_average, vec3(0.0f), vec3(1.5f)));
}

// What the lobe does with uniform light: by tables where there is one, else as if it were smooth (as Cycles).
FN vec3 microfacet_albedo(FloatBuffer table, IN(Lobe) l, vec3 wo) {
  const float mu = clamp(dot(l.n, wo), 1e-4f, 1.0f);
  const uint fresnel = l.mode & LOBE_FRESNEL;
  vec3 reflected;
  vec3 transmitted = vec3(0.0f);
  if (l.film <= FILM_CUTOFF && fresnel == LOBE_FRESNEL_F82) {
    reflected = l.f0 + (1.0f - l.f0) * albedo_schlick(table, microfacet_roughness(l), mu);
  } else if (l.film <= FILM_CUTOFF && fresnel == LOBE_FRESNEL_DIELECTRIC) {
    const float s = albedo_dielectric(table, microfacet_roughness(l), mu, l.eta);
    const vec3 f = l.f0 + (1.0f - l.f0) * s;
    reflected = f * l.f1;
    if (l.kind == LOBE_GLASS) transmitted = (1.0f - f) * l.tint;
  } else {
    lobe_fresnel(table, l, mu, reflected, transmitted);
  }
  return l.weight * (reflected + transmitted) * l.single;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
