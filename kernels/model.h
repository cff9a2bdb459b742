// SPDX-License-Identifier: GPL-3.0-or-later
// The reflection models beside Principled: Lambert, Oren-Nayar, Phong, Blinn-Phong, Cook-Torrance and toon, each to
// prepare, evaluate and sample. bsdf.h takes them where a material asks for one; nothing else knows of them.
#ifndef COTORRA_MODEL_H
#define COTORRA_MODEL_H

#include "model_bsdf.h"
#include "sampling.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Powers beyond cannot be told from this one by directions in 32 bits.
const float EXPONENT_MAX = 1e8f;

// Fresnel terms below are rounding: there is no interface.
const float REFLECTANCE_CUTOFF = 1e-5f;

// ---- Preparation: each returns the highlight's albedo, roughly, for the choice between the lobes.

FN vec3 model_prepare_phong(IN(Material) material, IN(MaterialModel) model, INOUT(ModelBsdf) m) {
  const float n = min(model.shininess, EXPONENT_MAX);
  const bool blinn = model.model == MODEL_BLINN_PHONG;
  const float phong_norm = (n + 2.0f) * (0.5f * INV_PI);
  const float blinn_norm = (n + 2.0f) * (n + 4.0f) / (8.0f * PI * (exp2(-0.5f * n) + n));
  m.exponent = n;
  m.form = model.normalized;
  m.diffuse = material.base_color * (model.kd * PI);
  m.specular = model.specular_color * model.ks;
  if (m.form != 0u) m.specular = m.specular * select(blinn, blinn_norm, phong_norm);
  // The lobe's solid angle, 2 pi / (n + 1); about a half vector, 4 oh times that, where oh is the viewer's cosine give
  // or take the tilt of h. With the normalised forms, f cos falls off with ni, which is about no.
  const float oh = sqrt(sqr(max(m.no, 0.0f)) + 1.0f / (n + 2.0f));
  const float angle = 2.0f * PI / (n + 1.0f) * select(blinn, 4.0f * oh, 1.0f);
  return m.specular * (m.form != 0u ? angle * oh : angle);
}

FN vec3 model_F0(IN(Material) material, IN(MaterialModel) model) {
  vec3 f0 = model.f0;
  if (model.f0_mode == F0_METALLIC) f0 = mix(vec3(0.04f), material.base_color, material.metallic);
  if (model.f0_mode == F0_IOR) f0 = vec3(F0_from_ior(material.ior));
  return clamp(f0, vec3(0.0f), vec3(1.0f));
}

FN vec3 model_prepare_cook_torrance(IN(Material) material, IN(MaterialModel) model, INOUT(ModelBsdf) m) {
  const float metallic = clamp(material.metallic, 0.0f, 1.0f);
  m.alpha = max(sqr(clamp(material.roughness, 0.0f, 1.0f)), MIRROR_ALPHA);
  m.distribution = model.distribution;
  m.masking = model.masking;
  m.fresnel = model.fresnel;
  m.form = model.split;
  m.eta = max(material.ior, 1e-5f);
  m.diffuse = material.base_color * (1.0f - metallic);
  m.share = select(m.form == SPLIT_MIX, metallic, 1.0f);
  m.specular = model_F0(material, model);
  m.index_n = model.conductor_n;
  m.index_k = model.conductor_k;
  if (m.fresnel == FRESNEL_F82) m.index_n = F_Schlick82Edge(m.specular, clamp(model.f82_tint, vec3(0.0f), vec3(1.0f)));
  const float no = max(m.no, 0.0f);
  const bool ggx = m.distribution == DISTRIBUTION_GGX;
  m.n_lambda = model_n_lambda(m.distribution, no, m.alpha);
  m.visible = max(no + (ggx ? m.n_lambda : N_LambdaBeckmannExact(no, m.alpha)), 1e-30f);
  // F toward the viewer, and the mean of Schlick's (1 - c)^5 times what it is near the horizon: there F is above 0 even
  // where it is 0 toward the viewer, and what can be seen must be sampled.
  const vec3 albedo = (model_fresnel(m, max(no, 1e-2f)) + model_fresnel(m, 1e-2f) * (1.0f / 21.0f)) * m.share;
  return select(max_component(albedo) > REFLECTANCE_CUTOFF, albedo, vec3(0.0f));
}

FN void model_prepare_oren_nayar(IN(MaterialModel) model, float no, INOUT(ModelBsdf) m) {
  const float sigma2 = sqr(model.oren_nayar_sigma);
  const bool eon = model.oren_nayar_form == OREN_NAYAR_ENERGY_PRESERVING;
  m.form = model.oren_nayar_form;
  m.sigma = eon ? min(model.oren_nayar_sigma * (2.0f * INV_PI), 1.0f) : model.oren_nayar_sigma;
  // The term that grows toward the light's horizon holds ratio sin(o) / 2 of the energy that the constant one holds.
  const float ratio = eon ? m.sigma : oren_nayar_B(sigma2) / oren_nayar_A(sigma2);
  const float grazing = 0.5f * ratio * sqrt(max(1.0f - no * no, 0.0f));
  m.p_uniform = grazing / (1.0f + grazing);
}

