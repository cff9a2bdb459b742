// SPDX-License-Identifier: GPL-3.0-or-later
// The CPU as a device: one of the builds of cpu_kernel.cpp, a tile at a time on as many threads as there are.
#include <algorithm>
#include <thread>

#include "device.h"

namespace cotorra {
namespace {

class CpuDevice final : public Device {
 public:
  explicit CpuDevice(const RenderJob &job)
      : kernel_(choose_cpu_kernel(job.features & ~(FEATURE_REWEIGHTING | FEATURE_SHARING))) {}

  int threads(int wanted) const override {
    return std::clamp(wanted > 0 ? wanted : static_cast<int>(std::thread::hardware_concurrency()), 1, 1024);
  }
  std::size_t tiles_at_once() const override { return 1; }
  std::uint64_t workspace_bytes() const override { return kernel_.workspace_bytes; }
  std::unique_ptr<Workspace> make_workspace(const RenderJob &job) override { return kernel_.make_workspace(job); }

  bool render(const RenderJob &job, std::span<FilmTile> tiles, std::uint32_t first, std::uint32_t count,
              Workspace &workspace, RayCounts &counts) override {
    return std::all_of(tiles.begin(), tiles.end(), [&](FilmTile &tile) {
      return tile.to_sample().empty() || kernel_.render(job, tile, first, count, workspace, counts);
    });
  }

  DeviceFigures figures() const override {
    DeviceFigures f;
    f.name = "CPU";
    f.isa = kernel_.isa;
    f.features = kernel_.features;
    return f;
  }

 private:
  const CpuKernel &kernel_;
};

}  // namespace

std::unique_ptr<Device> make_cpu_device(const RenderJob &job) { return std::make_unique<CpuDevice>(job); }

}  // namespace cotorra
