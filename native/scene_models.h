// SPDX-License-Identifier: GPL-3.0-or-later
// From the exporter's arrays to the records of reflection models (kernels/scene_types.h), checked.
// What the models do is told in kernels/model.h.
#pragma once

#include <span>
#include <vector>

#include "../kernels/scene_types.h"

namespace cotorra {

// Views of a MaterialModels, one entry a material; all empty where there is none.
struct ModelsInput {
  std::span<const uint> model, normalized, distribution, masking, fresnel, f0_mode, split, oren_nayar_form, toon_steps;
  std::span<const float> kd, ks, shininess, oren_nayar_sigma, ka, kr, kt;
  std::span<const vec3> specular_color, f0, f82_tint, conductor_n, conductor_k, toon_lit, toon_shade, absorption;
};

// Below this roughness a highlight may be narrower than a usual lamp: light sampling alone becomes noisy, and BSDF
// sampling shares the work, for a ray a sample. Where exactly the two break even was not measured yet.
constexpr float kSharpRoughness = 0.25f;

// The records of `materials` models. Throws std::invalid_argument naming array, index and value.
std::vector<MaterialModel> model_records(const ModelsInput &in, std::size_t materials);
// Marks the materials with a model other than Principled: MATERIAL_MODEL, the place of the model, and what it does
// (MATERIAL_SPECULAR, MATERIAL_DIFFUSE, MATERIAL_SHARP).
void apply_models(std::span<const MaterialModel> models, std::span<Material> materials);

}  // namespace cotorra
