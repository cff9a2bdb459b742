// SPDX-License-Identifier: GPL-3.0-or-later
// Validates a scene's arrays and derives the records that kernels read.
// The BVH over them is built in scene_bvh.cpp.
#include "scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "albedo_tables.h"
#include "coplanar.h"
#include "memory.h"

namespace cotorra {
namespace {

template <class T>
void require_size(std::span<const T> array, std::size_t size, const char *name) {
  if (array.size() != size) {
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(array.size()) + " entries, expected " +
                                std::to_string(size));
  }
}

void require_below(std::span<const uint> array, std::size_t limit, const std::string &name) {
  // One pass for the maximum, which vectorises; the culprit is looked for only if there is one.
  uint largest = 0;
  for (const uint value : array) largest = std::max(largest, value);
  if (array.empty() || largest < limit) return;
  const auto it = std::find_if(array.begin(), array.end(), [limit](uint v) { return v >= limit; });
  throw std::invalid_argument(name + "[" + std::to_string(it - array.begin()) + "] = " + std::to_string(*it) +
                              ", must be below " + std::to_string(limit));
}

std::span<const uint> flat(std::span<const uvec3> array) {
  return {reinterpret_cast<const uint *>(array.data()), array.size() * 3};
}

struct Matrix3 {
  vec3 x, y, z;  // columns
};

Matrix3 columns_of_rows(const float *m) { return {{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}; }

// Columns of the inverse transpose, up to a positive factor: the cofactors, with the sign of the determinant. They
// exist for singular matrices too, where an inverse does not.
Matrix3 normal_matrix(const Matrix3 &m) {
  Matrix3 c{cross(m.y, m.z), cross(m.z, m.x), cross(m.x, m.y)};
  const float largest = std::max({std::abs(c.x.x), std::abs(c.x.y), std::abs(c.x.z), std::abs(c.y.x), std::abs(c.y.y),
                                  std::abs(c.y.z), std::abs(c.z.x), std::abs(c.z.y), std::abs(c.z.z), 1e-37f});
  const float scale = (dot(m.x, c.x) < 0.0f ? -1.0f : 1.0f) / largest;
  return {c.x * scale, c.y * scale, c.z * scale};
}

bool is_identity(const float *m) {
  constexpr float kIdentity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  return std::equal(m, m + 12, kIdentity);
}

constexpr uint kScattered = VISIBLE_DIFFUSE | VISIBLE_GLOSSY;

// Is a light of this visibility hidden from diffuse or from glossy rays, and not from both?
bool seen_by_one_kind(uint visibility) {
  return (visibility & kScattered) == VISIBLE_DIFFUSE || (visibility & kScattered) == VISIBLE_GLOSSY;
}

}  // namespace

Light light_from_blender(const LightsInput &in, std::size_t i) {
  constexpr float pi = std::numbers::pi_v<float>;
  const float *m = in.transform.data() + 12 * i;
  const Matrix3 frame = columns_of_rows(m);
  // Rows of the inverse, up to a factor that a direction's length takes out again.
  const Matrix3 local = normal_matrix(frame);
  Light light{};
  light.type = in.type[i];
  light.position = {m[3], m[7], m[11]};
  const float z_length = length(frame.z);
  light.axis = z_length > 0.0f ? frame.z * (-1.0f / z_length) : vec3(0.0f, 0.0f, -1.0f);
  light.local_x = local.x;
  light.local_y = local.y;
  light.local_z = local.z;
  light.flags = (in.soft_falloff[i] != 0 ? LIGHT_SOFT_FALLOFF : 0u) | (in.cast_shadow[i] != 0 ? LIGHT_CAST_SHADOW : 0u);
  light.visibility = in.visibility[i];
  light.group = in.light_group[i];
  light.max_bounces = in.max_bounces[i];
  light.name_index = static_cast<uint>(i);

  const bool normalize = in.normalize[i] != 0;
  const float size = std::max(in.size[i], 0.0f);
  float scale;
  if (light.type == LIGHT_SUN) {
    const double half = 0.5 * std::min(static_cast<double>(size), std::numbers::pi);
    light.radius = static_cast<float>(2.0 * std::pow(std::sin(0.5 * half), 2.0));  // 1 - cos(angle / 2)
    light.cos_sun = static_cast<float>(std::cos(half));
    const float sin_half = static_cast<float>(std::sin(half));
    scale = size > 0.0f && normalize ? 1.0f / (pi * sin_half * sin_half) : 1.0f;
  } else if (light.type == LIGHT_AREA) {
    const double area = shape_area_light(in, i, light);
    scale = static_cast<float>(1.0 / (std::numbers::pi * (normalize ? area : 1.0)));
  } else {
    light.radius = size;
    scale = normalize ? 1.0f / (size > 0.0f ? 4.0f * pi * pi * size * size : 4.0f * pi) : 1.0f / pi;
    const double half_cone = 0.5 * static_cast<double>(in.spot_size[i]);
    const double versine = 2.0 * std::pow(std::sin(0.5 * half_cone), 2.0);
    light.spot_versine = static_cast<float>(versine);
    const double ramp = versine * static_cast<double>(in.spot_blend[i]);
    light.spot_scale = static_cast<float>(1.0 / std::max(ramp, 1e-9));  // no blend: a step, not a division by zero
  }
  light.radiance = in.strength[i] * scale;
  // A sun that bounces do not meet is not seen by the camera either, nor is a beam.
  const bool beam = light.type == LIGHT_AREA && light.tan_spread <= 0.0f;
  if (light.radius > 0.0f && !beam) {
    if (in.use_mis[i] != 0) light.flags |= LIGHT_VISIBLE;
    if (in.use_mis[i] != 0 || light.type != LIGHT_SUN) light.flags |= LIGHT_SEEN;
  }
  return light;
}

Scene::Scene(SceneInput input, const SceneUse &use) : editable_(use.editable) {
  recognise(input, use.previous.get());
  validate(input);
  const std::uint64_t instances = input.instances.mesh.size();
  with_memory(instances * (sizeof(Instance) + sizeof(ObjectSpace)) + input.materials.shader.size() * sizeof(Material),
              std::to_string(instances) + " instances and the scene's materials",
              [&] { prepare(input, use.previous.get()); });
}

void Scene::prepare(SceneInput &input, const Scene *previous) {
  light_group_count_ = input.light_group_count;
  prepare_programs(input.programs, input.materials);
  prepare_models(input.materials.models);
  prepare_classic();
  material_slots_.assign(input.material_slots.begin(), input.material_slots.end());
  prepare_lights(input.lights);
  prepare_instances(input);
  prepare_mesh_textures(input);
  prepare_meshes(input, previous);

  data_.lights = {lights_.data()};
  data_.light_shapes = {light_shapes_.data()};
  data_.light_programs = {light_programs_.data()};
  data_.materials = {materials_.data()};
  data_.material_slots = {material_slots_.data()};
  data_.meshes = {meshes_.data()};
  data_.instances = {instances_.data()};
  data_.albedo = {albedo_tables};
  data_.light_count = static_cast<uint>(lights_.size());
  data_.instance_count = static_cast<uint>(instances_.size());
  data_.material_count = static_cast<uint>(materials_.size());
  estimate_emission(input.materials);
  prepare_world(input, previous);
  estimate_lights();
  prepare_links(input.linking, input.lights.type.size());
  prepare_emitters();
  prepare_light_tree();
  gather_node_sets();
  prepare_features();
  find_coplanar();
  stats_.bytes = instances_.size() * sizeof(Instance) + materials_.size() * sizeof(Material) +
                 models_.size() * sizeof(MaterialModel) + classic_.size() * sizeof(ClassicMaterial) +
                 emitters_.size() * sizeof(Emitter) + light_tree_.bytes() + material_slots_.size() * sizeof(uint) +
                 textures_.bytes() + world_table().size() * sizeof(float);
  stats_.light_bytes = lights_.size() * sizeof(Light) + emitters_.size() * sizeof(Emitter) + light_tree_.bytes();
  stats_.images = textures_.images.size();
  stats_.image_bytes = textures_.image_bytes;
  for (const auto &s : storage_) stats_.bytes += (s->positions.size() + s->normals.size()) * sizeof(vec3);
}

Scene::~Scene() { release(); }

std::span<const float> Scene::albedo() { return albedo_tables; }

void Scene::validate(const SceneInput &in) const {
  const std::size_t n = in.instances.mesh.size();
  require_size(in.instances.transform, n * 12, "instances.transform");
  require_size(in.instances.material_base, n, "instances.material_base");
  require_size(in.instances.material_count, n, "instances.material_count");
  require_size(in.instances.pass_index, n, "instances.pass_index");
  require_size(in.instances.visibility, n, "instances.visibility");
  require_size(in.instances.light_group, n, "instances.light_group");
  require_size(in.instances.terminator, n, "instances.terminator");
  require_below(in.instances.mesh, in.meshes.size(), "instances.mesh");
  const std::size_t materials = in.materials.pass_index.size();
  require_size(in.materials.emission_sampling, materials, "materials.emission_sampling");
  require_size(in.materials.shader, materials, "materials.shader");
  require_below(in.material_slots, materials, "material_slots");
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t base = in.instances.material_base[i];
    const std::size_t count = in.instances.material_count[i];
    if (count == 0 || base + count > in.material_slots.size()) {
      throw std::invalid_argument("instances.material_base[" + std::to_string(i) + "] = " + std::to_string(base) +
                                  " with " + std::to_string(count) + " slots does not fit material_slots, which has " +
                                  std::to_string(in.material_slots.size()) + " entries");
    }
  }
  if (n > 0x7fffffffu) throw std::invalid_argument("too many instances: " + std::to_string(n));
  for (std::size_t i = 0; i < in.meshes.size(); ++i) {
    if (known_[i] < 0) validate_mesh(in.meshes[i]);
  }
  const std::size_t lights = in.lights.type.size();
  require_below(in.lights.type, 4, "lights.type");
  require_size(in.lights.strength, lights, "lights.strength");
  require_size(in.lights.transform, lights * 12, "lights.transform");
  require_size(in.lights.size, lights, "lights.size");
  require_size(in.lights.spot_size, lights, "lights.spot_size");
  require_size(in.lights.spot_blend, lights, "lights.spot_blend");
  require_size(in.lights.soft_falloff, lights, "lights.soft_falloff");
  require_size(in.lights.normalize, lights, "lights.normalize");
  require_size(in.lights.cast_shadow, lights, "lights.cast_shadow");
  require_size(in.lights.use_mis, lights, "lights.use_mis");
  require_size(in.lights.max_bounces, lights, "lights.max_bounces");
  require_size(in.lights.visibility, lights, "lights.visibility");
  require_size(in.lights.light_group, lights, "lights.light_group");
  if (!in.lights.shader.empty()) require_size(in.lights.shader, lights, "lights.shader");
  validate_light_shapes(in.lights);
  validate_area_lights(in.lights);
  validate_linking(in.linking, lights, n);
  validate_shaders(in);
}

