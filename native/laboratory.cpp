// SPDX-License-Identifier: GPL-3.0-or-later
// Reflection models over NumPy arrays, exactly as the kernels compute them.
// Materials are constants and models, checked as those of a scene are; no lights and no geometry here.
#include "laboratory.h"

#include <memory>
#include <utility>

#include "albedo_tables.h"
#include "python_arrays.h"
#include "python_models.h"
#include "scene.h"

#include "every_feature.h"

#include "../kernels/bsdf_terms.h"

namespace cotorra {
namespace {

using namespace nb::literals;
using Vectors = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

// A new NumPy array of `rows` entries; `data` is where to write them.
template <class Scalar, class T>
nb::object new_array(std::size_t rows, T *&data) {
  auto values = std::make_unique<T[]>(rows);
  data = values.get();
  nb::capsule owner(values.release(), [](void *p) noexcept { delete[] static_cast<T *>(p); });
  constexpr std::size_t columns = sizeof(T) / sizeof(Scalar);
  const std::size_t shape[2] = {rows, columns};
  return nb::cast(nb::ndarray<nb::numpy, Scalar>(data, columns > 1 ? 2 : 1, shape, owner));
}

vec3 vector_at(const Vectors &array, std::size_t i) {
  const float *v = array.data() + 3 * (i % array.shape(0));
  return {v[0], v[1], v[2]};
}

// Principled materials from arrays that are named as Principled's inputs, with `models`.
std::vector<Material> principled_records(nb::handle from, std::vector<nb::object> &keep) {
  const auto base_color = view<vec3, float>(from, "base_color", keep);
  const auto specular_tint = view<vec3, float>(from, "specular_tint", keep);
  const auto metallic = view<float, float>(from, "metallic", keep);
  const auto roughness = view<float, float>(from, "roughness", keep);
  const auto ior = view<float, float>(from, "ior", keep);
  const auto specular_level = view<float, float>(from, "specular_level", keep);
  const auto multi_ggx = view<uint, std::uint32_t>(from, "multi_ggx", keep);
  const std::size_t count = metallic.size();
  const auto require = [count](std::size_t size, const char *name) {
    if (size == count) return;
    throw std::invalid_argument(std::string("materials.") + name + " has " + std::to_string(size) +
                                " entries, expected " + std::to_string(count));
  };
  require(base_color.size(), "base_color");
  require(specular_tint.size(), "specular_tint");
  require(roughness.size(), "roughness");
  require(ior.size(), "ior");
  require(specular_level.size(), "specular_level");
  require(multi_ggx.size(), "multi_ggx");
  std::vector<Material> materials(count);
  for (std::size_t i = 0; i < count; ++i) {
    Material &m = materials[i];
    m = {};
    m.base_color = base_color[i];
    m.specular_tint = specular_tint[i];
    m.metallic = clamp(metallic[i], 0.0f, 1.0f);
    m.roughness = clamp(roughness[i], 0.0f, 1.0f);
    m.ior = ior[i];
    m.specular_level = specular_level[i];
    m.alpha = 1.0f;
    m.flags = principled_flags(m);
    if ((m.flags & MATERIAL_SPECULAR) != 0 && m.roughness < kSharpRoughness) m.flags |= MATERIAL_SHARP;
    if (multi_ggx[i] != 0) m.flags |= MATERIAL_MULTI_GGX;
  }
  return materials;
}

// Materials, each at one point with one viewer; inputs with fewer rows than the longest are repeated.
class Bench {
 public:
  Bench(nb::handle materials, const Vectors &n, const Vectors &wo) : n_(n), wo_(wo) {
    materials_ = principled_records(materials, keep_);
    const ModelsInput models = read_models(nb::getattr(materials, "models"), keep_);
    if (!models.model.empty()) {
      models_ = model_records(models, materials_.size());
      apply_models(models_, materials_);
    }
    scene_.models = {models_.data()};
    scene_.albedo = {albedo_tables};
  }

  std::size_t rows(const Vectors &other) const {
    const std::size_t least = std::min({materials_.size(), n_.shape(0), wo_.shape(0), other.shape(0)});
    if (least == 0) throw std::invalid_argument("materials, n, wo and the last array must not be empty");
    return std::max({materials_.size(), n_.shape(0), wo_.shape(0), other.shape(0)});
  }
  vec3 wo(std::size_t i) const { return vector_at(wo_, i); }
  Bsdf bsdf(std::size_t i) const {
    Bsdf bsdf;
    const vec3 n = vector_at(n_, i);
    bsdf_prepare(scene_, materials_[i % materials_.size()], n, n, wo(i), bsdf);
    return bsdf;
  }

