// SPDX-License-Identifier: GPL-3.0-or-later
// The Principled BSDF as Blender 5.2 has it, without coat, sheen, transmission and subsurface: a metal, and beside it a
// diffuse base under a dielectric layer. Where a material asks for another model, model.h takes over.
#ifndef COTORRA_BSDF_H
#define COTORRA_BSDF_H

#include "bsdf_tables.h"
#include "microfacet.h"
#include "model.h"
#include "reflection_normal.h"
#include "sampling.h"
#include "scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint BSDF_DIFFUSE = 1u;
const uint BSDF_GLOSSY = 2u;
const uint BSDF_SINGULAR = 4u;  // a mirror: no light sample can meet it
const uint BSDF_SHARP = 8u;  // of a MATERIAL_SHARP
const uint BSDF_TRANSMIT = 16u;  // goes through the surface
const uint BSDF_THROUGH = 32u;  // no lobe: the ray goes straight on
const uint BSDF_HIDDEN = 64u;  // sampled where n_smooth hides lamps (glossy_cosine)
const uint BSDF_HOLDOUT = 128u;  // it shows nothing, and leaves nothing of the film

// Weights of lobes below this count as none, as in Cycles.
const float BSDF_WEIGHT_CUTOFF = 1e-5f;

// The lobes at one shading point, toward one viewer. Metal and dielectric share D and V; only Fresnel differs.
// Weights are multiplied in, multiple scattering included.
struct Bsdf {
  vec3 n;  // shading normal
  float p_glossy;  // probability with which bsdf_sample takes the glossy lobe
  vec3 diffuse;  // albedo / pi
  float no;  // dot(n_glossy, wo)
  vec3 metal_f0;  // F_Schlick82
  float alpha2;
  vec3 metal_range;
  float s_o;  // S_SmithGGX of the viewer
  vec3 metal_edge;
  float eta;  // of the dielectric
  vec3 coating_f0;  // dielectric: the user's F0
  float fresnel_f0;  // F_Dielectric at normal incidence
  vec3 n_glossy;  // normal of the glossy lobes, see normal_for_reflection
  float unused;
  vec3 n_smooth;  // shading normal before a normal map bent it, with FEATURE_PROGRAMS only
  float unused2;
  vec3 coating_f90;  // dielectric: (1 - the user's F0) / (1 - fresnel_f0)
  uint lobes;  // BSDF_*: what bsdf_eval finds, and BSDF_SINGULAR where only bsdf_sample can
  ModelBsdf model;  // with FEATURE_MODELS only; takes over where it is not MODEL_PRINCIPLED
};

struct BsdfSample {
  vec3 wi;
  float pdf;  // of all lobes together, solid angle; of a mirror: the probability of its choice; 0: no sample
  vec3 weight;  // f cos / pdf
  uint lobe;  // BSDF_DIFFUSE or BSDF_GLOSSY; with it BSDF_SINGULAR, BSDF_SHARP, BSDF_TRANSMIT
};

// Index of refraction of the dielectric layer, and its F0, after "Specular IOR Level"; at 1 there is no layer.
FN float dielectric_eta(float material_ior, float specular_level, OUT(float) f0) {
  const float ior = max(material_ior, 1e-5f);
  const float level = max(specular_level, 0.0f);
  f0 = F0_from_ior(ior);
  if (level == 0.5f) return ior;
  f0 *= 2.0f * level;
  const float eta = ior_from_F0(f0);
  return select(ior < 1.0f, 1.0f / eta, eta);
}
FN float principled_eta(IN(Material) material, OUT(float) f0) {
  return dielectric_eta(material.ior, material.specular_level, f0);
}

// Share of the material that is metal, and what is left for the layers beside it.
FN float principled_metal(IN(Material) material, OUT(float) rest) {
  const float share = clamp(material.metallic, 0.0f, 1.0f);
  const float metal = select(share > BSDF_WEIGHT_CUTOFF, share, 0.0f);
  rest = select(1.0f - metal >= BSDF_WEIGHT_CUTOFF, 1.0f - metal, 0.0f);
  return metal;
}

