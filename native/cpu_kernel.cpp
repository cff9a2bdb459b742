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
#include "cpu_lane.h"
#include "cpu_occlusion.h"
#include "cpu_passes.h"
#include "cpu_shadows.h"
#include "cpu_staged.h"
#include "cpu_surface.h"
#include "cpu_toon.h"
#include "cpu_visibility.h"
#include "cpu_whitted.h"
#include "cpu_world.h"

namespace cotorra {
namespace {

class Renderer {
 public:
  Renderer(const RenderJob &job, Batch &batch, RayCounts &counts, int x0, int y0)
      : job_(job), scene_(*job.scene), b_(batch), counts_(counts), data_(job_data(job)) {
    block_seed_ = sampler_block_seed(static_cast<uint>(x0), static_cast<uint>(y0), job.sample_bits, job.seed);
    arguments_.feature_mask = job.embree_features;
    if (FEATURE(FEATURE_TRANSPARENCY | FEATURE_LOBES)) {
      begin_alpha(job, data_.integrator, block_seed_, b_.alpha_context);
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
    stage_samples(tracer_, pixels, static_cast<std::size_t>(tile.width), per_pixel);
    if ((job_.features & FEATURE_REWEIGHTING) != 0u) stage_bright(tracer_, pixels, per_pixel);
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
      if (FEATURE(FEATURE_HEALTH)) b_.unwell[i] = 0;
    }
    if (FEATURE(FEATURE_LIGHT_GROUPS)) {
      b_.groups.assign(static_cast<std::size_t>(lane) * job_.passes.light_groups, vec3(0.0f));
    }
    if (FEATURE(FEATURE_TERMS)) {
      b_.lamps.assign(static_cast<std::size_t>(lane) * job_.passes.lamps, vec3(0.0f));
    }
  }

  // ---- Stage 2: the nearest surface.
  void trace(int lanes, bool coherent) {
    arguments_.flags = coherent ? embree::kCoherent : embree::kIncoherent;
    trace_packets(tracer_, b_.packets.data(), lanes, true);
  }

