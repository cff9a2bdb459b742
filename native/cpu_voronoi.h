// SPDX-License-Identifier: GPL-3.0-or-later
// Worley's cells as loops over lanes inside the loops over octaves and cells, by Euclid's metric alone.
// Included by cpu_textures.cpp alone; what a cell adds is kernels/program/voronoi.h's.
#pragma once

#include "../kernels/program/voronoi_fractal.h"
#include "cpu_noise.h"

namespace cotorra {
namespace {

struct alignas(64) BlockInts {
  int v[kBlock];
  int &operator[](std::size_t i) { return v[i]; }
  const int &operator[](std::size_t i) const { return v[i]; }
};

// What the lanes keep: VoronoiInputs, VoronoiFractal, and of the octave the cell and what was found.
struct VoronoiLanes {
  BlockFloats scale, detail, roughness, lacunarity, smoothness, exponent, randomness, largest;
  PointLanes p;
  BlockFloats distance, red, green, blue, amplitude, frequency, total;
  PointLanes position;
  PointLanes low, local, edge;
  BlockInts x, y, z, w;
  BlockFloats bound1, bound2;
  BlockInts cell1, cell2;
  BlockFloats found_distance, found_red, found_green, found_blue;
  PointLanes found_position;

  VoronoiInputs inputs(std::size_t i) const {
    return {scale[i], detail[i], roughness[i], lacunarity[i], smoothness[i], exponent[i], randomness[i], largest[i]};
  }
  void set_inputs(std::size_t i, const VoronoiInputs &in) {
    scale[i] = in.scale;
    detail[i] = in.detail;
    roughness[i] = in.roughness;
    lacunarity[i] = in.lacunarity;
    smoothness[i] = in.smoothness;
    exponent[i] = in.exponent;
    randomness[i] = in.randomness;
    largest[i] = in.largest;
  }
  VoronoiFractal fractal(std::size_t i) const {
    return {distance[i], {red[i], green[i], blue[i]}, position.get<4>(i), amplitude[i], frequency[i], total[i]};
  }
  void set_fractal(std::size_t i, const VoronoiFractal &s) {
    distance[i] = s.distance;
    red[i] = s.color.x;
    green[i] = s.color.y;
    blue[i] = s.color.z;
    position.set<4>(i, s.position);
    amplitude[i] = s.amplitude;
    frequency[i] = s.frequency;
    total[i] = s.total;
  }
  template <uint kDimensions>
  VoronoiCell cell(std::size_t i) const {
    return {x[i], kDimensions > 1u ? y[i] : 0, kDimensions > 2u ? z[i] : 0, kDimensions > 3u ? w[i] : 0};
  }
  VoronoiNearest nearest(std::size_t i) const { return {bound1[i], bound2[i], cell1[i], cell2[i]}; }
  void set_nearest(std::size_t i, const VoronoiNearest &s) {
    bound1[i] = s.bound1;
    bound2[i] = s.bound2;
    cell1[i] = s.cell1;
    cell2[i] = s.cell2;
  }
  VoronoiPoint found(std::size_t i) const {
    return {found_distance[i], {found_red[i], found_green[i], found_blue[i]}, found_position.get<4>(i)};
  }
  void set_found(std::size_t i, const VoronoiPoint &s) {
    found_distance[i] = s.distance;
    found_red[i] = s.color.x;
    found_green[i] = s.color.y;
    found_blue[i] = s.color.z;
    found_position.set<4>(i, s.position);
  }
};

// By the dimensions less one.
template <uint kMode>
struct Voronoi {
  static constexpr uint kDimensions = kMode + 1u;

  template <uint kFeature>
  COTORRA_LOOP void begin(Columns a, int n, VoronoiLanes &s) {
    constexpr uint mode = (kDimensions - 1u) | kFeature << 2 | METRIC_EUCLIDEAN << 5;
    COTORRA_EACH {
      const VoronoiInputs in = voronoi_inputs(mode, a[4][i], a[5][i], a[6][i], a[7][i], a[8][i], a[9][i], a[10][i]);
      s.set_inputs(i, in);
      s.p.set<4>(i, voronoi_coordinates(kDimensions, column_vector(a, 0, i), a[3][i], a[4][i]));
      s.set_fractal(i, voronoi_begin(mode, in));
    }
  }
  COTORRA_LOOP void octave_begin(int n, VoronoiLanes &s) {
    COTORRA_EACH {
      const vec4 p = s.p.get<4>(i) * s.frequency[i];
      const vec4 low = voronoi_low(kDimensions, p);
      const VoronoiCell c = voronoi_cell(low);
      s.low.set<4>(i, low);
      s.local.set<4>(i, p - low);
      s.x[i] = c.x;
      s.y[i] = c.y;
      s.z[i] = c.z;
      s.w[i] = c.w;
      s.set_nearest(i, voronoi_nearest_begin(kDimensions));
      s.set_found(i, voronoi_point_zero());
    }
  }
  COTORRA_LOOP void nearest_step(int number, int n, VoronoiLanes &s) {
    COTORRA_EACH {
      VoronoiNearest one = s.nearest(i);
      voronoi_nearest_step(kDimensions, METRIC_EUCLIDEAN, s.exponent[i], s.randomness[i], s.cell<kDimensions>(i),
                           s.local.get<kDimensions>(i), number, one);
      s.set_nearest(i, one);
    }
  }
  template <bool kSecond>
  COTORRA_LOOP void ranked(int n, VoronoiLanes &s) {
    COTORRA_EACH s.set_found(
        i, voronoi_point(kDimensions, METRIC_EUCLIDEAN, s.exponent[i], s.randomness[i], s.cell<kDimensions>(i),
                         s.low.get<4>(i), s.local.get<4>(i), kSecond ? s.cell2[i] : s.cell1[i]));
  }
  // Without kWhole the distance alone.
  template <bool kWhole>
  COTORRA_LOOP void smooth_step(int number, int n, VoronoiLanes &s) {
    COTORRA_EACH {
      VoronoiPoint one = s.found(i);
      voronoi_smooth_step(kDimensions, METRIC_EUCLIDEAN, s.exponent[i], s.randomness[i], s.smoothness[i],
                          s.cell<kDimensions>(i), s.local.get<4>(i), number, one);
      if (kWhole) {
        s.set_found(i, one);
      } else {
        s.found_distance[i] = one.distance;
      }
    }
  }
  COTORRA_LOOP void smooth_end(int n, VoronoiLanes &s) {
    COTORRA_EACH s.found_position.set<4>(i, s.found_position.get<4>(i) + s.low.get<4>(i));
  }
  COTORRA_LOOP void edge_begin(int n, VoronoiLanes &s) {
    COTORRA_EACH {
      s.edge.set<4>(
          i, voronoi_edge_begin(kDimensions, s.randomness[i], s.cell<kDimensions>(i), s.local.get<4>(i), s.cell1[i]));
      s.found_distance[i] = VORONOI_FAR;
    }
  }
  COTORRA_LOOP void edge_step(int number, int n, VoronoiLanes &s) {
    COTORRA_EACH {
      s.found_distance[i] = voronoi_edge_step(kDimensions, s.randomness[i], s.cell<kDimensions>(i), s.local.get<4>(i),
                                              s.edge.get<4>(i), number, s.found_distance[i]);
    }
  }

