// SPDX-License-Identifier: GPL-3.0-or-later
// Reads shaders, images and attributes (addon/export/buffers.py) as views of NumPy's memory.
// Values are checked where records are made of them.
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <vector>

#include "images.h"

namespace cotorra {

// Makes objects that are kept alive one owner, which gives them back under the GIL.
using MakeOwner = std::shared_ptr<void> (*)(std::vector<nanobind::object>);

// The shaders and images of `buffers`, and what they ask of instances; empty where there is none. `keep` holds alive
// what is copied later; images have owners of their own.
ProgramsInput read_programs(nanobind::handle buffers, MakeOwner make_owner, std::vector<nanobind::object> &keep);
// The attributes of a mesh.
std::vector<AttributeInput> read_attributes(nanobind::handle mesh, std::vector<nanobind::object> &keep);

}  // namespace cotorra
