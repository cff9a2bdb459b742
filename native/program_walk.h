// SPDX-License-Identifier: GPL-3.0-or-later
// The instructions of a program, one after the other, for those who look at its code and do not run it.
// How they are written down is kernels/program/types.h's.
#pragma once

#include <optional>

#include "../kernels/scene_types.h"

namespace cotorra {

// One op of a program of the scene; `constants`: the first of its material's numbers.
struct ProgramInstruction {
  const SceneData &scene;
  uint constants;
  uint op;
  uint mode;
  uint first;  // word of its first argument

  // The argument's number, or its first one, where it is a constant.
  std::optional<float> argument(uint index) const {
    const uint reference = scene.program_code.v[first + index];
    if ((reference & REFERENCE_CONSTANT) == 0) return std::nullopt;
    return scene.program_constants.v[constants + (reference & REFERENCE_MASK)];
  }
};

template <class Work>
void each_instruction(const SceneData &scene, const ProgramPart &part, uint constants, Work work) {
  for (uint word = part.first; word < part.end;) {
    const uint head = scene.program_code.v[word];
    work(ProgramInstruction{scene, constants, head & PROGRAM_OP_MASK, scene.program_code.v[word + 1], word + 2});
    word += 2 + ((head >> PROGRAM_COUNT_SHIFT) & PROGRAM_COUNT_MASK);
  }
}

}  // namespace cotorra