// MATERIAL_SPECULAR and MATERIAL_DIFFUSE as the material deserves them.
FN uint principled_flags(IN(Material) material) {
  float rest;
  float f0;
  const float metal = principled_metal(material, rest);
  const float eta = principled_eta(material, f0);
  const bool specular = metal > 0.0f || (rest > 0.0f && eta != 1.0f);
  const bool diffuse = rest > 0.0f && max_component(material.base_color) > 0.0f;
  return select(specular, MATERIAL_SPECULAR, 0u) | select(diffuse, MATERIAL_DIFFUSE, 0u);
}

// The energy that single scattering on a rough surface loses.
struct Multiscatter {
  float single;  // albedo of single scattering with F = 1
  float missing;  // (1 - single) / single
  float mean;  // mean of `single` over the hemisphere
};

// Single and multiple scattering over single scattering (Kulla & Conty 2017): 1 + F_ms (1 - E) / E.
FN vec3 multiscatter_scale(IN(Multiscatter) m, vec3 f_average) {
  return vec3(1.0f) + f_average * (m.mean * m.missing) / (vec3(1.0f) - f_average * (1.0f - m.mean));
}

// Metal. Returns its albedo.
FN vec3 bsdf_prepare_metal(IN(SceneData) scene, IN(Material) material, IN(Multiscatter) m, float weight,
                           INOUT(Bsdf) bsdf) {
  const vec3 f0 = clamp(material.base_color, vec3(0.0f), vec3(1.0f));
  const vec3 edge = F_Schlick82Edge(f0, clamp(material.specular_tint, vec3(0.0f), vec3(1.0f)));
  const vec3 scale = multiscatter_scale(m, F_Schlick82Average(f0, edge)) * weight;
  bsdf.metal_f0 = scale * f0;
  bsdf.metal_range = scale - bsdf.metal_f0;
  bsdf.metal_edge = scale * edge;
  // Cycles leaves the edge out of the albedo too.
  const float fresnel = albedo_schlick(scene.albedo, clamp(material.roughness, 0.0f, 1.0f), max(bsdf.no, 0.0f));
  return (bsdf.metal_f0 + bsdf.metal_range * fresnel) * m.single;
}

// Dielectric layer: Fresnel's curve runs from the user's F0 to 1 instead of from its own. Returns its albedo for weight
// 1; what is left of 1 reaches the base.
FN vec3 bsdf_prepare_coating(IN(SceneData) scene, IN(Material) material, IN(Multiscatter) m, float weight, float eta,
                             float f0_user, INOUT(Bsdf) bsdf) {
  bsdf.eta = eta;
  bsdf.fresnel_f0 = F0_from_ior(eta);
  const float range = 1.0f / max(1.0f - bsdf.fresnel_f0, 1e-6f);
  const vec3 f0 = min(max(material.specular_tint, vec3(0.0f)) * f0_user, vec3(1.0f));
  const float average = clamp((F_DielectricAverage(eta) - bsdf.fresnel_f0) * range, 0.0f, 1.0f);
  const vec3 scale = multiscatter_scale(m, f0 + (1.0f - f0) * average);
  const vec3 scale_f0 = scale * f0;
  const vec3 scale_f90 = scale - scale_f0;
  bsdf.coating_f0 = scale_f0 * weight;
  bsdf.coating_f90 = scale_f90 * (weight * range);
  const float roughness = clamp(material.roughness, 0.0f, 1.0f);
  const float fresnel = albedo_dielectric(scene.albedo, roughness, max(bsdf.no, 0.0f), eta);
  return (scale_f0 + scale_f90 * fresnel) * m.single;
}

// The glossy lobes. Returns their albedo; `rest` is what lies beside the metal, and on return the part of it that the
// dielectric layer lets through to the base.
FN vec3 bsdf_prepare_glossy(IN(SceneData) scene, IN(Material) material, float metal, INOUT(float) rest,
                            INOUT(Bsdf) bsdf) {
  const float roughness = clamp(material.roughness, 0.0f, 1.0f);
  const float mu = max(bsdf.no, 0.0f);
  bsdf.alpha2 = max(sqr(sqr(roughness)), MIRROR_ALPHA2);
  bsdf.s_o = S_SmithGGX(mu, bsdf.alpha2);
  Multiscatter m;
  const float single = albedo_reflectance(scene.albedo, roughness, mu, m.mean);
  const bool multiple = (material.flags & MATERIAL_MULTI_GGX) != 0u;
  m.single = select(multiple, single, 1.0f);
  m.missing = 1.0f / m.single - 1.0f;
  vec3 albedo = vec3(0.0f);
  if (metal > 0.0f) albedo = bsdf_prepare_metal(scene, material, m, metal, bsdf);
  float f0_user;
  const float eta = principled_eta(material, f0_user);
  if (rest > 0.0f && eta != 1.0f) {
    const vec3 coating = bsdf_prepare_coating(scene, material, m, rest, eta, f0_user, bsdf);
    albedo += coating * rest;
    rest *= 1.0f - min(max_component(coating), 1.0f);
  }
  return albedo;
}

