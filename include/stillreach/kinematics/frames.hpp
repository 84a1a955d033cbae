// Poses (12 numbers: rotation by columns, translation) and what a task sees of them.
#pragma once

#include "stillreach/simd/scalar.hpp"

STILLREACH_BEGIN

STILLREACH_INLINE double dot3(const double* a, const double* b) {
  return madd(a[0], b[0], madd(a[1], b[1], a[2] * b[2]));
}

// Task rows of a 6-vector [v; w] along base axes. asked: has m, rows (which of the six) and tool_axes (along the tool's
// axes).
template <class Asked>
STILLREACH_INLINE void select_rows(const Asked& asked, const double* pose, const double* base, double* task) {
  double v[6];
  for (int h = 0; h < 6; h += 3)
    for (int i = 0; i < 3; ++i) v[h + i] = asked.tool_axes ? dot3(pose + 3 * i, base + h) : base[h + i];
  for (int r = 0; r < asked.m; ++r) task[r] = v[asked.rows[r]];
}

// As a row-major 4 x 4 matrix.
inline void write_pose(const double* pose, double* to) {
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) to[4 * r + c] = r < 3 ? pose[3 * c + r] : c == 3 ? 1.0 : 0.0;
}

STILLREACH_END
