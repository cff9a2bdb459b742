// SPDX-License-Identifier: GPL-3.0-or-later
// The part of the Embree 4 C interface that Cotorra uses, and the table of its functions, filled when the library is
// opened at run time. Building needs no Embree SDK; the device's reported version is checked when it is opened.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include <sys/types.h>

namespace cotorra::embree {

struct DeviceTy;
struct SceneTy;
struct GeometryTy;
using Device = DeviceTy *;
using Scene = SceneTy *;
using Geometry = GeometryTy *;

constexpr std::uint32_t kInvalidId = 0xffffffffu;

// Values of the published enumerations.
enum DeviceProperty : int {
  kPropertyVersion = 0,
  kPropertyNativeRay4 = 32,
  kPropertyNativeRay8 = 33,
  kPropertyRayMask = 64,
};
enum GeometryType : int { kQuads = 1, kInstanceArray = 122 };
enum BufferType : int { kIndexBuffer = 0, kVertexBuffer = 1, kTransformBuffer = 23 };
enum Format : int { kUint = 0x5001, kUint4 = 0x5004, kFloat3 = 0x9003, kFloat4x4ColumnMajor = 0x9244 };
enum BuildQuality : int { kLow = 0, kMedium = 1, kHigh = 2 };
enum SceneFlags : int { kSceneCompact = 2, kSceneRobust = 4 };
enum Error : int { kNone = 0, kOutOfMemory = 4, kUnsupportedCpu = 5, kCancelled = 6 };
enum QueryFlags : int { kIncoherent = 0, kCoherent = 1 << 16 };

template <int N>
struct alignas(N == 1 ? 16 : 4 * N) Ray {
  float org_x[N], org_y[N], org_z[N], tnear[N];
  float dir_x[N], dir_y[N], dir_z[N], time[N];
  float tfar[N];
  std::uint32_t mask[N], id[N], flags[N];
};
template <int N>
struct alignas(N == 1 ? 16 : 4 * N) Hit {
  float ng_x[N], ng_y[N], ng_z[N], u[N], v[N];
  std::uint32_t prim_id[N], geom_id[N], inst_id[N], inst_prim_id[N];
};
template <int N>
struct alignas(N == 1 ? 16 : 4 * N) RayHit {
  Ray<N> ray;
  Hit<N> hit;
};

// Ray k of a packet, and what it met before it is traced: nothing.
template <int N, class Vector>
void set_ray(Ray<N> &ray, std::size_t k, Vector origin, Vector direction, float begin, float end, std::uint32_t mask) {
  ray.org_x[k] = origin.x;
  ray.org_y[k] = origin.y;
  ray.org_z[k] = origin.z;
  ray.dir_x[k] = direction.x;
  ray.dir_y[k] = direction.y;
  ray.dir_z[k] = direction.z;
  ray.tnear[k] = begin;
  ray.tfar[k] = end;
  ray.time[k] = 0.0f;
  ray.mask[k] = mask;
}
template <int N>
void set_missed(Hit<N> &hit, std::size_t k) {
  hit.geom_id[k] = kInvalidId;
  hit.inst_id[k] = kInvalidId;
  hit.inst_prim_id[k] = 0;
}

// Where in the instances a query is; RTCRayQueryContext of builds with one level of instances and instance arrays.
struct QueryContext {
  std::uint32_t inst_id = kInvalidId;
  std::uint32_t inst_prim_id = kInvalidId;
};

// What a filter function is told of N hits: whether each counts, which it may change. Ray and hit are a Ray<N> and a
// Hit<N>.
struct FilterArguments {
  int *valid;
  void *geometry_user;
  QueryContext *context;
  void *ray;
  void *hit;
  unsigned int count;
};
using Filter = void (*)(const FilterArguments *);

// Arguments of intersection and of occlusion queries; both have this layout.
struct QueryArguments {
  int flags = kIncoherent;
  std::uint32_t feature_mask = 0xffffffffu;
  void *context = nullptr;
  void *filter = nullptr;
  void *callback = nullptr;
  float min_width_distance_factor = 0.0f;  // read only by builds of Embree with that option
};

constexpr std::uint32_t kFeatureQuad = 1u << 2;
constexpr std::uint32_t kFeatureFilterInArguments = 1u << 24;
constexpr std::uint32_t kFeatureInstanceArray = 1u << 29;

struct Api {
  Device (*new_device)(const char *config);
  void (*release_device)(Device);
  ssize_t (*get_device_property)(Device, int property);
  int (*get_device_error)(Device);
  const char *(*get_device_last_error_message)(Device);
  void (*set_device_memory_monitor)(Device, bool (*monitor)(void *, ssize_t, bool), void *);
  Scene (*new_scene)(Device);
  void (*release_scene)(Scene);
  void (*commit_scene)(Scene);
  void (*set_scene_build_quality)(Scene, int);
  void (*set_scene_flags)(Scene, int);
  void (*set_scene_progress_monitor)(Scene, bool (*monitor)(void *, double), void *);
  Geometry (*new_geometry)(Device, int type);
  void (*release_geometry)(Geometry);
  void (*commit_geometry)(Geometry);
  void (*set_geometry_mask)(Geometry, std::uint32_t);
  void (*set_geometry_build_quality)(Geometry, int);
  void (*set_geometry_enable_filter)(Geometry, bool);  // that of the query's arguments
  void (*set_shared_geometry_buffer)(Geometry, int type, std::uint32_t slot, int format, const void *,
                                     std::size_t offset, std::size_t stride, std::size_t count);
  void (*set_geometry_instanced_scene)(Geometry, Scene);
  void (*attach_geometry_by_id)(Scene, Geometry, std::uint32_t);
  void (*intersect1)(Scene, RayHit<1> *, QueryArguments *);
  void (*occluded1)(Scene, Ray<1> *, QueryArguments *);
  void (*intersect4)(const int *valid, Scene, RayHit<4> *, QueryArguments *);
  void (*occluded4)(const int *valid, Scene, Ray<4> *, QueryArguments *);
  void (*intersect8)(const int *valid, Scene, RayHit<8> *, QueryArguments *);
  void (*occluded8)(const int *valid, Scene, Ray<8> *, QueryArguments *);
};

// An opened Embree library; it stays open as long as somebody holds it.
class Library {
 public:
  // Tries `path`, then $COTORRA_EMBREE, then the system's name. Throws std::runtime_error with what was tried.
  static std::shared_ptr<const Library> open(const std::string &path);

  explicit Library(const std::string &path);
  ~Library();
  Library(const Library &) = delete;
  Library &operator=(const Library &) = delete;

  const Api &api() const { return api_; }
  const std::string &path() const { return path_; }

 private:
  void *handle_ = nullptr;
  Api api_{};
  std::string path_;
};

}  // namespace cotorra::embree
