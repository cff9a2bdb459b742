// SPDX-License-Identifier: GPL-3.0-or-later
// Each pure op in many modes over numbers that break naive code: zeros, infinities, NaN and the largest floats.
// Built with the undefined behaviour sanitizer, it ends by it or returns 0; of numbers up to 10 it demands numbers.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <random>

namespace cotorra {
constexpr std::uint32_t KERNEL_FEATURES = 0xffffffffu;
}
#include "program/pure.h"

using namespace cotorra;

namespace {

struct Row {
  unsigned number;
  const char *kind;
};

const Row rows[] = {
#define PROGRAM_OP(CONSTANT, NAME, NUMBER, KIND, RESULT, ARGUMENTS) {NUMBER, #KIND},
#include "program/ops.inc"
#undef PROGRAM_OP
};

constexpr float INF = std::numeric_limits<float>::infinity();
constexpr float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();
constexpr float WILD[] = {0.0f, -0.0f, 1.0f, -1.0f, INF, -INF, NOT_A_NUMBER, 3.4e38f, -3.4e38f, 1e-38f, 1e10f, 0.3f};
constexpr float TAME[] = {0.0f, -0.0f, 1.0f, -1.0f, 0.5f, 1e-3f, -0.25f, 10.0f, 2.0f, 0.3f, -7.7f, 3.0f};
// Powers, exponentials and hyperbolic functions of large numbers are infinite, in Cycles too.
bool may_overflow(unsigned op, unsigned mode) {
  const unsigned operation = mode & 0xffffu;
  return (op == OP_MATH && (operation == 10u || operation == 26u || operation == 29u || operation == 30u)) ||
         (op == OP_VECTOR_MATH_V && mode == 27u) || op == OP_GAMMA;
}

}  // namespace

int main() {
  std::mt19937 random(7);
  int bad = 0;
  for (const Row &row : rows) {
    if (row.kind[0] != 'P') continue;
    for (int trial = 0; trial < 3000; ++trial) {
      const bool tame = trial % 2 == 0;
      const unsigned mode = static_cast<unsigned>(random()) & (trial % 3 == 0 ? 0xfffu : 63u);
      ProgramArguments arguments;
      for (float &value : arguments.v) value = (tame ? TAME : WILD)[random() % 12];
      // A roughness above 1 is a growth: what 15 octaves multiply is beyond numbers, in Cycles too.
      if (tame && (row.number == OP_NOISE_F || row.number == OP_NOISE_V)) arguments.v[6] = 0.9f;
      // Cells in four dimensions and many octaves are slow, not different.
      if (row.number == OP_VORONOI_F || row.number == OP_VORONOI_V) arguments.v[5] = 1.5f;
      const vec3 r = program_pure(row.number, mode, arguments);
      if (tame && !may_overflow(row.number, mode) && !std::isfinite(r.x + r.y + r.z) && bad++ < 20) {
        std::printf("op %u mode %u: %g %g %g from", row.number, mode, double{r.x}, double{r.y}, double{r.z});
        for (int i = 0; i < 11; ++i) std::printf(" %g", double{arguments.v[i]});
        std::printf("\n");
      }
    }
  }
  return bad != 0;
}
