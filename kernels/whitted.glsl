// SPDX-License-Identifier: GPL-3.0-or-later
// Whitted's recursion on a lane: the rays that a sample still has to trace wait on a stack, and the lane takes the one
// on top when it is done with a ray. What a surface sends out is told in whitted.h.

void plant_tree(uint lane) {
  WaveTree tree;
  tree.pending = 0u;
  tree.medium = INVALID_ID;
  STORE(WAVE.trees, lane, tree);
}

// Did the lane's ray end at a surface? Lanes without one stay in the shading queue while rays wait.
bool stands_at_surface(uint lane) {
  return WAVE.hits.v[lane].instance != INVALID_ID && WAVE.hits.v[lane].t != HIT_ENDED;
}

// What the medium that the ray ran inside of has left of it.
void absorb(uint lane, float distance, inout PathState path) {
  const uint medium = WAVE.trees.v[lane].medium;
  if (medium == INVALID_ID) return;
  path.throughput *= medium_transmittance(WAVE.scene.classic.v[medium].absorption, distance);
  WAVE.paths.v[lane].throughput = path.throughput;
}

void push_child(uint lane, PathState path, Surface s, ClassicMaterial classic, vec3 direction, vec3 weight, uint kind) {
  WavePending ray;
  ray.path = path;
  if (!whitted_advance(ray.path, s, direction, weight, kind, WAVE.whitted_threshold, ray.origin)) return;
  ray.medium = whitted_medium(classic, s, kind);
  ray.direction = direction;
  ray.unused = 0u;
  const uint place = WAVE.trees.v[lane].pending;
  STORE(WAVE.pending, place * WAVE.lanes + lane, ray);
  WAVE.trees.v[lane].pending = place + 1u;
}

// The rays that go on from the surface that the lane stands at.
void push_children(uint lane, PathState path, Surface s, Material material, Bsdf bsdf, vec3 wo) {
  if (path.bounce >= WAVE.whitted_depth) return;
  const ClassicMaterial classic = LOAD(WAVE.scene.classic, s.material);
  WhittedChildren children;
  whitted_children(material, classic, s, bsdf, wo, children);
  push_child(lane, path, s, classic, children.reflected, children.reflected_weight, VISIBLE_GLOSSY);
  push_child(lane, path, s, classic, children.transmitted, children.transmitted_weight, VISIBLE_TRANSMISSION);
}

// Makes the ray on top of the stack the lane's. Returns false where none waits.
bool take_pending(uint lane) {
  WaveTree tree = LOAD(WAVE.trees, lane);
  if (tree.pending == 0u) return false;
  tree.pending -= 1u;
  const WavePending next = LOAD(WAVE.pending, tree.pending * WAVE.lanes + lane);
  tree.medium = next.medium;
  STORE(WAVE.trees, lane, tree);
  STORE(WAVE.paths, lane, next.path);
  CameraRay ray;
  ray.origin = next.origin;
  ray.t_min = 0.0f;
  ray.direction = next.direction;
  ray.t_max = INFINITE_DISTANCE;
  STORE(WAVE.rays, lane, ray);
  return true;
}
