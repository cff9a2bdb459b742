// SPDX-License-Identifier: GPL-3.0-or-later
// The wavefront on a CPU: runs the stages of kernels/integrator.h over a batch of paths, with Embree's packets in
// between. Compiled once for each instruction set and set of features; what FEATURE leaves out leaves no code here.
#include <algorithm>
#include <array>
#include <vector>

#include "cpu_kernel.h"

namespace cotorra {
namespace {
constexpr std::uint32_t KERNEL_FEATURES = COTORRA_KERNEL_FEATURES;
}  // namespace
}  // namespace cotorra

#include "../kernels/integrator.h"
#include "cpu_batch.h"
#include "cpu_camera.h"
#include "cpu_occlusion.h"
#include "cpu_passes.h"
#include "cpu_staged.h"
#include "cpu_surface.h"
#include "cpu_terms.h"
#include "cpu_toon.h"
#include "cpu_visibility.h"
#include "cpu_whitted.h"

namespace cotorra {
namespace {

class Renderer {
 public:
  Renderer(const RenderJob &job, Batch &batch, RayCounts &counts, int x0, int y0)
      : job_(job), scene_(*job.scene), b_(batch), counts_(counts) {
    limits_ = {job.limits.max_bounces,    job.limits.diffuse_bounces,     job.limits.glossy_bounces,
               job.limits.roulette_start, job.limits.transparent_bounces, job.limits.transmission_bounces};
    block_seed_ = sampler_block_seed(static_cast<uint>(x0), static_cast<uint>(y0), job.sample_bits, job.seed);
    arguments_.feature_mask = job.embree_features;
    if (FEATURE(FEATURE_TRANSPARENCY)) {
      begin_alpha(job, block_seed_, b_.alpha_context);
      arguments_.context = &b_.alpha_context.query;
    }
  }

  // Samples [first, first + per_pixel) of `pixels`, which are places in the tile.
  void render(std::span<const std::uint16_t> pixels, const FilmTile &tile, int x_offset, int y_offset, uint first,
              uint per_pixel) {
    begin(pixels, tile, x_offset, y_offset, first, per_pixel);
    int lanes = static_cast<int>(pixels.size() * per_pixel);
    counts_.samples += static_cast<std::uint64_t>(lanes);
    counts_.camera += static_cast<std::uint64_t>(lanes);
    if (is_classic()) {
      classic(lanes);
      lanes = 0;
    }
    for (uint bounce = 0; lanes > 0; ++bounce) {
      trace(lanes, bounce == 0);
      lanes = shade(lanes, bounce);
      light(lanes, bounce);
      if (wants(FEATURE_OCCLUSION)) ambient(lanes, bounce);
      if (!FEATURE(FEATURE_BOUNCES) && !FEATURE(FEATURE_BSDF_RAYS)) break;
      lanes = bounce_rays(lanes, bounce);
      counts_.bounce += static_cast<std::uint64_t>(lanes);
    }
    stage_samples(tracer_, pixels, first, per_pixel);
  }

 private:
  // ---- Stage 1: camera rays.
  void begin(std::span<const std::uint16_t> pixels, const FilmTile &tile, int x_offset, int y_offset, uint first,
             uint per_pixel) {
    int lane = 0;
    for (const std::uint16_t pixel : pixels) {
      const int x = x_offset + pixel % tile.width;
      const int y = y_offset + pixel / tile.width;
      for (uint s = 0; s < per_pixel; ++s, ++lane) {
        const auto i = static_cast<std::size_t>(lane);
        b_.pixel[i] = pixel;
        b_.random[i] = sampler_index(static_cast<uint>(x), static_cast<uint>(y), first + s, job_.sample_bits);
        // Held in u2, v2 until the filter offsets are known.
        b_.u2[i] = static_cast<float>(x) + 0.5f;
        b_.v2[i] = static_cast<float>(y) + 0.5f;
      }
    }
    fill_pairs(b_.random.data(), lane, sampler_pair_seed(block_seed_, PAIR_FILTER), b_.u.data(), b_.v.data());
    camera_packets(job_.camera, scene_.filter_table, lane, b_);
    for (std::size_t i = 0; i < static_cast<std::size_t>(lane); ++i) {
      path_begin(b_.random[i], b_.path[i]);
      b_.slot[i] = static_cast<uint>(i);
      b_.radiance[i] = vec3(0.0f);
      b_.alpha[i] = 1.0f;
    }
    if (FEATURE(FEATURE_LIGHT_GROUPS)) {
      b_.groups.assign(static_cast<std::size_t>(lane) * job_.passes.light_groups, vec3(0.0f));
    }
    if (FEATURE(FEATURE_TERMS)) clear_lamps(job_.passes, lane, b_);
  }

