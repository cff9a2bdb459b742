// SPDX-License-Identifier: GPL-3.0-or-later
// The nearest triangle along a ray, and whether there is any: traversal of an 8-wide BVH whose boxes are kept in bytes,
// for devices without ray queries. Who builds it is native/wide_bvh.cpp; the CPU device has Embree instead.
#ifndef COTORRA_BVH_H
#define COTORRA_BVH_H

#include "surface.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017: nodes
// of 80 bytes with eight children, whose boxes stand on a grid of 256 steps along each axis; the children's slots are
// ordered by octant, so that no distances need sorting.
struct BvhNode {
  vec3 origin;  // of the grid
  uint exponents;  // bytes: exponents of the grid's step in x, y, z, biased as a float's; the slots that hold nodes
  uint child_base;  // children that are nodes follow each other, in order of slots
  uint leaf_base;  // what the children that are leaves hold follows each other too
  uint meta[2];  // a byte a slot: see bvh_meta_node, bvh_meta_leaf; 0: empty
  uint low[6];  // a byte a slot, slots 0-3 and 4-7: x, x, y, y, z, z
  uint high[6];
};

// Of a leaf below an instance; or of the BVH in world space, where each triangle knows its instance and visibility.
struct BvhTriangle {
  vec3 p0;
  uint instance;  // INVALID_ID: the instance that was entered
  vec3 p1;
  uint triangle;
  vec3 p2;
  uint mask;  // VISIBLE_*
};

// Of a leaf of the top level.
struct BvhInstance {
  vec4 x;  // rows of world-to-object
  vec4 y;
  vec4 z;
  uint root;
  uint instance;
  uint mask;
  uint unused;
};

BUFFER_REF(BvhNode, BvhNodeBuffer)
BUFFER_REF(BvhTriangle, BvhTriangleBuffer)
BUFFER_REF(BvhInstance, BvhInstanceBuffer)

struct BvhData {
  BvhNodeBuffer nodes;
  BvhTriangleBuffer triangles;
  BvhInstanceBuffer instances;
  uint world_root;  // node above the triangles in world space, INVALID_ID: there are none
  uint top_root;  // node above the instances, likewise
};

const int BVH_STACK = 48;  // the builder keeps its trees so low
const uint BVH_LEAVES = 0x00ffffffu;  // bits of hits that stand for what leaves hold; those above for nodes
const uint BVH_ROOT_HITS = 0x80000000u;  // the hits of a parent that has a root as its only child

// What a slot's byte says: bits to set in the hits (upper three), and where (lower five).
FN uint bvh_meta_node(uint slot) { return 32u | (24u + slot); }
FN uint bvh_meta_leaf(uint first, uint count) { return (((1u << count) - 1u) << 5) | first; }

struct BvhRay {
  vec3 origin;
  uint octant;  // slot ^ octant is the larger, the nearer the slot's child
  vec3 direction;
  uint unused;
  vec3 inverse;  // 1 / direction, finite
};

FN float bvh_inverse(float d) { return 1.0f / select(abs(d) > 1e-18f, d, select(d < 0.0f, -1e-18f, 1e-18f)); }

FN void bvh_ray(vec3 origin, vec3 direction, OUT(BvhRay) ray) {
  ray.origin = origin;
  ray.direction = direction;
  ray.inverse = vec3(bvh_inverse(direction.x), bvh_inverse(direction.y), bvh_inverse(direction.z));
  ray.octant =
      select(direction.x < 0.0f, 0u, 1u) | select(direction.y < 0.0f, 0u, 2u) | select(direction.z < 0.0f, 0u, 4u);
  ray.unused = 0u;
}

// A world-space ray in the space of an instance; its direction keeps its length there, so that distances stay.
FN void bvh_ray_into(IN(BvhInstance) i, vec3 origin, vec3 direction, OUT(BvhRay) ray) {
  const vec3 x = vec3(i.x.x, i.x.y, i.x.z);
  const vec3 y = vec3(i.y.x, i.y.y, i.y.z);
  const vec3 z = vec3(i.z.x, i.z.y, i.z.z);
  bvh_ray(vec3(dot(x, origin) + i.x.w, dot(y, origin) + i.y.w, dot(z, origin) + i.z.w),
          vec3(dot(x, direction), dot(y, direction), dot(z, direction)), ray);
}

FN float bvh_byte(uint word, uint i) { return float(int((word >> (8u * i)) & 255u)); }

// Four slots of a node: near and far are the words of the sides that the ray enters and leaves through.
FN uint bvh_hits_four(uint meta, uint near_x, uint near_y, uint near_z, uint far_x, uint far_y, uint far_z, vec3 scale,
                      vec3 base, uint octant, float t_min, float t_max) {
  uint hits = 0u;
  for (uint i = 0u; i < 4u; ++i) {
    const float near_t = max(bvh_byte(near_x, i) * scale.x + base.x,
                             max(bvh_byte(near_y, i) * scale.y + base.y, bvh_byte(near_z, i) * scale.z + base.z));
    const float far_t = min(bvh_byte(far_x, i) * scale.x + base.x,
                            min(bvh_byte(far_y, i) * scale.y + base.y, bvh_byte(far_z, i) * scale.z + base.z));
    // The factor covers the rounding of both sides.
    const bool met = max(near_t, t_min) <= min(far_t * 1.0000008f, t_max);
    const uint byte = (meta >> (8u * i)) & 255u;
    const uint where = (byte & 24u) == 24u ? byte ^ octant : byte;
    hits |= select(met, (byte >> 5) << (where & 31u), 0u);
  }
  return hits;
}

