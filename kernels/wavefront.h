// SPDX-License-Identifier: GPL-3.0-or-later
// The memory of a wavefront on a GPU: what the stages (*.comp) hand to each other, by lane; and what a dispatch is
// told. One lane is one sample of one pixel. What a stage does is written in the stages and in integrator.h.
#ifndef COTORRA_WAVEFRONT_H
#define COTORRA_WAVEFRONT_H

#include "bvh.h"
#include "camera.h"
#include "denoising.h"
#include "film.h"
#include "lamp_terms.h"
#include "occlusion.h"
#include "outline.h"
#include "toon.h"

#ifdef __cplusplus
namespace cotorra {
#endif

const uint WAVE_GROUP_SIZE = 64u;

// Queues of lanes: whose ray is to be traced, who stands at a surface, and which shadow rays (light slot x lanes +
// lane).
const uint WAVE_RAYS = 0u;
const uint WAVE_SHADING = 1u;
const uint WAVE_SHADOWS = 2u;
// Words of the counters: for each queue three that an indirect dispatch reads, then how many lanes each queue has, then
// sums that the host collects.
const uint WAVE_COUNTS = 9u;
const uint WAVE_BOUNCE_RAYS = 12u;
const uint WAVE_SHADOW_RAYS = 13u;
const uint WAVE_REJECTED = 14u;
const uint WAVE_COUNTERS = 16u;

const uint WAVE_TRANSPARENT = 1u;           // RenderJob's flags
const uint WAVE_CAMERA_MEETS_LIGHTS = 2u;
const uint WAVE_LAST_RAYS_FIND_LIGHT = 4u;
const uint WAVE_ALL_LIGHTS = 8u;            // every lamp is sampled at each vertex
const uint WAVE_TRANSPARENT_SHADOWS = 16u;  // Whitted: shadow rays see through glass
const uint WAVE_OCCLUSION_PICTURE = 32u;    // what is seen of the sky is the picture
const uint WAVE_OCCLUSION_PASS = 64u;
const uint WAVE_AMBIENT = 128u;             // surfaces return ambient light
const uint WAVE_AMBIENT_OCCLUDED = 256u;    // as much as they see of the sky
const uint WAVE_TERMS_PASS = 512u;

// What ShadowRay.t_max says once a light sample is done: the share of it that arrives, or that there is none; and what
// Hit.t says of a ray that crossed more transparent surfaces than it may.
const float SHADOW_NONE = -1.0f;
const float HIT_ENDED = -1.0f;

struct WavePixel {
  uint x;  // in the whole picture
  uint y;
  uint block_seed;  // of the tile that the pixel lies in
  uint unused;
};

// What a sample has gathered.
struct WaveSample {
  vec3 radiance;
  float alpha;
  vec2 offset;  // from the pixel's centre, pixels
};

// What a sample tells beside its light, for passes; of a pixel: sums over its samples, and the first five of the sample
// nearest its centre.
struct WaveRecord {
  vec3 position;
  float depth;
  float object_index;
  float material_index;
  float distance2;  // to the pixel's centre
  float hit;        // 1: there is a surface
  vec3 normal;
  float uv_coverage;
  vec3 diffuse_color;
  float lit;         // luminance that arrived at the first surface
  vec3 emission;
  float unshadowed;  // that would have arrived
  vec3 environment;
  float occlusion;  // sky that is free
  vec2 uv;
  vec3 feature_albedo;
  vec3 feature_normal;
};

// Whitted: what a sample still has to trace. Rays wait on a stack, so that the deepest comes first and there are never
// more than levels of the recursion, and one.
struct WaveTree {
  uint pending;  // rays that wait
  uint medium;   // material that the ray under way runs inside of, INVALID_ID: none that absorbs
};

struct WavePending {
  PathState path;
  vec3 origin;
  uint medium;
  vec3 direction;
  uint unused;
};

// The terms of the first surface's highlight; of a pixel: sums over its samples.
struct WaveTerms {
  float d;
  float g;
  vec3 f;
};

// A geometry of the hardware's acceleration structure. It is found at the custom index of the hardware's instance + the
// geometry's index in there.
struct TracedGeometry {
  uint instance;
  uint first_triangle;
};

BUFFER_REF(TracedGeometry, TracedGeometryBuffer)
BUFFER_REF(WavePixel, WavePixelBuffer)
BUFFER_RW(uint, UintRwBuffer)
BUFFER_RW(vec3, Vec3RwBuffer)
BUFFER_RW(CameraRay, CameraRayRwBuffer)
BUFFER_RW(PathState, PathStateRwBuffer)
BUFFER_RW(Hit, HitRwBuffer)
BUFFER_RW(Surface, SurfaceRwBuffer)
BUFFER_RW(Bsdf, BsdfRwBuffer)
BUFFER_RW(Lobe, LobeRwBuffer)
BUFFER_RW(ShadowRay, ShadowRayRwBuffer)
BUFFER_RW(WaveSample, WaveSampleRwBuffer)
BUFFER_RW(WaveRecord, WaveRecordRwBuffer)
BUFFER_RW(WaveTree, WaveTreeRwBuffer)
BUFFER_RW(WavePending, WavePendingRwBuffer)
BUFFER_RW(WaveTerms, WaveTermsRwBuffer)
BUFFER_RW(OutlinePoint, OutlinePointRwBuffer)
BUFFER_RW(OutlineSums, OutlineSumsRwBuffer)
BUFFER_RW(FilmPixel, FilmPixelRwBuffer)

struct AccelerationData {
  TracedGeometryBuffer geometries;
  uvec2 top;  // device address of the top level: low word, high word
};

// Everything that stays the same while a session renders. Of `bvh` and `acceleration` only that is filled which the
// stages were compiled for (trace.glsl).
struct WaveData {
  RECORD_REF(SceneData) scene;
  BvhData bvh;
  AccelerationData acceleration;
  UintRwBuffer counters;
  UintRwBuffer rays_queue;
  UintRwBuffer shading_queue;
  UintRwBuffer shadows_queue;
  // By lane; shadow_rays by light slot x lanes + lane, groups by lane x light_groups + group, lamps likewise, pending
  // by place on the stack x lanes + lane.
  CameraRayRwBuffer rays;
  PathStateRwBuffer paths;
  HitRwBuffer hits;
  SurfaceRwBuffer surfaces;
  BsdfRwBuffer bsdfs;
  LobeRwBuffer lobes;  // with FEATURE_LOBES
  ShadowRayRwBuffer shadow_rays;
  WaveSampleRwBuffer samples;
  WaveRecordRwBuffer records;
  Vec3RwBuffer groups;
  WaveTreeRwBuffer trees;
  WavePendingRwBuffer pending;
  Vec3RwBuffer lamps;
  WaveTermsRwBuffer terms;
  Vec3RwBuffer base_colors;  // Toon
  // Toon with outlines: what the camera ray met, while those around it are traced, and what these met.
  HitRwBuffer outline_hits;
  OutlinePointRwBuffer outline_points;
  OutlineSumsRwBuffer outline_sums;
  // By pixel of the tiles that are being rendered.
  WavePixelBuffer pixels;
  FilmPixelRwBuffer film;
  Vec3RwBuffer film_odd;
  WaveRecordRwBuffer film_records;
  Vec3RwBuffer film_groups;
  Vec3RwBuffer film_lamps;
  WaveTermsRwBuffer film_terms;
  CameraData camera;
  IntegratorData integrator;
  uint lanes;  // there are
  uint sample_bits;
  uint flags;  // WAVE_*
  uint light_groups;
  uint adaptive;  // film_odd is kept
  uint lamp_passes;  // passes of single lamps
  uint whitted_depth;
  float whitted_threshold;
  vec3 ambient;
  float occlusion_distance;
  vec3 outline_color;
  uint outlines;     // OUTLINE_*, 0: none are drawn
  float outline_x;   // half of a line's width, pixels
  float outline_y;
  float rows;        // of the whole picture, pixels
};
BUFFER_RW(WaveData, WaveDataBuffer)

// What a dispatch is told: pixels [first_pixel, + pixel_count), samples [first_sample, + sample_count) of each.
struct WavePush {
  WaveDataBuffer data;
  uint first_pixel;
  uint pixel_count;
  uint first_sample;
  uint sample_count;
  uint bounce;
  uint light_slots;  // shadow rays that a lane may send to lights at this vertex
  uint sky_slot;     // place of the one that it sends to the sky, INVALID_ID: none
  uint queue;        // wave_prepare.comp: which is to be dispatched over
  uint outline_ray;  // wave_outline.comp: which has been traced
  uint unused;
};

#ifdef __cplusplus
static_assert(sizeof(WavePixel) == 16 && sizeof(WaveSample) == 24 && sizeof(WaveRecord) == 128 &&
              sizeof(WaveTree) == 8 && sizeof(WavePending) == 120 && sizeof(WaveTerms) == 20 &&
              sizeof(WavePush) == 48 && sizeof(TracedGeometry) == 8);
}  // namespace cotorra
#endif

#endif
