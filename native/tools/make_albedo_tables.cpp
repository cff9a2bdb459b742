// SPDX-License-Identifier: GPL-3.0-or-later
// Computes the tables of kernels/bsdf_tables.h and kernels/closure/lobe_tables.h and writes them as a C++ header; run
// by the build. It is no part of the module. The integrals are those that a Monte Carlo estimate with the kernels'
// sampling has.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <vector>

namespace {
constexpr unsigned KERNEL_FEATURES = 0;
}
#include "closure/lobe_tables.h"

namespace cotorra {
namespace {

// Normals are taken from a rank-1 lattice with the golden ratio: a grid would align with the horizon, where the
// integrands jump. Of their disk, the rim within about alpha2 leads to the horizon; t = sqrt(1 - r^2) resolves it.
constexpr unsigned NORMALS = 16384;
constexpr unsigned GLASS_NORMALS = 2048;

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

// Points of the lattice that reflections() takes, fewer.
struct LatticePoint {
  vec2 disk;
  float probability;
};
std::vector<LatticePoint> make_lattice() {
  std::vector<LatticePoint> lattice;
  for (unsigned i = 0; i < GLASS_NORMALS; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(GLASS_NORMALS);
    const double turns = static_cast<double>(i) * 0.6180339887498949;
    const float phi = PI * static_cast<float>(turns - std::floor(turns));
    const float r = std::sqrt(1.0f - t * t);
    lattice.push_back({vec2(r * std::cos(phi), r * std::sin(phi)), 2.0f * t / static_cast<float>(GLASS_NORMALS)});
  }
  return lattice;
}

// What rough glass reflects and refracts; as reflections(), but both ways from each facet, by Fresnel's share.
float glass(const std::vector<LatticePoint> &lattice, float roughness, float mu, float eta) {
  const float alpha = roughness * roughness;
  const float alpha2 = alpha * alpha;
  if (alpha2 <= MIRROR_ALPHA2) return 1.0f;
  const vec3 o(std::sqrt(1.0f - mu * mu), 0.0f, mu);
  const float s_o = S_SmithGGX(mu, alpha2);
  // G2 / G1 toward a direction of cosine ni on either side.
  const auto kept = [=](float ni) {
    return V_SmithGGXCorrelated(mu, s_o, ni, S_SmithGGX(ni, alpha2)) * ni / V_SmithGGXVisible(mu, s_o);
  };
  double sum = 0.0;
  for (const LatticePoint &at : lattice) {
    const vec3 h = half_vector_GGX(o, alpha, s_o, at.disk);
    const float inv_length = 1.0f / std::sqrt(max(dot(h, h), 1e-30f));
    const float c = min(dot(o, h) * inv_length, 1.0f);
    const float nh = h.z * inv_length;
    const float f = F_Dielectric(c, c * c, eta);
    const float reflected = 2.0f * c * nh - mu;
    float share = reflected > 0.0f ? f * kept(reflected) : 0.0f;
    const float cos2 = 1.0f - (1.0f - c * c) / (eta * eta);
    if (cos2 > 0.0f) {
      const float refracted = nh * (c / eta - std::sqrt(cos2)) - mu / eta;
      // Light that is not bent goes straight on, past every facet.
      const bool straight = std::abs(eta - 1.0f) < 1e-4f;
      // What a facet sends back up, out of denser matter at grazing angles, counts as well: Cycles' table has it,
      // though its sampling loses it, as ours does.
      share += (1.0f - f) * (straight ? 1.0f : kept(std::abs(refracted)));
    }
    sum += static_cast<double>(at.probability * share);
  }
  return min(static_cast<float>(sum), 1.0f);
}

void make_glass_tables(std::vector<float> &table) {
  constexpr unsigned N = ALBEDO_FRESNEL_NODES;
  constexpr unsigned STEPS = 32;
  const std::vector<LatticePoint> lattice = make_lattice();
  for (unsigned leaving = 0; leaving < 2; ++leaving) {
    for (unsigned z = 0; z < N; ++z) {
      const float a = node(z, N, 0.99f);
      const float ior = (1.0f + a * a) / (1.0f - a * a);
      const float eta = leaving != 0 ? 1.0f / ior : ior;
      for (unsigned y = 0; y < N; ++y) {
        for (unsigned x = 0; x < N; ++x) {
          const unsigned first = leaving != 0 ? TABLE_GLASS_LEAVING : TABLE_GLASS;
          table[first + (z * N + y) * N + x] = glass(lattice, node(y, N), node(x, N), eta);
        }
        double sum = 0.0;
        for (unsigned i = 0; i < STEPS; ++i) {
          const float mu = (static_cast<float>(i) + 0.5f) / static_cast<float>(STEPS);
          sum += static_cast<double>(2.0f * mu * glass(lattice, node(y, N), mu, eta));
        }
        const unsigned means = leaving != 0 ? TABLE_GLASS_LEAVING_MEAN : TABLE_GLASS_MEAN;
        table[means + z * N + y] = static_cast<float>(sum / STEPS);
      }
    }
  }
}

// The CIE 1931 standard observer, x y z every 10 nm from 380 nm on (CIE 015, table of the 2 degree observer).
constexpr double OBSERVER_FIRST = 380.0;
constexpr double OBSERVER_STEP = 10.0;
constexpr double OBSERVER[][3] = {
    {0.001368, 3.9e-05, 0.00645}, {0.004243, 0.00012, 0.02005}, {0.01431, 0.000396, 0.06785},
    {0.04351, 0.00121, 0.2074},   {0.13438, 0.004, 0.6456},     {0.2839, 0.0116, 1.3856},
    {0.34828, 0.023, 1.74706},    {0.3362, 0.038, 1.77211},     {0.2908, 0.06, 1.6692},
    {0.19536, 0.09098, 1.28764},  {0.09564, 0.13902, 0.81295},  {0.03201, 0.20802, 0.46518},
    {0.0049, 0.323, 0.272},       {0.0093, 0.503, 0.1582},      {0.06327, 0.71, 0.07825},
    {0.1655, 0.862, 0.04216},     {0.2904, 0.954, 0.0203},      {0.43345, 0.99495, 0.00875},
    {0.5945, 0.995, 0.0039},      {0.7621, 0.952, 0.0021},      {0.9163, 0.87, 0.00165},
    {1.0263, 0.757, 0.0011},      {1.0622, 0.631, 0.0008},      {1.0026, 0.503, 0.00034},
    {0.85445, 0.381, 0.00019},    {0.6424, 0.265, 5e-05},       {0.4479, 0.175, 2e-05},
    {0.2835, 0.107, 0.0},         {0.1649, 0.061, 0.0},         {0.0874, 0.032, 0.0},
    {0.04677, 0.017, 0.0},        {0.0227, 0.00821, 0.0},       {0.011359, 0.004102, 0.0},
    {0.00579, 0.002091, 0.0},     {0.002899, 0.001047, 0.0},    {0.00144, 0.00052, 0.0},
    {0.00069, 0.000249, 0.0},     {0.000332, 0.00012, 0.0},     {0.000166, 6e-05, 0.0},
    {8.3e-05, 3e-05, 0.0},        {4.2e-05, 1.5e-05, 0.0}};
constexpr int OBSERVER_ROWS = std::size(OBSERVER);
constexpr double OBSERVER_LAST = OBSERVER_FIRST + OBSERVER_STEP * (OBSERVER_ROWS - 1);

// Between the rows by Catmull and Rom's cubic.
std::array<double, 3> observer(double nm) {
  const double x = (nm - OBSERVER_FIRST) / OBSERVER_STEP;
  const int row = std::clamp(static_cast<int>(x), 0, OBSERVER_ROWS - 2);
  const double t = x - row;
  const double weights[4] = {t * (-0.5 + t * (1.0 - 0.5 * t)), 1.0 + t * t * (-2.5 + 1.5 * t),
                             t * (0.5 + t * (2.0 - 1.5 * t)), t * t * (-0.5 + 0.5 * t)};
  std::array<double, 3> xyz{};
  for (int k = 0; k < 4; ++k) {
    const double *values = OBSERVER[std::clamp(row + k - 1, 0, OBSERVER_ROWS - 1)];
    for (std::size_t i = 0; i < 3; ++i) xyz[i] += weights[k] * values[i];
  }
  return xyz;
}

// Means over wavelengths as Rec. 709's channels see them.
void make_film_tables(std::vector<float> &table) {
  constexpr double RGB[3][3] = {
      {3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}};
  constexpr unsigned STEPS = 600;
  const auto wavelength = [](unsigned i) {
    return OBSERVER_FIRST + (OBSERVER_LAST - OBSERVER_FIRST) * (i + 0.5) / STEPS;
  };
  for (unsigned channel = 0; channel < 3; ++channel) {
    std::array<double, STEPS> sensitivity;
    double total = 0.0;
    for (unsigned i = 0; i < STEPS; ++i) {
      const std::array<double, 3> xyz = observer(wavelength(i));
      sensitivity[i] = RGB[channel][0] * xyz[0] + RGB[channel][1] * xyz[1] + RGB[channel][2] * xyz[2];
      total += sensitivity[i];
    }
    for (unsigned x = 0; x < FILM_NODES; ++x) {
      const double path = static_cast<double>(FILM_LONGEST) * x / (FILM_NODES - 1);
      double c = 0.0;
      double s = 0.0;
      for (unsigned i = 0; i < STEPS; ++i) {
        const double phase = 2.0 * 3.14159265358979 * path / wavelength(i);
        c += sensitivity[i] * std::cos(phase);
        s += sensitivity[i] * std::sin(phase);
      }
      table[TABLE_FILM + channel * FILM_NODES + x] = static_cast<float>(c / total);
      table[TABLE_FILM + (channel + 3) * FILM_NODES + x] = static_cast<float>(s / total);
    }
  }
}

// What was measured.
constexpr float SHEEN_TABLE[] = {
#include "sheen_table.inc"
};
static_assert(std::size(SHEEN_TABLE) == 3 * SHEEN_NODES * SHEEN_NODES);

std::vector<float> make_tables() {
  std::vector<float> table(TABLE_SIZE);
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
  make_glass_tables(table);
  make_film_tables(table);
  std::copy(std::begin(SHEEN_TABLE), std::end(SHEEN_TABLE), table.begin() + TABLE_SHEEN);
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
  std::fprintf(
      file,
      "// Written by make_albedo_tables; see kernels/closure/lobe_tables.h.\n#pragma once\n\nnamespace cotorra {\n");
  std::fprintf(file, "inline constexpr unsigned albedo_table_size = %zu;\n", table.size());
  std::fprintf(file, "inline constexpr float albedo_tables[albedo_table_size] = {\n");
  for (const float value : table) std::fprintf(file, "%.7ef,\n", static_cast<double>(value));
  std::fprintf(file, "};\n}  // namespace cotorra\n");
  return std::fclose(file) == 0 ? 0 : 1;
}
