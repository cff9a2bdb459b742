// SPDX-License-Identifier: GPL-3.0-or-later
// Where pixels share samples: one invocation a pixel sums up what its neighbours' samples, which film.comp has sorted
// by pixel, count for it. Once for all samples of a pass.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"

void main() {
  const uint pixel = gl_GlobalInvocationID.x;
  if (!FEATURE(FEATURE_SHARING) || pixel >= push.pixel_count) return;
  const WavePixel p = LOAD(WAVE.pixels, pixel);
  const int side = int(SHARING_SIDE);
  SharedSum sum;
  sum.film.radiance = vec3(0.0f);
  sum.film.alpha = 0.0f;
  sum.weight = 0.0f;
  for (int k = 0; k < side * side; ++k) {
    if (((p.sampled >> uint(k)) & 1u) == 0u) continue;
    // Seen from that pixel, this one is as far on the other side.
    const int place = int(p.place) + (k / side - side / 2) * int(WAVE.tile_side) + k % side - side / 2;
    const uint from = LOAD(WAVE.film_places, place) * SHARING_WINDOW + SHARING_WINDOW - 1u - uint(k);
    const SharedSum part = LOAD(WAVE.film_shares, from);
    sum.film.radiance += part.film.radiance;
    sum.film.alpha += part.film.alpha;
    sum.weight += part.weight;
  }
  STORE(WAVE.film_shared, pixel, sum);
}
