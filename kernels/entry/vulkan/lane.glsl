// SPDX-License-Identifier: GPL-3.0-or-later
// What every stage of the GPU's wavefront begins with: extensions, features, what the dispatch was told, queues, and
// how the bodies of stages (kernels/stage/) reach the lane that they work on. What a stage does is not here.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint KERNEL_FEATURES = 0xffffffffu;

// What of the ops of programs this stage needs for the scene.
layout(constant_id = 1) const uint PROGRAM_GROUPS = 0xffffffffu;
layout(constant_id = 2) const uint PROGRAM_VARIANTS = 0xffffffffu;
#define PROGRAM_GROUP(BIT) ((PROGRAM_GROUPS & (BIT)) != 0u)
#define PROGRAM_VARIANT(BIT) ((PROGRAM_VARIANTS & (BIT)) != 0u)

#include "wavefront.h"

layout(push_constant, scalar) uniform PushConstants { WavePush push; };

#define WAVE push.data.v[0]

// Is this invocation beyond the lanes of a queue?
bool beyond(uint queue) { return gl_GlobalInvocationID.x >= LOAD(WAVE.counters, WAVE_COUNTS + queue); }

// A new place at the end of a queue. The order of lanes in it differs from run to run; nothing depends on it.
uint append(uint queue) { return atomicAdd(WAVE.counters.v[WAVE_COUNTS + queue], 1u); }

WavePixel pixel_of(uint lane) { return LOAD(WAVE.pixels, push.first_pixel + lane / push.sample_count); }

// Random pair `pair` of the vertex that the path stands at.
vec2 vertex_random(PathState path, uint block_seed, uint pair) {
  return sampler_pair(path.random, sampler_pair_seed(block_seed, vertex_pair(path.vertex, pair)));
}

// ---- What bodies of stages see of a lane; native/cpu_lane.h is the other device's.
#define LANE uint
#define LANE_BSDF Bsdf
#define SCENE WAVE.scene
#define JOB WAVE.job
#define FLAG(BIT) ((JOB.flags & (BIT)) != 0u)
#define SLOT(lane) (lane)  // the sample that it belongs to
#define RADIANCE(lane) WAVE.samples.v[lane].radiance
#define ALPHA(lane) WAVE.samples.v[lane].alpha
#define FILTER_OFFSET(lane) WAVE.offsets.v[lane]
#define GROUP_LIGHT(lane, group) WAVE.groups.v[(lane) * JOB.light_groups + (group)]
#define LAMP_LIGHT(lane, lamp) WAVE.lamps.v[(lane) * JOB.lamp_passes + (lamp)]
#define CLAMPED(lane, light, limit) clamped_light(light, limit)
#define PATH_BOUNCE(lane) path_bounce_of(lane)
#define WORLD_SEEN(lane, path, direction) world_radiance(SCENE, path_background(path, direction))
#define MEDIUM(lane) WAVE.trees.v[lane].medium

#include "state.glsl"

uint path_bounce_of(uint lane) {
  if (!GOES_ON) return 0u;
  return LOAD(WAVE.path_bounce, lane);
}

// ---- What passes are told beside light.
#define NOTE_EMISSION(lane, light) WAVE.records.v[lane].emission += (light)
#define NOTE_ENVIRONMENT(lane, light) WAVE.records.v[lane].environment += (light)
#define NOTE_FEATURES(lane, albedo, normal) note_features(lane, albedo, normal)
#define NOTE_SKY(lane, sky) WAVE.records.v[lane].occlusion = (sky)
#define NOTE_SHADOW(lane, arrived, sent) note_shadow(lane, arrived, sent)
#define NOTE_SURFACE(lane, first) note_surface(lane, first)
#define NOTE_TERMS(lane, d, g, f) STORE(WAVE.terms, lane, WaveTerms(d, g, f))
#define PUSH_RAY(lane, ray) push_ray(lane, ray)
// Bad samples are counted on the CPU alone.
#define NOTE_LIT(lane, light)
#define NOTE_FOUND(lane, path, light, place, id)
#define NOTE_SCATTER(lane, path, b)

void note_shadow(uint lane, float arrived, float sent) {
  WAVE.records.v[lane].lit += arrived;
  WAVE.records.v[lane].unshadowed += sent;
}

void note_features(uint lane, vec3 albedo, vec3 normal) {
  WAVE.records.v[lane].feature_albedo += albedo;
  WAVE.records.v[lane].feature_normal += normal;
}

void note_surface(uint lane, FirstSurface first) {
  WaveRecord r = LOAD(WAVE.records, lane);
  r.hit = 1.0f;
  r.distance2 = first.distance2;
  r.depth = first.depth;
  r.position = first.position;
  r.object_index = first.object_index;
  r.material_index = first.material_index;
  r.normal = first.normal;
  r.uv = first.uv;
  r.uv_coverage = first.uv_coverage;
  r.diffuse_color = first.diffuse_color;
  STORE(WAVE.records, lane, r);
}

// Rays wait on a stack, so that the deepest comes first.
void push_ray(uint lane, PendingRay ray) {
  const uint place = WAVE.trees.v[lane].pending;
  STORE(WAVE.pending, place * WAVE.lanes + lane, ray);
  WAVE.trees.v[lane].pending = place + 1u;
}
