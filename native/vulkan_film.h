// SPDX-License-Identifier: GPL-3.0-or-later
// The film of the tiles that a graphics card renders at once: room for its sums on the card, and their way back into
// the tiles. Who adds to it there is kernels/entry/vulkan/film.comp; the tiles are film.h's.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cpu_kernel.h"
#include "vulkan_api.h"

namespace cotorra {
struct WaveData;
struct WavePixel;
}  // namespace cotorra

namespace cotorra::vulkan {

class FilmOnCard {
 public:
  // Both must outlive it.
  FilmOnCard(LogicalDevice &device, const RenderJob &job);
  ~FilmOnCard();
  FilmOnCard(const FilmOnCard &) = delete;
  FilmOnCard &operator=(const FilmOnCard &) = delete;

  // Lists the pixels of the tiles that are to be sampled; returns how many there are.
  std::size_t place(std::span<FilmTile> tiles);
  // Makes room for the film of the pixels that were placed, and tells `wave` where.
  void reserve(WaveData &wave);
  // Copies the list of pixels, and clears their film.
  void clear(VkCommandBuffer commands);
  // Adds the card's sums, of `count` samples a pixel, to the tiles that were placed.
  void read(std::span<FilmTile> tiles, std::uint32_t count);

 private:
  template <class T>
  T *add(std::uint64_t count, std::uint64_t &bytes);
  void share(const FilmTile &tile, std::size_t first);
  void take(FilmTile &staged, std::size_t pixel, std::size_t i) const;

  LogicalDevice &device_;
  const RenderJob &job_;
  std::vector<std::unique_ptr<Buffer>> buffers_;  // the first are the pixels
  std::unique_ptr<Buffer> host_;
  std::size_t room_ = 0, place_room_ = 0;  // pixels that the buffers can hold, and places of pixels
  std::vector<WavePixel> pixels_;
  // Where pixels share samples.
  std::unique_ptr<Buffer> shares_, places_;
  std::vector<std::uint32_t> place_;  // [tiles * kTilePixels] the pixel of the list that lies there
};

// Tiles of a session have no more pixels.
constexpr std::size_t kTileSide = 32;
constexpr std::size_t kTilePixels = kTileSide * kTileSide;

// Pixels whose sums are on the card at once.
std::size_t film_pixels_at_once(const Physical &physical, const PassSelection &passes);

}  // namespace cotorra::vulkan
