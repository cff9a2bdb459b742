// SPDX-License-Identifier: GPL-3.0-or-later
// Checks what materials read from images, and derives the records that kernels read beside Material and Mesh.
// Pixels are taken over in images.cpp.
#include <algorithm>
#include <cmath>
#include <string>

#include "scene.h"

namespace cotorra {
namespace {

constexpr uint KERNEL_FEATURES = ~0u;

}
}  // namespace cotorra

#include "../kernels/bsdf.h"

namespace cotorra {
namespace {

void require_entries(std::size_t size, std::size_t expected, const char *name) {
  if (size == expected) return;
  throw std::invalid_argument("textures." + std::string(name) + " has " + std::to_string(size) + " entries, expected " +
                              std::to_string(expected));
}

void require_below(std::size_t value, std::size_t limit, const std::string &name) {
  if (value < limit) return;
  throw std::invalid_argument("textures." + name + " = " + std::to_string(value) + ", must be below " +
                              std::to_string(limit));
}

void check_slot(const TextureSlot &slot, std::size_t index, const TexturesInput &in) {
  const std::string name = "slots[" + std::to_string(index) + "].";
  require_below(slot.image, in.images.size(), name + "image");
  require_below(slot.channel, CHANNEL_LUMINANCE + 1, name + "channel");
  require_below(slot.coordinates, COORDINATES_WORLD + 1, name + "coordinates");
  require_below(slot.interpolation, INTERPOLATION_CUBIC + 1, name + "interpolation");
  require_below(slot.extension, EXTENSION_MIRROR + 1, name + "extension");
  if (slot.coordinates == COORDINATES_OBJECT && in.world_to_object.empty()) {
    throw std::invalid_argument("textures." + name +
                                "coordinates are object coordinates, but instances.spaces is None");
  }
}

bool equal(vec4 a, vec4 b) { return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w; }

// Do two slots read the same texel?
bool same_lookup(const TextureSlot &a, const TextureSlot &b) {
  return a.image == b.image && equal(a.mapping_s, b.mapping_s) && equal(a.mapping_t, b.mapping_t) &&
         a.coordinates == b.coordinates && a.uv_layer == b.uv_layer && a.interpolation == b.interpolation &&
         a.extension == b.extension && a.flags == b.flags;
}

std::vector<TextureSlot> slot_records(const TexturesInput &in) {
  std::vector<TextureSlot> slots(in.slots.begin(), in.slots.end());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    check_slot(slots[i], i, in);
    if (std::isnan(slots[i].threshold)) slots[i].threshold = INFINITE_DISTANCE;
    const auto same = std::find_if(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(i),
                                   [&](const TextureSlot &other) { return same_lookup(slots[i], other); });
    slots[i].lookup = static_cast<uint>(same - slots.begin());
  }
  return slots;
}

MaterialInputs inputs_record(const TexturesInput &in, std::size_t material) {
  const int *slots = in.inputs.data() + material * kTexturedInputs;
  for (std::size_t k = 0; k < kTexturedInputs; ++k) {
    if (slots[k] >= -1 && slots[k] < static_cast<int>(in.slots.size())) continue;
    throw std::invalid_argument("textures.inputs[" + std::to_string(material) + ", " + std::to_string(k) + "] = " +
                                std::to_string(slots[k]) + ", must be -1 or below " + std::to_string(in.slots.size()));
  }
  require_below(in.normal_space[material], NORMAL_WORLD + 1, "normal_space[" + std::to_string(material) + "]");
  return {slots[0],
          slots[1],
          slots[2],
          slots[3],
          slots[4],
          slots[5],
          slots[6],
          slots[7],
          slots[8],
          in.normal_strength[material],
          in.normal_tangent[material],
          in.normal_space[material]};
}

// MATERIAL_SPECULAR, _DIFFUSE and _SHARP for whatever the images may hold.
uint possible_flags(const Material &material, const MaterialInputs &inputs) {
  Material m = material;
  if (inputs.base_color >= 0) m.base_color = vec3(1.0f);
  if (inputs.ior >= 0) m.ior = 1.5f;
  if (inputs.specular_level >= 0) m.specular_level = 0.5f;
  uint flags = principled_flags(m);
  if (inputs.metallic >= 0) {
    m.metallic = 0.0f;
    flags = principled_flags(m) | MATERIAL_SPECULAR;
  }
  const bool sharp = inputs.roughness >= 0 || material.roughness < kSharpRoughness;
  return flags | ((flags & MATERIAL_SPECULAR) != 0 && sharp ? MATERIAL_SHARP : 0u);
}

// Entries of a layer of corner data, of which `total` come for all layers: layers hold one entry for each corner, and
// the last corner belongs to some triangle.
uint corners_of_layer(std::span<const uvec3> corners, std::size_t total, uint &layers) {
  uint last = 0;
  for (const uvec3 &c : corners) last = std::max({last, c.x, c.y, c.z});
  std::size_t count = std::max<std::size_t>(total / (static_cast<std::size_t>(last) + 1), 1);
  while (total % count != 0) --count;
  layers = static_cast<uint>(count);
  return static_cast<uint>(total / count);
}

}  // namespace

