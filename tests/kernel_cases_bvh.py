# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kernel functions that CPU and Vulkan must agree on, continued: the BVH of devices without ray queries.

That whole scenes are traced right is tests/test_vulkan_device.py's and tests/test_wide_bvh.py's.
"""

from __future__ import annotations

import numpy as np

from kernel_cases import DIRECTION, POINT, ROUNDING
from kernel_inputs import choices, directions, integers, points, records, uniform, vectors
from kernel_parity import Case


def nodes(rng: np.random.Generator, n: int) -> np.ndarray:
    """Nodes with boxes in all slots, their grids a few metres wide; half of the slots are nodes, the others leaves."""
    made = records('BvhNode', origin=points(1.0), child_base=integers(1000), leaf_base=integers(1000))(rng, n)
    steps = rng.integers(120, 124, (n, 3)).astype(np.uint32)  # 2^-7 to 2^-4 m
    is_node = rng.random((n, 8)) < 0.5
    made['exponents'] = steps[:, 0] | steps[:, 1] << 8 | steps[:, 2] << 16
    made['exponents'] |= (is_node << np.arange(24, 32)).sum(axis=1).astype(np.uint32)
    slots = np.arange(8)
    meta = np.where(is_node, 32 | (24 + slots), (3 << 5) | 2 * slots).astype(np.uint8)
    made['meta'] = meta.view(np.uint32)
    low = rng.integers(0, 200, (n, 3, 8))
    high = low + rng.integers(0, 55, (n, 3, 8))
    made['low'] = low.astype(np.uint8).reshape(n, 24).view(np.uint32)
    made['high'] = high.astype(np.uint8).reshape(n, 24).view(np.uint32)
    return made


ROW = ('vec4', lambda rng, n: rng.normal(size=(n, 4)).astype(np.float32))
RAY = 'BvhRay ray; bvh_ray(origin, direction, ray); '

CASES = [
    Case(
        'bvh_rays',
        RAY + 'octant = ray.octant; inverse = ray.inverse; tilt = bvh_inverse(d);'
        'BvhInstance i; i.x = x; i.y = y; i.z = z; i.root = 0u; i.instance = 0u; i.mask = 0u; i.unused = 0u;'
        'BvhRay inside; bvh_ray_into(i, origin, direction, inside); o = inside.origin; v = inside.direction;',
        {
            'origin': POINT,
            'direction': DIRECTION,
            'x': ROW,
            'y': ROW,
            'z': ROW,
            'd': ('float', choices(0.0, -0.0, 1e-30, -1e-30, 0.5)),
        },
        {'octant': 'uint', 'inverse': 'vec3', 'tilt': 'float', 'o': 'vec3', 'v': 'vec3'},
        ROUNDING,
    ),
    Case(
        'bvh_bytes',
        'byte = bvh_byte(word, i); node = bvh_meta_node(slot); leaf = bvh_meta_leaf(slot, count);'
        'child = bvh_nearest_child(word & 1023u, word | 0x01000000u, slot);',
        {
            'word': ('uint', integers()),
            'i': ('uint', integers(4)),
            'slot': ('uint', integers(8)),
            'count': ('uint', integers(4)),
        },
        {'byte': 'float', 'node': 'uint', 'leaf': 'uint', 'child': 'uint'},
    ),
    Case(
        'bvh_boxes',
        RAY + 'met = bvh_node_hits(node, ray, 0.0f, t_max);'
        'four = bvh_hits_four(node.meta[0], node.low[0], node.low[2], node.low[4], node.high[0], node.high[2],'
        ' node.high[4], vec3(0.01f), direction, ray.octant, 0.0f, t_max);',
        {
            'node': ('BvhNode', nodes),
            'origin': POINT,
            'direction': DIRECTION,
            't_max': ('float', uniform(0.1, 20.0)),
        },
        {'met': 'uint', 'four': 'uint'},
    ),
    Case(
        'bvh_walks',
        'BvhData none; none.world_root = INVALID_ID; none.top_root = root; BvhWalk walk;'
        'bvh_walk_begin(none, origin, direction, walk); begun = uvec3(walk.hits, walk.leaves, walk.top);'
        'bvh_open(node, 0.0f, t_max, walk); opened = uvec3(walk.base, walk.hits, walk.leaves);'
        'child = 0u; leaf = 0u;'
        'if (walk.hits > BVH_LEAVES) child = bvh_take_node(walk); if (walk.leaves != 0u) leaf = bvh_take_leaf(walk);'
        'taken = uvec3(walk.hits, walk.leaves, walk.leaf_base);'
        'BvhInstance i; i.x = x; i.y = y; i.z = z; i.root = root; i.instance = 5u; i.mask = 0u; i.unused = 0u;'
        'bvh_enter(i, origin, direction, walk); entered = uvec3(walk.instance, walk.base, walk.ray.octant);'
        'bvh_resume(root, bits, walk); resumed = uvec3(walk.hits, walk.leaves, walk.base);'
        'bvh_leave(origin, direction, walk); bvh_walk_from(INVALID_ID, walk);'
        'left = uvec3(walk.hits, walk.ray.octant, walk.top);',
        {
            'node': ('BvhNode', nodes),
            'origin': POINT,
            'direction': DIRECTION,
            't_max': ('float', uniform(0.1, 20.0)),
            'root': ('uint', integers(1000)),
            'bits': ('uint', integers()),
            'x': ROW,
            'y': ROW,
            'z': ROW,
        },
        dict.fromkeys(('begun', 'opened', 'taken', 'entered', 'resumed', 'left'), 'uvec3')
        | {'child': 'uint', 'leaf': 'uint'},
    ),
    Case(
        'bvh_triangles',
        RAY
        + 'hit.t = 1e30f; hit.u = 0.0f; hit.v = 0.0f; hit.triangle = 0u; hit.instance = INVALID_ID; hit.crossed = 0u;'
        'BvhTriangle triangle; triangle.p0 = p0; triangle.p1 = p1; triangle.p2 = p2; triangle.instance = INVALID_ID;'
        'triangle.triangle = 7u; triangle.mask = VISIBLE_ALL;'
        'met = bvh_meet_triangle(triangle, ray, 0.0f, 3u, uvec2(3u, left), hit) ? 1u : 0u;'
        'BvhWalk walk; walk.ray = ray; walk.instance = 3u; again.t = 1e30f; again.u = 0.0f; again.v = 0.0f;'
        'again.triangle = 0u; again.instance = INVALID_ID; again.crossed = 0u;'
        'of_leaf = bvh_meet_leaf(triangle, walk, 0.0f, mask, uvec2(left, 7u), again) ? 1u : 0u;'
        'BvhData none; none.world_root = INVALID_ID; none.top_root = INVALID_ID;'
        'empty = bvh_trace(none, origin, direction, 0.0f, VISIBLE_ALL, true, uvec2(left, left), hit) ? 1u : 0u;'
        'passed = ray_passes(left, 7u, uvec2(3u, left)) ? 1u : 0u;',
        {
            'origin': ('vec3', points(0.5)),
            'direction': ('vec3', directions()),
            'mask': ('uint', integers(128)),
            'left': ('uint', choices(3, 7, 0xFFFFFFFE, 0xFFFFFFFF)),
            **{name: ('vec3', vectors(uniform(-2.0, 2.0))) for name in ('p0', 'p1', 'p2')},
        },
        {'hit': 'Hit', 'again': 'Hit', 'met': 'uint', 'of_leaf': 'uint', 'empty': 'uint', 'passed': 'uint'},
        ROUNDING,
    ),
]
