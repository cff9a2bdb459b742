// SPDX-License-Identifier: GPL-3.0-or-later
// Tells Python what a shader became, as dicts and tuples. What they mean to people is told in addon/shader/explain.py.
#pragma once

#include <nanobind/nanobind.h>

#include "scene.h"

namespace cotorra {

// Of shader `index` of the scene; throws std::out_of_range.
nanobind::dict explain_shader(const Scene &scene, std::size_t index);

}  // namespace cotorra
