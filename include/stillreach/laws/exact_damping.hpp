// Eq. (10) without singular values, where the Gram matrix G is harmless: joint rates relative to their limits are
// u_i(kappa) = w_i' (G + kappa I)^-1 x, with w_i the joint's column times its limit, and each kappa costs a
// factorisation.
#pragma once

#include "stillreach/linear/inner.hpp"
#include "stillreach/types.hpp"

STILLREACH_BEGIN

constexpr int kDampingSteps = 100;
constexpr double kLimitSlack = 1e-13;

// A step of kappa that u = w' (G + kappa)^-1 x > 1 certainly does not pass its crossing of 1 in. b, c and f hold
// x' x, w' w and w' x with powers 1, 2, 3 of that inverse between them. With p, n = (a w +- x / a)' (..)^-1 (a w +- x /
// a) / 4 and a^4 = b1 / c1, u = p - n: both fall with kappa, with derivatives of alternating signs and concave
// reciprocals. Two bounds from below, the larger step counts: p through its reciprocal beside today's n (as Newton's
// method on 1 / norm does), and a Taylor expansion of u with n's second derivative (there a^4 = b3 / c3, which makes it
// least); near the crossing that is Newton's step.
template <class T>
STILLREACH_INLINE T certain_step(T u, const T* b, const T* c, const T* f) {
  const T excess = u - 1.0, root = square_root(b[0] * c[0]);
  const T n = 0.5 * magnitude(root - u), n3 = 0.5 * magnitude(square_root(b[2]) * square_root(c[2]) - f[2]);
  const T harmonic = 4.0 * (n + u) * excess * root / ((n + 1.0) * (b[0] * c[1] + c[0] * b[1] + 2.0 * f[1] * root));
  const T taylor = 2.0 * excess / (f[1] + square_root(madd(f[1], f[1], 4.0 * n3 * excess)));
  return larger(taylor, harmonic);
}

// Columns kStride apart, as the templates below read them.
struct StridedColumns {
  const double* first;
  STILLREACH_INLINE const double* operator()(int j) const { return first + j * kStride; }
  // w = weight times the column of joint `joint`.
  STILLREACH_INLINE void weigh(int m, double joint, double weight, double* w) const {
    const double* const column = (*this)(static_cast<int>(joint));
    for (int r = 0; r < m; ++r) w[r] = column[r] * weight;
  }
};

// The same for one problem (T double, where: bool) and for one a lane (Wide, Lanes).

// The size of the relative rates, and the w of the joint that is furthest over its limit; with the 2-norm, of the sum
// of all along today's direction, which is never longer than the sum itself.
template <class T, int M, class Columns>
STILLREACH_INLINE T furthest(Rows<M> m, const Columns& column, int k, const T* limit, NormKind norm, const T* z, T* w) {
  const T zero = fill<T>(0.0);
  T most = zero, square = zero, joint = zero, weight = zero;
  for (int j = 0; j < k; ++j) {
    const T u = magnitude(z[j]) * limit[j];
    const Where<T> further = u > most;
    most = select(further, u, most);
    joint = select(further, fill<T>(j), joint);
    weight = select(further, select(z[j] < zero, -limit[j], limit[j]), weight);
    square = madd(u, u, square);
  }
  if (norm == NormKind::MAXIMUM) {
    column.weigh(m(), joint, weight, w);
    return most;
  }
  const T size = square_root(square);
  for (int r = 0; r < m(); ++r) w[r] = zero;
  for (int j = 0; j < k; ++j) {
    weight = z[j] * limit[j] / size * limit[j];
    for (int r = 0; r < m(); ++r) w[r] = madd(column(j)[r], weight, w[r]);
  }
  return size;
}

// The smallest kappa >= 0 that meets the limit, from the undamped answer in z (k) and its `dual` and factor f, which
// change; z becomes the damped answer. steps: how many kappas were looked at. Returns those of `where` that were
// answered: neither rounding nor the number of steps ended them.
template <class T, int M, class Columns, class F>
inline Where<T> exact_damping(Rows<M> m, const Columns& column, int k, const T* rhs, const T* limit, NormKind norm,
                              Where<T> where, F& f, T* dual, T* z, T& kappa, T& steps) {
  T diagonal[kRows], w[kRows], v[kRows], t[kRows];
  Where<T> settled = except(where, where);
  for (int r = 0; r < m(); ++r) diagonal[r] = f.gram[r][r];
  kappa = steps = fill<T>(0.0);
  for (int step = 1; step <= kDampingSteps; ++step) {
    const T u = furthest(m, column, k, limit, norm, z, w);
    const Where<T> meets = where & (u <= fill<T>(1.0 + kLimitSlack));
    settled |= meets;
    where = except(where, meets);
    steps = select(meets, fill<T>(step), steps);
    if (!any(where)) break;
    solve(m, f, w, v);
    solve(m, f, dual, t);
    const T b[] = {dot(m, rhs, dual), dot(m, dual, dual), dot(m, dual, t)};
    const T c[] = {dot(m, w, v), dot(m, v, v), inverse_norm(m, f, v)}, g[] = {u, dot(m, v, dual), dot(m, v, t)};
    const T next = kappa + certain_step(u, b, c, g);
    where &= next > kappa;
    kappa = select(where, next, kappa);
    for (int r = 0; r < m(); ++r) f.gram[r][r] = diagonal[r] + kappa;
    where &= factor(m, f) < fill<T>(infinity());
    solve(m, f, rhs, dual);
    for (int j = 0; j < k; ++j) z[j] = dot(m, column(j), dual);
  }
  return settled;
}

// Eq. (16), kappa = [|V| |U' twist| / 2 dq_max]^2 with both norms inf, from shapes (k x rank, `stride` apart), beta and
// sigma^2.
template <class T>
STILLREACH_INLINE T closed_form_damping(int rank, const T* shapes, int stride, int k, const T* limit, const T* beta,
                                        const T* square) {
  T left = fill<T>(0.0), right = fill<T>(0.0), inverse[kRows];
  for (int j = 0; j < rank; ++j) inverse[j] = fill<T>(1.0) / square_root(square[j]);
  for (int i = 0; i < k; ++i) {
    T sum = fill<T>(0.0);
    for (int j = 0; j < rank; ++j) sum = madd(magnitude(shapes[stride * i + j]), inverse[j], sum);
    left = larger(left, sum * limit[i]);
  }
  for (int j = 0; j < rank; ++j) right = larger(right, magnitude(beta[j]));
  return fill<T>(0.25) * left * left * right * right;
}

STILLREACH_END
