// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes and sessions without Python, for the sanitizers: arrays that end where they end, threads that read, cancel and
// go away meanwhile. What the pixels should be is tested through Python; here they must be finite, and the same twice.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "../../kernels/program/ops.h"
#include "scene.h"
#include "session.h"

namespace {

using namespace cotorra;

#define CHECK(CONDITION)                                                                 \
  do {                                                                                   \
    if (!(CONDITION)) {                                                                  \
      std::fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #CONDITION); \
      std::exit(1);                                                                      \
    }                                                                                    \
  } while (false)

constexpr int kWidth = 70, kHeight = 45;  // no multiple of a tile, a packet or a block of the sampler
constexpr int kSamples = 3;

// The arrays of a mesh: they must live as long as the scene, which shares them. Each is as long as it must be.
struct Grid {
  std::vector<vec3> positions, normals;
  std::vector<uvec3> triangles, corners;
  std::vector<vec2> uv;
  std::vector<uint> slots;

  // A height field of n x n cells over [-1, 1]^2.
  void make(uint n) {
    for (uint y = 0; y <= n; ++y) {
      for (uint x = 0; x <= n; ++x) {
        const float u = float(x) / float(n), v = float(y) / float(n);
        positions.emplace_back(2.0f * u - 1.0f, 2.0f * v - 1.0f, 0.2f * std::sin(6.0f * u) * std::cos(5.0f * v));
        normals.push_back(normalize_up(u, v));
      }
    }
    for (uint y = 0; y < n; ++y) {
      for (uint x = 0; x < n; ++x) {
        const uint i = y * (n + 1) + x;
        for (const uvec3 t : {uvec3(i, i + 1, i + n + 1), uvec3(i + 1, i + n + 2, i + n + 1)}) {
          const uint first = static_cast<uint>(3 * triangles.size());
          triangles.push_back(t);
          corners.emplace_back(first, first + 1, first + 2);
          for (int corner = 0; corner < 3; ++corner) uv.emplace_back(float(x), float(y));
          slots.push_back((x + y) % 3);  // slot 2 does not exist: the last one is taken
        }
      }
    }
  }

  static vec3 normalize_up(float u, float v) { return cotorra::normalize(vec3(u - 0.5f, v - 0.5f, 2.0f)); }
};

// A shader that is one Principled closure; where it is smooth, most of it is clear glass.
struct ShaderArrays {
  std::vector<uint> ops{OP_NORMAL}, modes{0};
  std::vector<vec3> constants;
  std::vector<ShaderInput::Closure> closures{{CLOSURE_PRINCIPLED, PRINCIPLED_MULTI_GGX, ~0, 0}};
  std::vector<int> arguments;

  ShaderArrays(vec3 color, float metal, float rough, vec3 emitted) {
    constants = {vec3(1.0f),  vec3(0.0f),  color,
                 vec3(metal), vec3(rough), vec3(1.5f),
                 vec3(0.5f),  emitted,     vec3(rough == 0.0f ? 0.8f : 0.0f)};
    arguments.assign(PRINCIPLED_ARGUMENTS, ~1);
    for (const uint one : {PRINCIPLED_SPECULAR_TINT, PRINCIPLED_ALPHA}) arguments[one] = ~0;
    for (const uint normal : {PRINCIPLED_NORMAL, PRINCIPLED_COAT_NORMAL}) arguments[normal] = 0;
    arguments[PRINCIPLED_BASE] = ~2;
    arguments[PRINCIPLED_METALLIC] = ~3;
    arguments[PRINCIPLED_ROUGHNESS] = ~4;
    arguments[PRINCIPLED_IOR] = ~5;
    arguments[PRINCIPLED_SPECULAR_LEVEL] = ~6;
    arguments[PRINCIPLED_EMISSION] = ~7;
    arguments[PRINCIPLED_TRANSMISSION] = ~8;
  }

