// SPDX-License-Identifier: GPL-3.0-or-later
// The wavefront of kernels/*.comp: batches of samples, a few stages in each submission, so that none takes long. Sums
// of samples come back to the film's tiles after each pass; no result depends on how many lanes there are.
#include "vulkan_wavefront.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <future>
#include <optional>

#include "scene.h"
#include "vulkan_acceleration.h"
#include "vulkan_pipelines.h"
#include "vulkan_scene.h"
#include "wide_bvh.h"

namespace cotorra {
namespace {
constexpr std::uint32_t KERNEL_FEATURES = ~0u;
}
}  // namespace cotorra

#include "../kernels/wavefront.h"

namespace cotorra::vulkan {
namespace {

using Clock = std::chrono::steady_clock;
using Buffers = std::vector<std::unique_ptr<Buffer>>;

// A submission should take between these, in seconds: cancelling must be quick, and no watchdog may bark.
constexpr double kShortest = 0.02;
constexpr double kLongest = 0.06;
constexpr std::uint32_t kFewestLanes = 1 << 10;
constexpr std::uint32_t kFirstLanes = 1 << 12;
constexpr std::uint32_t kMostLanes = 1 << 20;
constexpr std::uint32_t kMostLanesOfCpu = 1 << 15;  // where the device is a processor, its caches like few lanes
constexpr std::uint32_t kMostBounces = 16;           // of one submission
constexpr std::uint64_t kPathMemory = 8;             // of a card's memory, at most this part for lanes
constexpr std::size_t kFilmPixels = 1 << 21;
constexpr std::size_t kFilmPixelsOfCpu = 1 << 16;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

bool is_cpu(const Physical &p) { return p.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU; }

class WavefrontOnCard final : public Wavefront {
 public:
  WavefrontOnCard(const Scene &scene, const RenderJob &job, const DeviceChoice &choice,
                  std::shared_ptr<Instance> instance, const Physical &physical, bool ray_query, SharedFigures &figures)
      : scene_(scene), job_(job), figures_(figures), device_(std::move(instance), physical, {ray_query}) {
    // Kernels are compiled while the scene is built and copied.
    std::future<double> compiled = std::async(std::launch::async, [&, begin = Clock::now()] {
      pipelines_.emplace(device_, job.features, static_cast<std::uint32_t>(sizeof(WavePush)), choice.cache);
      return seconds_since(begin);
    });
    upload(choice.threads);
    describe_job();
    allocate_lanes();
    const double seconds = compiled.get();
    const std::lock_guard lock(figures_.mutex);
    figures_.figures.compile_seconds = seconds;
  }

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
  void describe_classic();
  void place_pixels(std::span<FilmTile> tiles);
  void reserve_film();
  void clear_film();
  bool run_batch(const Batch &batch, RayCounts &counts);
  void begin_batch(VkCommandBuffer commands, const Batch &batch, const WavePush &push);
  void record_bounce(VkCommandBuffer commands, WavePush push);
  void record_outlines(VkCommandBuffer commands, WavePush push);
  void read_film(std::span<FilmTile> tiles, std::uint32_t count);
  void take_pixel(FilmTile &staged, std::size_t pixel, std::size_t i) const;
  std::uint32_t vertices_at_once(const Batch &batch, std::uint32_t alive) const;
  void adapt(double seconds, bool full);
  void barrier(VkCommandBuffer commands) const;
  void bind(VkCommandBuffer commands, Stage stage, const WavePush &push) const;
  void dispatch(VkCommandBuffer commands, Stage stage, const WavePush &push, std::uint32_t items) const;
  void dispatch_queue(VkCommandBuffer commands, Stage stage, const WavePush &push) const;

  template <class T>
  T *add(Buffers &buffers, std::uint64_t count, const char *purpose) {
    buffers.push_back(std::make_unique<Buffer>(device_, count * sizeof(T), purpose));
    return reinterpret_cast<T *>(buffers.back()->address());
  }

