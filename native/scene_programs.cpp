// SPDX-License-Identifier: GPL-3.0-or-later
// Gives materials the programs that their shaders became, and derives what programs read of meshes and instances.
// How a shader is compiled is told in program_compile.cpp; pixels are taken over in images.cpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "scene.h"

#include "every_feature.h"

#include "../kernels/integrator.h"

namespace cotorra {
namespace {

void require_entries(std::size_t size, std::size_t expected, const char *name) {
  if (size == expected) return;
  throw std::invalid_argument(std::string(name) + " has " + std::to_string(size) + " entries, expected " +
                              std::to_string(expected));
}

bool uses(const CompiledShader &shader, std::initializer_list<uint> ops) {
  return std::any_of(ops.begin(), ops.end(),
                     [&](uint op) { return (shader.ops_used[op / 64] >> (op % 64) & 1u) != 0; });
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

// Of a material without a shader: the constants of a new Principled node, and nothing varies.
static const CompiledShader &default_shader() {
  static const CompiledShader shader;
  return shader;
}

// Takes over what a shader became where all of it, or a part, is constant; what varies is the program's.
static Material material_of(const CompiledShader &shader) {
  Material m{};
  const PlainSurface &s = shader.surface;
  m.base_color = s.base_color;
  m.metallic = s.metallic;
  m.roughness = s.roughness;
  m.ior = s.ior;
  m.specular_level = s.specular_level;
  m.specular_tint = s.specular_tint;
  m.alpha = 1.0f - clamp(shader.transparency.x, 0.0f, 1.0f);
  m.emission = shader.emission;
  m.flags = shader.dark;
  const bool varies = shader.program.surface.first != NO_PROGRAM;
  m.flags |= varies ? MATERIAL_SPECULAR | MATERIAL_DIFFUSE : principled_flags(m);
  if (shader.sharp || (!varies && (m.flags & MATERIAL_SPECULAR) != 0 && m.roughness < kSharpRoughness)) {
    m.flags |= MATERIAL_SHARP;
  }
  if (s.multi_ggx) m.flags |= MATERIAL_MULTI_GGX;
  const bool clear = shader.program.transparency.first != NO_PROGRAM || max_component(shader.transparency) > 0.0f;
  if (clear) m.flags |= MATERIAL_TRANSPARENT;
  if (clear && !shader.grey) m.flags |= MATERIAL_TINTED;
  if (shader.varies()) m.flags |= MATERIAL_PROGRAM;
  return m;
}

// Surfaces that shine to one side alike, and to the other not at all, need no program for it.
static void take_lit_side(CompiledShader &c) {
  if (!c.lit_evenly) return;
  c.emission = c.lit;
  c.program.emission = {NO_PROGRAM, 0, 0, 0};
  c.emission_needs = {};
}

const CompiledShader &Scene::compiled(std::size_t material) const {
  const int shader = material_shaders_.at(material);
  return shader < 0 ? default_shader() : compiled_[static_cast<std::size_t>(shader)];
}

void Scene::validate_shaders(const SceneInput &in) const {
  const int count = static_cast<int>(in.programs.shaders.size());
  const auto require = [count](int shader, const std::string &name) {
    if (shader >= -1 && shader < count) return;
    throw std::invalid_argument(name + " = " + std::to_string(shader) + ", must be from -1 to below " +
                                std::to_string(count));
  };
  const auto require_all = [&](std::span<const int> shaders, const std::string &name) {
    for (std::size_t i = 0; i < shaders.size(); ++i) require(shaders[i], name + "[" + std::to_string(i) + "]");
  };
  require_all(in.materials.shader, "materials.shader");
  require_all(in.lights.shader, "lights.shader");
  require(in.world_shader, "world.shader");
}

vec3 Scene::emission_of(int shader, bool &varies) const {
  if (shader < 0) return vec3(1.0f);
  const CompiledShader &c = compiled_[static_cast<std::size_t>(shader)];
  if ((c.dark & MATERIAL_FRONT_DARK) != 0) return vec3(0.0f);  // lamps and worlds have no back
  varies = c.program.emission.first != NO_PROGRAM;
  return c.emission;
}

void Scene::prepare_programs(ProgramsInput &in, const MaterialsInput &materials) {
  material_shaders_.assign(materials.shader.begin(), materials.shader.end());
  const bool alpha = std::any_of(in.shaders.begin(), in.shaders.end(), [](const ShaderInput &shader) {
    return std::find(shader.ops.begin(), shader.ops.end(), OP_IMAGE_F) != shader.ops.end();
  });
  for (const ImageInput &image : in.images) {
    library_of_programs_.opaque_images.push_back(alpha && is_opaque(image) ? 1 : 0);
  }
  for (const ShaderInput &shader : in.shaders) compiled_.push_back(library_of_programs_.add(shader));
  for (const int shader : material_shaders_) {
    if (shader >= 0) take_lit_side(compiled_[static_cast<std::size_t>(shader)]);
  }
  for (const CompiledShader &c : compiled_) {
    surface_needs_.add(c.surface_needs);
    emission_needs_.add(c.emission_needs);
    transparency_needs_.add(c.transparency_needs);
    asks_spaces_ |= uses(c, {OP_OBJECT_POSITION, OP_OBJECT_TRANSFORM});
    asks_meshes_ |= c.varies();
  }
  for (std::size_t i = 0; i < material_shaders_.size(); ++i) {
    const CompiledShader &c = compiled(i);
    materials_.push_back(material_of(c));
    materials_[i].pass_index = materials.pass_index[i];
    set_emission_flags(materials_[i], materials.emission_sampling[i]);
    if (asks_meshes_) material_programs_.push_back(c.program);
  }
  if (!asks_meshes_) return;
  for (ImageInput &image : in.images) add_image(std::move(image), textures_);
  data_.textures = {textures_.images.data()};
  data_.texture_count = static_cast<uint>(textures_.images.size());
  data_.programs = {material_programs_.data()};
  data_.program_code = {library_of_programs_.code.data()};
  data_.program_closures = {library_of_programs_.closures.data()};
  data_.program_constants = {library_of_programs_.constants.data()};
  data_.tables = {library_of_programs_.tables.data()};
  data_.uv_layer_count = in.uv_layers;
}

using Matrix = std::array<std::array<double, 3>, 3>;

// The inverse by cofactors; 0 where there is none.
static Matrix inverse_of(const Matrix &m) {
  Matrix inverse;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
      inverse[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
    }
  }
  const double det = m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
  for (auto &row : inverse) {
    for (double &x : row) x = det != 0.0 ? x / det : 0.0;
  }
  return inverse;
}

// From world space to that of an object, by rows. A flat object has the pseudoinverse (M^T M + e I)^-1 M^T, e small:
// along the axis that its scale makes 0, its own coordinate is 0.
static ObjectSpace space_of(const float *transform) {
  Matrix m;
  double size = 1.0;  // of the box that the axes span
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) m[i][j] = static_cast<double>(transform[4 * i + j]);
    size *= std::sqrt(m[0][j] * m[0][j] + m[1][j] * m[1][j] + m[2][j] * m[2][j]);
  }
  const double det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) +
                     m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
                     m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  Matrix inverse = inverse_of(m);
  if (std::abs(det) <= 1e-12 * size) {
    Matrix square{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < 3; ++k) square[i][j] += m[k][i] * m[k][j];
      }
    }
    const double e = 1e-12 * (square[0][0] + square[1][1] + square[2][2]);
    for (std::size_t i = 0; i < 3; ++i) square[i][i] += e;
    const Matrix left = inverse_of(square);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        inverse[i][j] = left[i][0] * m[j][0] + left[i][1] * m[j][1] + left[i][2] * m[j][2];
      }
    }
  }
  vec4 rows[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = inverse[i][0], y = inverse[i][1], z = inverse[i][2];
    const double w = x * static_cast<double>(transform[3]) + y * static_cast<double>(transform[7]) +
                     z * static_cast<double>(transform[11]);
    rows[i] = vec4(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(-w));
  }
  return {rows[0], rows[1], rows[2], vec3(transform[3], transform[7], transform[11]), 0};
}

