// SPDX-License-Identifier: GPL-3.0-or-later
// What a session's integrator asks of the kernels: limits, features, and the settings of those beside Path.
// How they render is told by the kernels and cpu_*.h.
#pragma once

#include "scene.h"
#include "session.h"

namespace cotorra {

// Fills the job's limits, features and ClassicJob; takes from the session's view of the scene what the integrator
// leaves out. Throws std::invalid_argument naming the setting that is wrong.
void apply_integrator(const SettingsInput &settings, const CameraInput &camera, const Scene &scene, RenderJob &job,
                      SceneData &data);

}  // namespace cotorra
