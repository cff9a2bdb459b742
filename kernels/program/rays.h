// SPDX-License-Identifier: GPL-3.0-or-later
// The ops that trace rays from the shading point: ambient occlusion, bevel, ray cast. How a ray is traced is the
// device's; where none may be (ShaderPoint.rays is 0), all is open and edges are sharp, as in Cycles.
#ifndef COTORRA_PROGRAM_RAYS_H
#define COTORRA_PROGRAM_RAYS_H

#include "../sampling.h"
#include "normal_map.h"
#include "pure.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// A ray from the point, what it may meet, and which surfaces it passes.
struct ProgramRay {
  vec3 origin;
  float t_min;  // excluded, as is t_max
  vec3 direction;
  float t_max;
  uint visibility;
  uint passes;    // RAY_ONLY_LOCAL and RAY_SKIPS_OWN
  uint instance;  // of the point
  uint triangle;
};
const uint RAY_ONLY_LOCAL = 1u;  // it passes other objects
const uint RAY_SKIPS_OWN = 2u;   // it passes the triangle that it starts on

FN ProgramRay program_ray(IN(ShaderPoint) at, vec3 origin, vec3 direction, float t_max, uint visibility, uint passes) {
  ProgramRay ray;
  ray.origin = origin;
  ray.t_min = 0.0f;
  ray.direction = direction;
  ray.t_max = t_max;
  ray.visibility = visibility;
  ray.passes = passes;
  ray.instance = at.instance;
  ray.triangle = at.triangle;
  return ray;
}

// The nearest surface that the ray meets and does not pass. In GLSL a stage that traces for programs defines
// PROGRAM_RAYS before, and includes trace.glsl behind; others meet nothing.
#ifdef __cplusplus
struct RayTracer {
  bool (*trace)(const RayTracer &tracer, const ProgramRay &ray, Hit &hit);
};
FN bool program_trace(IN(SceneData) scene, IN(ProgramRay) ray, OUT(Hit) hit) {
  const RayTracer *tracer = scene.tracer.v;
  return tracer != nullptr && tracer->trace(*tracer, ray, hit);
}
#elif defined(PROGRAM_RAYS)
const uint RAY_STEPS = 64u;  // surfaces that a ray passes at most

bool trace(vec3 origin, vec3 direction, float t_min, float t_max, uint visibility, bool any, uvec2 left, out Hit hit);

bool program_trace(SceneData scene, ProgramRay ray, out Hit hit) {
  const bool local = (ray.passes & RAY_ONLY_LOCAL) != 0u;
  const uvec2 passes = local ? uvec2(ray.instance, LEFT_ALL_OTHERS) : uvec2(INVALID_ID, INVALID_ID);
  for (uint k = 0u; k < RAY_STEPS; ++k) {
    if (!trace(ray.origin, ray.direction, ray.t_min, ray.t_max, ray.visibility, false, passes, hit)) return false;
    const bool own = hit.instance == ray.instance && hit.triangle == ray.triangle;
    if (!own || (ray.passes & RAY_SKIPS_OWN) == 0u) return true;
    ray.t_min = hit.t;
  }
  return false;
}
#else
bool program_trace(SceneData scene, ProgramRay ray, out Hit hit) { return false; }
#endif

// The seed of an op's random pairs at the point; two kinds of op never share theirs.
FN uint ray_seed(IN(ShaderPoint) at, uint op) { return hash_combine(at.rays, op); }

// Most rays of an evaluation, as Blender has it.
const uint RAY_SAMPLES_MAX = 128u;

// How many bits of a sampler index count `samples` rays an evaluation.
FN uint ray_bits(uint samples) { return uint(findMSB(max(samples, 1u) - 1u) + 1); }

// Pair `ray` of an evaluation: those of all evaluations of a pixel and its neighbours are one stratified set.
FN vec2 ray_pair(IN(ShaderPoint) at, uint seed, uint ray, uint bits) {
  return sampler_pair((at.random >> bits) | bitfieldReverse(ray), seed);
}

// ---- Ambient occlusion: the share of rays, cosine-distributed about the normal, that meet nothing within a distance.

const uint AO_INSIDE = 1u;
const uint AO_ONLY_LOCAL = 2u;
const uint AO_SAMPLES_SHIFT = 8u;

