// SPDX-License-Identifier: GPL-3.0-or-later
// Worley's cells in one to four dimensions (Worley 1996): nearest and second point, smooth minimum (Quilez 2014), way
// to the edge, radius of the free sphere. One octave, of one point; sums of octaves are in voronoi_fractal.h.
#ifndef COTORRA_PROGRAM_VORONOI_H
#define COTORRA_PROGRAM_VORONOI_H

#include "elementary.h"
#include "hash.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint VORONOI_F1 = 0u;
const uint VORONOI_F2 = 1u;
const uint VORONOI_SMOOTH_F1 = 2u;
const uint VORONOI_EDGE = 3u;
const uint VORONOI_N_SPHERE = 4u;

const uint METRIC_EUCLIDEAN = 0u;
const uint METRIC_MANHATTAN = 1u;
const uint METRIC_CHEBYCHEV = 2u;
const uint METRIC_MINKOWSKI = 3u;

const float VORONOI_FAR = 3.0e38f;
const float VORONOI_LARGEST = 1.0e18f;  // distance by a metric whose exponent is next to 0, where it has no bound

// The cell that a point lies in. What lies beyond the dimensions in use is 0.
struct VoronoiCell {
  int x;
  int y;
  int z;
  int w;
};

// What an octave finds: the point's distance, its cell's colour, its position in the octave's coordinates.
struct VoronoiPoint {
  float distance;
  vec3 color;
  vec4 position;
};

// The nearest two points of the cells around; cells are counted as voronoi_neighbour does. Bounds grow with distance.
struct VoronoiNearest {
  float bound1;
  float bound2;
  int cell1;
  int cell2;
};

FN vec4 voronoi_low(uint dimensions, vec4 p) {
  return vec4(floor(p.x), dimensions > 1u ? floor(p.y) : 0.0f, dimensions > 2u ? floor(p.z) : 0.0f,
              dimensions > 3u ? floor(p.w) : 0.0f);
}

FN VoronoiCell voronoi_cell(vec4 low) {
  VoronoiCell c;
  c.x = floor_int(low.x);
  c.y = floor_int(low.y);
  c.z = floor_int(low.z);
  c.w = floor_int(low.w);
  return c;
}

// Number of cells in a block of `side` cells along each axis.
FN int voronoi_block(uint dimensions, int side) {
  const int square = side * side;
  if (dimensions == 1u) return side;
  return dimensions == 2u ? square : (dimensions == 3u ? square * side : square * square);
}

// The cell with the given number in the block around `c`; x runs first. Integers wrap around at their ends.
FN VoronoiCell voronoi_neighbour(uint dimensions, IN(VoronoiCell) c, int number, int side) {
  const int half_side = side / 2;
  VoronoiCell n;
  n.x = int(uint(c.x) + uint(number % side - half_side));
  n.y = dimensions > 1u ? int(uint(c.y) + uint(number / side % side - half_side)) : 0;
  n.z = dimensions > 2u ? int(uint(c.z) + uint(number / (side * side) % side - half_side)) : 0;
  n.w = dimensions > 3u ? int(uint(c.w) + uint(number / (side * side * side) - half_side)) : 0;
  return n;
}

// Where in its cell the cell's point is, 0 ... 1 along each axis.
FN vec4 voronoi_jitter(uint dimensions, IN(VoronoiCell) c) {
  if (dimensions == 1u) return vec4(hash_float(float(c.x)), 0.0f, 0.0f, 0.0f);
  if (dimensions == 2u) {
    const vec2 a = pcg2(c.x, c.y);
    return vec4(a.x, a.y, 0.0f, 0.0f);
  }
  if (dimensions == 3u) return vec4(pcg3(c.x, c.y, c.z), 0.0f);
  return pcg4(c.x, c.y, c.z, c.w);
}

FN vec3 voronoi_color(uint dimensions, IN(VoronoiCell) c) {
  if (dimensions == 1u) return hash_float_to_vec3(float(c.x));
  if (dimensions < 4u) return pcg3(c.x, c.y, c.z);
  const vec4 a = pcg4(c.x, c.y, c.z, c.w);
  return vec3(a.x, a.y, a.z);
}

// The point of cell n as seen from the corner of cell c.
FN vec4 voronoi_at(uint dimensions, IN(VoronoiCell) c, IN(VoronoiCell) n, float randomness) {
  const vec4 offset = vec4(float(int(uint(n.x) - uint(c.x))), float(int(uint(n.y) - uint(c.y))),
                           float(int(uint(n.z) - uint(c.z))), float(int(uint(n.w) - uint(c.w))));
  return offset + voronoi_jitter(dimensions, n) * randomness;
}

