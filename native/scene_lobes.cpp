// SPDX-License-Identifier: GPL-3.0-or-later
// Hands the inputs of Principled to kernels/scattering.h, for materials that ask for lobes which bsdf.h lacks.
// Nothing of Blender's is read here: tests fill the inputs.
#include <cstring>
#include <stdexcept>
#include <string>

#include "scene.h"

namespace cotorra {

void Scene::prepare_lobes(std::span<const float> words) {
  if (words.empty()) return;
  constexpr std::size_t kWords = sizeof(PrincipledInputs) / sizeof(float);
  if (words.size() != materials_.size() * kWords) {
    throw std::invalid_argument("materials.principled has " + std::to_string(words.size()) + " words, expected " +
                                std::to_string(materials_.size() * kWords));
  }
  principled_.resize(materials_.size());
  std::memcpy(principled_.data(), words.data(), words.size_bytes());
  for (std::size_t i = 0; i < materials_.size(); ++i) {
    if (principled_[i].inside != 0) materials_[i].flags |= MATERIAL_LOBES;
  }
  data_.principled = {principled_.data()};
}

}  // namespace cotorra
