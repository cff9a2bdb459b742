// SPDX-License-Identifier: GPL-3.0-or-later
// Colours of light, linear Rec.709: of a black body and of one wavelength, as Cycles computes them.
// What lamps do with a temperature is the exporter's.
#ifndef COTORRA_PROGRAM_SPECTRUM_H
#define COTORRA_PROGRAM_SPECTRUM_H

#include "elementary.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// A Laurent polynomial of the temperature in thousands of kelvin: a ... d times x^-4 ... x^-1, then e + f x + g x^2 +
// h x^3. Fitted to what Cycles 5.2 renders between 800 K and 12000 K, to 8e-4; colours are constant outside.
FN float blackbody_channel(float x, vec4 low, vec4 high) {
  const float u = 1.0f / x;
  const float negative = (((low.x * u + low.y) * u + low.z) * u + low.w) * u;
  return max(negative + high.x + x * (high.y + x * (high.z + x * high.w)), 0.0f);
}

FN vec3 op_blackbody(uint, float kelvin) {
  const float x = clamp(kelvin * 0.001f, 0.8f, 12.0f);
  const vec3 inside = vec3(blackbody_channel(x, vec4(0.53768754f, -2.26482034f, 2.15580177f, 3.97453928f),
                                             vec4(0.148207739f, 0.0536893904f, -0.00306613301f, 7.63970456e-05f)),
                           blackbody_channel(x, vec4(-0.544090569f, 1.85267377f, -1.98263836f, -0.538179457f),
                                             vec4(1.29482937f, -0.0466441251f, 0.00335835083f, -9.70405017e-05f)),
                           blackbody_channel(x, vec4(4.58509254f, -13.967083f, 15.7079811f, -7.75647736f),
                                             vec4(1.07128084f, 0.208021715f, -0.0148478253f, 0.000395042676f)));
  const vec3 above = vec3(0.826424658f, 0.994484186f, 1.56593144f);
  return select(kelvin < 800.0f, vec3(5.41415453f, 0.0f, 0.0f), select(kelvin >= 12000.0f, above, inside));
}

// The CIE 1931 standard observer every 5 nm from 380 nm, in linear Rec.709, divided by 2.52, which keeps it below 1.
const int WAVELENGTHS = 81;
// clang-format off
const float WAVELENGTH_RGB[243] = {
    0.00051f, -0.00043f, 0.00276f, 0.00069f, -0.00060f, 0.00444f, 0.00136f, -0.00121f, 0.00852f, 0.00249f, -0.00218f, 0.01534f,
    0.00471f, -0.00408f, 0.02876f, 0.00767f, -0.00666f, 0.04669f, 0.01418f, -0.01242f, 0.08785f, 0.02499f, -0.02209f, 0.15727f,
    0.04267f, -0.03807f, 0.27343f, 0.06620f, -0.06005f, 0.43998f, 0.08389f, -0.07771f, 0.58649f, 0.09111f, -0.08708f, 0.68663f,
    0.08823f, -0.08803f, 0.73862f, 0.07680f, -0.08231f, 0.75295f, 0.05857f, -0.07180f, 0.74762f, 0.03551f, -0.05809f, 0.73468f,
    0.00712f, -0.03966f, 0.70168f, -0.02450f, -0.01637f, 0.64050f, -0.05898f, 0.01382f, 0.53701f, -0.09209f, 0.04635f, 0.43103f,
    -0.12271f, 0.08011f, 0.33186f, -0.15061f, 0.11389f, 0.24603f, -0.17779f, 0.15021f, 0.17899f, -0.20876f, 0.19268f, 0.12758f,
    -0.24457f, 0.24305f, 0.08805f, -0.28740f, 0.30578f, 0.05613f, -0.32621f, 0.37348f, 0.02585f, -0.35572f, 0.44341f, -0.00174f,
    -0.36721f, 0.50549f, -0.02327f, -0.35429f, 0.54927f, -0.03775f, -0.32138f, 0.57874f, -0.04842f, -0.27378f, 0.59476f, -0.05657f,
    -0.21254f, 0.59883f, -0.06229f, -0.13810f, 0.59164f, -0.06579f, -0.05135f, 0.57416f, -0.06732f, 0.04741f, 0.54756f, -0.06725f,
    0.15679f, 0.51212f, -0.06578f, 0.27494f, 0.46762f, -0.06310f, 0.39893f, 0.41561f, -0.05935f, 0.52472f, 0.35744f, -0.05474f,
    0.64735f, 0.29526f, -0.04948f, 0.76030f, 0.23131f, -0.04388f, 0.85788f, 0.16882f, -0.03816f, 0.93488f, 0.11089f, -0.03250f,
    0.98098f, 0.06121f, -0.02729f, 0.99884f, 0.01979f, -0.02254f, 0.98252f, -0.01117f, -0.01846f, 0.93767f, -0.03248f, -0.01491f,
    0.86637f, -0.04499f, -0.01189f, 0.77052f, -0.05004f, -0.00935f, 0.66452f, -0.04981f, -0.00727f, 0.56455f, -0.04688f, -0.00560f,
    0.46928f, -0.04200f, -0.00428f, 0.37971f, -0.03589f, -0.00322f, 0.29933f, -0.02939f, -0.00240f, 0.23149f, -0.02337f, -0.00178f,
    0.17486f, -0.01801f, -0.00130f, 0.12867f, -0.01341f, -0.00093f, 0.09288f, -0.00979f, -0.00066f, 0.06764f, -0.00719f, -0.00047f,
    0.04982f, -0.00534f, -0.00034f, 0.03505f, -0.00380f, -0.00024f, 0.02419f, -0.00263f, -0.00016f, 0.01684f, -0.00183f, -0.00011f,
    0.01216f, -0.00133f, -0.00008f, 0.00865f, -0.00096f, -0.00006f, 0.00618f, -0.00067f, -0.00004f, 0.00436f, -0.00046f, -0.00003f,
    0.00312f, -0.00037f, -0.00002f, 0.00215f, -0.00025f, -0.00001f, 0.00150f, -0.00017f, -0.00001f, 0.00104f, -0.00009f, -0.00001f,
    0.00078f, -0.00012f, 0.0f, 0.00052f, -0.00004f, -0.00001f, 0.00032f, -0.00004f, 0.0f, 0.00020f, 0.0f, 0.0f,
    0.00020f, 0.0f, 0.0f, 0.00013f, -0.00004f, 0.0f, 0.00013f, -0.00004f, 0.0f, 0.00013f, -0.00004f, 0.0f,
    0.0f, 0.0f, 0.0f
};
// clang-format on

// Black below 375 nm, where the first interval still goes on downwards, and from 780 nm.
FN vec3 op_wavelength(uint, float nanometres) {
  const float at = (nanometres - 380.0f) * 0.2f;
  const bool seen = at > -1.0f && at < float(WAVELENGTHS - 1);
  const float safe = select(seen, at, 0.0f);
  const int i = int(max(floor(safe), 0.0f));
  float ends[6];  // in one place: each that names the table has, in GLSL, a copy of it
  for (int k = 0; k < 6; ++k) ends[k] = WAVELENGTH_RGB[3 * i + k];
  const vec3 rgb = lerp(vec3(ends[0], ends[1], ends[2]), vec3(ends[3], ends[4], ends[5]), safe - float(i));
  return select(seen, max(rgb, vec3(0.0f, 0.0f, 0.0f)), vec3(0.0f, 0.0f, 0.0f));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
