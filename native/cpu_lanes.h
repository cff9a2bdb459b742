// SPDX-License-Identifier: GPL-3.0-or-later
// Many shading points at once: fields of the kernels' structs as arrays by lane, and the loops over them that
// vectorise. Included by cpu_kernel.cpp alone, after the kernels, so that each instruction set has its own.
#pragma once

#include "cpu_models.h"

namespace cotorra {
namespace {

// The shading points of a batch, field by field: loops over lanes vectorise. Bsdf of kernels/bsdf.h, and what a lamp's
// sample needs beside it.
struct ShadingLanes {
  Vec3s p, ng, wo, throughput;
  Floats epsilon, terminator;
  Vec3s n, n_smooth, n_glossy, diffuse, metal_f0, metal_range, metal_edge, coating_f0, coating_f90;
  Floats p_glossy, no, alpha2, s_o, eta, fresnel_f0;
  Array<uint, kLanes> lobes;
  ModelLanes model;
  Array<Lobe, FEATURE(FEATURE_LOBES) ? kLanes : 1> lobe;  // where its kind is not LOBE_NONE, it takes over

  void set_bsdf(std::size_t i, const Bsdf &b) {
    if (FEATURE(FEATURE_MODELS)) model.set(i, b.model);
    n.set(i, b.n);
    diffuse.set(i, b.diffuse);
    if (FEATURE(FEATURE_PROGRAMS)) n_smooth.set(i, b.n_smooth);
    if (!FEATURE(FEATURE_SPECULAR)) return;
    n_glossy.set(i, b.n_glossy);
    metal_f0.set(i, b.metal_f0);
    metal_range.set(i, b.metal_range);
    metal_edge.set(i, b.metal_edge);
    coating_f0.set(i, b.coating_f0);
    coating_f90.set(i, b.coating_f90);
    p_glossy[i] = b.p_glossy;
    no[i] = b.no;
    alpha2[i] = b.alpha2;
    s_o[i] = b.s_o;
    eta[i] = b.eta;
    fresnel_f0[i] = b.fresnel_f0;
    lobes[i] = b.lobes;
  }
  void set_lobe(std::size_t i, const Lobe &l) {
    lobe[i].kind = l.kind;
    if (l.kind != LOBE_NONE) lobe[i] = l;
  }
  // Of no kind that counts where lobes are not built.
  const Lobe &lobe_of(std::size_t i) const { return lobe[FEATURE(FEATURE_LOBES) ? i : 0]; }
  // For one lane at a time.
  Bsdf bsdf(std::size_t i) const {
    const uint of_model = FEATURE(FEATURE_MODELS) ? model.model[i] : MODEL_PRINCIPLED;
    if (of_model == MODEL_PRINCIPLED) return principled(i);
    Bsdf b{};
    model_bsdf(i, of_model, b);
    return b;
  }
  // Of a lane that has this model: what of Bsdf counts for it. In its place, since loops with a copy of a struct would
  // not vectorise.
  void model_bsdf(std::size_t i, uint of_model, Bsdf &b) const {
    b.n = n.get(i);
    b.n_glossy = n_glossy.get(i);
    b.n_smooth = n.get(i);
    if (FEATURE(FEATURE_PROGRAMS)) b.n_smooth = n_smooth.get(i);
    b.diffuse = diffuse.get(i);
    b.p_glossy = p_glossy[i];
    b.no = no[i];
    b.lobes = lobes[i];
    model.get(i, of_model, b.model);
  }
  // For loops that vectorise: as if no lane had a model, which the compiler sees.
  Bsdf principled(std::size_t i) const {
    Bsdf b{};
    b.n = n.get(i);
    b.diffuse = diffuse.get(i);
    if (FEATURE(FEATURE_PROGRAMS)) b.n_smooth = n_smooth.get(i);
    if (!FEATURE(FEATURE_SPECULAR)) return b;
    b.n_glossy = n_glossy.get(i);
    b.metal_f0 = metal_f0.get(i);
    b.metal_range = metal_range.get(i);
    b.metal_edge = metal_edge.get(i);
    b.coating_f0 = coating_f0.get(i);
    b.coating_f90 = coating_f90.get(i);
    b.p_glossy = p_glossy[i];
    b.no = no[i];
    b.alpha2 = alpha2[i];
    b.s_o = s_o[i];
    b.eta = eta[i];
    b.fresnel_f0 = fresnel_f0[i];
    b.lobes = lobes[i];
    return b;
  }
};

// Where each lane's ray hit, and what it met there: input of the shading.
struct HitLanes {
  Vec3s p0, p1, p2, n0, n1, n2, direction;
  Floats orientation, u, v, side;

