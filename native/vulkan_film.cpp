// SPDX-License-Identifier: GPL-3.0-or-later
// Places pixels, keeps a buffer for each kind of sum that the passes ask for, and unpacks what comes back.
// Sums that no pass asks for have no memory here.
#include "vulkan_film.h"

#include <algorithm>
#include <cstring>

#include "every_feature.h"

#include "../kernels/wavefront.h"

namespace cotorra::vulkan {
namespace {

constexpr const char *kPurpose = "the film";
constexpr std::size_t kFilmPixels = 1 << 21;
constexpr std::size_t kFilmPixelsShared = 1 << 18;  // each with a window of sums
constexpr std::size_t kFilmPixelsOfCpu = 1 << 16;

}  // namespace

std::size_t film_pixels_at_once(const Physical &physical, const PassSelection &passes) {
  if (is_cpu(physical)) return kFilmPixelsOfCpu;
  return passes.shared ? kFilmPixelsShared : kFilmPixels;
}

FilmOnCard::FilmOnCard(LogicalDevice &device, const RenderJob &job) : device_(device), job_(job) {}
FilmOnCard::~FilmOnCard() = default;

std::size_t FilmOnCard::place(std::span<FilmTile> tiles) {
  pixels_.clear();
  place_.clear();
  for (FilmTile &tile : tiles) {
    const auto x0 = static_cast<uint>(job_.region_x + tile.x0);
    const auto y0 = static_cast<uint>(job_.region_y + tile.y0);
    const auto width = static_cast<uint>(tile.width);
    const uint seed = sampler_block_seed(x0, y0, job_.sample_bits, job_.seed);
    const std::size_t first = pixels_.size();
    for (const std::uint16_t i : tile.to_sample()) pixels_.push_back({x0 + i % width, y0 + i / width, seed, 0u, 0u});
    if (job_.passes.shared) share(tile, first);
  }
  return pixels_.size();
}

// Tells the pixels of a tile, those of the list from `first` on, which of them are around each.
void FilmOnCard::share(const FilmTile &tile, std::size_t first) {
  constexpr int kReach = SHARING_SIDE / 2;
  const std::size_t corner = place_.size();
  place_.resize(corner + kTilePixels, INVALID_ID);
  std::size_t pixel = first;
  for (const std::uint16_t i : tile.to_sample()) {
    const auto width = static_cast<std::size_t>(tile.width);
    const std::size_t place = corner + i / width * kTileSide + i % width;
    pixels_[pixel].place = static_cast<uint>(place);
    place_[place] = static_cast<uint>(pixel++);
  }
  pixel = first;
  for (const std::uint16_t i : tile.to_sample()) {
    WavePixel &p = pixels_[pixel++];
    const int x0 = i % tile.width, y0 = i / tile.width;
    for (int y = std::max(y0 - kReach, 0); y <= std::min(y0 + kReach, tile.height - 1); ++y) {
      for (int x = std::max(x0 - kReach, 0); x <= std::min(x0 + kReach, tile.width - 1); ++x) {
        const bool sampled =
            place_[corner + static_cast<std::size_t>(y) * kTileSide + static_cast<std::size_t>(x)] != INVALID_ID;
        p.sampled |= (sampled ? 1u : 0u) << ((y - y0 + kReach) * static_cast<int>(SHARING_SIDE) + x - x0 + kReach);
      }
    }
  }
}

template <class T>
T *FilmOnCard::add(std::uint64_t count, std::uint64_t &bytes) {
  bytes += count * sizeof(T);
  return add_buffer<T>(device_, buffers_, count, kPurpose);
}

void FilmOnCard::reserve(WaveData &wave) {
  if (pixels_.size() <= room_ && place_.size() <= place_room_) return;
  const std::uint64_t n = std::max<std::uint64_t>(pixels_.size(), WAVE_GROUP_SIZE);
  buffers_.clear();
  host_.reset();
  shares_.reset();
  places_.reset();
  const PassSelection &passes = job_.passes;
  std::uint64_t listed = 0, summed = 0;
  wave.pixels.v = add<WavePixel>(n, listed);
  wave.film.v = add<FilmPixel>(n, summed);
  if (passes.shared) {
    wave.film_shared.v = add<SharedSum>(n, summed);
    shares_ = std::make_unique<Buffer>(device_, n * SHARING_WINDOW * sizeof(SharedSum), kPurpose);
    wave.film_shares.v = reinterpret_cast<SharedSum *>(shares_->address());
    place_room_ = place_.size();
    places_ = std::make_unique<Buffer>(device_, place_room_ * sizeof(uint), kPurpose);
    wave.film_places.v = reinterpret_cast<uint *>(places_->address());
    wave.tile_side = kTileSide;
    listed += places_->size();
  }
  if ((job_.features & FEATURE_DATA_PASSES) != 0) wave.film_records.v = add<WaveRecord>(n, summed);
  if (passes.bright) wave.film_bright.v = add<BrightSum>(n * BRIGHT_CASCADES, summed);
  if (passes.light_groups > 0) wave.film_groups.v = add<vec3>(n * passes.light_groups, summed);
  if (passes.lamps > 0) wave.film_lamps.v = add<vec3>(n * passes.lamps, summed);
  if (passes.terms) wave.film_terms.v = add<WaveTerms>(n, summed);
  // The list of pixels goes through the buffer in which the film will come back.
  host_ = std::make_unique<Buffer>(device_, std::max(listed, summed), kPurpose, true);
  room_ = n;
}

void FilmOnCard::clear(VkCommandBuffer commands) {
  const VkBufferCopy region{0, 0, pixels_.size() * sizeof(WavePixel)};
  std::memcpy(host_->data(), pixels_.data(), region.size);
  device_.vkCmdCopyBuffer(commands, host_->handle(), buffers_[0]->handle(), 1, &region);
  if (places_ != nullptr) {
    const VkBufferCopy places{region.size, 0, place_.size() * sizeof(uint)};
    std::memcpy(host_->data() + places.srcOffset, place_.data(), places.size);
    device_.vkCmdCopyBuffer(commands, host_->handle(), places_->handle(), 1, &places);
    device_.vkCmdFillBuffer(commands, shares_->handle(), 0, VK_WHOLE_SIZE, 0);
  }
  for (std::size_t i = 1; i < buffers_.size(); ++i) {
    device_.vkCmdFillBuffer(commands, buffers_[i]->handle(), 0, VK_WHOLE_SIZE, 0);
  }
}

void FilmOnCard::read(std::span<FilmTile> tiles, std::uint32_t count) {
  device_.run([&](VkCommandBuffer commands) {
    all_barrier(device_, commands);
    std::uint64_t offset = 0;
    for (std::size_t i = 1; i < buffers_.size(); ++i) {
      const VkBufferCopy region{0, offset, buffers_[i]->size()};
      device_.vkCmdCopyBuffer(commands, buffers_[i]->handle(), host_->handle(), 1, &region);
      offset += region.size;
    }
  });
  FilmTile staged;
  std::size_t pixel = 0;
  for (FilmTile &tile : tiles) {
    if (tile.to_sample().empty()) continue;
    staged.clear_as(tile);
    for (const std::uint16_t i : tile.to_sample()) take(staged, pixel++, i);
    tile.add(staged, count);
  }
}

// Pixel number `pixel` of those that were placed becomes pixel i of its tile.
void FilmOnCard::take(FilmTile &staged, std::size_t pixel, std::size_t i) const {
  const std::byte *at = host_->data();
  const auto next = [&]<class T>(std::size_t each, T *) {
    const T *array = reinterpret_cast<const T *>(at) + pixel * each;
    at += room_ * each * sizeof(T);
    return array;
  };
  staged.pixels[i] = *next(1, static_cast<FilmPixel *>(nullptr));
  if (job_.passes.shared) staged.shared[i] = *next(1, static_cast<SharedSum *>(nullptr));
  if ((job_.features & FEATURE_DATA_PASSES) != 0) {
    const WaveRecord &r = *next(1, static_cast<WaveRecord *>(nullptr));
    if (!staged.nearest.empty() && r.hit > 0.0f) {
      staged.nearest[i] = {r.distance2, r.depth, r.position, r.object_index, r.material_index};
    }
    if (!staged.surface.empty()) staged.surface[i] = {r.normal, r.uv, r.uv_coverage, r.diffuse_color};
    if (!staged.features.empty()) staged.features[i] = {r.feature_albedo, r.feature_normal};
    if (!staged.emission.empty()) staged.emission[i] = r.emission;
    if (!staged.environment.empty()) staged.environment[i] = r.environment;
    if (!staged.shadow.empty()) staged.shadow[i] = {r.lit, r.unshadowed};
    if (!staged.occlusion.empty()) staged.occlusion[i] = r.occlusion;
  }
  if (job_.passes.bright) {
    std::copy_n(next(BRIGHT_CASCADES, static_cast<BrightSum *>(nullptr)), BRIGHT_CASCADES,
                staged.bright.begin() + static_cast<std::ptrdiff_t>(i * BRIGHT_CASCADES));
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

}  // namespace cotorra::vulkan
