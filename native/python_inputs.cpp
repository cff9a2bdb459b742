// SPDX-License-Identifier: GPL-3.0-or-later
// Reads scenes, cameras and settings by the names of their members. Nothing is checked but types and shapes.
#include "python_inputs.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>

#include "python_arrays.h"
#include "python_models.h"
#include "python_programs.h"

namespace cotorra {
namespace {

// Owns Python objects from C++ threads: gives them back under the GIL.
std::shared_ptr<void> python_owner(std::vector<nb::object> objects) {
  return {new std::vector<nb::object>(std::move(objects)), [](void *pointer) {
            const nb::gil_scoped_acquire gil;
            delete static_cast<std::vector<nb::object> *>(pointer);
          }};
}

// Does the buffer go on for another 4 bytes after the last vertex? (Embree reads 16 bytes at each vertex of 12.)
bool is_padded(nb::handle positions) {
  nb::object base = nb::getattr(positions, "base", nb::none());
  if (base.is_none() || !nb::hasattr(base, "nbytes") || !nb::hasattr(base, "ctypes")) return false;
  const auto begin = nb::cast<std::uintptr_t>(nb::getattr(nb::getattr(base, "ctypes"), "data"));
  const auto bytes = nb::cast<std::size_t>(nb::getattr(base, "nbytes"));
  const auto first = nb::cast<std::uintptr_t>(nb::getattr(nb::getattr(positions, "ctypes"), "data"));
  const auto used = nb::cast<std::size_t>(nb::getattr(positions, "nbytes"));
  return begin + bytes >= first + used + 4;
}

MeshInput read_mesh(nb::handle mesh) {
  std::vector<nb::object> keep;
  MeshInput m;
  m.name = nb::cast<std::string>(nb::getattr(mesh, "name"));
  try {
    m.positions = view<vec3, float>(mesh, "positions", keep);
    m.positions_padded = is_padded(nb::getattr(mesh, "positions"));
    m.triangles = view<uvec3, std::uint32_t>(mesh, "triangles", keep);
    m.corners = view<uvec3, std::uint32_t>(mesh, "corners", keep);
    m.normals = view<vec3, float>(mesh, "normals", keep);
    m.corner_normals = nb::cast<std::string>(nb::getattr(mesh, "normals_domain")) == "CORNER";
    m.uv = view<vec2, float>(mesh, "uv", keep);
    m.slots = view<uint, std::uint32_t>(mesh, "slots", keep);
    m.tangents = view<vec4, float>(mesh, "tangents", keep);
    m.generated = view<vec3, float>(mesh, "generated", keep);
    m.attributes = read_attributes(mesh, keep);
  } catch (const std::invalid_argument &error) {
    throw std::invalid_argument("mesh '" + m.name + "': " + error.what());
  }
  m.owner = python_owner(std::move(keep));
  return m;
}

std::array<float, 12> read_matrix(nb::handle object, const char *name) {
  std::vector<nb::object> keep;
  const std::span<const float> m = view<float, float>(object, name, keep);
  if (m.size() != 12) throw std::invalid_argument(std::string(name) + " must be a 3 x 4 matrix");
  std::array<float, 12> out;
  std::copy(m.begin(), m.end(), out.begin());
  return out;
}

}  // namespace

SceneInput read_scene(nb::handle buffers, std::vector<nb::object> &keep) {
  SceneInput in;
  for (nb::handle mesh : nb::getattr(buffers, "meshes")) in.meshes.push_back(read_mesh(mesh));

  in.programs = read_programs(buffers, python_owner, keep);
  const nb::object instances = nb::getattr(buffers, "instances");
  in.instances.mesh = view<uint, std::uint32_t>(instances, "mesh", keep);
  in.instances.transform = view<float, float>(instances, "transform", keep);
  in.instances.material_base = view<uint, std::uint32_t>(instances, "material_base", keep);
  in.instances.material_count = view<uint, std::uint32_t>(instances, "material_count", keep);
  in.instances.pass_index = view<int, std::int32_t>(instances, "pass_index", keep);
  in.instances.visibility = view<uint, std::uint32_t>(instances, "visibility", keep);
  in.instances.light_group = view<int, std::int32_t>(instances, "light_group", keep);
  in.instances.terminator = view<float, float>(instances, "terminator", keep);

  in.materials = read_materials(nb::getattr(buffers, "materials"), keep);
  in.material_slots = view<uint, std::uint32_t>(buffers, "material_slots", keep);

  const nb::object lights = nb::getattr(buffers, "lights");
  in.lights.type = view<uint, std::uint32_t>(lights, "type", keep);
  in.lights.strength = view<vec3, float>(lights, "strength", keep);
  in.lights.transform = view<float, float>(lights, "transform", keep);
  in.lights.size = view<float, float>(lights, "size", keep);
  in.lights.spot_size = view<float, float>(lights, "spot_size", keep);
  in.lights.spot_blend = view<float, float>(lights, "spot_blend", keep);
  in.lights.soft_falloff = view<uint, std::uint32_t>(lights, "soft_falloff", keep);
  in.lights.normalize = view<uint, std::uint32_t>(lights, "normalize", keep);
  in.lights.cast_shadow = view<uint, std::uint32_t>(lights, "cast_shadow", keep);
  in.lights.use_mis = view<uint, std::uint32_t>(lights, "use_mis", keep);
  in.lights.max_bounces = view<uint, std::uint32_t>(lights, "max_bounces", keep);
  in.lights.visibility = view<uint, std::uint32_t>(lights, "visibility", keep);
  in.lights.light_group = view<int, std::int32_t>(lights, "light_group", keep);
  in.lights.falloff = view<uint, std::uint32_t>(lights, "falloff", keep);
  in.lights.range = view<float, float>(lights, "range", keep);
  in.lights.polynomial = view<vec3, float>(lights, "polynomial", keep);
  in.lights.spot_edge = view<uint, std::uint32_t>(lights, "spot_edge", keep);
  in.lights.inner_angle = view<float, float>(lights, "inner_angle", keep);
  in.lights.outer_angle = view<float, float>(lights, "outer_angle", keep);
  in.lights.pass_index = view<int, std::int32_t>(lights, "pass_index", keep);
  in.lights.shader = view<int, std::int32_t>(lights, "shader", keep);
  in.lights.size_y = view<float, float>(lights, "size_y", keep);
  in.lights.spread = view<float, float>(lights, "spread", keep);
  in.lights.ellipse = view<uint, std::uint32_t>(lights, "ellipse", keep);

  const nb::object linking = nb::getattr(buffers, "linking");
  if (!linking.is_none()) {
    in.linking.receiver = view<uint, std::uint32_t>(linking, "receiver", keep);
    in.linking.blocker = view<uint, std::uint32_t>(linking, "blocker", keep);
    in.linking.light_sets = view<uvec2, std::uint32_t>(linking, "light_sets", keep);
    in.linking.shadow_sets = view<uint, std::uint32_t>(linking, "shadow_sets", keep);
  }

  const nb::object world = nb::getattr(buffers, "world");
  const auto color = nb::cast<std::array<float, 3>>(nb::getattr(world, "color"));
  in.world = {color[0], color[1], color[2]};
  in.world_shader = nb::cast<int>(nb::getattr(world, "shader"));
  in.world_visibility = nb::cast<std::uint32_t>(nb::getattr(world, "visibility"));
  in.world_group = nb::cast<int>(nb::getattr(world, "light_group"));
  in.world_resolution = nb::cast<int>(nb::getattr(world, "resolution"));
  const auto sun = nb::cast<std::array<float, 4>>(nb::getattr(world, "sun"));
  in.world_sun.direction = {sun[0], sun[1], sun[2]};
  in.world_sun.cap = static_cast<float>(2.0 * std::pow(std::sin(0.25 * static_cast<double>(sun[3])), 2.0));
  in.world_max_bounces = nb::cast<std::uint32_t>(nb::getattr(world, "max_bounces"));
  in.light_group_count = static_cast<uint>(nb::len(nb::getattr(buffers, "light_groups")));
  return in;
}

CameraInput read_camera(nb::handle camera) {
  CameraInput in;
  const auto kind = nb::cast<std::string>(nb::getattr(camera, "kind"));
  if (kind != "PERSP" && kind != "ORTHO")
    throw std::invalid_argument("camera.kind = '" + kind + "', must be PERSP or ORTHO");
  in.orthographic = kind == "ORTHO";
  in.transform = read_matrix(camera, "transform");
  in.window = nb::cast<std::array<float, 4>>(nb::getattr(camera, "window"));
  in.clip = nb::cast<std::array<float, 2>>(nb::getattr(camera, "clip"));
  in.resolution = nb::cast<std::array<int, 2>>(nb::getattr(camera, "resolution"));
  in.region = nb::cast<std::array<int, 4>>(nb::getattr(camera, "region"));
  in.filter = nb::cast<std::string>(nb::getattr(camera, "filter"));
  in.filter_width = nb::cast<float>(nb::getattr(camera, "filter_width"));
  return in;
}

SettingsInput read_settings(nb::handle settings) {
  SettingsInput in;
  in.integrator = nb::cast<std::string>(nb::getattr(settings, "integrator"));
  in.samples = nb::cast<std::int64_t>(nb::getattr(settings, "samples"));
  in.seed = static_cast<std::uint32_t>(nb::cast<std::int64_t>(nb::getattr(settings, "seed")));
  in.max_bounces = nb::cast<std::uint32_t>(nb::getattr(settings, "max_bounces"));
  in.diffuse_bounces = nb::cast<std::uint32_t>(nb::getattr(settings, "diffuse_bounces"));
  in.glossy_bounces = nb::cast<std::uint32_t>(nb::getattr(settings, "glossy_bounces"));
  in.transmission_bounces = nb::cast<std::uint32_t>(nb::getattr(settings, "transmission_bounces"));
  in.transparent_bounces = nb::cast<std::uint32_t>(nb::getattr(settings, "transparent_bounces"));
  in.clamp_direct = nb::cast<float>(nb::getattr(settings, "clamp_direct"));
  in.clamp_indirect = nb::cast<float>(nb::getattr(settings, "clamp_indirect"));
  in.filter_glossy = nb::cast<float>(nb::getattr(settings, "filter_glossy"));
  in.light_threshold = nb::cast<float>(nb::getattr(settings, "light_threshold"));
  in.reweighting = nb::cast<float>(nb::getattr(settings, "reweighting"));
  in.white = nb::cast<float>(nb::getattr(settings, "white"));
  in.sharing = nb::cast<bool>(nb::getattr(settings, "sharing"));
  in.reflective_caustics = nb::cast<bool>(nb::getattr(settings, "reflective_caustics"));
  in.refractive_caustics = nb::cast<bool>(nb::getattr(settings, "refractive_caustics"));
  in.adaptive = nb::cast<bool>(nb::getattr(settings, "adaptive"));
  in.noise_threshold = nb::cast<float>(nb::getattr(settings, "noise_threshold"));
  in.adaptive_min_samples = nb::cast<std::uint32_t>(nb::getattr(settings, "adaptive_min_samples"));
  in.spread_after = nb::cast<std::uint32_t>(nb::getattr(settings, "spread_after"));
  in.transparent = nb::cast<bool>(nb::getattr(settings, "transparent_film"));
  in.threads = nb::cast<int>(nb::getattr(settings, "threads"));
  in.measure_tracing = nb::cast<bool>(nb::getattr(settings, "measure_tracing"));
  in.health = nb::cast<bool>(nb::getattr(settings, "health"));
  in.firefly_limit = nb::cast<float>(nb::getattr(settings, "firefly_limit"));
  in.ambient_color = nb::cast<std::array<float, 3>>(nb::getattr(settings, "ambient_color"));
  in.ambient_strength = nb::cast<float>(nb::getattr(settings, "ambient_strength"));
  in.use_ambient_occlusion = nb::cast<bool>(nb::getattr(settings, "use_ambient_occlusion"));
  in.ao_distance = nb::cast<float>(nb::getattr(settings, "ao_distance"));
  in.whitted_depth = nb::cast<std::uint32_t>(nb::getattr(settings, "whitted_depth"));
  in.whitted_threshold = nb::cast<float>(nb::getattr(settings, "whitted_threshold"));
  in.use_transparent_shadows = nb::cast<bool>(nb::getattr(settings, "use_transparent_shadows"));
  in.toon_outline = nb::cast<bool>(nb::getattr(settings, "toon_outline"));
  in.outline_width = nb::cast<float>(nb::getattr(settings, "outline_width"));
  in.outline_color = nb::cast<std::array<float, 3>>(nb::getattr(settings, "outline_color"));
  in.outline_normal = nb::cast<bool>(nb::getattr(settings, "outline_normal"));
  in.outline_depth = nb::cast<bool>(nb::getattr(settings, "outline_depth"));
  in.outline_object = nb::cast<bool>(nb::getattr(settings, "outline_object"));
  in.device.kind = nb::cast<std::string>(nb::getattr(settings, "device"));
  in.device.index = nb::cast<int>(nb::getattr(settings, "device_index"));
  in.device.ray_tracing = nb::cast<std::string>(nb::getattr(settings, "ray_tracing"));
  in.device.cache = nb::cast<std::string>(nb::getattr(settings, "cache"));
  for (nb::handle pass : nb::getattr(settings, "passes")) in.passes.push_back(nb::cast<std::string>(pass));
  return in;
}

}  // namespace cotorra