  void set(std::size_t i, const SurfaceTriangle &t, const Hit &hit, vec3 d) {
    p0.set(i, t.p0);
    p1.set(i, t.p1);
    p2.set(i, t.p2);
    n0.set(i, t.n0);
    n1.set(i, t.n1);
    n2.set(i, t.n2);
    direction.set(i, d);
    orientation[i] = t.orientation;
    u[i] = hit.u;
    v[i] = hit.v;
  }
  SurfaceTriangle triangle(std::size_t i) const {
    SurfaceTriangle t{};
    t.p0 = p0.get(i);
    t.p1 = p1.get(i);
    t.p2 = p2.get(i);
    t.n0 = n0.get(i);
    t.n1 = n1.get(i);
    t.n2 = n2.get(i);
    t.orientation = orientation[i];
    return t;
  }
};

// What each lane's sample of one lamp would bring.
struct LightLanes {
  Vec3s origin, wi, contribution;
  Floats distance;
  Floats lift;  // terminator_amount, below 0: behind the surface
  Vec3s weight;  // for lanes that are done in loops of their own
  Floats pdf;
};
constexpr bool kLaterLanes = FEATURE(FEATURE_LOBES) || FEATURE(FEATURE_MODELS);

// What each lane's sample of its BSDF is.
struct BounceLanes {
  Vec3s wi, weight;
  Floats pdf;
  Array<uint, kLanes> lobe;
};

// Random pairs of many paths at once; the loop vectorises.
void fill_pairs(const uint *index, int n, uint pair_seed, float *u, float *v) {
  for (int i = 0; i < n; ++i) {
    const vec2 p = sampler_pair(index[i], pair_seed);
    u[i] = p.x;
    v[i] = p.y;
  }
}

// Positions and normals of all lanes.
COTORRA_FLATTEN void shape_surfaces(HitLanes &in, int n, ShadingLanes &out) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    const vec3 direction = in.direction.get(i);
    vec3 p, ng, ns;
    float side;
    out.epsilon[i] = surface_shape(in.triangle(i), in.u[i], in.v[i], direction, p, ng, ns, side);
    out.p.set(i, p);
    out.ng.set(i, ng);
    out.n.set(i, ns);
    out.wo.set(i, -direction);
    in.side[i] = side;
  }
}

// A lamp's samples for lanes whose surface is a Lobe, one after the other. Apart, since there is a loop over all lanes
// for each kind of lamp.
COTORRA_FLATTEN void sample_lamp_singly(const SceneData &scene, const Light &light, const ShadingLanes &in, int n,
                                        LightLanes &out) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    if (!has_lobe(in.lobe_of(i))) continue;
    const LightSample l{out.wi.get(i), out.distance[i], out.weight.get(i), out.pdf[i]};
    out.contribution.set(i, lobe_light_contribution(scene, light, l, in.bsdf(i), in.lobe_of(i), in.wo.get(i),
                                                    in.throughput.get(i), 1.0f));
  }
}

