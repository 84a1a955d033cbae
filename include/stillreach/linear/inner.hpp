// The unconstrained core of every law: z = argmin |b - A z|^2 + kappa |z|^2 over some columns of A, for kappa = 0 the
// least-squares solution of least norm, for any number of columns and any rank.
#pragma once

#include "stillreach/linear/spectrum.hpp"

STILLREACH_BEGIN

enum InnerWay { WIDE, TALL, SPECTRAL };

struct Inner {
  InnerWay way;  // how it was solved: Gram matrix of the rows, of the columns, or singular values
  int rank;
  double condition;           // WIDE, TALL: upper bound of the Gram matrix's condition number
  double dual[kStride];       // z = A' dual
  double residual[kStride];   // b - A z
  double inverse_square_sum;  // sum of 1 / (sigma^2 + kappa) over min(m, count) singular values
  Factor factor;              // WIDE, TALL
  Spectrum spectrum;          // SPECTRAL
};

STILLREACH_INLINE const double* column_at(const double* columns, const int* index, int i) {
  return columns + (index ? index[i] : i) * kStride;
}

// residual = b - A z (kStride numbers each).
STILLREACH_INLINE void residual_of(const double* columns, const int* index, int count, const double* rhs,
                                   const double* z, double* residual) {
  Pack low = load(rhs), high = load(rhs + 4);
  for (int i = 0; i < count; ++i) {
    const double* a = column_at(columns, index, i);
    const Pack t = broadcast(-z[i]);
    low = madd(load(a), t, low);
    high = madd(load(a + 4), t, high);
  }
  store(residual, low);
  store(residual + 4, high);
}

// to = A'u, u with zeros behind.
STILLREACH_INLINE void multiply_columns(const double* columns, int count, const double* u, double* to) {
  const Pack low = load(u), high = load(u + 4);
  const auto along = [&](int i) {
    return madd(load(columns + i * kStride + 4), high, load(columns + i * kStride) * low);
  };
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    Pack p[4] = {along(i), along(i + 1), along(i + 2), along(i + 3)};
    store(to + i, sums(p));
  }
  for (; i < count; ++i) {
    const Pack p = along(i);
    to[i] = (p[0] + p[2]) + (p[1] + p[3]);
  }
}

STILLREACH_INLINE int refinements(double condition, double plain) {
  return condition <= plain ? 0 : condition <= kTwiceCondition ? 1 : 2;
}

// plain: condition number up to which nothing is refined.
// At least as many columns as rows: z = A' G^-1 b with G = A A' + kappa I, refined where G is not quite harmless (the
// corrected seminormal equations; Bjorck, 1987). False where G cannot be trusted.
template <int M>
STILLREACH_INLINE bool solve_wide(Rows<M> m, const double* columns, const int* index, int count, const double* rhs,
                                  double kappa, double* z, Inner& in, double plain) {
  gram(m, columns, index, count, kappa, in.factor);
  in.condition = factor(m, in.factor);
  if (!(in.condition <= kRefinedCondition)) return false;
  solve(m, in.factor, rhs, in.dual);
  for (int r = m(); r < kStride; ++r) in.dual[r] = in.residual[r] = 0.0;
  for (int i = 0; i < count; ++i) z[i] = dot(m, column_at(columns, index, i), in.dual);
  for (int step = refinements(in.condition, plain); step > 0; --step) {
    double error[kStride], change[kRows];
    residual_of(columns, index, count, rhs, z, error);
    for (int r = 0; r < m(); ++r) error[r] = madd(-kappa, in.dual[r], error[r]);
    solve(m, in.factor, error, change);
    for (int r = 0; r < m(); ++r) in.dual[r] += change[r];
    for (int i = 0; i < count; ++i) z[i] += dot(m, column_at(columns, index, i), change);
  }
  for (int r = 0; r < m(); ++r) in.residual[r] = kappa * in.dual[r];
  in.way = InnerWay::WIDE;
  in.rank = m();
  in.inverse_square_sum = in.factor.inverse_trace;
  return true;
}

