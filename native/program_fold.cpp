// SPDX-License-Identifier: GPL-3.0-or-later
// Runs ops on constants while shaders are compiled: the very functions that kernels run.
// What is folded, and why, is program_graph.cpp's.
#include <algorithm>
#include <cmath>

#include "program_graph.h"

#include "every_feature.h"

#include "../kernels/program/program.h"

namespace cotorra {

vec3 program_fold(uint op, uint mode, std::span<const float> arguments, std::span<const float> tables) {
  ProgramArguments a{};
  std::copy(arguments.begin(), arguments.end(), a.v);
  SceneData scene{};
  scene.tables = {tables.data()};
  const vec3 value = program_op(scene, ShaderPoint{}, op, mode, a);
  const auto finite = [](float x) { return std::isnan(x) ? 0.0f : std::clamp(x, -3e38f, 3e38f); };
  return {finite(value.x), finite(value.y), finite(value.z)};
}

}  // namespace cotorra