void Scene::validate_mesh(const MeshInput &m) const {
  const std::string name = "mesh '" + m.name + "': ";
  require_below(flat(m.triangles), m.positions.size(), name + "triangles");
  if (!m.corners.empty() || !m.uv.empty() || m.corner_normals) {
    require_size(m.corners, m.triangles.size(), (name + "corners").c_str());
  }
  if (m.corner_normals) require_below(flat(m.corners), m.normals.size(), name + "corners (of normals)");
  if (!m.corner_normals && !m.normals.empty()) {
    require_size(m.normals, m.positions.size(), (name + "normals").c_str());
  }
  if (!m.uv.empty()) require_below(flat(m.corners), m.uv.size(), name + "corners (of uv)");
  if (!m.slots.empty()) require_size(m.slots, m.triangles.size(), (name + "slots").c_str());
}

void Scene::prepare_lights(const LightsInput &in) {
  bool any = false;
  bool programs = false;
  for (std::size_t i = 0; i < in.type.size(); ++i) {
    bool varies = false;
    vec3 emission = in.shader.empty() ? vec3(1.0f) : emission_of(in.shader[i], varies);
    if (varies) emission = vec3(1.0f);
    if (emission.x == 0.0f && emission.y == 0.0f && emission.z == 0.0f) continue;  // its shader turns it off
    Light light = light_from_blender(in, i);
    light.radiance *= emission;
    if (!in.pass_index.empty()) set_lamp_pass(in.pass_index[i], light);
    if (!in.falloff.empty()) {
      light_shapes_.push_back(shape_light(in, i, light));
      any |= (light.flags & LIGHT_SHAPED) != 0;
    }
    light_programs_.push_back(varies ? program_light(in, i, light) : LightProgram{});
    programs |= varies;
    lights_.push_back(light);
  }
  if (programs) features_ |= FEATURE_PROGRAMS;
  if (!programs) light_programs_.clear();
  if (!in.pass_index.empty()) features_ |= FEATURE_TERMS;
  if (!any) light_shapes_.clear();
}

