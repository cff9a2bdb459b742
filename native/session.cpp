// SPDX-License-Identifier: GPL-3.0-or-later
// Turns settings into a job, and hands out its tiles to threads in passes of growing length.
#include "session.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <system_error>

#if defined(__x86_64__) || defined(_M_X64)
#include <xmmintrin.h>
#endif

#include "../kernels/program/ops.h"
#include "../kernels/sampling.h"
#include "../kernels/sharing.h"
#include "integrators.h"
#include "memory.h"
#include "noise_estimate.h"
#include "sharing_mix.h"

namespace cotorra {
namespace {
std::uint64_t rays_of(const RayCounts &counts) { return counts.camera + counts.bounce + counts.shadow; }

constexpr std::int64_t kMaxSamples = 1 << 24;  // float sums stand still beyond; Cycles' bound too
constexpr std::uint32_t kLongestPass = 32;     // samples; keeps cancelling quick
constexpr std::uint32_t kLampPasses = 1024;    // more than anyone looks through

// Do pixels' filters reach each other's samples, and no farther than is provided for?
bool shares_samples(const CameraInput &camera, const SettingsInput &settings) {
  const float radius = camera.filter_width * filter_reach(camera.filter);
  return settings.sharing && !(settings.reweighting > 0.0f) && radius > 0.5f && radius <= SHARING_RADIUS;
}

PassSelection select_passes(const CameraInput &camera, const SettingsInput &settings, std::uint32_t light_groups) {
  PassSelection p;
  p.error = settings.adaptive || settings.spread_after > 0;
  p.bright = settings.reweighting > 0.0f;
  p.shared = shares_samples(camera, settings);
  p.mixed = p.shared && settings.samples >= kMixFrom;
  for (const std::string &name : settings.passes) {
    if (name == "depth" || name == "position" || name == "object_index" || name == "material_index") {
      p.nearest = true;
    } else if (name == "normal" || name == "uv" || name == "diffuse_color") {
      p.surface = true;
    } else if (name.starts_with("denoising_")) {
      p.features = true;
    } else if (name == "emission") {
      p.emission = true;
    } else if (name == "environment") {
      p.environment = true;
    } else if (name == "shadow") {
      p.shadow = true;
    } else if (name == "noise") {
      p.error = true;
    } else if (name == "ao") {
      p.occlusion = true;
    } else if (name == "health") {
      p.health = true;
    } else if (name.starts_with("term_")) {
      p.terms = true;
    } else if (const std::uint32_t lamp = numbered_pass(name, "light:"); lamp < kLampPasses) {
      p.lamps = std::max(p.lamps, lamp + 1);
    } else if (name.starts_with("lightgroup:")) {
      p.light_groups = light_groups;
    } else {
      require(name == "combined" || name == "unweighted" || name == "sample_count", "settings.passes", "'" + name + "'",
              "a known pass");
    }
  }
  return p;
}

// Side of a tile: large ones make long batches, small ones spread a small picture over the threads. The choice knows
// nothing of the thread count, so that the picture does not depend on it.
int tile_size(const CameraInput &c) {
  return static_cast<std::int64_t>(c.region[2]) * c.region[3] >= 256 * 256 ? 32 : 16;
}

std::unique_ptr<Device> make_device(const std::shared_ptr<const Scene> &scene, const RenderJob &job,
                                    const SettingsInput &settings) {
  DeviceChoice choice = settings.device;
  choice.threads = settings.threads;
  require(choice.kind == "CPU" || choice.kind == "VULKAN", "settings.device", "'" + choice.kind + "'", "CPU or VULKAN");
  require(choice.ray_tracing == "AUTO" || choice.ray_tracing == "SOFTWARE" || choice.ray_tracing == "HARDWARE",
          "settings.ray_tracing", "'" + choice.ray_tracing + "'", "AUTO, SOFTWARE or HARDWARE");
  return choice.kind == "CPU" ? make_cpu_device(job) : make_vulkan_device(scene, job, choice);
}

}  // namespace

Session::Session(std::shared_ptr<const Scene> scene, const CameraInput &camera, const SettingsInput &settings,
                 bool restarts)
    : scene_(std::move(scene)),
      settings_(settings),
      passes_(select_passes(camera, settings, scene_->light_group_count())),
      film_(checked(camera).region[2], camera.region[3], tile_size(camera), passes_),
      restarts_(restarts) {
  describe(camera);
  device_ = make_device(scene_, job_, settings_);
}

void Session::restart(const CameraInput &camera, const SettingsInput &settings) {
  stop();
  SettingsInput same = settings;
  same.samples = settings_.samples;
  same.seed = settings_.seed;
  same.noise_threshold = settings_.noise_threshold;
  same.adaptive_min_samples = settings_.adaptive_min_samples;
  // A card keeps the filter's table, and kernels that share samples or do not.
  const bool keep =
      restarts_ && same == settings_ && camera.filter == filter_ && shares_samples(camera, settings) == passes_.shared;
  settings_ = settings;
  passes_ = select_passes(camera, settings_, scene_->light_group_count());
  film_ = Film(checked(camera).region[2], camera.region[3], tile_size(camera), passes_);
  describe(camera);
  if (!keep) {
    workspaces_.clear();
    device_ = make_device(scene_, job_, settings_);
  }
  for (const auto &workspace : workspaces_) {
    if (workspace != nullptr) device_->look_again(*workspace);
  }
}

// The job, from the settings and the scene, which both stand; nothing of it is rendered yet.
void Session::describe(const CameraInput &camera) {
  require(settings_.samples >= 1 && settings_.samples <= kMaxSamples, "settings.samples",
          std::to_string(settings_.samples), "1 to 16777216");
  require(settings_.reweighting >= 0.0f && settings_.reweighting < INFINITE_DISTANCE, "settings.reweighting",
          std::to_string(settings_.reweighting), "0 or more");
  require(settings_.white > 0.0f && settings_.white < INFINITE_DISTANCE, "settings.white",
          std::to_string(settings_.white), "above 0");
  const auto samples = static_cast<std::uint32_t>(settings_.samples);

  job_ = {};
  scene_data_ = scene_->data();
  if (filter_table_.empty() || filter_ != camera.filter) filter_table_ = make_filter_table(camera.filter);
  filter_ = camera.filter;
  scene_data_.filter_table = {filter_table_.data()};
  job_.scene = &scene_data_;
  job_.camera = camera_data(camera);
  see_from(job_.camera, camera, scene_data_);
  job_.region_x = camera.region[0];
  job_.region_y = camera.region[1];
  job_.passes = passes_;
  apply_integrator(settings_, camera, *scene_, job_, scene_data_);
  if (passes_.any_data()) job_.features |= FEATURE_DATA_PASSES;
  if (passes_.occlusion) job_.features |= FEATURE_OCCLUSION;
  if (passes_.bright) job_.features |= FEATURE_REWEIGHTING;
  if (passes_.shared) job_.features |= FEATURE_SHARING;
  if (passes_.light_groups > 0) job_.features |= FEATURE_LIGHT_GROUPS;
  if (passes_.terms || passes_.lamps > 0) job_.features |= FEATURE_TERMS;
  // What a surface is, passes show even where the integrator does not ask.
  if (passes_.terms || passes_.surface) job_.features |= scene_->features() & (FEATURE_SPECULAR | FEATURE_MODELS);
  if (passes_.emission) job_.features |= scene_->features() & FEATURE_EMISSIVE_MESHES;
  // Graphics cards do not count.
  if ((settings_.health || passes_.health) && settings_.device.kind == "CPU") job_.features |= FEATURE_HEALTH;
  job_.white = settings_.white;
  job_.firefly_limit = settings_.firefly_limit;
  job_.seed = settings_.seed;
  scene_data_.seed = settings_.seed;
  job_.program_registers = scene_->programs().registers;
  job_.sample_bits = std::min(static_cast<std::uint32_t>(std::bit_width(samples - 1u)), SAMPLE_BITS_MAX);
  job_.transparent = settings_.transparent;
  job_.camera_meets_lights = scene_->camera_meets_lights() && (job_.features & FEATURE_VISIBLE_LIGHTS) != 0;
  job_.last_rays_find_light = (job_.features & (FEATURE_WORLD | FEATURE_EMISSIVE_MESHES)) != 0;
  job_.measure_tracing = settings_.measure_tracing;
  job_.cancel = &cancel_;
  if (settings_.device.kind == "CPU") use_embree();

  // Passes of 1, 1, 2, 4 ... samples: a first picture soon, few interruptions later.
  pass_ends_.clear();
  plan_passes(samples);
  most_.clear();
  passes_now_ = pass_ends_.size();
  if (settings_.spread_after > 0) {
    require(!settings_.adaptive, "settings.spread_after", std::to_string(settings_.spread_after),
            "0 with adaptive sampling");
    const auto last = std::ranges::find(pass_ends_, settings_.spread_after);
    require(last != pass_ends_.end(), "settings.spread_after", std::to_string(settings_.spread_after),
            "the end of a pass: a power of two, or a multiple of 32");
    passes_now_ = static_cast<std::size_t>(last - pass_ends_.begin()) + 1;
  }
  tile_passes_ = std::vector<std::atomic<std::uint32_t>>(film_.tile_count());
  tile_rays_.assign(film_.tile_count(), 0);
  next_work_ = 0;
  samples_finished_ = 0;
  cancel_ = false;
  counts_ = {};
  error_ = nullptr;
  begin_ = end_ = {};
}

void Session::stop() {
  cancel();
  for (std::thread &thread : threads_) thread.join();
  threads_.clear();
}

void Session::resume() {
  stop();
  if (error_) {
    try {
      std::rethrow_exception(error_);
    } catch (const Cancelled &) {
      error_ = nullptr;  // a graphics card had not built what it traces rays by
    } catch (...) {
      return;  // `wait` throws it
    }
  }
  next_work_ = 0;
  cancel_ = false;
  start();
}

void Session::use_embree() {
  if (scene_->bvh() == nullptr) {
    throw std::invalid_argument("settings.device is CPU, but the scene has no BVH for it (build_bvh)");
  }
  job_.bvh = scene_->bvh();
  job_.rtc = &scene_->api();
  job_.geometries = scene_->geometries();
  job_.embree_features = embree::kFeatureQuad | (scene_->instanced() ? embree::kFeatureInstanceArray : 0u);
  if ((job_.features & (FEATURE_TRANSPARENCY | FEATURE_LOBES)) != 0)
    job_.embree_features |= embree::kFeatureFilterInArguments;
  if (((scene_->surface_needs().groups | scene_->emission_needs().groups) & GROUP_RAYS) == 0) return;
  tracer_ = make_embree_tracer(*job_.rtc, job_.bvh, job_.geometries.data(), scene_->instanced());
  scene_data_.tracer = {tracer_.get()};
}

Session::~Session() { stop(); }

void Session::start() {
  const std::lock_guard lock(mutex_);
  if (!threads_.empty()) throw std::logic_error("this session was started before");
  const int n = device_->threads(settings_.threads);
  end_ = std::chrono::steady_clock::now();
  if (begin_ == std::chrono::steady_clock::time_point{}) begin_ = end_;
  running_ = n;
  if (restarts_ && workspaces_.size() < static_cast<std::size_t>(n)) workspaces_.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    try {
      threads_.emplace_back([this, i] { work(static_cast<std::size_t>(i)); });
    } catch (const std::system_error &error) {  // no memory for another stack, or no more threads allowed
      running_ -= n - i;
      if (i == 0) throw std::runtime_error(std::string("no thread could be started to render: ") + error.what());
      break;
    }
  }
}

