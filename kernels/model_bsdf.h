// SPDX-License-Identifier: GPL-3.0-or-later
// The lobes of a reflection model other than Principled, toward one viewer: their record, Fresnel term and highlights.
// How they are prepared and sampled is told in model.h.
#ifndef COTORRA_MODEL_BSDF_H
#define COTORRA_MODEL_BSDF_H

#include "model_diffuse.h"
#include "model_half_vectors.h"
#include "model_microfacet.h"
#include "scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Alpha at least: below MIRROR_ALPHA2 squared, so that it still counts as a mirror, and far enough from 0 to divide by.
const float MIRROR_ALPHA = 1.4e-5f;

struct ModelBsdf {
  vec3 diffuse;      // pi f where it is constant: albedo; Phongs: pi kd base; toon: the colour in full light
  float p_specular;  // probability with which the highlight is sampled, not the diffuse lobe
  vec3 specular;     // Phongs: f cos is this times the power; Cook-Torrance: F0; toon: the colour in the shade
  float p_uniform;   // of the diffuse lobe's samples, the share that is uniform, not by the cosine
  vec3 index_n;      // conductor: index of refraction; F82: the edge coefficient
  float exponent;    // Phongs
  vec3 index_k;      // conductor
  float alpha;       // Cook-Torrance
  float eta;         // dielectric
  float no;          // cosine between the highlight's normal and the viewer
  float n_lambda;    // no Lambda(o) of Smith's masking
  float visible;     // no (1 + Lambda(o)) as half vectors are sampled
  float share;       // Cook-Torrance: factor of the highlight
  float sigma;       // Oren-Nayar: radians, or EON's r
  uint model;        // MODEL_*
  uint distribution; // and so on, as in MaterialModel
  uint masking;
  uint fresnel;
  uint form;         // Phongs: normalized; Oren-Nayar: its form; Cook-Torrance: split; toon: steps
};

// No lobe at all: a Principled material.
FN void model_clear(OUT(ModelBsdf) m) {
  m.diffuse = vec3(0.0f);
  m.p_specular = 0.0f;
  m.specular = vec3(0.0f);
  m.p_uniform = 0.0f;
  m.index_n = vec3(0.0f);
  m.exponent = 0.0f;
  m.index_k = vec3(0.0f);
  m.alpha = 1.0f;
  m.eta = 1.0f;
  m.no = 0.0f;
  m.n_lambda = 0.0f;
  m.visible = 1.0f;
  m.share = 0.0f;
  m.sigma = 0.0f;
  m.model = MODEL_PRINCIPLED;
  m.distribution = DISTRIBUTION_GGX;
  m.masking = MASKING_SMITH_CORRELATED;
  m.fresnel = FRESNEL_SCHLICK;
  m.form = 0u;
}

FN bool model_is_phong(uint model) { return model == MODEL_PHONG || model == MODEL_BLINN_PHONG; }

// A mirror: no light sample can meet it.
FN bool model_is_mirror(IN(ModelBsdf) m) {
  return m.model == MODEL_COOK_TORRANCE && m.alpha * m.alpha <= MIRROR_ALPHA2;
}

// Are half vectors sampled as Smith's model shows them, not V-cavities'? There is no Smith model of Blinn-Phong's D.
FN bool model_samples_smith(IN(ModelBsdf) m) {
  return m.masking != MASKING_COOK_TORRANCE && m.distribution != DISTRIBUTION_BLINN_PHONG;
}

// Two directions as a highlight sees them; the cosines are to its normal.
struct HalfAngle {
  float ni;
  float nh;
  float sin2;    // 1 - nh^2
  float oh;
  float rv;      // cosine between wi and the mirror direction of wo
  float off_mirror;  // 1 - rv
};

// `ni` is passed, since it is 0 where the two normals of a point disagree about the side of the surface.
FN void half_angle(vec3 n, vec3 wo, vec3 wi, float ni, OUT(HalfAngle) a) {
  const vec3 h = wo + wi;
  const float h2 = max(dot(h, h), 1e-20f);
  const vec3 xy = cross(n, h);
  a.ni = ni;
  a.nh = max(dot(n, h), 0.0f) / sqrt(h2);
  a.sin2 = min(dot(xy, xy) / h2, 1.0f);
  a.oh = 0.5f * sqrt(h2);
  const vec3 mirror = n * (2.0f * dot(n, wo)) - wo;
  const vec3 apart = wi - mirror;
  a.rv = dot(wi, mirror);
  a.off_mirror = 0.5f * dot(apart, apart);
}

// ---- Cook-Torrance

// From here on to the highlights nothing returns early: what is not asked for is passed over, or in loops over lanes,
// which become vector code, computed and left.

FN vec3 model_fresnel(IN(ModelBsdf) m, float c) {
  vec3 f = m.specular + (1.0f - m.specular) * F_SchlickWeight(c);
  if (m.fresnel == FRESNEL_F82) f = F_Schlick82(m.specular, 1.0f - m.specular, m.index_n, c);
  if (m.fresnel == FRESNEL_DIELECTRIC) f = vec3(F_Dielectric(c, c * c, m.eta));
  if (m.fresnel == FRESNEL_CONDUCTOR) {
    f = vec3(F_Conductor(c, m.index_n.x, m.index_k.x), F_Conductor(c, m.index_n.y, m.index_k.y),
             F_Conductor(c, m.index_n.z, m.index_k.z));
  }
  return f;
}

