// SPDX-License-Identifier: GPL-3.0-or-later
// What the exporter derives of meshes, over NumPy arrays. How it is computed is told in tangents.cpp.
#pragma once

#include <nanobind/nanobind.h>

namespace cotorra {

// Adds corner_tangents and are_directions to the module.
void register_geometry(nanobind::module_ &module);

}  // namespace cotorra