void Session::work(std::size_t thread) {
#if defined(__x86_64__) || defined(_M_X64)
  _mm_setcsr(_mm_getcsr() | 0x8040);  // flush denormals to zero: Embree asks for it
#endif
  RayCounts counts;
  std::exception_ptr error;
  try {
    with_memory(device_->workspace_bytes(), "the work of a thread, at least", [&] { run_passes(thread, counts); });
  } catch (...) {
    error = std::current_exception();
    cancel();
  }
  if (error && restarts_) workspaces_[thread] = nullptr;
  const std::lock_guard lock(mutex_);
  counts_.add(counts);
  if (error && !error_) error_ = error;
  if (--running_ == 0) end_ = std::chrono::steady_clock::now();
  changed_.notify_all();
}

// All work that is left, shared with the other threads.
void Session::run_passes(std::size_t thread, RayCounts &counts) {
  std::unique_ptr<Workspace> own;
  std::unique_ptr<Workspace> &workspace = restarts_ ? workspaces_[thread] : own;
  if (workspace == nullptr) workspace = device_->make_workspace(job_);
  const std::uint64_t at_once = device_->tiles_at_once();
  const std::uint64_t groups = (film_.tile_count() + at_once - 1) / at_once;
  const std::uint64_t total = groups * passes_now_;
  while (!cancel_.load(std::memory_order_relaxed)) {
    const std::uint64_t work = next_work_.fetch_add(1);
    if (work >= total) break;
    const std::uint64_t pass = work / groups;
    const std::size_t tile = work % groups * at_once;
    // Another thread may still be at this tile's last pass: its samples come first, whatever the thread count.
    while (tile_passes_[tile].load(std::memory_order_acquire) < pass && !cancel_.load(std::memory_order_relaxed)) {
      std::this_thread::yield();
    }
    const std::uint32_t done = tile_passes_[tile].load(std::memory_order_acquire);
    if (done > pass) continue;  // another device did it
    if (done < pass) break;     // cancelled while it waited
    const std::uint32_t first = pass > 0 ? pass_ends_[pass - 1] : 0;
    run_tiles(tile, std::min<std::size_t>(at_once, film_.tile_count() - tile), first, pass_ends_[pass] - first,
              *workspace, counts);
  }
}

