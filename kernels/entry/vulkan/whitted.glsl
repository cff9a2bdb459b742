// SPDX-License-Identifier: GPL-3.0-or-later
// Whitted's recursion on a lane: the rays that a sample still has to trace wait on a stack, and the lane takes the one
// on top when it is done with a ray. What a surface sends out is told in stage/recursion.h.

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

// Makes the ray on top of the stack the lane's. Returns false where none waits.
bool take_pending(uint lane) {
  WaveTree tree = LOAD(WAVE.trees, lane);
  if (tree.pending == 0u) return false;
  tree.pending -= 1u;
  const PendingRay next = LOAD(WAVE.pending, tree.pending * WAVE.lanes + lane);
  tree.medium = next.medium;
  STORE(WAVE.trees, lane, tree);
  store_path(lane, next.path);
  CameraRay ray;
  ray.origin = next.origin;
  ray.t_min = 0.0f;
  ray.direction = next.direction;
  ray.t_max = INFINITE_DISTANCE;
  STORE(WAVE.rays, lane, ray);
  return true;
}