 private:
  std::vector<nb::object> keep_;
  std::vector<Material> materials_;
  std::vector<MaterialModel> models_;
  SceneData scene_{};
  const Vectors &n_, &wo_;
};

nb::tuple evaluate_model(nb::handle materials, const Vectors &n, const Vectors &wo, const Vectors &wi) {
  const Bench bench(materials, n, wo);
  const std::size_t rows = bench.rows(wi);
  vec3 *diffuse, *specular;
  float *pdf;
  nb::object result[] = {new_array<float>(rows, diffuse), new_array<float>(rows, specular),
                         new_array<float>(rows, pdf)};
  for (std::size_t i = 0; i < rows; ++i) {
    diffuse[i] = bsdf_eval_lobes(bench.bsdf(i), bench.wo(i), vector_at(wi, i), false, specular[i], pdf[i]);
  }
  return nb::make_tuple(result[0], result[1], result[2]);
}

nb::tuple sample_model(nb::handle materials, const Vectors &n, const Vectors &wo, const Vectors &u) {
  const Bench bench(materials, n, wo);
  const std::size_t rows = bench.rows(u);
  vec3 *wi, *weight;
  float *pdf;
  uint *lobe;
  nb::object result[] = {new_array<float>(rows, wi), new_array<float>(rows, weight), new_array<float>(rows, pdf),
                         new_array<std::uint32_t>(rows, lobe)};
  for (std::size_t i = 0; i < rows; ++i) {
    const vec3 random = vector_at(u, i);
    BsdfSample sample;
    bsdf_sample(bench.bsdf(i), bench.wo(i), random.x, vec2(random.y, random.z), sample);
    wi[i] = sample.wi;
    weight[i] = sample.weight;
    pdf[i] = sample.pdf;
    lobe[i] = sample.lobe;
  }
  return nb::make_tuple(result[0], result[1], result[2], result[3]);
}

nb::tuple model_terms_of(nb::handle materials, const Vectors &n, const Vectors &wo, const Vectors &wi) {
  const Bench bench(materials, n, wo);
  const std::size_t rows = bench.rows(wi);
  float *d, *g;
  vec3 *f;
  nb::object result[] = {new_array<float>(rows, d), new_array<float>(rows, g), new_array<float>(rows, f)};
  for (std::size_t i = 0; i < rows; ++i) bsdf_terms(bench.bsdf(i), bench.wo(i), vector_at(wi, i), d[i], g[i], f[i]);
  return nb::make_tuple(result[0], result[1], result[2]);
}

}  // namespace

void register_laboratory(nb::module_ &module) {
  module.def("evaluate_model", &evaluate_model, "materials"_a, "n"_a, "wo"_a, "wi"_a,
             "f cos of materials as the kernels compute it: (diffuse (N, 3), specular (N, 3), pdf (N,)), float32.\n"
             "`materials` has M entries in arrays named as Principled's inputs (base_color, metallic, roughness, ior,\n"
             "specular_level, specular_tint, multi_ggx), and a MaterialModels or None as `models`; n, wo and wi are\n"
             "float32 arrays (rows, 3) of unit vectors: the normal, toward the viewer and toward the light. N is the "
             "most of their\n"
             "rows; shorter ones are repeated. pdf is that of sample_model. Raises ValueError as Scene does.");
  module.def(
      "sample_model", &sample_model, "materials"_a, "n"_a, "wo"_a, "u"_a,
      "Directions toward light as the kernels draw them: (wi (N, 3), weight (N, 3), pdf (N,), lobe (N,) uint32).\n"
      "u is float32 (rows, 3) in [0, 1): the choice of the lobe, and two for the direction. weight is f cos / pdf;\n"
      "pdf 0 is no sample. lobe: 1 diffuse, 2 specular; + 4 a mirror, whose pdf is the lobe's probability; + 8\n"
      "sharp. The rest is as in evaluate_model.");
  module.def(
      "model_terms", &model_terms_of, "materials"_a, "n"_a, "wo"_a, "wi"_a,
      "The highlight's D (N,), G (N,) and F (N, 3), as in evaluate_model. Phongs: D is the power, F its factor.");
}

}  // namespace cotorra