// A number that grows with the distance, as cheap as it may be. One dimension knows one metric.
FN float voronoi_bound(uint dimensions, uint metric, float exponent, vec4 d) {
  const float x = abs(d.x);
  const float y = abs(d.y);
  const float z = abs(d.z);
  const float w = abs(d.w);
  if (dimensions == 1u) return x;
  if (metric == METRIC_EUCLIDEAN) return dot(d, d);
  if (metric == METRIC_MANHATTAN) return x + y + z + w;
  if (metric == METRIC_CHEBYCHEV) return max(max(x, y), max(z, w));
  return pow(x, exponent) + pow(y, exponent) + (dimensions > 2u ? pow(z, exponent) : 0.0f) +
         (dimensions > 3u ? pow(w, exponent) : 0.0f);
}

FN float voronoi_distance(uint dimensions, uint metric, float exponent, vec4 d) {
  const float bound = voronoi_bound(dimensions, metric, exponent, d);
  if (dimensions == 1u || metric == METRIC_MANHATTAN || metric == METRIC_CHEBYCHEV) return bound;
  return metric == METRIC_EUCLIDEAN ? sqrt(bound) : min(pow(bound, 1.0f / exponent), VORONOI_LARGEST);
}

FN VoronoiNearest voronoi_nearest_begin(uint dimensions) {
  VoronoiNearest s;
  s.bound1 = VORONOI_FAR;
  s.bound2 = VORONOI_FAR;
  s.cell1 = voronoi_block(dimensions, 3) / 2;
  s.cell2 = s.cell1;
  return s;
}

// One cell of the block, as seen from `local` in cell c. A step of its own, for loops over lanes inside that over
// cells.
FN void voronoi_nearest_step(uint dimensions, uint metric, float exponent, float randomness, IN(VoronoiCell) c,
                             vec4 local, int number, INOUT(VoronoiNearest) s) {
  const VoronoiCell n = voronoi_neighbour(dimensions, c, number, 3);
  const float b = voronoi_bound(dimensions, metric, exponent, voronoi_at(dimensions, c, n, randomness) - local);
  const bool first = b < s.bound1;
  const bool second = b < s.bound2;
  s.cell2 = select(first, s.cell1, select(second, number, s.cell2));
  s.bound2 = select(first, s.bound1, select(second, b, s.bound2));
  s.cell1 = select(first, number, s.cell1);
  s.bound1 = select(first, b, s.bound1);
}

FN VoronoiNearest voronoi_nearest(uint dimensions, uint metric, float exponent, float randomness, IN(VoronoiCell) c,
                                  vec4 local) {
  VoronoiNearest s = voronoi_nearest_begin(dimensions);
  const int cells = voronoi_block(dimensions, 3);
  for (int number = 0; number < cells; ++number) {
    voronoi_nearest_step(dimensions, metric, exponent, randomness, c, local, number, s);
  }
  return s;
}

// What the point of the cell with the given number is.
FN VoronoiPoint voronoi_point(uint dimensions, uint metric, float exponent, float randomness, IN(VoronoiCell) c,
                              vec4 low, vec4 local, int number) {
  const VoronoiCell n = voronoi_neighbour(dimensions, c, number, 3);
  const vec4 at = voronoi_at(dimensions, c, n, randomness);
  VoronoiPoint result;
  result.distance = voronoi_distance(dimensions, metric, exponent, at - local);
  result.color = voronoi_color(dimensions, n);
  result.position = at + low;
  return result;
}

// The nearest or second point.
FN VoronoiPoint voronoi_ranked(uint feature, uint dimensions, uint metric, float exponent, float randomness, vec4 p) {
  const vec4 low = voronoi_low(dimensions, p);
  const VoronoiCell c = voronoi_cell(low);
  const VoronoiNearest s = voronoi_nearest(dimensions, metric, exponent, randomness, c, p - low);
  return voronoi_point(dimensions, metric, exponent, randomness, c, low, p - low,
                       feature == VORONOI_F2 ? s.cell2 : s.cell1);
}

FN VoronoiPoint voronoi_point_zero() {
  VoronoiPoint s;
  s.distance = 0.0f;
  s.color = vec3(0.0f, 0.0f, 0.0f);
  s.position = vec4(0.0f, 0.0f, 0.0f, 0.0f);
  return s;
}