  // ---- Stage 2: the nearest surface.
  void trace(int lanes, bool coherent) {
    arguments_.flags = coherent ? embree::kCoherent : embree::kIncoherent;
    trace_packets(tracer_, b_.packets.data(), lanes, true);
  }

  void add_light(uint slot, vec3 value, int group) {
    b_.radiance[slot] += value;
    if (FEATURE(FEATURE_TERMS)) group = add_lamp(job_.passes, slot, value, group, b_);
    if (FEATURE(FEATURE_LIGHT_GROUPS) && group >= 0 && group < static_cast<int>(job_.passes.light_groups)) {
      b_.groups[slot * job_.passes.light_groups + static_cast<uint>(group)] += value;
    }
  }

  // ---- Stage 3: what the ray met. Lanes that go on are compacted to the front; returns how many.
  int shade(int lanes, uint bounce) {
    std::size_t next = 0;
    const bool meets_lights = bounce == 0 ? job_.camera_meets_lights : (FEATURE(FEATURE_BSDF_RAYS) != 0);
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      const embree::RayHit<kWidth> &p = b_.packets[i / kWidth];
      const std::size_t k = i % kWidth;
      const PathState path = b_.path[i];
      const uint slot = b_.slot[i];
      const vec3 direction(p.ray.dir_x[k], p.ray.dir_y[k], p.ray.dir_z[k]);
      const bool missed = p.hit.geom_id[k] == embree::kInvalidId;
      if (FEATURE(FEATURE_TRANSPARENCY) && p.ray.mask[k] == 0u) continue;  // ended in transparent surfaces

      if (FEATURE(FEATURE_VISIBLE_LIGHTS) && meets_lights) {
        const vec3 origin(p.ray.org_x[k], p.ray.org_y[k], p.ray.org_z[k]);
        meet_lights(path, slot, origin, direction, missed ? INFINITE_DISTANCE : p.ray.tfar[k]);
      }
      if (missed) {
        escape(path, slot, bounce, direction);
        continue;
      }
      const Hit hit = packet_hit(job_, p, k);
      if (path_is_last(limits_, path)) {  // only brings light home
        if (FEATURE(FEATURE_EMISSIVE_MESHES)) emission(path, slot, bounce, hit, direction);
        continue;
      }
      SurfaceTriangle triangle;
      surface_fetch(scene_, hit.instance, hit.triangle, triangle);
      const Material &material = scene_.materials.v[triangle.material];
      if (FEATURE(FEATURE_EMISSIVE_MESHES) && (material.flags & MATERIAL_EMISSIVE) != 0u) {
        emission(path, slot, bounce, hit, direction);
      }
      b_.hit.set(next, triangle, hit, direction);
      b_.shading.terminator[next] = triangle.terminator;
      b_.shading.throughput.set(next, path.throughput);
      b_.surface[next].t = hit.t;
      b_.surface[next].instance = hit.instance;
      b_.surface[next].triangle = hit.triangle;
      b_.surface[next].material = triangle.material;
      b_.path[next] = path;
      b_.slot[next] = slot;
      b_.random[next] = path.random;
      ++next;
    }
    const int count = static_cast<int>(next);
    shape_surfaces(b_.hit, count, b_.shading);
    for (std::size_t i = 0; i < next; ++i) {
      Surface &s = b_.surface[i];
      s.p = b_.shading.p.get(i);
      s.ng = b_.shading.ng.get(i);
      s.n = b_.shading.n.get(i);
      s.epsilon = b_.shading.epsilon[i];
      s.terminator = b_.shading.terminator[i];
      s.side = b_.hit.side[i];
      s.u = b_.hit.u[i];
      s.v = b_.hit.v[i];
    }
    if (FEATURE(FEATURE_PROGRAMS)) {
      Array<float, kLanes> choice, unused;
      fill_pairs(b_.random.data(), count, pair_seed(bounce, PAIR_CLOSURE), choice.data(), unused.data());
      draw_surfaces(tracer_, count, choice.data());
    }
    for (std::size_t i = 0; i < next; ++i) {
      const Surface &s = b_.surface[i];
      const Material &material = FEATURE(FEATURE_PROGRAMS) ? b_.shaded[i].material : scene_.materials.v[s.material];
      Bsdf bsdf;
      if (FEATURE(FEATURE_PROGRAMS) && b_.shaded[i].kind != CLOSURE_KINDS) {
        bsdf = b_.shading.bsdf(i);
      } else {
        const vec3 smooth = b_.shading.n.get(i);
        bsdf_prepare(scene_, material, s.n, s.ng, b_.shading.wo.get(i), bsdf);
        if (FEATURE(FEATURE_LOBES)) b_.shading.lobe[i].kind = LOBE_NONE;
        if (FEATURE(FEATURE_PROGRAMS)) bsdf.n_smooth = smooth;
      }
      if (wants(FEATURE_WHITTED)) whitted_prepare(material, scene_.classic.v[s.material], bsdf);
      b_.shading.set_bsdf(i, bsdf);
      if (FEATURE(FEATURE_DATA_PASSES) && bounce == 0) {
        const vec3 weight = FEATURE(FEATURE_PROGRAMS) ? b_.shaded[i].weight : vec3(1.0f);
        record_surface(tracer_, b_.slot[i], s, material, bsdf.diffuse * weight * PI);
      }
      if (FEATURE(FEATURE_TERMS) && bounce == 0 && job_.passes.terms) {
        record_terms(scene_, s.p, bsdf, b_.shading.wo.get(i), b_.pixel[b_.slot[i]], b_);
      }
    }
    return count;
  }

