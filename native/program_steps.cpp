// SPDX-License-Identifier: GPL-3.0-or-later
// Counts what the textures of a program visit: corners of noise, cells of Worley, impulses of Gabor, by octaves.
// What they compute there is kernels/program/'s.
#include "program_steps.h"

#include "every_feature.h"

#include "../kernels/integrator.h"
#include "program_walk.h"

namespace cotorra {
namespace {

// Loops of the CPU take about so many lanes at once; what has no loop takes a lane after the other.
constexpr double kLanes = 16.0;

double octaves(const ProgramInstruction &in, uint detail) {
  return static_cast<double>(fractal_octaves(in.argument(detail).value_or(NOISE_MAX_DETAIL)));
}

double corners(uint dimensions) { return static_cast<double>(1u << dimensions); }

double noise_steps(const ProgramInstruction &in, double channels) {
  const uint dimensions = noise_dimensions(in.mode);
  const double moved = in.argument(8) == 0.0f ? 0.0 : static_cast<double>(dimensions);
  return corners(dimensions) * (channels * octaves(in, 3) + moved);
}

double voronoi_steps(const ProgramInstruction &in) {
  const uint dimensions = voronoi_dimensions(in.mode), feature = voronoi_feature(in.mode);
  const bool smooth = feature == VORONOI_SMOOTH_F1 && in.argument(6) != 0.0f;
  const double cells = static_cast<double>(voronoi_block(dimensions, smooth ? 5 : 3));
  if (feature == VORONOI_N_SPHERE) return 2.0 * cells * kLanes;
  double each = 1.0;
  if (feature == VORONOI_EDGE) {
    each = 2.0;  // the nearest point is found first
  } else if (dimensions > 1u && voronoi_metric(in.mode) != METRIC_EUCLIDEAN) {
    each = kLanes;
    if (voronoi_metric(in.mode) == METRIC_MINKOWSKI) each *= dimensions;  // a power along each axis
  }
  return each * cells * octaves(in, 3);
}

double steps(const ProgramInstruction &in) {
  switch (in.op) {
    case OP_NOISE_F:
      return noise_steps(in, 1.0);
    case OP_NOISE_V:
      return noise_steps(in, 3.0);
    case OP_VORONOI_F:
    case OP_VORONOI_V:
      return voronoi_steps(in);
    case OP_WAVE_F:
      return in.argument(2) == 0.0f ? 1.0 : corners(3) * octaves(in, 3);
    case OP_GABOR_F:
      return static_cast<double>(GABOR_IMPULSES * voronoi_block((in.mode & 1u) + 2u, 3)) * kLanes;
    default:
      return 1.0;
  }
}

}  // namespace

double program_steps(const SceneData &scene, const ProgramPart &part, uint constants) {
  double sum = 0.0;
  each_instruction(scene, part, constants, [&](const ProgramInstruction &in) { sum += steps(in); });
  return sum;
}

}  // namespace cotorra
