// SPDX-License-Identifier: GPL-3.0-or-later
// Reads a MaterialModels (addon/export/buffers.py) as spans. Values are checked where records are made of them.
#pragma once

#include <nanobind/nanobind.h>

#include <vector>

#include "scene_models.h"

namespace cotorra {

// None gives no models. `keep` holds the arrays alive.
ModelsInput read_models(nanobind::handle models, std::vector<nanobind::object> &keep);

}  // namespace cotorra