// Prepares the lobes toward wo. n and n_glossy as in Bsdf. Returns the highlight's albedo, roughly.
FN vec3 model_prepare(IN(Material) material, IN(MaterialModel) model, vec3 n, vec3 n_glossy, vec3 wo,
                      OUT(ModelBsdf) m) {
  model_clear(m);
  m.model = model.model;
  m.no = dot(n_glossy, wo);
  m.diffuse = material.base_color;
  vec3 albedo = vec3(0.0f);
  if (model_is_phong(m.model)) albedo = model_prepare_phong(material, model, m);
  if (m.model == MODEL_COOK_TORRANCE) albedo = model_prepare_cook_torrance(material, model, m);
  if (m.model == MODEL_OREN_NAYAR) model_prepare_oren_nayar(model, max(dot(n, wo), 0.0f), m);
  if (m.model == MODEL_TOON) {
    m.diffuse = model.toon_lit;
    m.specular = model.toon_shade;
    m.form = model.toon_steps;
    m.p_uniform = 1.0f;
  }
  m.diffuse = max(m.diffuse, vec3(0.0f));
  const float weight = albedo.x + albedo.y + albedo.z;
  const float total = weight + m.diffuse.x + m.diffuse.y + m.diffuse.z;
  m.p_specular = weight > 0.0f && m.no > 0.0f ? weight / total : 0.0f;
  return albedo;
}

// ---- Evaluation

// The colour of `steps` tones at a light's cosine.
FN vec3 toon_color(vec3 lit, vec3 shade, uint steps, float ni) {
  const float last = float(int(max(steps, 2u) - 1u));
  const float tone = min(floor(ni * (last + 1.0f)), last) / last;
  return mix(shade, lit, tone);
}

// f cos of the diffuse lobe for ni > 0. Cook-Torrance's, if it splits by energy, gets what F leaves.
FN vec3 model_eval_diffuse(IN(ModelBsdf) m, vec3 n, vec3 wo, vec3 wi, float ni, float oh) {
  const float no = max(dot(n, wo), 0.0f);
  const float oi = dot(wo, wi);
  vec3 f = m.diffuse;
  if (m.model == MODEL_TOON) f = toon_color(m.diffuse, m.specular, m.form, ni) * (0.5f / ni);
  if (m.model == MODEL_OREN_NAYAR) {
    const float sigma2 = m.sigma * m.sigma;
    const vec3 qualitative = f * (oren_nayar_A(sigma2) + oren_nayar_B(sigma2) * oren_nayar_shape(no, ni, oi));
    const bool energy = m.form == OREN_NAYAR_ENERGY_PRESERVING;
    f = select(energy, eon_eval(f, m.sigma, no, ni, oi), qualitative);
  }
  if (m.model == MODEL_COOK_TORRANCE && m.form == SPLIT_ENERGY) f = f * (1.0f - model_fresnel(m, oh));
  return f * (ni * INV_PI);
}

// Density with which the diffuse lobe is sampled, at cosine ni.
FN float model_diffuse_pdf(IN(ModelBsdf) m, float ni) {
  return select(ni > 0.0f, mix(ni * INV_PI, 0.5f * INV_PI, m.p_uniform), 0.0f);
}

// f cos(wi) of the diffuse lobe, and of the highlight beside it; pdf is that of model_sample. All are 0 below n.
// ni_glossy is the cosine to the highlight's normal, 0 where n disagrees about the side of the surface.
FN vec3 model_eval(IN(ModelBsdf) m, vec3 n, vec3 n_glossy, float ni_glossy, vec3 wo, vec3 wi, OUT(vec3) specular,
                   OUT(float) pdf) {
  const float ni = dot(n, wi);
  const bool above = ni > 0.0f;
  const float cosine = select(above, ni, 1.0f);
  HalfAngle a;
  half_angle(n_glossy, wo, wi, ni_glossy, a);
  float pdf_specular = 0.0f;
  specular = vec3(0.0f);
  if (m.p_specular > 0.0f && above) specular = model_eval_specular(m, a, pdf_specular);
  pdf = select(above, mix(model_diffuse_pdf(m, cosine), pdf_specular, m.p_specular), 0.0f);
  return select(above, model_eval_diffuse(m, n, wo, wi, cosine, a.oh), vec3(0.0f));
}

// ---- Sampling

// A direction about +z: uniform in the hemisphere with probability p_uniform, else by the cosine.
FN vec3 hemisphere_mixture(float p_uniform, float u_choice, vec2 u) {
  const vec2 disk = disk_from_square(u);
  const float r2 = dot(disk, disk);
  const bool uniform_one = u_choice < p_uniform;
  const float spread = uniform_one ? sqrt(max(2.0f - r2, 0.0f)) : 1.0f;
  const float z = uniform_one ? 1.0f - r2 : sqrt(max(1.0f - r2, 0.0f));
  return vec3(disk.x * spread, disk.y * spread, max(z, 0.0f));
}

// A direction of one of the lobes; `specular` tells which. The number that chose is used again for what it left open.
FN vec3 model_sample(IN(ModelBsdf) m, vec3 n, vec3 n_glossy, vec3 wo, float u_lobe, vec2 u, OUT(bool) specular) {
  specular = u_lobe < m.p_specular;
  const vec3 frame = select(specular, n_glossy, n);
  vec3 t;
  vec3 b;
  orthonormal_basis(frame, t, b);
  const vec3 o = vec3(dot(wo, t), dot(wo, b), dot(wo, frame));
  const float u_choice = (u_lobe - m.p_specular) / max(1.0f - m.p_specular, 1e-8f);
  vec3 i = hemisphere_mixture(m.p_uniform, u_choice, u);
  if (specular) i = model_sample_specular(m, o, u_lobe / m.p_specular, u);
  return to_world(i, t, b, frame);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