// Mixes the point of one cell of a block of five cells a side in.
FN void voronoi_smooth_step(uint dimensions, uint metric, float exponent, float randomness, float smoothness,
                            IN(VoronoiCell) c, vec4 local, int number, INOUT(VoronoiPoint) s) {
  const VoronoiCell n = voronoi_neighbour(dimensions, c, number, 5);
  const vec4 at = voronoi_at(dimensions, c, n, randomness);
  const float d = voronoi_distance(dimensions, metric, exponent, at - local);
  const float h = number == 0 ? 1.0f : smoothstep01(0.5f + 0.5f * (s.distance - d) / smoothness);
  const float correction = smoothness * h * (1.0f - h);
  const float softer = correction / (1.0f + 3.0f * smoothness);
  s.distance = lerp(s.distance, d, h) - correction;
  s.color = lerp(s.color, voronoi_color(dimensions, n), h) + vec3(-softer);
  s.position = s.position + (at - s.position) * h - vec4(softer, softer, softer, softer);
}

// All points within two cells, mixed by a smooth minimum of their distances.
FN VoronoiPoint voronoi_smooth(uint dimensions, uint metric, float exponent, float randomness, float smoothness,
                               vec4 p) {
  const vec4 low = voronoi_low(dimensions, p);
  const VoronoiCell c = voronoi_cell(low);
  VoronoiPoint s = voronoi_point_zero();
  const int cells = voronoi_block(dimensions, 5);
  for (int number = 0; number < cells; ++number) {
    voronoi_smooth_step(dimensions, metric, exponent, randomness, smoothness, c, p - low, number, s);
  }
  s.position = s.position + low;
  return s;
}

// The point that edges are measured from. On a line it is the cell's own, the nearest or not.
FN vec4 voronoi_edge_begin(uint dimensions, float randomness, IN(VoronoiCell) c, vec4 local, int nearest) {
  const int from = dimensions == 1u ? 1 : nearest;
  return voronoi_at(dimensions, c, voronoi_neighbour(dimensions, c, from, 3), randomness) - local;
}

// `result`, or the distance to the plane halfway between the nearest point and that of one cell, if it is smaller.
FN float voronoi_edge_step(uint dimensions, float randomness, IN(VoronoiCell) c, vec4 local, vec4 nearest, int number,
                           float result) {
  const VoronoiCell n = voronoi_neighbour(dimensions, c, number, 3);
  const vec4 to = voronoi_at(dimensions, c, n, randomness) - local;
  const vec4 across = to - nearest;
  const float d2 = dot(across, across);
  const bool counts = dimensions == 1u ? number != 1 : d2 > 0.0001f;
  const float middle = dot((nearest + to) * 0.5f, across) / sqrt(select(d2 > 0.0f, d2, 1.0f));
  const float d = dimensions == 1u ? abs((nearest.x + to.x) * 0.5f) : middle;
  return select(counts, min(result, d), result);
}

// Distance to the plane halfway between the nearest point and one of its neighbours.
FN float voronoi_edge(uint dimensions, float randomness, vec4 p) {
  const vec4 low = voronoi_low(dimensions, p);
  const VoronoiCell c = voronoi_cell(low);
  const vec4 local = p - low;
  const VoronoiNearest s = voronoi_nearest(dimensions, METRIC_EUCLIDEAN, 0.0f, randomness, c, local);
  const vec4 nearest = voronoi_edge_begin(dimensions, randomness, c, local, s.cell1);
  float result = VORONOI_FAR;
  const int cells = voronoi_block(dimensions, 3);
  for (int number = 0; number < cells; ++number) {
    result = voronoi_edge_step(dimensions, randomness, c, local, nearest, number, result);
  }
  return result;
}

// Half the way from the nearest point to the point that is nearest to it.
FN float voronoi_n_sphere(uint dimensions, float randomness, vec4 p) {
  const vec4 low = voronoi_low(dimensions, p);
  const VoronoiCell c = voronoi_cell(low);
  const VoronoiNearest s = voronoi_nearest(dimensions, METRIC_EUCLIDEAN, 0.0f, randomness, c, p - low);
  const VoronoiCell centre = voronoi_neighbour(dimensions, c, s.cell1, 3);
  const vec4 at = voronoi_at(dimensions, c, centre, randomness);
  float nearest = VORONOI_FAR;
  const int cells = voronoi_block(dimensions, 3);
  for (int number = 0; number < cells; ++number) {
    const VoronoiCell n = voronoi_neighbour(dimensions, centre, number, 3);
    const vec4 d = at - voronoi_at(dimensions, c, n, randomness);
    nearest = select(number == cells / 2, nearest, min(nearest, dot(d, d)));
  }
  return sqrt(nearest) * 0.5f;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
