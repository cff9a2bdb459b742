// SPDX-License-Identifier: GPL-3.0-or-later
// Between stages: one invocation turns the length of a queue into the size of the dispatch over it, and empties the
// queue that this dispatch will fill. It touches no lane.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"

void main() {
  if (gl_GlobalInvocationID.x != 0u) return;
  const uint count = LOAD(WAVE.counters, WAVE_COUNTS + push.queue);
  STORE(WAVE.counters, 3u * push.queue, (count + WAVE_GROUP_SIZE - 1u) / WAVE_GROUP_SIZE);
  STORE(WAVE.counters, 3u * push.queue + 1u, 1u);
  STORE(WAVE.counters, 3u * push.queue + 2u, 1u);
  const uint next = push.queue == WAVE_RAYS ? WAVE_SHADING : (push.queue == WAVE_SHADING ? WAVE_SHADOWS : WAVE_RAYS);
  STORE(WAVE.counters, WAVE_COUNTS + next, 0u);
  if (push.queue == WAVE_RAYS && push.bounce > 0u) WAVE.counters.v[WAVE_BOUNCE_RAYS] += count;
  if (push.queue == WAVE_SHADOWS) WAVE.counters.v[WAVE_SHADOW_RAYS] += count;
}
