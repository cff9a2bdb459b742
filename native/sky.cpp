// SPDX-License-Identifier: GPL-3.0-or-later
// Computes skies: marches rays through air, aerosols and ozone. The constants of the air are those of Blender's two
// models, so that the skies are the same; the methods are the papers'. Nothing of it runs while a picture is rendered.
#include "sky.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

namespace cotorra {
namespace {

constexpr double kPi = std::numbers::pi;

struct Triple {
  double x, y, z;
};

Triple operator+(Triple a, Triple b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Triple operator*(Triple a, double s) { return {a.x * s, a.y * s, a.z * s}; }

double square(double a) { return a * a; }

vec3 rec709(Triple xyz) {
  return vec3(static_cast<float>(3.2409699 * xyz.x - 1.5373832 * xyz.y - 0.4986108 * xyz.z),
              static_cast<float>(-0.9692436 * xyz.x + 1.8759675 * xyz.y + 0.0415551 * xyz.z),
              static_cast<float>(0.0556301 * xyz.x - 0.2039770 * xyz.y + 1.0569715 * xyz.z));
}

// The way from a height above the centre, under this cosine to the zenith, out of a sphere around it.
double way_out(double height, double cosine, double radius) {
  const double across = height * cosine;
  return -across + std::sqrt(std::max(square(across) + square(radius) - square(height), 0.0));
}

// Height above the centre after `way` from `height`, under this cosine to the zenith.
double height_after(double height, double cosine, double way) {
  return std::sqrt(square(height) + square(way) + 2.0 * height * way * cosine);
}

// Share of light that air sends on at an angle (Rayleigh).
double phase_of_air(double cosine) { return 3.0 / (16.0 * kPi) * (1.0 + square(cosine)); }

double solid_angle_of(double size) { return 2.0 * kPi * (1.0 - std::cos(0.5 * size)); }

// ---- One scattering, over the spectrum. Lengths in metres.
namespace once {

constexpr double kEarth = 6360e3, kTop = 6420e3, kHighest = 59999.0;
constexpr double kAirHeight = 8e3, kAerosolHeight = 1.2e3;  // over which densities fall to 1/e
constexpr double kAerosolScattering = 2e-5, kAerosolExtinction = 1.11 * kAerosolScattering;  // 1/m
constexpr double kForward = 0.76;  // mean cosine of the aerosols
constexpr int kSteps = 32;
constexpr int kWavelengths = 21;  // 380 to 780 nm
constexpr double kStepNm = 20.0;

using Spectrum = std::array<double, kWavelengths>;

// Of the sun above the air, W/(m2 nm).
constexpr Spectrum kSunlight = {1.457568, 1.565963, 1.651484, 1.714962, 1.757980, 1.782564, 1.790951,
                                1.785416, 1.768156, 1.741221, 1.706471, 1.665561, 1.619934, 1.570836,
                                1.519323, 1.466285, 1.412459, 1.358450, 1.304749, 1.251750, 1.199760};
// Scattering of air and absorption of ozone at their densest, 1/m.
constexpr Spectrum kAir = {5.424820e-5, 4.418550e-5, 3.635152e-5, 3.017929e-5, 2.526320e-5, 2.130859e-5, 1.809838e-5,
                           1.547057e-5, 1.330285e-5, 1.150185e-5, 9.995574e-6, 8.728000e-6, 7.655137e-6, 6.742172e-6,
                           5.961341e-6, 5.290346e-6, 4.711157e-6, 4.209105e-6, 3.772184e-6, 3.390513e-6, 3.055915e-6};
constexpr Spectrum kOzone = {3.251268e-9, 5.853954e-9, 1.977191e-8, 7.309569e-8, 2.008456e-7, 4.038396e-7, 6.355134e-7,
                             9.670704e-7, 1.547974e-6, 2.090386e-6, 2.461281e-6, 2.735513e-6, 2.151259e-6, 1.590518e-6,
                             1.123562e-6, 7.352755e-7, 4.645013e-7, 3.309608e-7, 2.251261e-7, 1.487913e-7, 1.682862e-7};
// The CIE 1931 standard observer.
constexpr std::array<Triple, kWavelengths> kObserver = {
    {{0.001368, 0.000039, 0.006450}, {0.014310, 0.000396, 0.067850}, {0.134380, 0.004000, 0.645600},
     {0.348280, 0.023000, 1.747060}, {0.290800, 0.060000, 1.669200}, {0.095640, 0.139020, 0.812950},
     {0.004900, 0.323000, 0.272000}, {0.063270, 0.710000, 0.078250}, {0.290400, 0.954000, 0.020300},
     {0.594500, 0.995000, 0.003900}, {0.916300, 0.870000, 0.001650}, {1.062200, 0.631000, 0.000800},
     {0.854450, 0.381000, 0.000190}, {0.447900, 0.175000, 0.000020}, {0.164900, 0.061000, 0.0},
     {0.046770, 0.017000, 0.0},      {0.011359, 0.004102, 0.0},      {0.002899, 0.001047, 0.0},
     {0.000690, 0.000249, 0.0},      {0.000166, 0.000060, 0.0},      {0.0000415, 0.0000150, 0.0}}};
// Gauss and Laguerre's eight points, for what falls off exponentially: the way is 25 of their lengths, and the weights
// hold e^x.
constexpr std::array<double, 8> kWay = {0.006811185292, 0.03614807107, 0.09004346519, 0.1706680068,
                                        0.2818362161,   0.4303406404,  0.6296271457,  0.9145252695};
constexpr std::array<double, 8> kShare = {0.01750893642, 0.04135477391, 0.06678839063, 0.09507698807,
                                          0.1283416365,  0.1707430204,  0.2327233347,  0.3562490486};

// Densities of air, aerosols and ozone.
Triple densities(double above) {
  return {std::exp(-above / kAirHeight), std::exp(-above / kAerosolHeight),
          std::max(1.0 - std::abs(above - 25e3) / 15e3, 0.0)};
}

// Densities summed up on the way from a height above the centre out of the air.
Triple depth_to_sun(double height, double cosine) {
  const double length = way_out(height, cosine, kTop);
  Triple sum{0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < kWay.size(); ++i) {
    sum = sum + densities(height_after(height, cosine, kWay[i] * length) - kEarth) * kShare[i];
  }
  return sum * length;
}

double phase_of_aerosols(double cosine) {
  constexpr double g2 = kForward * kForward;
  return 3.0 * (1.0 - g2) * (1.0 + square(cosine)) /
         (8.0 * kPi * (2.0 + g2) * std::pow(1.0 + g2 - 2.0 * kForward * cosine, 1.5));
}

vec3 color_of(const Spectrum &light) {
  Triple xyz{0.0, 0.0, 0.0};
  for (std::size_t w = 0; w < light.size(); ++w) xyz = xyz + kObserver[w] * (light[w] * kStepNm);
  return rec709(xyz);
}

double viewer_of(const SkyInput &in) { return kEarth + std::clamp(in.altitude, 1.0, kHighest); }

vec3 light_from(const SkyInput &in, double elevation, double azimuth) {
  const double viewer = viewer_of(in);
  const double up = std::sin(elevation), sun_up = std::sin(in.sun_elevation);
  const double cosine = up * sun_up + std::cos(elevation) * std::cos(in.sun_elevation) * std::cos(azimuth);
  const double by_air = phase_of_air(cosine), by_aerosols = phase_of_aerosols(cosine);
  const double step = way_out(viewer, up, kTop) / kSteps;
  Spectrum light{};
  Triple depth{0.0, 0.0, 0.0};
  for (int k = 0; k < kSteps; ++k) {
    const double way = (k + 0.5) * step;
    const double height = height_after(viewer, up, way);
    Triple density = densities(height - kEarth);
    density = {density.x * in.air, density.y * in.aerosol, density.z * in.ozone};
    depth = depth + density * step;
    // The sun, as the point sees it; the earth may hide it.
    const double to_sun = (viewer * sun_up + way * cosine) / height;
    if (sun_up < 0.0 && square(height * to_sun) - square(height) + square(kEarth) >= 0.0) continue;
    const Triple rest = depth_to_sun(height, to_sun);
    const Triple whole = depth + Triple{rest.x * in.air, rest.y * in.aerosol, rest.z * in.ozone};
    for (std::size_t w = 0; w < light.size(); ++w) {
      const double kept = std::exp(-(whole.x * kAir[w] + whole.y * kAerosolExtinction + whole.z * kOzone[w]));
      const double sent = by_air * density.x * kAir[w] + by_aerosols * density.y * kAerosolScattering;
      light[w] += kept * sent * kSunlight[w] * step;
    }
  }
  return color_of(light);
}

vec3 sun_at(const SkyInput &in, double elevation) {
  const Triple depth = depth_to_sun(viewer_of(in), std::sin(std::max(elevation, 0.0)));
  Spectrum light;
  for (std::size_t w = 0; w < light.size(); ++w) {
    light[w] = kSunlight[w] * std::exp(-(depth.x * in.air * kAir[w] + depth.y * in.aerosol * kAerosolExtinction));
  }
  return color_of(light) * static_cast<float>(1.0 / solid_angle_of(in.sun_size));
}

}  // namespace once

// ---- All scattering, at 630, 560, 490 and 430 nm. Lengths in kilometres.
namespace often {

constexpr double kEarth = 6371.0, kThickness = 100.0, kTop = kEarth + kThickness, kHighest = 99999.0;
constexpr double kForward = 0.8;
constexpr double kGround = 0.3;  // what it reflects
constexpr int kSteps = 64;
constexpr int kCosines = 256, kHeights = 64;  // of the table of transmittance

using Four = std::array<double, 4>;

constexpr Four kSunlight = {1.679, 1.828, 1.986, 1.307};
constexpr Four kAir = {6.605e-3, 1.067e-2, 1.842e-2, 3.156e-2};
constexpr Four kOzone = {334.5 * 3.472e-25, 334.5 * 3.914e-25, 334.5 * 1.349e-25, 334.5 * 1.103e-26};
constexpr Four kAerosolAbsorbs = {2.8722e-24, 4.6168e-24, 7.9706e-24, 1.3578e-23};
constexpr Four kAerosolScatters = {1.5908e-22, 1.7711e-22, 2.0942e-22, 2.4033e-22};
constexpr double kAerosolDensity = 1.3681e20, kAerosolBackground = 2e6, kAerosolFall = 0.73;
constexpr Four kScatteredBefore = {0.02 * 0.217, 0.02 * 0.347, 0.02 * 0.594, 0.02};  // the fit
constexpr std::array<Triple, 4> kToXyz = {{{53.3869177, 22.9813375, 0.0},
                                           {43.9048445, 71.3477957, 0.1025069},
                                           {1.6137278, 18.4229606, 31.7429212},
                                           {20.7626687, 2.3614214, 110.4800964}}};

// What a height's air scatters by molecules and by aerosols, and takes away in all; 1/km.
struct Mixture {
  Four air, aerosol, extinction;
};

Mixture mixture_at(const SkyInput &in, double above) {
  const double log = std::log(std::max(above, 1e-4));
  const double ozone = in.ozone * 3.78547397e20 * std::exp(-square(log - 3.22261) * 5.55555555 - log);
  const double aerosol = in.aerosol * (kAerosolDensity * std::exp(-above / kAerosolFall) + kAerosolBackground);
  const double air = in.air * std::exp(-0.07771971 * std::pow(above, 1.16364243));
  Mixture m;
  for (std::size_t w = 0; w < 4; ++w) {
    m.air[w] = kAir[w] * air;
    m.aerosol[w] = kAerosolScatters[w] * aerosol;
    m.extinction[w] = m.air[w] + m.aerosol[w] + kAerosolAbsorbs[w] * aerosol + kOzone[w] * ozone;
  }
  return m;
}

// Share of light that comes through all the air to a height above the centre. The earth lets it through as air at sea
// level would.
Four transmittance(const SkyInput &in, double height, double cosine) {
  const double step = way_out(height, cosine, kTop) / kSteps;
  Four depth{};
  for (int k = 0; k < kSteps; ++k) {
    const Mixture m = mixture_at(in, std::max(height_after(height, cosine, (k + 0.5) * step) - kEarth, 0.0));
    for (std::size_t w = 0; w < 4; ++w) depth[w] += m.extinction[w] * step;
  }
  Four kept;
  for (std::size_t w = 0; w < 4; ++w) kept[w] = std::exp(-depth[w]);
  return kept;
}

// Transmittance by height and by the cosine of the sun's zenith angle.
struct Table {
  std::vector<Four> entries = std::vector<Four>(static_cast<std::size_t>(kCosines) * kHeights);

  // Between its entries, at places from 0 to 1.
  Four at(double cosine, double height) const {
    const double x = std::clamp(0.5 * cosine + 0.5, 0.0, 1.0) * (kCosines - 1);
    const double y = std::clamp(height, 0.0, 1.0) * (kHeights - 1);
    const auto x0 = static_cast<std::size_t>(x), y0 = static_cast<std::size_t>(y);
    const std::size_t x1 = std::min<std::size_t>(x0 + 1, kCosines - 1),
                      y1 = std::min<std::size_t>(y0 + 1, kHeights - 1);
    const double fx = x - static_cast<double>(x0), fy = y - static_cast<double>(y0);
    Four value;
    for (std::size_t w = 0; w < 4; ++w) {
      const double below = std::lerp(entry(x0, y0)[w], entry(x1, y0)[w], fx);
      value[w] = std::lerp(below, std::lerp(entry(x0, y1)[w], entry(x1, y1)[w], fx), fy);
    }
    return value;
  }

 private:
  const Four &entry(std::size_t x, std::size_t y) const { return entries[y * kCosines + x]; }
};

// Light that was scattered before and comes as if from everywhere: by the ground once, and by the air as fitted.
Four scattered_before(const Table &table, double to_sun, double height) {
  const double earth = 2.0 * kPi * (1.0 - std::sqrt(std::max(1.0 - square(kEarth / height), 0.0)));  // its solid angle
  const Four to_ground = table.at(to_sun, 0.0);
  const Four whole = table.at(1.0, 0.0), upper = table.at(1.0, (height - kEarth) / kThickness);
  const double seen = earth / (4.0 * kPi) * (kGround / kPi) * to_sun;
  const double day = 1.0 / (1.0 + 5.0 * std::exp(-17.92 * to_sun));
  Four light;
  for (std::size_t w = 0; w < 4; ++w) light[w] = seen * to_ground[w] * whole[w] / upper[w] + kScatteredBefore[w] * day;
  return light;
}

vec3 color_of(const Four &light) {
  Triple xyz{0.0, 0.0, 0.0};
  for (std::size_t w = 0; w < 4; ++w) xyz = xyz + kToXyz[w] * light[w];
  return rec709(xyz);
}

double viewer_of(const SkyInput &in) { return kEarth + std::clamp(in.altitude, 1.0, kHighest) / 1000.0; }

// How far a ray goes: to the ground, or out of the air.
double length_of(double viewer, double up) {
  const double across = viewer * up;
  const double ground = square(across) + square(kEarth) - square(viewer);
  if (up < 0.0 && ground >= 0.0) return -across - std::sqrt(ground);
  return way_out(viewer, up, kTop);
}

vec3 light_from(const SkyInput &in, const Table &table, double elevation, double azimuth) {
  const double viewer = viewer_of(in);
  const double up = std::sin(elevation), sun_up = std::sin(in.sun_elevation);
  const double cosine = up * sun_up + std::cos(elevation) * std::cos(in.sun_elevation) * std::cos(azimuth);
  const double by_air = phase_of_air(cosine);
  // Henyey and Greenstein's.
  const double by_aerosols =
      (1.0 - square(kForward)) / (4.0 * kPi) / std::pow(1.0 + square(kForward) - 2.0 * kForward * cosine, 1.5);
  const double step = length_of(viewer, up) / kSteps;
  Four light{}, kept{1.0, 1.0, 1.0, 1.0};
  for (int k = 0; k < kSteps; ++k) {
    const double way = (k + 0.5) * step;
    const double height = std::max(height_after(viewer, up, way), kEarth);
    const double to_sun = (viewer * sun_up + way * cosine) / height;
    const Mixture m = mixture_at(in, height - kEarth);
    const Four direct = table.at(to_sun, (height - kEarth) / kThickness);
    const Four before = scattered_before(table, to_sun, height);
    for (std::size_t w = 0; w < 4; ++w) {
      const double source = kSunlight[w] * (m.air[w] * (by_air * direct[w] + before[w]) +
                                            m.aerosol[w] * (by_aerosols * direct[w] + before[w]));
      // A step through which the source is constant (Hillaire 2016).
      const double passed = std::exp(-step * m.extinction[w]);
      light[w] += kept[w] * source * (1.0 - passed) / std::max(m.extinction[w], 1e-7);
      kept[w] *= passed;
    }
  }
  return color_of(light);
}

vec3 sun_at(const SkyInput &in, double elevation) {
  Four light = transmittance(in, viewer_of(in), std::sin(elevation));
  for (std::size_t w = 0; w < 4; ++w) light[w] *= kSunlight[w] / solid_angle_of(in.sun_size);
  return color_of(light);
}

}  // namespace often

// Calls work(row) for every row, on all cores.
template <class Work>
void each_row(int rows, Work work) {
  std::atomic<int> next{0};
  const auto take = [&] {
    for (int y = next++; y < rows; y = next++) work(y);
  };
  const int threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, rows);
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(take);
  take();
}

// Fills a row by its left half: the two sides of the sun's plane look the same.
template <class Light>
void fill_row(Sky &sky, int y, Light light) {
  vec3 *row = sky.pixels.data() + static_cast<std::size_t>(y) * kSkyWidth;
  for (int x = 0; x < kSkyWidth / 2; ++x) row[x] = row[kSkyWidth - 1 - x] = light(x);
}

}  // namespace

Sky make_sky(const SkyInput &in) {
  Sky sky{std::vector<vec3>(static_cast<std::size_t>(kSkyWidth) * kSkyHeight, vec3(0.0f)), vec3(0.0f), vec3(0.0f)};
  const double low = in.sun_elevation - 0.5 * in.sun_size, high = in.sun_elevation + 0.5 * in.sun_size;
  constexpr int kHorizon = kSkyHeight / 2;
  if (!in.multiple) {
    // Rows stand where the picture's have their lower edges, as Blender's do. Below the horizon its row fades out.
    each_row(kSkyHeight - kHorizon, [&](int i) {
      const double elevation = 0.5 * kPi * square(static_cast<double>(i) / kHorizon);
      fill_row(sky, kHorizon + i,
               [&](int x) { return once::light_from(in, elevation, 2.0 * kPi * x / kSkyWidth - kPi); });
    });
    const auto horizon = sky.pixels.begin() + static_cast<std::ptrdiff_t>(kHorizon) * kSkyWidth;
    for (int y = 0; y < kHorizon; ++y) {
      const double elevation = 0.5 * kPi * square(1.0 - static_cast<double>(y) / kHorizon);
      const auto fade = static_cast<float>(std::pow(std::max(1.0 - 2.5 * std::sin(elevation), 0.0), 3.0));
      for (int x = 0; x < kSkyWidth; ++x) sky.pixels[static_cast<std::size_t>(y * kSkyWidth + x)] = horizon[x] * fade;
    }
    if (high > 0.0) {
      sky.sun_low = once::sun_at(in, low);
      sky.sun_high = once::sun_at(in, high);
    }
    return sky;
  }
  often::Table table;
  each_row(often::kHeights, [&](int y) {
    const double height = often::kEarth + often::kThickness * y / (often::kHeights - 1);
    for (int x = 0; x < often::kCosines; ++x) {
      table.entries[static_cast<std::size_t>(y * often::kCosines + x)] =
          often::transmittance(in, height, 2.0 * x / (often::kCosines - 1) - 1.0);
    }
  });
  each_row(kSkyHeight, [&](int y) {
    const double place = 2.0 * (y + 0.5) / kSkyHeight - 1.0;
    const double elevation = std::copysign(0.5 * kPi * square(place), place);
    fill_row(sky, y,
             [&](int x) { return often::light_from(in, table, elevation, 2.0 * kPi * (x + 0.5) / kSkyWidth - kPi); });
  });
  sky.sun_low = often::sun_at(in, low);
  sky.sun_high = often::sun_at(in, high);
  return sky;
}

}  // namespace cotorra
