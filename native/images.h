// SPDX-License-Identifier: GPL-3.0-or-later
// Images and other data that shaders read, as the native module holds them: the exporter's pixels, shared and not
// copied, and the records that kernels read. What a texel becomes is told in kernels/texture.h.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "../kernels/scene_types.h"
#include "program_compile.h"

namespace cotorra {

// Views of the exporter's arrays (addon/export/buffers.py, Image). `owner` keeps them alive.
struct ImageInput {
  std::string name;
  const void *pixels = nullptr;
  std::size_t width = 0, height = 0, channels = 0;
  uint format = TEXELS_UINT8;
  bool srgb = false;
  std::shared_ptr<void> owner;
};

// One attribute of a mesh: addon/export/buffers.py, Attribute.
struct AttributeInput {
  uint layer = 0;
  uint domain = ATTRIBUTE_NONE;
  uint components = 3;
  std::span<const vec4> values;
};

// What shaders read beside their own arrays.
struct ProgramsInput {
  std::vector<ShaderInput> shaders;
  std::vector<ImageInput> images;
  uint uv_layers = 1;
  uint attribute_layers = 1;          // those of UV maps included
  std::vector<uint> instance_layers;  // which of them have one value for each instance
  // By instance; empty where no shader asks.
  std::span<const vec4> info_color;
  std::span<const float> info_random;
  std::span<const vec4> instance_attributes;  // [instance_layers * instances]
};

// Everything that kernels read beside Material and Mesh where materials read images.
struct Textures {
  std::vector<Texture> images;
  std::vector<std::vector<uint>> copies;  // of pixels that do not begin and end with a word
  std::vector<std::shared_ptr<void>> owners;
  std::vector<MeshTextures> meshes;
  std::vector<std::vector<uint>> attribute_tables;  // by mesh
  std::vector<std::vector<vec4>> attributes;        // by mesh
  std::vector<ObjectSpace> spaces;
  std::vector<InstanceInfo> infos;
  std::vector<vec4> instance_attributes;  // [instance_layers * instances]
  std::uint64_t image_bytes = 0;

  std::uint64_t bytes() const;
};

// Checks one image (std::invalid_argument with its name) and takes it over.
// Is alpha 1 in all of the image?
bool is_opaque(const ImageInput &image);

void add_image(ImageInput input, Textures &textures);

}  // namespace cotorra
