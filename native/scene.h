// SPDX-License-Identifier: GPL-3.0-or-later
// A scene as the native module holds it: validated arrays, kernel records derived from them, and Embree's two-level
// BVH. Cameras, settings and pixels belong to a session; Python is not known here.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "../kernels/scene_types.h"
#include "embree.h"
#include "images.h"
#include "light_tree.h"
#include "quads.h"
#include "scene_models.h"
#include "world_table.h"

namespace cotorra {

// Thrown when the caller asked to stop.
struct Cancelled : std::runtime_error {
  Cancelled() : std::runtime_error("cancelled") {}
};

// Views of the exporter's arrays (addon/export/buffers.py has shapes and units). `owner` keeps them alive.
struct MeshInput {
  std::string name;
  std::span<const vec3> positions;
  bool positions_padded = false;  // 4 readable bytes follow the last vertex
  std::span<const uvec3> triangles;
  std::span<const uvec3> corners;
  std::span<const vec3> normals;
  bool corner_normals = false;
  std::span<const vec2> uv;  // layer by layer
  std::span<const vec4> tangents;
  std::span<const vec3> generated;
  std::vector<AttributeInput> attributes;
  std::span<const uint> slots;
  std::shared_ptr<void> owner;
};

struct InstancesInput {
  std::span<const uint> mesh;
  std::span<const float> transform;  // [instances * 12], rows
  std::span<const uint> material_base;
  std::span<const uint> material_count;
  std::span<const int> pass_index;
  std::span<const uint> visibility;
  std::span<const int> light_group;
  std::span<const float> terminator;
};

struct MaterialsInput {
  std::span<const int> pass_index;
  std::span<const uint> emission_sampling;
  std::span<const int> shader;  // -1: the default grey
  ModelsInput models{};
};

struct LightsInput {
  std::span<const uint> type;
  std::span<const vec3> strength;
  std::span<const float> transform;  // [lights * 12], rows
  std::span<const float> size;
  std::span<const float> spot_size;
  std::span<const float> spot_blend;
  std::span<const uint> soft_falloff;
  std::span<const uint> normalize;
  std::span<const uint> cast_shadow;
  std::span<const uint> use_mis;
  std::span<const uint> max_bounces;
  std::span<const uint> visibility;
  std::span<const int> light_group;
  // What follows may be empty: lamps are then Blender's.
  std::span<const uint> falloff{};
  std::span<const float> range{};
  std::span<const vec3> polynomial{};
  std::span<const uint> spot_edge{};
  std::span<const float> inner_angle{};
  std::span<const float> outer_angle{};
  std::span<const int> pass_index{};  // the pass that shows the lamp alone, -1 = none
  std::span<const int> shader{};      // whose emission is a factor of `strength`, -1 = none
  // Empty where no lamp is an area light, whose width is `size`.
  std::span<const float> size_y{};
  std::span<const float> spread{};  // radians, of the whole cone
  std::span<const uint> ellipse{};
};

// Which of the lights and instances light which instances, and are shadowed by which; empty where nothing is linked.
struct LinkingInput {
  std::span<const uint> receiver, blocker;  // [instances] sets
  std::span<const uvec2> light_sets;        // [lights + instances]
  std::span<const uint> shadow_sets;        // [lights + instances]
};

struct SceneInput {
  LinkingInput linking;
  std::vector<MeshInput> meshes;
  InstancesInput instances;
  MaterialsInput materials;
  std::span<const uint> material_slots;
  LightsInput lights;
  ProgramsInput programs;
  vec3 world{0.0f, 0.0f, 0.0f};
  int world_shader = -1;  // whose emission is a factor of `world`, -1 = none
  uint world_visibility = VISIBLE_ALL;
  int world_group = -1;
  int world_resolution = 0;  // cells around of the table that samples it; 0: as its images, -1: no table
  WorldSun world_sun;
  uint world_max_bounces = 1024;  // last bounce that it lights
  uint light_group_count = 0;
};

struct SceneStats {
  double build_seconds = 0.0;
  std::uint64_t triangles = 0;         // stored
  std::uint64_t instanced_triangles = 0;  // as seen, instances counted
  std::uint64_t bvh_bytes = 0;
  std::uint64_t coplanar_meshes = 0;  // those with triangles in one plane with others; opaque ones: that face one way
  std::uint64_t images = 0;
  std::uint64_t image_bytes = 0;  // of pixels
  std::uint64_t light_bytes = 0;  // of lamps, emitting triangles and the tree over them
  double light_tree_seconds = 0.0;
  bool world_taken_over = false;  // how it is sampled, from the previous scene
  std::uint64_t bytes = 0;  // everything the scene holds, the BVH and images included
};

// Whether a material emits and is sampled as a light, by its emission.
void set_emission_flags(Material &material, uint sampled);

// Entries of the arrays that a mesh refers to; 0 for those that it does not have.
struct MeshLengths {
  std::size_t positions = 0, triangles = 0, corners = 0, normals = 0, uv = 0, slots = 0;
};

// Radiometry and geometry of one lamp from Blender's units (see blender-facts in the project's notes, measured on
// Cycles).
Light light_from_blender(const LightsInput &lights, std::size_t index);
// Axes, widths and spread of an area light, and the area that it has; takes its circle for `radius`.
double shape_area_light(const LightsInput &lights, std::size_t index, Light &light);
// How the lamp falls off and ends; marks `light` with LIGHT_SHAPED where that is not Blender's way.
LightShape shape_light(const LightsInput &lights, std::size_t index, Light &light);
// Packs the pass that shows the lamp alone into the lamp's group.
void set_lamp_pass(int pass, Light &light);
void validate_light_shapes(const LightsInput &lights);
void validate_area_lights(const LightsInput &lights);
void validate_linking(const LinkingInput &linking, std::size_t lights, std::size_t instances);

// Which memory the arrays of a mesh are: equal only for the same arrays, as long as their owner lives.
using MeshIdentity = std::array<std::pair<const void *, std::size_t>, 9>;
MeshIdentity identity_of(const MeshInput &mesh);

// What a scene holds of a mesh; scenes that know each other share it.
struct MeshStorage {
  std::string name;
  std::vector<vec3> positions;  // where the mesh was moved to world space, or came without padding
  std::vector<vec3> normals;  // where the mesh was moved to world space
  std::shared_ptr<void> owner;  // of the exporter's arrays
  MeshIdentity identity{};
  MeshLengths lengths;
  bool moved = false;  // to world space
};

struct EmbreeDevice;  // scene_bvh.h
struct MeshBvh;
class Scene;

// How a scene goes with others.
struct SceneUse {
  // It is one of many, each a little changed: a mesh keeps a BVH of its own, in its own space, for the next to take
  // over.
  bool editable = false;
  // An editable one from before: meshes whose arrays are the same memory are known to be right, and so on.
  std::shared_ptr<const Scene> previous;
};

class Scene {
 public:
  // Validates (std::invalid_argument naming array, index and value) and derives records.
  explicit Scene(SceneInput input, const SceneUse &use = {});
  ~Scene();
  Scene(const Scene &) = delete;
  Scene &operator=(const Scene &) = delete;

