// SPDX-License-Identifier: GPL-3.0-or-later
// Opens the Embree 4 library at run time and looks up its functions.
// It builds and traces nothing.
#include "embree.h"

#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "dynamic_library.h"

namespace cotorra::embree {
namespace {

#if defined(_WIN32)
constexpr const char *kSystemNames[] = {"embree4.dll"};
#elif defined(__APPLE__)
constexpr const char *kSystemNames[] = {"libembree4.4.dylib", "libembree4.dylib"};
#else
constexpr const char *kSystemNames[] = {"libembree4.so.4", "libembree4.so"};
#endif

template <class Function>
void look_up(void *handle, const char *name, Function &function) {
  void *symbol = find_symbol(handle, name);
  if (symbol == nullptr) throw std::runtime_error(std::string("it has no function ") + name);
  function = reinterpret_cast<Function>(symbol);
}

}  // namespace

Library::Library(const std::string &path) : path_(path) {
  handle_ = open_library(path);
  if (handle_ == nullptr) throw std::runtime_error(open_error());
  try {
    look_up(handle_, "rtcNewDevice", api_.new_device);
    look_up(handle_, "rtcReleaseDevice", api_.release_device);
    look_up(handle_, "rtcGetDeviceProperty", api_.get_device_property);
    look_up(handle_, "rtcGetDeviceError", api_.get_device_error);
    look_up(handle_, "rtcGetDeviceLastErrorMessage", api_.get_device_last_error_message);
    look_up(handle_, "rtcSetDeviceMemoryMonitorFunction", api_.set_device_memory_monitor);
    look_up(handle_, "rtcNewScene", api_.new_scene);
    look_up(handle_, "rtcReleaseScene", api_.release_scene);
    look_up(handle_, "rtcCommitScene", api_.commit_scene);
    look_up(handle_, "rtcSetSceneBuildQuality", api_.set_scene_build_quality);
    look_up(handle_, "rtcSetSceneFlags", api_.set_scene_flags);
    look_up(handle_, "rtcSetSceneProgressMonitorFunction", api_.set_scene_progress_monitor);
    look_up(handle_, "rtcNewGeometry", api_.new_geometry);
    look_up(handle_, "rtcReleaseGeometry", api_.release_geometry);
    look_up(handle_, "rtcCommitGeometry", api_.commit_geometry);
    look_up(handle_, "rtcSetGeometryMask", api_.set_geometry_mask);
    look_up(handle_, "rtcSetGeometryBuildQuality", api_.set_geometry_build_quality);
    look_up(handle_, "rtcSetGeometryEnableFilterFunctionFromArguments", api_.set_geometry_enable_filter);
    look_up(handle_, "rtcSetSharedGeometryBuffer", api_.set_shared_geometry_buffer);
    look_up(handle_, "rtcSetGeometryInstancedScene", api_.set_geometry_instanced_scene);
    look_up(handle_, "rtcAttachGeometryByID", api_.attach_geometry_by_id);
    look_up(handle_, "rtcIntersect1", api_.intersect1);
    look_up(handle_, "rtcOccluded1", api_.occluded1);
    look_up(handle_, "rtcIntersect4", api_.intersect4);
    look_up(handle_, "rtcOccluded4", api_.occluded4);
    look_up(handle_, "rtcIntersect8", api_.intersect8);
    look_up(handle_, "rtcOccluded8", api_.occluded8);
  } catch (...) {
    close_library(handle_);
    throw;
  }
}

Library::~Library() {
  // Embree's scheduler may still own threads that run library code: the handle is left to the process.
}

std::shared_ptr<const Library> Library::open(const std::string &path) {
  std::vector<std::string> candidates;
  if (!path.empty()) candidates.push_back(path);
  if (const char *chosen = std::getenv("COTORRA_EMBREE"); chosen != nullptr && *chosen != '\0') {
    candidates.emplace_back(chosen);
  }
  for (const char *name : kSystemNames) candidates.emplace_back(name);
  std::string tried;
  for (const std::string &candidate : candidates) {
    try {
      return std::make_shared<const Library>(candidate);
    } catch (const std::runtime_error &error) {
      tried += "\n  " + candidate + ": " + error.what();
    }
  }
  throw std::runtime_error(
      "No Embree 4 library could be opened. Install the embreex package, or set COTORRA_EMBREE to the library's path. "
      "Tried:" +
      tried);
}

}  // namespace cotorra::embree