void Scene::prepare_textures(TexturesInput &in, std::span<const uint> emission_sampling,
                             std::span<const uint> emission_sides) {
  if (in.inputs.empty()) return;
  const std::size_t n = materials_.size();
  require_entries(in.inputs.size(), n * kTexturedInputs, "inputs");
  require_entries(in.normal_strength.size(), n, "normal_strength");
  require_entries(in.normal_tangent.size(), n, "normal_tangent");
  require_entries(in.normal_space.size(), n, "normal_space");
  textures_.slots = slot_records(in);
  for (ImageInput &image : in.images) add_image(std::move(image), textures_);
  for (std::size_t i = 0; i < n; ++i) {
    MaterialInputs inputs = inputs_record(in, i);
    Material &m = materials_[i];
    if (std::any_of(&inputs.base_color, &inputs.normal + 1, [](int slot) { return slot >= 0; })) {
      m.flags |= MATERIAL_TEXTURED;
      if ((m.flags & MATERIAL_MODEL) == 0) {
        m.flags &= ~(MATERIAL_SPECULAR | MATERIAL_DIFFUSE | MATERIAL_SHARP);
        m.flags |= possible_flags(m, inputs);
      } else if ((m.flags & MATERIAL_SPECULAR) != 0 && inputs.roughness >= 0) {
        m.flags |= MATERIAL_SHARP;
      }
    }
    if (inputs.emission >= 0) {
      m.emission = slot_mean(textures_, textures_.slots[static_cast<std::size_t>(inputs.emission)]);
      set_emission_flags(m, emission_sampling[i], emission_sides.empty() ? 3u : emission_sides[i]);
    }
    if (inputs.alpha >= 0) {
      const bool below = slot_below_one(textures_, textures_.slots[static_cast<std::size_t>(inputs.alpha)]);
      m.alpha = 1.0f;
      m.flags = below ? m.flags | MATERIAL_TRANSPARENT : m.flags & ~MATERIAL_TRANSPARENT;
    }
    textures_.inputs.push_back(inputs);
  }
  data_.textures = {textures_.images.data()};
  data_.texture_slots = {textures_.slots.data()};
  data_.material_inputs = {textures_.inputs.data()};
}

void Scene::prepare_object_spaces(std::span<const float> world_to_object, std::span<const uint> order) {
  if (world_to_object.empty()) return;
  require_entries(world_to_object.size(), order.size() * 12, "world_to_object");
  for (const uint i : order) {
    const float *m = world_to_object.data() + std::size_t{12} * i;
    textures_.spaces.push_back(
        {vec4(m[0], m[1], m[2], m[3]), vec4(m[4], m[5], m[6], m[7]), vec4(m[8], m[9], m[10], m[11])});
  }
  data_.object_spaces = {textures_.spaces.data()};
}

void Scene::prepare_mesh_textures(const SceneInput &in) {
  if (textures_.inputs.empty()) return;
  textures_.meshes.resize(in.meshes.size());
  for (std::size_t k = 0; k < in.meshes.size(); ++k) {
    const MeshInput &source = in.meshes[k];
    MeshTextures &m = textures_.meshes[k];
    const std::string name = "mesh '" + source.name + "': ";
    const std::size_t uv = source.uv.size();
    if (uv > 0) m.corner_count = corners_of_layer(source.corners, uv, m.uv_layers);
    if (!source.tangents.empty()) {
      if (m.corner_count == 0)
        m.corner_count = corners_of_layer(source.corners, source.tangents.size(), m.tangent_layers);
      m.tangent_layers = static_cast<uint>(source.tangents.size() / m.corner_count);
      if (source.corners.empty() || m.tangent_layers == 0) {
        throw std::invalid_argument(name + "tangents has " + std::to_string(source.tangents.size()) +
                                    " entries, expected one for each corner");
      }
    }
    if (!source.generated.empty() && source.generated.size() != source.positions.size()) {
      throw std::invalid_argument(name + "generated has " + std::to_string(source.generated.size()) +
                                  " entries, expected " + std::to_string(source.positions.size()));
    }
    m.tangents = {source.tangents.data()};
    m.generated = {source.generated.data()};
  }
  data_.mesh_textures = {textures_.meshes.data()};
}

void Scene::note_frame(std::size_t mesh, const Instance &instance) {
  if (textures_.meshes.empty()) return;
  MeshTextures &m = textures_.meshes[mesh];
  m.moved = 1;
  m.x_axis = instance.x_axis;
  m.y_axis = instance.y_axis;
  m.z_axis = instance.z_axis;
  m.normal_x = instance.normal_x;
  m.normal_y = instance.normal_y;
  m.normal_z = instance.normal_z;
}

void set_emission_flags(Material &m, uint sampled, uint sides) {
  m.flags &= ~(MATERIAL_EMISSIVE | MATERIAL_SAMPLED | MATERIAL_EMIT_FRONT | MATERIAL_EMIT_BACK);
  if (!(max(max(m.emission.x, m.emission.y), m.emission.z) > 0.0f)) return;
  m.flags |= MATERIAL_EMISSIVE;
  // Triangles are picked by luminance, which colours with negative parts may lack.
  const float luminance = dot(m.emission, vec3(0.2126f, 0.7152f, 0.0722f));
  if (sampled != 0 && luminance > 0.0f) m.flags |= MATERIAL_SAMPLED;
  m.flags |= ((sides & 1u) != 0 ? MATERIAL_EMIT_FRONT : 0u) | ((sides & 2u) != 0 ? MATERIAL_EMIT_BACK : 0u);
}

}  // namespace cotorra
