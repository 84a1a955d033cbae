// The wide route of inner.hpp for all lanes at once: z = A' (A A' + kappa I)^-1 b, refined in the lanes that need it.
// A joint that does not count in a lane has a column of zeros there, which changes no sum.
#pragma once

#include "inner.hpp"
#include "lanes.hpp"

STILLREACH_BEGIN

#if defined(__GNUC__) && !defined(__clang__)
#define STILLREACH_UNROLL _Pragma("GCC unroll 8")
#else
#define STILLREACH_UNROLL
#endif

template <int M>
struct LaneFactor {
  Wide gram[M][M];     // lower triangle
  Wide lower[M][M];    // strictly lower part of the unit triangle L
  Wide inverse[M][M];  // of its inverse
  Wide pivot_inverse[M];
  Wide trace, inverse_trace;
};

template <int M>
struct LaneInner {
  LaneFactor<M> factor;
  Wide condition;
  Wide dual[M];
};

// Rows FIRST to LAST - 1 of the Gram matrix: so few that their sums stay in registers.
template <int M, int FIRST, int LAST>
STILLREACH_INLINE void gram_rows(const Wide* const* column, int count, Wide kappa, LaneFactor<M>& f) {
  Wide sum[LAST - FIRST][M];
  STILLREACH_UNROLL for (int r = FIRST; r < LAST; ++r)
    STILLREACH_UNROLL for (int c = 0; c <= r; ++c) sum[r - FIRST][c] = wide(0.0);
  for (int i = 0; i < count; ++i) {
    const Wide* a = column[i];
    STILLREACH_UNROLL for (int r = FIRST; r < LAST; ++r)
      STILLREACH_UNROLL for (int c = 0; c <= r; ++c) sum[r - FIRST][c] = madd(a[r], a[c], sum[r - FIRST][c]);
  }
  STILLREACH_UNROLL for (int r = FIRST; r < LAST; ++r) {
    STILLREACH_UNROLL for (int c = 0; c <= r; ++c) f.gram[r][c] = sum[r - FIRST][c];
    f.gram[r][r] += kappa;
  }
}

template <int M>
STILLREACH_INLINE void gram(const Wide* const* column, int count, Wide kappa, LaneFactor<M>& f) {
  if constexpr (M > 4) {
    gram_rows<M, 0, 4>(column, count, kappa, f);
    gram_rows<M, 4, M>(column, count, kappa, f);
  } else {
    gram_rows<M, 0, M>(column, count, kappa, f);
  }
}

// As factor() of factor.hpp: proven upper bounds of the condition numbers, infinity where a matrix is not positive.
template <int M>
STILLREACH_INLINE Wide factor(LaneFactor<M>& f) {
  Wide w[M][M];
  auto& l = f.lower;
  f.trace = f.inverse_trace = wide(0.0);
  Lanes positive = every_lane();
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    f.trace += f.gram[j][j];
    STILLREACH_UNROLL for (int i = j; i < M; ++i) {
      Wide sum = f.gram[i][j];
      STILLREACH_UNROLL for (int k = 0; k < j; ++k) sum = madd(-w[i][k], l[j][k], sum);
      w[i][j] = sum;
    }
    positive &= w[j][j] > wide(0.0);
    f.pivot_inverse[j] = wide(1.0) / w[j][j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) l[i][j] = w[i][j] * f.pivot_inverse[j];
  }
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    Wide sum = f.pivot_inverse[j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) {
      Wide entry = -l[i][j];
      STILLREACH_UNROLL for (int k = j + 1; k < i; ++k) entry = madd(-l[i][k], f.inverse[k][j], entry);
      f.inverse[i][j] = entry;
      sum = madd(entry * entry, f.pivot_inverse[i], sum);
    }
    f.inverse_trace += sum;
  }
  const Wide condition = f.trace * f.inverse_trace;
  return select(positive & (condition < wide(infinity())), condition, wide(infinity()));
}

template <int M>
STILLREACH_INLINE void solve(const LaneFactor<M>& f, const Wide* b, Wide* x) {
  Wide y[M];
  STILLREACH_UNROLL for (int i = 0; i < M; ++i) {
    Wide sum = b[i];
    STILLREACH_UNROLL for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    y[i] = sum * f.pivot_inverse[i];
  }
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    Wide sum = y[j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) sum = madd(f.inverse[i][j], y[i], sum);
    x[j] = sum;
  }
}

template <int M>
STILLREACH_INLINE Wide inverse_norm(const LaneFactor<M>& f, const Wide* b) {
  Wide total = wide(0.0);
  STILLREACH_UNROLL for (int i = 0; i < M; ++i) {
    Wide sum = b[i];
    STILLREACH_UNROLL for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    total = madd(sum * sum, f.pivot_inverse[i], total);
  }
  return total;
}

template <int M>
STILLREACH_INLINE Wide dot(const Wide* a, const Wide* b) {
  Wide sum = wide(0.0);
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum = madd(a[r], b[r], sum);
  return sum;
}

// residual = b - A z.
template <int M>
STILLREACH_INLINE void residual_of(const Wide* const* column, int count, const Wide* rhs, const Wide* z, Wide* residual) {
  Wide sum[M];
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum[r] = rhs[r];
  for (int i = 0; i < count; ++i) {
    const Wide t = -z[i];
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum[r] = madd(column[i][r], t, sum[r]);
  }
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) residual[r] = sum[r];
}

// One refinement, in the lanes of `where`.
template <int M>
inline STILLREACH_NOINLINE void refine(const Wide* const* column, int count, const Wide* rhs, Wide kappa, Lanes where, Wide* z, LaneInner<M>& in) {
  Wide error[M], change[M];
  residual_of<M>(column, count, rhs, z, error);
  for (int r = 0; r < M; ++r) error[r] = madd(-kappa, in.dual[r], error[r]);
  solve<M>(in.factor, error, change);
  for (int r = 0; r < M; ++r) in.dual[r] = select(where, in.dual[r] + change[r], in.dual[r]);
  for (int i = 0; i < count; ++i) z[i] = select(where, z[i] + dot<M>(column[i], change), z[i]);
}

// rhs: M. z: count. Returns the lanes where the route can be trusted; the others hold nothing.
template <int M>
STILLREACH_INLINE Lanes solve_wide(const Wide* const* column, int count, const Wide* rhs, Wide kappa, Wide* z, LaneInner<M>& in) {
  gram<M>(column, count, kappa, in.factor);
  in.condition = factor<M>(in.factor);
  const Lanes trusted = in.condition <= wide(kRefinedCondition);
  solve<M>(in.factor, rhs, in.dual);
  for (int i = 0; i < count; ++i) z[i] = dot<M>(column[i], in.dual);
  const Lanes once = trusted & (in.condition > wide(kPlainCondition));
  if (any(once)) {
    refine<M>(column, count, rhs, kappa, once, z, in);
    const Lanes twice = trusted & (in.condition > wide(kTwiceCondition));
    if (any(twice)) refine<M>(column, count, rhs, kappa, twice, z, in);
  }
  return trusted;
}

STILLREACH_END
