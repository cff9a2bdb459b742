// SPDX-License-Identifier: GPL-3.0-or-later
// One render in progress: a camera's view of a scene, refined pass by pass over tiles by a pool of threads.
// It can be asked for its state, read and cancelled at any time; Python is not known here.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "camera_view.h"
#include "cpu_kernel.h"
#include "device.h"
#include "film.h"
#include "ray_tracer.h"
#include "scene.h"

namespace cotorra {

struct SettingsInput {  // addon/export/buffers.py, RenderSettings
  std::string integrator = "DIRECT";
  std::int64_t samples = 64;
  std::uint32_t seed = 0;
  std::uint32_t max_bounces = 12, diffuse_bounces = 4, glossy_bounces = 4, transmission_bounces = 12;
  std::uint32_t transparent_bounces = 8;
  float clamp_direct = 0.0f, clamp_indirect = 0.0f;  // 0: no limit
  float filter_glossy = 0.0f;
  float light_threshold = 0.0f;
  float reweighting = 0.0f, white = 1.0f;
  bool sharing = false;
  bool reflective_caustics = true, refractive_caustics = true;
  bool adaptive = false;
  float noise_threshold = 0.01f;
  std::uint32_t adaptive_min_samples = 0;
  std::uint32_t spread_after = 0;  // samples after which `spread` tells where more are taken, 0: all pixels take all
  bool transparent = false;
  int threads = 0;
  bool measure_tracing = false;
  bool health = false;
  float firefly_limit = 1e30f;
  std::vector<std::string> passes;
  std::array<float, 3> ambient_color{1.0f, 1.0f, 1.0f};
  float ambient_strength = 0.0f;
  bool use_ambient_occlusion = false;
  float ao_distance = 10.0f;
  std::uint32_t whitted_depth = 8;
  float whitted_threshold = 0.003f;
  bool use_transparent_shadows = false;
  bool toon_outline = true;
  float outline_width = 0.3f;  // percent of the picture's height
  std::array<float, 3> outline_color{};
  bool outline_normal = true, outline_depth = true, outline_object = true;
  DeviceChoice device;
  bool operator==(const SettingsInput &) const = default;
};

struct SessionStats {
  double render_seconds = 0.0;
  RayCounts rays;
  std::uint64_t bytes = 0;
  std::uint32_t features = 0;  // in use
  DeviceFigures device;
};

class Session {
 public:
  // Throws std::invalid_argument naming the setting that is wrong, DeviceError where the device cannot render this.
  // `restarts`: `restart` will be called, for which threads' memory, and what is on a graphics card, is kept.
  Session(std::shared_ptr<const Scene> scene, const CameraInput &camera, const SettingsInput &settings,
          bool restarts = false);
  ~Session();
  Session(const Session &) = delete;
  Session &operator=(const Session &) = delete;

  void start();
  // Stops, forgets the picture, and is as a new session; `start` is to be called. What is on a graphics card stays
  // where the settings differ in nothing but samples, noise and seed. Throws as the constructor.
  void restart(const CameraInput &camera, const SettingsInput &settings);
  // True when all threads have stopped. Rethrows what a thread threw.
  bool wait(double seconds);
  // After `wait` threw DeviceError: `start` will let the CPU take the samples that are missing; those that there are
  // stay.
  void continue_on_cpu();
  void cancel() { cancel_.store(true, std::memory_order_relaxed); }
  // After `cancel`: goes on with the samples that are missing, to the same bits.
  void resume();
  // Once each pixel has settings.spread_after samples: `start` will go on to as many as `most` says, row by row from
  // below, or as the end of the pass in which it reaches them. Throws std::logic_error before, and the second time.
  void spread(std::span<const std::uint32_t> most);
  // What each pixel differs by from itself after half of its samples, and that one from after a quarter: how large its
  // error is and how fast it falls; and the rays of a sample in its tile: what more of them cost. Three numbers each,
  // row by row. For settings.spread_after alone.
  void differences(std::span<float> out);
  double progress() const;
  std::uint32_t samples_done() const;
  void read(const std::string &pass, std::span<float> out);
  SessionStats stats() const;
  int width() const { return film_.width(); }
  int height() const { return film_.height(); }

 private:
  void describe(const CameraInput &camera);
  void stop();
  void use_embree();
  void work(std::size_t thread);
  void run_passes(std::size_t thread, RayCounts &counts);
  void run_tiles(std::size_t first_tile, std::size_t tile_count, std::uint32_t first, std::uint32_t count,
                 Workspace &workspace, RayCounts &counts);
  void update_pending(FilmTile &tile, std::uint32_t samples) const;
  void plan_passes(std::uint32_t samples);
  std::size_t pixel_of(const FilmTile &tile, std::size_t i) const;  // in the whole film, row by row
  void drop_sampled_pixels(FilmTile &tile, std::uint32_t samples) const;

  std::shared_ptr<const Scene> scene_;
  SettingsInput settings_;
  PassSelection passes_;
  std::string filter_;
  std::vector<float> filter_table_;  // inverse CDF, then density
  SceneData scene_data_;
  std::shared_ptr<const RayTracer> tracer_;  // where a program traces rays on the CPU
  Film film_;
  RenderJob job_{};
  bool restarts_;
  std::unique_ptr<Device> device_;
  std::vector<std::unique_ptr<Workspace>> workspaces_;  // by thread, where they are kept
  std::vector<std::uint32_t> pass_ends_;  // samples after each progressive pass
  std::size_t passes_now_ = 0;            // of these, as long as `spread` was not called
  std::vector<std::uint32_t> most_;       // samples of each pixel, as `spread` was told
  std::uint64_t planned_ = 0;             // of all pixels then
  std::atomic<std::uint64_t> taken_ = 0;
  std::vector<std::atomic<std::uint32_t>> tile_passes_;  // passes that each tile has behind it
  std::vector<std::uint64_t>
      tile_rays_;  // of each tile, with settings.spread_after; those of a pass before tile_passes_

  std::atomic<std::uint64_t> next_work_{0};  // a pass over a few tiles
  std::atomic<std::uint64_t> samples_finished_{0};  // tile passes times their samples
  std::atomic<bool> cancel_{false};
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::thread> threads_;
  int running_ = 0;
  RayCounts counts_;
  std::exception_ptr error_;
  std::chrono::steady_clock::time_point begin_{}, end_{};
};

}  // namespace cotorra