// Fewer columns than rows: the Gram matrix of the columns, refined likewise. False where it cannot be trusted.
template <int M>
STILLREACH_INLINE bool solve_tall(Rows<M> m, const double* columns, const int* index, int count, const double* rhs,
                                  double kappa, double* z, Inner& in, double plain) {
  const Rows<0> size{count};
  double y[kRows];
  for (int i = 0; i < count; ++i) {
    const double* a = column_at(columns, index, i);
    for (int j = 0; j <= i; ++j) in.factor.gram[i][j] = dot(m, a, column_at(columns, index, j));
    in.factor.gram[i][i] += kappa;
    y[i] = dot(m, a, rhs);
  }
  in.condition = factor(size, in.factor);
  if (!(in.condition <= kRefinedCondition)) return false;
  solve(size, in.factor, y, z);
  residual_of(columns, index, count, rhs, z, in.residual);
  for (int step = refinements(in.condition, plain); step > 0; --step) {
    for (int i = 0; i < count; ++i) y[i] = madd(-kappa, z[i], dot(m, column_at(columns, index, i), in.residual));
    solve(size, in.factor, y, y);
    for (int i = 0; i < count; ++i) z[i] += y[i];
    residual_of(columns, index, count, rhs, z, in.residual);
  }
  if (kappa > 0.0) {
    for (int r = 0; r < kStride; ++r) in.dual[r] = in.residual[r] / kappa;
  } else {
    double zero[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
    solve(size, in.factor, z, y);
    for (int i = 0; i < count; ++i) y[i] = -y[i];
    residual_of(columns, index, count, zero, y, in.dual);
  }
  in.way = InnerWay::TALL;
  in.rank = count;
  in.inverse_square_sum = in.factor.inverse_trace;
  return true;
}

// Any rank: by singular values. threshold as in spectrum(); work: 6 count numbers.
template <int M>
inline STILLREACH_NOINLINE void solve_spectral(Rows<M> m, const double* columns, const int* index, int count,
                                               const double* rhs, double kappa, double threshold, double* work,
                                               double* z, Inner& in) {
  spectrum(m(), columns, index, count, threshold, work, in.spectrum);
  const Spectrum& s = in.spectrum;
  in.way = InnerWay::SPECTRAL;
  in.rank = s.rank;
  in.inverse_square_sum = 0.0;
  for (int j = 0; j < s.count; ++j)
    in.inverse_square_sum += j < s.rank || kappa > 0.0 ? 1.0 / madd(s.sigma[j], s.sigma[j], kappa) : infinity();
  double y[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  for (int r = 0; r < kStride; ++r) in.dual[r] = 0.0;
  for (int j = 0; j < s.rank; ++j) {
    const double c = dot(m, s.left[j], rhs) / madd(s.sigma[j], s.sigma[j], kappa);
    for (int r = 0; r < m(); ++r) in.dual[r] = madd(c, s.left[j][r], in.dual[r]);
    for (int r = 0; r < s.count; ++r) y[r] = madd(c * s.sigma[j], s.right[j][r], y[r]);
  }
  apply_reflections(s, y, z);  // not A' dual, which loses a singular value ratio's worth of digits
  residual_of(columns, index, count, rhs, z, in.residual);
}

// rhs: kStride numbers, zeros behind the m that count; z: count.
template <int M>
inline void solve_inner(Rows<M> m, const double* columns, const int* index, int count, const double* rhs, double kappa,
                        double threshold, double* work, double* z, Inner& in, double plain = kPlainCondition) {
  const bool done = count >= m() ? solve_wide(m, columns, index, count, rhs, kappa, z, in, plain)
                                 : count > 0 && solve_tall(m, columns, index, count, rhs, kappa, z, in, plain);
  if (!done) solve_spectral(m, columns, index, count, rhs, kappa, threshold, work, z, in);
}

STILLREACH_END