FN float model_distribution(IN(ModelBsdf) m, IN(HalfAngle) a) {
  const float alpha2 = m.alpha * m.alpha;
  float d = D_GGX(a.sin2, 1.0f, alpha2);
  if (m.distribution == DISTRIBUTION_BECKMANN) d = D_Beckmann(a.sin2, a.nh, alpha2);
  if (m.distribution == DISTRIBUTION_BLINN_PHONG) d = D_BlinnPhong(a.sin2, a.nh, alpha2);
  return d;
}

// nx Lambda(x) of the user's D; Blinn-Phong takes Beckmann's.
FN float model_n_lambda(uint distribution, float nx, float alpha) {
  float n_lambda = N_LambdaGGX(nx, alpha * alpha);
  if (distribution != DISTRIBUTION_GGX) n_lambda = N_LambdaBeckmann(nx, alpha);
  return n_lambda;
}

// G / (4 no).
FN float model_masking(IN(ModelBsdf) m, IN(HalfAngle) a) {
  const float n_lambda = model_n_lambda(m.distribution, a.ni, m.alpha);
  float v = V_SmithCorrelated(m.no, m.n_lambda, a.ni, n_lambda);
  if (m.masking == MASKING_SMITH) v = V_Smith(m.no, m.n_lambda, a.ni, n_lambda);
  if (m.masking == MASKING_COOK_TORRANCE) v = V_Cavity(m.no, a.ni, a.nh, a.oh);
  if (m.masking == MASKING_SCHLICK_GGX) v = V_SchlickGGX(m.no, a.ni, m.alpha);
  return v;
}

// ---- Highlights

// f cos of the highlight for ni and no above 0, and the density with which it is sampled; not of a mirror.
FN vec3 model_eval_phong(IN(ModelBsdf) m, IN(HalfAngle) a, OUT(float) pdf) {
  const bool blinn = m.model == MODEL_BLINN_PHONG;
  const float c = select(blinn, a.nh * a.nh, max(a.rv, 0.0f));
  const float x = select(blinn, a.sin2, a.off_mirror);
  const float power = select(c > 0.0f, pow_near_one(c, x, select(blinn, 0.5f, 1.0f) * m.exponent), 0.0f);
  pdf = power * (m.exponent + 1.0f) * (0.5f * INV_PI) * select(blinn, 0.25f / a.oh, 1.0f);
  return m.specular * select(m.form != 0u, power * a.ni, power);
}
FN vec3 model_eval_cook_torrance(IN(ModelBsdf) m, IN(HalfAngle) a, OUT(float) pdf) {
  const float d = model_distribution(m, a);
  pdf = d * select(model_samples_smith(m), 0.25f / m.visible, V_CavityVisible(m.no, a.nh, a.oh));
  return model_fresnel(m, a.oh) * (m.share * d * model_masking(m, a));
}

// The same of any model; 0 where it has no highlight, or a mirror's.
FN vec3 model_eval_specular(IN(ModelBsdf) m, IN(HalfAngle) a, OUT(float) pdf) {
  vec3 f = vec3(0.0f);
  pdf = 0.0f;
  if (model_is_phong(m.model)) f = model_eval_phong(m, a, pdf);
  if (m.model == MODEL_COOK_TORRANCE) f = model_eval_cook_torrance(m, a, pdf);
  const bool seen = a.ni > 0.0f && m.no > 0.0f && !model_is_mirror(m);
  pdf = select(seen, pdf, 0.0f);
  return select(seen, f, vec3(0.0f));
}

// A half vector, of any length, that the highlight reflects wo about; `o` is wo in the frame of the highlight's normal.
FN vec3 model_half_vector(IN(ModelBsdf) m, vec3 o, vec2 disk, float u_side, vec2 u) {
  vec3 h = vec3(0.0f, 0.0f, 1.0f);
  if (m.model == MODEL_BLINN_PHONG) {
    h = power_lobe(disk, m.exponent);
  } else if (m.model == MODEL_COOK_TORRANCE && !model_is_mirror(m)) {
    if (!model_samples_smith(m)) {
      h = half_vector_cavity(m.distribution, o, disk, u_side, m.alpha);
    } else if (m.distribution == DISTRIBUTION_BECKMANN) {
      h = half_vector_Beckmann(o, m.alpha, u);
    } else {
      h = half_vector_GGX(o, m.alpha, S_SmithGGX(o.z, m.alpha * m.alpha), disk);
    }
  }
  return h;
}

// Where the highlight sends a ray from wo, in the same frame.
FN vec3 model_sample_specular(IN(ModelBsdf) m, vec3 o, float u_side, vec2 u) {
  const vec2 disk = disk_from_square(u);
  const vec3 h = model_half_vector(m, o, disk, u_side, u);
  vec3 i = h * (2.0f * dot(o, h) / max(dot(h, h), 1e-30f)) - o;
  if (m.model == MODEL_PHONG) {
    // About the mirror direction, whose frame is its own.
    const vec3 mirror = vec3(-o.x, -o.y, o.z);
    vec3 t;
    vec3 b;
    orthonormal_basis(mirror, t, b);
    i = to_world(power_lobe(disk, m.exponent), t, b, mirror);
  }
  return i;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
