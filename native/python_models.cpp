// SPDX-License-Identifier: GPL-3.0-or-later
// Reads materials and their reflection models by the names of their arrays. Nothing is checked but types.
#include "python_models.h"

#include "python_arrays.h"

namespace cotorra {

ModelsInput read_models(nb::handle models, std::vector<nb::object> &keep) {
  ModelsInput in;
  if (models.is_none()) return in;
  in.model = view<uint, std::uint32_t>(models, "model", keep);
  in.normalized = view<uint, std::uint32_t>(models, "normalized", keep);
  in.distribution = view<uint, std::uint32_t>(models, "distribution", keep);
  in.masking = view<uint, std::uint32_t>(models, "masking", keep);
  in.fresnel = view<uint, std::uint32_t>(models, "fresnel", keep);
  in.f0_mode = view<uint, std::uint32_t>(models, "f0_mode", keep);
  in.split = view<uint, std::uint32_t>(models, "split", keep);
  in.oren_nayar_form = view<uint, std::uint32_t>(models, "oren_nayar_form", keep);
  in.toon_steps = view<uint, std::uint32_t>(models, "toon_steps", keep);
  in.kd = view<float, float>(models, "kd", keep);
  in.ks = view<float, float>(models, "ks", keep);
  in.shininess = view<float, float>(models, "shininess", keep);
  in.oren_nayar_sigma = view<float, float>(models, "oren_nayar_sigma", keep);
  in.ka = view<float, float>(models, "ka", keep);
  in.kr = view<float, float>(models, "kr", keep);
  in.kt = view<float, float>(models, "kt", keep);
  in.specular_color = view<vec3, float>(models, "specular_color", keep);
  in.f0 = view<vec3, float>(models, "f0", keep);
  in.f82_tint = view<vec3, float>(models, "f82_tint", keep);
  in.conductor_n = view<vec3, float>(models, "conductor_n", keep);
  in.conductor_k = view<vec3, float>(models, "conductor_k", keep);
  in.toon_lit = view<vec3, float>(models, "toon_lit", keep);
  in.toon_shade = view<vec3, float>(models, "toon_shade", keep);
  in.absorption = view<vec3, float>(models, "absorption", keep);
  return in;
}

MaterialsInput read_materials(nb::handle materials, std::vector<nb::object> &keep) {
  MaterialsInput in;
  in.pass_index = view<int, std::int32_t>(materials, "pass_index", keep);
  in.emission_sampling = view<uint, std::uint32_t>(materials, "emission_sampling", keep);
  in.shader = view<int, std::int32_t>(materials, "shader", keep);
  in.models = read_models(nb::getattr(materials, "models", nb::none()), keep);
  return in;
}

}  // namespace cotorra
