// SPDX-License-Identifier: GPL-3.0-or-later
// Which meshes have triangles that lie in one plane with others and overlap them, such as glass that stands on a floor.
#pragma once

#include <span>
#include <vector>

#include "../kernels/scene_types.h"

namespace cotorra {

// By mesh. Planes are one where the starts of their rays, which are rounded, are in one. True as well where finding out
// would take too long: in scenes of many millions of triangles, and of flat parts that are finely divided.
std::vector<bool> coplanar_meshes(std::span<const Mesh> meshes, std::span<const Instance> instances);

// The same of triangles that face one way, as of two opaque tops in one place: an opaque thing hides what it stands on.
// False where finding out would take too long: in scenes of more than 100,000 triangles or 1,000 objects, and within a
// mesh of more than 1,000.
std::vector<bool> coinciding_meshes(std::span<const Mesh> meshes, std::span<const Instance> instances);

}  // namespace cotorra