// The same for lanes with a model.
template <uint kModel>
COTORRA_UNTHREADED COTORRA_FLATTEN void sample_lamp_model(const Light &lamp, const ShadingLanes &in, int n,
                                                          LightLanes &out) {
  const Light light = lamp;
  COTORRA_EACH {
    const LightSample l{out.wi.get(i), out.distance[i], out.weight.get(i), out.pdf[i]};
    Bsdf bsdf;
    in.model_bsdf(i, kModel, bsdf);
    const vec3 light_here = light_contribution(light, l, bsdf, in.wo.get(i), in.throughput.get(i), 1.0f);
    out.contribution.set(i, select(in.model.model[i] == kModel, light_here, out.contribution.get(i)));
  }
}

template <uint kType>
void sample_one(const Light &light, vec3 p, vec3 n, vec2 u, LightSample &l) {
  if constexpr (kType == LIGHT_AREA) {
    area_light_sample_spread(light, p, u, l);
  } else {
    light_sample(light, p, n, u, l);
  }
}

// One sample of a lamp for each lane. What distinguishes the kinds of lamps is constant in each instance, since a loop
// with conditions that do not change in it would not vectorise.
// kDisk: a disk that faces the point, of an area light an ellipse.
template <uint kType, bool kDisk>
COTORRA_FLATTEN void sample_lamp(const SceneData &scene, const Light &lamp, const ShadingLanes &in, const float *u,
                                 const float *v, int n, LightLanes &out) {
  Light light = lamp;
  light.type = kType;
  constexpr uint disk = kType == LIGHT_AREA ? LIGHT_ELLIPSE : LIGHT_SOFT_FALLOFF;
  light.flags = kDisk ? lamp.flags | disk : lamp.flags & ~disk;
  light.visibility = VISIBLE_ALL;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    LightSample l;
    sample_one<kType>(light, in.p.get(i), in.n.get(i), vec2(u[i], v[i]), l);
    out.contribution.set(i, light_contribution(light, l, in.principled(i), in.wo.get(i), in.throughput.get(i), 1.0f));
    const vec3 ng = in.ng.get(i);
    out.origin.set(i, surface_ray_origin(in.p.get(i), ng, in.epsilon[i], l.wi));
    const vec3 smooth = FEATURE(FEATURE_PROGRAMS) ? in.n_smooth.get(i) : in.n.get(i);
    const float n_wi = dot(smooth, l.wi);
    const float lift = terminator_amount(in.terminator[i], n_wi, dot(ng, l.wi));
    out.lift[i] = select(n_wi < 0.0f, -lift, lift);
    out.wi.set(i, l.wi);
    out.distance[i] = l.distance;
    if (!kLaterLanes) continue;
    out.weight.set(i, l.weight);
    out.pdf[i] = l.pdf;
  }
  if (FEATURE(FEATURE_MODELS)) {
    each_model(in.model, [&](auto model) { sample_lamp_model<model()>(light, in, n, out); });
  }
  if (FEATURE(FEATURE_LOBES)) sample_lamp_singly(scene, light, in, n, out);
}

// Dims each lane's sample of a lamp by the lamp's shape. A loop of its own: Blender's own lamps have nothing to do
// here.
COTORRA_FLATTEN void shape_lamp(const LightShape &lamp_shape, const Light &lamp, const ShadingLanes &in, int n,
                                LightLanes &out) {
  const LightShape shape = lamp_shape;
  const Light light = lamp;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    const float factor = light_shape(shape, light, in.p.get(i), out.wi.get(i));
    out.contribution.set(i, out.contribution.get(i) * factor);
  }
}

inline void set_sample(const BsdfSample &b, std::size_t i, BounceLanes &out) {
  out.wi.set(i, b.wi);
  out.weight.set(i, b.weight);
  out.pdf[i] = b.pdf;
  out.lobe[i] = b.lobe;
}