  bool has(std::uint32_t feature) const { return (job_.features & feature) != 0; }
  bool all_lights() const { return wave_.scene.light_count <= job_.lights_at_once; }
  // Does it matter what a surface does with light?
  bool scatters() const { return !has(FEATURE_TOON) && job_.classic.integrator != Integrator::kOcclusion; }
  // Shadow rays that a lane may send to lights at its vertex number `bounce`.
  std::uint32_t light_slots(std::uint32_t bounce) const {
    if (job_.classic.integrator == Integrator::kOcclusion) return 0;
    if (job_.classic.integrator == Integrator::kToon) return wave_.scene.light_count;
    const std::uint32_t picks = bounce == 0 ? job_.lights_at_once : 1;
    const bool emitters = has(FEATURE_EMISSIVE_MESHES) && wave_.scene.emitter_count > 0;
    return (all_lights() ? wave_.scene.light_count : picks) + (emitters ? 1 : 0);
  }
  std::uint32_t shadow_slots() const { return light_slots(0) + (sky_slot(0) != INVALID_ID ? 1 : 0); }
  // The place of the one to the sky.
  std::uint32_t sky_slot(std::uint32_t bounce) const {
    const uint always = WAVE_OCCLUSION_PICTURE | WAVE_AMBIENT_OCCLUDED;
    const bool sent = (wave_.flags & (bounce == 0 ? always | WAVE_OCCLUSION_PASS : always)) != 0;
    return sent ? light_slots(bounce) : INVALID_ID;
  }
  // Vertices of the longest path, the one included that only brings light home; of Whitted's trees, one after the
  // other.
  std::uint32_t vertices() const {
    if (has(FEATURE_WHITTED)) return ~0u;
    return has(FEATURE_BOUNCES | FEATURE_BSDF_RAYS) ? job_.limits.max_bounces + 2 : 1;
  }

