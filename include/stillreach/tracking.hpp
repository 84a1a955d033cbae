// From a pose error to a twist: geodesic in orientation, bounded, right through a half turn.
#pragma once

#include "scalar.hpp"

STILLREACH_BEGIN

// Rotation vector of E = target R' (both rotations by columns), along base axes; its length is at most pi.
inline void rotation_error(const double* target, const double* R, double* vector) {
  double E[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      E[i][j] = madd(target[i], R[j], madd(target[3 + i], R[3 + j], target[6 + i] * R[6 + j]));
  // quaternion by its largest component (Shepperd, 1978), so that no angle loses digits
  const double trace = E[0][0] + E[1][1] + E[2][2];
  double w, v[3];
  int big = E[0][0] > E[1][1] ? (E[0][0] > E[2][2] ? 0 : 2) : (E[1][1] > E[2][2] ? 1 : 2);
  if (trace > E[big][big]) {
    w = 0.5 * square_root(larger(1.0 + trace, 0.0));
    for (int i = 0; i < 3; ++i) v[i] = (E[(i + 2) % 3][(i + 1) % 3] - E[(i + 1) % 3][(i + 2) % 3]) / (4.0 * w);
  } else {
    const int a = big, b = (a + 1) % 3, c = (a + 2) % 3;
    v[a] = 0.5 * square_root(larger(1.0 + E[a][a] - E[b][b] - E[c][c], 0.0));
    v[b] = (E[a][b] + E[b][a]) / (4.0 * v[a]);
    v[c] = (E[a][c] + E[c][a]) / (4.0 * v[a]);
    w = (E[c][b] - E[b][c]) / (4.0 * v[a]);
  }
  if (w < 0.0) {
    w = -w;
    for (int i = 0; i < 3; ++i) v[i] = -v[i];
  }
  const double s = square_root(madd(v[0], v[0], madd(v[1], v[1], v[2] * v[2])));
  const double gain = s > 1e-8 ? 2.0 * STILLREACH_LIBRARY(atan2)(s, w) / s : 2.0;
  for (int i = 0; i < 3; ++i) vector[i] = gain * v[i];
}

STILLREACH_INLINE void bound_length(double* v, double largest) {
  const double length = square_root(madd(v[0], v[0], madd(v[1], v[1], v[2] * v[2])));
  if (length > largest)
    for (int i = 0; i < 3; ++i) v[i] *= largest / length;
}

// twist += gain * pose error, its linear and angular parts each at most as long as told. pose, target: 12 numbers.
inline void add_correction(const double* target, const double* pose, double gain, double linear, double angular, double* twist) {
  double v[3], w[3];
  rotation_error(target, pose, w);
  for (int i = 0; i < 3; ++i) v[i] = gain * (target[9 + i] - pose[9 + i]), w[i] *= gain;
  bound_length(v, linear);
  bound_length(w, angular);
  for (int i = 0; i < 3; ++i) twist[i] += v[i], twist[3 + i] += w[i];
}

STILLREACH_END
