// SPDX-License-Identifier: GPL-3.0-or-later
// Textures that are made of a few formulas: white noise, waves, magic, gradients, checkers and bricks.
// Textures of octaves and cells have files of their own.
#ifndef COTORRA_PROGRAM_PATTERNS_H
#define COTORRA_PROGRAM_PATTERNS_H

#include "math_ops.h"
#include "noise_fractal.h"

#ifdef __cplusplus
namespace cotorra {
#endif

FN float op_white_noise_f(uint mode, vec3 v, float w) {
  if (mode == 0u) return hash_float(w);
  if (mode == 1u) return hash_float2(v.x, v.y);
  return mode == 2u ? hash_float3(v) : hash_float4(vec4(v, w));
}

FN vec3 op_white_noise_v(uint mode, vec3 v, float w) {
  if (mode == 0u) return hash_float_to_vec3(w);
  if (mode == 1u) return hash_float2_to_vec3(v.x, v.y);
  return mode == 2u ? hash_float3_to_vec3(v) : hash_float4_to_vec3(vec4(v, w));
}

// Coordinates on a cell's border fall into the cell above it on each device: moved up a little, and shrunk.
FN vec3 off_the_border(vec3 p) { return (p + 0.000001f) * 0.999999f; }

// The angle of a wave at p: along a direction, or by the distance from an axis or the origin.
FN float wave_angle(uint mode, vec3 p) {
  const uint bands = (mode >> 1) & 3u;
  const uint rings = (mode >> 3) & 3u;
  if ((mode & 1u) == 0u) {
    if (bands == 3u) return (p.x + p.y + p.z) * 10.0f;
    return (bands == 0u ? p.x : (bands == 1u ? p.y : p.z)) * 20.0f;
  }
  const vec3 r = vec3(rings == 0u ? 0.0f : p.x, rings == 1u ? 0.0f : p.y, rings == 2u ? 0.0f : p.z);
  return sqrt(dot(r, r)) * 20.0f;
}

FN FractalInputs wave_inputs(float detail, float roughness) {
  return fractal_inputs(detail, roughness, 2.0f, 0.0f, 0.0f);
}

FN float wave_noise(float fractal) { return fractal * 2.0f - 1.0f; }

FN float wave_distortion(vec3 p, float detail, float scale, float roughness) {
  return wave_noise(noise_fractal(NOISE_FBM, 3u, true, wave_inputs(detail, roughness), vec4(p * scale, 0.0f)));
}

FN float wave_profile(uint mode, float angle) {
  const uint profile = (mode >> 5) & 3u;
  if (profile == 0u) return 0.5f + 0.5f * sin_lanes(angle - HALF_PI);
  const float turns = angle / TWO_PI;
  return profile == 1u ? fraction(turns) : abs(turns - floor(turns + 0.5f)) * 2.0f;
}

// The wave at an angle that `noise` bends.
FN float wave_bent(uint mode, float angle, float distortion, float noise) {
  return wave_profile(mode, distortion != 0.0f ? angle + distortion * noise : angle);
}

FN float op_wave_f(uint mode, vec3 vector, float scale, float distortion, float detail, float detail_scale,
                   float detail_roughness, float phase) {
  const vec3 p = off_the_border(vector * scale);
  float noise = 0.0f;
  if (distortion != 0.0f) noise = wave_distortion(p, detail, detail_scale, detail_roughness);
  return wave_bent(mode, wave_angle(mode, p) + phase, distortion, noise);
}

// Step n of ten that turn one of three numbers by the others.
FN vec3 magic_step(uint n, vec3 a, float distortion) {
  switch (n) {
    case 0u:
      return vec3(a.x, -cos_lanes(a.x - a.y + a.z) * distortion, a.z);
    case 1u:
      return vec3(cos_lanes(a.x - a.y - a.z) * distortion, a.y, a.z);
    case 2u:
      return vec3(a.x, a.y, sin_lanes(-a.x - a.y - a.z) * distortion);
    case 3u:
      return vec3(-cos_lanes(-a.x + a.y - a.z) * distortion, a.y, a.z);
    case 4u:
      return vec3(a.x, -sin_lanes(-a.x + a.y + a.z) * distortion, a.z);
    case 5u:
      return vec3(a.x, -cos_lanes(-a.x + a.y + a.z) * distortion, a.z);
    case 6u:
      return vec3(cos_lanes(a.x + a.y + a.z) * distortion, a.y, a.z);
    case 7u:
      return vec3(a.x, a.y, sin_lanes(a.x + a.y - a.z) * distortion);
    case 8u:
      return vec3(-cos_lanes(-a.x - a.y + a.z) * distortion, a.y, a.z);
    default:
      return vec3(a.x, -sin_lanes(a.x - a.y + a.z) * distortion, a.z);
  }
}

FN vec3 magic_begin(uint depth, vec3 vector, float scale, float distortion) {
  const float x = remainder_truncated(vector.x * scale, TWO_PI);
  const float y = remainder_truncated(vector.y * scale, TWO_PI);
  const float z = remainder_truncated(vector.z * scale, TWO_PI);
  const vec3 a = vec3(sin_lanes((x + y + z) * 5.0f), cos_lanes((-x + y - z) * 5.0f), -cos_lanes((-x - y + z) * 5.0f));
  return depth > 0u ? a * distortion : a;
}

FN vec3 magic_end(vec3 a, float distortion) {
  const float scaled = select(distortion != 0.0f, 1.0f / (2.0f * select(distortion != 0.0f, distortion, 1.0f)), 1.0f);
  return 0.5f - a * scaled;
}

FN uint magic_depth(uint mode) { return min(mode, 10u); }

FN vec3 op_magic_v(uint mode, vec3 vector, float scale, float distortion) {
  vec3 a = magic_begin(magic_depth(mode), vector, scale, distortion);
  for (uint n = 0u; n < magic_depth(mode); ++n) a = magic_step(n, a, distortion);
  return magic_end(a, distortion);
}

FN float gradient_shape(uint mode, vec3 p) {
  const float r = max(0.999999f - sqrt(dot(p, p)), 0.0f);
  switch (mode) {
    case 0u:
      return p.x;
    case 1u:
      return sqr(max(p.x, 0.0f));
    case 2u:
      return smoothstep01(p.x);
    case 3u:
      return (p.x + p.y) * 0.5f;
    case 4u:
      return angle_of(p.y, p.x) / TWO_PI + 0.5f;
    case 5u:
      return r * r;
    default:
      return r;
  }
}

FN float op_gradient_f(uint mode, vec3 p) { return saturate(gradient_shape(mode, p)); }

FN float parity(float a) {
  const float low = floor(a);
  return low - 2.0f * floor(low * 0.5f);
}

FN float op_checker_f(uint, vec3 vector, float scale) {
  const vec3 p = off_the_border(vector * scale);
  return parity(parity(p.x) + parity(p.y) + parity(p.z));
}

// 0 ... 1 by the number of a brick: two rounds of a polynomial modulo 2^31 (Elias's integer noise).
FN float brick_random(uint n) {
  const uint a = (n + 1013u) & 0x7fffffffu;
  const uint b = a ^ (a >> 13);
  const uint c = (b * (b * b * 60493u + 19990303u) + 1376312589u) & 0x7fffffffu;
  return float(int(c)) * (1.0f / 2147483648.0f);
}

FN bool divides(uint frequency, int row) {
  const int magnitude = max(row, -row);
  return frequency != 0u && magnitude % int(max(frequency, 1u)) == 0;
}

// x is how much mortar there is, y the tint of the brick.
FN vec3 op_brick_f(uint mode, vec3 vector, float scale, float mortar_size, float mortar_smooth, float bias, float width,
                   float height, float offset, float squash) {
  const uint offset_frequency = mode & 255u;
  const uint squash_frequency = (mode >> 8) & 255u;
  const vec3 p = vector * scale;
  const int row = floor_int(safe_divide(p.y, height));
  const bool uneven = offset_frequency != 0u && squash_frequency != 0u;
  const float length_x = width * (uneven && divides(squash_frequency, row) ? squash : 1.0f);
  const float shift = uneven && divides(offset_frequency, row) ? length_x * offset : 0.0f;
  const int column = floor_int(safe_divide(p.x + shift, length_x));
  const float x = (p.x + shift) - length_x * float(column);
  const float y = p.y - height * float(row);
  const float tint = saturate(brick_random((uint(row) << 16) + (uint(column) & 65535u)) + bias);
  // Of bricks without a length, only the joints between rows count; rows without a height are mortar (as Cycles).
  const float along = length_x == 0.0f ? LARGEST_INT_FLOAT : min(x, length_x - x);
  const float border = height == 0.0f ? -LARGEST_INT_FLOAT : min(along, min(y, height - y));
  const float depth = 1.0f - safe_divide(border, mortar_size);
  const bool hard = mortar_smooth == 0.0f || mortar_size == 0.0f;
  const float soft = hard ? 1.0f : smoothstep01(safe_divide(depth, mortar_smooth));
  return vec3(select(border >= mortar_size, 0.0f, soft), tint, 0.0f);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
