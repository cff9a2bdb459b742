// SPDX-License-Identifier: GPL-3.0-or-later
// The kernels' reflection models over NumPy arrays: for tests, charts and the curious. Rendering does not use it.
#pragma once

#include <nanobind/nanobind.h>

namespace cotorra {

// Adds evaluate_model, sample_model and model_terms to the module.
void register_laboratory(nanobind::module_ &module);

}  // namespace cotorra