// No glossy lobe, until bsdf_prepare_glossy finds one.
FN void bsdf_clear_glossy(INOUT(Bsdf) bsdf) {
  bsdf.metal_f0 = vec3(0.0f);
  bsdf.metal_range = vec3(0.0f);
  bsdf.metal_edge = vec3(0.0f);
  bsdf.coating_f0 = vec3(0.0f);
  bsdf.coating_f90 = vec3(0.0f);
  bsdf.alpha2 = 1.0f;
  bsdf.s_o = 1.0f;
  bsdf.eta = 1.0f;
  bsdf.fresnel_f0 = 0.0f;
}

// The same for a material with a model other than Principled: of Bsdf itself, only normals, flags and the albedo count.
FN vec3 bsdf_prepare_model(IN(SceneData) scene, IN(Material) material, vec3 n, vec3 ng, vec3 wo, INOUT(Bsdf) bsdf) {
  const MaterialModel model = LOAD(scene.models, material.flags >> MATERIAL_INDEX_SHIFT);
  bsdf_clear_glossy(bsdf);
  bsdf.n = n;
  bsdf.n_smooth = n;
  bsdf.unused2 = 0.0f;
  bsdf.unused = 0.0f;
  bsdf.n_glossy = normal_for_reflection(n, ng, wo);
  const vec3 albedo = model_prepare(material, model, n, bsdf.n_glossy, wo, bsdf.model);
  bsdf.no = bsdf.model.no;
  bsdf.p_glossy = bsdf.model.p_specular;
  bsdf.diffuse = bsdf.model.diffuse * INV_PI;
  const uint kind = select(model_is_mirror(bsdf.model), BSDF_SINGULAR, BSDF_GLOSSY);
  const uint sharp = select((material.flags & MATERIAL_SHARP) != 0u, BSDF_SHARP, 0u);
  bsdf.lobes = BSDF_DIFFUSE | select(bsdf.p_glossy > 0.0f, kind | sharp, 0u);
  return albedo;
}

// Prepares the lobes of a material toward wo. `n` is the shading normal on the side of the geometric normal that faces
// wo, `ng`; dot(n, wo) may be negative on smooth surfaces. Also returns the albedo of the
// glossy lobes, for passes; that of the diffuse lobe is pi times Bsdf.diffuse.
FN vec3 bsdf_prepare_albedo(IN(SceneData) scene, IN(Material) material, vec3 n, vec3 ng, vec3 wo, OUT(Bsdf) bsdf) {
  if (FEATURE(FEATURE_MODELS)) {
    if ((material.flags & MATERIAL_MODEL) != 0u) return bsdf_prepare_model(scene, material, n, ng, wo, bsdf);
    model_clear(bsdf.model);
  }
  float rest;
  const float metal = principled_metal(material, rest);
  vec3 albedo = vec3(0.0f);
  bsdf.n = n;
  bsdf.n_smooth = n;
  bsdf.unused2 = 0.0f;
  bsdf.n_glossy = n;
  bsdf.unused = 0.0f;
  if (FEATURE(FEATURE_SPECULAR)) bsdf.n_glossy = normal_for_reflection(n, ng, wo);
  bsdf.no = dot(bsdf.n_glossy, wo);
  bsdf.lobes = BSDF_DIFFUSE;
  bsdf.p_glossy = 0.0f;
  bsdf_clear_glossy(bsdf);
  if (FEATURE(FEATURE_SPECULAR) && (material.flags & MATERIAL_SPECULAR) != 0u) {
    albedo = bsdf_prepare_glossy(scene, material, metal, rest, bsdf);
  }
  const vec3 diffuse = max(material.base_color, vec3(0.0f)) * rest;
  bsdf.diffuse = diffuse * INV_PI;
  if (FEATURE(FEATURE_SPECULAR)) {
    const float weight = albedo.x + albedo.y + albedo.z;
    const bool glossy = weight > 0.0f && bsdf.no > 0.0f;
    bsdf.p_glossy = select(glossy, weight / (weight + diffuse.x + diffuse.y + diffuse.z), 0.0f);
    const uint kind = select(bsdf.alpha2 > MIRROR_ALPHA2, BSDF_GLOSSY, BSDF_SINGULAR);
    bsdf.lobes |= select(glossy, kind, 0u);
    bsdf.lobes |= select(glossy && (material.flags & MATERIAL_SHARP) != 0u, BSDF_SHARP, 0u);
  }
  return albedo;
}

