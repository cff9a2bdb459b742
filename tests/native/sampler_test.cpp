// SPDX-License-Identifier: GPL-3.0-or-later
// The sampler of kernels/sampling.h over arrays, for test_sampler.py.
// What its points must be like, the test says.
#include <cstddef>
#include <cstdint>

namespace cotorra {
namespace {
constexpr std::uint32_t KERNEL_FEATURES = ~0u;
}
}  // namespace cotorra

#include "../../kernels/sampling.h"

extern "C" {

void test_owen_hash(const std::uint32_t *x, std::uint32_t seed, std::uint32_t *out, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = cotorra::owen_hash(x[i], seed);
}

// Points of `count` samples from `first` on, of one pixel; out holds x, y by turns.
void test_points(std::uint32_t x, std::uint32_t y, std::uint32_t first, std::uint32_t sample_bits, std::uint32_t seed,
                 std::uint32_t pair, float *out, std::size_t count) {
  const std::uint32_t own = cotorra::sampler_pair_seed(cotorra::sampler_block_seed(x, y, sample_bits, seed), pair);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t number = first + static_cast<std::uint32_t>(i);
    const cotorra::vec2 p = cotorra::sampler_pair(cotorra::sampler_index(x, y, number, sample_bits), own);
    out[2 * i] = p.x;
    out[2 * i + 1] = p.y;
  }
}
}