  void emission(const PathState &path, uint slot, uint bounce, const Hit &hit, vec3 direction) {
    Surface surface;
    surface_from_hit(scene_, hit, direction, surface);
    const Material &material = scene_.materials.v[surface.material];
    if ((material.flags & MATERIAL_EMISSIVE) == 0u) return;
    const vec3 emitted = path_emission(scene_, path, surface, material, -direction, hit.t);
    add_light(slot, emitted, scene_.instances.v[hit.instance].light_group);
    if (FEATURE(FEATURE_DATA_PASSES) && bounce == 0 && job_.passes.emission) {
      b_.staged.emission[b_.pixel[slot]] += film_vector(emitted);
    }
  }

  void meet_lights(const PathState &path, uint slot, vec3 origin, vec3 direction, float t) {
    for (uint l = 0; l < scene_.light_count; ++l) {
      int group;
      const vec3 seen = path_meet_light(scene_, l, path, origin, direction, t, group);
      if (is_black(seen)) continue;
      add_light(slot, seen, group);
      if (FEATURE(FEATURE_DATA_PASSES) && path.bounce == 0 && job_.passes.emission) {
        b_.staged.emission[b_.pixel[slot]] += film_vector(seen);
      }
    }
  }

  void escape(const PathState &path, uint slot, uint bounce, vec3 direction) {
    if (FEATURE(FEATURE_WORLD)) {
      const vec3 world = path_escape(scene_, path, direction);
      if (FEATURE(FEATURE_DATA_PASSES) && bounce == 0 && job_.passes.environment) {
        b_.staged.environment[b_.pixel[slot]] += film_vector(world);
      }
      if (bounce > 0 || !job_.transparent) add_light(slot, world, scene_.world_group);
    }
    if (bounce == 0) b_.alpha[slot] = 0.0f;
  }

  // ---- Stage 4: light from lamps and emitting triangles, with shadow rays.
  void light(int lanes, uint bounce) {
    if (lanes == 0) return;
    const bool all = scene_.light_count <= job_.lights_at_once;
    arguments_.flags = bounce == 0 ? embree::kCoherent : embree::kIncoherent;
    if (all) {
      for (uint l = 0; l < scene_.light_count; ++l) sample_light(l, lanes, bounce);
    } else {
      sample_picked_lights(lanes, bounce);
    }
    if (FEATURE(FEATURE_EMISSIVE_MESHES) && scene_.emitter_count > 0) sample_emitters(lanes, bounce);
    flush_shadow(bounce);
  }

