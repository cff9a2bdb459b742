// SPDX-License-Identifier: GPL-3.0-or-later
// Checks the exporter's reflection models and derives the records and flags that kernels read.
// What the models do is told in kernels/model.h.
#include "scene_models.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "scene.h"

namespace cotorra {
namespace {

// One array of the input: how large it must be, and what its values may be.
struct Checker {
  std::size_t materials;

  template <class T>
  void size(std::span<const T> array, const char *name) const {
    if (array.size() == materials) return;
    throw std::invalid_argument("models." + std::string(name) + " has " + std::to_string(array.size()) +
                                " entries, expected " + std::to_string(materials));
  }
  void below(std::span<const uint> array, uint limit, const char *name) const {
    size(array, name);
    const auto it = std::find_if(array.begin(), array.end(), [limit](uint v) { return v >= limit; });
    if (it == array.end()) return;
    throw std::invalid_argument("models." + std::string(name) + "[" + std::to_string(it - array.begin()) +
                                "] = " + std::to_string(*it) + ", must be below " + std::to_string(limit));
  }
  // Finite, and at least 0.
  void amounts(std::span<const float> array, const char *name, std::size_t components = 1) const {
    if (components == 1) size(array, name);
    const auto it = std::find_if_not(array.begin(), array.end(), [](float v) { return std::isfinite(v) && v >= 0.0f; });
    if (it == array.end()) return;
    throw std::invalid_argument("models." + std::string(name) + "[" +
                                std::to_string(static_cast<std::size_t>(it - array.begin()) / components) +
                                "] = " + std::to_string(*it) + ", must be a finite number of at least 0");
  }
  void amounts(std::span<const vec3> array, const char *name) const {
    size(array, name);
    if (array.empty()) return;
    amounts({&array.front().x, array.size() * 3}, name, 3);
  }
};

void check(const ModelsInput &in, std::size_t materials) {
  const Checker c{materials};
  c.below(in.model, MODEL_TOON + 1, "model");
  c.below(in.normalized, 2, "normalized");
  c.below(in.distribution, DISTRIBUTION_BLINN_PHONG + 1, "distribution");
  c.below(in.masking, MASKING_SCHLICK_GGX + 1, "masking");
  c.below(in.fresnel, FRESNEL_F82 + 1, "fresnel");
  c.below(in.f0_mode, F0_IOR + 1, "f0_mode");
  c.below(in.split, SPLIT_MIX + 1, "split");
  c.below(in.oren_nayar_form, OREN_NAYAR_ENERGY_PRESERVING + 1, "oren_nayar_form");
  c.size(in.toon_steps, "toon_steps");
  c.amounts(in.kd, "kd");
  c.amounts(in.ks, "ks");
  c.amounts(in.shininess, "shininess");
  c.amounts(in.oren_nayar_sigma, "oren_nayar_sigma");
  c.amounts(in.ka, "ka");
  c.amounts(in.kr, "kr");
  c.amounts(in.kt, "kt");
  c.amounts(in.specular_color, "specular_color");
  c.amounts(in.f0, "f0");
  c.amounts(in.f82_tint, "f82_tint");
  c.amounts(in.conductor_n, "conductor_n");
  c.amounts(in.conductor_k, "conductor_k");
  c.amounts(in.toon_lit, "toon_lit");
  c.amounts(in.toon_shade, "toon_shade");
  c.amounts(in.absorption, "absorption");
}

MaterialModel record(const ModelsInput &in, std::size_t i) {
  MaterialModel m{};
  m.specular_color = in.specular_color[i];
  m.kd = in.kd[i];
  m.f0 = in.f0[i];
  m.ks = in.ks[i];
  m.conductor_n = in.conductor_n[i];
  m.shininess = in.shininess[i];
  m.conductor_k = in.conductor_k[i];
  m.oren_nayar_sigma = in.oren_nayar_sigma[i];
  m.f82_tint = in.f82_tint[i];
  m.ka = in.ka[i];
  m.toon_lit = in.toon_lit[i];
  m.kr = in.kr[i];
  m.toon_shade = in.toon_shade[i];
  m.kt = in.kt[i];
  m.absorption = in.absorption[i];
  m.toon_steps = std::max(in.toon_steps[i], 2u);
  m.model = in.model[i];
  m.distribution = in.distribution[i];
  m.masking = in.masking[i];
  m.fresnel = in.fresnel[i];
  m.f0_mode = in.f0_mode[i];
  m.split = in.split[i];
  m.normalized = in.normalized[i];
  m.oren_nayar_form = in.oren_nayar_form[i];
  return m;
}

// Roughness of a Cook-Torrance surface whose highlight is about as wide: alpha^2 = 2 / (n + 2), with Phong's n counted
// four times, since its angle is twice that of the half vector.
float equal_roughness(const Material &material, const MaterialModel &model) {
  if (model.model == MODEL_COOK_TORRANCE) return material.roughness;
  const float n = model.shininess * (model.model == MODEL_PHONG ? 4.0f : 1.0f);
  return std::pow(2.0f / (n + 2.0f), 0.25f);
}

uint model_flags(const Material &material, const MaterialModel &model) {
  const bool phong = model.model == MODEL_PHONG || model.model == MODEL_BLINN_PHONG;
  const bool specular = model.model == MODEL_COOK_TORRANCE || (phong && model.ks > 0.0f);
  const bool no_diffuse =
      (phong && model.kd == 0.0f) || (model.model == MODEL_COOK_TORRANCE && material.metallic >= 1.0f);
  uint flags = MATERIAL_MODEL;
  if (specular) flags |= MATERIAL_SPECULAR;
  if (!no_diffuse) flags |= MATERIAL_DIFFUSE;
  if (specular && equal_roughness(material, model) < kSharpRoughness) flags |= MATERIAL_SHARP;
  return flags;
}

}  // namespace

std::vector<MaterialModel> model_records(const ModelsInput &in, std::size_t materials) {
  check(in, materials);
  std::vector<MaterialModel> models(materials);
  for (std::size_t i = 0; i < materials; ++i) models[i] = record(in, i);
  return models;
}

void apply_models(std::span<const MaterialModel> models, std::span<Material> materials) {
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (models[i].model == MODEL_PRINCIPLED) continue;
    if (i >> (32u - MATERIAL_INDEX_SHIFT) != 0) {
      throw std::invalid_argument("models.model[" + std::to_string(i) + "]: only the first " +
                                  std::to_string(1u << (32u - MATERIAL_INDEX_SHIFT)) +
                                  " materials can have a reflection model other than Principled");
    }
    Material &m = materials[i];
    m.flags &= ~(MATERIAL_SPECULAR | MATERIAL_DIFFUSE | MATERIAL_SHARP);
    m.flags |= model_flags(m, models[i]) | static_cast<uint>(i) << MATERIAL_INDEX_SHIFT;
  }
}

void Scene::prepare_models(const ModelsInput &in) {
  if (in.model.empty()) return;
  models_ = model_records(in, materials_.size());
  data_.models = {models_.data()};
  apply_models(models_, materials_);
}

}  // namespace cotorra
