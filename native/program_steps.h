// SPDX-License-Identifier: GPL-3.0-or-later
// How much work a program is, counted from its code: what may run it in millions of places asks first.
// It is a number of steps, the same on every machine, and no time.
#pragma once

#include "../kernels/scene_types.h"

namespace cotorra {

// About how many corners and cells of textures the program visits for one point, beside one step for each op.
double program_steps(const SceneData &scene, const ProgramPart &part, uint constants);

}  // namespace cotorra