  uint pair_seed(uint bounce, uint pair) const { return sampler_pair_seed(block_seed_, vertex_pair(bounce, pair)); }

  void sample_light(uint index, int lanes, uint bounce) {
    if (FEATURE(FEATURE_SOFT_LIGHTS)) {
      fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_LIGHTS + index % LAST_SHARED_PAIR), b_.u2.data(),
                 b_.v2.data());
    }
    const Light &light = scene_.lights.v[index];
    const uint scattering = VISIBLE_SCATTERED | (wants(FEATURE_LOBES) ? VISIBLE_TRANSMISSION : 0u);
    if ((light.visibility & scattering) != scattering) {  // rare: lobe by lobe
      for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i)
        sample_lane(index, i, vec2(b_.u2[i], b_.v2[i]), 1.0f, bounce);
      return;
    }
    sample_lamp_of(light)(scene_, light, b_.shading, b_.u2.data(), b_.v2.data(), lanes, b_.light);
    if (FEATURE(FEATURE_LIGHT_SHAPES) && (light.flags & LIGHT_SHAPED) != 0u) {
      shape_lamp(scene_.light_shapes.v[index], light, b_.shading, lanes, b_.light);
    }
    if (bounce > light.max_bounces) return;
    const uint mask = (light.flags & LIGHT_CAST_SHADOW) != 0u ? VISIBLE_SHADOW : 0u;
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      const vec3 contribution = b_.light.contribution.get(i);
      if (!(max_component(contribution) > 0.0f)) continue;
      vec3 origin = b_.light.origin.get(i);
      if (b_.light.lift[i] > 0.0f) {
        const Surface &s = b_.surface[i];
        origin += surface_smooth_lift(scene_, s.instance, s.triangle, s.u, s.v, s.ng) * b_.light.lift[i];
      }
      queue_shadow({origin, b_.light.distance[i], b_.light.wi.get(i), light.group, contribution, mask}, i, bounce);
    }
  }

  void sample_lane(uint index, std::size_t i, vec2 u, float scale, uint bounce) {
    ShadowRay ray;
    if (path_sample_light(scene_, index, b_.path[i], b_.surface[i], b_.shading.bsdf(i), b_.shading.lobe_of(i),
                          b_.shading.wo.get(i), u, scale, ray)) {
      queue_shadow(ray, i, bounce);
    }
  }

  void sample_picked_lights(int lanes, uint bounce) {
    // The first vertex fills the picture: it gets several lamps, stratified over their importance.
    const uint picks = bounce == 0 ? job_.lights_at_once : 1u;
    Array<float, kLanes> pick, unused;
    fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_PICK), pick.data(), unused.data());
    for (uint k = 0; k < picks; ++k) {
      fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_LIGHTS + k), b_.u2.data(), b_.v2.data());
      for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
        float scale;
        const float u = (static_cast<float>(k) + pick[i]) / static_cast<float>(picks);
        const uint index =
            path_pick_light(scene_, b_.surface[i], scatters_through(b_.shading.lobe_of(i)), min(u, 0.99999994f), scale);
        if (index != INVALID_ID) {
          sample_lane(index, i, vec2(b_.u2[i], b_.v2[i]), scale / static_cast<float>(picks), bounce);
        }
      }
    }
  }

  void sample_emitters(int lanes, uint bounce) {
    Array<float, kLanes> pick, unused;
    fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_PICK), unused.data(), pick.data());
    fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_EMITTER), b_.u2.data(), b_.v2.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      ShadowRay ray;
      if (path_sample_emitter(scene_, b_.path[i], b_.surface[i], b_.shading.bsdf(i), b_.shading.lobe_of(i),
                              b_.shading.wo.get(i), pick[i], vec2(b_.u2[i], b_.v2[i]), ray)) {
        queue_shadow(ray, i, bounce);
      }
    }
  }

  void queue_shadow(const ShadowRay &ray, std::size_t lane, uint bounce) {
    const uint slot = b_.slot[lane];
    if (ray.visibility == 0u) {
      arrive(slot, ray.contribution, ray.group, bounce, true);
      return;
    }
    const auto k = static_cast<std::size_t>(b_.shadow_count);
    b_.shadow.org_x[k] = ray.origin.x;
    b_.shadow.org_y[k] = ray.origin.y;
    b_.shadow.org_z[k] = ray.origin.z;
    b_.shadow.dir_x[k] = ray.direction.x;
    b_.shadow.dir_y[k] = ray.direction.y;
    b_.shadow.dir_z[k] = ray.direction.z;
    b_.shadow.tnear[k] = 0.0f;
    b_.shadow.tfar[k] = ray.t_max;
    b_.shadow.time[k] = 0.0f;
    b_.shadow.mask[k] = ray.visibility;
    b_.shadow_slot[k] = slot;
    b_.shadow_contribution[k] = ray.contribution;
    b_.shadow_group[k] = ray.group;
    if (FEATURE(FEATURE_TRANSPARENCY)) b_.shadow_paths[k] = &b_.path[lane];
    if (++b_.shadow_count == kWidth) flush_shadow(bounce);
  }

  void flush_shadow(uint bounce) {
    if (b_.shadow_count == 0) return;
    alignas(64) int valid[kWidth];
    for (int k = 0; k < kWidth; ++k) valid[k] = k < b_.shadow_count ? -1 : 0;
    if (b_.recording) b_.recorded.push_back({{b_.shadow, {}}, b_.shadow_count, arguments_.flags, true});
    embree::Ray<kWidth> asked;
    if (FEATURE(FEATURE_WHITTED)) asked = b_.shadow;
    if (FEATURE(FEATURE_TRANSPARENCY)) b_.alpha_context.shadow_paths = b_.shadow_paths;
    occluded(*job_.rtc, valid, job_.bvh, &b_.shadow, &arguments_);
    if (FEATURE(FEATURE_WHITTED) && job_.classic.transparent_shadows) {
      see_through(tracer_, asked, b_.shadow_count, b_.shadow, b_.shadow_contribution.data());
    }
    for (std::size_t k = 0; k < static_cast<std::size_t>(b_.shadow_count); ++k) {
      if (FEATURE(FEATURE_TRANSPARENCY)) dim_shadow(k, bounce);
      // Embree sets tfar to -infinity where something is in the way.
      arrive(b_.shadow_slot[k], b_.shadow_contribution[k], b_.shadow_group[k], bounce, b_.shadow.tfar[k] >= 0.0f);
    }
    counts_.shadow += static_cast<std::uint64_t>(b_.shadow_count);
    b_.shadow_count = 0;
  }

  // Takes out of the shadow ray's light what transparent surfaces kept of it.
  void dim_shadow(std::size_t k, uint bounce) {
    const vec3 kept = light_kept(arguments_, k);
    if (FEATURE(FEATURE_DATA_PASSES) && bounce == 0 && job_.passes.shadow && b_.shadow.tfar[k] >= 0.0f) {
      b_.staged.shadow[b_.pixel[b_.shadow_slot[k]]].unshadowed +=
          film_number(luminance(b_.shadow_contribution[k] * (vec3(1.0f) - kept)));
    }
    if (b_.shadow.tfar[k] >= 0.0f) b_.shadow_contribution[k] *= kept;
  }

  void arrive(uint slot, vec3 contribution, int group, uint bounce, bool lit) {
    if (lit) add_light(slot, contribution, group);
    if (FEATURE(FEATURE_DATA_PASSES) && bounce == 0 && job_.passes.shadow) {
      ShadowRecord &r = b_.staged.shadow[b_.pixel[slot]];
      const float l = film_number(luminance(contribution));
      r.unshadowed += l;
      r.lit += lit ? l : 0.0f;
    }
  }

  // ---- Stage 5: the next ray of each path. Returns how many go on.
  int bounce_rays(int lanes, uint bounce) {
    fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_BSDF), b_.u2.data(), b_.v2.data());
    Array<float, kLanes> choice, roulette;
    fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_CHOICE), choice.data(), roulette.data());
    sample_bsdf(scene_, b_.shading, choice.data(), b_.u2.data(), b_.v2.data(), lanes, b_.bounce);
    std::size_t next = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      PathState path = b_.path[i];
      const BsdfSample sample{b_.bounce.wi.get(i), b_.bounce.pdf[i], b_.bounce.weight.get(i), b_.bounce.lobe[i]};
      vec3 origin;
      if (FEATURE(FEATURE_PROGRAMS) && (b_.shading.lobes[i] & BSDF_THROUGH) != 0u) {
        const vec3 wo = b_.shading.wo.get(i);
        if (!path_pass(scene_, path, b_.surface[i], wo, origin)) continue;
        start_ray(b_.packets[next / kWidth], next % kWidth, origin, -wo, 0.0f, INFINITE_DISTANCE,
                  path.ray_kind & VISIBLE_ALL);
        b_.path[next] = path;
        b_.slot[next] = b_.slot[i];
        ++next;
        continue;
      }
      if (!path_advance(scene_, limits_, path, b_.surface[i], sample, roulette[i], origin)) continue;
      if (scene_.light_kinds != 0u)
        path_note_kind(b_.shading.bsdf(i), b_.shading.lobe_of(i), b_.shading.wo.get(i), sample.wi, path);
      // A last ray can only bring light home: where there is none to find, it need not be traced.
      const bool finds =
          FEATURE(FEATURE_BSDF_RAYS) && (job_.last_rays_find_light || (path.ray_kind & RAY_MEETS_LAMPS) != 0u);
      if (!finds && path_is_last(limits_, path)) continue;
      start_ray(b_.packets[next / kWidth], next % kWidth, origin, sample.wi, 0.0f, INFINITE_DISTANCE,
                path.ray_kind & VISIBLE_ALL);
      b_.path[next] = path;
      b_.slot[next] = b_.slot[i];
      ++next;
    }
    return static_cast<int>(next);
  }

  // ---- The integrators beside Direct and Path.

  // Is this feature both built and asked for? Most are harmless where a scene does without; these change the picture.
  bool wants(uint feature) const { return FEATURE(feature) && (job_.features & feature) != 0u; }
  bool is_classic() const {
    return wants(FEATURE_WHITTED) || wants(FEATURE_TOON) ||
           (wants(FEATURE_OCCLUSION) && job_.classic.integrator == Integrator::kOcclusion);
  }

  // All of one batch of camera rays.
  void classic(int lanes) {
    if (wants(FEATURE_WHITTED)) {
      whitted(lanes);
      return;
    }
    trace(lanes, true);
    if (wants(FEATURE_TOON)) {
      toon(lanes);
    } else {
      ambient(shade(lanes, 0), 0);
    }
  }

  void whitted(int lanes) {
    std::fill_n(b_.classic->medium.data(), lanes, INVALID_ID);
    for (uint bounce = 0; lanes > 0; bounce = lanes > 0 ? b_.path[0].bounce : 0) {
      trace(lanes, bounce == 0);
      absorb(tracer_, lanes);
      const int met = shade(lanes, bounce);
      light(met, bounce);
      if (wants(FEATURE_OCCLUSION)) ambient(met, bounce);
      store_children(tracer_, met);
      lanes = start_pending(tracer_);
      counts_.bounce += static_cast<std::uint64_t>(lanes);
    }
  }

  void toon(int lanes) {
    const bool lines = job_.classic.outlines != 0;
    if (lines) gather_outlines(tracer_, lanes);
    const int met = shade(lanes, 0);
    count_lamps(tracer_, met);
    if (wants(FEATURE_OCCLUSION)) ambient(met, 0);
    for (std::size_t i = 0; i < static_cast<std::size_t>(met); ++i) {
      const Surface &s = b_.surface[i];
      const ClassicMaterial &classic = scene_.classic.v[s.material];
      const vec3 tone = toon_color(lane_material(tracer_, i), classic, b_.classic->lit[i], scene_.light_count);
      add_light(b_.slot[i], tone, -1);
    }
    const float reach = job_.classic.outline_y / job_.classic.rows;
    for (std::size_t slot = 0; lines && slot < static_cast<std::size_t>(lanes); ++slot) {
      if (!outline_found(b_.classic->sums[slot], job_.classic.outlines, reach)) continue;
      b_.radiance[slot] = job_.classic.outline_color;
      b_.alpha[slot] = 1.0f;  // a line covers what is behind it, and the transparent film
    }
  }

  // Ambient light and its occlusion: as a term, as a pass, as the whole picture.
  void ambient(int lanes, uint bounce) {
    const ClassicJob &c = job_.classic;
    const bool picture = c.integrator == Integrator::kOcclusion;
    const bool pass = bounce == 0 && job_.passes.occlusion;
    const bool term = !is_black(c.ambient);
    if (picture || pass || (term && c.occluded)) trace_sky(tracer_, lanes, pair_seed(bounce, PAIR_OCCLUSION));
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      const Surface &s = b_.surface[i];
      const float sky = b_.classic->sky[i];
      if (term) {
        const vec3 light = ambient_term(lane_material(tracer_, i), scene_.classic.v[s.material], c.ambient);
        add_light(b_.slot[i], b_.path[i].throughput * light * (c.occluded ? sky : 1.0f), -1);
      }
      if (pass) b_.staged.occlusion[b_.pixel[b_.slot[i]]] += sky;
      if (picture) b_.radiance[b_.slot[i]] = vec3(sky);
    }
  }

  const RenderJob &job_;
  const SceneData &scene_;
  Batch &b_;
  RayCounts &counts_;
  IntegratorData limits_{};
  uint block_seed_ = 0;
  embree::QueryArguments arguments_;
  const Tracer tracer_{job_, b_, arguments_, counts_};
};

