// The wide route of inner.hpp for four problems at once: z = A' (A A' + kappa I)^-1 b, refined in the lanes that need it.
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
  Pack gram[M][M];     // lower triangle
  Pack lower[M][M];    // strictly lower part of the unit triangle L
  Pack inverse[M][M];  // of its inverse
  Pack pivot_inverse[M];
  Pack trace, inverse_trace;
};

template <int M>
struct LaneInner {
  LaneFactor<M> factor;
  Pack condition;
  Pack dual[M];
};

// Rows FIRST to LAST - 1 of the Gram matrix: so few that their sums stay in registers.
template <int M, int FIRST, int LAST>
STILLREACH_INLINE void gram_rows(const Pack* const* column, int count, Pack kappa, LaneFactor<M>& f) {
  Pack sum[LAST - FIRST][M];
  STILLREACH_UNROLL for (int r = FIRST; r < LAST; ++r)
    STILLREACH_UNROLL for (int c = 0; c <= r; ++c) sum[r - FIRST][c] = zero_pack();
  for (int i = 0; i < count; ++i) {
    const Pack* a = column[i];
    STILLREACH_UNROLL for (int r = FIRST; r < LAST; ++r)
      STILLREACH_UNROLL for (int c = 0; c <= r; ++c) sum[r - FIRST][c] = madd(a[r], a[c], sum[r - FIRST][c]);
  }
  STILLREACH_UNROLL for (int r = FIRST; r < LAST; ++r) {
    STILLREACH_UNROLL for (int c = 0; c <= r; ++c) f.gram[r][c] = sum[r - FIRST][c];
    f.gram[r][r] += kappa;
  }
}

template <int M>
STILLREACH_INLINE void gram(const Pack* const* column, int count, Pack kappa, LaneFactor<M>& f) {
  if constexpr (M > 4) {
    gram_rows<M, 0, 4>(column, count, kappa, f);
    gram_rows<M, 4, M>(column, count, kappa, f);
  } else {
    gram_rows<M, 0, M>(column, count, kappa, f);
  }
}

// As factor() of factor.hpp: proven upper bounds of the condition numbers, infinity where a matrix is not positive.
template <int M>
STILLREACH_INLINE Pack factor(LaneFactor<M>& f) {
  Pack w[M][M];
  auto& l = f.lower;
  f.trace = f.inverse_trace = zero_pack();
  Mask positive = every_lane();
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    f.trace += f.gram[j][j];
    STILLREACH_UNROLL for (int i = j; i < M; ++i) {
      Pack sum = f.gram[i][j];
      STILLREACH_UNROLL for (int k = 0; k < j; ++k) sum = madd(-w[i][k], l[j][k], sum);
      w[i][j] = sum;
    }
    positive &= w[j][j] > zero_pack();
    f.pivot_inverse[j] = broadcast(1.0) / w[j][j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) l[i][j] = w[i][j] * f.pivot_inverse[j];
  }
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    Pack sum = f.pivot_inverse[j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) {
      Pack entry = -l[i][j];
      STILLREACH_UNROLL for (int k = j + 1; k < i; ++k) entry = madd(-l[i][k], f.inverse[k][j], entry);
      f.inverse[i][j] = entry;
      sum = madd(entry * entry, f.pivot_inverse[i], sum);
    }
    f.inverse_trace += sum;
  }
  const Pack condition = f.trace * f.inverse_trace;
  return select(positive & (condition < broadcast(infinity())), condition, broadcast(infinity()));
}

template <int M>
STILLREACH_INLINE void solve(const LaneFactor<M>& f, const Pack* b, Pack* x) {
  Pack y[M];
  STILLREACH_UNROLL for (int i = 0; i < M; ++i) {
    Pack sum = b[i];
    STILLREACH_UNROLL for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    y[i] = sum * f.pivot_inverse[i];
  }
  STILLREACH_UNROLL for (int j = 0; j < M; ++j) {
    Pack sum = y[j];
    STILLREACH_UNROLL for (int i = j + 1; i < M; ++i) sum = madd(f.inverse[i][j], y[i], sum);
    x[j] = sum;
  }
}

template <int M>
STILLREACH_INLINE Pack inverse_norm(const LaneFactor<M>& f, const Pack* b) {
  Pack total = zero_pack();
  STILLREACH_UNROLL for (int i = 0; i < M; ++i) {
    Pack sum = b[i];
    STILLREACH_UNROLL for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    total = madd(sum * sum, f.pivot_inverse[i], total);
  }
  return total;
}

template <int M>
STILLREACH_INLINE Pack dot(const Pack* a, const Pack* b) {
  Pack sum = zero_pack();
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum = madd(a[r], b[r], sum);
  return sum;
}

// residual = b - A z.
template <int M>
STILLREACH_INLINE void residual_of(const Pack* const* column, int count, const Pack* rhs, const Pack* z, Pack* residual) {
  Pack sum[M];
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum[r] = rhs[r];
  for (int i = 0; i < count; ++i) {
    const Pack t = -z[i];
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum[r] = madd(column[i][r], t, sum[r]);
  }
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) residual[r] = sum[r];
}

// One refinement, in the lanes of `where`.
template <int M>
inline STILLREACH_NOINLINE void refine(const Pack* const* column, int count, const Pack* rhs, Pack kappa, Mask where, Pack* z, LaneInner<M>& in) {
  Pack error[M], change[M];
  residual_of<M>(column, count, rhs, z, error);
  for (int r = 0; r < M; ++r) error[r] = madd(-kappa, in.dual[r], error[r]);
  solve<M>(in.factor, error, change);
  for (int r = 0; r < M; ++r) in.dual[r] = select(where, in.dual[r] + change[r], in.dual[r]);
  for (int i = 0; i < count; ++i) z[i] = select(where, z[i] + dot<M>(column[i], change), z[i]);
}

// rhs: M. z: count. Returns the lanes where the route can be trusted; the others hold nothing.
template <int M>
STILLREACH_INLINE Mask solve_wide(const Pack* const* column, int count, const Pack* rhs, Pack kappa, Pack* z, LaneInner<M>& in) {
  gram<M>(column, count, kappa, in.factor);
  in.condition = factor<M>(in.factor);
  const Mask trusted = in.condition <= broadcast(kRefinedCondition);
  solve<M>(in.factor, rhs, in.dual);
  for (int i = 0; i < count; ++i) z[i] = dot<M>(column[i], in.dual);
  const Mask once = trusted & (in.condition > broadcast(kPlainCondition));
  if (any(once)) {
    refine<M>(column, count, rhs, kappa, once, z, in);
    const Mask twice = trusted & (in.condition > broadcast(kTwiceCondition));
    if (any(twice)) refine<M>(column, count, rhs, kappa, twice, z, in);
  }
  return trusted;
}

STILLREACH_END
