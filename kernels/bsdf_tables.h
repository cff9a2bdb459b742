// SPDX-License-Identifier: GPL-3.0-or-later
// Albedos of rough GGX surfaces by table: where each table lies in SceneData.albedo, and how it is read.
// The values are computed when the project is built, by native/tools/make_albedo_tables.cpp.
#ifndef COTORRA_BSDF_TABLES_H
#define COTORRA_BSDF_TABLES_H

#include "microfacet.h"
#include "scene_types.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Axes are uniform over 0..1 and read linearly, on Cycles' grid: what lies between two nodes shows in the image.
// x: cosine to the viewer, fastest; y: roughness; z: index of refraction, see albedo_ior_axis.
const uint ALBEDO_NODES = 32u;         // of the reflectance and its mean
const uint ALBEDO_FRESNEL_NODES = 16u; // of the Fresnel weights
// Reflectance of GGX with F = 1 (x, y), and its mean over the cosine-weighted hemisphere (y).
const uint ALBEDO_REFLECTANCE = 0u;
const uint ALBEDO_REFLECTANCE_MEAN = 1024u;
// Mean of (F - F0) / (1 - F0) over the visible normals that reflect upward: dielectric (x, y, z), Schlick (x, y).
const uint ALBEDO_DIELECTRIC = 1056u;
const uint ALBEDO_SCHLICK = 5152u;
const uint ALBEDO_SIZE = 5408u;

// sqrt of (ior - 1) / (ior + 1): all of 1..infinity, and half of the axis for 1 to 1.7.
FN float albedo_ior_axis(float ior) { return sqrt(abs((ior - 1.0f) / (ior + 1.0f))); }

// Linear interpolation between two neighbours of a row.
FN float albedo_row(FloatBuffer table, uint i, float t) { return mix(LOAD(table, i), LOAD(table, i + 1u), t); }

// Cell of a coordinate on an axis of `nodes` nodes, and the place in it; the last cell holds its upper end.
FN uint albedo_cell(float x, uint nodes, OUT(float) t) {
  // In this order of arguments a NaN, as of a degenerate normal, becomes 0 and reads nothing out of bounds.
  const float s = min(max(0.0f, x), 1.0f) * float(nodes - 1u);
  // Signed, which processors convert in one instruction.
  const int cell = min(int(s), int(nodes) - 2);
  t = s - float(cell);
  return uint(cell);
}

// Reflectance of GGX toward cosine mu, and its mean.
FN float albedo_reflectance(FloatBuffer table, float roughness, float mu, OUT(float) mean) {
  float tx;
  float ty;
  const uint x = albedo_cell(mu, ALBEDO_NODES, tx);
  const uint y = albedo_cell(roughness, ALBEDO_NODES, ty);
  mean = albedo_row(table, ALBEDO_REFLECTANCE_MEAN + y, ty);
  const uint i = ALBEDO_REFLECTANCE + y * ALBEDO_NODES + x;
  return mix(albedo_row(table, i, tx), albedo_row(table, i + ALBEDO_NODES, tx), ty);
}

// One slice of Fresnel weights.
FN float albedo_fresnel_slice(FloatBuffer table, uint i, float tx, float ty) {
  return mix(albedo_row(table, i, tx), albedo_row(table, i + ALBEDO_FRESNEL_NODES, tx), ty);
}

// Mean Fresnel weight of a metal.
FN float albedo_schlick(FloatBuffer table, float roughness, float mu) {
  float tx;
  float ty;
  const uint x = albedo_cell(mu, ALBEDO_FRESNEL_NODES, tx);
  const uint y = albedo_cell(roughness, ALBEDO_FRESNEL_NODES, ty);
  return albedo_fresnel_slice(table, ALBEDO_SCHLICK + y * ALBEDO_FRESNEL_NODES + x, tx, ty);
}

// Mean Fresnel weight of a dielectric.
FN float albedo_dielectric(FloatBuffer table, float roughness, float mu, float eta) {
  float tx;
  float ty;
  float tz;
  const uint x = albedo_cell(mu, ALBEDO_FRESNEL_NODES, tx);
  const uint y = albedo_cell(roughness, ALBEDO_FRESNEL_NODES, ty);
  const uint z = albedo_cell(albedo_ior_axis(eta), ALBEDO_FRESNEL_NODES, tz);
  const uint slice = ALBEDO_FRESNEL_NODES * ALBEDO_FRESNEL_NODES;
  const uint i = ALBEDO_DIELECTRIC + z * slice + y * ALBEDO_FRESNEL_NODES + x;
  return mix(albedo_fresnel_slice(table, i, tx, ty), albedo_fresnel_slice(table, i + slice, tx, ty), tz);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
