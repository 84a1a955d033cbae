// Forward kinematics and Jacobian of a chain in one pass.
#pragma once

#include "types.hpp"
#include "sincos.hpp"

STILLREACH_BEGIN

// Cyclic permutations of a 3-vector; the lane that does not matter holds what comes first in `yzx` again.
STILLREACH_INLINE Pack yzx(Pack a) { return STILLREACH_SHUFFLE(a, a, 1, 2, 0, 0); }
STILLREACH_INLINE Pack zxy(Pack a) { return STILLREACH_SHUFFLE(a, a, 2, 0, 1, 3); }

STILLREACH_INLINE Pack cross(Pack a, Pack b) {
  return madd(yzx(a), zxy(b), -(zxy(a) * yzx(b)));
}

// Pose of the tool (12 numbers: rotation by columns, translation) and, unless null, the Jacobian: column i at
// jacobian + 6 i is [v; w] of the tool point along base axes (Whitney, 1969). scratch: 10 n numbers.
inline void kinematics(const ArmView& arm, const double* q, double* scratch, double* pose, double* jacobian) {
  const double *sine = scratch, *cosine = scratch + arm.n;
  double *at = scratch + 2 * arm.n, *axis = at + 4 * arm.n;  // of each joint, four numbers apart
  sincos(q, arm.n, scratch, scratch + arm.n);
  Pack x = {1, 0, 0, 0}, y = {0, 1, 0, 0}, z = {0, 0, 1, 0}, p = {0, 0, 0, 0};
  for (int i = 0; i <= arm.n; ++i) {
    const double* f = arm.placements + 12 * i;
    double local[8];  // x and y of the next frame along the axes of this one: none waits for the joints before
    Pack fx = load(f), fy = load(f + 3);
    if (i < arm.n && arm.kinds[i] == REVOLUTE) {
      const Pack c = broadcast(cosine[i]), s = broadcast(sine[i]), turned = madd(c, fx, s * fy);
      fy = madd(c, fy, -(s * fx)), fx = turned;
    }
    store(local, fx), store(local + 4, fy);
    const Pack nx = madd(x, broadcast(local[0]), madd(y, broadcast(local[1]), z * local[2]));
    const Pack ny = madd(x, broadcast(local[4]), madd(y, broadcast(local[5]), z * local[6]));
    p = madd(x, broadcast(f[9]), madd(y, broadcast(f[10]), madd(z, broadcast(f[11]), p)));
    z = madd(x, broadcast(f[6]), madd(y, broadcast(f[7]), z * f[8]));
    x = nx, y = ny;
    if (i == arm.n) break;
    if (arm.kinds[i] != REVOLUTE) p = madd(broadcast(q[i]), z, p);
    store(at + 4 * i, p), store(axis + 4 * i, z);
  }
  double frame[16];
  store(frame, x), store(frame + 3, y), store(frame + 6, z), store(frame + 9, p);
  for (int r = 0; r < 12; ++r) pose[r] = frame[r];
  if (!jacobian) return;
  for (int i = 0; i < arm.n; ++i) {
    double* column = jacobian + 6 * i;
    const Pack w = load(axis + 4 * i), turned = yzx(w);
    if (arm.kinds[i] == REVOLUTE) {  // four and two numbers, as weighted_column() reads them
      store(column, STILLREACH_SHUFFLE(cross(w, p - load(at + 4 * i)), turned, 0, 1, 2, 7));
      store_pair(column + 4, turned);
    } else {
      const Pack zero = {0, 0, 0, 0};
      store(column, STILLREACH_SHUFFLE(w, zero, 0, 1, 2, 7));
      store_pair(column + 4, zero);
    }
  }
}

STILLREACH_END
