// SPDX-License-Identifier: GPL-3.0-or-later
// Gabor noise: a sum of windowed waves at random points (Lagae et al. 2009), with a fixed number of points a cell and
// weights of -1 or 1 (Tavernier et al. 2019), as a phasor (Tricard et al. 2019). Two and three dimensions, and the op.
#ifndef COTORRA_PROGRAM_GABOR_H
#define COTORRA_PROGRAM_GABOR_H

#include "hash.h"
#include "math_ops.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const int GABOR_IMPULSES = 8;  // points a cell

// A wave of phase `turns` within Gauss's bell and Hann's window, d2 from its centre; x is its cosine, y its sine.
FN vec2 gabor_kernel(float d2, float turns, float weight) {
  const float window = 0.5f + 0.5f * cos_lanes(PI * d2);
  const float size = exp_lanes(-PI * d2) * window * select(d2 < 1.0f, weight, 0.0f);
  const float angle = TWO_PI * turns;
  return vec2(size * cos_lanes(angle), size * sin_lanes(angle));
}

// Point number i of a cell, as seen from p within it. A seed has the cell and which of three draws it is.
FN vec2 gabor_impulse_2d(vec2 cell, int i, vec2 p, float frequency, float isotropy, float orientation) {
  const float draw = float(i * 3);
  const float turned = orientation + (hash_float3(vec3(cell.x, cell.y, draw)) - 0.5f) * PI * isotropy;
  const vec3 seed = vec3(cell.x, cell.y, draw + 1.0f);
  const vec2 d = p - vec2(hash_float3(seed), hash_float3(vec3(seed.z, seed.x, seed.y)));
  const float weight = select(hash_float3(vec3(cell.x, cell.y, draw + 2.0f)) < 0.5f, -1.0f, 1.0f);
  const float along = d.x * cos_lanes(turned) + d.y * sin_lanes(turned);
  return gabor_kernel(dot(d, d), frequency * along, weight);
}

// Impulse n of the cells around p: a step of its own, so that a loop over lanes can stand inside the loop over n.
FN vec2 gabor_step_2d(int n, vec2 p, float frequency, float isotropy, float orientation) {
  const vec2 low = vec2(floor(p.x), floor(p.y));
  const int block = n / GABOR_IMPULSES;
  const vec2 offset = vec2(float(block % 3 - 1), float(block / 3 - 1));
  return gabor_impulse_2d(low + offset, n % GABOR_IMPULSES, (p - low) - offset, frequency, isotropy, orientation);
}

FN vec2 gabor_2d(vec2 p, float frequency, float isotropy, float orientation) {
  vec2 sum = vec2(0.0f, 0.0f);
  for (int n = 0; n < 9 * GABOR_IMPULSES; ++n) sum = sum + gabor_step_2d(n, p, frequency, isotropy, orientation);
  return sum;
}

// A direction turned by two random angles, as far as the noise is isotropic.
FN vec3 gabor_direction(vec3 orientation, float isotropy, vec4 seed) {
  const float across = sqrt(orientation.x * orientation.x + orientation.y * orientation.y);
  const float theta = acos(clamp(orientation.z, -1.0f, 1.0f)) + hash_float4(seed) * PI * isotropy;
  const float azimuth = sign_nonzero(orientation.y) * acos(clamp(safe_divide(orientation.x, across), -1.0f, 1.0f));
  const float phi = azimuth + hash_float4(vec4(seed.z, seed.x, seed.w, seed.y)) * PI * isotropy;
  const float s = sin_lanes(theta);
  const vec3 turned = vec3(s * cos_lanes(phi), s * sin_lanes(phi), cos_lanes(theta));
  return select(isotropy == 0.0f, orientation, turned);
}

FN vec2 gabor_impulse_3d(vec3 cell, int i, vec3 p, float frequency, float isotropy, vec3 orientation) {
  const float draw = float(i * 3);
  const vec3 d = p - hash_float4_to_vec3(vec4(cell, draw + 1.0f));
  if (dot(d, d) >= 1.0f) return vec2(0.0f, 0.0f);  // most are: the angles below cost more than the branch
  const vec3 direction = gabor_direction(orientation, isotropy, vec4(cell, draw));
  const float weight = select(hash_float4(vec4(cell, draw + 2.0f)) < 0.5f, -1.0f, 1.0f);
  return gabor_kernel(dot(d, d), frequency * dot(d, direction), weight);
}

FN vec2 gabor_step_3d(int n, vec3 p, float frequency, float isotropy, vec3 orientation) {
  const vec3 low = floor(p);
  const int block = n / GABOR_IMPULSES;
  const vec3 offset = vec3(float(block % 3 - 1), float(block / 3 % 3 - 1), float(block / 9 - 1));
  return gabor_impulse_3d(low + offset, n % GABOR_IMPULSES, (p - low) - offset, frequency, isotropy, orientation);
}

FN vec2 gabor_3d(vec3 p, float frequency, float isotropy, vec3 orientation) {
  vec2 sum = vec2(0.0f, 0.0f);
  for (int n = 0; n < 27 * GABOR_IMPULSES; ++n) sum = sum + gabor_step_3d(n, p, frequency, isotropy, orientation);
  return sum;
}

// Outputs: 0 value, 1 phase, 2 intensity. Six standard deviations of the sum are the range -1 ... 1; its variance is
// half of the number of points times the integral of the squared kernel, which is 1/4, or 2^(-5/2) in space.
FN float gabor_end(uint mode, vec2 sum) {
  const bool in_space = (mode & 1u) != 0u;
  const uint output_kind = (mode >> 1) & 3u;
  if (output_kind == 1u) return (angle_of(sum.y, sum.x) + PI) / TWO_PI;
  const float integral = in_space ? 0.176776695f : 0.25f;
  const float range = 6.0f * sqrt(0.5f * float(GABOR_IMPULSES) * integral);
  return output_kind == 0u ? (sum.y / range) * 0.5f + 0.5f : sqrt(dot(sum, sum)) / range;
}

FN float op_gabor_f(uint mode, vec3 vector, float scale, float frequency, float anisotropy, float orientation_2d,
                    vec3 orientation_3d) {
  const vec3 p = vector * scale;
  const float isotropy = 1.0f - saturate(anisotropy);
  const float f = max(frequency, 0.001f);
  const bool in_space = (mode & 1u) != 0u;
  vec2 sum;
  if (in_space) {
    sum = gabor_3d(p, f, isotropy, normalize_or_zero(orientation_3d));
  } else {
    sum = gabor_2d(vec2(p.x, p.y), f, isotropy, orientation_2d);
  }
  return gabor_end(mode, sum);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
