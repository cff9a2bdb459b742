// SPDX-License-Identifier: GPL-3.0-or-later
// Skies over NumPy arrays, for the exporter. How they are computed is told in sky.cpp.
#pragma once

#include <nanobind/nanobind.h>

namespace cotorra {

// Adds sky to the module.
void register_sky(nanobind::module_ &module);

}  // namespace cotorra
