// SPDX-License-Identifier: GPL-3.0-or-later
// The whole Principled BSDF of Blender 5.2, from plain inputs: its layers from the top down, and the pick of one of
// them. Where only metal, dielectric layer and Lambert are asked for, all three stand in bsdf.h's record, at once.
#ifndef COTORRA_PRINCIPLED_H
#define COTORRA_PRINCIPLED_H

#include "lobe.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Who was picked.
const uint PICK_NONE = 0u;
const uint PICK_BSDF = 1u;  // metal, dielectric layer and Lambert, in a Bsdf
const uint PICK_LOBE = 2u;

// A reservoir: the one of the lobes seen so far that is kept, each in proportion to its weight, by one random number.
struct LobePick {
  float u;       // what is left of the random number
  float sum;     // of weights
  float chosen;  // weight of the kept one
  uint kind;     // PICK_*
};

FN void pick_begin(float u, OUT(LobePick) p) {
  p.u = u;
  p.sum = 0.0f;
  p.chosen = 0.0f;
  p.kind = PICK_NONE;
}

// Shall a candidate of this weight replace the one that is kept?
FN bool pick_next(float weight, uint kind, INOUT(LobePick) p) {
  if (!(weight > 0.0f) || !(weight < INFINITE_DISTANCE)) return false;
  p.sum += weight;
  const float chance = weight / p.sum;
  const bool taken = p.u < chance;
  p.u = min(taken ? p.u / chance : (p.u - chance) / max(1.0f - chance, 1e-8f), 0.99999994f);
  if (taken) {
    p.chosen = weight;
    p.kind = kind;
  }
  return taken;
}

FN void pick_lobe(FloatBuffer table, IN(Lobe) candidate, vec3 wo, INOUT(LobePick) p, INOUT(Lobe) kept) {
  const float weight = mean_component(lobe_albedo(table, candidate, wo));
  if (weight >= BSDF_WEIGHT_CUTOFF && pick_next(weight, PICK_LOBE, p)) kept = candidate;
}

// What a layer of this albedo, its own weight included, leaves of the light for what lies below (Cycles).
FN vec3 layer_below(vec3 albedo, vec3 weight) {
  const vec3 share = vec3(weight.x > 0.0f ? albedo.x / weight.x : 0.0f, weight.y > 0.0f ? albedo.y / weight.y : 0.0f,
                          weight.z > 0.0f ? albedo.z / weight.z : 0.0f);
  return weight * clamp(1.0f - max_component(share), 0.0f, 1.0f);
}

// Is this kind of lobe left out?
FN bool principled_lacks(IN(PrincipledInputs) inputs, uint caustics) { return (inputs.no_caustics & caustics) != 0u; }

// ---- Layers, from above. Each prepares its lobe, LOBE_NONE where there is none, and leaves in `weight` what goes
// below.

FN void principled_sheen(FloatBuffer table, IN(PrincipledInputs) inputs, vec3 wo, INOUT(vec3) weight, OUT(Lobe) l) {
  lobe_clear(LOBE_NONE, vec3(0.0f), inputs.n, l);
  const vec3 own = weight * max(inputs.sheen_tint, vec3(0.0f)) * max(inputs.sheen, 0.0f);
  if (!(inputs.sheen > BSDF_WEIGHT_CUTOFF) || !(mean_component(own) >= BSDF_WEIGHT_CUTOFF)) return;
  float len;
  const vec3 n = safe_normalize(mix(inputs.n, inputs.coat_n, clamp(inputs.coat, 0.0f, 1.0f)), len);
  sheen_prepare(table, own, vec3(1.0f), inputs.sheen_roughness, n, wo, l);
  if (l.kind != LOBE_NONE) weight = layer_below(l.weight, weight);
}

