// SPDX-License-Identifier: GPL-3.0-or-later
// What a session asks of that which renders its tiles: this machine's processor, or a graphics card.
// A session does not know which it has.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cpu_kernel.h"
#include "film.h"

namespace cotorra {

class Scene;
struct ProgramNeeds;

// A device cannot render this, or cannot go on; another may.
struct DeviceError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Which device, and how it is to be used.
struct DeviceChoice {
  std::string kind = "CPU";  // CPU, VULKAN
  int index = -1;            // of vulkan_devices(); -1: the first that can
  std::string ray_tracing = "AUTO";  // AUTO, SOFTWARE, HARDWARE: what a graphics card traces rays by
  std::string cache;         // folder for compiled kernels, empty: none is kept
  int threads = 0;           // of the host, for what it builds; 0: all
  bool operator==(const DeviceChoice &) const = default;
};

struct DeviceFigures {
  std::string name;
  std::string isa;                 // instruction set of the CPU kernels; on a graphics card: software, ray query
  std::uint32_t features = 0;      // FEATURE_* compiled in
  double build_seconds = 0.0;      // of the device's own BVH
  double upload_seconds = 0.0;
  double compile_seconds = 0.0;    // of the kernels
  double first_seconds = 0.0;      // from the start until the first samples were in the film
  std::uint64_t bytes = 0;         // on the device
  std::vector<std::string> messages;  // of the validation layer, where it is asked for
};

class Device {
 public:
  Device() = default;
  virtual ~Device() = default;
  Device(const Device &) = delete;
  Device &operator=(const Device &) = delete;

  // Threads that may call `render` at once, where the user asks for so many (0: for all).
  virtual int threads(int wanted) const = 0;
  // Tiles that one call of `render` should be given.
  virtual std::size_t tiles_at_once() const = 0;
  virtual std::unique_ptr<Workspace> make_workspace(const RenderJob &) = 0;
  // The job that a workspace was made for is seen from elsewhere now: another camera, seed, or number of samples.
  virtual void look_again(Workspace &) {}
  // What a thread's work takes of this machine's memory, at least; for messages.
  virtual std::uint64_t workspace_bytes() const = 0;
  // Takes samples [first, first + count) of each pixel in each tile's to_sample(). Returns false if cancelled; a tile
  // then has all of these samples or none.
  virtual bool render(const RenderJob &, std::span<FilmTile> tiles, std::uint32_t first, std::uint32_t count,
                      Workspace &, RayCounts &) = 0;
  virtual DeviceFigures figures() const = 0;
};

std::unique_ptr<Device> make_cpu_device(const RenderJob &job);

// Throws DeviceError, saying what is missing, where no such device is there or it cannot render the job.
std::unique_ptr<Device> make_vulkan_device(std::shared_ptr<const Scene> scene, const RenderJob &job,
                                           const DeviceChoice &choice);

// What `make_vulkan_device` chooses from.
struct VulkanDeviceInfo {
  std::string name;
  std::string driver;
  std::string type;         // discrete, integrated, virtual, cpu, other
  std::uint64_t memory = 0;  // of its largest heap, bytes
  bool ray_query = false;
  std::string problem;      // why it cannot be used; empty where it can
};
// Throws DeviceError where this build or this machine has no Vulkan.
std::vector<VulkanDeviceInfo> vulkan_devices();

// One stage of the kernels as a driver compiled it.
struct CompiledStage {
  std::string name;
  double seconds = 0.0;
  std::vector<std::pair<std::string, double>> statistics;  // in the driver's words; none where it tells none
};
// Compiles the kernels with these features, and programs that need this much, for a device, one stage after the other,
// and renders nothing. Throws DeviceError.
std::vector<CompiledStage> compile_vulkan_kernels(std::uint32_t features, const ProgramNeeds &programs,
                                                  const DeviceChoice &choice);

}  // namespace cotorra
