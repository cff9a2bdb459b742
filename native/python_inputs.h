// SPDX-License-Identifier: GPL-3.0-or-later
// Reads the exporter's dataclasses (addon/export/buffers.py, which tells what they mean) as inputs of scenes and
// sessions. Arrays are views of NumPy's memory.
#pragma once

#include <nanobind/nanobind.h>

#include <vector>

#include "scene.h"
#include "session.h"

namespace cotorra {

// Reads a SceneBuffers. `keep` must live until the scene is made: all but the meshes is copied then.
SceneInput read_scene(nanobind::handle buffers, std::vector<nanobind::object> &keep);
CameraInput read_camera(nanobind::handle camera);
SettingsInput read_settings(nanobind::handle settings);

}  // namespace cotorra
