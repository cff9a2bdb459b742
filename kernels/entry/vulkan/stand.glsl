// SPDX-License-Identifier: GPL-3.0-or-later
// The surface that a lane stands at, for the stages after shade.comp: what follows from the hit is computed again,
// which costs less than to keep it; what a program found is loaded. Nothing is decided here.

Surface surface_at(uint lane) {
  Surface s;
  surface_from_hit(SCENE, LOAD(WAVE.hits, lane), WAVE.rays.v[lane].direction, s);
  if (DRAWN) s.n = LOAD(WAVE.normals, lane);
  return s;
}

void scattering_at(uint lane, Surface s, vec3 wo, out Bsdf bsdf, out Lobe lobe) {
  if (DRAWN) {
    load_scattering(lane, s.n, bsdf, lobe);
    return;
  }
  const Material material = LOAD(SCENE.materials, s.material);
  bsdf_prepare(SCENE, material, s.n, s.ng, wo, bsdf);
  if (FEATURE(FEATURE_WHITTED)) whitted_prepare(material, LOAD(SCENE.classic, s.material), bsdf);
}
