// SPDX-License-Identifier: GPL-3.0-or-later
// Measured distributions of luminaires (IES LM-63), looked up by direction with cubic interpolation as Cycles has it.
// How files become tables is addon/shader/ies.py's.
#ifndef COTORRA_PROGRAM_IES_H
#define COTORRA_PROGRAM_IES_H

#include "../scene_types.h"
#include "math_ops.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// The cell of ascending numbers that x lies in: the first whose upper end is not below x.
FN int ies_cell(IN(SceneData) scene, int first, int count, float x) {
  int low = 0;
  int high = count - 2;
  while (low < high) {
    const int middle = (low + high) / 2;
    if (LOAD(scene.tables, uint(first + middle + 1)) < x) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

// Catmull and Rom's spline between b and c.
FN float ies_spline(float a, float b, float c, float d, float t) {
  const float cubic = d - a + 3.0f * (b - c);
  const float square = 2.0f * a - 5.0f * b + 4.0f * c - d;
  return b + 0.5f * t * (c - a + t * (square + t * cubic));
}

// Strength toward a direction in the light's space, straight down being -z. The table holds the horizontal angles, the
// vertical ones, and a row of strengths for each horizontal angle; rows and columns have one more entry at both ends.
FN float op_ies_f(IN(SceneData) scene, vec3 direction, float table, float horizontal, float vertical) {
  const vec3 n = normalize_or_zero(direction);
  const int rows = int(horizontal);
  const int columns = int(vertical);
  const int h_first = int(table);
  const int v_first = h_first + rows;
  const float v = acos(clamp(-n.z, -1.0f, 1.0f));
  const float h = angle_of(n.x, n.y) + PI;
  const bool below = v < LOAD(scene.tables, uint(v_first)) || h < LOAD(scene.tables, uint(h_first));
  const bool above =
      v >= LOAD(scene.tables, uint(v_first + columns - 1)) || h >= LOAD(scene.tables, uint(h_first + rows - 1));
  if (below || above || is_black(n)) return 0.0f;
  const int row = ies_cell(scene, h_first, rows, h);
  const int column = ies_cell(scene, v_first, columns, v);
  const float h0 = LOAD(scene.tables, uint(h_first + row));
  const float v0 = LOAD(scene.tables, uint(v_first + column));
  const float x = safe_divide(h - h0, LOAD(scene.tables, uint(h_first + row + 1)) - h0);
  const float y = safe_divide(v - v0, LOAD(scene.tables, uint(v_first + column + 1)) - v0);
  float across[4];
  for (int k = 0; k < 4; ++k) {
    const uint at = uint(v_first + columns + (row + k) * (columns + 2) + column);
    across[k] = ies_spline(LOAD(scene.tables, at), LOAD(scene.tables, at + 1u), LOAD(scene.tables, at + 2u),
                           LOAD(scene.tables, at + 3u), y);
  }
  return max(ies_spline(across[0], across[1], across[2], across[3], x), 0.0f);
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
