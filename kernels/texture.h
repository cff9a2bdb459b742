// SPDX-License-Identifier: GPL-3.0-or-later
// Reads images: texels of any depth, the three filters, the four ways to go on outside, sRGB, as Cycles does each of
// them. Where coordinates come from is told in program/.
#ifndef COTORRA_TEXTURE_H
#define COTORRA_TEXTURE_H

#include "math.h"
#include "scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const float TEXEL_RANGE = 1e9f;  // coordinates beyond, in texels, and NaN count as 0

// sRGB decoded (IEC 61966-2-1). Above the linear part ((c + 0.055) / 1.055)^2.4 as x^2 times a polynomial of the fourth
// root, fitted to 4.3e-7 relative: a sixth of the time of pow, and the same bits on each device.
FN float srgb_decode_unit(float c) {
  const float x = (max(c, 0.0f) + 0.055f) * (1.0f / 1.055f);
  const float q = sqrt(sqrt(x));
  const float p = -0.0139422753f +
                  q * (0.253816187f + q * (1.03030944f + q * (-0.394730717f + q * (0.152997285f + q * -0.02845003f))));
  return select(c < 0.04045f, max(c, 0.0f) * (1.0f / 12.92f), x * x * p);
}
FN float srgb_decode(float c) { return c > 1.0f ? pow((c + 0.055f) * (1.0f / 1.055f), 2.4f) : srgb_decode_unit(c); }

// Bytes of a number.
FN uint texel_bytes(uint format) { return format == TEXELS_UINT8 ? 1u : (format == TEXELS_FLOAT ? 4u : 2u); }

// A half float from its 16 bits; infinity and NaN become numbers of 65536 and above.
FN float float_from_half(uint h) {
  const float normal = uintBitsToFloat(((h & 0x7fffu) << 13) + 0x38000000u);  // the exponent's bias, 127 for 15
  const float subnormal = float(int(h & 0x3ffu)) * 5.9604644775390625e-8f;
  const float magnitude = select((h & 0x7c00u) == 0u, subnormal, normal);
  return select((h & 0x8000u) != 0u, -magnitude, magnitude);
}

// Number i of the image, counting channels.
FN float texture_component(IN(Texture) t, uint i) {
  if (t.format == TEXELS_UINT8) {
    return float(int((LOAD(t.texels, i >> 2) >> ((i & 3u) * 8u)) & 255u)) * (1.0f / 255.0f);
  }
  if (t.format == TEXELS_FLOAT) {
    const float value = uintBitsToFloat(LOAD(t.texels, i));
    return select(abs(value) < INFINITE_DISTANCE, value, 0.0f);
  }
  const uint bits = (LOAD(t.texels, i >> 1) >> ((i & 1u) * 16u)) & 65535u;
  return t.format == TEXELS_HALF ? float_from_half(bits) : float(int(bits)) * (1.0f / 65535.0f);
}

// Texel in column x and row y as RGBA; 0 where either is -1.
FN vec4 texture_texel(IN(Texture) t, int x, int y) {
  if (x < 0 || y < 0) return vec4(0.0f, 0.0f, 0.0f, 0.0f);
  const uint i = (uint(y) * t.width + uint(x)) * t.channels;
  if (t.channels == 4u && t.format == TEXELS_UINT8) {
    const uint word = LOAD(t.texels, i >> 2);
    return vec4(float(int(word & 255u)), float(int((word >> 8) & 255u)), float(int((word >> 16) & 255u)),
                float(int(word >> 24))) *
           (1.0f / 255.0f);
  }
  const float r = texture_component(t, i);
  if (t.channels == 1u) return vec4(r, r, r, 1.0f);
  const float second = texture_component(t, i + 1u);
  if (t.channels == 2u) return vec4(r, r, r, second);
  const float b = texture_component(t, i + 2u);
  return vec4(r, second, b, t.channels == 4u ? texture_component(t, i + 3u) : 1.0f);
}

// Where to read texel i of a row or column of n, which may lie outside; -1: nowhere.
FN int texture_wrap(int i, int n, uint extension) {
  if (i >= 0 && i < n) return i;
  if (extension == EXTENSION_CLIP) return -1;
  if (extension == EXTENSION_EXTEND) return clamp(i, 0, n - 1);
  const bool mirrored = extension == EXTENSION_MIRROR;
  const int period = mirrored ? 2 * n : n;
  // The remainder of a negative number is undefined in GLSL: count from -1 downwards.
  const int m = i >= 0 ? i % period : period - 1 - (-1 - i) % period;
  return m < n ? m : period - 1 - m;
}

