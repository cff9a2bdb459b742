// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses among the CPU builds of the kernels: highest instruction set that runs here, fewest features that suffice.
#include <bit>
#include <cstdlib>
#include <stdexcept>

#include "cpu_kernel.h"
#include "cpu_program.h"

namespace cotorra {

#define COTORRA_KERNEL(NAME) extern const CpuKernel NAME;
#define COTORRA_PROGRAM(NAME, LEVEL) extern const RunProgram NAME;
#include "cpu_kernel_list.inc"
#undef COTORRA_KERNEL
#undef COTORRA_PROGRAM

namespace {
#define COTORRA_KERNEL(NAME) &NAME,
#define COTORRA_PROGRAM(NAME, LEVEL)
const CpuKernel *const kKernels[] = {
#include "cpu_kernel_list.inc"
};
#undef COTORRA_KERNEL
#undef COTORRA_PROGRAM

constexpr const char *kNoHealth = "This build of Cotorra has no kernels that count bad samples";
constexpr const char *kTooOld = "This processor lacks SSE 4.2 (x86-64-v2), which Cotorra needs";
}  // namespace

std::span<const CpuKernel *const> cpu_kernels() { return kKernels; }

std::uint32_t cpu_isa_level() {
  std::uint32_t level = 0;
#if defined(__x86_64__) || defined(_M_X64)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v2")) level = 2;
  if (__builtin_cpu_supports("x86-64-v3")) level = 3;
  if (__builtin_cpu_supports("x86-64-v4")) level = 4;
#else
  level = 2;
#endif
  if (const char *limit = std::getenv("COTORRA_ISA"); limit != nullptr && limit[0] >= '2' && limit[0] <= '4') {
    level = std::min(level, static_cast<std::uint32_t>(limit[0] - '0'));
  }
  return level;
}

const CpuKernel &choose_cpu_kernel(std::uint32_t features) {
  const std::uint32_t level = cpu_isa_level();
  const CpuKernel *best = nullptr;
  for (const CpuKernel *kernel : kKernels) {
    if (kernel->isa_level > level || (features & ~kernel->features) != 0) continue;
    const bool better =
        best == nullptr || kernel->isa_level > best->isa_level ||
        (kernel->isa_level == best->isa_level && std::popcount(kernel->features) < std::popcount(best->features));
    if (better) best = kernel;
  }
  if (best == nullptr && (features & FEATURE_HEALTH) != 0u) throw std::runtime_error(kNoHealth);
  if (best == nullptr) throw std::runtime_error(kTooOld);
  return *best;
}

RunProgram choose_cpu_program() {
  const std::uint32_t level = cpu_isa_level();
  RunProgram best = nullptr;  // levels are listed from the lowest
#define COTORRA_KERNEL(NAME)
#define COTORRA_PROGRAM(NAME, LEVEL) \
  if (LEVEL <= level) best = NAME;
#include "cpu_kernel_list.inc"
#undef COTORRA_KERNEL
#undef COTORRA_PROGRAM
  if (best == nullptr) throw std::runtime_error(kTooOld);
  return best;
}

}  // namespace cotorra