// The coat, and what its tint absorbs on the way in and out (Beer's law, along the refracted direction).
FN void principled_coat(FloatBuffer table, IN(PrincipledInputs) inputs, vec3 ng, vec3 wo, INOUT(vec3) weight,
                        OUT(Lobe) l) {
  lobe_clear(LOBE_NONE, vec3(0.0f), inputs.n, l);
  const float coat = max(inputs.coat, 0.0f);
  if (!(coat > BSDF_WEIGHT_CUTOFF)) return;
  const vec3 n = normal_for_reflection(inputs.coat_n, ng, wo);
  const float eta = clamp(inputs.coat_ior, 1.0f, 1e5f);
  if (mean_component(weight) * coat >= BSDF_WEIGHT_CUTOFF && !principled_lacks(inputs, CAUSTICS_REFLECTIVE)) {
    lobe_clear(LOBE_REFLECTION, weight * coat, n, l);
    const float alpha = sqr(clamp(inputs.coat_roughness, 0.0f, 1.0f));
    microfacet_set_alpha(alpha, alpha, l);
    dielectric_layer_set(table, vec3(F0_from_ior(eta)), eta, true, wo, l);
    weight = layer_below(microfacet_albedo(table, l, wo), weight);
  }
  const float c = dot(n, wo);
  const float inside = sqrt(max(1.0f - (1.0f - c * c) / (eta * eta), 1e-4f));
  const vec3 tint = max(inputs.coat_tint, vec3(0.0f));
  if (tint.x == 1.0f && tint.y == 1.0f && tint.z == 1.0f) return;
  weight = weight * max(mix(vec3(1.0f), power(tint, 1.0f / inside), coat), vec3(0.0f));
}

FN void principled_metal_layer(FloatBuffer table, IN(PrincipledInputs) inputs, vec3 ng, vec3 wo, INOUT(vec3) weight,
                               OUT(Lobe) l) {
  lobe_clear(LOBE_NONE, vec3(0.0f), inputs.n, l);
  const float metallic = clamp(inputs.metallic, 0.0f, 1.0f);
  if (!(metallic > BSDF_WEIGHT_CUTOFF)) return;
  const vec3 own = weight * metallic;
  weight *= 1.0f - metallic;
  if (principled_lacks(inputs, CAUSTICS_REFLECTIVE)) return;
  const uint distribution = inputs.multiscatter != 0u ? CLOSURE_MULTI_GGX : CLOSURE_GGX;
  metallic_prepare(table, distribution, own, inputs.base_color, inputs.specular_tint, inputs.roughness,
                   inputs.anisotropic, inputs.rotation, inputs.n, ng, inputs.tangent, wo, inputs.film, inputs.film_ior,
                   l);
}

// Glass, or the reflection of a thin wall, whose other lobe is `passed`.
FN void principled_transmission(FloatBuffer table, IN(PrincipledInputs) inputs, vec3 ng, vec3 wo, INOUT(vec3) weight,
                                OUT(Lobe) l, OUT(Lobe) passed) {
  lobe_clear(LOBE_NONE, vec3(0.0f), inputs.n, l);
  passed = l;
  const float transmission = clamp(inputs.transmission, 0.0f, 1.0f);
  if (!(transmission > BSDF_WEIGHT_CUTOFF)) return;
  const vec3 own = weight * transmission;
  weight *= 1.0f - transmission;
  const vec3 mirrored = vec3(principled_lacks(inputs, CAUSTICS_REFLECTIVE) ? 0.0f : 1.0f);
  const vec3 refracted = vec3(principled_lacks(inputs, CAUSTICS_REFRACTIVE) ? 0.0f : 1.0f);
  if (is_black(mirrored) && is_black(refracted)) return;
  const vec3 n = normal_for_reflection(inputs.n, ng, wo);
  const vec3 base = clamp(inputs.base_color, vec3(0.0f), vec3(1.0f));
  const vec3 tint = max(inputs.specular_tint, vec3(0.0f));
  if (inputs.thin_wall != 0u) {
    const float c = dot(n, wo);
    if (!(c > 0.0f)) return;
    vec3 reflectance;
    vec3 transmittance;
    thin_wall_fresnel(table, tint, base, inputs.ior, inputs.film, inputs.film_ior, min(c, 1.0f), reflectance,
                      transmittance);
    lobe_clear(LOBE_REFLECTION, own * reflectance * mirrored, n, l);
    thin_wall_reflection_set(table, inputs.roughness, tint, wo, l);
    lobe_clear(LOBE_THIN_TRANSMISSION, own * transmittance * refracted, n, passed);
    thin_wall_transmission_set(table, inputs.roughness, inputs.ior, wo, passed);
    return;
  }
  lobe_clear(LOBE_GLASS, own, n, l);
  const uint distribution = inputs.multiscatter != 0u ? CLOSURE_MULTI_GGX : CLOSURE_GGX;
  const vec3 f0 = tint * F0_from_ior(clamp(inputs.ior, 1e-5f, 1e5f));
  glass_set(table, distribution, inputs.roughness, inputs.ior, inputs.inside != 0u, f0, mirrored,
            sqrt(base) * refracted, inputs.film, max(inputs.film_ior, 1e-5f), wo, l);
}