// Children of a node that the ray meets between t_min and t_max: a bit for each thing that a met leaf holds, and one
// for each met node, the highest for the nearest.
FN uint bvh_node_hits(IN(BvhNode) node, IN(BvhRay) ray, float t_min, float t_max) {
  const vec3 scale =
      vec3(uintBitsToFloat((node.exponents & 255u) << 23), uintBitsToFloat(((node.exponents >> 8) & 255u) << 23),
           uintBitsToFloat(((node.exponents >> 16) & 255u) << 23)) *
      ray.inverse;
  const vec3 base = (node.origin - ray.origin) * ray.inverse;
  const bool x = ray.direction.x < 0.0f;
  const bool y = ray.direction.y < 0.0f;
  const bool z = ray.direction.z < 0.0f;
  const uint first = bvh_hits_four(node.meta[0], select(x, node.high[0], node.low[0]),
                                   select(y, node.high[2], node.low[2]), select(z, node.high[4], node.low[4]),
                                   select(x, node.low[0], node.high[0]), select(y, node.low[2], node.high[2]),
                                   select(z, node.low[4], node.high[4]), scale, base, ray.octant, t_min, t_max);
  return first | bvh_hits_four(node.meta[1], select(x, node.high[1], node.low[1]), select(y, node.high[3], node.low[3]),
                               select(z, node.high[5], node.low[5]), select(x, node.low[1], node.high[1]),
                               select(y, node.low[3], node.high[3]), select(z, node.low[5], node.high[5]), scale, base,
                               ray.octant, t_min, t_max);
}

// Index of the node that the highest bit of `hits` stands for; `hits` holds the node slots of the parent in its lowest
// byte.
FN uint bvh_nearest_child(uint base, uint hits, uint octant) {
  const uint slot = (uint(findMSB(hits)) - 24u) ^ octant;
  return base + uint(bitCount(hits & 255u & ((1u << slot) - 1u)));
}

// Does the ray meet the triangle between t_min and hit.t, and is it not the one that it left? If so the hit becomes
// this one. The edges are tested in Pluecker coordinates about the ray's origin: an edge that two triangles share gives
// the same bits for both but for the sign, so that no ray slips through between them.
FN bool bvh_meet_triangle(IN(BvhTriangle) triangle, IN(BvhRay) ray, float t_min, uint entered, uvec2 left,
                          INOUT(Hit) hit) {
  const vec3 v0 = triangle.p0 - ray.origin;
  const vec3 v1 = triangle.p1 - ray.origin;
  const vec3 v2 = triangle.p2 - ray.origin;
  const vec3 e0 = v2 - v0;
  const vec3 e1 = v0 - v1;
  const vec3 e2 = v1 - v2;
  const float u = dot(cross(e0, v2 + v0), ray.direction);
  const float v = dot(cross(e1, v0 + v1), ray.direction);
  const float w = dot(cross(e2, v1 + v2), ray.direction);
  if (min(u, min(v, w)) < 0.0f && max(u, max(v, w)) > 0.0f) return false;
  const vec3 n = cross(e0, e1);
  const float along = dot(n, ray.direction);
  const float sum = u + v + w;
  if (along == 0.0f || sum == 0.0f) return false;
  const float t = dot(v0, n) / along;
  if (!(t > t_min && t < hit.t)) return false;
  const uint instance = select(triangle.instance == INVALID_ID, entered, triangle.instance);
  if (ray_passes(instance, triangle.triangle, left)) return false;
  hit.t = t;
  hit.u = u / sum;
  hit.v = v / sum;
  hit.triangle = triangle.triangle;
  hit.instance = instance;
  return true;
}

// Where a ray stands in the tree.
struct BvhWalk {
  BvhRay ray;  // in the space of the tree below
  uint base;  // the first child of a node
  uint hits;  // its children that were met and wait, as bvh_node_hits tells them
  uint leaf_base;
  uint leaves;  // likewise of what leaves hold
  uint instance;  // that was entered
  uint top;  // 1: leaves hold instances
};

// At a root.
FN void bvh_walk_from(uint root, INOUT(BvhWalk) walk) {
  walk.base = root;
  walk.hits = select(root == INVALID_ID, 0u, BVH_ROOT_HITS);
  walk.leaf_base = 0u;
  walk.leaves = 0u;
}

// Triangles in world space come first, then the instances.
FN void bvh_walk_begin(IN(BvhData) bvh, vec3 origin, vec3 direction, OUT(BvhWalk) walk) {
  bvh_ray(origin, direction, walk.ray);
  walk.instance = INVALID_ID;
  walk.top = select(bvh.world_root == INVALID_ID, 1u, 0u);
  bvh_walk_from(select(walk.top != 0u, bvh.top_root, bvh.world_root), walk);
}

