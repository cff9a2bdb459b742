// SPDX-License-Identifier: GPL-3.0-or-later
// Traces the rays of programs through Embree, one at a time. Which rays those are is kernels/program/rays.h's; the rays
// of paths go in packets (cpu_kernel.cpp).
#pragma once

#include <memory>

#include "embree.h"

namespace cotorra {

struct RayTracer;
struct EmbreeGeometry;

// geometries: as in scene.h. All of it must stay as long as the tracer.
std::shared_ptr<const RayTracer> make_embree_tracer(const embree::Api &rtc, embree::Scene bvh,
                                                    const EmbreeGeometry *geometries, bool instanced);

}  // namespace cotorra
