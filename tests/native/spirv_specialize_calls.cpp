// SPDX-License-Identifier: GPL-3.0-or-later
// spirv_specialize.h for Python: one call, and what it threw.
#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>

#include "spirv_specialize.h"

namespace {
std::string error;
}

extern "C" const char *specialize_error() { return error.c_str(); }

// Words of the result, which never has more than the module; 0: see specialize_error.
extern "C" std::size_t specialize(const std::uint32_t *code, std::size_t length, const std::uint32_t *constants,
                                  std::size_t count, std::uint32_t *out) {
  try {
    const std::vector<std::uint32_t> made = cotorra::specialize_spirv({code, length}, {constants, count});
    if (made.size() > length) throw std::length_error("it grew");
    std::copy(made.begin(), made.end(), out);
    return made.size();
  } catch (const std::exception &e) {
    error = e.what();
    return 0;
  }
}
