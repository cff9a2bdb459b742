// SPDX-License-Identifier: GPL-3.0-or-later
// For sources that use kernels with every feature, as no CPU build of the stages does: include it before any kernel.
// Which features a build of the stages has is CMakeLists.txt's.
#pragma once

#include <cstdint>

namespace cotorra {
namespace {
constexpr std::uint32_t KERNEL_FEATURES = ~0u;
}
}  // namespace cotorra
