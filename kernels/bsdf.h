// SPDX-License-Identifier: GPL-3.0-or-later
// The Principled BSDF as Blender 5.2 has it, without coat, sheen, transmission and subsurface: a metal, and beside it a
// diffuse base under a dielectric layer. Emission and transparency are not part of it.
#ifndef COTORRA_BSDF_H
#define COTORRA_BSDF_H

#include "bsdf_tables.h"
#include "microfacet.h"
#include "sampling.h"
#include "scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint BSDF_DIFFUSE = 1u;
const uint BSDF_GLOSSY = 2u;
const uint BSDF_SINGULAR = 4u;  // a mirror: no light sample can meet it

// Weights of lobes below this count as none, as in Cycles.
const float BSDF_WEIGHT_CUTOFF = 1e-5f;

// The lobes at one shading point, toward one viewer. Metal and dielectric share D and V; only Fresnel differs.
struct Bsdf {
  vec3 n;  // shading normal
  float p_glossy;  // probability with which bsdf_sample takes the glossy lobe
  vec3 diffuse;  // albedo / pi
  float no;  // dot(n, wo)
  vec3 metal_f0;
  float alpha2;
  vec3 metal_edge;  // F_Schlick82Edge
  float s_o;  // S_SmithGGX of the viewer
  vec3 metal;  // weight of the metal, multiple scattering included
  float eta;  // of the dielectric
  vec3 coating_f0;  // dielectric: weight times the user's F0
  float fresnel_f0;  // F_Dielectric at normal incidence
  vec3 coating_f90;  // dielectric: weight times (1 - the user's F0) / (1 - fresnel_f0)
  uint lobes;  // BSDF_*: what bsdf_eval finds, and BSDF_SINGULAR where only bsdf_sample can
};

struct BsdfSample {
  vec3 wi;
  float pdf;  // of all lobes together, solid angle; of a mirror: the probability of its choice; 0: no sample
  vec3 weight;  // f cos / pdf
  uint lobe;  // BSDF_DIFFUSE or BSDF_GLOSSY, with BSDF_SINGULAR or without
};