  const Scene &scene_;
  const RenderJob &job_;
  SharedFigures &figures_;
  LogicalDevice device_;
  std::optional<Pipelines> pipelines_;
  std::optional<Acceleration> acceleration_;
  Buffers scene_buffers_, lane_buffers_, film_buffers_;  // of the film: the first are the pixels
  std::unique_ptr<Buffer> data_, counters_, counters_host_, film_host_;
  WaveData wave_{};
  std::uint32_t lanes_ = 0;  // there are
  std::uint32_t lanes_at_once_ = kFirstLanes;
  std::uint32_t bounces_at_once_ = 2;
  std::size_t film_pixels_ = 0;    // that the film's buffers have room for
  std::vector<WavePixel> pixels_;  // of the tiles that are being rendered
  bool first_pass_ = true;
  Clock::time_point begin_ = Clock::now();
};

// ---- Once

void WavefrontOnCard::upload(int threads) {
  const auto begin = Clock::now();
  double build_seconds = 0.0;
  Uploader uploader(device_);
  wave_.scene = *job_.scene;
  const std::vector<Mesh> meshes = upload_scene(scene_, job_.features, uploader, wave_.scene);
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

std::uint64_t WavefrontOnCard::lane_bytes() const {
  std::uint64_t bytes =
      sizeof(CameraRay) + sizeof(PathState) + sizeof(Hit) + sizeof(Surface) + sizeof(WaveSample) + 2 * sizeof(uint);
  if (scatters()) bytes += sizeof(Bsdf);
  bytes += shadow_slots() * (sizeof(ShadowRay) + sizeof(uint));
  if (has(FEATURE_DATA_PASSES)) bytes += sizeof(WaveRecord);
  if (has(FEATURE_WHITTED)) bytes += sizeof(WaveTree) + (job_.classic.depth + 1) * sizeof(WavePending);
  if (job_.passes.terms) bytes += sizeof(WaveTerms);
  if (has(FEATURE_TOON)) bytes += sizeof(vec3);
  if (wave_.outlines != 0) bytes += sizeof(Hit) + sizeof(OutlinePoint) + sizeof(OutlineSums);
  return bytes + (job_.passes.light_groups + job_.passes.lamps) * sizeof(vec3);
}

void WavefrontOnCard::allocate_lanes() {
  const std::uint64_t fit = device_.memory_limit() / kPathMemory / lane_bytes();
  const std::uint64_t most = is_cpu(device_.physical()) ? kMostLanesOfCpu : kMostLanes;
  const std::uint64_t n = std::clamp<std::uint64_t>(fit, kFewestLanes, most);
  const std::uint64_t shadows = n * shadow_slots();
  constexpr const char *purpose = "paths";
  Buffers &b = lane_buffers_;
  wave_.rays_queue.v = add<uint>(b, n, purpose);
  wave_.shading_queue.v = add<uint>(b, n, purpose);
  wave_.shadows_queue.v = add<uint>(b, shadows, purpose);
  wave_.rays.v = add<CameraRay>(b, n, purpose);
  wave_.paths.v = add<PathState>(b, n, purpose);
  wave_.hits.v = add<Hit>(b, n, purpose);
  wave_.surfaces.v = add<Surface>(b, n, purpose);
  if (scatters()) wave_.bsdfs.v = add<Bsdf>(b, n, purpose);
  wave_.shadow_rays.v = add<ShadowRay>(b, shadows, purpose);
  wave_.samples.v = add<WaveSample>(b, n, purpose);
  if (has(FEATURE_DATA_PASSES)) wave_.records.v = add<WaveRecord>(b, n, purpose);
  if (job_.passes.light_groups > 0) wave_.groups.v = add<vec3>(b, n * job_.passes.light_groups, purpose);
  if (has(FEATURE_WHITTED)) {
    wave_.trees.v = add<WaveTree>(b, n, purpose);
    wave_.pending.v = add<WavePending>(b, n * (job_.classic.depth + 1), purpose);
  }
  if (job_.passes.lamps > 0) wave_.lamps.v = add<vec3>(b, n * job_.passes.lamps, purpose);
  if (job_.passes.terms) wave_.terms.v = add<WaveTerms>(b, n, purpose);
  if (has(FEATURE_TOON)) wave_.base_colors.v = add<vec3>(b, n, purpose);
  if (wave_.outlines != 0) {
    wave_.outline_hits.v = add<Hit>(b, n, purpose);
    wave_.outline_points.v = add<OutlinePoint>(b, n, purpose);
    wave_.outline_sums.v = add<OutlineSums>(b, n, purpose);
  }
  counters_ = std::make_unique<Buffer>(device_, WAVE_COUNTERS * sizeof(uint), purpose);
  wave_.counters.v = reinterpret_cast<uint *>(counters_->address());
  counters_host_ = std::make_unique<Buffer>(device_, WAVE_COUNTERS * sizeof(uint), purpose, true);
  data_ = std::make_unique<Buffer>(device_, sizeof(WaveData), purpose);
  wave_.lanes = lanes_ = static_cast<std::uint32_t>(n);
  lanes_at_once_ = std::min(lanes_at_once_, lanes_);
}

void WavefrontOnCard::describe_job() {
  wave_.camera = job_.camera;
  wave_.integrator = {job_.limits.max_bounces, job_.limits.diffuse_bounces, job_.limits.glossy_bounces,
                      job_.limits.roulette_start};
  wave_.sample_bits = job_.sample_bits;
  wave_.light_groups = job_.passes.light_groups;
  wave_.adaptive = job_.passes.error ? 1u : 0u;
  wave_.transparent_bounces = job_.transparent_bounces;
  if (job_.transparent) wave_.flags |= WAVE_TRANSPARENT;
  if (job_.camera_meets_lights) wave_.flags |= WAVE_CAMERA_MEETS_LIGHTS;
  if (job_.last_rays_find_light) wave_.flags |= WAVE_LAST_RAYS_FIND_LIGHT;
  if (all_lights()) wave_.flags |= WAVE_ALL_LIGHTS;
  if (job_.passes.terms) wave_.flags |= WAVE_TERMS_PASS;
  wave_.lamp_passes = job_.passes.lamps;
  describe_classic();
}

void WavefrontOnCard::describe_classic() {
  const ClassicJob &c = job_.classic;
  wave_.whitted_depth = c.depth;
  wave_.whitted_threshold = c.threshold;
  if (c.transparent_shadows) wave_.flags |= WAVE_TRANSPARENT_SHADOWS;
  if (c.integrator == Integrator::kOcclusion) wave_.flags |= WAVE_OCCLUSION_PICTURE;
  if (job_.passes.occlusion) wave_.flags |= WAVE_OCCLUSION_PASS;
  if (max(max(c.ambient.x, c.ambient.y), c.ambient.z) > 0.0f) {
    wave_.flags |= WAVE_AMBIENT | (c.occluded ? WAVE_AMBIENT_OCCLUDED : 0u);
  }
  wave_.ambient = c.ambient;
  wave_.occlusion_distance = c.occlusion_distance;
  wave_.outlines = c.outlines;
  wave_.outline_color = c.outline_color;
  wave_.outline_x = c.outline_x;
  wave_.outline_y = c.outline_y;
  wave_.rows = c.rows;
}

// ---- Each pass over some tiles

bool WavefrontOnCard::render(std::span<FilmTile> tiles, std::uint32_t first, std::uint32_t count, RayCounts &counts) {
  place_pixels(tiles);
  if (pixels_.empty()) return true;
  reserve_film();
  clear_film();
  const auto pixels = static_cast<std::uint32_t>(pixels_.size());
  for (std::uint32_t done = 0; done < count;) {
    const std::uint32_t samples = std::clamp(lanes_at_once_ / pixels, 1u, count - done);
    for (std::uint32_t p = 0; p < pixels;) {
      const std::uint32_t some = std::min(std::max(lanes_at_once_ / samples, 1u), pixels - p);
      if (!run_batch({p, some, first + done, samples}, counts)) return false;
      p += some;
    }
    done += samples;
  }
  read_film(tiles, count);
  const std::lock_guard lock(figures_.mutex);
  if (std::exchange(first_pass_, false)) figures_.figures.first_seconds = seconds_since(begin_);
  figures_.figures.bytes = device_.memory_used();
  return true;
}

void WavefrontOnCard::place_pixels(std::span<FilmTile> tiles) {
  pixels_.clear();
  for (FilmTile &tile : tiles) {
    const auto x0 = static_cast<uint>(job_.region_x + tile.x0);
    const auto y0 = static_cast<uint>(job_.region_y + tile.y0);
    const auto width = static_cast<uint>(tile.width);
    const uint seed = sampler_block_seed(x0, y0, job_.sample_bits, job_.seed);
    for (const std::uint16_t i : tile.to_sample()) pixels_.push_back({x0 + i % width, y0 + i / width, seed, 0u});
  }
}

// Makes room for the film of the pixels that were placed.
void WavefrontOnCard::reserve_film() {
  if (pixels_.size() <= film_pixels_) return;
  const std::uint64_t n = std::max<std::uint64_t>(pixels_.size(), WAVE_GROUP_SIZE);
  film_buffers_.clear();
  film_host_.reset();
  constexpr const char *purpose = "the film";
  const std::uint64_t groups = n * job_.passes.light_groups;
  std::uint64_t bytes = n * std::max(sizeof(FilmPixel), sizeof(WavePixel));
  wave_.pixels.v = add<WavePixel>(film_buffers_, n, purpose);
  wave_.film.v = add<FilmPixel>(film_buffers_, n, purpose);
  if (job_.passes.error) {
    wave_.film_odd.v = add<vec3>(film_buffers_, n, purpose);
    bytes += n * sizeof(vec3);
  }
  if (has(FEATURE_DATA_PASSES)) {
    wave_.film_records.v = add<WaveRecord>(film_buffers_, n, purpose);
    bytes += n * sizeof(WaveRecord);
  }
  if (groups > 0) {
    wave_.film_groups.v = add<vec3>(film_buffers_, groups, purpose);
    bytes += groups * sizeof(vec3);
  }
  if (job_.passes.lamps > 0) {
    wave_.film_lamps.v = add<vec3>(film_buffers_, n * job_.passes.lamps, purpose);
    bytes += n * job_.passes.lamps * sizeof(vec3);
  }
  if (job_.passes.terms) {
    wave_.film_terms.v = add<WaveTerms>(film_buffers_, n, purpose);
    bytes += n * sizeof(WaveTerms);
  }
  film_host_ = std::make_unique<Buffer>(device_, bytes, purpose, true);
  film_pixels_ = n;
}

void WavefrontOnCard::clear_film() {
  // The list of pixels goes through the buffer in which the film will come back.
  const VkBufferCopy region{0, 0, pixels_.size() * sizeof(WavePixel)};
  std::memcpy(film_host_->data(), pixels_.data(), region.size);
  device_.run([&](VkCommandBuffer commands) {
    device_.vkCmdCopyBuffer(commands, film_host_->handle(), film_buffers_[0]->handle(), 1, &region);
    for (std::size_t i = 1; i < film_buffers_.size(); ++i) {
      device_.vkCmdFillBuffer(commands, film_buffers_[i]->handle(), 0, VK_WHOLE_SIZE, 0);
    }
    device_.vkCmdUpdateBuffer(commands, data_->handle(), 0, sizeof wave_, &wave_);
  });
}

// All stages of a batch. Returns false if cancelled.
bool WavefrontOnCard::run_batch(const Batch &batch, RayCounts &counts) {
  WavePush push{};
  push.data.v = reinterpret_cast<const WaveData *>(data_->address());
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
      barrier(commands);
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
      barrier(commands);
      finish(commands, true);
    });
    break;
  }
  const uint *counted = reinterpret_cast<const uint *>(counters_host_->data());
  counts.samples += batch.lanes();
  counts.camera += std::uint64_t{batch.lanes()} * (wave_.outlines != 0 ? OUTLINE_RAYS : 1);
  counts.bounce += counted[WAVE_BOUNCE_RAYS];
  counts.shadow += counted[WAVE_SHADOW_RAYS];
  counts.rejected += counted[WAVE_REJECTED];
  return true;
}

