// SPDX-License-Identifier: GPL-3.0-or-later
// Ops that look values up in tables of the scene: colour ramps and curves, as Blender bakes them.
// Images are image_map.h's.
#ifndef COTORRA_PROGRAM_TABLE_OPS_H
#define COTORRA_PROGRAM_TABLE_OPS_H

#include "../scene_types.h"
#include "elementary.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint TABLE_FLAG = 1u;  // bit of the mode. Ramps: constant between entries; curves: straight lines outside
const int CURVE_ENTRIES = 257;  // as many as Cycles bakes

// Entry i of `count`, clamped, of a table of `stride` floats an entry from offset `at`.
FN float table_entry(IN(SceneData) scene, int at, int stride, int count, int i) {
  return LOAD(scene.tables, uint(at + stride * clamp(i, 0, count - 1)));
}

// The table at x, 0 being its first entry and 1 its last one.
FN float table_lookup(IN(SceneData) scene, int at, int stride, int count, bool interpolated, float x) {
  const float place = saturate(x) * float(count - 1);
  const float low = floor(select(place >= 0.0f, place, 0.0f));
  const int i = int(low);
  const float a = table_entry(scene, at, stride, count, i);
  const float b = table_entry(scene, at, stride, count, i + 1);
  const float t = interpolated ? place - low : 0.0f;
  return (1.0f - t) * a + t * b;
}

// The straight line through the table's last two entries on the side of x.
FN float table_beyond(IN(SceneData) scene, int at, int stride, int count, float x) {
  const bool before = x < 0.0f;
  const float end = table_entry(scene, at, stride, count, before ? 0 : count - 1);
  const float inner = table_entry(scene, at, stride, count, before ? 1 : count - 2);
  return end + (end - inner) * (before ? -x : x - 1.0f) * float(count - 1);
}

FN float ramp_channel(IN(SceneData) scene, uint mode, float factor, float table, float size, int channel) {
  return table_lookup(scene, int(table) + channel, 4, max(int(size), 1), (mode & TABLE_FLAG) == 0u, factor);
}

FN vec3 op_ramp_v(IN(SceneData) scene, uint mode, float factor, float table, float size) {
  return vec3(ramp_channel(scene, mode, factor, table, size, 0), ramp_channel(scene, mode, factor, table, size, 1),
              ramp_channel(scene, mode, factor, table, size, 2));
}

FN float op_ramp_alpha(IN(SceneData) scene, uint mode, float factor, float table, float size) {
  return ramp_channel(scene, mode, factor, table, size, 3);
}

// A curve of the value, mixed with the value itself.
FN float curve_channel(IN(SceneData) scene, uint mode, int at, int stride, float value, float low, float high,
                       float factor) {
  const float x = safe_divide(value - low, high - low);
  const bool outside = (mode & TABLE_FLAG) != 0u && (x < 0.0f || x > 1.0f);
  const float curved = outside ? table_beyond(scene, at, stride, CURVE_ENTRIES, x)
                               : table_lookup(scene, at, stride, CURVE_ENTRIES, true, x);
  return (1.0f - factor) * value + factor * curved;
}

FN float op_curve_f(IN(SceneData) scene, uint mode, float value, float table, float low, float high, float factor) {
  return curve_channel(scene, mode, int(table), 1, value, low, high, factor);
}

FN vec3 op_rgb_curve_v(IN(SceneData) scene, uint mode, vec3 color, float table, float low, float high, float factor) {
  const int at = int(table);
  return vec3(curve_channel(scene, mode, at, 3, color.x, low, high, factor),
              curve_channel(scene, mode, at + 1, 3, color.y, low, high, factor),
              curve_channel(scene, mode, at + 2, 3, color.z, low, high, factor));
}

FN vec3 op_vector_curve_v(IN(SceneData) scene, uint mode, vec3 vector, float table, float low, float high,
                          float factor) {
  return op_rgb_curve_v(scene, mode, vector, table, low, high, factor);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