// The nearest of the nodes that wait; it waits no longer.
FN uint bvh_take_node(INOUT(BvhWalk) walk) {
  const uint child = bvh_nearest_child(walk.base, walk.hits, walk.ray.octant);
  walk.hits &= ~(1u << uint(findMSB(walk.hits)));
  return child;
}

FN uint bvh_take_leaf(INOUT(BvhWalk) walk) {
  const uint leaf = walk.leaf_base + uint(findLSB(walk.leaves));
  walk.leaves &= walk.leaves - 1u;
  return leaf;
}

// Goes on to the children of a node.
FN void bvh_open(IN(BvhNode) node, float t_min, float t_max, INOUT(BvhWalk) walk) {
  const uint met = bvh_node_hits(node, walk.ray, t_min, t_max);
  walk.base = node.child_base;
  walk.hits = (met & ~BVH_LEAVES) | (node.exponents >> 24);
  walk.leaf_base = node.leaf_base;
  walk.leaves = met & BVH_LEAVES;
}

FN bool bvh_meet_leaf(IN(BvhTriangle) triangle, IN(BvhWalk) walk, float t_min, uint mask, uvec2 left, INOUT(Hit) hit) {
  return (triangle.mask & mask) != 0u && bvh_meet_triangle(triangle, walk.ray, t_min, walk.instance, left, hit);
}

FN void bvh_enter(IN(BvhInstance) instance, vec3 origin, vec3 direction, INOUT(BvhWalk) walk) {
  bvh_ray_into(instance, origin, direction, walk.ray);
  walk.instance = instance.instance;
  walk.top = 0u;
  bvh_walk_from(instance.root, walk);
}

FN void bvh_leave(vec3 origin, vec3 direction, INOUT(BvhWalk) walk) {
  walk.top = 1u;
  bvh_ray(origin, direction, walk.ray);
}

// Goes on with what waited: nodes, or what leaves hold.
FN void bvh_resume(uint base, uint bits, INOUT(BvhWalk) walk) {
  const bool nodes = bits > BVH_LEAVES;
  walk.base = base;
  walk.hits = select(nodes, bits, 0u);
  walk.leaf_base = base;
  walk.leaves = select(nodes, 0u, bits);
}

// In bvh_trace alone. A function would copy the stack in GLSL.
#define BVH_WAIT(BASE, BITS) \
  do {                       \
    bases[depth] = (BASE);   \
    stacked[depth] = (BITS); \
    depth += 1;              \
  } while (false)

// The nearest hit between t_min and hit.t of what the mask sees, into `hit`; or, with `any`, whether there is one. The
// ray does not meet triangle left.y of instance left.x, or with LEFT_ALL_OTHERS other instances.
FN bool bvh_trace(IN(BvhData) bvh, vec3 origin, vec3 direction, float t_min, uint mask, bool any, uvec2 left,
                  INOUT(Hit) hit) {
  uint bases[BVH_STACK];
  uint stacked[BVH_STACK];
  int depth = 0;
  bool found = false;
  BvhWalk walk;
  bvh_walk_begin(bvh, origin, direction, walk);
  if (walk.top == 0u && bvh.top_root != INVALID_ID) BVH_WAIT(bvh.top_root, BVH_ROOT_HITS);
  int floor_depth = depth;  // where the stack stood before an instance
  while (true) {
    if (walk.hits > BVH_LEAVES) {  // 1. The nearest node: its children are next.
      const uint child = bvh_take_node(walk);
      if (walk.hits > BVH_LEAVES) BVH_WAIT(walk.base, walk.hits);
      bvh_open(LOAD(bvh.nodes, child), t_min, hit.t, walk);
    }
    while (walk.leaves != 0u) {  // 2. What its leaves hold.
      const uint leaf = bvh_take_leaf(walk);
      if (walk.top == 0u) {
        if (!bvh_meet_leaf(LOAD(bvh.triangles, leaf), walk, t_min, mask, left, hit)) continue;
        if (any) return true;
        found = true;
        continue;
      }
      const BvhInstance instance = LOAD(bvh.instances, leaf);
      if ((instance.mask & mask) == 0u) continue;
      if (walk.leaves != 0u) BVH_WAIT(walk.leaf_base, walk.leaves);
      if (walk.hits > BVH_LEAVES) BVH_WAIT(walk.base, walk.hits);
      floor_depth = depth;
      bvh_enter(instance, origin, direction, walk);
    }
    if (walk.hits > BVH_LEAVES) continue;
    // 3. Back to the top level, or to what waits.
    if (walk.top == 0u && depth == floor_depth) bvh_leave(origin, direction, walk);
    if (depth == 0) return found;
    depth -= 1;
    bvh_resume(bases[depth], stacked[depth], walk);
  }
}
#undef BVH_WAIT

#ifdef __cplusplus
static_assert(sizeof(BvhNode) == 80 && sizeof(BvhTriangle) == 48 && sizeof(BvhInstance) == 64);
}  // namespace cotorra
#endif

#endif
