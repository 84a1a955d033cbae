// kinematics.hpp for several configurations of one arm at once.
#pragma once

#include "kinematics.hpp"
#include "lanes.hpp"

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
STILLREACH_INLINE LaneVector scaled(const LaneVector& a, Wide s) { return {a.x * s, a.y * s, a.z * s}; }

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
      if (const double x = q[i][l]; !(magnitude(x) <= kLargestReducedAngle))
        sine[i][l] = STILLREACH_LIBRARY(sin)(x), cosine[i][l] = STILLREACH_LIBRARY(cos)(x);
}

// q: n. scratch: 2 n. pose: 12. jacobian: 6 n, or null.
inline void kinematics(const ArmView& arm, const Wide* q, Wide* scratch, Wide* pose, Wide* jacobian) {
  const Wide *sine = scratch, *cosine = scratch + arm.n;
  sincos(q, arm.n, scratch, scratch + arm.n);
  const Wide zero = wide(0.0), one = wide(1.0);
  LaneVector x = {one, zero, zero}, y = {zero, one, zero}, z = {zero, zero, one}, p = {zero, zero, zero};
  for (int i = 0; i <= arm.n; ++i) {
    const double* f = arm.placements + 12 * i;
    LaneVector nx, ny;  // one after the other, and component by component: so many numbers stay in registers
    if (i < arm.n && arm.kinds[i] == REVOLUTE) {
      const Wide c = cosine[i], s = sine[i];
      nx = scaled(z, madd(c, wide(f[2]), s * wide(f[5])));
      nx = scale_add(y, madd(c, wide(f[1]), s * wide(f[4])), nx);
      nx = scale_add(x, madd(c, wide(f[0]), s * wide(f[3])), nx);
      ny = scaled(z, madd(c, wide(f[5]), -(s * wide(f[2]))));
      ny = scale_add(y, madd(c, wide(f[4]), -(s * wide(f[1]))), ny);
      ny = scale_add(x, madd(c, wide(f[3]), -(s * wide(f[0]))), ny);
    } else {
      nx = scale_add(x, wide(f[0]), scale_add(y, wide(f[1]), scaled(z, wide(f[2]))));
      ny = scale_add(x, wide(f[3]), scale_add(y, wide(f[4]), scaled(z, wide(f[5]))));
    }
    p = scale_add(x, wide(f[9]), scale_add(y, wide(f[10]), scale_add(z, wide(f[11]), p)));
    z = scale_add(x, wide(f[6]), scale_add(y, wide(f[7]), scaled(z, wide(f[8]))));
    x = nx, y = ny;
    if (i == arm.n) break;
    if (arm.kinds[i] != REVOLUTE) p = scale_add(z, q[i], p);
    if (jacobian) {
      Wide* column = jacobian + 6 * i;
      column[0] = p.x, column[1] = p.y, column[2] = p.z, column[3] = z.x, column[4] = z.y, column[5] = z.z;
    }
  }
  const LaneVector frame[4] = {x, y, z, p};
  for (int j = 0; j < 4; ++j) pose[3 * j] = frame[j].x, pose[3 * j + 1] = frame[j].y, pose[3 * j + 2] = frame[j].z;
  if (!jacobian) return;
  for (int i = 0; i < arm.n; ++i) {
    Wide* column = jacobian + 6 * i;
    if (arm.kinds[i] == REVOLUTE) {
      const LaneVector v = cross({column[3], column[4], column[5]}, {p.x - column[0], p.y - column[1], p.z - column[2]});
      column[0] = v.x, column[1] = v.y, column[2] = v.z;
    } else {
      for (int r = 0; r < 3; ++r) column[r] = column[3 + r], column[3 + r] = zero;
    }
  }
}

STILLREACH_END