  ShaderInput input() const { return {"shader", ops, modes, {}, constants, closures, arguments, {}}; }
};

// The other arrays that SceneInput views; they may go away once the scene is made.
struct Arrays {
  std::shared_ptr<Grid> grid = std::make_shared<Grid>();
  std::vector<uint> mesh, material_base, material_count, visibility;
  std::vector<float> transform, terminator;
  std::vector<int> pass_index, light_group;
  std::vector<ShaderArrays> shaders;
  std::vector<uint> emission_sampling, material_slots;
  std::vector<int> material_index, material_shader;
  std::vector<uint> light_type, soft_falloff, normalize, cast_shadow, use_mis, max_bounces, light_visibility;
  std::vector<vec3> strength;
  std::vector<float> light_transform, size, spot_size, spot_blend;
  std::vector<int> lamp_group;

  void add_instance(uint mesh_index, float scale, vec3 origin, uint slot_base) {
    mesh.push_back(mesh_index);
    transform.insert(transform.end(), {scale, 0, 0, origin.x, 0, scale, 0, origin.y, 0, 0, std::abs(scale), origin.z});
    material_base.push_back(slot_base);
    material_count.push_back(2);
    pass_index.push_back(7);
    visibility.push_back(VISIBLE_ALL);
    light_group.push_back(0);
    terminator.push_back(0.1f);
  }

  void add_material(vec3 color, float metal, float rough, vec3 emitted) {
    material_shader.push_back(static_cast<int>(shaders.size()));
    shaders.emplace_back(color, metal, rough, emitted);
    emission_sampling.push_back(1);
    material_index.push_back(3);
  }

  void add_light(uint type, vec3 power, vec3 origin, float radius) {
    light_type.push_back(type);
    strength.push_back(power);
    light_transform.insert(light_transform.end(), {1, 0, 0, origin.x, 0, 1, 0, origin.y, 0, 0, 1, origin.z});
    size.push_back(radius);
    spot_size.push_back(1.0f);
    spot_blend.push_back(0.2f);
    soft_falloff.push_back(static_cast<uint>(light_type.size() % 2));
    for (auto *flags : {&normalize, &cast_shadow, &use_mis}) flags->push_back(1);
    max_bounces.push_back(1024);
    light_visibility.push_back(VISIBLE_ALL);
    lamp_group.push_back(1);
  }

  SceneInput input() {
    SceneInput scene;
    MeshInput smooth;
    smooth.name = "smooth";
    smooth.positions = grid->positions;
    smooth.triangles = grid->triangles;
    smooth.corners = grid->corners;
    smooth.normals = grid->normals;
    smooth.uv = grid->uv;
    smooth.slots = grid->slots;
    smooth.owner = grid;
    MeshInput flat;
    flat.name = "flat";
    flat.positions = grid->positions;
    flat.triangles = grid->triangles;
    flat.owner = grid;
    MeshInput empty;
    empty.name = "empty";
    scene.meshes = {smooth, flat, empty};
    scene.instances = {mesh, transform, material_base, material_count, pass_index, visibility, light_group, terminator};
    scene.materials = {material_index, emission_sampling, material_shader};
    for (const ShaderArrays &shader : shaders) scene.programs.shaders.push_back(shader.input());
    scene.material_slots = material_slots;
    scene.lights = {light_type, strength,    light_transform, size,        spot_size,        spot_blend, soft_falloff,
                    normalize,  cast_shadow, use_mis,         max_bounces, light_visibility, lamp_group};
    scene.world = vec3(0.1f, 0.2f, 0.3f);
    scene.light_group_count = 2;
    return scene;
  }
};

Arrays make_arrays() {
  Arrays a;
  a.grid->make(9);
  a.add_instance(0, 1.0f, vec3(0.0f), 0);
  a.add_instance(0, -0.4f, vec3(0.5f, 0.2f, 0.6f), 0);
  a.add_instance(0, 0.3f, vec3(-0.6f, 0.1f, 0.5f), 1);
  a.add_instance(1, 3.0f, vec3(0.0f, 0.0f, -1.0f), 1);
  a.add_instance(2, 1.0f, vec3(0.0f), 0);
  a.add_material(vec3(0.8f, 0.5f, 0.2f), 0.0f, 0.5f, vec3(0.0f));
  a.add_material(vec3(0.9f), 0.5f, 0.0f, vec3(0.0f));
  a.add_material(vec3(0.1f), 0.0f, 1.0f, vec3(2.0f, 3.0f, 1.0f));
  a.material_slots = {0, 1, 2};
  a.add_light(LIGHT_POINT, vec3(30.0f), vec3(1.0f, 1.0f, 2.0f), 0.2f);
  a.add_light(LIGHT_SUN, vec3(1.0f), vec3(0.0f), 0.1f);
  a.add_light(LIGHT_SPOT, vec3(80.0f), vec3(0.0f, 0.0f, 3.0f), 0.1f);
  return a;
}

CameraInput make_camera() {
  CameraInput camera;
  camera.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 4};
  camera.window = {-0.4f, 0.4f, -0.26f, 0.26f};
  camera.clip = {0.1f, 100.0f};
  camera.resolution = {kWidth, kHeight};
  camera.region = {0, 0, kWidth, kHeight};
  return camera;
}

