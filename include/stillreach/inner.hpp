// The unconstrained core of every law: z = argmin |b - A z|^2 + kappa |z|^2 over some columns of A, for kappa = 0 the
// least-squares solution of least norm, for any number of columns and any rank.
#pragma once

#include "spectrum.hpp"

STILLREACH_BEGIN

enum InnerWay { WIDE, TALL, SPECTRAL };

struct Inner {
  InnerWay way;      // how it was solved: Gram matrix of the rows, of the columns, or singular values
  int rank;
  double dual[kRows];          // z = A' dual
  double residual[kRows];      // b - A z
  double inverse_square_sum;   // sum of 1 / (sigma^2 + kappa) over min(m, count) singular values
  Factor factor;               // WIDE, TALL
  Spectrum spectrum;           // SPECTRAL
};

template <int M>
inline void residual_of(Rows<M> m, const double* columns, const int* index, int count, const double* rhs, const double* z,
                        double* residual) {
  double e[kRows];
  for (int r = 0; r < m(); ++r) e[r] = rhs[r];
  for (int i = 0; i < count; ++i) {
    const double* a = columns + (index ? index[i] : i) * m();
    for (int r = 0; r < m(); ++r) e[r] = madd(-a[r], z[i], e[r]);
  }
  for (int r = 0; r < m(); ++r) residual[r] = e[r];
}

// Fewer columns than rows: the Gram matrix of the columns. False where it cannot be trusted.
template <int M>
inline bool solve_tall(Rows<M> m, const double* columns, const int* index, int count, const double* rhs, double kappa,
                       double* z, Inner& in) {
  const Rows<0> size{count};
  double y[kRows];
  for (int i = 0; i < count; ++i) {
    const double* a = columns + (index ? index[i] : i) * m();
    for (int j = 0; j <= i; ++j) {
      in.factor.gram[i][j] = dot(m, a, columns + (index ? index[j] : j) * m());
      if (i == j) in.factor.gram[i][j] += kappa;
    }
    y[i] = dot(m, a, rhs);
  }
  if (!factor(size, in.factor, kappa > 0.0 ? kSafeDampedCondition : kSafeCondition)) return false;
  solve(size, in.factor, y, z);
  residual_of(m, columns, index, count, rhs, z, in.residual);
  if (kappa > 0.0) {
    for (int r = 0; r < m(); ++r) in.dual[r] = in.residual[r] / kappa;
  } else {
    solve(size, in.factor, z, y);
    for (int r = 0; r < m(); ++r) in.dual[r] = 0.0;
    for (int i = 0; i < count; ++i) {
      const double* a = columns + (index ? index[i] : i) * m();
      for (int r = 0; r < m(); ++r) in.dual[r] = madd(a[r], y[i], in.dual[r]);
    }
  }
  in.way = TALL, in.rank = count, in.inverse_square_sum = in.factor.inverse_trace;
  return true;
}

// threshold as in spectrum(); work: m * count numbers; z: count.
template <int M>
inline void solve_inner(Rows<M> m, const double* columns, const int* index, int count, const double* rhs, double kappa,
                        double threshold, double* work, double* z, Inner& in) {
  if (count >= m()) {
    gram(m, columns, index, count, kappa, in.factor);
    if (factor(m, in.factor, kappa > 0.0 ? kSafeDampedCondition : kSafeCondition)) {
      solve(m, in.factor, rhs, in.dual);
      for (int i = 0; i < count; ++i) z[i] = dot(m, columns + (index ? index[i] : i) * m(), in.dual);
      for (int r = 0; r < m(); ++r) in.residual[r] = kappa * in.dual[r];
      in.way = WIDE, in.rank = m(), in.inverse_square_sum = in.factor.inverse_trace;
      return;
    }
  } else if (count > 0 && solve_tall(m, columns, index, count, rhs, kappa, z, in)) {
    return;
  }
  spectrum(m(), columns, index, count, threshold, work, in.spectrum);
  const Spectrum& s = in.spectrum;
  in.way = SPECTRAL, in.rank = s.rank;
  in.inverse_square_sum = 0.0;
  for (int j = 0; j < s.count; ++j)
    in.inverse_square_sum += j < s.rank || kappa > 0.0 ? 1.0 / madd(s.sigma[j], s.sigma[j], kappa) : infinity();
  for (int r = 0; r < m(); ++r) in.dual[r] = 0.0;
  for (int j = 0; j < s.rank; ++j) {
    const double c = dot(m, s.left[j], rhs) / madd(s.sigma[j], s.sigma[j], kappa);
    for (int r = 0; r < m(); ++r) in.dual[r] = madd(c, s.left[j][r], in.dual[r]);
  }
  for (int i = 0; i < count; ++i) z[i] = dot(m, columns + (index ? index[i] : i) * m(), in.dual);
  residual_of(m, columns, index, count, rhs, z, in.residual);
}

STILLREACH_END
