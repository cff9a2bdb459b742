// SPDX-License-Identifier: GPL-3.0-or-later
// Fields of the kernels' structs as arrays by lane. Included by cpu_kernel.cpp alone, after the kernels, so that each
// instruction set has its own.
#pragma once

#include <cstddef>
#include <cstdint>

#include "../kernels/integrator.h"
#include "cpu_vector.h"

namespace cotorra {
namespace {

constexpr int kLanes = 1024;  // paths of one batch

template <class T, std::size_t N>
struct alignas(64) Array {
  T items[N + 64 / sizeof(T) +
          1];  // a cache line more: arrays a page apart would share the same few lines of the cache
  T &operator[](std::size_t i) { return items[i]; }
  const T &operator[](std::size_t i) const { return items[i]; }
  T *data() { return items; }
  const T *data() const { return items; }
};
using Floats = Array<float, kLanes>;
template <std::size_t N>
struct VectorArray {
  Array<float, N> x, y, z;
  vec3 get(std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, vec3 v) {
    x[i] = v.x;
    y[i] = v.y;
    z[i] = v.z;
  }
};
using Vec3s = VectorArray<kLanes>;

}  // namespace
}  // namespace cotorra
