// Eq. (10) without singular values, where the Gram matrix G is harmless: joint rates relative to their limits are
// u_i(kappa) = w_i' (G + kappa I)^-1 x, with w_i the joint's column times its limit, and each kappa costs a factorisation.
#pragma once

#include "stillreach/linear/inner.hpp"
#include "stillreach/types.hpp"

STILLREACH_BEGIN

constexpr int kDampingSteps = 100;
constexpr double kLimitSlack = 1e-13;

// A step of kappa that u = w' (G + kappa)^-1 x > 1 certainly does not pass its crossing of 1 in. b, c and f hold
// x' x, w' w and w' x with powers 1, 2, 3 of that inverse between them. With p, n = (a w +- x / a)' (..)^-1 (a w +- x / a) / 4
// and a^4 = b1 / c1, u = p - n: both fall with kappa, with derivatives of alternating signs and concave reciprocals. Two
// bounds from below, the larger step counts: p through its reciprocal beside today's n (as Newton's method on 1 / norm does),
// and a Taylor expansion of u with n's second derivative (there a^4 = b3 / c3, which makes it least); near the crossing that is
// Newton's step.
template <class T>
STILLREACH_INLINE T certain_step(T u, const T* b, const T* c, const T* f) {
  const T excess = u - 1.0, root = square_root(b[0] * c[0]);
  const T n = 0.5 * magnitude(root - u), n3 = 0.5 * magnitude(square_root(b[2]) * square_root(c[2]) - f[2]);
  const T harmonic = 4.0 * (n + u) * excess * root / ((n + 1.0) * (b[0] * c[1] + c[0] * b[1] + 2.0 * f[1] * root));
  const T taylor = 2.0 * excess / (f[1] + square_root(madd(f[1], f[1], 4.0 * n3 * excess)));
  return larger(taylor, harmonic);
}

// The size of the relative rates, and the w of the joint that is furthest over its limit; with the 2-norm, of the sum of
// all along today's direction, which is never longer than the sum itself.
template <int M>
STILLREACH_INLINE double furthest(Rows<M> m, const double* columns, int k, const double* limit, int norm, const double* z, double* w) {
  double most = 0.0, square = 0.0;
  int joint = 0;
  for (int j = 0; j < k; ++j) {
    const double u = magnitude(z[j]) * limit[j];
    if (u > most) most = u, joint = j;
    square = madd(u, u, square);
  }
  if (norm == NORM_INF) {
    const double weight = z[joint] < 0.0 ? -limit[joint] : limit[joint];
    for (int r = 0; r < m(); ++r) w[r] = columns[joint * kStride + r] * weight;
    return most;
  }
  const double size = square_root(square);
  for (int r = 0; r < m(); ++r) w[r] = 0.0;
  for (int j = 0; j < k; ++j) {
    const double weight = z[j] * limit[j] / size * limit[j];
    for (int r = 0; r < m(); ++r) w[r] = madd(columns[j * kStride + r], weight, w[r]);
  }
  return size;
}

// The smallest kappa >= 0 that meets the limit, from the undamped answer in z (k) and `in` (WIDE), whose factor changes; z
// becomes the damped answer. steps: how many kappas were looked at. False where rounding or the number of steps ended it.
template <int M>
inline bool exact_damping(Rows<M> m, const double* columns, int k, const double* rhs, const double* limit, int norm, Inner& in,
                          double* z, double& kappa, int& steps) {
  Factor& f = in.factor;
  double diagonal[kRows], w[kRows];
  for (int r = 0; r < m(); ++r) diagonal[r] = f.gram[r][r];
  for (kappa = 0.0, steps = 1; steps <= kDampingSteps; ++steps) {
    const double u = furthest(m, columns, k, limit, norm, z, w);
    if (u <= 1.0 + kLimitSlack) return true;
    double v[kRows], t[kRows];
    solve(m, f, w, v), solve(m, f, in.dual, t);
    const double b[] = {dot(m, rhs, in.dual), dot(m, in.dual, in.dual), dot(m, in.dual, t)};
    const double c[] = {dot(m, w, v), dot(m, v, v), inverse_norm(m, f, v)}, g[] = {u, dot(m, v, in.dual), dot(m, v, t)};
    const double next = kappa + certain_step(u, b, c, g);
    if (!(next > kappa)) return false;
    kappa = next;
    for (int r = 0; r < m(); ++r) f.gram[r][r] = diagonal[r] + kappa;
    if (!(factor(m, f) < infinity())) return false;
    solve(m, f, rhs, in.dual);
    for (int j = 0; j < k; ++j) z[j] = dot(m, columns + j * kStride, in.dual);
  }
  return false;
}

STILLREACH_END
