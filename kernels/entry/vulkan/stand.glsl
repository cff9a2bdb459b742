// SPDX-License-Identifier: GPL-3.0-or-later
// The surface that a lane stands at, for the stages after shade.comp: what follows from the hit is computed again,
// which costs less than to keep it; what a program found is loaded. Nothing is decided here.

Surface surface_at(uint lane) {
  Surface s;
  surface_from_hit(SCENE, LOAD(WAVE.hits, lane), WAVE.rays.v[lane].direction, s);
  if (DRAWN) s.n = LOAD(WAVE.normals, lane);
  return s;
}

// What a constant material does with light.
void scattering_of(PathState path, inout Material material, Surface s, vec3 wo, out Bsdf bsdf, out Lobe lobe) {
  material_leave_out_caustics(SCENE, path.ray_kind, material);
  lobe_clear(LOBE_NONE, vec3(0.0f), s.n, lobe);
  bsdf_prepare(SCENE, material, s.n, s.ng, wo, bsdf);
  if (FEATURE(FEATURE_WHITTED)) whitted_prepare(material, LOAD(SCENE.classic, s.material), bsdf);
  if (SCATTERS) path_filter_glossy(JOB.integrator, path, bsdf, lobe);
}

void scattering_at(uint lane, PathState path, Surface s, vec3 wo, out Bsdf bsdf, out Lobe lobe) {
  if (DRAWN) {
    load_scattering(lane, s.n, bsdf, lobe);
    return;
  }
  Material material = LOAD(SCENE.materials, s.material);
  scattering_of(path, material, s, wo, bsdf, lobe);
}
