// L D L' of a small symmetric matrix with the inverse of L at hand, and the proof that it can be trusted.
//
// Cholesky of a Gram matrix squares the condition number and, on a rank-deficient one, gives silently wrong answers.
// The inverse of L bounds the condition number rigorously, trace(G) trace(G^-1) >= cond(G), so that the cheap way is
// taken only where it is known to be right; elsewhere spectrum.hpp factors the matrix itself.
#pragma once

#include "stillreach/simd/packs.hpp"

STILLREACH_BEGIN

constexpr int kRows = 6;                    // most rows of a task
constexpr int kStride = 8;                  // columns are kStride apart and end in zeros, so that they are whole packs
constexpr double kPlainCondition = 1e4;     // of a Gram matrix: the answer is right to about 1e-12 as it is,
constexpr double kPricedCondition = 300.0;  // (where errors must be rounding: up to here)
constexpr double kTwiceCondition = 1e6;     // and to the same after one step of refinement,
constexpr double kRefinedCondition = 1e9;   // or after two

// Number of rows, known to the compiler where M > 0.
template <int M>
struct Rows {
  int value;
  STILLREACH_INLINE int operator()() const { return M > 0 ? M : value; }
};

struct Factor {
  double gram[kRows][kStride];   // lower triangle
  double lower[kRows][kRows];    // unit lower triangular L: strictly lower part
  double inverse[kRows][kRows];  // of L, likewise
  double pivot_inverse[kRows];
  double trace, inverse_trace;
};

// G = sum of a a' + kappa I over the columns a of `columns` (count of them), added up in the order given by `index`
// (null: 0, 1, 2, ...).
template <int M>
STILLREACH_INLINE void gram(Rows<M> m, const double* columns, const int* index, int count, double kappa, Factor& f) {
  Pack low[kRows] = {}, high[kRows] = {};  // columns 0 to 3, and 4 to 7, of each row of G
  for (int i = 0; i < count; ++i) {
    const double* a = columns + (index ? index[i] : i) * kStride;
    const Pack a_low = load(a), a_high = load(a + 4);
    for (int r = 0; r < m(); ++r) {
      const Pack b = broadcast(a[r]);
      low[r] = madd(b, a_low, low[r]);
      if (r >= 4) high[r] = madd(b, a_high, high[r]);
    }
  }
  for (int r = 0; r < m(); ++r) {
    store(f.gram[r], low[r]);
    store(f.gram[r] + 4, high[r]);
    f.gram[r][r] += kappa;
  }
}

// The same for one matrix (T double, F Factor) and for one a lane (Wide, LaneFactor). Loops over M are written out: the
// numbers stay in registers.

// Factors f.gram. Returns a proven upper bound of its condition number, infinity where it is not positive (or not a
// number).
template <int M, class T, class F>
STILLREACH_INLINE T factor(F& f) {
  T w[kRows][kRows], trace = fill<T>(0.0), inverse_trace = fill<T>(0.0);
  auto& l = f.lower;
  auto positive = trace == trace;
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    trace += f.gram[j][j];
    STILLREACH_UNROLL for (int i = j; i < M; ++i) {
      T sum = f.gram[i][j];
      STILLREACH_UNROLL for (int k = 0; k < j; ++k) sum = madd(-w[i][k], l[j][k], sum);
      w[i][j] = sum;  // L D
    }
    positive &= w[j][j] > fill<T>(0.0);
    f.pivot_inverse[j] = 1.0 / w[j][j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) l[i][j] = w[i][j] * f.pivot_inverse[j];
  }
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    T sum = f.pivot_inverse[j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) {
      T entry = -l[i][j];
      STILLREACH_UNROLL for (int k = j + 1; k < i; ++k) entry = madd(-l[i][k], f.inverse[k][j], entry);
      f.inverse[i][j] = entry;
      sum = madd(entry * entry, f.pivot_inverse[i], sum);
    }
    inverse_trace += sum;
  }
  f.trace = trace;
  f.inverse_trace = inverse_trace;
  const T condition = trace * inverse_trace, none = fill<T>(infinity());
  return select(positive & (condition < none), condition, none);
}

// x = G^-1 b: two products with the inverse triangle. x and b may be the same.
template <int M, class T, class F>
STILLREACH_INLINE void solve(const F& f, const T* b, T* x) {
  T y[kRows];
  STILLREACH_UNROLL for (int i = 0; i < M; ++i) {
    T sum = b[i];
    STILLREACH_UNROLL for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    y[i] = sum * f.pivot_inverse[i];
  }
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    T sum = y[j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) sum = madd(f.inverse[i][j], y[i], sum);
    x[j] = sum;
  }
}

// b' G^-1 b.
template <int M, class T, class F>
STILLREACH_INLINE T inverse_norm(const F& f, const T* b) {
  T total = fill<T>(0.0);
  STILLREACH_UNROLL for (int i = 0; i < M; ++i) {
    T sum = b[i];
    STILLREACH_UNROLL for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    total = madd(sum * sum, f.pivot_inverse[i], total);
  }
  return total;
}

// work(Rows<m>) for the m of a task.
template <class Work>
STILLREACH_INLINE auto with_rows(int m, Work work) {
  switch (m) {
    case 1: return work(Rows<1>{1});
    case 2: return work(Rows<2>{2});
    case 3: return work(Rows<3>{3});
    case 4: return work(Rows<4>{4});
    case 5: return work(Rows<5>{5});
    default: return work(Rows<6>{6});
  }
}

template <int M>
STILLREACH_INLINE double factor(Rows<M>, Factor& f) {
  return factor<M, double>(f);
}
template <int M>
STILLREACH_INLINE void solve(Rows<M>, const Factor& f, const double* b, double* x) {
  solve<M>(f, b, x);
}
inline STILLREACH_NOINLINE double factor(Rows<0> m, Factor& f) {
  return with_rows(m.value, [&](auto rows) { return factor(rows, f); });
}
inline STILLREACH_NOINLINE void solve(Rows<0> m, const Factor& f, const double* b, double* x) {
  with_rows(m.value, [&](auto rows) { solve(rows, f, b, x); });
}
template <int M>
STILLREACH_INLINE double inverse_norm(Rows<M>, const Factor& f, const double* b) {
  return inverse_norm<M>(f, b);
}
inline STILLREACH_NOINLINE double inverse_norm(Rows<0> m, const Factor& f, const double* b) {
  return with_rows(m.value, [&](auto rows) { return inverse_norm(rows, f, b); });
}

template <class T, int M>
STILLREACH_INLINE T dot(Rows<M> m, const T* a, const T* b) {
  const int rows = m();  // the compiler drops the annotation of a loop that calls
  T sum = fill<T>(0.0);
  STILLREACH_UNROLL for (int r = 0; r < rows; ++r) sum = madd(a[r], b[r], sum);
  return sum;
}

// Of the entries' sizes.
template <class T, int M>
STILLREACH_INLINE T largest_of(Rows<M> m, const T* a) {
  T size = fill<T>(0.0);
  for (int r = 0; r < m(); ++r) size = larger(size, magnitude(a[r]));
  return size;
}

template <int M>
STILLREACH_INLINE double size_of(Rows<M> m, const double* a) {
  return square_root(dot(m, a, a));
}

STILLREACH_END
