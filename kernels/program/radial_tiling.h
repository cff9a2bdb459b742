// SPDX-License-Identifier: GPL-3.0-or-later
// The Radial Tiling node: the plane in segments around the origin, each with coordinates along and across the side of a
// polygon whose corners are rounded by circles. With a number of sides that is not whole the last segment is narrower.
#ifndef COTORRA_PROGRAM_RADIAL_TILING_H
#define COTORRA_PROGRAM_RADIAL_TILING_H

#include "math_ops.h"

#ifdef __cplusplus
namespace cotorra {
#endif

// Half of a segment: from the line that divides it from its neighbour to its middle. The side of the polygon is at
// distance 1 along the middle; its corner is round from the divider to the angle `bevel`.
struct TilingHalf {
  float bevel;  // from the divider to the end of the round part
  float straight;  // from there to the middle
  float spline;  // of the round part as much as is eased in
  float rounded;  // what the round part adds to the length of the side
};

// What the node puts out.
struct TilingPoint {
  float along;  // across the segment: from -width to width, or from -1 to 1
  float distance;  // along its middle; 1 on the polygon
  float width;
  float rotation;  // of the middle from the x axis
};

FN TilingHalf tiling_half(float bevel, float middle, float roundness) {
  TilingHalf h;
  h.bevel = bevel;
  h.straight = middle - bevel;
  h.spline = (1.0f - roundness) * bevel;
  h.rounded = roundness * bevel;
  return h;
}

FN float tiling_bevel(float middle, float roundness) { return middle - atan((1.0f - roundness) * tan(middle)); }

// Half the length of the side at a distance from the origin.
FN float tiling_length(IN(TilingHalf) h, float distance) {
  return distance * tan(h.straight) + h.spline * (0.5f * distance + 0.5f) + h.rounded;
}

// Way from the middle along the round part, for a point at `radius`, an angle of `from_divider` away.
FN float tiling_round(IN(TilingHalf) h, float radius, float from_divider) {
  const float c = h.bevel - from_divider;
  const float end = radius * cos(h.straight);
  const float eased = end * c + 0.5f * (1.0f - end) * safe_divide(c * c, h.spline);
  const float full = h.spline * (0.5f * end - 0.5f) + c;
  return radius * sin(h.straight) + select(c < h.spline, eased, full);
}

// What `tiling_round` is divided by where coordinates are normalised.
FN float tiling_round_length(IN(TilingHalf) h, float radius, float distance, float from_divider) {
  const float share = safe_divide(h.bevel - from_divider, h.bevel);
  return lerp(tiling_length(h, distance), tiling_length(h, radius * cos(h.straight)), share);
}

// Distance from the origin to a circle, in a direction at an angle to the axis that its centre is measured from.
FN float circle_distance(vec2 centre, float radius, float angle) {
  const float along = cos(angle) * centre.x + sin(angle) * centre.y;
  return along + safe_sqrt(along * along + radius * radius - dot(centre, centre));
}

// The angle of p from the x axis, 0 to 2 pi.
FN float turn_of(vec3 p) { return angle_of(p.y, p.x) + select(p.y < 0.0f, TWO_PI, 0.0f); }

// A point's segment where all are alike or it is not near the last one; `half_turn` is from a divider to the middle.
// On the straight part, lengths are those of `side`, which is the neighbour's half beside the last segment.
FN TilingPoint tiling_regular(float radius, float from_divider, float half_turn, float roundness, IN(TilingHalf) h,
                              IN(TilingHalf) side, bool straight, bool normalized) {
  TilingPoint r;
  r.rotation = 0.0f;  // radial_tiling's
  const float nearest = min(from_divider, 2.0f * half_turn - from_divider);
  const float middle = abs(half_turn - from_divider);
  const vec2 centre = vec2((1.0f - roundness) / cos(half_turn), 0.0f);
  r.distance = straight ? radius * cos(middle) : radius / circle_distance(centre, roundness, nearest);
  r.along = straight ? r.distance * tan(middle) : tiling_round(h, radius, nearest);
  const float length_here =
      straight ? tiling_length(side, r.distance) : tiling_round_length(h, radius, r.distance, nearest);
  r.along = r.along / (normalized ? length_here : 1.0f);
  r.width = tiling_length(h, 1.0f);
  return r;
}

// Whole numbers of sides. Two sides without corners are parallel lines of no end: nothing to normalise by.
FN TilingPoint tiling_whole(float radius, float from_divider, float half_turn, float roundness, bool normalized) {
  const TilingHalf h = tiling_half(tiling_bevel(half_turn, roundness), half_turn, roundness);
  const bool endless = roundness == 0.0f && half_turn > 1.5f;
  const bool straight = roundness == 0.0f || (from_divider < 2.0f * half_turn - h.bevel && from_divider >= h.bevel);
  TilingPoint r = tiling_regular(radius, from_divider, half_turn, roundness, h, h, straight, normalized && !endless);
  r.width = endless ? 0.0f : r.width;
  return r;
}

// The last, narrower segment, and the round parts that it shares with its neighbours. `last` is half of its angle,
// `signed_angle` counts from the nearer of its dividers, negative within the segment.
FN TilingPoint tiling_last(float radius, float from_divider, float half_turn, float last, IN(TilingHalf) inner,
                           IN(TilingHalf) outer, IN(TilingHalf) regular, vec2 centre, float circle, float signed_angle,
                           bool straight, bool normalized) {
  TilingPoint r;
  r.rotation = 0.0f;
  const float scale = cos(half_turn) / cos(last);
  const bool inside = straight || signed_angle < 0.0f;
  const float middle = abs(last - from_divider);
  const float around = abs(signed_angle);
  const float own = straight ? radius * cos(middle) : radius / circle_distance(centre, circle, signed_angle);
  r.distance = scale * own;
  if (straight) {
    r.along = own * tan(middle) / (normalized ? tiling_length(inner, own) : 1.0f);
  } else if (inside) {
    r.along =
        tiling_round(inner, radius, around) / (normalized ? tiling_round_length(inner, radius, own, around) : 1.0f);
  } else {
    r.along = tiling_round(outer, radius, around) /
              (normalized ? tiling_round_length(outer, radius, r.distance, around) : 1.0f);
  }
  r.along *= inside && !normalized ? scale : 1.0f;
  const float narrow = tan(inner.straight) + scale * (inner.spline * (0.5f / scale + 0.5f) + inner.rounded);
  r.width = inside ? narrow : tiling_length(regular, 1.0f);
  return r;
}

FN TilingPoint tiling_broken(vec3 p, float radius, float sides, float from_divider, float half_turn, float roundness,
                             bool normalized) {
  const float turn = turn_of(p);
  const float last = PI - floor(sides) * half_turn;
  const float end = TWO_PI - 2.0f * last;  // where the last segment begins
  const TilingHalf regular = tiling_half(tiling_bevel(half_turn, roundness), half_turn, roundness);
  const TilingHalf inner = tiling_half(tiling_bevel(last, roundness), last, roundness);
  // The circle that rounds the corner between the last segment and its neighbours touches both sides.
  const float circle = roundness * tan(last) / tan(0.5f * (half_turn + last));
  const vec2 centre = vec2(cos(inner.bevel) / cos(inner.straight) - circle * cos(last),
                           circle * sin(last) - sin(inner.bevel) / cos(inner.straight));
  const float outer_bevel = atan((centre.y + circle * sin(half_turn)) / (centre.x + circle * cos(half_turn)));
  const float outer_roundness = 1.0f - tan(half_turn - outer_bevel) / tan(half_turn);
  const TilingHalf outer = tiling_half(outer_bevel, half_turn, outer_roundness);

  if (turn >= outer_bevel && turn < end - outer_bevel) {
    const bool within = from_divider >= regular.bevel && from_divider < 2.0f * half_turn - regular.bevel;
    const bool straight = within || turn >= end - regular.bevel || turn < regular.bevel;
    const bool beside = turn >= end - half_turn || turn < half_turn;
    TilingHalf side = regular;
    if (beside) side = outer;
    return tiling_regular(radius, from_divider, half_turn, roundness, regular, side, straight, normalized);
  }
  const bool straight = turn >= end + inner.bevel && turn < TWO_PI - inner.bevel;
  const float angle = angle_of(p.y, p.x);
  const bool mirrored = turn >= end - outer_bevel && turn < TWO_PI - last;
  const float signed_angle = mirrored ? -(angle + 2.0f * last) : angle;
  return tiling_last(radius, from_divider, half_turn, last, inner, outer, regular, centre, circle, signed_angle,
                     straight, normalized);
}

FN TilingPoint radial_tiling(bool normalized, vec3 p, float sides, float roundness) {
  const float half_turn = PI / sides;
  const float radius = sqrt(p.x * p.x + p.y * p.y);
  const float turn = turn_of(p);
  const float segment = floor(turn / (2.0f * half_turn));
  const float from_divider = turn - segment * 2.0f * half_turn;
  const bool whole = fraction(sides) == 0.0f;
  TilingPoint r;
  if (whole) {
    r = tiling_whole(radius, from_divider, half_turn, roundness, normalized);
  } else {
    r = tiling_broken(p, radius, sides, from_divider, half_turn, roundness, normalized);
  }
  const float last = PI - floor(sides) * half_turn;
  const bool narrow = !whole && turn >= TWO_PI - 2.0f * last;
  const float middle = narrow ? last : half_turn;
  r.rotation = segment * 2.0f * half_turn + middle;
  r.along = select(radius == 0.0f, 0.0f, select(from_divider < middle, -r.along, r.along));
  return r;
}

FN vec3 op_radial_tiling_v(uint mode, vec3 vector, float sides, float roundness) {
  const bool normalized = (mode & 1u) != 0u;
  const TilingPoint r = radial_tiling(normalized, vector, max(sides, 2.0f), saturate(roundness));
  return vec3(normalized ? 0.5f * r.along + 0.5f : r.along, normalized ? r.distance : r.distance - 1.0f, 0.0f);
}

// Outputs: 0 number of the segment, 1 its width, 2 its rotation.
FN float op_radial_tiling_f(uint mode, vec3 vector, float sides, float roundness) {
  const uint output_kind = (mode >> 1) & 3u;
  const float n = max(sides, 2.0f);
  if (output_kind == 0u) {
    return floor(n * (angle_of(vector.y, vector.x) / TWO_PI + select(vector.y < 0.0f, 1.0f, 0.0f)));
  }
  const TilingPoint r = radial_tiling((mode & 1u) != 0u, vector, n, saturate(roundness));
  return output_kind == 1u ? r.width : r.rotation;
}

#ifdef __cplusplus
}  // namespace cotorra
#endif

#endif