void Scene::prepare_instances(const SceneInput &in) {
  const InstancesInput &source = in.instances;
  const std::size_t n = source.mesh.size();
  // Instances of one mesh and visibility stand together, so that they make one instance array of Embree's.
  std::vector<uint> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint a, uint b) {
    if (source.mesh[a] != source.mesh[b]) return source.mesh[a] < source.mesh[b];
    if (source.visibility[a] != source.visibility[b]) return source.visibility[a] < source.visibility[b];
    return !in.linking.blocker.empty() && in.linking.blocker[a] < in.linking.blocker[b];
  });
  prepare_object_spaces(in, order);
  prepare_infos(in, order);
  if (!in.linking.blocker.empty()) instance_order_ = order;
  instances_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = order[k];
    const float *m = source.transform.data() + 12 * i;
    const Matrix3 frame = columns_of_rows(m);
    const Matrix3 normal = normal_matrix(frame);
    Instance &instance = instances_[k];
    instance.x_axis = frame.x;
    instance.y_axis = frame.y;
    instance.z_axis = frame.z;
    instance.origin = {m[3], m[7], m[11]};
    instance.normal_x = normal.x;
    instance.normal_y = normal.y;
    instance.normal_z = normal.z;
    instance.mesh = source.mesh[i];
    instance.material_base = source.material_base[i];
    instance.material_count = source.material_count[i];
    instance.pass_index = source.pass_index[i];
    instance.visibility = source.visibility[i] & VISIBLE_ANYHOW;
    if (!in.linking.blocker.empty() && (instance.visibility & VISIBLE_SHADOW) != 0) {
      instance.visibility |= 1u << (SHADOW_SET_SHIFT + in.linking.blocker[i]);
    }
    instance.light_group = source.light_group[i];
    const float terminator = clamp(source.terminator[i], 0.0f, 1.0f);
    instance.flags = static_cast<uint>(std::lround(terminator * 65535.0f)) << INSTANCE_TERMINATOR_SHIFT;
    if (is_identity(m)) instance.flags |= INSTANCE_IDENTITY;
    if (dot(frame.x, cross(frame.y, frame.z)) < 0.0f) instance.flags |= INSTANCE_MIRRORED;
  }
}

