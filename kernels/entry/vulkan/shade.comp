// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 3: what each ray met: lamps, the background, or a surface, whose emission is added and whose BSDF is prepared.
// Lanes at a surface that may be lit go into the shading queue.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PROGRAM_RAYS  // programs trace rays here
#include "lane.glsl"
#include "trace.glsl"
#include "whitted.glsl"
#include "stage/meet.h"
#include "stage/recursion.h"
#include "stand.glsl"

// Does the lane stand at a surface that may be lit? What the ray met there and on its way is added.
bool shade(uint lane) {
  const CameraRay ray = LOAD(WAVE.rays, lane);
  PathState path = load_path(lane);
  const Hit hit = LOAD(WAVE.hits, lane);
  if (FEATURE(FEATURE_TRANSPARENCY)) {
    if (hit.t == HIT_ENDED) return false;
    path.transparent_bounces += hit.crossed;
    STORE(WAVE.path_transparent_bounces, lane, path.transparent_bounces);
  }
  if (FEATURE(FEATURE_WHITTED)) {
    absorb(lane, hit.t, path);
    STORE(WAVE.path_throughput, lane, path.throughput);
  }
  if (!meet(lane, path, ray.origin, ray.direction, hit)) return false;
  Surface s;
  surface_from_hit(SCENE, hit, ray.direction, s);
  Material material = LOAD(SCENE.materials, s.material);
  if (FEATURE(FEATURE_EMISSIVE_MESHES)) add_emission(lane, path, s, material, ray.direction);
  if (path_is_last(JOB.integrator, path)) return false;  // it only brought light home
  Bsdf bsdf;
  Lobe lobe;
  vec3 weight = vec3(1.0f);
  if (DRAWN) {
    const float u = vertex_random(path, pixel_of(lane).block_seed, PAIR_CLOSURE).x;
    const ShaderPoint at = path_point(SCENE, path, s, -ray.direction, hit.t);
    SurfaceShading shading;
    surface_shading(SCENE, at, u, s, shading, bsdf, lobe);
    material = shading.material;
    weight = shading.weight;
    path.throughput = path.throughput * weight;
    STORE(WAVE.path_throughput, lane, path.throughput);
    STORE(WAVE.normals, lane, s.n);
  } else if (SCATTERS || FEATURE(FEATURE_DATA_PASSES | FEATURE_TERMS)) {
    scattering_of(path, material, s, -ray.direction, bsdf, lobe);
  }
  if (DRAWN && SCATTERS) path_filter_glossy(JOB.integrator, path, bsdf, lobe);
  if (DRAWN && FEATURE(FEATURE_WHITTED)) whitted_prepare(material, LOAD(SCENE.classic, s.material), bsdf);
  if (FEATURE(FEATURE_DATA_PASSES)) {
    show_features(lane, path, bsdf, lobe, -ray.direction);
    if (GOES_ON) STORE(WAVE.path_ray_kind, lane, path.ray_kind);
  }
  describe(lane, path, s, material, weight, bsdf, lobe, -ray.direction);
  if (FEATURE(FEATURE_OCCLUSION) && FLAG(JOB_AMBIENT)) {
    const vec3 light = ambient_light(lane, path, s.material, material);
    if (FLAG(JOB_AMBIENT_OCCLUDED)) {  // light.comp completes the ray to the sky
      STORE(WAVE.shadow_contribution, push.sky_slot * WAVE.lanes + lane, light);
    } else {
      add_light(lane, light, -1);
    }
  }
  if (FEATURE(FEATURE_TOON)) STORE(WAVE.base_colors, lane, material.base_color);
  if (DRAWN && SCATTERS) store_scattering(lane, bsdf, lobe);
  if (FEATURE(FEATURE_WHITTED)) push_children(lane, path, s, material, bsdf, -ray.direction);
  return true;
}

void main() {
  if (beyond(WAVE_RAYS)) return;
  const uint lane = LOAD(WAVE.rays_queue, gl_GlobalInvocationID.x);
  bool goes_on = shade(lane);
  if (FEATURE(FEATURE_WHITTED)) goes_on = goes_on || WAVE.trees.v[lane].pending > 0u;
  if (goes_on) STORE(WAVE.shading_queue, append(WAVE_SHADING), lane);
}