LightProgram Scene::program_light(const LightsInput &in, std::size_t i, Light &light) const {
  const float *m = in.transform.data() + 12 * i;
  const CompiledShader &shader = compiled_[static_cast<std::size_t>(in.shader[i])];
  LightProgram program{};
  program.emission = shader.program.emission;
  program.constants = shader.program.constants;
  program.space = space_of(m);
  program.x_axis = {m[0], m[4], m[8]};
  program.y_axis = {m[1], m[5], m[9]};
  program.z_axis = {m[2], m[6], m[10]};
  const double angle = static_cast<double>(light.type == LIGHT_SUN ? in.size[i] : in.spot_size[i]);
  if (light.type == LIGHT_SPOT) program.uv_scale = static_cast<float>(0.5 / std::max(std::tan(0.5 * angle), 1e-6));
  if (light.type == LIGHT_SUN && angle > 0.0) program.uv_scale = static_cast<float>(0.5 / std::sin(0.25 * angle));
  light.flags |= LIGHT_PROGRAM;
  return program;
}

void Scene::estimate_lights() {
  constexpr uint kPoints = 256;  // of each lamp
  for (uint i = 0; i < light_programs_.size(); ++i) {
    const Light &light = lights_[i];
    LightProgram &program = light_programs_[i];
    if ((light.flags & LIGHT_PROGRAM) == 0) continue;
    double sum = 0.0;
    for (uint k = 0; k < kPoints; ++k) {
      // From a place in front of it, or anywhere about a point light, a few of its own sizes away.
      const vec2 u = sampler_pair(k, 0x1a3bu);
      const float h =
          light.type == LIGHT_POINT ? 2.0f : (light.type == LIGHT_SPOT ? min(light.spot_versine, 1.0f) : 1.0f);
      const vec3 local = cone_from_square(u, h);
      vec3 t, b;
      orthonormal_basis(light.axis, t, b);
      const vec3 way = to_world(local, t, b, light.axis);
      const vec3 p = light.position + way * (1.0f + 4.0f * light.radius);
      LightSample l;
      light_sample(light, p, -way, sampler_pair(k, 0x77e1u), l);
      ShaderPoint at = light_point(i, light, program, p, l.wi, l.distance);
      at.ray_kind = 0;
      at.bounce = 1;
      const vec3 value = light_numbers(program_value(data_, at, program.emission, program.constants));
      sum += static_cast<double>(luminance(abs(value)));
    }
    // It may shine where nobody looked: it is never left out.
    program.mean = static_cast<float>(std::clamp(sum / kPoints, 1e-3, 1e15));
  }
}

