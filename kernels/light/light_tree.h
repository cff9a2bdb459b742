// SPDX-License-Identifier: GPL-3.0-or-later
// One light out of many, in proportion to a bound of what each may bring (Conty Estevez & Kulla 2018, "Importance
// Sampling of Many Lights with Adaptive Tree Splitting"), and the probability of it. Nodes have eight children here,
// side by side, so that their bounds are one loop. Who builds the tree is native/light_tree.cpp; what is sampled of a
// light stands in sampled.h.
#ifndef COTORRA_LIGHT_TREE_H
#define COTORRA_LIGHT_TREE_H

#include "../math.h"
#include "light_link.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Lamps are all sampled, each at each vertex, while there are no more than these.
const uint LIGHTS_AT_ONCE = 8u;

// A node is rows of numbers, one for each child: what it bounds, how it shines, and where it lies.
const uint LIGHT_FANOUT = 8u;
const uint LIGHT_ROW_CENTRE = 0u;  // three: of a sphere about it, metres
const uint LIGHT_ROW_RADIUS = 3u;
const uint LIGHT_ROW_AXIS = 4u;  // three: of the cone of the directions that its lights face; distant: toward them
const uint LIGHT_ROW_COS = 7u;  // of the cone's half angle
const uint LIGHT_ROW_SIN = 8u;
const uint LIGHT_ROW_COS_SENT = 9u;  // of the angle from what it faces within which each light shines
const uint LIGHT_ROW_ENERGY = 10u;  // luminance of intensity along the axis, W/sr; distant: of irradiance; 0: no child
const uint LIGHT_ROW_CHILD = 11u;  // bits: LIGHT_CHILD_*, and the index of a node, lamp or emitter
const uint LIGHT_ROWS = 12u;
const uint LIGHT_NODE_FLOATS = 96u;

const uint LIGHT_CHILD_LEAF = 0x80000000u;
const uint LIGHT_CHILD_LAMPS = 0x40000000u;  // it is, or holds, a lamp
const uint LIGHT_CHILD_TWO_SIDED = 0x20000000u;  // it shines along its axis and against it
const uint LIGHT_CHILD_DISTANT = 0x10000000u;
const uint LIGHT_CHILD_INDEX = 0x0fffffffu;

// Where the light is received: a point, its normal, and whether light from behind counts as well.
struct LightReceiver {
  vec3 p;
  vec3 n;
  uint both_sides;
  uint set;  // of objects that it is one of (receiver_set)
};

struct LightWeights {
  float w[8];
};

// Signed numbers do not wrap, which tells the compiler that children lie side by side.
FN float light_row(FloatBuffer nodes, uint node, uint row, int k) {
  return LOAD(nodes, int(node * LIGHT_NODE_FLOATS + row * LIGHT_FANOUT) + k);
}

FN vec3 light_row_vector(FloatBuffer nodes, uint node, uint row, int k) {
  return vec3(light_row(nodes, node, row, k), light_row(nodes, node, row + 1u, k), light_row(nodes, node, row + 2u, k));
}

FN uint light_child(FloatBuffer nodes, uint node, int k) {
  return floatBitsToUint(light_row(nodes, node, LIGHT_ROW_CHILD, k));
}

// cos(max(a - b, 0)) of angles from 0 to pi.
FN float cos_less(float cos_a, float sin_a, float cos_b, float sin_b) {
  return select(cos_a >= cos_b, 1.0f, cos_a * cos_b + sin_a * sin_b);
}