FN void bsdf_prepare(IN(SceneData) scene, IN(Material) material, vec3 n, vec3 ng, vec3 wo, OUT(Bsdf) bsdf) {
  bsdf_prepare_albedo(scene, material, n, ng, wo, bsdf);
}

// Fresnel term of the glossy lobes; c is the cosine between half vector and viewer, c2 its square.
FN vec3 bsdf_fresnel(IN(Bsdf) bsdf, float c, float c2) {
  const float dielectric = max(F_Dielectric(c, c2, bsdf.eta) - bsdf.fresnel_f0, 0.0f);
  return F_Schlick82(bsdf.metal_f0, bsdf.metal_range, bsdf.metal_edge, c) + bsdf.coating_f0 +
         bsdf.coating_f90 * dielectric;
}

// f cos(wi) of the glossy lobe; takes the pdf of the diffuse lobe and returns that of both. The half vector is given by
// its squared length h2, the squared length xy2 of its part along the surface, and its squared cosine c2 to the viewer.
FN vec3 bsdf_eval_glossy(IN(Bsdf) bsdf, float ni, float h2, float xy2, float c2, INOUT(float) pdf) {
  const float d = D_GGX(xy2, h2, bsdf.alpha2);
  const float v = V_SmithGGXCorrelated(bsdf.no, bsdf.s_o, ni, S_SmithGGX(ni, bsdf.alpha2));
  const bool valid = ni > 0.0f && (bsdf.lobes & BSDF_GLOSSY) != 0u;
  pdf = mix(pdf, select(valid, d * V_SmithGGXVisible(bsdf.no, bsdf.s_o), 0.0f), bsdf.p_glossy);
  return bsdf_fresnel(bsdf, sqrt(c2), c2) * select(valid, d * v * ni, 0.0f);
}

// Does the smooth surface see wi on another side than the closure's normal n, which sees it in front?
FN bool bsdf_hides(IN(Bsdf) bsdf, vec3 n, vec3 wi) { return dot(bsdf.n_smooth, wi) * dot(bsdf.n_smooth, n) < 0.0f; }

FN vec3 bsdf_smooth_normal(IN(Bsdf) bsdf) { return bsdf.n_smooth; }

// Cosine of wi to the normal of the glossy lobes; 0 where it and the smooth surface disagree about the side wi is on.
// Rays that were `sampled` need not agree, as in Cycles 5.2: its lamps are hidden by what a displacement bent the
// surface to, where its reflections still show the sky. Past its triangle they do not go (path_advance).
FN float glossy_cosine(IN(Bsdf) bsdf, float n_wi, vec3 wi, bool sampled) {
  const float ni = max(dot(bsdf.n_glossy, wi), 0.0f);
  if (sampled) return ni;
  if (FEATURE(FEATURE_PROGRAMS)) return select(bsdf_hides(bsdf, bsdf.n_glossy, wi), 0.0f, ni);
  return select(n_wi * dot(bsdf.n, bsdf.n_glossy) >= 0.0f, ni, 0.0f);
}

// What is left of the diffuse light from wi where a normal map bent the surface: the shadowing of a GGX surface whose
// roughness is as great as the bend, about the smooth normal (Estevez, Lecocq & Stein 2019, "A Microfacet-Based
// Shadowing Function to Solve the Bump Terminator Problem"), as Cycles 5.2 does it. 1 without a map.
FN float bump_shadowing_of(vec3 n, vec3 n_smooth, vec3 wi) {
  const float bend = dot(n, n_smooth);
  const float height = dot(n_smooth, wi);
  // The sine by a cross product: 1 - bend^2 would find a bend where there is none, and darken grazing light.
  const vec3 sine = cross(n, n_smooth);
  const float height2 = clamp(height * height, 1e-12f, 1.0f);
  const float alpha2 = min(0.125f * dot(sine, sine) / max(bend * bend, 1e-12f), 1.0f);
  return 2.0f / (1.0f + sqrt(1.0f + alpha2 * (1.0f - height2) / height2));
}