void Scene::prepare_object_spaces(const SceneInput &in, std::span<const uint> order) {
  if (!asks_spaces_) return;
  for (const uint i : order) textures_.spaces.push_back(space_of(in.instances.transform.data() + std::size_t{12} * i));
  data_.object_spaces = {textures_.spaces.data()};
}

void Scene::prepare_infos(const SceneInput &input, std::span<const uint> order) {
  const ProgramsInput &in = input.programs;
  const std::size_t n = order.size();
  const std::size_t layers = in.instance_layers.size();
  require_entries(in.instance_attributes.size(), layers * n, "instances.attributes");
  for (std::size_t layer = 0; layer < layers; ++layer) {
    for (const uint i : order) textures_.instance_attributes.push_back(in.instance_attributes[layer * n + i]);
  }
  data_.instance_attributes = {textures_.instance_attributes.data()};
  const bool asked = std::any_of(compiled_.begin(), compiled_.end(),
                                 [](const CompiledShader &c) { return uses(c, {OP_OBJECT_INFO_V, OP_OBJECT_INFO_F}); });
  if (!asked) return;
  const bool given = !in.info_color.empty();
  if (given) {
    require_entries(in.info_color.size(), n, "instances.info.color");
    require_entries(in.info_random.size(), n, "instances.info.random");
  }
  for (const uint i : order) {
    const float *m = input.instances.transform.data() + std::size_t{12} * i;
    InstanceInfo info{vec3(m[3], m[7], m[11]), 1.0f, vec3(1.0f), 0.0f};
    if (given) {
      const vec4 c = in.info_color[i];
      info.color = vec3(c.x, c.y, c.z);
      info.alpha = c.w;
      info.random = in.info_random[i];
    }
    textures_.infos.push_back(info);
  }
  data_.instance_infos = {textures_.infos.data()};
}

