// SPDX-License-Identifier: GPL-3.0-or-later
// The BSDF kernels over arrays, for the tests in Python. Inputs with fewer entries than results are repeated.
// Nothing is tested here: see tests/test_bsdf.py.
#include <cstddef>

namespace {
constexpr unsigned KERNEL_FEATURES = 32u;  // FEATURE_SPECULAR
}
#include "bsdf.h"

using namespace cotorra;

namespace {

struct Inputs {
  const float *tables;
  std::size_t count;      // results
  std::size_t materials;  // entries of material, n and wo
  const Material *material;
  const vec3 *n;
  const vec3 *wo;
};

vec3 prepare(const Inputs &in, std::size_t i, Bsdf &bsdf) {
  SceneData scene{};
  scene.albedo.v = in.tables;
  const std::size_t k = i % in.materials;
  return bsdf_prepare_albedo(scene, in.material[k], in.n[k], in.n[k], in.wo[k], bsdf);
}

}  // namespace

extern "C" {

// exp(-x), log(x), and the angle of (x, y), of positive x.
void test_lanes(const float *x, const float *y, std::size_t n, float *power, float *logarithm, float *angle) {
  for (std::size_t i = 0; i < n; ++i) {
    power[i] = exp_lanes(-x[i]);
    logarithm[i] = log_lanes(x[i]);
    angle[i] = angle_lanes(y[i], x[i] - 1.0f);
  }
}

void test_eval(const Inputs *in, const vec3 *wi, vec3 *diffuse, vec3 *glossy, float *pdf) {
  for (std::size_t i = 0; i < in->count; ++i) {
    Bsdf bsdf;
    prepare(*in, i, bsdf);
    diffuse[i] = bsdf_eval_lobes(bsdf, in->wo[i % in->materials], wi[i], false, glossy[i], pdf[i]);
  }
}

void test_sample(const Inputs *in, const vec3 *u, BsdfSample *samples) {
  for (std::size_t i = 0; i < in->count; ++i) {
    Bsdf bsdf;
    prepare(*in, i, bsdf);
    bsdf_sample(bsdf, in->wo[i % in->materials], u[i].x, vec2(u[i].y, u[i].z), samples[i]);
  }
}

void test_albedo(const Inputs *in, vec3 *diffuse, vec3 *glossy) {
  for (std::size_t i = 0; i < in->count; ++i) {
    Bsdf bsdf;
    glossy[i] = prepare(*in, i, bsdf);
    diffuse[i] = bsdf.diffuse * PI;
  }
}

void test_flags(const Material *material, std::size_t count, unsigned *flags) {
  for (std::size_t i = 0; i < count; ++i) flags[i] = principled_flags(material[i]);
}
}
