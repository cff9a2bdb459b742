// SPDX-License-Identifier: GPL-3.0-or-later
// What a denoiser is shown beside the picture: albedo and normal of the first surface that is rough, as it is seen
// through mirrors and clear glass. Where they are kept is the film's.
#ifndef COTORRA_DENOISING_H
#define COTORRA_DENOISING_H

#include "integrator.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Highlights of a smaller alpha count as mirrors (Cycles).
const float FEATURE_ALPHA = 0.075f;
// Share of a surface's light that mirrors take, from which on what they show counts, and not the surface (Cycles).
const float FEATURE_MIRROR_SHARE = 0.75f;

struct Features {
  vec3 albedo;
  vec3 normal;
};

// Is the path still on its way to the surface whose features count?
FN bool path_shows_features(IN(PathState) path) { return (path.ray_kind & RAY_SHOWN) != 0u; }

// The features of a surface; `path` is weighted as after its program. False where the path goes on to what the surface
// mirrors.
FN bool path_features(IN(SceneData) scene, IN(PathState) path, IN(Bsdf) bsdf, IN(Lobe) lobe, vec3 wo, OUT(Features) f) {
  // Both are dimmed as what is mirrored is (Cycles).
  const float kept = mean_component(path.throughput);
  f.albedo = vec3(0.0f);
  f.normal = bsdf.n * kept;
  if (has_lobe(lobe)) {
    const bool facets = lobe.kind >= LOBE_REFLECTION && lobe.kind <= LOBE_ASHIKHMIN_SHIRLEY;
    if (facets && lobe.alpha_x * lobe.alpha_y <= FEATURE_ALPHA * FEATURE_ALPHA) return false;
    f.albedo = path.throughput * lobe_albedo(scene.albedo, lobe, wo);
    f.normal = lobe.n * kept;
    return true;
  }
  if ((bsdf.lobes & BSDF_THROUGH) != 0u) return false;
  vec3 albedo = bsdf.diffuse * PI;
  if (FEATURE(FEATURE_SPECULAR) && bsdf.p_glossy > 0.0f) {
    const bool smooth_lobe = bsdf.alpha2 <= FEATURE_ALPHA * FEATURE_ALPHA || (bsdf.lobes & BSDF_SINGULAR) != 0u;
    if (smooth_lobe && bsdf.p_glossy >= FEATURE_MIRROR_SHARE) return false;
    const float c = max(bsdf.no, 0.0f);
    float mean;
    const float single = albedo_reflectance(scene.albedo, sqrt(sqrt(bsdf.alpha2)), c, mean);
    if (!smooth_lobe) albedo += bsdf_fresnel(bsdf, c, c * c) * single;
  }
  f.albedo = path.throughput * albedo;
  return true;
}

// The albedo of light that a path found, emitted there or from the background.
FN vec3 light_features(vec3 found) { return clamp(found, vec3(0.0f), vec3(1.0f)); }

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
