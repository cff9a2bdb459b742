// SPDX-License-Identifier: GPL-3.0-or-later
// The Python module cotorra_native: shows scenes and sessions to Python. Exceptions become Python errors here and
// nowhere else; the exporter's dataclasses are read in python_inputs.cpp.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <future>
#include <thread>

#include "features.h"
#include "laboratory.h"
#include "python_arrays.h"
#include "python_explain.h"
#include "python_geometry.h"
#include "python_inputs.h"
#include "python_sky.h"
#include "scene.h"
#include "session.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace cotorra {
namespace {

// What Python holds: sessions share the scene, and may outlive it.
struct SceneHandle {
  std::shared_ptr<Scene> scene;
};

// Calls work(cancel) on a thread of its own, so that the caller's can ask `should_cancel` (which needs the GIL).
template <class Work>
void run_cancellable(Work work, nb::object should_cancel) {
  std::atomic<bool> cancel{false};
  const nb::gil_scoped_release no_gil;
  std::future<void> future = std::async(std::launch::async, [&] { work(cancel); });
  std::exception_ptr interrupt;
  while (future.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
    const nb::gil_scoped_acquire gil;
    if (cancel || interrupt) continue;
    try {
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      if (!should_cancel.is_none() && nb::cast<bool>(should_cancel())) cancel = true;
    } catch (...) {
      interrupt = std::current_exception();
      cancel = true;
    }
  }
  try {
    future.get();
    if (interrupt) std::rethrow_exception(interrupt);
    if (cancel) throw Cancelled();
  } catch (const Cancelled &) {
    if (interrupt) std::rethrow_exception(interrupt);
    throw;
  }
}

std::shared_ptr<Scene> make_scene(nb::handle buffers, int threads, const std::string &embree_path,
                                  nb::object should_cancel, bool bvh, const SceneUse &use) {
  std::vector<nb::object> keep;
  SceneInput input = read_scene(buffers, keep);
  std::shared_ptr<Scene> scene;
  run_cancellable(
      [&](const std::atomic<bool> &cancel) {
        scene = std::make_shared<Scene>(std::move(input), use);
        if (bvh) scene->build_bvh(embree::Library::open(embree_path), threads, cancel, use.previous.get());
      },
      std::move(should_cancel));
  return scene;
}

void build_bvh(const SceneHandle &handle, int threads, const std::string &embree_path, nb::object should_cancel,
               const SceneHandle *previous) {
  run_cancellable(
      [&](const std::atomic<bool> &cancel) {
        handle.scene->build_bvh(embree::Library::open(embree_path), threads, cancel,
                                previous != nullptr ? previous->scene.get() : nullptr);
      },
      std::move(should_cancel));
}

nb::dict scene_stats(const SceneHandle &handle) {
  const Scene &scene = *handle.scene;
  const SceneStats &s = scene.stats();
  nb::dict d;
  d["build_seconds"] = s.build_seconds;
  d["memory_bytes"] = s.bytes;
  d["bvh_bytes"] = s.bvh_bytes;
  d["triangles"] = s.triangles;
  d["instanced_triangles"] = s.instanced_triangles;
  d["instances"] = scene.data().instance_count;
  d["meshes"] = scene.mesh_count();
  d["materials"] = scene.data().material_count;
  d["lights"] = scene.data().light_count;
  d["images"] = s.images;
  d["image_bytes"] = s.image_bytes;
  d["emitters"] = scene.data().emitter_count;
  d["coplanar_meshes"] = s.coplanar_meshes;
  d["light_bytes"] = s.light_bytes;
  d["light_tree_seconds"] = s.light_tree_seconds;
  d["world_width"] = scene.data().world_width;
  d["world_taken_over"] = s.world_taken_over;
  return d;
}

// What a material is made of where that is constant, by the names of Principled's inputs.
nb::dict material_constants(const SceneHandle &handle, std::size_t material) {
  const CompiledShader &c = handle.scene->compiled(material);
  const auto color = [](vec3 v) { return nb::make_tuple(v.x, v.y, v.z); };
  nb::dict d;
  if (c.program.surface.first == NO_PROGRAM) {
    d["base_color"] = color(c.surface.base_color);
    d["metallic"] = c.surface.metallic;
    d["roughness"] = c.surface.roughness;
    d["ior"] = c.surface.ior;
    d["specular_level"] = c.surface.specular_level;
    d["specular_tint"] = color(c.surface.specular_tint);
    d["multi_ggx"] = c.surface.multi_ggx;
  }
  d["transmission"] = c.surface.transmission;
  if (c.program.emission.first == NO_PROGRAM) d["emission"] = color(c.emission);
  if (c.program.transparency.first == NO_PROGRAM) d["transparency"] = color(c.transparency);
  return d;
}

// What a BadSample is, by the names of native/health.h; -1: nobody.
nb::list bad_samples(const BadCounts &counts) {
  const auto number = [](std::uint32_t value) { return value == kNobody ? std::int64_t{-1} : std::int64_t{value}; };
  nb::list found;
  for (const auto &[bad, count] : counts) {
    nb::dict d;
    d["kind"] = bad.kind;
    d["place"] = bad.place;
    d["material"] = number(bad.material);
    d["light"] = number(bad.light);
    d["bounce"] = bad.bounce;
    d["lobe"] = bad.lobe;
    d["argument"] = number(bad.argument);
    d["op"] = number(bad.op);
    d["samples"] = count;
    found.append(d);
  }
  return found;
}

nb::dict session_stats(const Session &session) {
  const SessionStats s = session.stats();
  nb::dict rays;
  rays["camera"] = s.rays.camera;
  rays["bounce"] = s.rays.bounce;
  rays["shadow"] = s.rays.shadow;
  nb::dict d;
  d["render_seconds"] = s.render_seconds;
  d["rays"] = rays;
  d["samples"] = s.rays.samples;
  d["rejected_samples"] = s.rays.rejected;
  d["bad_samples"] = bad_samples(s.rays.bad);
  d["light"] = s.rays.light;
  d["held_light"] = s.rays.held_light;
  d["caustics"] = s.rays.caustics;
  d["held_caustics"] = s.rays.held_caustics;
  d["busy_seconds"] = s.rays.busy_seconds;
  d["traced_seconds"] = s.rays.traced_seconds;
  d["memory_bytes"] = s.bytes;
  d["features"] = feature_names(s.features);
  d["left_out"] = left_out(s.features);
  d["device"] = s.device.name;
  d["isa"] = s.device.isa;
  d["compiled"] = feature_names(s.device.features);
  d["device_build_seconds"] = s.device.build_seconds;
  d["upload_seconds"] = s.device.upload_seconds;
  d["compile_seconds"] = s.device.compile_seconds;
  d["first_seconds"] = s.device.first_seconds;
  d["device_bytes"] = s.device.bytes;
  d["device_messages"] = s.device.messages;
  return d;
}

nb::dict cpu_info() {
  nb::dict d;
  d["isa"] = "x86-64-v" + std::to_string(cpu_isa_level());
  d["threads"] = std::thread::hardware_concurrency();
  return d;
}

nb::dict shader_ops() {
  nb::dict d;
  for (const OpInfo &op : program_ops()) {
    d[op.name] = nb::make_tuple(op.number, std::string(1, op.result), op.arguments);
  }
  return d;
}

nb::dict shader_closures() {
  nb::dict d;
  for (const ClosureInfo &c : program_closures()) d[c.name] = nb::make_tuple(c.kind, std::string(c.arguments));
  return d;
}

nb::list devices() {
  nb::list list;
  for (const VulkanDeviceInfo &info : vulkan_devices()) {
    nb::dict d;
    d["name"] = info.name;
    d["driver"] = info.driver;
    d["type"] = info.type;
    d["memory_bytes"] = info.memory;
    d["ray_query"] = info.ray_query;
    d["problem"] = info.problem;
    list.append(d);
  }
  return list;
}

nb::list compile_kernels(const std::vector<std::string> &features, int device_index, const std::string &cache,
                         const std::string &ray_tracing, const std::vector<std::string> &ops) {
  DeviceChoice choice;
  choice.kind = "VULKAN";
  choice.index = device_index;
  choice.cache = cache;
  choice.ray_tracing = ray_tracing;
  nb::list list;
  for (const CompiledStage &stage : compile_vulkan_kernels(features_of(features), needs_of_ops(ops), choice)) {
    nb::dict statistics;
    for (const auto &[name, value] : stage.statistics) statistics[name.c_str()] = value;
    nb::dict d;
    d["stage"] = stage.name;
    d["seconds"] = stage.seconds;
    d["statistics"] = statistics;
    list.append(d);
  }
  return list;
}

using PassArray = nb::ndarray<float, nb::c_contig, nb::device::cpu>;

}  // namespace
}  // namespace cotorra

