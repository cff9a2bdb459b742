// SPDX-License-Identifier: GPL-3.0-or-later
// Reads a Materials and its MaterialModels (addon/export/buffers.py) as spans. Values are checked where records are
// made of them.
#pragma once

#include <nanobind/nanobind.h>

#include <vector>

#include "scene.h"

namespace cotorra {

// None gives no models. `keep` holds the arrays alive.
ModelsInput read_models(nanobind::handle models, std::vector<nanobind::object> &keep);

MaterialsInput read_materials(nanobind::handle materials, std::vector<nanobind::object> &keep);

}  // namespace cotorra