  const SceneData &data() const { return data_; }
  const SceneStats &stats() const { return stats_; }

  // Embree's BVH, without which the CPU cannot render the scene; graphics cards have another. Built on `threads`
  // threads (0 = all); `cancel`, polled meanwhile, makes it throw Cancelled. Not while a session is at work. Of a
  // previous editable scene, the BVHs of meshes that both have are taken over.
  void build_bvh(std::shared_ptr<const embree::Library> library, int threads, const std::atomic<bool> &cancel,
                 const Scene *previous = nullptr);
  const embree::Api &api() const;
  embree::Scene bvh() const { return bvh_; }
  bool instanced() const { return instanced_; }
  // Features (FEATURE_* of scene_types.h) that the scene itself asks for.
  uint features() const { return features_; }
  // Is a lamp with a size visible to camera rays; can bounces meet one?
  bool camera_meets_lights() const { return camera_meets_lights_; }
  bool bounces_meet_lights() const { return bounces_meet_lights_; }
  // Do some rays start at the very point of a surface, so as to meet what lies in one plane with it?
  bool starts_at_point() const { return starts_at_point_; }
  // Does a material in use give a colour to what it lets through?
  bool tints() const { return tints_; }
  uint light_group_count() const { return light_group_count_; }
  std::size_t mesh_count() const { return meshes_.size(); }