void Session::run_tiles(std::size_t first_tile, std::size_t tile_count, std::uint32_t first, std::uint32_t count,
                        Workspace &workspace, RayCounts &counts) {
  const std::span<FilmTile> tiles = film_.tiles(first_tile, tile_count);
  if (passes_.error || passes_.mixed) {
    for (FilmTile &tile : tiles) mark_noise(tile, first);
  }
  const std::uint64_t rays = rays_of(counts);
  if (!device_->render(job_, tiles, first, count, workspace, counts)) return;
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    tile_rays_[first_tile + k] += (rays_of(counts) - rays) / tiles.size();
    if (passes_.mixed) measure_mix(tiles[k], first + count);
    if (passes_.error) measure_rate(tiles[k], first + count);
    if (!most_.empty()) taken_.fetch_add(count * tiles[k].to_sample().size(), std::memory_order_relaxed);
    if (!tiles[k].to_sample().empty()) update_pending(tiles[k], first + count);
    samples_finished_.fetch_add(count, std::memory_order_relaxed);
    tile_passes_[first_tile + k].fetch_add(1, std::memory_order_release);
  }
}

// The next pass leaves out what has all of its samples, and with adaptive sampling what is clean.
void Session::update_pending(FilmTile &tile, std::uint32_t samples) const {
  if (!most_.empty()) drop_sampled_pixels(tile, samples);
  if (!settings_.adaptive) return;
  const float threshold = settings_.noise_threshold;
  const std::uint32_t least =
      settings_.adaptive_min_samples > 0
          ? settings_.adaptive_min_samples
          : std::max(16u, static_cast<std::uint32_t>(std::lround(1.6f / std::sqrt(std::max(threshold, 1e-6f)))));
  // With one sample there is nothing to compare.
  if (samples >= std::max(least, 2u)) drop_clean_pixels(tile, threshold);
}

