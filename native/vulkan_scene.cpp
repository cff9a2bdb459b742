// SPDX-License-Identifier: GPL-3.0-or-later
// Copies a scene's arrays to a graphics card.
// A new array of SceneData needs a line in upload_scene, and nothing else here.
#include "vulkan_scene.h"

#include "../kernels/camera.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cotorra::vulkan {
namespace {

constexpr std::uint64_t kStaging = std::uint64_t{16} << 20;
constexpr std::uint64_t kBlock = std::uint64_t{64} << 20;  // larger arrays get a buffer of their own
constexpr std::uint64_t kAlignment = 16;

std::uint64_t aligned(std::uint64_t size) { return (size + kAlignment - 1) / kAlignment * kAlignment; }

std::span<const uint> texels_of(const Texture &texture) {
  const std::size_t bytes = texture.format == TEXELS_UINT8 ? 1 : texture.format == TEXELS_FLOAT ? 4 : 2;
  const std::size_t numbers = std::size_t{texture.width} * texture.height * texture.channels;
  return {texture.texels.v, (numbers * bytes + sizeof(uint) - 1) / sizeof(uint)};
}

bool is_finite(vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// Triangles at vertices that are no numbers shrink to a point, where no ray meets them. The specification has another
// way to leave them out, but lavapipe loses the rest of the mesh by it. The BVH of our own does not hold them.
void shrink_unusable(std::vector<vec3> &positions, std::vector<uvec3> &triangles) {
  for (uvec3 &t : triangles) {
    if (!is_finite(positions[t.x]) || !is_finite(positions[t.y]) || !is_finite(positions[t.z])) t = uvec3(0u, 0u, 0u);
  }
  for (vec3 &p : positions) {
    if (!is_finite(p)) p = vec3(0.0f);
  }
}

// Vertices and triangles of a mesh.
void upload_shape(std::span<const vec3> positions, std::span<const uvec3> triangles, Uploader &uploader, Mesh &mesh) {
  std::vector<vec3> usable;
  std::vector<uvec3> shrunk;
  if (uploader.device().ray_query() && !std::all_of(positions.begin(), positions.end(), is_finite)) {
    usable.assign(positions.begin(), positions.end());
    shrunk.assign(triangles.begin(), triangles.end());
    shrink_unusable(usable, shrunk);
    positions = usable;
    triangles = shrunk;
  }
  mesh.positions.v = uploader.put(positions, "vertices");
  mesh.triangles.v = uploader.put(triangles, "triangles");
}

void upload_textures(const Scene &scene, Uploader &uploader, SceneData &data) {
  const Textures &source = scene.textures();
  std::vector<Texture> images = source.images;
  for (Texture &image : images) image.texels.v = uploader.put(texels_of(image), "images");
  std::vector<MeshTextures> meshes = source.meshes;
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    MeshTextures &mesh = meshes[k];
    const std::size_t tangents = std::size_t{mesh.tangent_layers} * mesh.corner_count;
    const std::size_t generated = mesh.generated.v != nullptr ? scene.mesh_lengths(k).positions : 0;
    mesh.tangents.v = uploader.put(std::span(mesh.tangents.v, tangents), "tangents");
    mesh.generated.v = uploader.put(std::span(mesh.generated.v, generated), "texture coordinates");
    mesh.attributes.v = uploader.put(std::span(source.attributes[k]), "attributes");
    mesh.attribute_table.v = uploader.put(std::span(source.attribute_tables[k]), "attributes");
  }
  data.textures.v = uploader.put(std::span<const Texture>(images), "images");
  const ProgramLibrary &library = scene.programs();
  data.programs.v = uploader.put(scene.material_programs(), "materials");
  data.program_code.v = uploader.put(std::span(library.code), "programs");
  data.program_closures.v = uploader.put(std::span(library.closures), "programs");
  data.program_constants.v = uploader.put(std::span(library.constants), "programs");
  data.tables.v = uploader.put(std::span(library.tables), "programs");
  data.mesh_textures.v = uploader.put(std::span<const MeshTextures>(meshes), "meshes");
  data.object_spaces.v = uploader.put(std::span(source.spaces), "instances");
  data.instance_attributes.v = uploader.put(std::span(source.instance_attributes), "attributes");
  data.light_programs.v = uploader.put(scene.light_programs(), "lights");
  data.instance_infos.v = uploader.put(std::span(source.infos), "instances");
  data.world_table.v = uploader.put(scene.world_table(), "the world");
}

}  // namespace

