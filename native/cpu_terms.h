// SPDX-License-Identifier: GPL-3.0-or-later
// Passes that take a picture apart: the terms of the highlight, and the light of single lamps.
// Included by cpu_kernel.cpp alone; with FEATURE_TERMS left out nothing here is called.
#pragma once

#include "../kernels/lamp_terms.h"
#include "cpu_batch.h"

namespace cotorra {
namespace {

void clear_lamps(const PassSelection &passes, int lanes, Batch &b) {
  b.lamps.assign(static_cast<std::size_t>(lanes) * passes.lamps, vec3(0.0f));
}

// Adds light to the pass of the lamp that it comes from, and returns the light group (LAMP_PASS_SHIFT).
int add_lamp(const PassSelection &passes, uint slot, vec3 value, int group, Batch &b) {
  const int lamp = light_pass(group);
  if (lamp >= 0 && lamp < static_cast<int>(passes.lamps))
    b.lamps[slot * passes.lamps + static_cast<uint>(lamp)] += value;
  return light_group(group);
}

void stage_lamps(const PassSelection &passes, std::size_t slot, std::size_t pixel, Batch &b) {
  const std::size_t n = passes.lamps;
  for (std::size_t l = 0; l < n; ++l) b.staged.lamps[pixel * n + l] += film_vector(b.lamps[slot * n + l]);
}

// The terms of the first surface that a sample met.
void record_terms(const SceneData &scene, vec3 p, const Bsdf &bsdf, vec3 wo, std::size_t pixel, Batch &b) {
  float d;
  float g;
  vec3 f;
  lamp_terms(scene, p, bsdf, wo, d, g, f);
  TermRecord &r = b.staged.terms[pixel];
  r.d += film_number(d);
  r.g += film_number(g);
  r.f += film_vector(f);
}

}  // namespace
}  // namespace cotorra
