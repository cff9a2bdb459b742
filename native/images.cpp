// SPDX-License-Identifier: GPL-3.0-or-later
// Takes images over: the pixels are shared where kernels can read them as they are.
// Who reads them, and how, is the kernels' business.
#include "images.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace cotorra {
namespace {

constexpr std::size_t kLargestSide = 1u << 24;  // beyond, a float cannot tell neighbouring texels apart
constexpr std::uint64_t kMostNumbers = 0xffffffffu;  // kernels count them with 32 bits

std::size_t bytes_of(uint format) {
  if (format == TEXELS_FLOAT) return 4;
  return format == TEXELS_UINT8 ? 1 : 2;
}

template <class T, class Below>
bool no_alpha(const ImageInput &in, Below below) {
  const T *alpha = static_cast<const T *>(in.pixels) + in.channels - 1;
  for (std::size_t i = 0; i < in.width * in.height; ++i) {
    if (below(alpha[i * in.channels])) return false;
  }
  return true;
}

}  // namespace

bool is_opaque(const ImageInput &in) {
  if (in.channels != 2 && in.channels != 4) return true;
  switch (in.format) {
    case TEXELS_UINT8:
      return no_alpha<std::uint8_t>(in, [](std::uint8_t a) { return a < 0xff; });
    case TEXELS_UINT16:
      return no_alpha<std::uint16_t>(in, [](std::uint16_t a) { return a < 0xffff; });
    case TEXELS_HALF:  // 0x3c00 is 1, from 0x7c00 on there are infinity, NaN and what is negative
      return no_alpha<std::uint16_t>(in, [](std::uint16_t a) { return a < 0x3c00 || a >= 0x7c00; });
    default:
      return no_alpha<float>(in, [](float a) { return !(a >= 1.0f); });
  }
}

std::uint64_t Textures::bytes() const {
  std::uint64_t sum = image_bytes + images.size() * sizeof(Texture) + meshes.size() * sizeof(MeshTextures);
  for (const std::vector<vec4> &values : attributes) sum += values.size() * sizeof(vec4);
  return sum + spaces.size() * sizeof(ObjectSpace) + infos.size() * sizeof(InstanceInfo);
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

}  // namespace cotorra