SettingsInput make_settings(const char *integrator, int threads) {
  SettingsInput settings;
  settings.integrator = integrator;
  settings.samples = kSamples;
  settings.threads = threads;
  settings.ambient_strength = 0.2f;
  settings.use_ambient_occlusion = true;
  settings.use_transparent_shadows = true;
  settings.whitted_threshold = 0.01f;
  settings.passes = {"combined",     "depth",          "position",      "normal",       "uv",
                     "object_index", "material_index", "diffuse_color", "emission",     "environment",
                     "shadow",       "sample_count",   "lightgroup:0",  "lightgroup:1", "ao"};
  return settings;
}

std::shared_ptr<const Scene> make_scene(const std::string &embree) {
  Arrays arrays = make_arrays();
  const std::atomic<bool> cancel{false};
  auto scene = std::make_shared<Scene>(arrays.input());
  scene->build_bvh(embree::Library::open(embree), 2, cancel);
  return scene;
}

std::vector<float> read_all(Session &session, const SettingsInput &settings) {
  std::vector<float> all;
  for (const std::string &pass : settings.passes) {
    std::vector<float> pixels(static_cast<std::size_t>(kWidth * kHeight * Film::channels(pass)));
    session.read(pass, pixels);
    all.insert(all.end(), pixels.begin(), pixels.end());
  }
  return all;
}

template <class Failure>
bool throws(const std::function<void()> &f) {
  try {
    f();
  } catch (const Failure &) {
    return true;
  }
  return false;
}

// ---- Tests

void test_same_bits_on_any_threads(const std::shared_ptr<const Scene> &scene) {
  for (const char *integrator : {"DIRECT", "PATH", "WHITTED", "AO", "TOON"}) {
    std::vector<std::vector<float>> images;
    for (const int threads : {1, 4}) {
      const SettingsInput settings = make_settings(integrator, threads);
      Session session(scene, make_camera(), settings);
      session.start();
      while (!session.wait(0.01)) CHECK(session.progress() >= 0.0 && session.progress() <= 1.0);
      CHECK(session.samples_done() == kSamples);
      images.push_back(read_all(session, settings));
    }
    CHECK(images[0] == images[1]);
    CHECK(std::all_of(images[0].begin(), images[0].end(), [](float value) { return std::isfinite(value); }));
    CHECK(std::any_of(images[0].begin(), images[0].end(), [](float value) { return value > 0.0f; }));
  }
}

void test_adaptive(const std::shared_ptr<const Scene> &scene) {
  SettingsInput settings = make_settings("PATH", 3);
  settings.adaptive = true;
  settings.samples = 16;
  settings.adaptive_min_samples = 4;
  settings.noise_threshold = 0.2f;
  settings.sharing = true;
  Session session(scene, make_camera(), settings);
  session.start();
  CHECK(session.wait(600.0));
  const std::vector<float> all = read_all(session, settings);
  CHECK(std::all_of(all.begin(), all.end(), [](float value) { return std::isfinite(value); }));
}

