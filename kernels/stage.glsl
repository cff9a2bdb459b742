// SPDX-License-Identifier: GPL-3.0-or-later
// What every stage of the GPU's wavefront begins with: extensions, features, what the dispatch was told, queues.
// Stages are GLSL alone; what they compute by stands in the headers that both languages share.
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

bool flag(uint bit) { return (WAVE.flags & bit) != 0u; }

// Is this invocation beyond the lanes of a queue?
bool beyond(uint queue) { return gl_GlobalInvocationID.x >= LOAD(WAVE.counters, WAVE_COUNTS + queue); }

// A new place at the end of a queue. The order of lanes in it differs from run to run; nothing depends on it.
uint append(uint queue) { return atomicAdd(WAVE.counters.v[WAVE_COUNTS + queue], 1u); }

WavePixel pixel_of(uint lane) { return LOAD(WAVE.pixels, push.first_pixel + lane / push.sample_count); }

// Random pair `pair` of the vertex that the path stands at.
vec2 vertex_random(PathState path, uint block_seed, uint pair) {
  return sampler_pair(path.random, sampler_pair_seed(block_seed, vertex_pair(path.vertex, pair)));
}

// Only one invocation at a time works on a lane, so that sums need no atomics and come in one order.
void add_light(uint lane, vec3 value, int group) {
  WAVE.samples.v[lane].radiance += value;
  if (FEATURE(FEATURE_TERMS)) {
    const int lamp = light_pass(group);
    if (lamp >= 0 && lamp < int(WAVE.lamp_passes)) WAVE.lamps.v[lane * WAVE.lamp_passes + uint(lamp)] += value;
    group = light_group(group);
  }
  if (FEATURE(FEATURE_LIGHT_GROUPS) && group >= 0 && group < int(WAVE.light_groups)) {
    WAVE.groups.v[lane * WAVE.light_groups + uint(group)] += value;
  }
}