void Session::plan_passes(std::uint32_t samples) {
  for (std::uint32_t done = pass_ends_.empty() ? 0 : pass_ends_.back(); done < samples;) {
    done += std::min({std::max(done, 1u), kLongestPass, samples - done});
    pass_ends_.push_back(done);
  }
}

std::size_t Session::pixel_of(const FilmTile &tile, std::size_t i) const {
  const auto across = static_cast<std::size_t>(tile.width);
  const std::size_t x = static_cast<std::size_t>(tile.x0) + i % across,
                    y = static_cast<std::size_t>(tile.y0) + i / across;
  return y * static_cast<std::size_t>(film_.width()) + x;
}

void Session::drop_sampled_pixels(FilmTile &tile, std::uint32_t samples) const {
  const std::lock_guard lock(tile.mutex);
  std::erase_if(tile.pending, [&](std::uint16_t i) { return most_[pixel_of(tile, i)] <= samples; });
}

void Session::spread(std::span<const std::uint32_t> most) {
  const std::lock_guard lock(mutex_);
  require(most.size() == static_cast<std::size_t>(film_.width()) * static_cast<std::size_t>(film_.height()), "most",
          std::to_string(most.size()) + " numbers", "one for each pixel");
  const auto behind = [this](const auto &passes) { return passes.load() < passes_now_; };
  if (running_ > 0 || !most_.empty() || settings_.spread_after == 0 || std::ranges::any_of(tile_passes_, behind)) {
    throw std::logic_error("samples are spread once, when each pixel has settings.spread_after of them");
  }
  for (std::thread &thread : threads_) thread.join();
  threads_.clear();
  most_.resize(most.size());
  std::ranges::transform(most, most_.begin(), [this](auto n) { return std::max(n, settings_.spread_after); });
  pass_ends_.resize(passes_now_);
  plan_passes(*std::ranges::max_element(most_));
  planned_ = 0;
  for (const std::uint32_t wanted : most_) planned_ += *std::ranges::lower_bound(pass_ends_, wanted);
  taken_ = static_cast<std::uint64_t>(settings_.spread_after) * most_.size();
  for (std::size_t k = 0; k < film_.tile_count(); ++k) drop_sampled_pixels(film_.tile(k), settings_.spread_after);
  passes_now_ = pass_ends_.size();
  next_work_ = 0;
}

