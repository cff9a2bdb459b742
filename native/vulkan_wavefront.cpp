// SPDX-License-Identifier: GPL-3.0-or-later
// The wavefront of kernels/entry/vulkan/*.comp: batches of samples, a few stages in each submission, so that none takes
// long. Sums of samples come back to the film's tiles after each pass; no result depends on how many lanes there are.
#include "vulkan_wavefront.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <future>
#include <optional>

#include "scene.h"
#include "vulkan_acceleration.h"
#include "vulkan_film.h"
#include "vulkan_pipelines.h"
#include "vulkan_scene.h"
#include "wide_bvh.h"

#include "every_feature.h"

#include "../kernels/wavefront.h"
#include "job_data.h"

namespace cotorra::vulkan {
namespace {

using Clock = std::chrono::steady_clock;

// A submission should take between these, in seconds: cancelling must be quick, and no watchdog may bark.
constexpr double kShortest = 0.02;
constexpr double kLongest = 0.06;
constexpr std::uint32_t kFewestLanes = 1 << 10;
constexpr std::uint32_t kFirstLanes = 1 << 12;
constexpr std::uint32_t kMostLanes = 1 << 20;
constexpr std::uint32_t kMostLanesOfCpu = 1 << 15;  // where the device is a processor, its caches like few lanes
constexpr std::uint32_t kMostBounces = 16;  // of one submission
constexpr std::uint64_t kPathMemory = 8;  // of a card's memory, at most this part for lanes

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

class WavefrontOnCard final : public Wavefront {
 public:
  WavefrontOnCard(const Scene &scene, const RenderJob &job, const DeviceChoice &choice,
                  std::shared_ptr<Instance> instance, const Physical &physical, bool ray_query, SharedFigures &figures)
      : scene_(scene),
        job_(job),
        figures_(figures),
        device_(std::move(instance), physical, {ray_query}),
        film_(device_, job) {
    // Kernels are compiled while the scene is built and copied.
    std::future<double> compiled = std::async(std::launch::async, [&, begin = Clock::now()] {
      const KernelChoice kernels{job.features, scene.surface_needs(), scene.emission_needs(),
                                 scene.transparency_needs()};
      pipelines_.emplace(device_, kernels, static_cast<std::uint32_t>(sizeof(WavePush)), choice.cache);
      return seconds_since(begin);
    });
    upload(choice.threads);
    describe_job();
    allocate_lanes();
    const double seconds = compiled.get();
    const std::lock_guard lock(figures_.mutex);
    figures_.figures.compile_seconds = seconds;
  }

  void look_again() override;
  bool render(std::span<FilmTile> tiles, std::uint32_t first, std::uint32_t count, RayCounts &counts) override;

 private:
  // A range of pixels and of their samples.
  struct Batch {
    std::uint32_t first_pixel, pixel_count, first_sample, sample_count;
    std::uint32_t lanes() const { return pixel_count * sample_count; }
  };

  void upload(int threads);
  void upload_bvh(const WideBvh &bvh, Uploader &uploader);
  std::uint64_t lane_bytes() const;
  void allocate_lanes();
  void describe_job();
  bool run_batch(const Batch &batch, RayCounts &counts);
  void gather(std::uint32_t pixels);
  void begin_batch(VkCommandBuffer commands, const Batch &batch, const WavePush &push);
  void record_bounce(VkCommandBuffer commands, WavePush push);
  void record_outlines(VkCommandBuffer commands, WavePush push);
  std::uint32_t vertices_at_once(const Batch &batch, std::uint32_t alive) const;
  void adapt(double seconds, bool full);
  void bind(VkCommandBuffer commands, Stage stage, const WavePush &push) const;
  void dispatch(VkCommandBuffer commands, Stage stage, const WavePush &push, std::uint32_t items) const;
  void dispatch_queue(VkCommandBuffer commands, Stage stage, const WavePush &push) const;

  template <class T>
  T *add(std::uint64_t count) {
    return add_buffer<T>(device_, lane_buffers_, count, "paths");
  }

