// SPDX-License-Identifier: GPL-3.0-or-later
// Ops that make colours of colours: HSV and HSL, hue and saturation, gamma, brightness, inversion.
// Two colours meet in mix.h; colours of light are spectrum.h's.
#ifndef COTORRA_PROGRAM_COLOR_OPS_H
#define COTORRA_PROGRAM_COLOR_OPS_H

#include "elementary.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// In sixths of the circle: 0 red, 2 green, 4 blue; -1 ... 5. `delta` is the largest component less the smallest.
FN float hue_sixths(vec3 rgb, float largest, float delta) {
  const float scale = safe_divide(1.0f, delta);
  const float red = (rgb.y - rgb.z) * scale;
  const float green = 2.0f + (rgb.z - rgb.x) * scale;
  const float blue = 4.0f + (rgb.x - rgb.y) * scale;
  return select(rgb.x == largest, red, select(rgb.y == largest, green, blue));
}

FN vec3 hsv_from_rgb(vec3 rgb) {
  const float largest = max(rgb.x, max(rgb.y, rgb.z));
  const float delta = largest - min(rgb.x, min(rgb.y, rgb.z));
  const float saturation = safe_divide(delta, largest);
  const float h = hue_sixths(rgb, largest, delta) / 6.0f;
  return vec3(select(saturation != 0.0f, select(h < 0.0f, h + 1.0f, h), 0.0f), saturation, largest);
}

// How far a channel lies below the value: 1 over a third of the circle, 0 over another one, ramps between.
FN float hue_dip(float sixths) { return saturate(min(sixths, 4.0f - sixths)); }

// Hues of 1 and of other numbers beyond the circle stay in its last sixth, as Blender has it.
FN vec3 rgb_from_hsv(vec3 hsv) {
  const float h = select(hsv.x == 1.0f, 0.0f, hsv.x) * 6.0f;
  const float low = floor(h);
  const float sixth = select(low >= 0.0f && low < 5.0f, low, 5.0f) + (h - low);
  const float dip = hsv.z * hsv.y;
  const float r = hue_dip(select(sixth >= 1.0f, sixth - 1.0f, sixth + 5.0f));
  const float g = hue_dip(select(sixth >= 3.0f, sixth - 3.0f, sixth + 3.0f));
  const float b = hue_dip(select(sixth >= 5.0f, sixth - 5.0f, sixth + 1.0f));
  return vec3(hsv.z - dip * r, hsv.z - dip * g, hsv.z - dip * b);
}

FN vec3 hsl_from_rgb(vec3 rgb) {
  const float largest = max(rgb.x, max(rgb.y, rgb.z));
  const float smallest = min(rgb.x, min(rgb.y, rgb.z));
  const float delta = largest - smallest;
  const float lightness = min(1.0f, (largest + smallest) * 0.5f);
  const float sum = select(lightness > 0.5f, 2.0f - largest - smallest, largest + smallest);
  const float h = hue_sixths(rgb, largest, delta);
  const float turned = select(rgb.x == largest && rgb.y < rgb.z, h + 6.0f, h);
  return vec3(select(delta != 0.0f, turned / 6.0f, 0.0f), safe_divide(delta, sum), lightness);
}

FN vec3 rgb_from_hsl(vec3 hsl) {
  const float sixths = hsl.x * 6.0f;
  const vec3 pure = vec3(saturate(abs(sixths - 3.0f) - 1.0f), saturate(2.0f - abs(sixths - 2.0f)),
                         saturate(2.0f - abs(sixths - 4.0f)));
  const float chroma = (1.0f - abs(2.0f * hsl.z - 1.0f)) * hsl.y;
  return (pure + -0.5f) * chroma + hsl.z;
}

// Modes: 0 RGB, 1 HSV, 2 HSL.
FN vec3 op_combine_color(uint mode, float a, float b, float c) {
  const vec3 color = vec3(a, b, c);
  return mode == 1u ? rgb_from_hsv(color) : (mode == 2u ? rgb_from_hsl(color) : color);
}

FN vec3 op_separate_color(uint mode, vec3 color) {
  return mode == 1u ? hsv_from_rgb(color) : (mode == 2u ? hsl_from_rgb(color) : color);
}

FN vec3 op_hsv(uint, float hue, float saturation, float value, float factor, vec3 color) {
  const vec3 hsv = hsv_from_rgb(color);
  const vec3 changed = rgb_from_hsv(vec3(fraction(hsv.x + hue + 0.5f), saturate(hsv.y * saturation), hsv.z * value));
  return max(changed * factor + color * (1.0f - factor), vec3(0.0f, 0.0f, 0.0f));
}

// Negative components stay as they are.
FN float gamma_component(float a, float gamma) { return select(a > 0.0f, pow(select(a > 0.0f, a, 1.0f), gamma), a); }

FN vec3 op_gamma(uint, vec3 color, float gamma) {
  const vec3 raised =
      vec3(gamma_component(color.x, gamma), gamma_component(color.y, gamma), gamma_component(color.z, gamma));
  return select(gamma == 0.0f, vec3(1.0f, 1.0f, 1.0f), raised);
}

FN vec3 op_bright_contrast(uint, vec3 color, float brightness, float contrast) {
  return max(color * (1.0f + contrast) + (brightness - contrast * 0.5f), vec3(0.0f, 0.0f, 0.0f));
}

FN vec3 op_invert(uint, vec3 color, float factor) { return (1.0f - color) * factor + color * (1.0f - factor); }

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