  // What an octave finds, by the feature.
  static void find(uint feature, bool whole, int n, VoronoiLanes &s) {
    octave_begin(n, s);
    const int cells = voronoi_block(kDimensions, feature == VORONOI_SMOOTH_F1 ? 5 : 3);
    if (feature == VORONOI_SMOOTH_F1) {
      for (int number = 0; number < cells; ++number) {
        whole ? smooth_step<true>(number, n, s) : smooth_step<false>(number, n, s);
      }
      return smooth_end(n, s);
    }
    for (int number = 0; number < cells; ++number) nearest_step(number, n, s);
    if (feature == VORONOI_F1) return ranked<false>(n, s);
    if (feature == VORONOI_F2) return ranked<true>(n, s);
    edge_begin(n, s);
    for (int number = 0; number < cells; ++number) edge_step(number, n, s);
  }
};

template <uint kFeature>
struct VoronoiStep {
  COTORRA_LOOP void run(int octave, int n, VoronoiLanes &s) {
    COTORRA_EACH {
      VoronoiFractal one = s.fractal(i);
      voronoi_step(kFeature << 2, s.inputs(i), octave, s.found(i), one);
      s.set_fractal(i, one);
    }
  }
};

COTORRA_LOOP void end_number(uint mode, int n, const VoronoiLanes &s, Results out) {
  COTORRA_EACH out[0][i] = voronoi_end_number(mode, s.inputs(i), s.fractal(i));
}
COTORRA_LOOP void end_vector(uint mode, int n, const VoronoiLanes &s, Results out) {
  COTORRA_EACH store(out, i, voronoi_end_vector(mode, s.inputs(i), s.fractal(i)));
}

// Runs a block through all octaves. False, with nothing done, where the lanes do not agree on whether they are smooth.
template <uint kMode>
struct VoronoiBlock {
  static bool run(uint mode, bool vector, Columns a, int n, Results out) {
    using Loops = Voronoi<kMode>;
    static constexpr decltype(&Loops::template begin<0>) begins[] = {
        Loops::template begin<0>, Loops::template begin<1>, Loops::template begin<2>, Loops::template begin<3>};
    VoronoiLanes s;
    uint feature = voronoi_feature(mode);
    begins[feature](a, n, s);
    // 1. A smoothness of 0 is the nearest point.
    const auto sharp = std::count(s.smoothness.v, s.smoothness.v + n, 0.0f);
    if (feature == VORONOI_SMOOTH_F1 && sharp == n) feature = VORONOI_F1;
    if (feature == VORONOI_SMOOTH_F1 && sharp != 0) return false;
    // 2. As many octaves as the lane that wants most.
    const int octaves = most_octaves(s.detail, n);
    for (int octave = 0; octave < octaves; ++octave) {
      Loops::find(feature, vector || voronoi_output(mode) != 0u, n, s);
      feature == VORONOI_EDGE ? VoronoiStep<VORONOI_EDGE>::run(octave, n, s)
                              : VoronoiStep<VORONOI_F1>::run(octave, n, s);
    }
    vector ? end_vector(mode, n, s, out) : end_number(mode, n, s, out);
    return true;
  }
};

// Is there a loop for the mode?
inline bool voronoi_has_loop(uint mode, bool vector) {
  const uint feature = voronoi_feature(mode);
  const uint output = voronoi_output(mode);
  // One dimension knows one metric, and so do edges.
  if (voronoi_metric(mode) != METRIC_EUCLIDEAN && (mode & 3u) != 0u && feature != VORONOI_EDGE) return false;
  if (vector) return feature < VORONOI_EDGE;
  return output == 0u ? feature <= VORONOI_EDGE : output == 1u && feature < VORONOI_EDGE;
}

}  // namespace
}  // namespace cotorra