FN float ambient_occlusion(IN(SceneData) scene, IN(ShaderPoint) at, uint mode, float distance, vec3 normal) {
  const uint samples = min(mode >> AO_SAMPLES_SHIFT, RAY_SAMPLES_MAX);
  if (at.rays == 0u || samples == 0u || !(distance > 0.0f)) return 1.0f;
  const vec3 n = normalize_or(normal, at.n) * select((mode & AO_INSIDE) != 0u, -1.0f, 1.0f);
  const bool local = (mode & AO_ONLY_LOCAL) != 0u;
  const uint passes = RAY_SKIPS_OWN | select(local, RAY_ONLY_LOCAL, 0u);
  const uint visibility = select(local, VISIBLE_ANYHOW, VISIBLE_SHADOW);
  vec3 t;
  vec3 b;
  orthonormal_basis(n, t, b);
  const uint seed = ray_seed(at, OP_AO);
  const uint bits = ray_bits(samples);
  float open = 0.0f;
  for (uint i = 0u; i < samples; ++i) {
    const vec3 d = to_world(cosine_hemisphere_from_square(ray_pair(at, seed, i, bits)), t, b, n);
    Hit hit;
    if (!program_trace(scene, program_ray(at, at.p, d, distance, visibility, passes), hit)) open += 1.0f;
  }
  return open / float(int(samples));
}

// ---- Bevel: the mean normal of the object's surface around the point. Points of the surface are found along the three
// axes of a frame at the point, and weighed by how well each axis finds them (King et al. 2013, "BSSRDF Importance
// Sampling"). Their distances r from the point have the density 10 (R - r)^3 / (pi R^5) on a disk.

const uint BEVEL_GIVEN_NORMAL = 1u;  // the normal is not the surface's own, and is bent likewise
const uint BEVEL_SAMPLES_SHIFT = 8u;
const uint BEVEL_SURFACES = 16u;  // along one ray, at most

// The share x of the radius within which a share u of the density lies: 10 x^2 - 20 x^3 + 15 x^4 - 4 x^5 = u, by
// Newton's method. About 0 the left side is 10 x^2, about 1 it is 1 - 5 (1 - x)^4.
FN float bevel_radius(float u) {
  float x = u < 0.5f ? sqrt(u * 0.1f) : 1.0f - sqrt(sqrt((1.0f - u) * 0.2f));
  for (uint i = 0u; i < 6u; ++i) {
    const float rest = 1.0f - x;
    const float slope = 20.0f * x * rest * rest * rest;
    const float wrong = x * x * (10.0f - x * (20.0f - x * (15.0f - 4.0f * x))) - u;
    x = clamp(x - wrong / max(slope, 1e-6f), 0.0f, 1.0f);
  }
  return x;
}

// The sum of the normals that one ray finds, each with its weight. `axis`: 0 for the normal's, 1 and 2.
FN vec3 bevel_ray(IN(SceneData) scene, IN(ShaderPoint) at, uint axis, vec2 u, float radius) {
  vec3 t;
  vec3 b;
  orthonormal_basis(at.ng, t, b);
  const vec3 along = axis == 0u ? at.ng : (axis == 1u ? t : b);
  const vec3 x = axis == 1u ? at.ng : t;
  const vec3 y = axis == 2u ? at.ng : b;
  const float phi = 2.0f * PI * u.x;
  const float r = bevel_radius(u.y) * radius;
  const float height = sqrt(max(radius * radius - r * r, 0.0f));
  const vec3 origin = at.p + (x * cos(phi) + y * sin(phi)) * r + along * height;
  const float rest = (radius - r) / radius;
  vec3 sum = vec3(0.0f);
  ProgramRay ray = program_ray(at, origin, -along, 2.0f * height, VISIBLE_ANYHOW, RAY_ONLY_LOCAL);
  for (uint k = 0u; k < BEVEL_SURFACES && rest > 0.0f; ++k) {
    Hit hit;
    if (!program_trace(scene, ray, hit)) break;
    ray.t_min = hit.t;
    Surface s;
    surface_from_hit(scene, hit, -along, s);
    // With which density each axis would have found it, but for the disk's.
    const float pdf_n = 0.5f * abs(dot(at.ng, s.ng));
    const float pdf_t = 0.25f * abs(dot(t, s.ng));
    const float pdf_b = 0.25f * abs(dot(b, s.ng));
    const float pdf = axis == 0u ? pdf_n : (axis == 1u ? pdf_t : pdf_b);
    const float far = max(radius - length(s.p - at.p), 0.0f) / (radius * rest);
    const float weight = pdf / max(pdf_n * pdf_n + pdf_t * pdf_t + pdf_b * pdf_b, 1e-12f) * far * far * far;
    sum += s.n * (s.side * weight);
  }
  return sum;
}