  bool has(std::uint32_t feature) const { return (job_.features & feature) != 0; }
  bool all_lights() const { return job_.scene->light_count <= LIGHTS_AT_ONCE; }
  // Does it matter what a surface does with light?
  bool scatters() const { return !has(FEATURE_TOON) && job_.classic.integrator != Integrator::kOcclusion; }
  // Shadow rays that a lane may send to lights at its vertex number `bounce`.
  std::uint32_t light_slots(std::uint32_t bounce) const {
    if (job_.classic.integrator == Integrator::kOcclusion) return 0;
    if (job_.classic.integrator == Integrator::kToon) return job_.scene->light_count;
    const std::uint32_t picks = bounce == 0 ? job_.scene->tree_picks : 1;
    const bool emitters = has(FEATURE_LIGHT_TREE) && job_.scene->emitter_count > 0;
    const bool world = has(FEATURE_WORLD_LIGHT);
    return (all_lights() ? job_.scene->light_count + (emitters ? 1 : 0) : picks) + (world ? 1 : 0);
  }
  std::uint32_t shadow_slots() const { return light_slots(0) + (sky_slot(0) != INVALID_ID ? 1 : 0); }
  // The place of the one to the sky.
  std::uint32_t sky_slot(std::uint32_t bounce) const {
    const uint always = JOB_OCCLUSION_PICTURE | JOB_AMBIENT_OCCLUDED;
    const bool sent = (wave_.job.flags & (bounce == 0 ? always | JOB_OCCLUSION_PASS : always)) != 0;
    return sent ? light_slots(bounce) : INVALID_ID;
  }
  // Vertices of the longest path, the one included that only brings light home; of Whitted's trees, one after the
  // other.
  std::uint32_t vertices() const {
    if (has(FEATURE_WHITTED)) return ~0u;
    const std::uint32_t bounces = has(FEATURE_BOUNCES | FEATURE_BSDF_RAYS) ? job_.limits.max_bounces + 2 : 1;
    // Surfaces that tint what they let through are shaded, too.
    const std::uint32_t passes = std::min(job_.limits.transparent_bounces, TRANSPARENT_UNLIMITED) + 1;
    return bounces + (scene_.tints() ? passes : 0);
  }

