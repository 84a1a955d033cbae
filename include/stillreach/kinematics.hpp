// Forward kinematics and Jacobian of a chain in one pass.
#pragma once

#include "types.hpp"
#include "sincos.hpp"

STILLREACH_BEGIN

#if defined(STILLREACH_PORTABLE_PACK)
STILLREACH_INLINE Pack yzx(Pack a) { return Pack{a[1], a[2], a[0], a[3]}; }
STILLREACH_INLINE Pack zxy(Pack a) { return Pack{a[2], a[0], a[1], a[3]}; }
#elif defined(__clang__)
STILLREACH_INLINE Pack yzx(Pack a) { return __builtin_shufflevector(a, a, 1, 2, 0, 3); }
STILLREACH_INLINE Pack zxy(Pack a) { return __builtin_shufflevector(a, a, 2, 0, 1, 3); }
#else
STILLREACH_INLINE Pack yzx(Pack a) { return __builtin_shuffle(a, Mask{1, 2, 0, 3}); }
STILLREACH_INLINE Pack zxy(Pack a) { return __builtin_shuffle(a, Mask{2, 0, 1, 3}); }
#endif

STILLREACH_INLINE Pack cross(Pack a, Pack b) {
  return madd(yzx(a), zxy(b), -(zxy(a) * yzx(b)));
}

// Pose of the tool (12 numbers: rotation by columns, translation) and, unless null, the Jacobian: column i at
// jacobian + 6 i is [v; w] of the tool point along base axes (Whitney, 1969); one number more than 6 n is written.
// scratch: 2 n numbers.
inline void kinematics(const ArmView& arm, const double* q, double* scratch, double* pose, double* jacobian) {
  const double *sine = scratch, *cosine = scratch + arm.n;
  sincos(q, arm.n, scratch, scratch + arm.n);
  Pack x = {1, 0, 0, 0}, y = {0, 1, 0, 0}, z = {0, 0, 1, 0}, p = {0, 0, 0, 0};
  for (int i = 0; i <= arm.n; ++i) {
    const double* f = arm.placements + 12 * i;
    const Pack nx = madd(x, broadcast(f[0]), madd(y, broadcast(f[1]), z * f[2]));
    const Pack ny = madd(x, broadcast(f[3]), madd(y, broadcast(f[4]), z * f[5]));
    p = madd(x, broadcast(f[9]), madd(y, broadcast(f[10]), madd(z, broadcast(f[11]), p)));
    z = madd(x, broadcast(f[6]), madd(y, broadcast(f[7]), z * f[8]));
    x = nx, y = ny;
    if (i == arm.n) break;
    if (arm.kinds[i] == REVOLUTE) {
      const Pack c = broadcast(cosine[i]), s = broadcast(sine[i]);
      x = madd(c, nx, s * ny), y = madd(c, ny, -(s * nx));
    } else {
      p = madd(broadcast(q[i]), z, p);
    }
    if (jacobian) store(jacobian + 6 * i, p), store(jacobian + 6 * i + 3, z);
  }
  double frame[16];
  store(frame, x), store(frame + 3, y), store(frame + 6, z), store(frame + 9, p);
  for (int r = 0; r < 12; ++r) pose[r] = frame[r];
  if (!jacobian) return;
  for (int i = 0; i < arm.n; ++i) {
    double* column = jacobian + 6 * i;
    if (arm.kinds[i] == REVOLUTE) {
      const Pack w = load(column + 3);  // its last lane is the next column's first number and is put back
      store(column, cross(w, p - load(column)));
      store(column + 3, w);
    } else {
      for (int r = 0; r < 3; ++r) column[r] = column[3 + r], column[3 + r] = 0.0;
    }
  }
}

STILLREACH_END