// The same of a diffuse lobe about bsdf.n: nothing from below the smooth surface, nor where the map points below it.
FN float bump_shadowing(IN(Bsdf) bsdf, vec3 wi) {
  if (!FEATURE(FEATURE_PROGRAMS)) return 1.0f;
  const bool above = dot(bsdf.n, bsdf.n_smooth) > 0.0f && dot(bsdf.n_smooth, wi) > 0.0f;
  return select(above, bump_shadowing_of(bsdf.n, bsdf.n_smooth, wi), 0.0f);
}

// f cos(wi) of the diffuse lobe, and of the glossy lobe beside it; pdf is that of bsdf_sample. All are 0 below n.
// `sampled`: glossy_cosine.
FN vec3 bsdf_eval_lobes(IN(Bsdf) bsdf, vec3 wo, vec3 wi, bool sampled, OUT(vec3) glossy, OUT(float) pdf) {
  const float n_wi = dot(bsdf.n, wi);
  if (FEATURE(FEATURE_MODELS) && bsdf.model.model != MODEL_PRINCIPLED) {
    const float ni_glossy = glossy_cosine(bsdf, n_wi, wi, sampled);
    return model_eval(bsdf.model, bsdf.n, bsdf.n_glossy, ni_glossy, wo, wi, glossy, pdf);
  }
  const float ni = max(n_wi, 0.0f);
  pdf = ni * INV_PI;
  glossy = vec3(0.0f);
  if (FEATURE(FEATURE_SPECULAR)) {
    const vec3 h = wo + wi;
    const float h2 = max(dot(h, h), 1e-20f);
    // Lagrange's identity, exact near the normal. |wo + wi| is twice the cosine between either of them and h.
    const vec3 xy = cross(bsdf.n_glossy, h);
    glossy = bsdf_eval_glossy(bsdf, glossy_cosine(bsdf, n_wi, wi, sampled), h2, dot(xy, xy), 0.25f * h2, pdf);
  }
  return bsdf.diffuse * (ni * bump_shadowing(bsdf, wi));
}

// The diffuse lobe's part of the density of bsdf_sample.
FN float bsdf_diffuse_pdf(IN(Bsdf) bsdf, vec3 wi) {
  const float ni = max(dot(bsdf.n, wi), 0.0f);
  float pdf = ni * INV_PI;
  if (FEATURE(FEATURE_MODELS) && bsdf.model.model != MODEL_PRINCIPLED) pdf = model_diffuse_pdf(bsdf.model, ni);
  return pdf * (1.0f - bsdf.p_glossy);
}

// f cos(wi) of all lobes; pdf is that of bsdf_sample.
FN vec3 bsdf_eval(IN(Bsdf) bsdf, vec3 wo, vec3 wi, OUT(float) pdf) {
  vec3 glossy;
  const vec3 diffuse = bsdf_eval_lobes(bsdf, wo, wi, false, glossy, pdf);
  return diffuse + glossy;
}

// The half vector that bsdf_sample reflects wo about, in the frame of n, of any length.
FN vec3 bsdf_sample_half_vector(IN(Bsdf) bsdf, vec3 o, vec2 disk) {
  if ((bsdf.lobes & BSDF_SINGULAR) != 0u) return vec3(0.0f, 0.0f, 1.0f);
  return half_vector_GGX(o, sqrt(bsdf.alpha2), bsdf.s_o, disk);
}

// What a direction of the highlight, or of the diffuse lobe, brings of a material with a model other than Principled.
FN void bsdf_weigh_model(IN(Bsdf) bsdf, vec3 wo, bool specular, INOUT(BsdfSample) s) {
  vec3 glossy;
  const vec3 diffuse = bsdf_eval_lobes(bsdf, wo, s.wi, true, glossy, s.pdf);
  s.weight = (diffuse + glossy) * select(s.pdf > 0.0f, 1.0f / s.pdf, 0.0f);
  s.lobe = select(specular, BSDF_GLOSSY, BSDF_DIFFUSE) | (bsdf.lobes & BSDF_SHARP);
  if (specular && model_is_mirror(bsdf.model)) {
    s.lobe |= BSDF_SINGULAR;
    s.pdf = bsdf.p_glossy;
    s.weight = model_fresnel(bsdf.model, bsdf.no) * (bsdf.model.share / bsdf.p_glossy);
  }
}

