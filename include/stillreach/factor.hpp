// L D L' of a small symmetric matrix with the inverse of L at hand, and the proof that it can be trusted.
//
// Cholesky of a Gram matrix squares the condition number and, on a rank-deficient one, gives silently wrong answers. The
// inverse of L bounds the condition number rigorously, trace(G) trace(G^-1) >= cond(G), so that the cheap way is taken
// only where it is known to be right; elsewhere spectrum.hpp factors the matrix itself.
#pragma once

#include "scalar.hpp"

STILLREACH_BEGIN

constexpr int kRows = 6;                       // most rows of a task
constexpr double kSafeCondition = 1e5;         // of the Gram matrix: answers right to about 1e-11
constexpr double kSafeDampedCondition = 1e7;

// Number of rows, known to the compiler where M > 0.
template <int M>
struct Rows {
  int value;
  STILLREACH_INLINE int operator()() const { return M > 0 ? M : value; }
};

struct Factor {
  double gram[kRows][kRows];     // lower triangle
  double lower[kRows][kRows];    // unit lower triangular L: strictly lower part
  double inverse[kRows][kRows];  // of L, likewise
  double pivot_inverse[kRows];
  double trace, inverse_trace;
};

// G = sum of a a' + kappa I over the columns a of `columns` (count of them, m apart), added up in the order given by
// `index` (null: 0, 1, 2, ...).
template <int M>
STILLREACH_INLINE void gram(Rows<M> m, const double* columns, const int* index, int count, double kappa, Factor& f) {
  double g[kRows * (kRows + 1) / 2];
  const int size = m() * (m() + 1) / 2;
  for (int e = 0; e < size; ++e) g[e] = 0.0;
  for (int i = 0; i < count; ++i) {
    const double* a = columns + (index ? index[i] : i) * m();
    int e = 0;
    for (int r = 0; r < m(); ++r)
      for (int c = 0; c <= r; ++c, ++e) g[e] = madd(a[r], a[c], g[e]);
  }
  int e = 0;
  for (int r = 0; r < m(); ++r)
    for (int c = 0; c <= r; ++c, ++e) f.gram[r][c] = r == c ? g[e] + kappa : g[e];
}

// Factors f.gram; true where its condition number is proven to be at most `safe` (never for NaN).
template <int M>
STILLREACH_INLINE bool factor(Rows<M> m, Factor& f, double safe) {
  double w[kRows][kRows];
  auto& l = f.lower;
  f.trace = 0.0, f.inverse_trace = 0.0;
  bool positive = true;
  for (int j = 0; j < m(); ++j) {
    f.trace += f.gram[j][j];
    for (int i = j; i < m(); ++i) {
      double sum = f.gram[i][j];
      for (int k = 0; k < j; ++k) sum = madd(-w[i][k], l[j][k], sum);
      w[i][j] = sum;  // L D
    }
    positive &= w[j][j] > 0.0;
    f.pivot_inverse[j] = 1.0 / w[j][j];
    for (int i = j + 1; i < m(); ++i) l[i][j] = w[i][j] * f.pivot_inverse[j];
  }
  for (int j = 0; j < m(); ++j) {
    double sum = f.pivot_inverse[j];
    for (int i = j + 1; i < m(); ++i) {
      double entry = -l[i][j];
      for (int k = j + 1; k < i; ++k) entry = madd(-l[i][k], f.inverse[k][j], entry);
      f.inverse[i][j] = entry;
      sum = madd(entry * entry, f.pivot_inverse[i], sum);
    }
    f.inverse_trace += sum;
  }
  return positive && f.trace * f.inverse_trace <= safe;
}

// x = G^-1 b: two products with the inverse triangle. x and b may be the same.
template <int M>
STILLREACH_INLINE void solve(Rows<M> m, const Factor& f, const double* b, double* x) {
  double y[kRows];
  for (int i = 0; i < m(); ++i) {
    double sum = b[i];
    for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    y[i] = sum * f.pivot_inverse[i];
  }
  for (int j = 0; j < m(); ++j) {
    double sum = y[j];
    for (int i = j + 1; i < m(); ++i) sum = madd(f.inverse[i][j], y[i], sum);
    x[j] = sum;
  }
}

template <int M>
STILLREACH_INLINE double dot(Rows<M> m, const double* a, const double* b) {
  double sum = 0.0;
  for (int r = 0; r < m(); ++r) sum = madd(a[r], b[r], sum);
  return sum;
}

STILLREACH_END
