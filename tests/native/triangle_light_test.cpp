// SPDX-License-Identifier: GPL-3.0-or-later
// Points of a triangle that shines, over arrays, for test_triangle_light.py. What they must be like, that says.
#include <cstddef>
#include <cstdint>

namespace cotorra {
namespace {
constexpr std::uint32_t KERNEL_FEATURES = ~0u;
}
}  // namespace cotorra

#include "../../kernels/light/spherical_triangle.h"

using namespace cotorra;

extern "C" {

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
