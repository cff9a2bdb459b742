// SPDX-License-Identifier: GPL-3.0-or-later
// One ray of a program: what Embree answers, as a Hit. Surfaces that let rays through stop these, as in Cycles.
// Nothing here knows what the ray is for.
#include "ray_tracer.h"

#include "every_feature.h"

#include "../kernels/program/rays.h"

namespace cotorra {
namespace {

struct EmbreeTracer : RayTracer {
  const embree::Api *rtc = nullptr;
  embree::Scene bvh = nullptr;
  const std::uint32_t *first_instances = nullptr;
  std::uint32_t features = 0;
};

// What the filter knows of the ray under way.
struct RayContext {
  embree::QueryContext query;  // comes first: Embree hands a pointer to it on
  const EmbreeTracer *tracer;
  const ProgramRay *ray;
};

// The instance that an Embree hit belongs to.
uint instance_of(const EmbreeTracer &tracer, const embree::Hit<1> &hit) {
  if (hit.inst_id[0] == embree::kInvalidId) return tracer.first_instances[hit.geom_id[0]];
  return tracer.first_instances[hit.inst_id[0]] + hit.inst_prim_id[0];
}

void filter_ray(const embree::FilterArguments *a) {
  const auto &c = *reinterpret_cast<const RayContext *>(a->context);
  const auto &hit = *static_cast<const embree::Hit<1> *>(a->hit);
  const bool foreign = instance_of(*c.tracer, hit) != c.ray->instance;
  const bool own = !foreign && hit.prim_id[0] == c.ray->triangle;
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
  r.ray.org_x[0] = ray.origin.x;
  r.ray.org_y[0] = ray.origin.y;
  r.ray.org_z[0] = ray.origin.z;
  r.ray.dir_x[0] = ray.direction.x;
  r.ray.dir_y[0] = ray.direction.y;
  r.ray.dir_z[0] = ray.direction.z;
  // A ray that goes on behind a surface must not meet it again: Embree rounds distances once more than it compares
  // them.
  r.ray.tnear[0] = ray.t_min * (1.0f + 1e-6f);
  r.ray.tfar[0] = ray.t_max;
  r.ray.mask[0] = ray.visibility;
  r.hit.geom_id[0] = embree::kInvalidId;
  r.hit.inst_id[0] = embree::kInvalidId;
  tracer.rtc->intersect1(tracer.bvh, &r, &arguments);
  if (r.hit.geom_id[0] == embree::kInvalidId) return false;
  hit.t = r.ray.tfar[0];
  hit.u = r.hit.u[0];
  hit.v = r.hit.v[0];
  hit.triangle = r.hit.prim_id[0];
  hit.instance = instance_of(tracer, r.hit);
  hit.crossed = 0;
  return true;
}

}  // namespace

std::shared_ptr<const RayTracer> make_embree_tracer(const embree::Api &rtc, embree::Scene bvh,
                                                    const std::uint32_t *first_instances, bool instanced) {
  auto tracer = std::make_shared<EmbreeTracer>();
  tracer->trace = trace_one;
  tracer->rtc = &rtc;
  tracer->bvh = bvh;
  tracer->first_instances = first_instances;
  tracer->features =
      embree::kFeatureTriangle | embree::kFeatureFilterInArguments | (instanced ? embree::kFeatureInstanceArray : 0u);
  return tracer;
}

}  // namespace cotorra