FN void principled_dielectric_layer(FloatBuffer table, IN(PrincipledInputs) inputs, vec3 ng, vec3 wo,
                                    INOUT(vec3) weight, OUT(Lobe) l) {
  lobe_clear(LOBE_NONE, vec3(0.0f), inputs.n, l);
  float f0;
  const float eta = dielectric_eta(inputs.ior, inputs.specular_level, f0);
  const bool film = inputs.film > FILM_CUTOFF;
  if ((eta == 1.0f && !film) || !(mean_component(weight) >= BSDF_WEIGHT_CUTOFF)) return;
  if (principled_lacks(inputs, CAUSTICS_REFLECTIVE)) return;
  lobe_clear(LOBE_REFLECTION, weight, normal_for_reflection(inputs.n, ng, wo), l);
  anisotropy_set(inputs.roughness, inputs.anisotropic, inputs.rotation, inputs.n, inputs.tangent, l);
  film_set(inputs.film, inputs.film_ior, l);
  dielectric_layer_set(table, max(inputs.specular_tint, vec3(0.0f)) * f0, eta, inputs.multiscatter != 0u, wo, l);
  weight = layer_below(microfacet_albedo(table, l, wo), weight);
}

// The diffuse base; of a thin wall, `passed` is what its subsurface part scatters through.
FN void principled_base(IN(PrincipledInputs) inputs, vec3 wo, vec3 weight, OUT(Lobe) l, OUT(Lobe) passed) {
  const vec3 base = max(inputs.base_color, vec3(0.0f));
  const float subsurface = inputs.subsurface > BSDF_WEIGHT_CUTOFF ? min(inputs.subsurface, 1.0f) : 0.0f;
  const vec3 scattered = min(base, vec3(1.0f)) * subsurface;
  const float back = inputs.thin_wall != 0u ? clamp(0.5f * (1.0f + inputs.subsurface_anisotropy), 0.0f, 1.0f) : 0.0f;
  diffuse_prepare(LOBE_DIFFUSE, weight, base, inputs.diffuse_roughness, inputs.n, wo, l);
  passed = l;
  l.weight = weight * (base * (1.0f - subsurface) + scattered * (1.0f - back));
  passed.kind = LOBE_TRANSLUCENT;
  passed.weight = weight * scattered * back;
}

// ---- The fast road

// Has the surface below sheen and coat nothing that bsdf.h lacks? Transmission stands beside it.
FN bool principled_is_plain(IN(PrincipledInputs) inputs) {
  const bool thin = inputs.thin_wall != 0u && inputs.subsurface > BSDF_WEIGHT_CUTOFF;
  return !(inputs.anisotropic > 0.0f) && !(inputs.film > FILM_CUTOFF) &&
         !(inputs.diffuse_roughness >= DIFFUSE_ROUGHNESS_MIN) && !thin;
}

// The material of bsdf.h, for what lies below sheen and coat, without its transmission. Returns the share of the light
// that reaches it: 1 where there is no transmission, and then the metal's share is as it was.
FN float principled_material(IN(PrincipledInputs) inputs, OUT(Material) m) {
  const float transmission = clamp(inputs.transmission, 0.0f, 1.0f);
  const float metallic = clamp(inputs.metallic, 0.0f, 1.0f);
  const bool glass = transmission > BSDF_WEIGHT_CUTOFF;
  const float share = glass ? metallic + (1.0f - metallic) * (1.0f - transmission) : 1.0f;
  m.base_color = inputs.base_color;
  m.metallic = glass ? metallic / max(share, 1e-10f) : inputs.metallic;
  m.specular_tint = inputs.specular_tint;
  m.roughness = inputs.roughness;
  m.emission = vec3(0.0f);
  m.ior = inputs.ior;
  m.specular_level = inputs.specular_level;
  m.alpha = 1.0f;
  m.pass_index = 0;
  m.flags = inputs.multiscatter != 0u ? MATERIAL_MULTI_GGX : 0u;
  m.flags |= principled_flags(m);
  if (principled_lacks(inputs, CAUSTICS_REFLECTIVE)) m.flags &= ~MATERIAL_SPECULAR;
  return share;
}

// ---- The pick

// No lobe at all, of a surface with normal n.
FN void bsdf_prepare_nothing(vec3 n, vec3 wo, OUT(Bsdf) bsdf) {
  bsdf_clear_glossy(bsdf);
  bsdf.n = n;
  bsdf.p_glossy = 0.0f;
  bsdf.diffuse = vec3(0.0f);
  bsdf.no = dot(n, wo);
  bsdf.n_glossy = n;
  bsdf.unused = 0.0f;
  bsdf.n_smooth = n;
  bsdf.unused2 = 0.0f;
  bsdf.lobes = 0u;
  model_clear(bsdf.model);
}