  // What data() refers to, for those who copy it.
  std::span<const Mesh> meshes() const { return meshes_; }
  std::span<const Instance> instances() const { return instances_; }
  std::span<const uint> material_slots() const { return material_slots_; }
  MeshLengths mesh_lengths(std::size_t mesh) const { return storage_[mesh]->lengths; }
  bool flattened(std::size_t mesh) const { return flattened_[mesh]; }
  const Textures &textures() const { return textures_; }
  const ProgramLibrary &programs() const { return library_of_programs_; }
  std::span<const MaterialProgram> material_programs() const { return material_programs_; }
  // What the programs of the scene need, by the parts of materials.
  const ProgramNeeds &surface_needs() const { return surface_needs_; }
  const ProgramNeeds &emission_needs() const { return emission_needs_; }
  const ProgramNeeds &transparency_needs() const { return transparency_needs_; }
  // What shader `index` became. Throws std::out_of_range.
  const CompiledShader &shader(std::size_t index) const { return compiled_.at(index); }
  // What a material is made of, where that is constant. Throws std::out_of_range.
  const CompiledShader &compiled(std::size_t material) const;
  std::span<const float> world_table() const {
    return world_ != nullptr ? std::span<const float>(world_->table.cumulated) : std::span<const float>();
  }
  const LightTree &light_tree() const { return light_tree_; }
  std::span<const LightLink> light_links() const { return light_links_; }
  std::span<const uvec2> light_node_sets() const { return light_node_sets_; }
  std::span<const LightProgram> light_programs() const { return light_programs_; }
  static std::span<const float> albedo();

  // What hits of Embree's are hits of, by geometry of the top-level BVH.
  std::span<const EmbreeGeometry> geometries() const { return geometries_; }

 private:
  void validate(const SceneInput &input) const;
  void validate_mesh(const MeshInput &mesh) const;
  // Which of the input's meshes the previous scene has, by its numbers; -1: none.
  void recognise(const SceneInput &input, const Scene *previous);
  void prepare(SceneInput &input, const Scene *previous);
  void prepare_models(const ModelsInput &input);  // after the materials
  void prepare_classic();
  void prepare_programs(ProgramsInput &input, const MaterialsInput &materials);  // before all that shaders tell
  void validate_shaders(const SceneInput &input) const;
  // The emission of a shader of a lamp or world, 1 for none; notes in `varies` where it is no constant.
  vec3 emission_of(int shader, bool &varies) const;
  void prepare_object_spaces(const SceneInput &input, std::span<const uint> order);
  void prepare_infos(const SceneInput &input, std::span<const uint> order);
  // How bright the materials whose emission varies are on average, where all else of the scene is known.
  void estimate_emission(const MaterialsInput &materials);
  void prepare_mesh_textures(const SceneInput &input);
  void note_frame(std::size_t mesh, const Instance &instance);  // of a mesh that is moved to world space
  void prepare_lights(const LightsInput &input);
  void prepare_links(const LinkingInput &input, std::size_t lights);  // after lamps and instances
  void gather_node_sets();  // after the light tree
  void prepare_world(const SceneInput &input, const Scene *previous);  // after the programs and images
  // Of a world that varies, to the kinds of rays in `lit`.
  std::shared_ptr<const SampledWorld> sampled_world(const SceneInput &input, uint lit, const Scene *previous) const;
  LightProgram program_light(const LightsInput &input, std::size_t index, Light &light) const;
  // How bright lamps are whose emission varies, where all else of the scene is known.
  void estimate_lights();
  void prepare_instances(const SceneInput &input);
  bool belongs_to_top(uint users, const Instance &instance) const;
  void prepare_meshes(SceneInput &input, const Scene *previous);
  void prepare_mesh(std::size_t k, MeshInput &source, Instance *instance, const Scene *previous);
  void prepare_emitters();
  bool emits(const Instance &instance) const;
  void prepare_light_tree();  // after the lamps and emitters, and how bright they are
  void place_emitters();
  void prepare_features();
  void find_coplanar();  // after the features
  void build(const std::atomic<bool> &cancel, const Scene *previous);
  std::shared_ptr<const std::vector<Quad>> quads_of(std::size_t mesh) const;
  std::shared_ptr<const MeshBvh> taken_over(std::size_t mesh, bool lets_through, bool compact,
                                            const Scene *previous) const;
  void open_device(std::shared_ptr<const embree::Library> library, int threads, const Scene *previous);
  std::uint64_t bvh_bytes_needed() const;
  void check_embree(const std::string &doing) const;
  void release();

