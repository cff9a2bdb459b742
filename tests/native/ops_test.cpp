// SPDX-License-Identifier: GPL-3.0-or-later
// The pure ops of shading programs over arrays, for the tests in Python, and the list of ops.
// Nothing is tested here: see tests/test_ops.py.
#include <cstddef>
#include <cstdint>

namespace cotorra {
constexpr std::uint32_t KERNEL_FEATURES = 0xffffffffu;
}
#include "program/pure.h"

using namespace cotorra;

struct OpRow {
  const char *name;
  unsigned number;
  const char *kind;
  const char *result;
  const char *arguments;
};

#define PROGRAM_OP(CONSTANT, NAME, NUMBER, KIND, RESULT, ARGUMENTS) {#NAME, NUMBER, #KIND, #RESULT, #ARGUMENTS},
extern "C" const OpRow test_ops[] = {
#include "program/ops.inc"
    {nullptr, 0, nullptr, nullptr, nullptr},
};
#undef PROGRAM_OP

extern "C" void test_pure(unsigned op, unsigned mode, std::size_t count, const ProgramArguments *arguments,
                          vec3 *results) {
  for (std::size_t i = 0; i < count; ++i) results[i] = program_pure(op, mode, arguments[i]);
}
