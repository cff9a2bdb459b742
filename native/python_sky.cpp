// SPDX-License-Identifier: GPL-3.0-or-later
// The border of skies with Python: numbers in, arrays out. How they are computed is told in sky.cpp.
#include "python_sky.h"

#include <nanobind/ndarray.h>

#include <memory>

#include "sky.h"

namespace cotorra {
namespace {

namespace nb = nanobind;
using namespace nb::literals;
using Pixels = nb::ndarray<nb::numpy, float, nb::shape<kSkyHeight, kSkyWidth, 3>>;

nb::tuple sky(bool multiple, double sun_elevation, double sun_size, double altitude, double air, double aerosol,
              double ozone) {
  auto made = std::make_unique<Sky>();
  {
    const nb::gil_scoped_release release;
    *made = make_sky({multiple, sun_elevation, sun_size, altitude, air, aerosol, ozone});
  }
  Sky *const kept = made.release();
  const nb::capsule owner(kept, [](void *p) noexcept { delete static_cast<Sky *>(p); });
  const auto color = [](vec3 v) { return nb::make_tuple(v.x, v.y, v.z); };
  return nb::make_tuple(Pixels(&kept->pixels[0].x, {kSkyHeight, kSkyWidth, 3}, owner), color(kept->sun_low),
                        color(kept->sun_high));
}

}  // namespace

void register_sky(nb::module_ &module) {
  module.def(
      "sky", &sky, "multiple"_a, "sun_elevation"_a, "sun_size"_a, "altitude"_a, "air"_a, "aerosol"_a, "ozone"_a,
      "The sky of a Sky Texture, scattered once or often: (pixels (256, 512, 3) float32, sun_low, sun_high).\n"
      "Linear Rec.709, not clamped. Rows go from straight down to straight up, at the place\n"
      "0.5 + 0.5 * sign(e) * sqrt(|e| / (pi / 2)) of elevation e; the sun's azimuth is in the middle. The other\n"
      "two are the radiance of the lowest and the highest point of the sun's disc.");
}

}  // namespace cotorra
