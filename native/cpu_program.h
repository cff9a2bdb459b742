// SPDX-License-Identifier: GPL-3.0-or-later
// Programs over batches of points on the CPU: one op over all points, then the next. Compiled once for each
// instruction set; one point at a time is kernels/program/program.h's business.
#pragma once

#include <cstddef>

#include "../kernels/program/point.h"
#include "../kernels/program/types.h"

namespace cotorra {

constexpr int kProgramLanes = 1024;                       // points of a batch at most
constexpr std::size_t kProgramStride =
    kProgramLanes + 16;  // between registers: a page apart they would share a cache line

// Points of surfaces whose programs have the same code.
struct ProgramBatch {
  const SceneData *scene;
  const ShaderPoint *points;      // [n]
  const std::uint32_t *constants;  // [n] where the numbers of each point's material begin
  int n;
  float *registers;  // [registers of the scene's largest program][kProgramStride], by register
};

// One lane of a batch's registers.
struct LaneRegisters {
  struct Column {
    const float *first;
    float operator[](std::uint32_t place) const { return first[place * kProgramStride]; }
  } v;
};
inline LaneRegisters lane_registers(const ProgramBatch &batch, std::size_t lane) { return {{batch.registers + lane}}; }

// Runs the instructions [first, end) of the code for all points.
using RunProgram = void (*)(const ProgramBatch &batch, std::uint32_t first, std::uint32_t end);

// The build for this processor.
RunProgram choose_cpu_program();

}  // namespace cotorra
