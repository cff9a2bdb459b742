// SPDX-License-Identifier: GPL-3.0-or-later
// A camera: as the exporter gives it, and what kernels know of it. How its rays are made is kernels/'s.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "../kernels/scene_types.h"
#include "../kernels/camera.h"

namespace cotorra {

struct CameraInput {  // addon/export/buffers.py, Camera
  bool orthographic = false;
  std::array<float, 12> transform{};  // rows
  std::array<float, 4> window{};      // left, right, bottom, top
  std::array<float, 2> clip{};
  std::array<int, 2> resolution{};
  std::array<int, 4> region{};        // x0, y0, width, height
  std::string filter = "BLACKMAN_HARRIS";
  float filter_width = 1.5f;
};

// Throws std::invalid_argument, with the name and the value of an input that is not as expected.
void require(bool good, const std::string &name, const std::string &value, const char *expected);

// The camera itself, after it was found good.
const CameraInput &checked(const CameraInput &camera);

CameraData camera_data(const CameraInput &camera);
// What shaders know of the camera: its space, looking along +z, and how wide a pixel's rays are.
void see_from(const CameraData &data, const CameraInput &camera, SceneData &scene);

// Half the support of a pixel filter over its width, as Cycles has them.
float filter_reach(const std::string &filter);
// Of a pixel filter: the inverse cumulative distribution over -1..1, at uniform probabilities; and the filter itself,
// at places 0..1.
std::vector<float> make_filter_table(const std::string &filter);

}  // namespace cotorra