FN vec3 bevel(IN(SceneData) scene, IN(ShaderPoint) at, uint mode, float radius, vec3 normal) {
  const uint samples = min(mode >> BEVEL_SAMPLES_SHIFT, RAY_SAMPLES_MAX);
  // Rays that left something rough see edges sharp: nobody would tell (Cycles).
  const bool sharp = (at.ray_kind & RAY_BLURRED) != 0u;
  if (at.rays == 0u || samples == 0u || !(radius > 0.0f) || sharp) return normal;
  const uint seed = ray_seed(at, OP_BEVEL);
  const uint bits = ray_bits(samples);
  vec3 sum = vec3(0.0f);
  for (uint i = 0u; i < samples; ++i) {
    vec2 u = ray_pair(at, seed, i, bits);
    const uint axis = u.x < 0.5f ? 0u : (u.x < 0.75f ? 1u : 2u);
    u.x = axis == 0u ? 2.0f * u.x : 4.0f * u.x - (axis == 1u ? 2.0f : 3.0f);
    sum += bevel_ray(scene, at, axis, u, radius);
  }
  const vec3 bent = normalize_or(sum * at.side, at.n);
  if ((mode & BEVEL_GIVEN_NORMAL) == 0u) return bent;
  return normalize_or(normal + (bent - at.n), normal);
}

// ---- Ray cast: what a ray from `origin` meets. Lengths count in that of `direction`.

const uint RAYCAST_ONLY_LOCAL = 0x10000u;

FN bool raycast_trace(IN(SceneData) scene, IN(ShaderPoint) at, uint mode, vec3 origin, vec3 direction, float t_max,
                      OUT(Hit) hit) {
  const float length2 = dot(direction, direction);
  if (at.rays == 0u || !(t_max > 0.0f) || !(length2 > 0.0f && length2 < INFINITE_DISTANCE)) return false;
  const bool local = (mode & RAYCAST_ONLY_LOCAL) != 0u;
  const bool shifted = (mode >> 30) != SHIFT_NONE;
  const bool here = !shifted && origin.x == at.p.x && origin.y == at.p.y && origin.z == at.p.z;
  const uint passes = select(local, RAY_ONLY_LOCAL, 0u) | select(here, RAY_SKIPS_OWN, 0u);
  ProgramRay ray = program_ray(at, origin, direction, t_max, select(local, VISIBLE_ANYHOW, VISIBLE_RAYCAST), passes);
  // A ray from a point one step aside may start behind the surface: it begins beyond that step.
  if (shifted) ray.t_min = 1.1f * mode_share(mode & 0xffffu) * at.footprint;
  return program_trace(scene, ray, hit);
}

// 1 where it meets something, 1 where that is the object itself, the distance.
FN vec3 raycast(IN(SceneData) scene, IN(ShaderPoint) at, uint mode, vec3 origin, vec3 direction, float t_max) {
  Hit hit;
  if (!raycast_trace(scene, at, mode, origin, direction, t_max, hit)) return vec3(0.0f, 0.0f, t_max);
  return vec3(1.0f, select(hit.instance == at.instance, 1.0f, 0.0f), hit.t);
}

FN vec3 raycast_normal(IN(SceneData) scene, IN(ShaderPoint) at, uint mode, vec3 origin, vec3 direction, float t_max) {
  Hit hit;
  if (!raycast_trace(scene, at, mode, origin, direction, t_max, hit)) return vec3(0.0f);
  Surface s;
  surface_from_hit(scene, hit, direction, s);
  return s.n;
}

// ---- All of them

FN vec3 program_rays(IN(SceneData) scene, IN(ShaderPoint) at, uint op, uint mode, IN(ProgramArguments) a) {
  if (op == OP_AO) return vec3(ambient_occlusion(scene, at, mode, a.v[0], argument3(a, 1)));
  if (op == OP_BEVEL) return bevel(scene, at, mode, a.v[0], argument3(a, 1));
  const vec3 origin = argument3(a, 0);
  const vec3 direction = argument3(a, 3);
  if (op == OP_RAYCAST) return raycast(scene, at, mode, origin, direction, a.v[6]);
  return raycast_normal(scene, at, mode, origin, direction, a.v[6]);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
