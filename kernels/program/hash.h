// SPDX-License-Identifier: GPL-3.0-or-later
// The hashes that Blender's textures are made of: of integers and of the bits of floats, to integers and to 0 ... 1.
// They decide how a texture looks; samplers have their own generator (sampling.h).
#ifndef COTORRA_PROGRAM_HASH_H
#define COTORRA_PROGRAM_HASH_H

#include "../math.h"

#ifdef __cplusplus
namespace cotorra {
#endif

FN uint rotate_left(uint x, uint k) { return (x << k) | (x >> (32u - k)); }

// The last rounds of Bob Jenkins' lookup3 (public domain, 2006): all bits of a, b and c reach the result.
FN uint lookup3_final(uint a, uint b, uint c) {
  c = (c ^ b) - rotate_left(b, 14u);
  a = (a ^ c) - rotate_left(c, 11u);
  b = (b ^ a) - rotate_left(a, 25u);
  c = (c ^ b) - rotate_left(b, 16u);
  a = (a ^ c) - rotate_left(c, 4u);
  b = (b ^ a) - rotate_left(a, 14u);
  return (c ^ b) - rotate_left(b, 24u);
}

// lookup3 starts from this plus four times the number of words.
const uint LOOKUP3_START = 0xdeadbeefu + 13u;

FN uint lookup3_1(uint x) { return lookup3_final(LOOKUP3_START + 4u + x, LOOKUP3_START + 4u, LOOKUP3_START + 4u); }
FN uint lookup3_2(uint x, uint y) {
  return lookup3_final(LOOKUP3_START + 8u + x, LOOKUP3_START + 8u + y, LOOKUP3_START + 8u);
}
FN uint lookup3_3(uint x, uint y, uint z) {
  return lookup3_final(LOOKUP3_START + 12u + x, LOOKUP3_START + 12u + y, LOOKUP3_START + 12u + z);
}

// Three words are mixed in before the fourth is added.
FN uint lookup3_4(uint x, uint y, uint z, uint w) {
  uint a = LOOKUP3_START + 16u + x;
  uint b = LOOKUP3_START + 16u + y;
  uint c = LOOKUP3_START + 16u + z;
  a = (a - c) ^ rotate_left(c, 4u);
  c += b;
  b = (b - a) ^ rotate_left(a, 6u);
  a += c;
  c = (c - b) ^ rotate_left(b, 8u);
  b += a;
  a = (a - c) ^ rotate_left(c, 16u);
  c += b;
  b = (b - a) ^ rotate_left(a, 19u);
  a += c;
  c = (c - b) ^ rotate_left(b, 4u);
  b += a;
  return lookup3_final(a + w, b, c);
}

// 0 ... 1, both included. By halves, whose conversions are signed ones, which vector units have; rounded once.
FN float hash_unit(uint h) {
  const float rounded = float(int(h >> 16)) * 65536.0f + float(int(h & 65535u));
  return rounded * (1.0f / 4294967296.0f);
}

FN float hash_float(float x) { return hash_unit(lookup3_1(floatBitsToUint(x))); }
FN float hash_float2(float x, float y) { return hash_unit(lookup3_2(floatBitsToUint(x), floatBitsToUint(y))); }
FN float hash_float3(vec3 p) {
  return hash_unit(lookup3_3(floatBitsToUint(p.x), floatBitsToUint(p.y), floatBitsToUint(p.z)));
}
FN float hash_float4(vec4 p) {
  return hash_unit(lookup3_4(floatBitsToUint(p.x), floatBitsToUint(p.y), floatBitsToUint(p.z), floatBitsToUint(p.w)));
}

// Three numbers of what gives one: the same hash with another word added, or of the words in another order.
FN vec3 hash_float_to_vec3(float x) { return vec3(hash_float(x), hash_float2(x, 1.0f), hash_float2(x, 2.0f)); }
FN vec3 hash_float2_to_vec3(float x, float y) {
  return vec3(hash_float2(x, y), hash_float3(vec3(x, y, 1.0f)), hash_float3(vec3(x, y, 2.0f)));
}
FN vec3 hash_float3_to_vec3(vec3 p) {
  return vec3(hash_float3(p), hash_float4(vec4(p.x, p.y, p.z, 1.0f)), hash_float4(vec4(p.x, p.y, p.z, 2.0f)));
}
FN vec3 hash_float4_to_vec3(vec4 p) {
  return vec3(hash_float4(p), hash_float4(vec4(p.z, p.x, p.w, p.y)), hash_float4(vec4(p.w, p.z, p.y, p.x)));
}

// PCG in two, three and four dimensions (Jarzynski and Olano 2020), on signed integers: their shift keeps the sign.
const uint PCG_FACTOR = 1664525u;
const uint PCG_STEP = 1013904223u;
const float PCG_UNIT = 1.0f / 2147483648.0f;

FN uint pcg_fold(uint v) { return v ^ uint(int(v) >> 16); }
FN float pcg_float(uint v) { return float(int(v & 0x7fffffffu)) * PCG_UNIT; }

FN vec2 pcg2(int i, int j) {
  uint x = uint(i) * PCG_FACTOR + PCG_STEP;
  uint y = uint(j) * PCG_FACTOR + PCG_STEP;
  x += y * PCG_FACTOR;
  y += x * PCG_FACTOR;
  x = pcg_fold(x);
  y = pcg_fold(y);
  x += y * PCG_FACTOR;
  y += x * PCG_FACTOR;
  return vec2(pcg_float(x), pcg_float(y));
}

FN vec3 pcg3(int i, int j, int k) {
  uint x = uint(i) * PCG_FACTOR + PCG_STEP;
  uint y = uint(j) * PCG_FACTOR + PCG_STEP;
  uint z = uint(k) * PCG_FACTOR + PCG_STEP;
  x += y * z;
  y += z * x;
  z += x * y;
  x = pcg_fold(x);
  y = pcg_fold(y);
  z = pcg_fold(z);
  x += y * z;
  y += z * x;
  z += x * y;
  return vec3(pcg_float(x), pcg_float(y), pcg_float(z));
}

FN vec4 pcg4(int i, int j, int k, int l) {
  uint x = uint(i) * PCG_FACTOR + PCG_STEP;
  uint y = uint(j) * PCG_FACTOR + PCG_STEP;
  uint z = uint(k) * PCG_FACTOR + PCG_STEP;
  uint w = uint(l) * PCG_FACTOR + PCG_STEP;
  x += y * w;
  y += z * x;
  z += x * y;
  w += y * z;
  x = pcg_fold(x);
  y = pcg_fold(y);
  z = pcg_fold(z);
  w = pcg_fold(w);
  x += y * w;
  y += z * x;
  z += x * y;
  w += y * z;
  return vec4(pcg_float(x), pcg_float(y), pcg_float(z), pcg_float(w));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
