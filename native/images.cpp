// SPDX-License-Identifier: GPL-3.0-or-later
// Takes images over, and tells of a slot what can be known beforehand: its mean, and whether it stays at 1.
#include "images.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace cotorra {
namespace {
constexpr uint KERNEL_FEATURES = ~0u;
}
}  // namespace cotorra

#include "../kernels/texture.h"

namespace cotorra {
namespace {

constexpr std::size_t kLargestSide = 1u << 24;  // beyond, a float cannot tell neighbouring texels apart
constexpr std::uint64_t kMostNumbers = 0xffffffffu;  // kernels count them with 32 bits
constexpr uint kMeanSide = 256;  // texels of a row and of a column that slot_mean looks at

std::size_t bytes_of(uint format) {
  if (format == TEXELS_FLOAT) return 4;
  return format == TEXELS_UINT8 ? 1 : 2;
}

// The value of texel (x, y) as a slot sees it.
vec3 texel_value(const Texture &image, const TextureSlot &slot, uint x, uint y) {
  vec4 c = texture_texel(image, static_cast<int>(x), static_cast<int>(y));
  c = texture_decode(image, slot, c);
  return texture_value(slot, c);
}

}  // namespace

std::uint64_t Textures::bytes() const {
  std::uint64_t sum = image_bytes + images.size() * sizeof(Texture) + slots.size() * sizeof(TextureSlot);
  sum += inputs.size() * sizeof(MaterialInputs) + meshes.size() * sizeof(MeshTextures);
  return sum + spaces.size() * sizeof(ObjectSpace);
}

void add_image(ImageInput in, Textures &textures) {
  const std::uint64_t numbers = static_cast<std::uint64_t>(in.width) * in.height * in.channels;
  const std::string shape =
      std::to_string(in.width) + " x " + std::to_string(in.height) + " x " + std::to_string(in.channels);
  if (in.width == 0 || in.height == 0 || in.width > kLargestSide || in.height > kLargestSide || in.channels == 0 ||
      in.channels > 4 || numbers > kMostNumbers) {
    throw std::invalid_argument("image '" + in.name + "': " + shape +
                                " pixels and channels; sides must be 1 to 16777216, channels 1 to 4, and all numbers "
                                "together fewer than 4294967296");
  }
  const std::size_t bytes = static_cast<std::size_t>(numbers) * bytes_of(in.format);
  Texture texture{};
  // Kernels read words: pixels that do not begin and end with one are copied.
  const bool whole = reinterpret_cast<std::uintptr_t>(in.pixels) % sizeof(uint) == 0 && bytes % sizeof(uint) == 0;
  if (whole) {
    texture.texels = {static_cast<const uint *>(in.pixels)};
    textures.owners.push_back(std::move(in.owner));
  } else {
    std::vector<uint> copy((bytes + sizeof(uint) - 1) / sizeof(uint));
    std::memcpy(copy.data(), in.pixels, bytes);
    texture.texels = {copy.data()};
    textures.copies.push_back(std::move(copy));
  }
  texture.width = static_cast<uint>(in.width);
  texture.height = static_cast<uint>(in.height);
  texture.channels = static_cast<uint>(in.channels);
  texture.format = in.format;
  texture.srgb = in.srgb ? 1u : 0u;
  textures.images.push_back(texture);
  textures.image_bytes += bytes;
}

vec3 slot_mean(const Textures &textures, const TextureSlot &slot) {
  const Texture &image = textures.images[slot.image];
  const uint columns = std::min(image.width, kMeanSide);
  const uint rows = std::min(image.height, kMeanSide);
  double sum[3] = {0.0, 0.0, 0.0};
  for (uint j = 0; j < rows; ++j) {
    for (uint i = 0; i < columns; ++i) {
      const auto x = static_cast<uint>((2ull * i + 1) * image.width / (2ull * columns));
      const auto y = static_cast<uint>((2ull * j + 1) * image.height / (2ull * rows));
      const vec3 v = texel_value(image, slot, x, y);
      sum[0] += static_cast<double>(v.x);
      sum[1] += static_cast<double>(v.y);
      sum[2] += static_cast<double>(v.z);
    }
  }
  const double n = static_cast<double>(columns) * rows;
  return {static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n), static_cast<float>(sum[2] / n)};
}

bool slot_below_one(const Textures &textures, const TextureSlot &slot) {
  const Texture &image = textures.images[slot.image];
  if (slot.extension == EXTENSION_CLIP) return true;
  for (uint y = 0; y < image.height; ++y) {
    for (uint x = 0; x < image.width; ++x) {
      if (texel_value(image, slot, x, y).x < 1.0f) return true;
    }
  }
  return false;
}

}  // namespace cotorra