  // ---- Stage 3: what the ray met. Lanes that go on are compacted to the front; returns how many.
  int shade(int lanes, uint bounce) {
    find_hits(tracer_, lanes);
    if (FEATURE(FEATURE_WORLD)) see_background(tracer_, lanes);
    b_.shading.model.present = 0;
    std::size_t next = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      const embree::RayHit<kWidth> &p = b_.packets[i / kWidth];
      const std::size_t k = i % kWidth;
      if (FEATURE(FEATURE_TRANSPARENCY) && p.ray.mask[k] == 0u) continue;  // ended in transparent surfaces
      const Lane lane = lane_at(tracer_, i);
      PathState path = b_.path[i];
      const vec3 origin(p.ray.org_x[k], p.ray.org_y[k], p.ray.org_z[k]);
      const vec3 direction = packet_direction(p, k);
      const Hit &hit = b_.found[i];
      if (wants(FEATURE_WHITTED)) absorb(lane, hit.t, path);
      if (FEATURE(FEATURE_HEALTH) && hit.instance == INVALID_ID) {
        note_world_numbers(tracer_, lane.slot, path, direction);
      }
      if (!meet(lane, path, origin, direction, hit)) continue;
      if (path_is_last(data_.integrator, path)) {  // only brings light home
        if (FEATURE(FEATURE_EMISSIVE_MESHES)) emission(lane, path, hit, direction);
        continue;
      }
      SurfaceTriangle triangle;
      surface_fetch(scene_, hit.instance, hit.triangle, triangle);
      const Material &material = scene_.materials.v[triangle.material];
      if (FEATURE(FEATURE_EMISSIVE_MESHES) && (material.flags & MATERIAL_EMISSIVE) != 0u) {
        emission(lane, path, hit, direction);
      }
      b_.hit.set(next, triangle, hit, direction);
      b_.shading.terminator[next] = triangle.terminator;
      b_.shading.throughput.set(next, path.throughput);
      b_.surface[next].t = hit.t;
      b_.surface[next].instance = hit.instance;
      b_.surface[next].triangle = hit.triangle;
      b_.surface[next].material = triangle.material;
      b_.path[next] = path;
      b_.slot[next] = lane.slot;
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
        if (caustics_left_out(scene_, b_.path[i].ray_kind) != 0u) {
          Material without = material;
          material_leave_out_caustics(scene_, b_.path[i].ray_kind, without);
          bsdf_prepare(scene_, without, s.n, s.ng, b_.shading.wo.get(i), bsdf);
        } else {
          bsdf_prepare(scene_, material, s.n, s.ng, b_.shading.wo.get(i), bsdf);
        }
        if (FEATURE(FEATURE_LOBES)) b_.shading.lobe[i].kind = LOBE_NONE;
        if (FEATURE(FEATURE_PROGRAMS)) bsdf.n_smooth = smooth;
      }
      if (wants(FEATURE_WHITTED)) whitted_prepare(material, scene_.classic.v[s.material], bsdf);
      if (data_.integrator.filter_glossy > 0.0f) {
        path_filter_glossy(data_.integrator, b_.path[i], bsdf, b_.shading.lobe[FEATURE(FEATURE_LOBES) ? i : 0]);
      }
      b_.shading.set_bsdf(i, bsdf);
      const vec3 weight = FEATURE(FEATURE_PROGRAMS) ? b_.shaded[i].weight : vec3(1.0f);
      if (FEATURE(FEATURE_DATA_PASSES)) {
        show_features(lane_at(tracer_, i), b_.path[i], bsdf, b_.shading.lobe_of(i), b_.shading.wo.get(i));
      }
      describe(lane_at(tracer_, i), b_.path[i], s, material, weight, bsdf, b_.shading.lobe_of(i), b_.shading.wo.get(i));
    }
    return count;
  }

  void emission(const Lane &lane, const PathState &path, const Hit &hit, vec3 direction) {
    Surface surface;
    surface_from_hit(scene_, hit, direction, surface);
    if (FEATURE(FEATURE_HEALTH)) note_emission_numbers(tracer_, lane.slot, path, surface, -direction);
    add_emission(lane, path, surface, scene_.materials.v[surface.material], direction);
  }

