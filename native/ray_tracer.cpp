// SPDX-License-Identifier: GPL-3.0-or-later
// One ray of a program: what Embree answers, as a Hit. Surfaces that let rays through stop these, as in Cycles.
// Nothing here knows what the ray is for.
#include "ray_tracer.h"

#include "every_feature.h"

#include "../kernels/program/rays.h"
#include "quads.h"

namespace cotorra {
namespace {

struct EmbreeTracer : RayTracer {
  const embree::Api *rtc = nullptr;
  embree::Scene bvh = nullptr;
  const EmbreeGeometry *geometries = nullptr;
  std::uint32_t features = 0;
};

// What the filter knows of the ray under way.
struct RayContext {
  embree::QueryContext query;  // comes first: Embree hands a pointer to it on
  const EmbreeTracer *tracer;
  const ProgramRay *ray;
};

Hit hit_of(const EmbreeTracer &tracer, float t, const embree::Hit<1> &h) {
  return traced_hit(tracer.geometries, {vec3(h.ng_x[0], h.ng_y[0], h.ng_z[0]), t, h.u[0], h.v[0], h.prim_id[0],
                                        h.geom_id[0], h.inst_id[0], h.inst_prim_id[0]});
}

void filter_ray(const embree::FilterArguments *a) {
  const auto &c = *reinterpret_cast<const RayContext *>(a->context);
  const Hit hit = hit_of(*c.tracer, 0.0f, *static_cast<const embree::Hit<1> *>(a->hit));
  const bool foreign = hit.instance != c.ray->instance;
  const bool own = !foreign && hit.triangle == c.ray->triangle;
  const uint passes = c.ray->passes;
  if ((foreign && (passes & RAY_ONLY_LOCAL) != 0u) || (own && (passes & RAY_SKIPS_OWN) != 0u)) a->valid[0] = 0;
}

bool trace_one(const RayTracer &base, const ProgramRay &ray, Hit &hit) {
  const auto &tracer = static_cast<const EmbreeTracer &>(base);
  RayContext context{{}, &tracer, &ray};
  embree::QueryArguments arguments;
  arguments.feature_mask = tracer.features;
  arguments.context = &context.query;
  if (ray.passes != 0u) arguments.filter = reinterpret_cast<void *>(static_cast<embree::Filter>(filter_ray));
  embree::RayHit<1> r{};
  // A ray that goes on behind a surface must not meet it again: Embree rounds distances once more than it compares
  // them.
  embree::set_ray(r.ray, 0, ray.origin, ray.direction, ray.t_min * (1.0f + 1e-6f), ray.t_max, ray.visibility);
  embree::set_missed(r.hit, 0);
  tracer.rtc->intersect1(tracer.bvh, &r, &arguments);
  if (r.hit.geom_id[0] == embree::kInvalidId) return false;
  hit = hit_of(tracer, r.ray.tfar[0], r.hit);
  return true;
}

}  // namespace

std::shared_ptr<const RayTracer> make_embree_tracer(const embree::Api &rtc, embree::Scene bvh,
                                                    const EmbreeGeometry *geometries, bool instanced) {
  auto tracer = std::make_shared<EmbreeTracer>();
  tracer->trace = trace_one;
  tracer->rtc = &rtc;
  tracer->bvh = bvh;
  tracer->geometries = geometries;
  tracer->features =
      embree::kFeatureQuad | embree::kFeatureFilterInArguments | (instanced ? embree::kFeatureInstanceArray : 0u);
  return tracer;
}

}  // namespace cotorra
