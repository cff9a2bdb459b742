// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 3: what each ray met: lamps, the background, or a surface, whose emission is added and whose BSDF is prepared.
// Lanes at a surface that may be lit go into the shading queue.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PROGRAM_RAYS  // programs trace rays here
#include "stage.glsl"
#include "trace.glsl"
#include "whitted.glsl"

void meet_lights(uint lane, PathState path, CameraRay ray, float t) {
  for (uint l = 0u; l < WAVE.scene.light_count; ++l) {
    int group;
    const vec3 seen = path_meet_light(WAVE.scene, l, path, ray.origin, ray.direction, t, group);
    if (is_black(seen)) continue;
    add_light(lane, seen, group);
    if (FEATURE(FEATURE_DATA_PASSES) && path.bounce == 0u) WAVE.records.v[lane].emission += seen;
  }
}

void escape(uint lane, PathState path, vec3 direction) {
  if (FEATURE(FEATURE_WORLD)) {
    const vec3 world = path_escape(WAVE.scene, path, direction);
    if (FEATURE(FEATURE_DATA_PASSES) && path.bounce == 0u) WAVE.records.v[lane].environment += world;
    if (path.bounce > 0u || !flag(WAVE_TRANSPARENT)) add_light(lane, world, WAVE.scene.world_group);
  }
  if (path.bounce == 0u) WAVE.samples.v[lane].alpha = 0.0f;
}

// Passes that describe the first surface.
void record(uint lane, Surface s, Material material, vec3 diffuse) {
  WaveRecord r = LOAD(WAVE.records, lane);
  const vec2 offset = WAVE.samples.v[lane].offset;
  const Instance instance = LOAD(WAVE.scene.instances, s.instance);
  r.hit = 1.0f;
  r.distance2 = sqr(offset.x) + sqr(offset.y);
  r.depth = camera_depth(WAVE.camera, s.p);
  r.position = s.p;
  r.object_index = float(instance.pass_index);
  r.material_index = float(material.pass_index);
  r.normal = s.n;
  r.uv = surface_uv(WAVE.scene, s);
  r.uv_coverage = (LOAD(WAVE.scene.meshes, instance.mesh).flags & MESH_HAS_UV) != 0u ? 1.0f : 0.0f;
  r.diffuse_color = diffuse;
  STORE(WAVE.records, lane, r);
}

void record_terms(uint lane, Surface s, Bsdf bsdf, vec3 wo) {
  WaveTerms terms;
  lamp_terms(WAVE.scene, s.p, bsdf, wo, terms.d, terms.g, terms.f);
  STORE(WAVE.terms, lane, terms);
}

// Ambient light: all of it, or as the contribution of the ray to the sky, which wave_light.comp completes.
void ambient(uint lane, PathState path, uint material_id, Material material) {
  const vec3 light = path.throughput * ambient_term(material, LOAD(WAVE.scene.classic, material_id), WAVE.ambient);
  if (flag(WAVE_AMBIENT_OCCLUDED)) {
    WAVE.shadow_rays.v[push.sky_slot * WAVE.lanes + lane].contribution = light;
  } else {
    add_light(lane, light, -1);
  }
}

// Does the lane stand at a surface that may be lit? What the ray met there and on its way is added.
bool shade(uint lane) {
  const CameraRay ray = LOAD(WAVE.rays, lane);
  PathState path = LOAD(WAVE.paths, lane);
  const Hit hit = LOAD(WAVE.hits, lane);
  if (FEATURE(FEATURE_TRANSPARENCY)) {
    if (hit.t == HIT_ENDED) return false;
    path.transparent_bounces += hit.crossed;
    WAVE.paths.v[lane].transparent_bounces = path.transparent_bounces;
  }
  if (FEATURE(FEATURE_WHITTED)) absorb(lane, hit.t, path);
  const bool missed = hit.instance == INVALID_ID;
  const bool meets = path.bounce > 0u ? FEATURE(FEATURE_BSDF_RAYS) : flag(WAVE_CAMERA_MEETS_LIGHTS);
  if (FEATURE(FEATURE_VISIBLE_LIGHTS) && meets) {
    meet_lights(lane, path, ray, missed ? INFINITE_DISTANCE : hit.t);
  }
  if (missed) {
    escape(lane, path, ray.direction);
    return false;
  }
  Surface s;
  surface_from_hit(WAVE.scene, hit, ray.direction, s);
  Material material = LOAD(WAVE.scene.materials, s.material);
  if (FEATURE(FEATURE_EMISSIVE_MESHES) && (material.flags & MATERIAL_EMISSIVE) != 0u) {
    const vec3 emitted = path_emission(WAVE.scene, path, s, material, -ray.direction, hit.t);
    add_light(lane, emitted, WAVE.scene.instances.v[hit.instance].light_group);
    if (FEATURE(FEATURE_DATA_PASSES) && path.bounce == 0u) WAVE.records.v[lane].emission += emitted;
  }
  if (path_is_last(WAVE.integrator, path)) return false;  // it only brought light home
  // Neither Toon nor a picture of the sky asks what the surface does with light.
  const bool lit = !FEATURE(FEATURE_TOON) && !(FEATURE(FEATURE_OCCLUSION) && flag(WAVE_OCCLUSION_PICTURE));
  Bsdf bsdf;
  Lobe lobe;
  vec3 weight = vec3(1.0f);
  if (FEATURE(FEATURE_PROGRAMS | FEATURE_LOBES)) {
    const float u = vertex_random(path, pixel_of(lane).block_seed, PAIR_CLOSURE).x;
    const ShaderPoint at = path_point(WAVE.scene, path, s, -ray.direction, hit.t);
    SurfaceShading shading;
    surface_shading(WAVE.scene, at, u, s, shading, bsdf, lobe);
    material = shading.material;
    weight = shading.weight;
    path.throughput = path.throughput * weight;
    WAVE.paths.v[lane].throughput = path.throughput;
  } else if (lit || FEATURE(FEATURE_DATA_PASSES | FEATURE_TERMS)) {
    bsdf_prepare(WAVE.scene, material, s.n, s.ng, -ray.direction, bsdf);
  }
  if (FEATURE(FEATURE_WHITTED)) whitted_prepare(material, LOAD(WAVE.scene.classic, s.material), bsdf);
  if (FEATURE(FEATURE_DATA_PASSES) && path.bounce == 0u) record(lane, s, material, bsdf.diffuse * weight * PI);
  if (FEATURE(FEATURE_TERMS) && flag(WAVE_TERMS_PASS) && path.bounce == 0u) {
    record_terms(lane, s, bsdf, -ray.direction);
  }
  if (FEATURE(FEATURE_OCCLUSION) && flag(WAVE_AMBIENT)) ambient(lane, path, s.material, material);
  if (FEATURE(FEATURE_TOON)) STORE(WAVE.base_colors, lane, material.base_color);
  STORE(WAVE.surfaces, lane, s);
  if (lit) STORE(WAVE.bsdfs, lane, bsdf);
  if (FEATURE(FEATURE_LOBES) && lit) STORE(WAVE.lobes, lane, lobe);
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
