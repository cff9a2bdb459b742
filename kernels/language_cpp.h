// SPDX-License-Identifier: GPL-3.0-or-later
// The GLSL types and built-in functions that the kernels use, for C++.
// Only what a kernel needs; GLSL has all of it already, so GLSL never sees this file.
#ifndef COTORRA_LANGUAGE_CPP_H
#define COTORRA_LANGUAGE_CPP_H

#include <bit>
#include <cmath>
#include <cstdint>

namespace cotorra {

// Internal linkage: one process holds builds of this for several instruction sets, and the linker must not merge them.
#define FN [[maybe_unused]] static inline

using uint = std::uint32_t;

struct vec2 {
  float x, y;
  vec2() = default;
  constexpr vec2(float x_, float y_) : x(x_), y(y_) {}
  constexpr explicit vec2(float s) : x(s), y(s) {}
};

struct vec3 {
  float x, y, z;
  vec3() = default;
  constexpr vec3(float x_, float y_, float z_) : x(x_), y(y_), z(z_) {}
  constexpr explicit vec3(float s) : x(s), y(s), z(s) {}
};

struct vec4 {
  float x, y, z, w;
  vec4() = default;
  constexpr vec4(float x_, float y_, float z_, float w_) : x(x_), y(y_), z(z_), w(w_) {}
  constexpr vec4(vec3 a, float w_) : x(a.x), y(a.y), z(a.z), w(w_) {}
};

struct uvec2 {
  uint x, y;
  uvec2() = default;
  constexpr uvec2(uint x_, uint y_) : x(x_), y(y_) {}
};

struct uvec3 {
  uint x, y, z;
  uvec3() = default;
  constexpr uvec3(uint x_, uint y_, uint z_) : x(x_), y(y_), z(z_) {}
};

static_assert(sizeof(vec2) == 8 && sizeof(vec3) == 12 && sizeof(vec4) == 16 && sizeof(uvec3) == 12);

FN vec2 operator+(vec2 a, vec2 b) { return {a.x + b.x, a.y + b.y}; }
FN vec2 operator-(vec2 a, vec2 b) { return {a.x - b.x, a.y - b.y}; }
FN vec2 operator*(vec2 a, vec2 b) { return {a.x * b.x, a.y * b.y}; }
FN vec2 operator*(vec2 a, float s) { return {a.x * s, a.y * s}; }
FN vec2 operator*(float s, vec2 a) { return {a.x * s, a.y * s}; }

FN vec3 operator+(vec3 a, vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
FN vec3 operator-(vec3 a, vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
FN vec3 operator-(vec3 a) { return {-a.x, -a.y, -a.z}; }
FN vec3 operator*(vec3 a, vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
FN vec3 operator*(vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
FN vec3 operator*(float s, vec3 a) { return {a.x * s, a.y * s, a.z * s}; }
FN vec3 operator/(vec3 a, vec3 b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
FN vec3 operator/(vec3 a, float s) { return {a.x / s, a.y / s, a.z / s}; }
FN vec3 operator+(vec3 a, float s) { return {a.x + s, a.y + s, a.z + s}; }
FN vec3 operator-(float s, vec3 a) { return {s - a.x, s - a.y, s - a.z}; }
FN vec3 &operator+=(vec3 &a, vec3 b) { return a = a + b; }
FN vec3 &operator*=(vec3 &a, vec3 b) { return a = a * b; }
FN vec3 &operator*=(vec3 &a, float s) { return a = a * s; }

FN vec4 operator+(vec4 a, vec4 b) { return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
FN vec4 operator-(vec4 a, vec4 b) { return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w}; }
FN vec4 operator*(vec4 a, float s) { return {a.x * s, a.y * s, a.z * s, a.w * s}; }

FN float dot(vec2 a, vec2 b) { return a.x * b.x + a.y * b.y; }
FN float dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
FN float dot(vec4 a, vec4 b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }
FN vec3 cross(vec3 a, vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

FN float sqrt(float a) { return __builtin_sqrtf(a); }
FN float abs(float a) { return __builtin_fabsf(a); }
FN float floor(float a) { return __builtin_floorf(a); }
FN float exp(float a) { return std::exp(a); }
FN float exp2(float a) { return std::exp2(a); }
FN float log(float a) { return std::log(a); }
FN float log2(float a) { return std::log2(a); }
FN float pow(float a, float b) { return std::pow(a, b); }
FN float sin(float a) { return std::sin(a); }
FN float cos(float a) { return std::cos(a); }
FN float tan(float a) { return std::tan(a); }
FN float asin(float a) { return std::asin(a); }
FN float acos(float a) { return std::acos(a); }
FN float atan(float a) { return std::atan(a); }
FN float atan(float y, float x) { return std::atan2(y, x); }
FN float sinh(float a) { return std::sinh(a); }
FN float cosh(float a) { return std::cosh(a); }
FN float tanh(float a) { return std::tanh(a); }
FN float ceil(float a) { return __builtin_ceilf(a); }
FN float trunc(float a) { return __builtin_truncf(a); }
FN float min(float a, float b) { return b < a ? b : a; }
FN float max(float a, float b) { return a < b ? b : a; }
FN uint min(uint a, uint b) { return b < a ? b : a; }
FN uint max(uint a, uint b) { return a < b ? b : a; }
FN int min(int a, int b) { return b < a ? b : a; }
FN int max(int a, int b) { return a < b ? b : a; }
FN float clamp(float a, float lo, float hi) { return min(max(a, lo), hi); }
FN int clamp(int a, int lo, int hi) { return min(max(a, lo), hi); }
FN float mix(float a, float b, float t) { return a * (1.0f - t) + b * t; }
FN float sign(float a) { return a > 0.0f ? 1.0f : (a < 0.0f ? -1.0f : 0.0f); }

FN vec3 abs(vec3 a) { return {abs(a.x), abs(a.y), abs(a.z)}; }
FN vec3 floor(vec3 a) { return {floor(a.x), floor(a.y), floor(a.z)}; }
FN vec3 sqrt(vec3 a) { return {sqrt(a.x), sqrt(a.y), sqrt(a.z)}; }
FN vec3 min(vec3 a, vec3 b) { return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)}; }
FN vec3 max(vec3 a, vec3 b) { return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)}; }
FN vec3 clamp(vec3 a, vec3 lo, vec3 hi) { return min(max(a, lo), hi); }
FN vec3 mix(vec3 a, vec3 b, float t) { return a * (1.0f - t) + b * t; }
FN vec3 mix(vec3 a, vec3 b, vec3 t) { return a * (1.0f - t) + b * t; }
FN float length(vec3 a) { return sqrt(dot(a, a)); }
FN vec3 normalize(vec3 a) { return a * (1.0f / sqrt(dot(a, a))); }

template <class T>
FN T select(bool condition, T if_true, T if_false) {
  return condition ? if_true : if_false;
}

// By components: a choice between two structs in memory would keep a loop from vectorising.
FN vec3 select(bool condition, vec3 a, vec3 b) {
  return {condition ? a.x : b.x, condition ? a.y : b.y, condition ? a.z : b.z};
}

FN uint floatBitsToUint(float a) { return std::bit_cast<uint>(a); }
FN int floatBitsToInt(float a) { return std::bit_cast<int>(a); }
FN float uintBitsToFloat(uint a) { return std::bit_cast<float>(a); }
FN float intBitsToFloat(int a) { return std::bit_cast<float>(a); }
FN int bitCount(uint a) { return std::popcount(a); }
FN int findLSB(uint a) { return a == 0 ? -1 : std::countr_zero(a); }
FN int findMSB(uint a) { return 31 - std::countl_zero(a); }
FN uint bitfieldReverse(uint a) {
  a = ((a & 0x55555555u) << 1) | ((a >> 1) & 0x55555555u);
  a = ((a & 0x33333333u) << 2) | ((a >> 2) & 0x33333333u);
  a = ((a & 0x0f0f0f0fu) << 4) | ((a >> 4) & 0x0f0f0f0fu);
  return __builtin_bswap32(a);
}

}  // namespace cotorra

#endif