void test_read_and_cancel_meanwhile(const std::shared_ptr<const Scene> &scene) {
  SettingsInput settings = make_settings("PATH", 3);
  settings.samples = 1 << 20;
  Session session(scene, make_camera(), settings);
  session.start();
  for (int i = 0; i < 5; ++i) {
    read_all(session, settings);
    session.stats();
  }
  std::thread([&] { session.cancel(); }).join();
  CHECK(session.wait(60.0));
  read_all(session, settings);
  CHECK(session.samples_done() < settings.samples);
}

void test_session_goes_away_while_rendering(const std::shared_ptr<const Scene> &scene) {
  SettingsInput settings = make_settings("DIRECT", 2);
  settings.samples = 1 << 20;
  Session never_started(scene, make_camera(), settings);
  Session session(scene, make_camera(), settings);
  session.start();
}

void test_orthographic_region(const std::shared_ptr<const Scene> &scene) {
  CameraInput camera = make_camera();
  camera.orthographic = true;
  camera.window = {-2.0f, 2.0f, -1.3f, 1.3f};
  camera.region = {33, 7, 1, 1};
  SettingsInput settings = make_settings("PATH", 2);
  settings.passes = {"combined"};
  Session session(scene, camera, settings);
  session.start();
  CHECK(session.wait(60.0));
  std::vector<float> pixel(4);
  session.read("combined", pixel);
  CHECK(pixel[3] > 0.0f);
}

void test_refusals(const std::string &embree) {
  const auto library = embree::Library::open(embree);
  const std::atomic<bool> stop{true};
  const auto refused = [&](const std::function<void(Arrays &)> &spoil) {
    Arrays arrays = make_arrays();
    spoil(arrays);
    return throws<std::invalid_argument>([&] { const Scene scene(arrays.input()); });
  };
  CHECK(refused([](Arrays &a) { a.grid->triangles.back().z = 1u << 30; }));
  CHECK(refused([](Arrays &a) { a.grid->corners.back().x = 1u << 30; }));
  CHECK(refused([](Arrays &a) { a.mesh.back() = 99; }));
  CHECK(refused([](Arrays &a) { a.material_slots.back() = 99; }));
  CHECK(refused([](Arrays &a) { a.transform.pop_back(); }));
  CHECK(refused([](Arrays &a) { a.material_shader.pop_back(); }));
  CHECK(refused([](Arrays &a) { a.material_shader[0] = 7; }));
  CHECK(refused([](Arrays &a) { a.shaders[0].arguments.pop_back(); }));
  CHECK(refused([](Arrays &a) { a.shaders[0].constants.pop_back(); }));
  CHECK(refused([](Arrays &a) { a.light_transform.pop_back(); }));
  CHECK(throws<Cancelled>([&] {
    Arrays arrays = make_arrays();
    Scene scene(arrays.input());
    scene.build_bvh(library, 2, stop);
  }));
  CHECK(throws<std::runtime_error>([] { embree::Library::open("/nowhere/libembree4.so"); }));
}

void test_empty_scene(const std::string &embree) {
  const std::atomic<bool> cancel{false};
  Arrays nothing;
  nothing.add_material(vec3(0.8f), 0.0f, 0.5f, vec3(0.0f));
  SceneInput input = nothing.input();
  input.meshes.clear();
  const auto scene = std::make_shared<Scene>(std::move(input));
  scene->build_bvh(embree::Library::open(embree), 1, cancel);
  const SettingsInput settings = make_settings("PATH", 2);
  Session session(scene, make_camera(), settings);
  session.start();
  CHECK(session.wait(60.0));
  read_all(session, settings);
}

}  // namespace

int main(int count, char **arguments) {
  CHECK(count == 2);
  const std::string embree = arguments[1];
  const std::shared_ptr<const Scene> scene = make_scene(embree);
  CHECK(!scene->instanced() || scene->stats().triangles > 0);
  test_same_bits_on_any_threads(scene);
  test_adaptive(scene);
  test_read_and_cancel_meanwhile(scene);
  test_session_goes_away_while_rendering(scene);
  test_orthographic_region(scene);
  test_refusals(embree);
  test_empty_scene(embree);
  std::puts("all sessions passed");
  return 0;
}
