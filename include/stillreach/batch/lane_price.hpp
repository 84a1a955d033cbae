// The variables of one_price.hpp for all lanes at once. Columns are zero in lanes where a joint does not work, which
// changes no sum.
#pragma once

#include "stillreach/batch/lane_system.hpp"
#include "stillreach/bounded/one_price.hpp"

STILLREACH_BEGIN

template <int M>
struct LaneVariables {
  using Number = Wide;
  using Where = Lanes;
  using Matrix = LaneFactor<M>;
  int k;
  const Wide* const* column;
  const Lanes* works;
  const Wide *lower, *upper;
  Wide *target, *next, *z, *answer, *side, *speed;  // k each
  Wide* masked;                                     // k M
  const Wide** masked_column;                       // k

  STILLREACH_INLINE void multiply(const Wide* u, Wide* to) const {
    for (int i = 0; i < k; ++i) {  // in the order of the single problem's packs
      const Wide* a = column[i];
      Wide part[4];
      STILLREACH_UNROLL for (int r = 0; r < 4; ++r) part[r] = r < M ? a[r] * u[r] : wide(0.0);
      STILLREACH_UNROLL for (int r = 4; r < M; ++r) part[r - 4] = madd(a[r], u[r], part[r - 4]);
      to[i] = (part[0] + part[2]) + (part[1] + part[3]);
    }
  }
  STILLREACH_INLINE void cut(const Wide* at) const {
    for (int i = 0; i < k; ++i) z[i] = clamp(at[i], lower[i], upper[i]);
  }
  STILLREACH_INLINE void residual(const Wide* rhs, const Wide* rates, Wide* to) const {
    residual_of<M>(column, k, rhs, rates, to);
  }
  STILLREACH_INLINE Wide largest(const Wide* rates) const {
    Wide most = wide(0.0);
    for (int i = 0; i < k; ++i) most = larger(most, select(works[i], magnitude(rates[i]), wide(0.0)));
    return most;
  }
  STILLREACH_INLINE void start() const {
    for (int i = 0; i < k; ++i) {
      side[i] = wide(0.0);
      masked_column[i] = masked + i * M;
    }
  }
  STILLREACH_INLINE Lanes classify(Lanes live, Wide slack) const {
    Lanes changed = no_lane();
    for (int i = 0; i < k; ++i) {
      const Wide now = select(live, side_of(side[i], target[i], lower[i], upper[i], slack), side[i]);
      changed |= works[i] & (now != side[i]);
      side[i] = now;
    }
    return changed;
  }
  STILLREACH_INLINE void form(Matrix& f) const {
    for (int i = 0; i < k; ++i) {
      const Lanes free = side[i] == wide(0.0);
      STILLREACH_UNROLL for (int r = 0; r < M; ++r) masked[i * M + r] = select(free, column[i][r], wide(0.0));
    }
    gram<M>(masked_column, k, wide(0.0), f);
  }
  STILLREACH_INLINE void keep(Lanes done) const {
    for (int i = 0; i < k; ++i) answer[i] = select(done, z[i], answer[i]);
  }
  STILLREACH_INLINE void move(Lanes done) const {
    for (int i = 0; i < k; ++i) {
      const Lanes free = done & (side[i] == wide(0.0));
      answer[i] = select(free, clamp(answer[i] + speed[i], lower[i], upper[i]), answer[i]);
    }
  }
};

STILLREACH_END
