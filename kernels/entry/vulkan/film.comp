// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 7: one invocation a pixel adds its finished samples to the film, one after the other, in their order.
// The host adds the film's sums to those that it keeps (native/film.h).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"
#include "stage/arrive.h"

void add_record(uint pixel, WaveRecord r) {
  WaveRecord sum = LOAD(WAVE.film_records, pixel);
  if (r.hit > 0.0f && (sum.hit == 0.0f || r.distance2 < sum.distance2)) {
    sum.distance2 = r.distance2;
    sum.depth = film_number(r.depth);
    sum.position = film_vector(r.position);
    sum.object_index = r.object_index;
    sum.material_index = r.material_index;
  }
  sum.hit += r.hit;
  sum.normal += film_vector(r.normal);
  sum.uv += vec2(film_number(r.uv.x), film_number(r.uv.y));
  sum.uv_coverage += r.uv_coverage;
  sum.diffuse_color += film_vector(r.diffuse_color);
  sum.emission += film_vector(r.emission);
  sum.environment += film_vector(r.environment);
  sum.lit += film_number(r.lit);
  sum.unshadowed += film_number(r.unshadowed);
  sum.occlusion += r.occlusion;
  sum.feature_albedo += film_vector(r.feature_albedo);
  sum.feature_normal += film_vector(r.feature_normal);
  STORE(WAVE.film_records, pixel, sum);
}

void add_terms(uint pixel, WaveTerms terms) {
  WAVE.film_terms.v[pixel].d += film_number(terms.d);
  WAVE.film_terms.v[pixel].g += film_number(terms.g);
  WAVE.film_terms.v[pixel].f += film_vector(terms.f);
}

void add_bright(uint pixel, vec3 radiance) {
  const vec3 light = film_vector(radiance);
  const float size = brightness(light);
  if (size <= JOB.white) return;
  for (uint c = 0u; c < BRIGHT_CASCADES; ++c) {
    BrightSum sum = LOAD(WAVE.film_bright, pixel * BRIGHT_CASCADES + c);
    bright_add(sum, light, size, c, JOB.white);
    STORE(WAVE.film_bright, pixel * BRIGHT_CASCADES + c, sum);
  }
}

// Adds a sample to what this pixel's samples count for those around it.
void share(uint pixel, vec2 offset, vec3 radiance, float alpha) {
  FloatBuffer table = WAVE.scene.filter_table;
  SampleShares shares;
  sample_shares(table, JOB.camera.filter_radius, offset, LOAD(WAVE.pixels, pixel).sampled, shares);
  const uint first = pixel * SHARING_WINDOW + shares.first;
  for (uint k = 0u; k < SHARING_PIXELS; ++k) {
    const uint place = first + k / 3u * SHARING_SIDE + k % 3u;
    SharedSum sum = LOAD(WAVE.film_shares, place);
    shared_add(sum, radiance, alpha, shares.weights[k]);
    STORE(WAVE.film_shares, place, sum);
  }
}

void main() {
  const uint index = gl_GlobalInvocationID.x;
  if (index >= push.pixel_count) return;
  const uint pixel = push.first_pixel + index;
  FilmPixel sum = LOAD(WAVE.film, pixel);
  for (uint k = 0u; k < push.sample_count; ++k) {
    const uint lane = index * push.sample_count + k;
    if (FEATURE(FEATURE_TOON) && JOB.outlines != 0u) draw_line(lane, LOAD(WAVE.outline_sums, lane));
    const FilmPixel s = LOAD(WAVE.samples, lane);
    vec3 radiance = s.radiance;
    const bool finite = film_add(sum, radiance, s.alpha);
    if (!finite) atomicAdd(WAVE.counters.v[WAVE_REJECTED], 1u);
    if (FEATURE(FEATURE_SHARING)) share(pixel, FILTER_OFFSET(lane), radiance, film_number(s.alpha));
    if (FEATURE(FEATURE_REWEIGHTING)) add_bright(pixel, radiance);
    if (FEATURE(FEATURE_DATA_PASSES)) add_record(pixel, LOAD(WAVE.records, lane));
    if (FEATURE(FEATURE_LIGHT_GROUPS) && finite) {
      for (uint g = 0u; g < JOB.light_groups; ++g) {
        WAVE.film_groups.v[pixel * JOB.light_groups + g] += film_vector(GROUP_LIGHT(lane, g));
      }
    }
    if (FEATURE(FEATURE_TERMS) && FLAG(JOB_TERMS_PASS)) add_terms(pixel, LOAD(WAVE.terms, lane));
    if (FEATURE(FEATURE_TERMS) && finite) {
      for (uint l = 0u; l < JOB.lamp_passes; ++l) {
        WAVE.film_lamps.v[pixel * JOB.lamp_passes + l] += film_vector(LAMP_LIGHT(lane, l));
      }
    }
  }
  STORE(WAVE.film, pixel, sum);
}
