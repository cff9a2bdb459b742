// SPDX-License-Identifier: GPL-3.0-or-later
// Loads and stores what is kept by lane between stages, member by member, as state.inc lists it. What is not needed is
// neither loaded nor stored. Each function takes one kind of entry from the list and passes over the others.

// What state.inc asks by; native/vulkan_wavefront.cpp knows the same.
#define ASKED(FEATURES) FEATURE(FEATURES)
#define GOES_ON FEATURE(FEATURE_BOUNCES | FEATURE_BSDF_RAYS | FEATURE_WHITTED)
#define DRAWN FEATURE(FEATURE_PROGRAMS | FEATURE_LOBES)
#define SCATTERS (!FEATURE(FEATURE_TOON) && !(FEATURE(FEATURE_OCCLUSION) && FLAG(JOB_OCCLUSION_PICTURE)))
#define LIGHT_KINDS (SCENE.light_kinds != 0u)

#define LANE_STATE(TYPE, BUFFER, NAME, EACH, NEEDED)
#define SHADOW_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT)
#define BSDF_STATE(TYPE, BUFFER, MEMBER, NEEDED)
#define LOBE_STATE(MEMBER, PLACE)

PathState load_path(uint lane) {
  PathState path;
#define PATH_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT) \
  path.MEMBER = ABSENT;                                  \
  if (NEEDED) path.MEMBER = LOAD(WAVE.path_##MEMBER, lane);
#include "state.inc"
#undef PATH_STATE
  return path;
}

void store_path(uint lane, PathState path) {
#define PATH_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT) \
  if (NEEDED) STORE(WAVE.path_##MEMBER, lane, path.MEMBER);
#include "state.inc"
#undef PATH_STATE
}

#define PATH_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT)
#undef SHADOW_STATE

// By light slot x lanes + lane.
ShadowRay load_shadow(uint place) {
  ShadowRay ray;
#define SHADOW_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT) \
  ray.MEMBER = ABSENT;                                     \
  if (NEEDED) ray.MEMBER = LOAD(WAVE.shadow_##MEMBER, place);
#include "state.inc"
#undef SHADOW_STATE
  return ray;
}

void store_shadow(uint place, ShadowRay ray) {
#define SHADOW_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT) \
  if (NEEDED) STORE(WAVE.shadow_##MEMBER, place, ray.MEMBER);
#include "state.inc"
#undef SHADOW_STATE
}

#define SHADOW_STATE(TYPE, BUFFER, MEMBER, NEEDED, ABSENT)
#undef BSDF_STATE
#undef LOBE_STATE

// What a program found at a surface whose normal is n.
void load_scattering(uint lane, vec3 n, out Bsdf bsdf, out Lobe lobe) {
  bsdf.n = n;
  lobe.kind = LOBE_NONE;
#define BSDF_STATE(TYPE, BUFFER, MEMBER, NEEDED) \
  if (NEEDED) bsdf.MEMBER = LOAD(WAVE.bsdf_##MEMBER, lane);
#define LOBE_STATE(MEMBER, PLACE)
#include "state.inc"
#undef BSDF_STATE
#undef LOBE_STATE
  if (!FEATURE(FEATURE_LOBES)) return;
  const uint kind = LOAD(WAVE.lobe_kinds, lane);
  lobe.kind = kind & 0xffffu;
  lobe.mode = kind >> 16;
#define BSDF_STATE(TYPE, BUFFER, MEMBER, NEEDED)
#define LOBE_STATE(MEMBER, PLACE) lobe.MEMBER = bsdf.PLACE;
#include "state.inc"
#undef BSDF_STATE
#undef LOBE_STATE
}

void store_scattering(uint lane, Bsdf found, Lobe lobe) {
  Bsdf bsdf = found;
  if (FEATURE(FEATURE_LOBES)) STORE(WAVE.lobe_kinds, lane, lobe.kind | (lobe.mode << 16));
  if (has_lobe(lobe)) {
#define BSDF_STATE(TYPE, BUFFER, MEMBER, NEEDED)
#define LOBE_STATE(MEMBER, PLACE) bsdf.PLACE = lobe.MEMBER;
#include "state.inc"
#undef BSDF_STATE
#undef LOBE_STATE
  }
#define BSDF_STATE(TYPE, BUFFER, MEMBER, NEEDED) \
  if (NEEDED) STORE(WAVE.bsdf_##MEMBER, lane, bsdf.MEMBER);
#define LOBE_STATE(MEMBER, PLACE)
#include "state.inc"
#undef BSDF_STATE
#undef LOBE_STATE
}

#undef LANE_STATE
#undef PATH_STATE
#undef SHADOW_STATE
