// SPDX-License-Identifier: GPL-3.0-or-later
// Computes the albedo tables of kernels/bsdf_tables.h and writes them as a C++ header; run by the build.
// It is no part of the module. The integrals are those that a Monte Carlo estimate with the kernels' sampling has.
#include <cmath>
#include <cstdio>
#include <vector>

namespace {
constexpr unsigned KERNEL_FEATURES = 0;
}
#include "bsdf_tables.h"

namespace cotorra {
namespace {

// Normals are taken from a rank-1 lattice with the golden ratio: a grid would align with the horizon, where the
// integrands jump. Of their disk, the rim within about alpha2 leads to the horizon; t = sqrt(1 - r^2) resolves it.
constexpr unsigned NORMALS = 16384;

// One direction above the surface from which light comes.
struct Reflection {
  float cos_half;     // between half vector and viewer
  float probability;  // that a sampled normal leads here
  float weight;       // G2 / G1
};

// Directions that the viewer at cosine mu sees in a GGX surface of the roughness.
std::vector<Reflection> reflections(float roughness, float mu) {
  const float alpha = roughness * roughness;
  const float alpha2 = alpha * alpha;
  const vec3 o(std::sqrt(1.0f - mu * mu), 0.0f, mu);
  if (alpha2 <= MIRROR_ALPHA2) return {{mu, 1.0f, 1.0f}};
  std::vector<Reflection> result;
  result.reserve(NORMALS);
  const float s_o = S_SmithGGX(mu, alpha2);
  for (unsigned i = 0; i < NORMALS; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(NORMALS);
    const double turns = static_cast<double>(i) * 0.6180339887498949;
    // Half a turn suffices: the other half mirrors it.
    const float phi = PI * static_cast<float>(turns - std::floor(turns));
    const float r = std::sqrt(1.0f - t * t);
    const vec3 h = half_vector_GGX(o, alpha, s_o, vec2(r * std::cos(phi), r * std::sin(phi)));
    const float inv_length = 1.0f / std::sqrt(max(dot(h, h), 1e-30f));
    const float c = min(dot(o, h) * inv_length, 1.0f);
    const float ni = 2.0f * c * h.z * inv_length - mu;
    if (ni <= 0.0f) continue;
    const float g2 = V_SmithGGXCorrelated(mu, s_o, ni, S_SmithGGX(ni, alpha2)) * ni;
    result.push_back({c, 2.0f * t / static_cast<float>(NORMALS), g2 / V_SmithGGXVisible(mu, s_o)});
  }
  return result;
}

float reflectance(float roughness, float mu) {
  double sum = 0.0;
  for (const Reflection &r : reflections(roughness, mu)) sum += static_cast<double>(r.probability * r.weight);
  return static_cast<float>(sum);
}

// Mean over the cosine-weighted hemisphere: the integral of 2 mu reflectance(mu), by the midpoint rule.
float reflectance_mean(float roughness) {
  constexpr unsigned STEPS = 64;
  double sum = 0.0;
  for (unsigned i = 0; i < STEPS; ++i) {
    const float mu = (static_cast<float>(i) + 0.5f) / static_cast<float>(STEPS);
    sum += static_cast<double>(2.0f * mu * reflectance(roughness, mu));
  }
  return static_cast<float>(sum / STEPS);
}

// Mean of weight(cos_half) where the light does not go below the surface.
template <class Weight>
float fresnel_mean(const std::vector<Reflection> &all, Weight weight) {
  double sum = 0.0;
  for (const Reflection &r : all) sum += static_cast<double>(r.probability * weight(r.cos_half));
  return static_cast<float>(sum);
}

// A node of an axis; the ends stay away from the limits, where nothing is defined.
float node(unsigned i, unsigned nodes, float last = 1.0f) {
  return clamp(static_cast<float>(i) / static_cast<float>(nodes - 1), 1e-4f, last);
}

std::vector<float> make_tables() {
  std::vector<float> table(ALBEDO_SIZE);
  for (unsigned y = 0; y < ALBEDO_NODES; ++y) {
    const float roughness = node(y, ALBEDO_NODES);
    for (unsigned x = 0; x < ALBEDO_NODES; ++x) {
      table[ALBEDO_REFLECTANCE + y * ALBEDO_NODES + x] = reflectance(roughness, node(x, ALBEDO_NODES));
    }
    table[ALBEDO_REFLECTANCE_MEAN + y] = reflectance_mean(roughness);
  }
  constexpr unsigned N = ALBEDO_FRESNEL_NODES;
  for (unsigned y = 0; y < N; ++y) {
    for (unsigned x = 0; x < N; ++x) {
      const std::vector<Reflection> all = reflections(node(y, N), node(x, N));
      // Cycles reads its table of exponents 5 (1 - z) / z midway between the nodes 7/15 and 8/15.
      table[ALBEDO_SCHLICK + y * N + x] = fresnel_mean(all, [](float c) {
        return 0.5f * (std::pow(1.0f - c, 5.0f * 8.0f / 7.0f) + std::pow(1.0f - c, 5.0f * 7.0f / 8.0f));
      });
      for (unsigned z = 0; z < N; ++z) {
        const float a = node(z, N, 0.99f);
        const float f0 = a * a * a * a;
        const float eta = (1.0f + a * a) / (1.0f - a * a);
        table[ALBEDO_DIELECTRIC + (z * N + y) * N + x] = fresnel_mean(
            all, [=](float c) { return clamp((F_Dielectric(c, c * c, eta) - f0) / (1.0f - f0), 0.0f, 1.0f); });
      }
    }
  }
  return table;
}

}  // namespace
}  // namespace cotorra

int main(int argc, char **argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_albedo_tables HEADER\n");
    return 2;
  }
  const std::vector<float> table = cotorra::make_tables();
  std::FILE *file = std::fopen(argv[1], "w");
  if (file == nullptr) {
    std::perror(argv[1]);
    return 1;
  }
  std::fprintf(file,
               "// Written by make_albedo_tables; see kernels/bsdf_tables.h.\n#pragma once\n\nnamespace cotorra {\n");
  std::fprintf(file, "inline constexpr unsigned albedo_table_size = %zu;\n", table.size());
  std::fprintf(file, "inline constexpr float albedo_tables[albedo_table_size] = {\n");
  for (const float value : table) std::fprintf(file, "%.7ef,\n", static_cast<double>(value));
  std::fprintf(file, "};\n}  // namespace cotorra\n");
  return std::fclose(file) == 0 ? 0 : 1;
}