// A bound of the irradiance that child k may bring; 0 only where it brings nothing. Selects instead of branches: the
// loop over children vectorises.
FN float light_bound(FloatBuffer nodes, uint node, int k, IN(LightReceiver) at) {
  const uint child = light_child(nodes, node, k);
  const bool distant = (child & LIGHT_CHILD_DISTANT) != 0u;
  const vec3 axis = light_row_vector(nodes, node, LIGHT_ROW_AXIS, k);
  const vec3 to = light_row_vector(nodes, node, LIGHT_ROW_CENTRE, k) - at.p;
  const float cos_o = light_row(nodes, node, LIGHT_ROW_COS, k);
  const float sin_o = light_row(nodes, node, LIGHT_ROW_SIN, k);
  const float r = light_row(nodes, node, LIGHT_ROW_RADIUS, k);
  const float d2 = max(dot(to, to), 1e-30f);
  const float over_d = 1.0f / sqrt(d2);
  const bool inside = select(distant, -1.0f, r * r) >= d2;
  // 1. The half angle under which the bounds show, about the direction to their middle.
  const float sin_seen = min(r * over_d, 1.0f);
  const float sin_u = select(distant, sin_o, sin_seen);
  const float cos_u = select(distant, cos_o, sqrt(1.0f - sin_seen * sin_seen));
  const vec3 wi = select(distant, axis, to * over_d);
  // 2. The widest cosine at the receiver.
  const float facing = dot(at.n, wi);
  const float cos_i = clamp(select(at.both_sides != 0u, abs(facing), facing), -1.0f, 1.0f);
  const float sin_i = sqrt(1.0f - cos_i * cos_i);
  const float received = select(inside, 1.0f, max(cos_less(cos_i, sin_i, cos_u, sin_u), 0.0f));
  // 3. The smallest angle to what one of the lights faces, and whether it shines there. A beam has no width: rounding
  // must not hide it.
  const float along = -dot(axis, wi);
  const float cos_w = clamp(select((child & LIGHT_CHILD_TWO_SIDED) != 0u, abs(along), along), -1.0f, 1.0f);
  const float sin_w = sqrt(1.0f - cos_w * cos_w);
  const float cos_x = cos_less(cos_w, sin_w, cos_o, sin_o);
  const float sin_x = select(cos_w >= cos_o, 0.0f, sin_w * cos_o - cos_w * sin_o);
  const float cos_p = select(inside, 1.0f, cos_less(cos_x, sin_x, cos_u, sin_u));
  const float shines = select(cos_p + 1e-4f >= light_row(nodes, node, LIGHT_ROW_COS_SENT, k), max(cos_p, 1e-4f), 0.0f);
  const float sent = select(distant, 1.0f, shines / max(d2, r * r));
  return light_row(nodes, node, LIGHT_ROW_ENERGY, k) * received * sent;
}

const float LIGHT_NEAR = 2.0f;  // radii

// Is child k a node, and its sphere so near that it shows wide?
FN bool light_child_near(FloatBuffer nodes, uint node, int k, IN(LightReceiver) at) {
  if ((light_child(nodes, node, k) & LIGHT_CHILD_LEAF) != 0u) return false;
  const vec3 to = light_row_vector(nodes, node, LIGHT_ROW_CENTRE, k) - at.p;
  const float reach = LIGHT_NEAR * light_row(nodes, node, LIGHT_ROW_RADIUS, k);
  return dot(to, to) < reach * reach;
}

FN LightWeights light_bounds(IN(SceneData) scene, uint node, IN(LightReceiver) at) {
  LightWeights weights;
  FloatBuffer nodes = scene.light_nodes;
  for (int k = 0; k < int(LIGHT_FANOUT); ++k) weights.w[k] = light_bound(nodes, node, k, at);
  if (!has_links(scene)) return weights;
  for (uint k = 0u; k < LIGHT_FANOUT; ++k) {
    if (!sets_hold(LOAD(scene.light_node_sets, node * LIGHT_FANOUT + k), at.set)) weights.w[k] = 0.0f;
  }
  return weights;
}

FN float light_weights_sum(IN(LightWeights) weights) {
  float sum = 0.0f;
  for (int k = 0; k < int(LIGHT_FANOUT); ++k) sum += weights.w[k];
  return sum;
}

// Bounds of a node's children. The first node's are judged by their own children where they are near: there a sphere
// tells little, and all light samples of a vertex share it.
FN LightWeights light_weights(IN(SceneData) scene, uint node, IN(LightReceiver) at) {
  FloatBuffer nodes = scene.light_nodes;
  LightWeights weights = light_bounds(scene, node, at);
  if (node != 0u) return weights;
  for (int k = 0; k < int(LIGHT_FANOUT); ++k) {
    if (!(weights.w[k] > 0.0f) || !light_child_near(nodes, node, k, at)) continue;
    weights.w[k] = light_weights_sum(light_bounds(scene, light_child(nodes, node, k) & LIGHT_CHILD_INDEX, at));
  }
  return weights;
}

