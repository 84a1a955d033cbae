// Forward kinematics and Jacobian of a chain in one pass.
#pragma once

#include "types.hpp"
#include "sincos.hpp"

STILLREACH_BEGIN

// Pose of the tool (12 numbers: rotation by columns, translation) and, unless null, the Jacobian: column i at
// jacobian + 6 i is [v; w] of the tool point along base axes (Whitney, 1969). sine, cosine: of each joint's angle.
// T is double, or Pack for four independent problems of the same arm.
template <class T>
STILLREACH_INLINE void kinematics(const ArmView& arm, const T* q, const T* sine, const T* cosine, T* pose, T* jacobian) {
  const T zero = {}, one = zero + 1.0;
  T x[3] = {one, zero, zero}, y[3] = {zero, one, zero}, z[3] = {zero, zero, one}, p[3] = {zero, zero, zero};
  for (int i = 0; i <= arm.n; ++i) {
    const double* f = arm.placements + 12 * i;
    T nx[3], ny[3];
    for (int r = 0; r < 3; ++r) {
      const T a = x[r], b = y[r], c = z[r];
      nx[r] = madd(a, zero + f[0], madd(b, zero + f[1], c * f[2]));
      ny[r] = madd(a, zero + f[3], madd(b, zero + f[4], c * f[5]));
      z[r] = madd(a, zero + f[6], madd(b, zero + f[7], c * f[8]));
      p[r] = madd(a, zero + f[9], madd(b, zero + f[10], madd(c, zero + f[11], p[r])));
    }
    if (i == arm.n) {
      for (int r = 0; r < 3; ++r) x[r] = nx[r], y[r] = ny[r];
      break;
    }
    if (arm.kinds[i] == REVOLUTE) {
      for (int r = 0; r < 3; ++r) {
        x[r] = madd(cosine[i], nx[r], sine[i] * ny[r]);
        y[r] = madd(cosine[i], ny[r], -(sine[i] * nx[r]));
      }
    } else {
      for (int r = 0; r < 3; ++r) x[r] = nx[r], y[r] = ny[r], p[r] = madd(q[i], z[r], p[r]);
    }
    if (jacobian)
      for (int r = 0; r < 3; ++r) jacobian[6 * i + r] = p[r], jacobian[6 * i + 3 + r] = z[r];
  }
  for (int r = 0; r < 3; ++r) pose[r] = x[r], pose[3 + r] = y[r], pose[6 + r] = z[r], pose[9 + r] = p[r];
  if (!jacobian) return;
  for (int i = 0; i < arm.n; ++i) {
    T* column = jacobian + 6 * i;
    const T w[3] = {column[3], column[4], column[5]};
    if (arm.kinds[i] == REVOLUTE) {
      const T d[3] = {p[0] - column[0], p[1] - column[1], p[2] - column[2]};
      for (int r = 0; r < 3; ++r) {
        const int s = (r + 1) % 3, t = (r + 2) % 3;
        column[r] = madd(w[s], d[t], -(w[t] * d[s]));
      }
    } else {
      for (int r = 0; r < 3; ++r) column[r] = w[r], column[3 + r] = zero;
    }
  }
}

// One configuration; scratch: 2 n numbers.
inline void kinematics(const ArmView& arm, const double* q, double* scratch, double* pose, double* jacobian) {
  sincos(q, arm.n, scratch, scratch + arm.n);
  kinematics<double>(arm, q, scratch, scratch + arm.n, pose, jacobian);
}

STILLREACH_END