Uploader::Uploader(LogicalDevice &device) : device_(device), staging_(device, kStaging, "copying", true) {}
Uploader::~Uploader() = default;

std::uint64_t Uploader::put_bytes(std::span<const std::byte> bytes, const char *purpose) {
  if (bytes.empty()) return 0;
  const std::uint64_t size = aligned(bytes.size());
  if (blocks_.empty() || block_used_ + size > blocks_.back()->size()) {
    blocks_.push_back(std::make_unique<Buffer>(device_, std::max(size, kBlock), purpose));
    block_used_ = 0;
  }
  const Buffer &block = *blocks_.back();
  const std::uint64_t address = block.address() + block_used_;
  for (std::uint64_t done = 0; done < bytes.size();) {
    if (staged_ == kStaging) flush();
    const std::uint64_t part = std::min<std::uint64_t>(bytes.size() - done, kStaging - staged_);
    std::memcpy(staging_.data() + staged_, bytes.data() + done, part);
    copies_.push_back({block.handle(), {staged_, block_used_ + done, part}});
    staged_ = std::min(aligned(staged_ + part), kStaging);
    done += part;
  }
  block_used_ += size;
  return address;
}

void Uploader::flush() {
  if (copies_.empty()) return;
  device_.run([&](VkCommandBuffer commands) {
    for (const Copy &copy : copies_) {
      device_.vkCmdCopyBuffer(commands, staging_.handle(), copy.target, 1, &copy.region);
    }
  });
  copies_.clear();
  staged_ = 0;
}

std::vector<std::unique_ptr<Buffer>> Uploader::finish() {
  flush();
  return std::move(blocks_);
}

std::vector<Mesh> upload_scene(const Scene &scene, std::uint32_t features, Uploader &uploader, SceneData &data) {
  std::vector<Mesh> meshes(scene.meshes().begin(), scene.meshes().end());
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    Mesh &mesh = meshes[k];
    const MeshLengths n = scene.mesh_lengths(k);
    upload_shape(std::span(mesh.positions.v, n.positions), std::span(mesh.triangles.v, n.triangles), uploader, mesh);
    mesh.corners.v = uploader.put(std::span(mesh.corners.v, n.corners), "corners");
    mesh.normals.v = uploader.put(std::span(mesh.normals.v, n.normals), "normals");
    mesh.uv.v = uploader.put(std::span(mesh.uv.v, n.uv), "texture coordinates");
    mesh.slots.v = uploader.put(std::span(mesh.slots.v, n.slots), "material slots");
  }
  data.meshes.v = uploader.put(std::span<const Mesh>(meshes), "meshes");
  data.instances.v = uploader.put(scene.instances(), "instances");
  data.materials.v = uploader.put(std::span(data.materials.v, data.material_count), "materials");
  data.material_slots.v = uploader.put(scene.material_slots(), "material slots");
  data.lights.v = uploader.put(std::span(data.lights.v, data.light_count), "lights");
  data.emitters.v = uploader.put(std::span(data.emitters.v, data.emitter_count), "emitters");
  const LightTree &tree = scene.light_tree();
  data.light_nodes.v = uploader.put(std::span(tree.nodes), "lights");
  data.light_parents.v = uploader.put(std::span(tree.parents), "lights");
  data.light_places.v = uploader.put(std::span(tree.places), "lights");
  data.light_links.v = uploader.put(scene.light_links(), "lights");
  data.light_node_sets.v = uploader.put(scene.light_node_sets(), "lights");
  data.albedo.v = uploader.put(scene.albedo(), "albedo tables");
  data.filter_table.v = uploader.put(std::span(data.filter_table.v, 2 * FILTER_TABLE_SIZE), "the pixel filter");
  const std::size_t models = (features & FEATURE_MODELS) != 0 ? data.material_count : 0;
  data.models.v = uploader.put(std::span(data.models.v, models), "reflection models");
  const std::size_t shapes = (features & FEATURE_LIGHT_SHAPES) != 0 ? data.light_count : 0;
  data.light_shapes.v = uploader.put(std::span(data.light_shapes.v, shapes), "light shapes");
  upload_textures(scene, uploader, data);  // nothing, where no material reads an image
  const bool classic = (features & (FEATURE_WHITTED | FEATURE_OCCLUSION | FEATURE_TOON)) != 0;
  data.classic.v = uploader.put(std::span(data.classic.v, classic ? data.material_count : 0), "materials");
  return meshes;
}

}  // namespace cotorra::vulkan