// A light, as the child that it is: LIGHT_CHILD_LEAF, LIGHT_CHILD_LAMPS for a lamp, and its index; INVALID_ID where
// none can light the receiver. `root`: weights of node 0. `u` chooses all the way down, and is left as a number in [0,
// 1) that tells nothing of the choice: samples that are spread evenly in u stay so within each light. After a dozen
// halvings its digits are used up, and `fresh`, a second number, gives it new ones.
FN uint light_tree_pick(IN(SceneData) scene, IN(LightReceiver) at, IN(LightWeights) root, INOUT(float) u, float fresh,
                        OUT(float) probability) {
  FloatBuffer nodes = scene.light_nodes;
  uint node = 0u;
  bool renewed = false;
  probability = 1.0f;
  LightWeights weights = root;
  for (uint depth = 0u; depth < 64u; ++depth) {
    if (depth > 0u) weights = light_weights(scene, node, at);
    const float sum = light_weights_sum(weights);
    if (!(sum > 0.0f)) break;
    // The first child whose share reaches u; rounding may leave u beyond all of them, and it is the last then.
    const float target = u * sum;
    float before = 0.0f;
    float start = 0.0f;
    int chosen = -1;
    for (int k = 0; k < int(LIGHT_FANOUT); ++k) {
      const bool takes = weights.w[k] > 0.0f && (chosen < 0 || target >= before);
      chosen = select(takes, k, chosen);
      start = select(takes, before, start);
      before += weights.w[k];
    }
    const float share = weights.w[chosen];
    probability *= share / sum;
    u = clamp((target - start) / share, 0.0f, 0.99999994f);
    if (!renewed && probability < 1.0f / 4096.0f) {
      u += fresh;
      u -= floor(u);
      renewed = true;
    }
    const uint child = light_child(nodes, node, chosen);
    if ((child & LIGHT_CHILD_LEAF) != 0u) return child & (LIGHT_CHILD_LEAF | LIGHT_CHILD_LAMPS | LIGHT_CHILD_INDEX);
    node = child & LIGHT_CHILD_INDEX;
  }
  probability = 0.0f;
  return INVALID_ID;
}

// The probability with which light_tree_pick takes the light at `place` (node x fanout + child), from its leaf upward.
FN float light_tree_probability(IN(SceneData) scene, uint place, IN(LightReceiver) at) {
  float probability = 1.0f;
  for (uint depth = 0u; depth < 64u && place != INVALID_ID; ++depth) {
    const uint node = place / LIGHT_FANOUT;
    const LightWeights weights = light_weights(scene, node, at);
    const float share = weights.w[place % LIGHT_FANOUT];
    if (!(share > 0.0f)) return 0.0f;
    probability *= share / light_weights_sum(weights);
    place = LOAD(scene.light_parents, node);
  }
  return probability;
}

// Where a lamp stands in the tree, and an emitting triangle, INVALID_ID: it is not sampled.
FN uint light_place_of_lamp(IN(SceneData) scene, uint lamp) { return LOAD(scene.light_places, lamp); }
FN uint light_place_of_triangle(IN(SceneData) scene, uint instance, uint triangle) {
  if (scene.emitter_count == 0u) return INVALID_ID;
  const uint first = LOAD(scene.light_places, scene.light_count + instance);
  if (first == INVALID_ID) return INVALID_ID;
  return LOAD(scene.light_places, first + triangle);
}

// May a ray meet one of the lamps that child k holds?
FN bool light_child_met(FloatBuffer nodes, uint node, int k, vec3 origin, vec3 direction, float t_max) {
  const uint child = light_child(nodes, node, k);
  if ((child & LIGHT_CHILD_LAMPS) == 0u) return false;
  if ((child & LIGHT_CHILD_DISTANT) != 0u) return t_max >= INFINITE_DISTANCE;
  const vec3 to = light_row_vector(nodes, node, LIGHT_ROW_CENTRE, k) - origin;
  const float r = light_row(nodes, node, LIGHT_ROW_RADIUS, k) * 1.0001f;
  const float along = dot(to, direction);
  const vec3 aside = to - direction * along;
  return dot(aside, aside) <= r * r && along + r >= 0.0f && along - r <= t_max;
}

// The lamp that a ray may meet next: a walk over the tree, of which `place` keeps how far it came (0 to begin with).
FN uint light_tree_next(IN(SceneData) scene, vec3 origin, vec3 direction, float t_max, INOUT(uint) place) {
  FloatBuffer nodes = scene.light_nodes;
  while (place != INVALID_ID) {
    const uint node = place / LIGHT_FANOUT;
    const int k = int(place % LIGHT_FANOUT);
    const uint child = light_child(nodes, node, k);
    const bool met = light_child_met(nodes, node, k, origin, direction, t_max);
    const bool leaf = (child & LIGHT_CHILD_LEAF) != 0u;
    if (met && !leaf) {
      place = (child & LIGHT_CHILD_INDEX) * LIGHT_FANOUT;
      continue;
    }
    // The next child, of an ancestor where this was the last.
    while (place != INVALID_ID && place % LIGHT_FANOUT == LIGHT_FANOUT - 1u) {
      place = LOAD(scene.light_parents, place / LIGHT_FANOUT);
    }
    if (place != INVALID_ID) place += 1u;
    if (met) return child & LIGHT_CHILD_INDEX;
  }
  return INVALID_ID;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