  std::shared_ptr<EmbreeDevice> embree_;
  embree::Scene bvh_ = nullptr;
  std::vector<std::shared_ptr<const MeshBvh>> mesh_bvhs_;  // by mesh; null for those in the top level
  bool editable_ = false;
  std::vector<int> known_;  // by mesh: its number in the previous scene, -1; while the scene is made
  std::vector<std::shared_ptr<MeshStorage>> storage_;
  std::vector<bool> flattened_;  // by mesh: in world space, part of the top-level BVH
  std::vector<Mesh> meshes_;
  std::vector<bool> coplanar_;  // by mesh: it may have triangles in one plane with others; empty: nobody asks
  std::vector<Instance> instances_;  // grouped by mesh and visibility, so that each group is one instance array
  std::vector<std::shared_ptr<const std::vector<Quad>>> quads_;  // by mesh, those of the BVH
  std::vector<EmbreeGeometry> geometries_;
  std::vector<Material> materials_;
  std::vector<MaterialModel> models_;
  std::vector<ClassicMaterial> classic_;
  Textures textures_;
  ProgramLibrary library_of_programs_;
  std::vector<CompiledShader> compiled_;  // by shader
  std::vector<MaterialProgram> material_programs_;  // by material; empty where none varies
  ProgramNeeds surface_needs_, emission_needs_, transparency_needs_;
  std::vector<int> material_shaders_;  // by material, -1: the default grey
  bool asks_spaces_ = false, asks_meshes_ = false;
  std::vector<uint> material_slots_;
  std::vector<Light> lights_;
  std::vector<LightShape> light_shapes_;  // empty where no lamp is LIGHT_SHAPED
  std::vector<LightProgram> light_programs_;  // empty where no lamp is a LIGHT_PROGRAM
  std::vector<Emitter> emitters_;
  LightTree light_tree_;
  std::vector<LightLink> light_links_;  // of lamps, then of instances; empty where nothing is linked
  std::vector<uvec2> light_node_sets_;
  std::vector<uint> instance_order_;  // place of each instance in the exporter's list
  std::shared_ptr<const SampledWorld> world_;  // null where it does not vary
  SceneData data_{};
  SceneStats stats_;
  uint features_ = 0;
  uint light_group_count_ = 0;
  bool instanced_ = false;
  bool tints_ = false;
  bool camera_meets_lights_ = false;
  bool bounces_meet_lights_ = false;
  bool lets_light_through_ = false;  // a lobe of some material sends it through the surface
  bool starts_at_point_ = false;
};

}  // namespace cotorra
