// SPDX-License-Identifier: GPL-3.0-or-later
// Images and their uses by materials, as the native module holds them: the exporter's pixels, shared and not copied,
// and the records that kernels read. What a texel becomes is told in kernels/texture.h.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "../kernels/scene_types.h"

namespace cotorra {

// Views of the exporter's arrays (addon/export/buffers.py, Image and MaterialTextures). `owner` keeps them alive.
struct ImageInput {
  std::string name;
  const void *pixels = nullptr;
  std::size_t width = 0, height = 0, channels = 0;
  uint format = TEXELS_UINT8;
  bool srgb = false;
  std::shared_ptr<void> owner;
};

struct TexturesInput {
  std::span<const TextureSlot> slots;
  std::span<const int> inputs;  // [materials * kTexturedInputs]
  std::span<const float> normal_strength;
  std::span<const uint> normal_tangent;
  std::span<const uint> normal_space;
  std::vector<ImageInput> images;
  std::span<const float> world_to_object;  // [instances * 12], rows; empty where no slot asks for it
};

constexpr std::size_t kTexturedInputs = 9;  // integers at the beginning of MaterialInputs

// Everything that kernels read beside Material and Mesh where materials read images.
struct Textures {
  std::vector<Texture> images;
  std::vector<std::vector<uint>> copies;  // of pixels that do not begin and end with a word
  std::vector<std::shared_ptr<void>> owners;
  std::vector<TextureSlot> slots;
  std::vector<MaterialInputs> inputs;
  std::vector<MeshTextures> meshes;
  std::vector<ObjectSpace> spaces;
  std::uint64_t image_bytes = 0;

  std::uint64_t bytes() const;
};

// Checks one image (std::invalid_argument with its name) and takes it over.
void add_image(ImageInput input, Textures &textures);

// Mean over the image of what a slot makes of it, by components, without filtering; a sample of it where it is large.
vec3 slot_mean(const Textures &textures, const TextureSlot &slot);

// Whether a slot's first component may be below 1 anywhere.
bool slot_below_one(const Textures &textures, const TextureSlot &slot);

}  // namespace cotorra
