// Any serial chain, brought into the form that the kinematics runs on: every joint axis is its frame's z.
#pragma once

#include "types.hpp"
#include "scalar.hpp"

STILLREACH_BEGIN

// Frames are 12 numbers: rotation by columns (9), then translation (3).
STILLREACH_INLINE void compose(const double* a, const double* b, double* out) {
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 3; ++i) {
      const double* column = b + 3 * j;
      out[3 * j + i] = madd(a[i], column[0], madd(a[3 + i], column[1], a[6 + i] * column[2])) + (j == 3 ? a[9 + i] : 0.0);
    }
}

// A rotation (columns) that turns z onto the unit vector `axis`; the identity, exactly, for z itself.
inline void rotation_from_z(const double* axis, double* rotation) {
  const double x = axis[0], y = axis[1], z = axis[2];
  if (z < 0.0) {  // the formula below is singular at -z: solve for the axis turned by pi about x, and turn back
    const double turned[3] = {x, -y, -z};
    rotation_from_z(turned, rotation);
    for (int j = 0; j < 3; ++j) rotation[3 * j + 1] = -rotation[3 * j + 1], rotation[3 * j + 2] = -rotation[3 * j + 2];
    return;
  }
  const double f = 1.0 / (1.0 + z);
  const double r[9] = {1 - x * x * f, -x * y * f, -x, -x * y * f, 1 - y * y * f, -y, x, y, z};
  for (int i = 0; i < 9; ++i) rotation[i] = r[i];
}

// placements: n + 1 row-major 4x4 poses (the last one is the tool), axes: n unit vectors in the joint's own frame.
// out: (n + 1) * 12 numbers for ArmView::placements.
inline void align_axes(int n, const double* placements, const double* axes, double* out) {
  double undo[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};  // inverse of the turn given to the previous joint's frame
  for (int i = 0; i <= n; ++i) {
    const double* T = placements + 16 * i;
    const double frame[12] = {T[0], T[4], T[8], T[1], T[5], T[9], T[2], T[6], T[10], T[3], T[7], T[11]};
    double turn[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, half[12];
    if (i < n) rotation_from_z(axes + 3 * i, turn);
    compose(undo, frame, half);
    compose(half, turn, out + 12 * i);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) undo[3 * c + r] = turn[3 * r + c];
  }
}

STILLREACH_END