NB_MODULE(cotorra_native, m) {
  using namespace cotorra;
  m.doc() = "Cotorra's native module: scenes on Embree and the render sessions over them.";
  nb::exception<Cancelled>(m, "Cancelled");
  nb::exception<DeviceError>(m, "DeviceError", PyExc_RuntimeError);
  m.def("devices", &devices,
        "Vulkan's devices in the order of RenderSettings.device_index, as dicts: name, driver, type, memory_bytes,\n"
        "ray_query, problem (why it cannot be used, or ''). Raises DeviceError where there is no Vulkan.");
  m.def(
      "compile_kernels", &compile_kernels, "features"_a, "device_index"_a = -1, "cache"_a = "",
      "ray_tracing"_a = "AUTO", "ops"_a = std::vector<std::string>(),
      "Compiles the kernels with these features (names as in Session.stats) for a Vulkan device, one stage after the\n"
      "other: a list of dicts with stage, seconds, and statistics (registers, spills, ... as the driver calls them).\n"
      "`cache`: folder of compiled kernels, '' for none; `ray_tracing`: as in RenderSettings; `ops`: those that "
      "programs\n"
      "hold. Raises DeviceError; ValueError for an unknown feature or op.");
  m.def("version", [] { return COTORRA_VERSION; }, "The version of the module.");
  m.def("shader_ops", &shader_ops,
        "Ops of shaders by name: (number, 'f' or 'v' for the result, the arguments' types such as 'vff').");
  m.def("shader_closures", &shader_closures, "Closures of shaders by name: (number, the arguments' types).");
  m.def("cpu_info", &cpu_info, "Instruction set that the kernels use here, and hardware threads.");
  m.def(
      "kernels",
      [] {
        nb::list list;
        for (const CpuKernel *k : cpu_kernels())
          list.append(nb::make_tuple(std::string(k->isa), feature_names(k->features)));
        return list;
      },
      "The builds of the CPU kernels: (instruction set, features compiled in).");

  register_laboratory(m);
  register_sky(m);
  register_geometry(m);

  nb::class_<SceneHandle>(m, "Scene", "A validated scene, for the CPU with a BVH.")
      .def(
          "__init__",
          [](SceneHandle *self, nb::handle buffers, int threads, const std::string &embree, nb::object should_cancel,
             bool bvh, bool editable, const SceneHandle *previous) {
            const SceneUse use{editable, previous != nullptr ? previous->scene : nullptr};
            new (self) SceneHandle{make_scene(buffers, threads, embree, std::move(should_cancel), bvh, use)};
          },
          "buffers"_a, "threads"_a = 0, "embree"_a = "", "should_cancel"_a = nb::none(), "bvh"_a = true,
          "editable"_a = false, "previous"_a.none() = nb::none(),
          "Builds a scene from a SceneBuffers on `threads` threads (0 = all), with the Embree library at the path\n"
          "`embree` ('' = $COTORRA_EMBREE, then the system's). `should_cancel`, called every 20 ms, may stop it.\n"
          "Without `bvh` the CPU cannot render it until build_bvh was called; Embree is not opened, then.\n"
          "An `editable` scene is one of many, each a little changed: it takes over from a `previous` editable one "
          "the\n"
          "meshes whose arrays are the same memory (arrays are never written again), with their BVHs. The previous "
          "one\n"
          "stays as it is.\n"
          "Raises ValueError (array, index, value), RuntimeError (Embree), Cancelled.")
      .def("build_bvh", &build_bvh, "threads"_a = 0, "embree"_a = "", "should_cancel"_a = nb::none(),
           "previous"_a.none() = nb::none(),
           "Builds the BVH that the CPU needs, where there is none yet; as the constructor.")
      .def("stats", &scene_stats, "Build seconds, bytes and counts, as a dict.")
      .def("constants", &material_constants, "material"_a,
           "What a material is made of, as a dict by the names of Principled's inputs; what varies has no entry.\n"
           "Raises IndexError.")
      .def(
          "explain",
          [](const SceneHandle &handle, std::size_t shader) { return explain_shader(*handle.scene, shader); },
          "shader"_a,
          "What a shader of the SceneBuffers became, as a dict: surface (None, the constants of its one closure, or a\n"
          "program), emission and transparency (three floats or a program), folded: (the shader's op, three floats),\n"
          "dropped: (the shader's closure, what of it is 0: 0 its weight, 1 its alpha, 2 its colour).\n"
          "A program is a dict: instructions (op, mode, values, the shader's op or -1), closures (kind, mode, weight,\n"
          "values, the shader's closure or -1), result (a value), registers, and nanoseconds, measured now: of its\n"
          "instructions for one point on one thread. A value is a float, three, or the number of an instruction.\n"
          "Raises IndexError.");

  nb::class_<Session>(m, "Session", "A render in progress.")
      .def(
          "__init__",
          [](Session *self, const SceneHandle &scene, nb::handle camera, nb::handle settings, bool restarts) {
            new (self) Session(scene.scene, read_camera(camera), read_settings(settings), restarts);
          },
          "scene"_a, "camera"_a, "settings"_a, "restarts"_a = false,
          "Prepares a render of `scene` through a Camera with RenderSettings. Raises ValueError naming the setting,\n"
          "DeviceError where its device cannot render this. `restarts`: keep for `restart` what it can use again.")
      .def(
          "restart",
          [](Session &self, nb::handle camera, nb::handle settings) {
            const CameraInput seen = read_camera(camera);
            const SettingsInput how = read_settings(settings);
            const nb::gil_scoped_release no_gil;
            self.restart(seen, how);
          },
          "camera"_a, "settings"_a,
          "Stops, and is as a new session of the scene. What is on a graphics card stays where the settings differ in\n"
          "nothing but samples, noise and seed. Raises as the constructor; the session is of no use, then.")
      .def("start", &Session::start, "Starts the threads and returns.")
      .def("wait", &Session::wait, "seconds"_a, nb::call_guard<nb::gil_scoped_release>(),
           "Waits; True when all threads have stopped. Raises what a thread raised.")
      .def("continue_on_cpu", &Session::continue_on_cpu,
           "After `wait` raised DeviceError: `start` will let the CPU take the samples that are missing, and those "
           "that\n"
           "there are stay. Raises ValueError where the scene has no BVH for the CPU.")
      .def("cancel", &Session::cancel, "Asks the threads to stop; what was rendered stays.")
      .def("resume", &Session::resume, nb::call_guard<nb::gil_scoped_release>(),
           "After `cancel`: goes on with the samples that are missing, to the same bits.")
      .def(
          "spread",
          [](Session &self, nb::ndarray<const std::uint32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu> most) {
            const std::span<const std::uint32_t> pixels(most.data(), most.size());
            const nb::gil_scoped_release no_gil;
            self.spread(pixels);
          },
          "most"_a.noconvert(),
          "Once each pixel has settings.spread_after samples: `start` will go on to as many as `most` says, (h, w) "
          "from\n"
          "below. Raises RuntimeError before.")
      .def(
          "differences",
          [](Session &self, nb::ndarray<float, nb::ndim<3>, nb::c_contig, nb::device::cpu> out) {
            const std::span<float> numbers(out.data(), out.size());
            const nb::gil_scoped_release no_gil;
            self.differences(numbers);
          },
          "out"_a.noconvert(),
          "film_error of each pixel beside half of its samples, and of these beside half of them, and the rays of a "
          "sample\n"
          "in its tile, (h, w, 3).")
      .def("progress", &Session::progress, "0 to 1.")
      .def("samples_done", &Session::samples_done, "Samples that every pixel has behind it.")
      .def(
          "read",
          [](Session &self, const std::string &pass, PassArray out) {
            const std::span<float> pixels(out.data(), out.size());
            const nb::gil_scoped_release no_gil;
            self.read(pass, pixels);
          },
          "pass_name"_a, "out"_a.noconvert(),
          "Writes the state of a pass into a float32 array (height, width, channels); row 0 is the bottom.")
      .def("stats", &session_stats, "Seconds, rays by kind, samples, bytes and features, as a dict.");
}
