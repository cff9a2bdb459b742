// SPDX-License-Identifier: GPL-3.0-or-later
// Ops of shading programs as loops over lanes, which g++ turns into vector code.
// What they cost is ops_bench.cpp's, and that they say what one lane says alone, test_ops.py's.
#define PROGRAM_LANES
#include "ops_lanes.h"

using namespace cotorra;

namespace {

#define OP_LOOP(NAME, EXPRESSION)                                      \
  __attribute__((flatten, noinline)) void NAME##_lanes(Lanes &lanes) { \
    for (int i = 0; i < LANES; ++i) lanes.out[i] = EXPRESSION;         \
  }
OPS(OP_LOOP)

struct FractalLanes {
  float x[LANES], y[LANES], z[LANES], value[LANES], amplitude[LANES], frequency[LANES], total[LANES], partial[LANES];
};

Fractal load(const FractalLanes &from, int i) {
  Fractal s = fractal_begin(vec4(from.x[i], from.y[i], from.z[i], 0.0f));
  s.value = from.value[i];
  s.amplitude = from.amplitude[i];
  s.frequency = from.frequency[i];
  s.total = from.total[i];
  s.partial = from.partial[i];
  return s;
}

void store(FractalLanes &to, int i, const Fractal &s) {
  to.x[i] = s.p.x;
  to.y[i] = s.p.y;
  to.z[i] = s.p.z;
  to.value[i] = s.value;
  to.amplitude[i] = s.amplitude;
  to.frequency[i] = s.frequency;
  to.total[i] = s.total;
  to.partial[i] = s.partial;
}

FractalInputs inputs(const Lanes &lanes, int i) { return fractal_inputs(lanes.detail[i], 0.5f, 2.0f, 0.0f, 0.0f); }

// As many octaves as the lane that wants most.
__attribute__((flatten, noinline)) void noise_lanes(Lanes &lanes) {
  static FractalLanes s;
  int octaves = 0;
  for (int i = 0; i < LANES; ++i) octaves = max(octaves, fractal_octaves(lanes.detail[i]));
  for (int i = 0; i < LANES; ++i) store(s, i, fractal_begin(noise_coordinates(3u, P, 0.0f, SCALE)));
  for (int octave = 0; octave < octaves; ++octave) {
    for (int i = 0; i < LANES; ++i) {
      Fractal one = load(s, i);
      fractal_octave(NOISE_FBM, 3u, inputs(lanes, i), octave, one);
      store(s, i, one);
    }
  }
  for (int i = 0; i < LANES; ++i) lanes.out[i] = fractal_end(NOISE_FBM, true, inputs(lanes, i), load(s, i));
}

struct PhasorLanes {
  float x[LANES], y[LANES];
};

__attribute__((flatten, noinline)) void gabor_step_lanes(const Lanes &lanes, int n, PhasorLanes &sum) {
  for (int i = 0; i < LANES; ++i) {
    const vec2 p = vec2(lanes.x[i] * SCALE, lanes.y[i] * SCALE);
    const vec2 one = gabor_step_2d(n, p, 2.0f, 0.0f, 0.7f);
    sum.x[i] += one.x;
    sum.y[i] += one.y;
  }
}

void gabor_lanes(Lanes &lanes) {
  static PhasorLanes sum;
  sum = PhasorLanes{};
  for (int n = 0; n < 9 * GABOR_IMPULSES; ++n) gabor_step_lanes(lanes, n, sum);
  for (int i = 0; i < LANES; ++i) lanes.out[i] = gabor_end(0u, vec2(sum.x[i], sum.y[i]));
}

}  // namespace

void run_lanes(int op, Lanes &lanes) {
#define ENTRY(NAME, EXPRESSION) NAME##_lanes,
  static void (*const loops[])(Lanes &) = {OPS(ENTRY) STEPPED_OPS(ENTRY)};
  loops[op](lanes);
}
