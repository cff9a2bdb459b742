// SPDX-License-Identifier: GPL-3.0-or-later
// Sets the specialization constants of a SPIR-V module and takes out what they make unreachable, before a driver sees
// it. Drivers do that themselves, but some only after they have inlined all of it. It knows nothing of Vulkan.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cotorra {

// `code`: a module as glslang writes it. `constants`: values of the 32-bit specialization constants by their number.
// The result has no specialization constants, no branch whose condition they decide, and no function that is never
// called. Throws std::runtime_error if the code is no SPIR-V, or has a constant that `constants` lacks.
std::vector<std::uint32_t> specialize_spirv(std::span<const std::uint32_t> code,
                                            std::span<const std::uint32_t> constants);

}  // namespace cotorra
