// SPDX-License-Identifier: GPL-3.0-or-later
// The lobes of kernels/closure over arrays, for the tests in Python. Inputs with fewer entries than results are
// repeated. Nothing is tested here: see tests/test_closures.py.
#include <cstddef>

namespace {
constexpr unsigned KERNEL_FEATURES = 32u;  // FEATURE_SPECULAR
}
#include "closure/principled.h"

using namespace cotorra;

// Arguments of any closure; which of them count is the closure's.
struct ClosureCase {
  unsigned kind;  // LOBE_*, or CASE_*
  unsigned distribution;
  vec3 color;
  vec3 edge;
  float roughness;
  float ior;
  float anisotropy;
  float rotation;
  float film;
  float film_ior;
  float size;
  float smooth_rim;
  unsigned inside;
  vec3 tangent;
};

namespace {

constexpr unsigned CASE_METALLIC = 100;
constexpr unsigned CASE_CONDUCTOR = 101;

Lobe prepare(const float *tables, const ClosureCase &c, vec3 n, vec3 wo) {
  const FloatBuffer table{tables};
  const vec3 one(1.0f);
  Lobe l;
  switch (c.kind) {
    case LOBE_DIFFUSE:
    case LOBE_TRANSLUCENT:
      diffuse_prepare(c.kind, one, c.color, c.roughness, n, wo, l);
      break;
    case LOBE_REFLECTION:
    case LOBE_ASHIKHMIN_SHIRLEY:
      glossy_prepare(table, c.distribution, one, c.color, c.roughness, c.anisotropy, c.rotation, n, n, c.tangent, wo,
                     l);
      break;
    case CASE_METALLIC:
      metallic_prepare(table, c.distribution, one, c.color, c.edge, c.roughness, c.anisotropy, c.rotation, n, n,
                       c.tangent, wo, c.film, c.film_ior, l);
      break;
    case CASE_CONDUCTOR:
      conductor_prepare(table, c.distribution, one, c.color, c.edge, c.roughness, c.anisotropy, c.rotation, n, n,
                        c.tangent, wo, c.film, c.film_ior, l);
      break;
    case LOBE_GLASS:
      glass_prepare(table, c.distribution, one, c.color, c.roughness, c.ior, n, n, wo, c.inside != 0, c.film,
                    c.film_ior, l);
      break;
    case LOBE_REFRACTION:
      refraction_prepare(c.distribution, one, c.color, c.roughness, c.ior, n, n, wo, c.inside != 0, l);
      break;
    case LOBE_SHEEN:
      sheen_prepare(table, one, c.color, c.roughness, n, wo, l);
      break;
    case LOBE_VELVET:
      velvet_prepare(one, c.color, c.roughness, n, l);
      break;
    default:
      toon_prepare(c.kind == LOBE_TOON_GLOSSY, one, c.color, c.size, c.smooth_rim, n, l);
  }
  return l;
}

}  // namespace

extern "C" {

// `cases` entries of c, n and wo; `count` results.
void test_lobes(const float *tables, std::size_t cases, const ClosureCase *c, const vec3 *n, const vec3 *wo,
                Lobe *lobes) {
  for (std::size_t i = 0; i < cases; ++i) lobes[i] = prepare(tables, c[i], n[i], wo[i]);
}

void test_lobe_eval(const float *tables, std::size_t lobes, std::size_t count, const Lobe *l, const vec3 *wo,
                    const vec3 *wi, vec3 *f, float *pdf) {
  for (std::size_t i = 0; i < count; ++i) f[i] = lobe_eval({tables}, l[i % lobes], wo[i % lobes], wi[i], pdf[i]);
}

void test_lobe_sample(const float *tables, std::size_t lobes, std::size_t count, const Lobe *l, const vec3 *wo,
                      const vec3 *u, BsdfSample *samples) {
  for (std::size_t i = 0; i < count; ++i) {
    lobe_sample({tables}, l[i % lobes], wo[i % lobes], u[i].x, vec2(u[i].y, u[i].z), samples[i]);
  }
}

void test_lobe_albedo(const float *tables, std::size_t lobes, const Lobe *l, const vec3 *wo, vec3 *albedo) {
  for (std::size_t i = 0; i < lobes; ++i) albedo[i] = lobe_albedo({tables}, l[i], wo[i]);
}

// One draw of Principled for each u (choice of the layer; choice in it; direction), and f cos toward wi of what was
// picked. `picked` is PICK_*.
void test_principled(const float *tables, std::size_t cases, std::size_t count, const PrincipledInputs *inputs,
                     const vec3 *ng, const vec3 *wo, const vec4 *u, const vec3 *wi, vec3 *f, float *pdf,
                     BsdfSample *samples, unsigned *picked) {
  SceneData scene{};
  scene.albedo.v = tables;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = i % cases;
    Bsdf bsdf;
    Lobe lobe;
    vec3 scale;
    picked[i] = principled_pick(scene, inputs[k], ng[k], wo[k], u[i].x, bsdf, lobe, scale);
    if (picked[i] == PICK_BSDF) {
      f[i] = bsdf_eval(bsdf, wo[k], wi[i], pdf[i]);
      bsdf_sample(bsdf, wo[k], u[i].y, vec2(u[i].z, u[i].w), samples[i]);
    } else {
      f[i] = lobe_eval({tables}, lobe, wo[k], wi[i], pdf[i]);
      lobe_sample({tables}, lobe, wo[k], u[i].y, vec2(u[i].z, u[i].w), samples[i]);
    }
    f[i] *= scale;
    samples[i].weight *= scale;
  }
}

void test_principled_sums(const float *tables, std::size_t cases, const PrincipledInputs *inputs, const vec3 *ng,
                          const vec3 *wo, vec3 *emission, vec3 *albedo) {
  for (std::size_t i = 0; i < cases; ++i) {
    emission[i] = principled_emission({tables}, inputs[i], ng[i], wo[i]);
    albedo[i] = principled_albedo({tables}, inputs[i], ng[i], wo[i]);
  }
}
}