// Picks one of the layers toward wo: a Bsdf or a Lobe, as the returned PICK_* says. Multiply the path's throughput by
// `scale`, which holds 1 / probability, and for a Bsdf what the layers above let through. u chooses.
FN uint principled_pick(IN(SceneData) scene, IN(PrincipledInputs) inputs, vec3 ng, vec3 wo, float u, OUT(Bsdf) bsdf,
                        OUT(Lobe) lobe, OUT(vec3) scale) {
  Lobe l;
  Lobe passed;
  LobePick p;
  pick_begin(u, p);
  vec3 weight = vec3(1.0f);
  lobe_clear(LOBE_NONE, vec3(0.0f), inputs.n, lobe);
  // 1. What lies above, and glass.
  principled_sheen(scene.albedo, inputs, wo, weight, l);
  pick_lobe(scene.albedo, l, wo, p, lobe);
  principled_coat(scene.albedo, inputs, ng, wo, weight, l);
  pick_lobe(scene.albedo, l, wo, p, lobe);
  vec3 beside_metal = weight * (1.0f - clamp(inputs.metallic, 0.0f, 1.0f));
  principled_transmission(scene.albedo, inputs, ng, wo, beside_metal, l, passed);
  pick_lobe(scene.albedo, l, wo, p, lobe);
  pick_lobe(scene.albedo, passed, wo, p, lobe);
  // 2. The rest, at once.
  if (principled_is_plain(inputs)) {
    Material m;
    const float share = principled_material(inputs, m);
    const vec3 below = weight * share;
    const vec3 glossy = bsdf_prepare_albedo(scene, m, inputs.n, ng, wo, bsdf);
    const vec3 albedo = below * (glossy + bsdf.diffuse * PI);
    pick_next(mean_component(albedo), PICK_BSDF, p);
    scale = select(p.kind == PICK_BSDF, below, vec3(1.0f));
    const bool alone = p.kind == PICK_BSDF && p.chosen == p.sum;
    scale *= alone ? 1.0f : p.sum / max(p.chosen, 1e-20f);
    return p.kind;
  }
  // 3. Or layer by layer.
  bsdf_prepare_nothing(inputs.n, wo, bsdf);
  principled_metal_layer(scene.albedo, inputs, ng, wo, weight, l);
  pick_lobe(scene.albedo, l, wo, p, lobe);
  principled_dielectric_layer(scene.albedo, inputs, ng, wo, beside_metal, l);
  pick_lobe(scene.albedo, l, wo, p, lobe);
  principled_base(inputs, wo, beside_metal, l, passed);
  pick_lobe(scene.albedo, l, wo, p, lobe);
  pick_lobe(scene.albedo, passed, wo, p, lobe);
  scale = vec3(p.sum / max(p.chosen, 1e-20f));
  return p.kind;
}

// What the surface emits toward wo, through sheen and coat.
FN vec3 principled_emission(FloatBuffer table, IN(PrincipledInputs) inputs, vec3 ng, vec3 wo) {
  Lobe l;
  vec3 weight = vec3(1.0f);
  principled_sheen(table, inputs, wo, weight, l);
  principled_coat(table, inputs, ng, wo, weight, l);
  return inputs.emission * weight;
}

// What the surface does with uniform light, about: the sum of all layers' albedos.
FN vec3 principled_albedo(FloatBuffer table, IN(PrincipledInputs) inputs, vec3 ng, vec3 wo) {
  Lobe l;
  Lobe passed;
  vec3 weight = vec3(1.0f);
  principled_sheen(table, inputs, wo, weight, l);
  vec3 sum = lobe_albedo(table, l, wo);
  principled_coat(table, inputs, ng, wo, weight, l);
  sum += lobe_albedo(table, l, wo);
  principled_metal_layer(table, inputs, ng, wo, weight, l);
  sum += lobe_albedo(table, l, wo);
  principled_transmission(table, inputs, ng, wo, weight, l, passed);
  sum += lobe_albedo(table, l, wo) + lobe_albedo(table, passed, wo);
  principled_dielectric_layer(table, inputs, ng, wo, weight, l);
  sum += lobe_albedo(table, l, wo);
  principled_base(inputs, wo, weight, l, passed);
  return sum + l.weight + passed.weight;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