// Splits a coordinate in texels into the texel below and the way to the next.
FN int texture_split(float x, OUT(float) fraction) {
  const float safe = select(abs(x) < TEXEL_RANGE, x, 0.0f);
  const float low = floor(safe);
  fraction = safe - low;
  return int(low);
}

// The cubic B-spline at distance t from the second of four texels.
FN vec4 cubic_weights(float t) {
  const float a = 1.0f / 6.0f;
  return vec4(((-a * t + 0.5f) * t - 0.5f) * t + a, (0.5f * t - 1.0f) * t * t + 4.0f * a,
              ((-0.5f * t + 0.5f) * t + 0.5f) * t + a, a * t * t * t);
}

// Weights of the texels of a row or column: one, two or four, by the way to the next texel.
FN vec4 texture_weights(uint interpolation, float fraction) {
  if (interpolation == INTERPOLATION_LINEAR) return vec4(1.0f - fraction, fraction, 0.0f, 0.0f);
  if (interpolation == INTERPOLATION_CUBIC) return cubic_weights(fraction);
  return vec4(1.0f, 0.0f, 0.0f, 0.0f);
}

FN float texture_weight(vec4 weights, int i) {
  return select(i == 0, weights.x, select(i == 1, weights.y, select(i == 2, weights.z, weights.w)));
}

// Texels of a row or column that a filter takes.
FN int texture_taps(uint interpolation) {
  return select(interpolation == INTERPOLATION_LINEAR, 2, select(interpolation == INTERPOLATION_CUBIC, 4, 1));
}

// The first texel that a filter takes, which may lie outside, and the way to the next one from that before the point.
struct TexturePlace {
  int x;
  int y;
  float fx;
  float fy;
};

// (0, 0) is the image's lower left corner, (1, 1) its upper right one.
FN TexturePlace texture_place(IN(Texture) t, vec2 st, uint interpolation) {
  const int taps = texture_taps(interpolation);
  // Texels have their values at their centres.
  const float centre = select(taps == 1, 0.0f, 0.5f);
  const int before = select(taps == 4, 1, 0);
  TexturePlace p;
  p.x = texture_split(st.x * float(int(t.width)) - centre, p.fx) - before;
  p.y = texture_split(st.y * float(int(t.height)) - centre, p.fy) - before;
  return p;
}

// The image at a place, filtered. One loop for all filters, since compilers for graphics cards copy what is called to
// each place that calls it.
FN vec4 texture_gather(IN(Texture) t, IN(TexturePlace) p, uint interpolation, uint extension) {
  const int taps = texture_taps(interpolation);
  const vec4 wx = texture_weights(interpolation, p.fx);
  const vec4 wy = texture_weights(interpolation, p.fy);
  vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
  for (int j = 0; j < taps; ++j) {
    const int row = texture_wrap(p.y + j, int(t.height), extension);
    vec4 line = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    for (int i = 0; i < taps; ++i) {
      line = line + texture_texel(t, texture_wrap(p.x + i, int(t.width), extension), row) * texture_weight(wx, i);
    }
    sum = sum + line * texture_weight(wy, j);
  }
  return sum;
}

FN vec4 texture_filtered(IN(Texture) t, vec2 st, uint interpolation, uint extension) {
  return texture_gather(t, texture_place(t, st, interpolation), interpolation, extension);
}

// A colour divided by its alpha, where that is asked for and can be.
FN vec3 texture_straight(bool unassociate, vec4 c) {
  const bool divide = unassociate && c.w != 0.0f;
  return vec3(c.x, c.y, c.z) * (1.0f / select(divide, c.w, 1.0f));
}

// A filtered texel, linear, with its colour divided by its alpha where that is asked for.
FN vec4 texture_linear(IN(Texture) t, bool unassociate, vec4 c) {
  const vec3 rgb = texture_straight(unassociate, c);
  if (t.srgb == 0u) return vec4(rgb.x, rgb.y, rgb.z, c.w);
  return vec4(srgb_decode(rgb.x), srgb_decode(rgb.y), srgb_decode(rgb.z), c.w);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