// Does the dielectric layer reflect at all? Also its index of refraction and F0, after "Specular IOR Level".
FN float principled_eta(IN(Material) material, OUT(float) f0) {
  const float ior = max(material.ior, 1e-5f);
  const float level = max(material.specular_level, 0.0f);
  f0 = F0_from_ior(ior);
  if (level == 0.5f) return ior;
  f0 *= 2.0f * level;
  const float eta = ior_from_F0(f0);
  return select(ior < 1.0f, 1.0f / eta, eta);
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

// Single and multiple scattering over single scattering (Kulla & Conty 2017): 1 + F_ms (1 - E) / E.
FN vec3 multiscatter_scale(vec3 f_average, float missing, float e_mean) {
  return vec3(1.0f) + f_average * (e_mean * missing) / (vec3(1.0f) - f_average * (1.0f - e_mean));
}

// The glossy lobe is absent until bsdf_prepare_glossy finds one.
FN void bsdf_clear_glossy(INOUT(Bsdf) bsdf) {
  bsdf.metal_f0 = vec3(0.0f);
  bsdf.metal_edge = vec3(0.0f);
  bsdf.metal = vec3(0.0f);
  bsdf.coating_f0 = vec3(0.0f);
  bsdf.coating_f90 = vec3(0.0f);
  bsdf.alpha2 = 1.0f;
  bsdf.s_o = 1.0f;
  bsdf.eta = 1.0f;
  bsdf.fresnel_f0 = 0.0f;
}

// Metal and dielectric layer. Returns their albedo; `rest` is what lies beside the metal, and on return the part of it
// that the layer lets through to the base.
FN vec3 bsdf_prepare_glossy(IN(SceneData) scene, IN(Material) material, float metal, INOUT(float) rest,
                            INOUT(Bsdf) bsdf) {
  const float roughness = clamp(material.roughness, 0.0f, 1.0f);
  const float mu = max(bsdf.no, 0.0f);
  bsdf.alpha2 = max(sqr(sqr(roughness)), MIRROR_ALPHA2);
  bsdf.s_o = S_SmithGGX(mu, bsdf.alpha2);

  // 1. The energy that single scattering loses, as a share of what it keeps.
  float e_mean;
  const float e = albedo_reflectance(scene.albedo, roughness, mu, e_mean);
  const bool multiple = (material.flags & MATERIAL_MULTI_GGX) != 0u;
  const float missing = select(multiple, (1.0f - e) / e, 0.0f);
  const float single = 1.0f / (1.0f + missing);

  // 2. Metal.
  bsdf.metal_f0 = clamp(material.base_color, vec3(0.0f), vec3(1.0f));
  bsdf.metal_edge = F_Schlick82Edge(bsdf.metal_f0, clamp(material.specular_tint, vec3(0.0f), vec3(1.0f)));
  bsdf.metal = multiscatter_scale(F_Schlick82Average(bsdf.metal_f0, bsdf.metal_edge), missing, e_mean) * metal;
  const float metal_fresnel = albedo_schlick(scene.albedo, roughness, mu);
  vec3 albedo = bsdf.metal * (bsdf.metal_f0 + (1.0f - bsdf.metal_f0) * metal_fresnel) * single;

  // 3. Dielectric: Fresnel's curve runs from the user's F0 to 1 instead of from its own.
  float f0_user;
  bsdf.eta = principled_eta(material, f0_user);
  bsdf.fresnel_f0 = F0_from_ior(bsdf.eta);
  const float range = 1.0f / max(1.0f - bsdf.fresnel_f0, 1e-6f);
  const vec3 f0 = min(max(material.specular_tint, vec3(0.0f)) * f0_user, vec3(1.0f));
  const float average = clamp((F_DielectricAverage(bsdf.eta) - bsdf.fresnel_f0) * range, 0.0f, 1.0f);
  const vec3 scale = multiscatter_scale(f0 + (1.0f - f0) * average, missing, e_mean);
  const float coating = select(bsdf.eta != 1.0f, rest, 0.0f);
  const float fresnel = albedo_dielectric(scene.albedo, roughness, mu, bsdf.eta);
  const vec3 coating_albedo = scale * (f0 + (1.0f - f0) * fresnel) * single;
  bsdf.coating_f0 = scale * f0 * coating;
  bsdf.coating_f90 = scale * (1.0f - f0) * (coating * range);
  albedo += coating_albedo * coating;
  rest -= coating * min(max_component(coating_albedo), 1.0f);
  return albedo;
}

// Prepares the lobes of a material toward wo. `n` is the shading normal on the side of the geometric normal that faces
// wo; dot(n, wo) may be negative on smooth surfaces, and then the glossy lobe is gone. Also returns the albedo of the
// glossy lobes, for passes; that of the diffuse lobe is pi times Bsdf.diffuse.
FN vec3 bsdf_prepare_albedo(IN(SceneData) scene, IN(Material) material, vec3 n, vec3 wo, OUT(Bsdf) bsdf) {
  float rest;
  const float metal = principled_metal(material, rest);
  vec3 albedo = vec3(0.0f);
  bsdf.n = n;
  bsdf.no = dot(n, wo);
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
  }
  return albedo;
}

FN void bsdf_prepare(IN(SceneData) scene, IN(Material) material, vec3 n, vec3 wo, OUT(Bsdf) bsdf) {
  bsdf_prepare_albedo(scene, material, n, wo, bsdf);
}

// Weighted Fresnel term of the glossy lobes; c is the cosine between half vector and viewer.
FN vec3 bsdf_fresnel(IN(Bsdf) bsdf, float c) {
  const float dielectric = max(F_Dielectric(c, bsdf.eta) - bsdf.fresnel_f0, 0.0f);
  return bsdf.metal * F_Schlick82(bsdf.metal_f0, bsdf.metal_edge, c) + bsdf.coating_f0 + bsdf.coating_f90 * dielectric;
}

