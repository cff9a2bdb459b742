// SPDX-License-Identifier: GPL-3.0-or-later
// What ops of shading programs cost: each as a loop over lanes, as the CPU runs a batch, and one lane after the other.
// It prints a table, with the number of lanes whose bits differ, and returns 1 where a lane does.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>

#include "ops_lanes.h"

using namespace cotorra;

namespace {

Lanes lanes;
float alone[LANES];

#define ONE(NAME, EXPRESSION) \
  __attribute__((noinline)) float NAME##_one(int i) { return EXPRESSION; }
OPS(ONE)
STEPPED_OPS(ONE)

template <class Run>
double nanoseconds(Run run) {
  double best = 1e30;
  for (int trial = 0; trial < 5; ++trial) {
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - start;
    best = std::min(best, took.count() / LANES);
  }
  return best;
}

int row(int op, const char *name, float (*one)(int)) {
  const double in_lanes = nanoseconds([&] { run_lanes(op, lanes); });
  const double by_one = nanoseconds([&] {
    for (int i = 0; i < LANES; ++i) alone[i] = one(i);
  });
  int differ = 0;
  for (int i = 0; i < LANES; ++i) differ += alone[i] != lanes.out[i];
  std::printf("%-16s %8.1f %8.1f %6.1f  %d\n", name, in_lanes, by_one, by_one / in_lanes, differ);
  return differ;
}

}  // namespace

int main() {
  std::mt19937 random(1);
  const auto draw = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() >> 8) * 5.9604645e-8f;
  };
  for (int i = 0; i < LANES; ++i) {
    for (float *coordinate : {lanes.x, lanes.y, lanes.z}) coordinate[i] = draw(-10.0f, 10.0f);
    for (float *share : {lanes.a, lanes.b, lanes.c}) share[i] = draw(0.0f, 1.0f);
    lanes.scale[i] = 5.0f;
    lanes.detail[i] = 4.0f;
  }
  std::printf("%-16s %8s %8s %6s  %s\n", "op", "ns/lane", "alone", "ratio", "lanes that differ");
  int op = 0;
  int differ = 0;
#define ROW(NAME, EXPRESSION) differ += row(op++, #NAME, NAME##_one);
  OPS(ROW)
  STEPPED_OPS(ROW)
  return differ != 0;
}
