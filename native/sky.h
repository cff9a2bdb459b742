// SPDX-License-Identifier: GPL-3.0-or-later
// The sky as a picture and its sun: light that the air scatters once (Nishita et al. 1993), or often by a fit
// (Garcia Linan 2022). How a Sky Texture shows them is told in addon/shader/nodes_sky.py.
#pragma once

#include <vector>

#include "../kernels/language_cpp.h"

namespace cotorra {

constexpr int kSkyWidth = 512;   // azimuth, the sun's in the middle
constexpr int kSkyHeight = 256;  // elevation, straight down in the lowest row; rows crowd at the horizon

// What scatters; densities are 1 on a clear day.
struct SkyInput {
  bool multiple = false;       // scattered often; else once
  double sun_elevation = 0.0;  // -pi/2 to pi/2
  double sun_size = 0.0;       // angle across the disc
  double altitude = 0.0;       // of the viewer above the sea, metres
  double air = 1.0, aerosol = 1.0, ozone = 1.0;
};

// Linear Rec.709, W/(m2 sr); colours outside of it have negative parts.
struct Sky {
  std::vector<vec3> pixels;     // [kSkyHeight][kSkyWidth]
  vec3 sun_low, sun_high;       // radiance of the lowest and the highest point of the disc
};

Sky make_sky(const SkyInput &input);

}  // namespace cotorra
