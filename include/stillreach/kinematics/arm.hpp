// Any serial chain, brought into the form that the kinematics runs on: every joint moves about or along its frame's z,
// and the next z is that one turned about x. A turn about z before or after that is the joint's own, or its
// neighbour's.
#pragma once

#include "stillreach/simd/scalar.hpp"
#include "stillreach/types.hpp"

STILLREACH_BEGIN

// Frames are 12 numbers: rotation by columns (9), then translation (3).
STILLREACH_INLINE void compose(const double* a, const double* b, double* out) {
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 3; ++i) {
      const double* column = b + 3 * j;
      out[3 * j + i] =
          madd(a[i], column[0], madd(a[3 + i], column[1], a[6 + i] * column[2])) + (j == 3 ? a[9 + i] : 0.0);
    }
}

// A rotation (columns) that turns z onto the unit vector `axis`; the identity, exactly, for z itself.
inline void rotation_from_z(const double* axis, double* rotation) {
  const double x = axis[0], y = axis[1], z = axis[2];
  if (z < 0.0) {  // the formula below is singular at -z: solve for the axis turned by pi about x, and turn back
    const double turned[3] = {x, -y, -z};
    rotation_from_z(turned, rotation);
    for (int j = 0; j < 3; ++j) {
      rotation[3 * j + 1] = -rotation[3 * j + 1];
      rotation[3 * j + 2] = -rotation[3 * j + 2];
    }
    return;
  }
  const double f = 1.0 / (1.0 + z);
  const double r[9] = {1 - x * x * f, -x * y * f, -x, -x * y * f, 1 - y * y * f, -y, x, y, z};
  for (int i = 0; i < 9; ++i) rotation[i] = r[i];
}

// Cosine and sine of an angle.
struct Turn {
  double c, s;
};
// Of the direction of (c, s), of any length; of angle 0 where both are 0.
STILLREACH_INLINE Turn turn_along(double c, double s) {
  const double size = square_root(madd(c, c, s * s));
  return size == 0.0 ? Turn{1.0, 0.0} : Turn{c / size, s / size};
}
STILLREACH_INLINE Turn operator+(Turn a, Turn b) { return turn_along(a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s); }
STILLREACH_INLINE Turn operator-(Turn a) { return {a.c, -a.s}; }

constexpr double kNoAngle = 4e-16;  // sine of an angle that is rounding alone

// A rotation as a turn about z, one about x and one about z again (Euler, 1776). The first one is `wanted` where the
// axes are parallel, and any would do; elsewhere two are possible, half a turn apart, and it is the one nearer to
// `wanted`.
struct ThreeTurns {
  Turn first, tilt, last;
};
inline ThreeTurns three_turns(const double* rotation, Turn wanted) {
  const double x = rotation[6], y = rotation[7], z = rotation[8], across = square_root(madd(x, x, y * y));
  ThreeTurns t;
  if (across <= kNoAngle) {
    t.first = wanted;
    t.tilt = {z < 0.0 ? -1.0 : 1.0, 0.0};
  } else {
    t.first = turn_along(-y, x);
    const double side = t.first.c * wanted.c + t.first.s * wanted.s < 0.0 ? -1.0 : 1.0;
    t.first = {side * t.first.c, side * t.first.s};
    t.tilt = turn_along(z, side * across);
  }
  const double c = t.first.c, s = t.first.s;
  t.last = turn_along(madd(c, rotation[0], s * rotation[1]), -madd(c, rotation[3], s * rotation[4]));
  return t;
}

// kinds: n. placements: n + 1 row-major 4x4 poses (the last one is the tool), axes: n unit vectors in the joint's own
// frame. links: n, which the arm goes on using.
inline ArmView align_axes(int n, const JointKind* kinds, const double* placements, const double* axes, Link* links) {
  ArmView arm{n, links, {}, {}, nullptr};
  double undo[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};  // inverse of the turn given to the previous joint's frame
  Turn before{1.0, 0.0};                                   // what the way to joint i leaves it to turn about its z
  for (int i = 0; i <= n; ++i) {
    const double* T = placements + 16 * i;
    const double frame[12] = {T[0], T[4], T[8], T[1], T[5], T[9], T[2], T[6], T[10], T[3], T[7], T[11]};
    double turn[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, half[12], way[12];
    if (i < n) rotation_from_z(axes + 3 * i, turn);
    compose(undo, frame, half);
    compose(half, turn, way);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) undo[3 * c + r] = turn[3 * r + c];
    if (i == 0) {
      for (int j = 0; j < 4; ++j)
        for (int r = 0; r < 3; ++r) arm.base[4 * j + r] = way[3 * j + r];
      continue;
    }
    Link& link = links[i - 1];
    const ThreeTurns t = three_turns(way, -before);
    const double c = t.first.c, s = t.first.s;
    const Turn own = before + t.first;
    if (i == 1) {  // the base turns instead
      for (int r = 0; r < 3; ++r) {
        const double x = arm.base[r], y = arm.base[4 + r];
        arm.base[r] = madd(c, x, s * y);
        arm.base[4 + r] = madd(c, y, -(s * x));
      }
    }
    link.kind = kinds[i - 1];
    link.shift[0] = madd(c, way[9], s * way[10]);
    link.shift[1] = madd(c, way[10], -(s * way[9]));
    link.shift[2] = way[11];
    link.tilt[0] = t.tilt.c;
    link.tilt[1] = t.tilt.s;
    const bool none = i == 1 || (own.c > 0.0 && magnitude(own.s) <= kNoAngle);
    link.turn[0] = none ? 1.0 : own.c;
    link.turn[1] = none ? 0.0 : own.s;
    link.plain = none && link.kind == JointKind::REVOLUTE;
    before = t.last;
  }
  arm.end[0] = before.c;
  arm.end[1] = before.s;
  return arm;
}

STILLREACH_END
