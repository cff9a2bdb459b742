// SPDX-License-Identifier: GPL-3.0-or-later
// Names for the feature bits of kernels/scene_types.h, and the reason for each that a scene goes without.
// For people; nothing is decided here.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cotorra {

std::vector<std::string> feature_names(std::uint32_t features);
// The bits of such names. Throws std::invalid_argument naming one that is unknown.
std::uint32_t features_of(const std::vector<std::string> &names);
// "name: why", for what is off.
std::vector<std::string> left_out(std::uint32_t features);

}  // namespace cotorra
