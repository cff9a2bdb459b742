// SPDX-License-Identifier: GPL-3.0-or-later
// Checks the exporter's camera, and derives the axes, the window and the table of the pixel filter.
#include "camera_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace cotorra {
namespace {

// A pixel filter at a place in its support, -1..1.
double filter_weight(const std::string &filter, double place) {
  if (filter == "BOX") return 1.0;
  if (filter == "GAUSSIAN") return std::exp(-18.0 * place * place);
  const double phase = std::numbers::pi * (place + 1.0);
  return 0.35875 - 0.48829 * std::cos(phase) + 0.14128 * std::cos(2.0 * phase) - 0.01168 * std::cos(3.0 * phase);
}

}  // namespace

void require(bool good, const std::string &name, const std::string &value, const char *expected) {
  if (!good) throw std::invalid_argument(name + " = " + value + ", must be " + expected);
}

float filter_reach(const std::string &filter) {
  if (filter == "BOX") return 0.5f;
  if (filter == "GAUSSIAN") return 1.5f;
  require(filter == "BLACKMAN_HARRIS", "camera.filter", "'" + filter + "'", "BOX, GAUSSIAN or BLACKMAN_HARRIS");
  return 1.0f;
}

std::vector<float> make_filter_table(const std::string &filter) {
  constexpr int kSteps = 8192;
  std::vector<double> cdf(kSteps + 1, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    const double place = 2.0 * (i + 0.5) / kSteps - 1.0;
    cdf[static_cast<std::size_t>(i) + 1] = cdf[static_cast<std::size_t>(i)] + filter_weight(filter, place);
  }
  std::vector<float> table(2 * FILTER_TABLE_SIZE);
  std::size_t j = 0;
  for (std::size_t i = 0; i < FILTER_TABLE_SIZE; ++i) {
    const double part = static_cast<double>(i) / (FILTER_TABLE_SIZE - 1);
    table[FILTER_TABLE_SIZE + i] = static_cast<float>(filter_weight(filter, part));
    const double target = cdf.back() * part;
    while (j + 2 < cdf.size() && cdf[j + 1] < target) ++j;
    const double t = std::clamp((target - cdf[j]) / (cdf[j + 1] - cdf[j]), 0.0, 1.0);
    table[i] = static_cast<float>(2.0 * (static_cast<double>(j) + t) / kSteps - 1.0);
  }
  return table;
}

CameraData camera_data(const CameraInput &in) {
  const auto &m = in.transform;
  CameraData c{};
  c.x_axis = {m[0], m[4], m[8]};
  c.y_axis = {m[1], m[5], m[9]};
  c.z_axis = {m[2], m[6], m[10]};
  c.origin = {m[3], m[7], m[11]};
  c.kind = in.orthographic ? CAMERA_ORTHOGRAPHIC : CAMERA_PERSPECTIVE;
  c.window_left = in.window[0];
  c.window_bottom = in.window[2];
  c.pixel_width = (in.window[1] - in.window[0]) / static_cast<float>(in.resolution[0]);
  c.pixel_height = (in.window[3] - in.window[2]) / static_cast<float>(in.resolution[1]);
  c.clip_start = in.clip[0];
  c.clip_end = in.clip[1];
  c.filter_radius = in.filter_width * filter_reach(in.filter);
  return c;
}

void see_from(const CameraData &c, const CameraInput &in, SceneData &scene) {
  const auto row = [&](vec3 axis) { return vec4(axis, -dot(axis, c.origin)); };
  scene.camera_space = {row(c.x_axis), row(c.y_axis), row(-c.z_axis), c.origin, 0};
  scene.camera_window = {c.window_left, c.window_bottom, 1.0f / (in.window[1] - in.window[0]),
                         1.0f / (in.window[3] - in.window[2])};
  scene.camera_orthographic = in.orthographic ? 1u : 0u;
  scene.camera_spread = 0.5f * (std::abs(c.pixel_width) + std::abs(c.pixel_height));
  scene.camera_near = c.clip_start;
}

const CameraInput &checked(const CameraInput &c) {
  require(c.resolution[0] > 0 && c.resolution[1] > 0, "camera.resolution",
          std::to_string(c.resolution[0]) + " x " + std::to_string(c.resolution[1]), "positive");
  require(c.region[2] > 0 && c.region[3] > 0 && c.region[0] >= 0 && c.region[1] >= 0, "camera.region",
          std::to_string(c.region[2]) + " x " + std::to_string(c.region[3]), "positive");
  for (const float v : c.transform) require(std::isfinite(v), "camera.transform", std::to_string(v), "finite");
  for (const float v : c.window) require(std::isfinite(v), "camera.window", std::to_string(v), "finite");
  require(c.clip[0] < c.clip[1], "camera.clip", std::to_string(c.clip[0]) + " to " + std::to_string(c.clip[1]),
          "increasing");
  return c;
}

}  // namespace cotorra