// The attributes of mesh k, one after the other, and for each layer behind those of UV maps where it begins.
static void fill_attributes(const SceneInput &in, std::size_t k, const std::string &name, Textures &textures) {
  const MeshInput &source = in.meshes[k];
  const uint uv_layers = in.programs.uv_layers;
  std::vector<uint> &table = textures.attribute_tables[k];
  table.assign(std::size_t{2} * (std::max(in.programs.attribute_layers, uv_layers) - uv_layers), ATTRIBUTE_NONE);
  const auto set = [&](uint layer, uint kind, std::size_t first) {
    if (layer < uv_layers || 2 * std::size_t{layer - uv_layers} >= table.size()) {
      throw std::invalid_argument(name + "an attribute's layer is " + std::to_string(layer) +
                                  ", which is none of attribute_layers");
    }
    table[2 * (layer - uv_layers)] = kind;
    table[2 * (layer - uv_layers) + 1] = static_cast<uint>(first);
  };
  for (std::size_t layer = 0; layer < in.programs.instance_layers.size(); ++layer) {
    set(in.programs.instance_layers[layer], ATTRIBUTE_INSTANCE, layer * in.instances.mesh.size());
  }
  for (const AttributeInput &a : source.attributes) {
    std::size_t least = a.domain == ATTRIBUTE_FACE ? source.triangles.size() : source.positions.size();
    if (a.domain == ATTRIBUTE_CORNER) {
      least = 1;
      for (const uvec3 &c : source.corners)
        least = std::max({least, c.x + std::size_t{1}, c.y + std::size_t{1}, c.z + std::size_t{1}});
    }
    if (a.values.size() < least || (a.domain == ATTRIBUTE_CORNER && source.corners.empty())) {
      throw std::invalid_argument(name + "an attribute has " + std::to_string(a.values.size()) + " entries, expected " +
                                  std::to_string(least));
    }
    set(a.layer, a.domain | a.components << ATTRIBUTE_COMPONENTS_SHIFT, textures.attributes[k].size());
    textures.attributes[k].insert(textures.attributes[k].end(), a.values.begin(), a.values.end());
  }
}