// Only there rays must meet what lies in the plane that they leave, and be kept from their own triangle. In an editable
// scene, where the next edit may bring a plane, that is everywhere; opaque ones that coincide are not looked for there.
void Scene::find_coplanar() {
  if (lets_light_through_) {
    coplanar_ = editable_ ? std::vector<bool>(meshes_.size(), true) : coplanar_meshes(meshes_, instances_);
  } else if (!editable_) {
    coplanar_ = coinciding_meshes(meshes_, instances_);
  }
  stats_.coplanar_meshes = static_cast<std::uint64_t>(std::count(coplanar_.begin(), coplanar_.end(), true));
  if (stats_.coplanar_meshes == 0) return;
  starts_at_point_ = true;
  if (!lets_light_through_) features_ |= FEATURE_TRANSPARENCY;
  for (Instance &i : instances_) {
    if (coplanar_[i.mesh]) i.flags |= INSTANCE_COPLANAR;
  }
}

void Scene::prepare_features() {
  bool soft = false;
  bool area = false;
  bool one_kind = false;
  for (const Light &light : lights_) {
    soft |= light.radius > 0.0f;
    area |= light.type == LIGHT_AREA;
    camera_meets_lights_ |= (light.flags & LIGHT_SEEN) != 0 && (light.visibility & VISIBLE_CAMERA) != 0;
    bounces_meet_lights_ |=
        (light.flags & LIGHT_VISIBLE) != 0 && (light.visibility & (kScattered | VISIBLE_TRANSMISSION)) != 0;
    one_kind |= (light.flags & LIGHT_VISIBLE) != 0 && seen_by_one_kind(light.visibility);
  }
  // From near by, an area light looks wider than any highlight.
  data_.sharp_roughness = area ? 1e30f : kSharpRoughness;
  bool specular = false;
  bool sharp = false;
  bool emissive = false;
  bool models = false;
  bool lobes = false;
  std::vector<bool> used(materials_.size(), false);
  for (const Instance &i : instances_) {
    for (uint s = 0; s < i.material_count; ++s) {
      const uint material = material_slots_[i.material_base + s];
      used[material] = true;
      one_kind |= (materials_[material].flags & MATERIAL_EMISSIVE) != 0 && seen_by_one_kind(i.visibility);
    }
  }
  for (std::size_t k = 0; k < materials_.size(); ++k) {
    if (!used[k]) continue;
    Material &m = materials_[k];
    if (area && (m.flags & MATERIAL_SPECULAR) != 0) m.flags |= MATERIAL_SHARP;
    specular |= (m.flags & MATERIAL_SPECULAR) != 0;
    sharp |= (m.flags & MATERIAL_SHARP) != 0;
    emissive |= (m.flags & MATERIAL_EMISSIVE) != 0;
    if ((m.flags & MATERIAL_PROGRAM) != 0) features_ |= FEATURE_PROGRAMS;
    if ((m.flags & MATERIAL_TRANSPARENT) != 0) features_ |= FEATURE_TRANSPARENCY;
    lets_light_through_ |= (m.flags & MATERIAL_TRANSPARENT) != 0;
    tints_ |= (m.flags & MATERIAL_TINTED) != 0;
    models |= (m.flags & MATERIAL_MODEL) != 0;
    const int shader = material_shaders_.empty() ? -1 : material_shaders_[k];
    if (shader < 0) continue;
    lobes |= compiled_[static_cast<std::size_t>(shader)].asks_lobes;
    lets_light_through_ |= compiled_[static_cast<std::size_t>(shader)].transmits;
  }
  const vec3 w = data_.world;
  const bool world = w.x != 0.0f || w.y != 0.0f || w.z != 0.0f || data_.world_program.end != 0;
  if (soft) features_ |= FEATURE_SOFT_LIGHTS;
  if (area) features_ |= FEATURE_AREA_LIGHTS;
  if (!light_shapes_.empty()) features_ |= FEATURE_LIGHT_SHAPES;
  if (models) features_ |= FEATURE_MODELS;
  if (specular || models || lobes) features_ |= FEATURE_SPECULAR;
  if (lobes) features_ |= FEATURE_LOBES;
  // Gloss and glass meet lamps themselves.
  sharp |= lobes;
  if (emissive) features_ |= FEATURE_EMISSIVE_MESHES;
  if (world) features_ |= FEATURE_WORLD;
  const bool world_lights = world && (data_.world_visibility & kScattered) != 0;
  one_kind |= world && seen_by_one_kind(data_.world_sampled);
  data_.light_kinds = one_kind ? 1u : 0u;
  if (emissive || world_lights || (lobes && world) || (sharp && bounces_meet_lights_)) features_ |= FEATURE_BSDF_RAYS;
  const bool met = camera_meets_lights_ || ((features_ & FEATURE_BSDF_RAYS) != 0 && bounces_meet_lights_);
  if (met) features_ |= FEATURE_VISIBLE_LIGHTS;
}

}  // namespace cotorra