  const Scene &scene_;
  const RenderJob &job_;
  SharedFigures &figures_;
  LogicalDevice device_;
  std::optional<Pipelines> pipelines_;
  std::optional<Acceleration> acceleration_;
  std::vector<std::unique_ptr<Buffer>> scene_buffers_, lane_buffers_;
  std::unique_ptr<Buffer> data_, scene_data_, counters_, counters_host_;
  WaveData wave_{};
  SceneData data_of_scene_{};  // with the card's addresses
  FilmOnCard film_;
  std::uint32_t lanes_ = 0;  // there are
  std::uint32_t lanes_at_once_ = kFirstLanes;
  std::uint32_t bounces_at_once_ = 2;
  bool first_pass_ = true;
  Clock::time_point begin_ = Clock::now();
};

// ---- Once

void WavefrontOnCard::upload(int threads) {
  const auto begin = Clock::now();
  double build_seconds = 0.0;
  Uploader uploader(device_);
  data_of_scene_ = *job_.scene;
  const std::vector<Mesh> meshes = upload_scene(scene_, job_.features, uploader, data_of_scene_);
  scene_data_ = std::make_unique<Buffer>(device_, sizeof(SceneData), "the scene");
  wave_.scene = reinterpret_cast<SceneData *>(scene_data_->address());
  if (device_.ray_query()) {
    const AccelerationPlan plan(scene_);
    wave_.acceleration.geometries.v = uploader.put(std::span(plan.geometries), "the acceleration structure");
    scene_buffers_ = uploader.finish();
    const auto built = Clock::now();
    acceleration_.emplace(device_, scene_, plan, meshes, *job_.cancel);
    build_seconds = seconds_since(built);
    const std::uint64_t top = acceleration_->address();
    wave_.acceleration.top = {static_cast<uint>(top), static_cast<uint>(top >> 32)};
  } else {
    const auto built = Clock::now();
    std::vector<char> flattened;
    for (std::size_t k = 0; k < scene_.mesh_count(); ++k) flattened.push_back(scene_.flattened(k) ? 1 : 0);
    const WideBvh bvh = build_wide_bvh(scene_.meshes(), scene_.instances(), flattened, threads, *job_.cancel);
    build_seconds = seconds_since(built);
    upload_bvh(bvh, uploader);
    scene_buffers_ = uploader.finish();
  }
  const std::lock_guard lock(figures_.mutex);
  figures_.figures.build_seconds = build_seconds;
  figures_.figures.upload_seconds = seconds_since(begin) - build_seconds;
}

void WavefrontOnCard::upload_bvh(const WideBvh &bvh, Uploader &uploader) {
  wave_.bvh.nodes.v = uploader.put(std::span(bvh.nodes), "BVH nodes");
  wave_.bvh.triangles.v = uploader.put(std::span(bvh.triangles), "BVH triangles");
  wave_.bvh.instances.v = uploader.put(std::span(bvh.instances), "BVH instances");
  wave_.bvh.world_root = bvh.world_root;
  wave_.bvh.top_root = bvh.top_root;
}

// What state.inc asks by.
#define ASKED(FEATURES) has(FEATURES)
#define GOES_ON has(FEATURE_BOUNCES | FEATURE_BSDF_RAYS | FEATURE_WHITTED)
#define DRAWN has(FEATURE_PROGRAMS | FEATURE_LOBES)
#define SCATTERS scatters()
#define LIGHT_KINDS (job_.scene->light_kinds != 0u)
#define JOB wave_.job
#define SHADOW_SLOTS shadow_slots()
#define PATH_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT) LANE_STATE(TYPE, BUFFER, path_##MEMBER, 1, NEEDED)
#define SHADOW_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT) \
  LANE_STATE(TYPE, BUFFER, shadow_##MEMBER, SHADOW_SLOTS, NEEDED)
#define LOBE_STATE(MEMBER, PLACE)
#define BSDF_STATE(TYPE, BUFFER, MEMBER, NEEDED) LANE_STATE(TYPE, BUFFER, bsdf_##MEMBER, 1, DRAWN && SCATTERS && NEEDED)

std::uint64_t WavefrontOnCard::lane_bytes() const {
  std::uint64_t bytes = 0;
#define LANE_STATE(TYPE, BUFFER, NAME, EACH, NEEDED) \
  if (NEEDED) bytes += sizeof(TYPE) * (EACH);
#include "../kernels/state.inc"
#undef LANE_STATE
  return bytes;
}

void WavefrontOnCard::allocate_lanes() {
  const std::uint64_t fit = device_.memory_limit() / kPathMemory / lane_bytes();
  const std::uint64_t most = is_cpu(device_.physical()) ? kMostLanesOfCpu : kMostLanes;
  const std::uint64_t n = std::clamp<std::uint64_t>(fit, kFewestLanes, most);
#define LANE_STATE(TYPE, BUFFER, NAME, EACH, NEEDED) \
  if (NEEDED) wave_.NAME.v = add<TYPE>(n * (EACH));
#include "../kernels/state.inc"
#undef LANE_STATE
  counters_ = std::make_unique<Buffer>(device_, WAVE_COUNTERS * sizeof(uint), "paths");
  wave_.counters.v = reinterpret_cast<uint *>(counters_->address());
  counters_host_ = std::make_unique<Buffer>(device_, WAVE_COUNTERS * sizeof(uint), "paths", true);
  data_ = std::make_unique<Buffer>(device_, sizeof(WaveData), "paths");
  wave_.lanes = lanes_ = static_cast<std::uint32_t>(n);
  lanes_at_once_ = std::min(lanes_at_once_, lanes_);
}

void WavefrontOnCard::describe_job() {
  wave_.job = job_data(job_);
  wave_.sample_bits = job_.sample_bits;
}

// What SceneData says of the camera and the seed, and the job.
void WavefrontOnCard::look_again() {
  const SceneData &now = *job_.scene;
  data_of_scene_.camera_space = now.camera_space;
  data_of_scene_.camera_window = now.camera_window;
  data_of_scene_.camera_orthographic = now.camera_orthographic;
  data_of_scene_.camera_spread = now.camera_spread;
  data_of_scene_.camera_near = now.camera_near;
  data_of_scene_.seed = now.seed;
  describe_job();
}

// ---- Each pass over some tiles

bool WavefrontOnCard::render(std::span<FilmTile> tiles, std::uint32_t first, std::uint32_t count, RayCounts &counts) {
  const auto pixels = static_cast<std::uint32_t>(film_.place(tiles));
  if (pixels == 0) return true;
  film_.reserve(wave_);
  device_.run([&](VkCommandBuffer commands) {
    film_.clear(commands);
    device_.vkCmdUpdateBuffer(commands, data_->handle(), 0, sizeof wave_, &wave_);
    device_.vkCmdUpdateBuffer(commands, scene_data_->handle(), 0, sizeof data_of_scene_, &data_of_scene_);
  });
  for (std::uint32_t done = 0; done < count;) {
    const std::uint32_t samples = std::clamp(lanes_at_once_ / pixels, 1u, count - done);
    for (std::uint32_t p = 0; p < pixels;) {
      const std::uint32_t some = std::min(std::max(lanes_at_once_ / samples, 1u), pixels - p);
      if (!run_batch({p, some, first + done, samples}, counts)) return false;
      p += some;
    }
    done += samples;
  }
  if (has(FEATURE_SHARING)) gather(pixels);
  film_.read(tiles, count);
  const std::lock_guard lock(figures_.mutex);
  if (std::exchange(first_pass_, false)) figures_.figures.first_seconds = seconds_since(begin_);
  figures_.figures.bytes = device_.memory_used();
  return true;
}

// What the samples of a pass, which all batches together have taken, count for each pixel.
void WavefrontOnCard::gather(std::uint32_t pixels) {
  WavePush push{};
  push.data.v = reinterpret_cast<WaveData *>(data_->address());
  push.pixel_count = pixels;
  device_.run([&](VkCommandBuffer commands) {
    all_barrier(device_, commands);
    dispatch(commands, Stage::kGather, push, pixels);
  });
}

// All stages of a batch. Returns false if cancelled.
bool WavefrontOnCard::run_batch(const Batch &batch, RayCounts &counts) {
  WavePush push{};
  push.data.v = reinterpret_cast<WaveData *>(data_->address());
  push.first_pixel = batch.first_pixel;
  push.pixel_count = batch.pixel_count;
  push.first_sample = batch.first_sample;
  push.sample_count = batch.sample_count;
  const auto finish = [&](VkCommandBuffer commands, bool film) {
    if (film) dispatch(commands, Stage::kFilm, push, batch.pixel_count);
    const VkBufferCopy region{0, 0, WAVE_COUNTERS * sizeof(uint)};
    device_.vkCmdCopyBuffer(commands, counters_->handle(), counters_host_->handle(), 1, &region);
  };
  const std::uint32_t all = vertices();
  std::uint32_t alive = batch.lanes();
  for (std::uint32_t bounce = 0; bounce < all;) {
    if (job_.cancel->load(std::memory_order_relaxed)) return false;
    const auto begin = Clock::now();
    const std::uint32_t end = std::min(bounce + vertices_at_once(batch, alive), all);
    device_.run([&](VkCommandBuffer commands) {
      all_barrier(device_, commands);
      if (bounce == 0) begin_batch(commands, batch, push);
      for (; bounce < end; ++bounce) {
        push.bounce = bounce;
        push.light_slots = light_slots(bounce);
        push.sky_slot = sky_slot(bounce);
        record_bounce(commands, push);
      }
      finish(commands, end == all);
    });
    adapt(seconds_since(begin), alive > batch.lanes() / 2);
    alive = reinterpret_cast<const uint *>(counters_host_->data())[WAVE_COUNTS + WAVE_RAYS];
    if (alive > 0 || end == all) continue;
    device_.run([&](VkCommandBuffer commands) {
      all_barrier(device_, commands);
      finish(commands, true);
    });
    break;
  }
  const uint *counted = reinterpret_cast<const uint *>(counters_host_->data());
  counts.samples += batch.lanes();
  counts.camera += std::uint64_t{batch.lanes()} * (wave_.job.outlines != 0 ? OUTLINE_RAYS : 1);
  counts.bounce += counted[WAVE_BOUNCE_RAYS];
  counts.shadow += counted[WAVE_SHADOW_RAYS];
  counts.rejected += counted[WAVE_REJECTED];
  return true;
}

void WavefrontOnCard::begin_batch(VkCommandBuffer commands, const Batch &batch, const WavePush &push) {
  device_.vkCmdFillBuffer(commands, counters_->handle(), 0, VK_WHOLE_SIZE, 0);
  all_barrier(device_, commands);
  const std::uint64_t rays = (WAVE_COUNTS + WAVE_RAYS) * sizeof(uint);
  device_.vkCmdFillBuffer(commands, counters_->handle(), rays, sizeof(uint), batch.lanes());
  all_barrier(device_, commands);
  dispatch(commands, Stage::kBegin, push, batch.lanes());
}

void WavefrontOnCard::record_bounce(VkCommandBuffer commands, WavePush push) {
  const auto prepare = [&](uint queue) {
    push.queue = queue;
    dispatch(commands, Stage::kPrepare, push, 1);
  };
  prepare(WAVE_RAYS);
  if (wave_.job.outlines != 0 && push.bounce == 0) {
    record_outlines(commands, push);
  } else {
    dispatch_queue(commands, Stage::kTrace, push);
  }
  dispatch_queue(commands, Stage::kShade, push);
  prepare(WAVE_SHADING);
  if (push.light_slots > 0 || push.sky_slot != INVALID_ID) {
    dispatch_queue(commands, Stage::kLight, push);
    prepare(WAVE_SHADOWS);
    dispatch_queue(commands, Stage::kShadow, push);
  } else {
    prepare(WAVE_SHADOWS);  // it empties the queue of rays
  }
  push.queue = WAVE_SHADING;
  dispatch_queue(commands, Stage::kBounce, push);
}

// The camera rays and those around them.
void WavefrontOnCard::record_outlines(VkCommandBuffer commands, WavePush push) {
  push.outline_ray = OUTLINE_MIDDLE;
  do {
    dispatch_queue(commands, Stage::kTrace, push);
    dispatch_queue(commands, Stage::kOutline, push);
    push.outline_ray = outline_next(push.outline_ray);
  } while (push.outline_ray != OUTLINE_MIDDLE);
}

// More of them in one submission where few of the batch's lanes still have a ray.
std::uint32_t WavefrontOnCard::vertices_at_once(const Batch &batch, std::uint32_t alive) const {
  return std::min(bounces_at_once_ * (batch.lanes() / std::max(alive, 1u)), kMostBounces);
}

// Longer submissions where they are short, shorter ones where they are long: by bounces first, then by lanes. That few
// lanes were done soon says nothing of many.
void WavefrontOnCard::adapt(double seconds, bool full) {
  if (seconds > kLongest) {
    // In proportion: what takes ten times too long should not do so four more times.
    const double share = kLongest / seconds;
    if (bounces_at_once_ > 1) {
      bounces_at_once_ = std::max(static_cast<std::uint32_t>(bounces_at_once_ * share), 1u);
    } else {
      lanes_at_once_ = std::max(static_cast<std::uint32_t>(lanes_at_once_ * share), std::min(kFewestLanes, lanes_));
    }
  } else if (seconds < kShortest && full) {
    if (lanes_at_once_ < lanes_) {
      lanes_at_once_ = std::min(lanes_at_once_ * 2, lanes_);
    } else {
      bounces_at_once_ = std::min(bounces_at_once_ * 2, kMostBounces);
    }
  }
}

// ---- Commands

void WavefrontOnCard::bind(VkCommandBuffer commands, Stage stage, const WavePush &push) const {
  device_.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, (*pipelines_)[stage]);
  device_.vkCmdPushConstants(commands, pipelines_->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, &push);
}

void WavefrontOnCard::dispatch(VkCommandBuffer commands, Stage stage, const WavePush &push, std::uint32_t items) const {
  bind(commands, stage, push);
  device_.vkCmdDispatch(commands, (items + WAVE_GROUP_SIZE - 1) / WAVE_GROUP_SIZE, 1, 1);
  all_barrier(device_, commands);
}

// Over the lanes of push.queue, which prepare.comp has counted.
void WavefrontOnCard::dispatch_queue(VkCommandBuffer commands, Stage stage, const WavePush &push) const {
  bind(commands, stage, push);
  device_.vkCmdDispatchIndirect(commands, counters_->handle(), 3 * push.queue * sizeof(uint));
  all_barrier(device_, commands);
}

}  // namespace

std::unique_ptr<Wavefront> make_wavefront(const Scene &scene, const RenderJob &job, const DeviceChoice &choice,
                                          std::shared_ptr<Instance> instance, const Physical &physical, bool ray_query,
                                          SharedFigures &figures) {
  return std::make_unique<WavefrontOnCard>(scene, job, choice, std::move(instance), physical, ray_query, figures);
}

std::vector<CompiledStage> compile_kernels(std::uint32_t features, const ProgramNeeds &programs,
                                           const std::string &cache, std::shared_ptr<Instance> instance,
                                           const Physical &physical, bool ray_query) {
  LogicalDevice device(std::move(instance), physical, {ray_query, true});
  std::vector<CompiledStage> stages;
  const KernelChoice kernels{features, programs, programs, programs};
  const Pipelines pipelines(device, kernels, static_cast<std::uint32_t>(sizeof(WavePush)), cache, &stages);
  return stages;
}

}  // namespace cotorra::vulkan