// The lanes whose surface is a Lobe.
COTORRA_APART void sample_bsdf_singly(const SceneData &scene, const ShadingLanes &in, const float *choice,
                                      const float *u, const float *v, int n, BounceLanes &out) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    if (!has_lobe(in.lobe_of(i))) continue;
    BsdfSample b;
    scattering_sample(scene, in.bsdf(i), in.lobe_of(i), in.wo.get(i), choice[i], vec2(u[i], v[i]), b);
    set_sample(b, i, out);
  }
}

// Directions of the lanes with a model, and whether each is of the highlight. Cook-Torrance's search for half vectors
// is no vector code.
template <uint kModel>
COTORRA_FLATTEN void sample_directions(const ShadingLanes &in, const float *choice, const float *u, const float *v,
                                       int n, Vec3s &wi, Array<uint, kLanes> &specular) {
  COTORRA_EACH {
    if (kModel == MODEL_COOK_TORRANCE && in.model.model[i] != kModel) continue;
    Bsdf bsdf;
    in.model_bsdf(i, kModel, bsdf);
    bool highlight;
    wi.set(i, model_sample(bsdf.model, bsdf.n, bsdf.n_glossy, in.wo.get(i), choice[i], vec2(u[i], v[i]), highlight));
    specular[i] = highlight ? 1u : 0u;
  }
}

// Samples of the lanes with a model.
template <uint kModel>
COTORRA_UNTHREADED COTORRA_FLATTEN void sample_bsdf_model(const ShadingLanes &in, const float *choice, const float *u,
                                                          const float *v, int n, BounceLanes &out) {
  Vec3s wi;
  Array<uint, kLanes> specular;
  sample_directions<kModel>(in, choice, u, v, n, wi, specular);
  COTORRA_EACH {
    Bsdf bsdf;
    in.model_bsdf(i, kModel, bsdf);
    BsdfSample b;
    b.wi = wi.get(i);
    bsdf_weigh_model(bsdf, in.wo.get(i), specular[i] != 0u, b);
    const bool mine = in.model.model[i] == kModel;
    out.wi.set(i, select(mine, b.wi, out.wi.get(i)));
    out.weight.set(i, select(mine, b.weight, out.weight.get(i)));
    out.pdf[i] = mine ? b.pdf : out.pdf[i];
    out.lobe[i] = mine ? b.lobe : out.lobe[i];
  }
}

COTORRA_FLATTEN void sample_bsdf(const SceneData &scene, const ShadingLanes &in, const float *choice, const float *u,
                                 const float *v, int n, BounceLanes &out) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    BsdfSample b;
    bsdf_sample(in.principled(i), in.wo.get(i), choice[i], vec2(u[i], v[i]), b);
    set_sample(b, i, out);
  }
  if (FEATURE(FEATURE_MODELS)) {
    each_model(in.model, [&](auto model) { sample_bsdf_model<model()>(in, choice, u, v, n, out); });
  }
  if (FEATURE(FEATURE_LOBES)) sample_bsdf_singly(scene, in, choice, u, v, n, out);
}

using SampleLamp = void (*)(const SceneData &, const Light &, const ShadingLanes &, const float *, const float *, int,
                            LightLanes &);
SampleLamp sample_lamp_of(const Light &lamp) {
  const bool disk = (lamp.flags & LIGHT_SOFT_FALLOFF) != 0;
  if (lamp.type == LIGHT_SUN) return sample_lamp<LIGHT_SUN, false>;
  if constexpr (FEATURE(FEATURE_AREA_LIGHTS)) {
    const bool round = (lamp.flags & LIGHT_ELLIPSE) != 0;
    if (lamp.type == LIGHT_AREA) return round ? sample_lamp<LIGHT_AREA, true> : sample_lamp<LIGHT_AREA, false>;
  }
  if (lamp.type == LIGHT_SPOT) return disk ? sample_lamp<LIGHT_SPOT, true> : sample_lamp<LIGHT_SPOT, false>;
  return disk ? sample_lamp<LIGHT_POINT, true> : sample_lamp<LIGHT_POINT, false>;
}

}  // namespace
}  // namespace cotorra
