// The wide route of inner.hpp for all lanes at once: z = A' (A A' + kappa I)^-1 b, refined in the lanes that need it.
// A joint that does not count in a lane has a column of zeros there, which changes no sum.
#pragma once

#include "stillreach/linear/inner.hpp"
#include "stillreach/simd/lanes.hpp"

STILLREACH_BEGIN

template <int M>
struct LaneFactor {
  Wide gram[kRows][kRows];     // lower triangle
  Wide lower[kRows][kRows];    // strictly lower part of the unit triangle L
  Wide inverse[kRows][kRows];  // of its inverse
  Wide pivot_inverse[kRows];
  Wide trace, inverse_trace;
};

template <int M>
struct LaneInner {
  LaneFactor<M> factor;
  Wide condition;
  Wide dual[kRows];
};

// Columns as factor.hpp's templates read them.
struct LaneColumns {
  const Wide* const* column;
  STILLREACH_INLINE const Wide* operator()(int j) const { return column[j]; }
  // w = weight times the column of the joint whose number each lane holds.
  STILLREACH_INLINE void weigh(int m, Wide joint, Wide weight, Wide* w) const {
    const Wide* chosen[kLanes];
    for (int l = 0; l < kLanes; ++l) chosen[l] = column[static_cast<int>(joint[l])];
    for (int r = 0; r < m; ++r) w[r] = pick(chosen, r) * weight;
  }
};

template <int M>
STILLREACH_INLINE Wide factor(Rows<M>, LaneFactor<M>& f) {
  return factor<M, Wide>(f);
}
template <int M>
STILLREACH_INLINE void solve(Rows<M>, const LaneFactor<M>& f, const Wide* b, Wide* x) {
  solve<M, Wide>(f, b, x);
}
template <int M>
STILLREACH_INLINE Wide inverse_norm(Rows<M>, const LaneFactor<M>& f, const Wide* b) {
  return inverse_norm<M, Wide>(f, b);
}

// Rows FIRST to LAST - 1 of the Gram matrix: so few that their sums stay in registers.
template <int M, int FIRST, int LAST>
STILLREACH_INLINE void gram_rows(const Wide* const* column, int count, Wide kappa, LaneFactor<M>& f) {
  Wide sum[4][kRows];
  STILLREACH_UNROLL for (int r = FIRST; r < LAST; ++r) STILLREACH_UNROLL for (int c = 0; c <= r; ++c)
      sum[r - FIRST][c] = wide(0.0);
  for (int i = 0; i < count; ++i) {
    const Wide* a = column[i];
    STILLREACH_UNROLL for (int r = FIRST; r < LAST; ++r) STILLREACH_UNROLL for (int c = 0; c <= r; ++c)
        sum[r - FIRST][c] = madd(a[r], a[c], sum[r - FIRST][c]);
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

template <int M>
STILLREACH_INLINE Wide dot(const Wide* a, const Wide* b) {
  return dot(Rows<M>{M}, a, b);
}

// residual = b - A z.
template <int M>
STILLREACH_INLINE void residual_of(const Wide* const* column, int count, const Wide* rhs, const Wide* z,
                                   Wide* residual) {
  Wide sum[kRows];
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum[r] = rhs[r];
  for (int i = 0; i < count; ++i) {
    const Wide t = -z[i];
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) sum[r] = madd(column[i][r], t, sum[r]);
  }
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) residual[r] = sum[r];
}

// One refinement, in the lanes of `where`.
template <int M>
inline STILLREACH_NOINLINE void refine(const Wide* const* column, int count, const Wide* rhs, Wide kappa, Lanes where,
                                       Wide* z, LaneInner<M>& in) {
  Wide error[kRows], change[kRows];
  residual_of<M>(column, count, rhs, z, error);
  for (int r = 0; r < M; ++r) error[r] = madd(-kappa, in.dual[r], error[r]);
  solve<M, Wide>(in.factor, error, change);
  for (int r = 0; r < M; ++r) in.dual[r] = select(where, in.dual[r] + change[r], in.dual[r]);
  for (int i = 0; i < count; ++i) z[i] = select(where, z[i] + dot<M>(column[i], change), z[i]);
}

// rhs: M. z: count. Returns the lanes where the route can be trusted; the others hold nothing.
template <int M>
STILLREACH_INLINE Lanes solve_wide(const Wide* const* column, int count, const Wide* rhs, Wide kappa, Wide* z,
                                   LaneInner<M>& in, double plain = kPlainCondition) {
  gram<M>(column, count, kappa, in.factor);
  in.condition = factor<M, Wide>(in.factor);
  const Lanes trusted = in.condition <= wide(kRefinedCondition);
  solve<M, Wide>(in.factor, rhs, in.dual);
  for (int i = 0; i < count; ++i) z[i] = dot<M>(column[i], in.dual);
  const Lanes once = trusted & (in.condition > wide(plain));
  if (any(once)) {
    refine<M>(column, count, rhs, kappa, once, z, in);
    const Lanes twice = trusted & (in.condition > wide(kTwiceCondition));
    if (any(twice)) refine<M>(column, count, rhs, kappa, twice, z, in);
  }
  return trusted;
}

STILLREACH_END
