// SPDX-License-Identifier: GPL-3.0-or-later
// The memory of a wavefront on a GPU: what the stages (entry/vulkan/*.comp) hand to each other, by lane; and what a
// dispatch is told. One lane is one sample of one pixel. What a stage does is written in the stages and in
// integrator.h.
#ifndef COTORRA_WAVEFRONT_H
#define COTORRA_WAVEFRONT_H

#include "bvh.h"
#include "denoising.h"
#include "job.h"
#include "lamp_terms.h"
#include "occlusion.h"
#include "outline.h"
#include "reweighting.h"
#include "sharing.h"
#include "toon.h"
#include "whitted.h"

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

// What ShadowRay.t_max says once a light sample is done: the share of it that arrives, or that there is none; and what
// Hit.t says of a ray that crossed more transparent surfaces than it may.
const float SHADOW_NONE = -1.0f;
const float HIT_ENDED = -1.0f;

struct WavePixel {
  uint x;  // in the whole picture
  uint y;
  uint block_seed;  // of the tile that the pixel lies in
  // Where pixels share samples: which of those around are sampled too (sharing.h), and where film_places has this one.
  uint sampled;
  uint place;
};

// What a sample tells beside its light, for passes; of a pixel: sums over its samples, and the first five of the sample
// nearest its centre.
struct WaveRecord {
  vec3 position;
  float depth;
  float object_index;
  float material_index;
  float distance2;  // to the pixel's centre
  float hit;  // 1: there is a surface
  vec3 normal;
  float uv_coverage;
  vec3 diffuse_color;
  float lit;  // luminance that arrived at the first surface
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
  uint medium;  // material that the ray under way runs inside of, INVALID_ID: none that absorbs
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
BUFFER_RW(float, FloatRwBuffer)
BUFFER_RW(Hit, HitRwBuffer)
BUFFER_RW(ModelBsdf, ModelBsdfRwBuffer)
BUFFER_RW(vec2, Vec2RwBuffer)
BUFFER_RW(int, IntRwBuffer)
BUFFER_RW(WaveRecord, WaveRecordRwBuffer)
BUFFER_RW(WaveTree, WaveTreeRwBuffer)
BUFFER_RW(PendingRay, PendingRayRwBuffer)
BUFFER_RW(WaveTerms, WaveTermsRwBuffer)
BUFFER_RW(OutlinePoint, OutlinePointRwBuffer)
BUFFER_RW(OutlineSums, OutlineSumsRwBuffer)
BUFFER_RW(FilmPixel, FilmPixelRwBuffer)
BUFFER_RW(BrightSum, BrightSumRwBuffer)
BUFFER_RW(SharedSum, SharedSumRwBuffer)

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
  // By lane.
#define LANE_STATE(TYPE, BUFFER, NAME, EACH, NEEDED) BUFFER NAME;
#define PATH_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT) BUFFER path_##MEMBER;
#define SHADOW_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT) BUFFER shadow_##MEMBER;
#define BSDF_STATE(TYPE, BUFFER, MEMBER, NEEDED) BUFFER bsdf_##MEMBER;
#define LOBE_STATE(MEMBER, PLACE)
#include "state.inc"
#undef LANE_STATE
#undef PATH_STATE
#undef SHADOW_STATE
#undef LOBE_STATE
#undef BSDF_STATE
  // By pixel of the tiles that are being rendered.
  WavePixelBuffer pixels;
  FilmPixelRwBuffer film;
  WaveRecordRwBuffer film_records;
  BrightSumRwBuffer film_bright;
  Vec3RwBuffer film_groups;
  Vec3RwBuffer film_lamps;
  WaveTermsRwBuffer film_terms;
  // Where pixels share samples: what each pixel's add to its window of pixels, and then what the pixels got.
  SharedSumRwBuffer film_shares;
  SharedSumRwBuffer film_shared;
  UintRwBuffer film_places;  // pixels of this list, by tile_side x tile_side places for each tile
  uint tile_side;
  JobData job;
  uint lanes;  // there are
  uint sample_bits;
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
  uint sky_slot;  // place of the one that it sends to the sky, INVALID_ID: none
  uint queue;  // prepare.comp: which is to be dispatched over
  uint outline_ray;  // outline.comp: which has been traced
  uint unused;
};

#ifdef __cplusplus
static_assert(sizeof(WavePixel) == 20 && sizeof(WaveRecord) == 128 && sizeof(WaveTree) == 8 &&
              sizeof(WaveTerms) == 20 && sizeof(WavePush) == 48 && sizeof(TracedGeometry) == 8);
}  // namespace cotorra
#endif

#endif
