// kinematics.hpp for several configurations of one arm at once.
#pragma once

#include "stillreach/kinematics/kinematics.hpp"
#include "stillreach/simd/lanes.hpp"

STILLREACH_BEGIN

struct LaneVector {
  Wide x, y, z;
};

STILLREACH_INLINE LaneVector cross(const LaneVector& a, const LaneVector& b) {
  return {madd(a.y, b.z, -(a.z * b.y)), madd(a.z, b.x, -(a.x * b.z)), madd(a.x, b.y, -(a.y * b.x))};
}
STILLREACH_INLINE LaneVector scale_add(const LaneVector& a, Wide s, const LaneVector& b) {
  return {madd(a.x, s, b.x), madd(a.y, s, b.y), madd(a.z, s, b.z)};
}
STILLREACH_INLINE void turn_first(Wide c, Wide s, LaneVector& a, LaneVector& b) {
  turn_first(c, s, a.x, b.x);
  turn_first(c, s, a.y, b.y);
  turn_first(c, s, a.z, b.z);
}
STILLREACH_INLINE void turn_second(Wide c, Wide s, LaneVector& a, LaneVector& b) {
  turn_second(c, s, a.x, b.x);
  turn_second(c, s, a.y, b.y);
  turn_second(c, s, a.z, b.z);
}

// sine, cosine: n.
inline void sincos(const Wide* q, int n, Wide* sine, Wide* cosine) {
  Lanes reducible = every_lane();
  for (int i = 0; i < n; ++i) {
    sincos(q[i], sine[i], cosine[i]);
    reducible &= magnitude(q[i]) <= wide(kLargestReducedAngle);
  }
  if (all(reducible)) return;
  for (int i = 0; i < n; ++i)
    for (int l = 0; l < kLanes; ++l)
      if (!(magnitude(q[i][l]) <= kLargestReducedAngle)) {
        double s, c;
        sincos_large(q[i][l], s, c);
        sine[i][l] = s;
        cosine[i][l] = c;
      }
}

// q: n. scratch: 2 n. pose: 12. jacobian: 6 n, or null.
inline void kinematics(const ArmView& arm, const Wide* q, Wide* scratch, Wide* pose, Wide* jacobian) {
  Wide *sine = scratch, *cosine = scratch + arm.n;
  sincos(q, arm.n, sine, cosine);
  const auto column_of = [&arm](int j) {
    return LaneVector{wide(arm.base[4 * j]), wide(arm.base[4 * j + 1]), wide(arm.base[4 * j + 2])};
  };
  LaneVector x = column_of(0), y = column_of(1), z = column_of(2), p = column_of(3);
  for (int i = 0; i < arm.n; ++i) {
    const Link& link = arm.links[i];
    if (!link.plain) {
      add_turn(link, sine[i], cosine[i]);
      if (link.kind != JointKind::REVOLUTE) p = scale_add(z, q[i], p);
    }
    if (jacobian) {
      Wide* column = jacobian + 6 * i;
      column[0] = p.x;
      column[1] = p.y;
      column[2] = p.z;
      column[3] = z.x;
      column[4] = z.y;
      column[5] = z.z;
    }
    turn_first(cosine[i], sine[i], x, y);
    p = scale_add(x, wide(link.shift[0]), scale_add(y, wide(link.shift[1]), scale_add(z, wide(link.shift[2]), p)));
    turn_second(wide(link.tilt[0]), wide(link.tilt[1]), y, z);
  }
  turn_first(wide(arm.end[0]), wide(arm.end[1]), x, y);
  const LaneVector frame[4] = {x, y, z, p};
  for (int j = 0; j < 4; ++j) {
    pose[3 * j] = frame[j].x;
    pose[3 * j + 1] = frame[j].y;
    pose[3 * j + 2] = frame[j].z;
  }
  if (!jacobian) return;
  for (int i = 0; i < arm.n; ++i) {
    Wide* column = jacobian + 6 * i;
    if (arm.links[i].kind == JointKind::REVOLUTE) {
      const LaneVector v =
          cross({column[3], column[4], column[5]}, {p.x - column[0], p.y - column[1], p.z - column[2]});
      column[0] = v.x;
      column[1] = v.y;
      column[2] = v.z;
    } else {
      for (int r = 0; r < 3; ++r) {
        column[r] = column[3 + r];
        column[3 + r] = wide(0.0);
      }
    }
  }
}

STILLREACH_END
