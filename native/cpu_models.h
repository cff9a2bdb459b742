// SPDX-License-Identifier: GPL-3.0-or-later
// Lanes whose surface has a reflection model other than Principled, field by field, and the loops over them: one for
// each model, in which the model is constant and what it does without is not computed. Included by cpu_kernel.cpp
// alone.
#pragma once

#include <type_traits>

#include "cpu_arrays.h"

namespace cotorra {
namespace {

constexpr std::size_t kModelLanes = FEATURE(FEATURE_MODELS) ? kLanes : 1;

// ModelBsdf of each lane. Of a lane's model counts what its kind has; the rest is an earlier lane's.
struct ModelLanes {
  using Numbers = Array<float, kModelLanes>;
  using Choices = Array<uint, kModelLanes>;
  using Vectors = VectorArray<kModelLanes>;
  Choices model;
  uint present = 0;  // bit m: a lane has model m
  Vectors diffuse, specular, index_n, index_k;
  Numbers p_specular, p_uniform, exponent, alpha, eta, no, n_lambda, visible, share, sigma;
  Choices distribution, masking, fresnel, form;

  void set(std::size_t i, const ModelBsdf &m) {
    model[i] = m.model;
    present |= 1u << m.model;
    if (m.model == MODEL_PRINCIPLED) return;
    diffuse.set(i, m.diffuse);
    p_specular[i] = m.p_specular;
    p_uniform[i] = m.p_uniform;
    no[i] = m.no;
    form[i] = m.form;
    if (m.model == MODEL_LAMBERT) return;
    sigma[i] = m.sigma;
    if (m.model == MODEL_OREN_NAYAR) return;
    specular.set(i, m.specular);
    exponent[i] = m.exponent;
    if (m.model != MODEL_COOK_TORRANCE) return;
    index_n.set(i, m.index_n);
    index_k.set(i, m.index_k);
    alpha[i] = m.alpha;
    eta[i] = m.eta;
    n_lambda[i] = m.n_lambda;
    visible[i] = m.visible;
    share[i] = m.share;
    distribution[i] = m.distribution;
    masking[i] = m.masking;
    fresnel[i] = m.fresnel;
  }

  // Of a lane that has this model.
  void get(std::size_t i, uint of_model, ModelBsdf &m) const {
    model_clear(m);
    m.model = of_model;
    m.diffuse = diffuse.get(i);
    m.no = no[i];
    m.form = form[i];
    if (of_model == MODEL_LAMBERT) return;
    m.p_uniform = p_uniform[i];
    m.sigma = sigma[i];
    if (of_model == MODEL_OREN_NAYAR) return;
    m.p_specular = p_specular[i];
    m.specular = specular.get(i);
    m.exponent = exponent[i];
    if (of_model != MODEL_COOK_TORRANCE) return;
    m.index_n = index_n.get(i);
    m.index_k = index_k.get(i);
    m.alpha = alpha[i];
    m.eta = eta[i];
    m.n_lambda = n_lambda[i];
    m.visible = visible[i];
    m.share = share[i];
    m.distribution = distribution[i];
    m.masking = masking[i];
    m.fresnel = fresnel[i];
  }
};

// run(model) for each model that a lane has, as a constant.
template <uint kModel = MODEL_LAMBERT, class Run>
void each_model(const ModelLanes &lanes, Run run) {
  if ((lanes.present & 1u << kModel) != 0u) run(std::integral_constant<uint, kModel>());
  if constexpr (kModel < MODEL_TOON) each_model<kModel + 1>(lanes, run);
}

}  // namespace
}  // namespace cotorra
