// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 1: the camera rays of new samples. Lane i takes sample i % sample_count of pixel i / sample_count.
// What they meet is found by trace.comp.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lane.glsl"
#include "whitted.glsl"

void clear_record(uint lane) {
  WaveRecord r;
  r.position = vec3(0.0f);
  r.depth = 0.0f;
  r.object_index = 0.0f;
  r.material_index = 0.0f;
  r.distance2 = 0.0f;
  r.hit = 0.0f;
  r.normal = vec3(0.0f);
  r.uv_coverage = 0.0f;
  r.diffuse_color = vec3(0.0f);
  r.lit = 0.0f;
  r.emission = vec3(0.0f);
  r.unshadowed = 0.0f;
  r.environment = vec3(0.0f);
  r.occlusion = 0.0f;
  r.uv = vec2(0.0f);
  r.feature_albedo = vec3(0.0f);
  r.feature_normal = vec3(0.0f);
  STORE(WAVE.records, lane, r);
}

void clear_terms(uint lane) {
  WaveTerms terms;
  terms.d = 0.0f;
  terms.g = 0.0f;
  terms.f = vec3(0.0f);
  if (FLAG(JOB_TERMS_PASS)) STORE(WAVE.terms, lane, terms);
  for (uint l = 0u; l < JOB.lamp_passes; ++l) LAMP_LIGHT(lane, l) = vec3(0.0f);
}

void main() {
  const uint lane = gl_GlobalInvocationID.x;
  if (beyond(WAVE_RAYS)) return;
  const WavePixel pixel = pixel_of(lane);
  const uint sample_number = push.first_sample + lane % push.sample_count;
  const uint random = sampler_index(pixel.x, pixel.y, sample_number, WAVE.sample_bits);
  const vec2 u = sampler_pair(random, sampler_pair_seed(pixel.block_seed, PAIR_FILTER));
  const CameraData camera = JOB.camera;
  FloatBuffer filter_table = WAVE.scene.filter_table;
  const vec2 offset = vec2(filter_sample(filter_table, u.x), filter_sample(filter_table, u.y)) * camera.filter_radius;
  CameraRay ray;
  camera_ray(camera, float(pixel.x) + 0.5f + offset.x, float(pixel.y) + 0.5f + offset.y, ray);
  PathState path;
  path_begin(random, path);
  RADIANCE(lane) = vec3(0.0f);
  ALPHA(lane) = 1.0f;
  if (FEATURE(FEATURE_DATA_PASSES | FEATURE_TOON | FEATURE_SHARING)) FILTER_OFFSET(lane) = offset;
  STORE(WAVE.rays, lane, ray);
  store_path(lane, path);
  STORE(WAVE.rays_queue, lane, lane);
  if (FEATURE(FEATURE_WHITTED)) plant_tree(lane);
  if (FEATURE(FEATURE_DATA_PASSES)) clear_record(lane);
  if (FEATURE(FEATURE_TERMS)) clear_terms(lane);
  if (FEATURE(FEATURE_LIGHT_GROUPS)) {
    for (uint g = 0u; g < JOB.light_groups; ++g) GROUP_LIGHT(lane, g) = vec3(0.0f);
  }
}