void WavefrontOnCard::begin_batch(VkCommandBuffer commands, const Batch &batch, const WavePush &push) {
  device_.vkCmdFillBuffer(commands, counters_->handle(), 0, VK_WHOLE_SIZE, 0);
  barrier(commands);
  const std::uint64_t rays = (WAVE_COUNTS + WAVE_RAYS) * sizeof(uint);
  device_.vkCmdFillBuffer(commands, counters_->handle(), rays, sizeof(uint), batch.lanes());
  barrier(commands);
  dispatch(commands, Stage::kBegin, push, batch.lanes());
}

void WavefrontOnCard::record_bounce(VkCommandBuffer commands, WavePush push) {
  const auto prepare = [&](uint queue) {
    push.queue = queue;
    dispatch(commands, Stage::kPrepare, push, 1);
  };
  prepare(WAVE_RAYS);
  if (wave_.outlines != 0 && push.bounce == 0) {
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

// Adds the card's sums to the tiles.
void WavefrontOnCard::read_film(std::span<FilmTile> tiles, std::uint32_t count) {
  device_.run([&](VkCommandBuffer commands) {
    barrier(commands);
    std::uint64_t offset = 0;
    for (std::size_t i = 1; i < film_buffers_.size(); ++i) {
      const VkBufferCopy region{0, offset, film_buffers_[i]->size()};
      device_.vkCmdCopyBuffer(commands, film_buffers_[i]->handle(), film_host_->handle(), 1, &region);
      offset += region.size;
    }
  });
  FilmTile staged;
  std::size_t pixel = 0;
  for (FilmTile &tile : tiles) {
    if (tile.to_sample().empty()) continue;
    staged.clear_as(tile);
    for (const std::uint16_t i : tile.to_sample()) take_pixel(staged, pixel++, i);
    tile.add(staged, count);
  }
}

// Pixel number `pixel` of those that were placed becomes pixel i of its tile.
void WavefrontOnCard::take_pixel(FilmTile &staged, std::size_t pixel, std::size_t i) const {
  const std::byte *at = film_host_->data();
  const auto next = [&]<class T>(std::size_t each, T *) {
    const T *array = reinterpret_cast<const T *>(at) + pixel * each;
    at += film_pixels_ * each * sizeof(T);
    return array;
  };
  staged.pixels[i] = *next(1, static_cast<FilmPixel *>(nullptr));
  if (job_.passes.error) staged.odd[i] = *next(1, static_cast<vec3 *>(nullptr));
  if (has(FEATURE_DATA_PASSES)) {
    const WaveRecord &r = *next(1, static_cast<WaveRecord *>(nullptr));
    if (!staged.nearest.empty() && r.hit > 0.0f) {
      staged.nearest[i] = {r.distance2, r.depth, r.position, r.object_index, r.material_index};
    }
    if (!staged.surface.empty()) staged.surface[i] = {r.normal, r.uv, r.uv_coverage, r.diffuse_color};
    if (!staged.emission.empty()) staged.emission[i] = r.emission;
    if (!staged.environment.empty()) staged.environment[i] = r.environment;
    if (!staged.shadow.empty()) staged.shadow[i] = {r.lit, r.unshadowed};
    if (!staged.occlusion.empty()) staged.occlusion[i] = r.occlusion;
  }
  const std::size_t groups = job_.passes.light_groups;
  if (groups > 0) std::copy_n(next(groups, static_cast<vec3 *>(nullptr)), groups, staged.groups.begin() + i * groups);
  const std::size_t lamps = job_.passes.lamps;
  if (lamps > 0) std::copy_n(next(lamps, static_cast<vec3 *>(nullptr)), lamps, staged.lamps.begin() + i * lamps);
  if (job_.passes.terms) {
    const WaveTerms &terms = *next(1, static_cast<WaveTerms *>(nullptr));
    staged.terms[i] = {terms.d, terms.g, terms.f};
  }
}

// ---- Commands

// What was written before may be read after, by whatever stage.
void WavefrontOnCard::barrier(VkCommandBuffer commands) const {
  VkMemoryBarrier memory{};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  memory.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  constexpr VkPipelineStageFlags stages =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
  device_.vkCmdPipelineBarrier(commands, stages, stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

void WavefrontOnCard::bind(VkCommandBuffer commands, Stage stage, const WavePush &push) const {
  device_.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, (*pipelines_)[stage]);
  device_.vkCmdPushConstants(commands, pipelines_->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, &push);
}

void WavefrontOnCard::dispatch(VkCommandBuffer commands, Stage stage, const WavePush &push, std::uint32_t items) const {
  bind(commands, stage, push);
  device_.vkCmdDispatch(commands, (items + WAVE_GROUP_SIZE - 1) / WAVE_GROUP_SIZE, 1, 1);
  barrier(commands);
}

// Over the lanes of push.queue, which wave_prepare.comp has counted.
void WavefrontOnCard::dispatch_queue(VkCommandBuffer commands, Stage stage, const WavePush &push) const {
  bind(commands, stage, push);
  device_.vkCmdDispatchIndirect(commands, counters_->handle(), 3 * push.queue * sizeof(uint));
  barrier(commands);
}

}  // namespace

std::size_t film_pixels_at_once(const Physical &physical) { return is_cpu(physical) ? kFilmPixelsOfCpu : kFilmPixels; }

std::unique_ptr<Wavefront> make_wavefront(const Scene &scene, const RenderJob &job, const DeviceChoice &choice,
                                          std::shared_ptr<Instance> instance, const Physical &physical, bool ray_query,
                                          SharedFigures &figures) {
  return std::make_unique<WavefrontOnCard>(scene, job, choice, std::move(instance), physical, ray_query, figures);
}

std::vector<CompiledStage> compile_kernels(std::uint32_t features, const std::string &cache,
                                           std::shared_ptr<Instance> instance, const Physical &physical,
                                           bool ray_query) {
  LogicalDevice device(std::move(instance), physical, {ray_query, true});
  std::vector<CompiledStage> stages;
  const Pipelines pipelines(device, features, static_cast<std::uint32_t>(sizeof(WavePush)), cache, &stages);
  return stages;
}

}  // namespace cotorra::vulkan