// A direction of such a material.
FN void bsdf_sample_model(IN(Bsdf) bsdf, vec3 wo, float u_lobe, vec2 u, OUT(BsdfSample) s) {
  bool specular;
  s.wi = model_sample(bsdf.model, bsdf.n, bsdf.n_glossy, wo, u_lobe, u, specular);
  bsdf_weigh_model(bsdf, wo, specular, s);
}

// A direction, from one of the lobes in proportion to their albedo.
FN void bsdf_sample(IN(Bsdf) bsdf, vec3 wo, float u_lobe, vec2 u, OUT(BsdfSample) s) {
  if (FEATURE(FEATURE_MODELS) && bsdf.model.model != MODEL_PRINCIPLED) {
    bsdf_sample_model(bsdf, wo, u_lobe, u, s);
    return;
  }
  const bool pick_glossy = FEATURE(FEATURE_SPECULAR) && u_lobe < bsdf.p_glossy;
  vec3 frame = bsdf.n;
  if (FEATURE(FEATURE_SPECULAR)) frame = select(pick_glossy, bsdf.n_glossy, bsdf.n);
  vec3 t;
  vec3 b;
  orthonormal_basis(frame, t, b);
  const vec2 disk = disk_from_square(u);
  // In the frame of the lobe's normal, wo is o and wi is i.
  vec3 i = vec3(disk.x, disk.y, sqrt(max(1.0f - dot(disk, disk), 0.0f)));
  s.lobe = BSDF_DIFFUSE;
  if (FEATURE(FEATURE_SPECULAR)) {
    const vec3 o = vec3(dot(wo, t), dot(wo, b), dot(wo, frame));
    vec3 h = o + i;
    float h2 = max(dot(h, h), 1e-20f);
    float c2 = 0.25f * h2;
    float xy2 = h.x * h.x + h.y * h.y;
    if (pick_glossy) {
      h = bsdf_sample_half_vector(bsdf, o, disk);
      h2 = max(dot(h, h), 1e-30f);
      const float oh = dot(o, h);
      i = h * (2.0f * oh / h2) - o;
      c2 = clamp(oh * oh / h2, 1e-20f, 1.0f);
      xy2 = h.x * h.x + h.y * h.y;
      s.lobe = BSDF_GLOSSY;
    }
    s.wi = to_world(i, t, b, frame);
    const float n_wi = dot(bsdf.n, s.wi);
    const float ni = max(n_wi, 0.0f);
    s.pdf = ni * INV_PI;
    // A diffuse direction's half vector stands in the frame of n: seen from n_glossy it is another.
    const vec3 xy = cross(bsdf.n_glossy, wo + s.wi);
    const float ni_glossy = glossy_cosine(bsdf, n_wi, s.wi, true);
    const vec3 glossy = bsdf_eval_glossy(bsdf, ni_glossy, h2, select(pick_glossy, xy2, dot(xy, xy)), c2, s.pdf);
    s.weight = (bsdf.diffuse * (ni * bump_shadowing(bsdf, s.wi)) + glossy) * (s.pdf > 0.0f ? 1.0f / s.pdf : 0.0f);
    if (s.lobe == BSDF_GLOSSY && (bsdf.lobes & BSDF_SINGULAR) != 0u) {
      s.lobe = BSDF_GLOSSY | BSDF_SINGULAR;
      s.pdf = bsdf.p_glossy;
      s.weight = bsdf_fresnel(bsdf, bsdf.no, bsdf.no * bsdf.no) / bsdf.p_glossy;
    }
    s.lobe |= bsdf.lobes & BSDF_SHARP;
    if (FEATURE(FEATURE_PROGRAMS)) s.lobe |= select(bsdf_hides(bsdf, bsdf.n_glossy, s.wi), BSDF_HIDDEN, 0u);
  } else {
    s.wi = to_world(i, t, b, frame);
    s.pdf = i.z * INV_PI;
    s.weight = bsdf.diffuse * (PI * bump_shadowing(bsdf, s.wi));
  }
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
