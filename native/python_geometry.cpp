// SPDX-License-Identifier: GPL-3.0-or-later
// The border of geometry with Python: arrays in, arrays out.
#include "python_geometry.h"

#include <nanobind/ndarray.h>

#include <memory>

#include "tangents.h"

namespace cotorra {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

template <class Scalar, int kColumns>
using Rows = nb::ndarray<const Scalar, nb::shape<-1, kColumns>, nb::c_contig, nb::device::cpu>;
using Tangents = nb::ndarray<nb::numpy, float, nb::shape<-1, 4>>;

template <class T, class Array>
std::span<const T> span_of(const Array &rows) {
  return {reinterpret_cast<const T *>(rows.data()), rows.shape(0)};
}

Tangents tangents(Rows<float, 3> positions, Rows<float, 3> normals, Rows<float, 2> uv, Rows<std::uint32_t, 3> vertices,
                  Rows<std::uint32_t, 3> corners) {
  auto made = std::make_unique<std::vector<vec4>>();
  {
    const nb::gil_scoped_release release;
    *made = corner_tangents({span_of<vec3>(positions), span_of<vec3>(normals), span_of<vec2>(uv),
                             span_of<uvec3>(vertices), span_of<uvec3>(corners)});
  }
  std::vector<vec4> *const kept = made.release();
  const nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<std::vector<vec4> *>(p); });
  return Tangents(&kept->data()->x, {kept->size(), 4}, owner);
}

}  // namespace

void register_geometry(nb::module_ &module) {
  module.def(
      "corner_tangents", &tangents, nb::arg("positions").noconvert(), nb::arg("normals").noconvert(),
      nb::arg("uv").noconvert(), nb::arg("vertices").noconvert(), nb::arg("corners").noconvert(),
      "Tangents as MikkTSpace defines them, (C, 4) float32: a unit vector along u and the sign of its bitangent;\n"
      "0, 0, 0 where uv gives no direction.\n"
      "positions: (V, 3) float32; normals, uv: (C, 3) and (C, 2) float32 by corner; vertices, corners: (T, 3)\n"
      "uint32 of the triangles. Raises ValueError where one of these has no entry.");
  module.def(
      "are_directions",
      [](Rows<float, 3> normals) {
        const nb::gil_scoped_release release;
        return are_directions(span_of<vec3>(normals));
      },
      nb::arg("normals").noconvert(), "Whether all of (N, 3) float32 are of about unit length; NaN is not.");
}

}  // namespace cotorra