  // ---- Stage 4: light from lamps and emitting triangles, with shadow rays.
  void light(int lanes, uint bounce) {
    if (lanes == 0) return;
    if (data_.integrator.shadow_roulette > 0.0f) {
      Array<float, kLanes> unused;
      fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_SHADOW), b_.weak.data(), unused.data());
    }
    // Shadow rays part too soon for what Embree does for coherent ones, even those of neighbours to one lamp.
    arguments_.flags = embree::kIncoherent;
    const bool all = scene_.light_count <= LIGHTS_AT_ONCE;
    for (uint l = 0; all && l < scene_.light_count; ++l) sample_light(l, lanes, bounce);
    if (FEATURE(FEATURE_LIGHT_TREE) && (all ? scene_.emitter_count : scene_.tree_picks) > 0) {
      // Rays of a packet go to different lights.
      flush_shadow(tracer_, bounce);
      arguments_.flags = embree::kIncoherent;
      sample_picked_lights(all ? scene_.light_count : 0, bounce == 0 ? scene_.tree_picks : 1, lanes, bounce);
    }
    if (FEATURE(FEATURE_WORLD_LIGHT) && scene_.world_width > 0) sample_world(lanes, bounce);
    flush_shadow(tracer_, bounce);
  }

  uint pair_seed(uint bounce, uint pair) const { return sampler_pair_seed(block_seed_, vertex_pair(bounce, pair)); }

  void sample_light(uint index, int lanes, uint bounce) {
    if (FEATURE(FEATURE_SOFT_LIGHTS)) {
      fill_pairs(b_.random.data(), lanes, pair_seed(bounce, light_pair(scene_, index)), b_.u2.data(), b_.v2.data());
    }
    const Light &light = scene_.lights.v[index];
    const uint scattering = VISIBLE_SCATTERED | (wants(FEATURE_LOBES) ? VISIBLE_TRANSMISSION : 0u);
    if ((light.visibility & scattering) != scattering || light_asks_lanes(light)) {  // rare: one by one
      for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i)
        sample_lane(index, i, vec2(b_.u2[i], b_.v2[i]), bounce);
      return;
    }
    sample_lamp_of(light)(scene_, light, b_.shading, b_.u2.data(), b_.v2.data(), lanes, b_.light);
    if (FEATURE(FEATURE_LIGHT_SHAPES) && (light.flags & LIGHT_SHAPED) != 0u) {
      shape_lamp(scene_.light_shapes.v[index], light, b_.shading, lanes, b_.light);
    }
    if (bounce > light.max_bounces) return;
    const uint mask = (light.flags & LIGHT_CAST_SHADOW) != 0u ? light_shadows(scene_, index) : 0u;
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      const vec3 contribution = b_.light.contribution.get(i);
      if (FEATURE(FEATURE_HEALTH) && bad_light(contribution, INFINITE_DISTANCE) != BAD_KINDS) {
        note_lit(tracer_, i, b_.slot[i], contribution, index);
      }
      if (!carries_light(contribution)) continue;
      if (has_links(scene_) && !light_lights(scene_, index, receiver_set(scene_, b_.surface[i].instance))) continue;
      vec3 origin = b_.light.origin.get(i);
      if (scene_.starts_at_point != 0u) origin = surface_start(scene_, b_.surface[i], b_.light.wi.get(i));
      const float lift = b_.light.lift[i];
      if (lift != 0.0f) {
        const Surface &s = b_.surface[i];
        const vec3 up = lift < 0.0f ? -s.ng : s.ng;
        origin += surface_smooth_lift(scene_, s.instance, s.triangle, s.u, s.v, up) * std::abs(lift);
      }
      queue_shadow(tracer_, {origin, b_.light.distance[i], b_.light.wi.get(i), light.group, contribution, mask}, i,
                   index, bounce);
    }
  }

  void sample_lane(uint index, std::size_t i, vec2 u, uint bounce) {
    ShadowRay ray;
    const bool sent = path_sample_light(scene_, index, b_.path[i], b_.surface[i], b_.shading.bsdf(i),
                                        b_.shading.lobe_of(i), b_.shading.wo.get(i), u, 1.0f, ray);
    if (FEATURE(FEATURE_HEALTH)) note_sample(tracer_, i, ray, index);
    if (sent) queue_shadow(tracer_, ray, i, index, bounce);
  }

  // Samples [first, first + picks) of a vertex, whose lights the tree picks.
  void sample_picked_lights(uint first, uint picks, int lanes, uint bounce) {
    Array<float, kLanes> unused, fresh;
    fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_PICK), unused.data(), fresh.data());
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      b_.light_weights[i] = path_light_weights(scene_, b_.surface[i], b_.shading.lobe_of(i));
    }
    for (uint k = first; k < first + picks; ++k) {
      fill_pairs(b_.random.data(), lanes, pair_seed(bounce, light_pair(scene_, k)), b_.u2.data(), b_.v2.data());
      for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
        float scale;
        vec2 u(b_.u2[i], b_.v2[i]);
        const Lobe &lobe = b_.shading.lobe_of(i);
        const uint light = light_of_slot(lane_at(tracer_, i), k, first + picks, b_.surface[i], lobe,
                                         b_.light_weights[i], fresh[i], u, scale);
        if (light == INVALID_ID) continue;
        ShadowRay ray;
        const bool sent = path_sample_picked(scene_, light, b_.path[i], b_.surface[i], b_.shading.bsdf(i), lobe,
                                             b_.shading.wo.get(i), u, scale, ray);
        if (FEATURE(FEATURE_HEALTH)) {
          const bool lamp = (light & LIGHT_CHILD_LAMPS) != 0u;
          note_sample(tracer_, i, ray, lamp ? light & LIGHT_CHILD_INDEX : kNobody);
        }
        if (sent) queue_shadow(tracer_, ray, i, k, bounce);
      }
    }
  }

  void sample_world(int lanes, uint bounce) {
    fill_pairs(b_.random.data(), lanes, pair_seed(bounce, PAIR_WORLD), b_.u2.data(), b_.v2.data());
    sample_background(tracer_, lanes, b_.u2.data(), b_.v2.data(), bounce);
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      ShadowRay ray;
      const vec3 light = b_.light.contribution.get(i);
      Surface bare = b_.surface[i];
      if (FEATURE(FEATURE_PROGRAMS)) bare.n = b_.shading.n_smooth.get(i);
      const bool sent = world_shadow_ray(scene_, bare, b_.light.wi.get(i), light, ray);
      if (FEATURE(FEATURE_HEALTH)) note_sample(tracer_, i, ray, kNobody);
      if (sent) queue_shadow(tracer_, ray, i, LAST_SHARED_PAIR, bounce);
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
      const uint lobes = FEATURE(FEATURE_PROGRAMS) ? b_.shading.lobes[i] : 0u;
      vec3 origin, direction;
      const LaneBsdf bsdf{b_.shading, i};
      if (!go_on(lane_at(tracer_, i), path, b_.surface[i], bsdf, b_.shading.lobe_of(i), lobes, b_.shading.wo.get(i),
                 sample, roulette[i], origin, direction)) {
        continue;
      }
      start_ray(b_.packets[next / kWidth], next % kWidth, origin, direction, 0.0f, INFINITE_DISTANCE,
                path.ray_kind & VISIBLE_ALL, surface_left(scene_, b_.surface[i], origin, direction));
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
      tone_arrives(lane_at(tracer_, i), b_.surface[i].material, lane_material(tracer_, i), b_.classic->lit[i]);
    }
    for (std::size_t slot = 0; lines && slot < static_cast<std::size_t>(lanes); ++slot) {
      draw_line(lane_of_sample(tracer_, slot), b_.classic->sums[slot]);
    }
  }

  // Ambient light and its occlusion: as a term, as a pass, as the whole picture.
  void ambient(int lanes, uint bounce) {
    const uint always = JOB_OCCLUSION_PICTURE | JOB_AMBIENT_OCCLUDED;
    if ((data_.flags & (bounce == 0 ? always | JOB_OCCLUSION_PASS : always)) != 0u) {
      trace_sky(tracer_, lanes, pair_seed(bounce, PAIR_OCCLUSION));
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes); ++i) {
      const Lane lane = lane_at(tracer_, i);
      vec3 light(0.0f);
      if ((data_.flags & JOB_AMBIENT) != 0u) {
        light = ambient_light(lane, b_.path[i], b_.surface[i].material, lane_material(tracer_, i));
        if ((data_.flags & JOB_AMBIENT_OCCLUDED) == 0u) add_light(lane, light, -1);
      }
      sky_arrives(lane, bounce == 0, light, b_.classic->sky[i]);
    }
  }

  const RenderJob &job_;
  const SceneData &scene_;
  Batch &b_;
  RayCounts &counts_;
  const JobData data_;
  uint block_seed_ = 0;
  embree::QueryArguments arguments_;
  const Tracer tracer_{job_, b_, arguments_, counts_, data_};
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
  if (job.passes.shared) begin_sharing(tile, batch.sharing);
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
  if (job.passes.shared) end_sharing(batch.sharing, batch.staged, tile);
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
