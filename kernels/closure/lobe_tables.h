// SPDX-License-Identifier: GPL-3.0-or-later
// The tables that lobes read beside those of bsdf_tables.h: albedos of rough glass, colours of thin films, and sheen.
// They follow the others in SceneData.albedo; native/tools/make_albedo_tables.cpp computes them all.
#ifndef COTORRA_LOBE_TABLES_H
#define COTORRA_LOBE_TABLES_H

#include "../bsdf_tables.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// What rough glass reflects and refracts of uniform light: x cosine, y roughness, z index of refraction as in
// bsdf_tables.h, on ALBEDO_FRESNEL_NODES nodes each; of light that enters the denser medium, and that leaves it.
const uint TABLE_GLASS = 5408u;
const uint TABLE_GLASS_LEAVING = 9504u;
// Their means over the cosine-weighted hemisphere: x roughness, y index of refraction.
const uint TABLE_GLASS_MEAN = 13600u;
const uint TABLE_GLASS_LEAVING_MEAN = 13856u;
// Means of cos and sin of 2 pi OPD / wavelength over the wavelengths that red, green and blue see: red cos, green cos,
// blue cos, red sin and so on, each over the optical path difference OPD in equal steps from 0 to FILM_LONGEST.
const uint TABLE_FILM = 14112u;
const uint FILM_NODES = 512u;
const float FILM_LONGEST = 9549.0f;  // nm
// A layer of microfibers: its albedo, then A and B of its transformed cosine; x cosine toward the viewer, y roughness,
// both uniform over 0..1. Measured in Cycles, between whose nodes all is linear (native/tools/sheen_table.inc).
const uint TABLE_SHEEN = 17184u;
const uint SHEEN_NODES = 32u;
const uint TABLE_SIZE = 20256u;

// Albedo of glass and its mean; eta is that beyond the surface over that on the viewer's side.
FN float table_glass(FloatBuffer table, float roughness, float mu, float eta, OUT(float) mean) {
  float tx;
  float ty;
  float tz;
  const uint n = ALBEDO_FRESNEL_NODES;
  const uint x = albedo_cell(mu, n, tx);
  const uint y = albedo_cell(roughness, n, ty);
  const uint z = albedo_cell(albedo_ior_axis(select(eta < 1.0f, 1.0f / max(eta, 1e-5f), eta)), n, tz);
  const uint means = select(eta < 1.0f, TABLE_GLASS_LEAVING_MEAN, TABLE_GLASS_MEAN) + z * n + y;
  mean = mix(albedo_row(table, means, ty), albedo_row(table, means + n, ty), tz);
  const uint i = select(eta < 1.0f, TABLE_GLASS_LEAVING, TABLE_GLASS) + (z * n + y) * n + x;
  return mix(albedo_fresnel_slice(table, i, tx, ty), albedo_fresnel_slice(table, i + n * n, tx, ty), tz);
}

// Means of cos and sin as one channel sees them.
FN vec2 table_film(FloatBuffer table, uint channel, float path_difference) {
  float t;
  const uint x = TABLE_FILM + channel * FILM_NODES + albedo_cell(path_difference / FILM_LONGEST, FILM_NODES, t);
  return vec2(albedo_row(table, x, t), albedo_row(table, x + 3u * FILM_NODES, t));
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
