// SPDX-License-Identifier: GPL-3.0-or-later
// What loops of ops over columns of arguments have in common: one number of an argument of all points is a column, and
// so is one of the result. The loops themselves are in cpu_ops.h, cpu_point_ops.h and cpu_textures.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "../kernels/language.h"
#include "cpu_vector.h"

namespace cotorra {

// Of cpu_textures.cpp: runs the op for n points and returns true where it has a loop.
namespace COTORRA_PROGRAM_LOOPS {
bool run_texture(std::uint32_t op, std::uint32_t mode, const float *const *a, int n, float *const *out);
}

namespace {

using Columns = const float *const *;
using Results = float *const *;
using Loop = void (*)(Columns a, int n, Results out);

inline vec3 column_vector(Columns a, std::size_t first, std::size_t i) {
  return {a[first][i], a[first + 1][i], a[first + 2][i]};
}
inline void store(Results out, std::size_t i, vec3 v) {
  out[0][i] = v.x;
  out[1][i] = v.y;
  out[2][i] = v.z;
}

// One loop for each mode below kCount, so that nothing in a loop asks for the mode. Running one gives false where
// there is none, or where it says so itself.
template <template <uint> class Op, std::size_t... kModes>
constexpr auto loops_of(std::index_sequence<kModes...>) {
  return std::array{&Op<static_cast<uint>(kModes)>::run...};
}
template <template <uint> class Op, std::size_t kCount, class... Arguments>
bool run_mode(uint mode, Arguments... arguments) {
  static constexpr auto loops = loops_of<Op>(std::make_index_sequence<kCount>());
  if (mode >= kCount) return false;
  if constexpr (std::is_same_v<decltype(loops[mode](arguments...)), bool>) {
    return loops[mode](arguments...);
  } else {
    loops[mode](arguments...);
    return true;
  }
}

}  // namespace
}  // namespace cotorra