void Scene::prepare_mesh_textures(const SceneInput &in) {
  if (!asks_meshes_) return;
  textures_.meshes.resize(in.meshes.size());
  textures_.attributes.resize(in.meshes.size());
  textures_.attribute_tables.resize(in.meshes.size());
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
    fill_attributes(in, k, name, textures_);
    m.attributes = {textures_.attributes[k].data()};
    m.attribute_table = {textures_.attribute_tables[k].data()};
    m.attribute_words = static_cast<uint>(textures_.attribute_tables[k].size());
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

void Scene::estimate_emission(const MaterialsInput &in) {
  constexpr uint kPoints = 512;  // of each material
  if (material_programs_.empty()) return;
  // 1. The triangles of each material whose emission varies: how many there are, then some of them.
  std::vector<std::uint64_t> count(materials_.size(), 0), seen(materials_.size(), 0);
  std::vector<std::array<double, 4>> sum(materials_.size(), {0.0, 0.0, 0.0, 0.0});
  const auto varies = [&](uint m) { return material_programs_[m].emission.first != NO_PROGRAM; };
  const auto each = [&](auto &&visit) {
    for (std::size_t k = 0; k < instances_.size(); ++k) {
      const Instance &i = instances_[k];
      bool any = false;
      for (uint s = 0; s < i.material_count; ++s) any |= varies(material_slots_[i.material_base + s]);
      for (uint t = 0; any && t < meshes_[i.mesh].triangle_count; ++t) {
        const uint m = triangle_material(data_, static_cast<uint>(k), t);
        if (varies(m)) visit(static_cast<uint>(k), t, m);
      }
    }
  };
  each([&](uint, uint, uint m) { ++count[m]; });
  // 2. Their programs at points spread over them, seen from the sides that are not dark.
  each([&](uint instance, uint triangle, uint m) {
    const std::uint64_t step = std::max<std::uint64_t>(count[m] / kPoints, 1);
    const std::uint64_t points = std::max<std::uint64_t>(kPoints / count[m], 1);
    if (seen[m]++ % step != 0) return;
    for (std::uint64_t p = 0; p < points; ++p) {
      const vec2 b = triangle_from_square(sampler_pair(static_cast<uint>(p), 0x51a7u + triangle));
      const Hit hit{1.0f, b.x, b.y, triangle, instance, 0};
      for (const float z : {1.0f, -1.0f}) {
        Surface s;
        surface_from_hit(data_, hit, vec3(0.0f, 0.0f, z), s);
        if (material_is_dark(materials_[m], s.side)) continue;
        vec3 x, y;
        orthonormal_basis(s.ng, x, y);
        const vec2 u = sampler_pair(static_cast<uint>(p), 0x29c3u + triangle);
        ShaderPoint at = shader_point(s, to_world(cosine_hemisphere_from_square(u), x, y, s.ng), 1.0f);
        at.ray_kind = 0;  // as light samples ask
        at.bounce = 1;
        const vec3 e = material_emission(data_, m, materials_[m], at);
        for (std::size_t c = 0; c < 3; ++c) sum[m][c] += std::max(static_cast<double>((&e.x)[c]), 0.0);
        sum[m][3] += 1.0;
      }
    }
  });
  for (std::size_t m = 0; m < materials_.size(); ++m) {
    if (material_programs_[m].emission.first == NO_PROGRAM) continue;
    const double n = std::max(sum[m][3], 1.0);
    materials_[m].emission =
        vec3(static_cast<float>(sum[m][0] / n), static_cast<float>(sum[m][1] / n), static_cast<float>(sum[m][2] / n));
    const CompiledShader &shader = compiled(m);
    // There is no camera yet that could tell.
    if (uses(shader, {OP_WINDOW, OP_CAMERA_POSITION, OP_CAMERA_Z, OP_CAMERA_DISTANCE, OP_OBJECT_TRANSFORM}) &&
        !carries_light(materials_[m].emission)) {
      materials_[m].emission = vec3(1.0f);
    }
    // Light samples trace no rays for programs: they would see another surface than the camera and the rays that find
    // it do. Cycles takes them nevertheless, as if all were open, and mixes both in shares that its light tree makes.
    const bool traces = (shader.emission_needs.groups & GROUP_RAYS) != 0u;
    set_emission_flags(materials_[m], traces ? 0u : in.emission_sampling[m]);
    // It may emit where nobody looked: rays find it there.
    materials_[m].flags |= MATERIAL_EMISSIVE;
  }
}

void set_emission_flags(Material &m, uint sampled) {
  m.flags &= ~(MATERIAL_EMISSIVE | MATERIAL_SAMPLED);
  if (!carries_light(m.emission)) return;
  m.flags |= MATERIAL_EMISSIVE;
  // Triangles are picked by luminance, which colours with negative parts may lack.
  const float luminance = dot(m.emission, vec3(0.2126f, 0.7152f, 0.0722f));
  if (sampled != 0 && luminance > 0.0f) m.flags |= MATERIAL_SAMPLED;
}

}  // namespace cotorra