std::unique_ptr<Workspace> make_workspace(const RenderJob &job) {
  auto batch = std::make_unique<Batch>();
  if ((KERNEL_FEATURES & job.features & (FEATURE_WHITTED | FEATURE_OCCLUSION | FEATURE_TOON)) != 0u) {
    batch->classic = std::make_unique<ClassicLanes>();
    batch->classic->pending.resize(job.classic.depth + 1u);
  }
  if ((KERNEL_FEATURES & job.features & FEATURE_PROGRAMS) != 0u) {
    batch->programs = std::make_unique<ProgramLanes>();
    batch->programs->registers.resize(std::size_t{job.program_registers} * kProgramStride);
  }
  return batch;
}

// Samples into batch.staged. Returns false if cancelled.
bool render_staged(const RenderJob &job, const FilmTile &tile, std::uint32_t first, std::uint32_t count, Batch &batch,
                   RayCounts &counts) {
  const int x_offset = job.region_x + tile.x0;
  const int y_offset = job.region_y + tile.y0;
  batch.staged.clear_as(tile);
  Renderer renderer(job, batch, counts, x_offset, y_offset);
  const std::span<const std::uint16_t> pixels(tile.to_sample());
  // Samples of one pixel lie side by side in a packet, so that its rays stay together.
  const std::uint32_t per_pixel = std::min(count, 16u);
  const std::size_t pixels_at_once = kLanes / per_pixel;
  for (std::uint32_t done = 0; done < count; done += per_pixel) {
    const std::uint32_t samples = std::min(per_pixel, count - done);
    for (std::size_t p = 0; p < pixels.size(); p += pixels_at_once) {
      if (job.cancel->load(std::memory_order_relaxed)) return false;
      renderer.render(pixels.subspan(p, std::min(pixels_at_once, pixels.size() - p)), tile, x_offset, y_offset,
                      first + done, samples);
    }
  }
  return true;
}

bool render(const RenderJob &job, FilmTile &tile, std::uint32_t first, std::uint32_t count, Workspace &workspace,
            RayCounts &counts) {
  Batch &batch = static_cast<Batch &>(workspace);
  if (job.measure_tracing) {
    // Once more before it counts, to note the rays; then Embree alone on them, and the whole work.
    RayCounts unused;
    batch.recording = true;
    const bool whole = render_staged(job, tile, first, count, batch, unused);
    batch.recording = false;
    if (whole) trace_again(job, batch, counts);
    batch.recorded.clear();
  }
  const auto begin = std::chrono::steady_clock::now();
  if (!render_staged(job, tile, first, count, batch, counts)) return false;
  tile.add(batch.staged, count);
  counts.busy_seconds += seconds_since(begin);
  return true;
}

}  // namespace

extern const CpuKernel COTORRA_KERNEL_NAME;
const CpuKernel COTORRA_KERNEL_NAME = {COTORRA_KERNEL_ISA, COTORRA_KERNEL_LEVEL, KERNEL_FEATURES,
                                       sizeof(Batch),      make_workspace,       render};

}  // namespace cotorra
