// SPDX-License-Identifier: GPL-3.0-or-later
// Samples of lights, what rays see of them, and how they fall off, over arrays, for test_area_sampling.py,
// test_light_sampling.py, test_triangle_light.py and the stability atlas. What they must be like, those say.
#include <cstddef>
#include <cstdint>

namespace cotorra {
namespace {
constexpr std::uint32_t KERNEL_FEATURES = ~0u;
}
}  // namespace cotorra

#include "../../kernels/light/light_shape.h"
#include "../../kernels/light/spherical_triangle.h"

using namespace cotorra;

extern "C" {

// One sample for each pair of random numbers, from p.
void test_samples(const Light *light, const vec3 *p, const vec2 *u, std::size_t count, LightSample *out) {
  for (std::size_t i = 0; i < count; ++i) light_sample(*light, *p, vec3(0.0f, 0.0f, 1.0f), u[i], out[i]);
}

// The same, each from a point of its own.
void test_samples_at(const Light *light, const vec3 *p, const vec2 *u, std::size_t count, LightSample *out) {
  for (std::size_t i = 0; i < count; ++i) light_sample(*light, p[i], vec3(0.0f, 0.0f, 1.0f), u[i], out[i]);
}

// What rays from p see: radiance, and the density of such samples; 0 where they miss.
void test_rays(const Light *light, const vec3 *p, const vec3 *d, std::size_t count, vec3 *radiance, float *pdf) {
  for (std::size_t i = 0; i < count; ++i) {
    if (light_intersect(*light, *p, d[i], INFINITE_DISTANCE, vec3(0.0f, 0.0f, 1.0f), radiance[i], pdf[i])) continue;
    radiance[i] = vec3(0.0f);
    pdf[i] = 0.0f;
  }
}

// Factors of lamps that fall off or end in another way than Blender's, for points p that see the lamp along wi.
void test_shapes(const LightShape *shape, const Light *light, const vec3 *p, const vec3 *wi, std::size_t count,
                 float *out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = light_shape(*shape, *light, p[i], wi[i]);
}

// corners: three, from the point. Returns the solid angle by which it is sampled, 0 where it is far.
float test_triangle(const vec3 *corners, const vec2 *u, std::size_t count, vec2 *b, float *pdf) {
  const vec3 edge1 = corners[1] - corners[0];
  const vec3 edge2 = corners[2] - corners[0];
  float twice_area;
  const vec3 normal = safe_normalize(cross(edge1, edge2), twice_area);
  TriangleView view;
  triangle_view(corners[0], edge1, edge2, view);
  for (std::size_t i = 0; i < count; ++i) {
    b[i] = triangle_light_sample(view, corners[0], edge1, edge2, u[i]);
    float distance;
    const vec3 wi = safe_normalize(corners[0] + edge1 * b[i].x + edge2 * b[i].y, distance);
    pdf[i] = triangle_light_pdf(view, twice_area, distance, abs(dot(normal, wi)));
  }
  return view.solid_angle;
}
}
