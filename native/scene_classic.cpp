// SPDX-License-Identifier: GPL-3.0-or-later
// Fills the records that Whitted, Toon and the ambient term read of a material beside its BSDF.
// What they do with them is told in kernels/whitted.h, toon.h and occlusion.h.
#include "scene.h"

namespace cotorra {
namespace {

ClassicMaterial classic_of(const MaterialModel &model) {
  ClassicMaterial c{};
  c.absorption = model.absorption;
  c.ka = model.ka;
  c.kr = model.kr;
  c.kt = model.kt;
  c.toon_lit = model.toon_lit;
  c.toon_shade = model.toon_shade;
  c.toon_steps = model.toon_steps;
  if (model.model == MODEL_TOON) c.flags |= CLASSIC_TOON;
  return c;
}

// As material.cotorra is when nobody touched it.
ClassicMaterial default_classic() {
  ClassicMaterial c{};
  c.ka = 1.0f;
  c.toon_steps = 2;
  return c;
}

}  // namespace

void Scene::prepare_classic() {
  const std::size_t n = materials_.size();
  for (std::size_t i = 0; i < n; ++i) {
    classic_.push_back(models_.empty() ? default_classic() : classic_of(models_[i]));
    classic_[i].transmission = compiled(i).surface.transmission;
  }
  data_.classic = {classic_.data()};
}

}  // namespace cotorra