// f cos(wi) of the diffuse lobe, and of the glossy lobe beside it; pdf is that of bsdf_sample. All are 0 below n.
FN vec3 bsdf_eval_lobes(IN(Bsdf) bsdf, vec3 wo, vec3 wi, OUT(vec3) glossy, OUT(float) pdf) {
  const float ni = max(dot(bsdf.n, wi), 0.0f);
  pdf = ni * INV_PI;
  glossy = vec3(0.0f);
  if (FEATURE(FEATURE_SPECULAR)) {
    const vec3 h = wo + wi;
    const float h2 = max(dot(h, h), 1e-20f);
    const vec3 nh = cross(bsdf.n, h);
    const float d = D_GGX(dot(nh, nh) / h2, bsdf.alpha2);
    const float v = V_SmithGGXCorrelated(bsdf.no, bsdf.s_o, ni, S_SmithGGX(ni, bsdf.alpha2));
    const bool valid = ni > 0.0f && (bsdf.lobes & BSDF_GLOSSY) != 0u;
    // |o + i| is twice the cosine between them and h.
    glossy = bsdf_fresnel(bsdf, 0.5f * sqrt(h2)) * select(valid, d * v * ni, 0.0f);
    pdf = mix(pdf, select(valid, d * V_SmithGGXVisible(bsdf.no, bsdf.s_o), 0.0f), bsdf.p_glossy);
  }
  return bsdf.diffuse * ni;
}

// f cos(wi) of all lobes; pdf is that of bsdf_sample.
FN vec3 bsdf_eval(IN(Bsdf) bsdf, vec3 wo, vec3 wi, OUT(float) pdf) {
  vec3 glossy;
  const vec3 diffuse = bsdf_eval_lobes(bsdf, wo, wi, glossy, pdf);
  return diffuse + glossy;
}

// A direction in proportion to the lobes. Both lobes are warped from one point of the disk, so that no branch is
// needed.
FN void bsdf_sample(IN(Bsdf) bsdf, vec3 wo, float u_lobe, vec2 u, OUT(BsdfSample) s) {
  vec3 t;
  vec3 b;
  orthonormal_basis(bsdf.n, t, b);
  const vec2 disk = disk_from_square(u);
  s.wi = to_world(vec3(disk.x, disk.y, sqrt(max(1.0f - dot(disk, disk), 0.0f))), t, b, bsdf.n);
  s.lobe = BSDF_DIFFUSE;
  const bool mirror = (bsdf.lobes & BSDF_SINGULAR) != 0u;
  const bool glossy = u_lobe < bsdf.p_glossy;
  if (FEATURE(FEATURE_SPECULAR)) {
    const vec3 o = vec3(dot(wo, t), dot(wo, b), bsdf.no);
    const vec3 h = half_vector_VisibleGGX(o, sqrt(bsdf.alpha2), disk);
    const vec3 m = select(mirror, bsdf.n, to_world(h, t, b, bsdf.n));
    s.wi = select(glossy, m * (2.0f * dot(wo, m)) - wo, s.wi);
    s.lobe = select(glossy, BSDF_GLOSSY, BSDF_DIFFUSE);
  }
  const vec3 f = bsdf_eval(bsdf, wo, s.wi, s.pdf);
  s.weight = f * select(s.pdf > 0.0f, 1.0f / s.pdf, 0.0f);
  if (FEATURE(FEATURE_SPECULAR) && glossy && mirror) {
    s.pdf = bsdf.p_glossy;
    s.weight = bsdf_fresnel(bsdf, bsdf.no) / bsdf.p_glossy;
    s.lobe = BSDF_GLOSSY | BSDF_SINGULAR;
  }
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