void Session::differences(std::span<float> out) {
  const std::size_t pixels = static_cast<std::size_t>(film_.width()) * static_cast<std::size_t>(film_.height());
  require(out.size() == 3 * pixels, "out", std::to_string(out.size()) + " numbers", "three for each pixel");
  require(settings_.spread_after > 0, "settings.spread_after", "0", "above 0 to tell differences");
  for (std::size_t k = 0; k < film_.tile_count(); ++k) {
    FilmTile &tile = film_.tile(k);
    const std::lock_guard lock(tile.mutex);
    const auto samples = static_cast<float>(tile.pixels.size() * settings_.spread_after);
    const float rays = static_cast<float>(tile_rays_[k]) / samples;
    for (std::size_t i = 0; i < tile.pixels.size(); ++i) {
      const HalfErrors errors = half_errors(tile, i);
      const std::size_t at = 3 * pixel_of(tile, i);
      out[at] = errors.now;
      out[at + 1] = errors.before;
      out[at + 2] = rays;
    }
  }
}

bool Session::wait(double seconds) {
  std::unique_lock lock(mutex_);
  const bool done =
      changed_.wait_for(lock, std::chrono::duration<double>(std::max(seconds, 0.0)), [this] { return running_ == 0; });
  if (done && error_) std::rethrow_exception(std::exchange(error_, nullptr));
  return done;
}

void Session::continue_on_cpu() {
  const std::lock_guard lock(mutex_);
  if (running_ > 0) throw std::logic_error("this session is at work");
  for (std::thread &thread : threads_) thread.join();
  threads_.clear();
  use_embree();
  workspaces_.clear();
  device_ = make_cpu_device(job_);
  settings_.device.kind = "CPU";
  next_work_ = 0;
  cancel_ = false;
}

double Session::progress() const {
  if (!most_.empty()) {
    return planned_ > 0 ? static_cast<double>(taken_.load(std::memory_order_relaxed)) / static_cast<double>(planned_)
                        : 1.0;
  }
  const double total = static_cast<double>(pass_ends_.back()) * static_cast<double>(film_.tile_count());
  return static_cast<double>(samples_finished_.load(std::memory_order_relaxed)) / total;
}

std::uint32_t Session::samples_done() const {
  std::uint32_t least = ~0u;
  for (const auto &passes : tile_passes_) least = std::min(least, passes.load(std::memory_order_relaxed));
  return least > 0 ? pass_ends_[least - 1] : 0;
}

void Session::read(const std::string &pass, std::span<float> out) {
  film_.read(pass, {settings_.transparent, settings_.reweighting}, out);
}

SessionStats Session::stats() const {
  const std::lock_guard lock(mutex_);
  SessionStats s;
  const auto end = running_ > 0 ? std::chrono::steady_clock::now() : end_;
  s.render_seconds = std::chrono::duration<double>(end - begin_).count();
  s.rays = counts_;
  s.bytes = film_.bytes();
  s.features = job_.features;
  s.device = device_->figures();
  return s;
}

}  // namespace cotorra
