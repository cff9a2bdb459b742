// SPDX-License-Identifier: GPL-3.0-or-later
// Pixels to rays: perspective and orthographic cameras as Blender defines them, and the pixel filter.
// Sensor fit, shift and pixel aspect were turned into a window by the exporter.
#ifndef COTORRA_CAMERA_H
#define COTORRA_CAMERA_H

#include "scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint CAMERA_PERSPECTIVE = 0u;
const uint CAMERA_ORTHOGRAPHIC = 1u;
const uint FILTER_TABLE_SIZE = 1024u;

struct CameraData {
  vec3 origin;
  uint kind;
  vec3 x_axis;         // right, world space, unit
  float window_left;   // of pixel coordinate 0, on the plane at distance 1 or in metres
  vec3 y_axis;         // up
  float window_bottom;
  vec3 z_axis;         // backwards: the camera looks along -z_axis
  float pixel_width;   // window units a pixel
  float pixel_height;
  float clip_start;    // along the viewing axis
  float clip_end;
  float filter_radius; // pixels
};

struct CameraRay {
  vec3 origin;
  float t_min;
  vec3 direction;  // unit
  float t_max;
};

// Position in the pixel filter, in filter radii from the centre: the inverse of the filter's cumulative distribution.
FN float filter_sample(IN(FloatBuffer) table, float u) {
  const float x = u * float(FILTER_TABLE_SIZE - 1u);
  const int i = clamp(int(x), 0, int(FILTER_TABLE_SIZE) - 2);
  return mix(LOAD(table, i), LOAD(table, i + 1), x - float(i));
}

// The ray through pixel coordinates (x, y), pixel centres at .5, y upwards.
FN void camera_ray(IN(CameraData) camera, float x, float y, OUT(CameraRay) ray) {
  const float u = camera.window_left + x * camera.pixel_width;
  const float v = camera.window_bottom + y * camera.pixel_height;
  const vec3 offset = camera.x_axis * u + camera.y_axis * v;
  if (camera.kind == CAMERA_PERSPECTIVE) {
    const vec3 d = offset - camera.z_axis;
    const float len = sqrt(dot(d, d));  // = 1 / cosine with the viewing axis
    ray.origin = camera.origin;
    ray.direction = d * (1.0f / len);
    ray.t_min = camera.clip_start * len;
    ray.t_max = camera.clip_end * len;
  } else {
    ray.origin = camera.origin + offset;
    ray.direction = -camera.z_axis;
    ray.t_min = camera.clip_start;
    ray.t_max = camera.clip_end;
  }
}

// Distance of a point along the viewing axis: Blender's Depth.
FN float camera_depth(IN(CameraData) camera, vec3 position) { return dot(camera.origin - position, camera.z_axis); }

#ifdef __cplusplus
static_assert(sizeof(CameraData) == 80);
}  // namespace cotorra
#endif

#endif
