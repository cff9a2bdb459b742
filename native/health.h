// SPDX-License-Identifier: GPL-3.0-or-later
// Bad samples by what they are and where they came to be, as sessions count them; see kernels/health.h.
#pragma once

#include <compare>
#include <cstdint>
#include <map>

namespace cotorra {

constexpr std::uint32_t kNobody = ~0u;
constexpr std::uint32_t kWeightArgument = ~0u;
// BadSample.lobe beside LOBE_* and, of a shader, CLOSURE_*: the lobes of bsdf.h.
constexpr std::uint32_t kLobeDiffuse = 64, kLobeGlossy = 65;

struct BadSample {
  std::uint32_t kind = 0;               // BAD_*
  std::uint32_t place = 0;              // HEALTH_*
  std::uint32_t material = kNobody;
  std::uint32_t light = kNobody;        // a lamp
  std::uint32_t bounce = 0;             // vertices before
  std::uint32_t lobe = 0;
  std::uint32_t argument = kWeightArgument;  // HEALTH_SHADER: of the closure
  std::uint32_t op = kNobody;                // BAD_NUMBER: the first of the program that made one
  auto operator<=>(const BadSample &) const = default;
};

using BadCounts = std::map<BadSample, std::uint64_t>;  // samples

// Arguments of a closure of that kind.
std::uint32_t closure_arguments(std::uint32_t kind);

}  // namespace cotorra
