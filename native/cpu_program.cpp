// SPDX-License-Identifier: GPL-3.0-or-later
// Runs programs over batches: arguments are gathered into columns, and each op is a loop over them.
// Ops that have one are in cpu_ops.h, cpu_point_ops.h and cpu_textures.cpp; every other op is called point by point.
#include "cpu_program.h"

#include <algorithm>
#include <array>
#include <memory>

#include "every_feature.h"

#include "../kernels/program/program.h"
#include "cpu_ops.h"
#include "cpu_point_ops.h"

namespace cotorra {
namespace {

// Columns for arguments that are constants; one set a thread.
struct Scratch {
  std::array<std::array<float, kProgramStride>, PROGRAM_ARGUMENTS> column;
};
Scratch &scratch() {
  static thread_local const std::unique_ptr<Scratch> own = std::make_unique<Scratch>();
  return *own;
}

// The columns of one instruction's arguments, number by number. Returns how many there are.
std::size_t gather(const ProgramBatch &b, const uint *references, uint count, bool same_constants,
                   std::array<const float *, PROGRAM_ARGUMENTS> &columns) {
  std::size_t n = 0;
  for (uint k = 0; k < count; ++k) {
    const uint reference = references[k];
    const std::size_t size = (reference & REFERENCE_VECTOR) != 0 ? 3 : 1;
    for (std::size_t c = 0; c < size; ++c, ++n) {
      const std::size_t place = (reference & REFERENCE_MASK) + c;
      if ((reference & REFERENCE_CONSTANT) == 0) {
        columns[n] = b.registers + place * kProgramStride;
        continue;
      }
      float *column = scratch().column[n].data();
      const float *numbers = b.scene->program_constants.v + place;
      if (same_constants) {
        std::fill_n(column, b.n, numbers[b.constants[0]]);
      } else {
        for (int i = 0; i < b.n; ++i) column[i] = numbers[b.constants[i]];
      }
      columns[n] = column;
    }
  }
  return n;
}

void run_each(const ProgramBatch &b, uint op, uint mode, const float *const *columns, std::size_t count, bool vector,
              float *const *out) {
  ProgramArguments a;
  for (std::size_t i = 0; i < static_cast<std::size_t>(b.n); ++i) {
    for (std::size_t k = 0; k < count; ++k) a.v[k] = columns[k][i];
    const vec3 value = program_op(*b.scene, b.points[i], op, mode, a);
    out[0][i] = value.x;
    if (!vector) continue;
    out[1][i] = value.y;
    out[2][i] = value.z;
  }
}

// Runs the op as a loop and returns true where it has one.
bool run_loop(const ProgramBatch &b, uint op, uint mode, Columns a, Results out) {
  if (op < OP_SPLAT) return run_point(b, op, mode, a, out);
  if (op < OP_NOISE_F) return run_pure(op, mode, a, b.n, out);
  if (op < OP_RAMP_V) return COTORRA_PROGRAM_LOOPS::run_texture(op, mode, a, b.n, out);
  return run_table(*b.scene, op, mode, a, b.n, out);
}

void run(const ProgramBatch &b, std::uint32_t first, std::uint32_t end) {
  const uint *code = b.scene->program_code.v;
  const bool same = std::all_of(b.constants, b.constants + b.n, [&](uint c) { return c == b.constants[0]; });
  std::array<const float *, PROGRAM_ARGUMENTS> columns;
  std::array<float, 3 * kProgramStride> result;
  for (uint word = first; word < end;) {
    const uint head = code[word];
    const uint mode = code[word + 1];
    const uint arguments = (head >> PROGRAM_COUNT_SHIFT) & PROGRAM_COUNT_MASK;
    const std::size_t count = gather(b, code + word + 2, arguments, same, columns);
    word += 2 + arguments;
    const bool vector = (head & PROGRAM_VECTOR) != 0;
    // The result may take the place of an argument: loops write beside it first.
    float *const out[3] = {result.data(), result.data() + kProgramStride, result.data() + 2 * kProgramStride};
    const uint op = head & PROGRAM_OP_MASK;
    if (!run_loop(b, op, mode, columns.data(), out)) run_each(b, op, mode, columns.data(), count, vector, out);
    float *target = b.registers + (head >> PROGRAM_RESULT_SHIFT) * kProgramStride;
    for (std::size_t c = 0; c < (vector ? 3u : 1u); ++c, target += kProgramStride) std::copy_n(out[c], b.n, target);
  }
}

}  // namespace

// Of kernels/program/pure.h, for the kernels of the same instruction set.
namespace COTORRA_PROGRAM_LOOPS {
vec3 pure_op(uint op, uint mode, const ProgramArguments &a) { return program_pure(op, mode, a); }
}  // namespace COTORRA_PROGRAM_LOOPS

extern const RunProgram COTORRA_PROGRAM_NAME;
const RunProgram COTORRA_PROGRAM_NAME = run;

}  // namespace cotorra
