// choose_damping() of singularity_robust.hpp, infinity norm, for four problems at once, where the Gram matrix is harmless.
#pragma once

#include "damping.hpp"
#include "lane_solve.hpp"

STILLREACH_BEGIN

// jacobi() of spectrum.hpp without the rotations' product, in the lanes of `where`.
template <int M>
inline void jacobi(Mask where, Pack (*triangle)[M]) {
  const auto product = [](const Pack* a, const Pack* b) {  // in the order of the single tick's packs
    Pack part[4];
    for (int r = 0; r < 4; ++r) part[r] = r < M ? a[r] * b[r] : zero_pack();
    for (int r = 4; r < M; ++r) part[r - 4] = madd(a[r], b[r], part[r - 4]);
    return (part[0] + part[2]) + (part[1] + part[3]);
  };
  for (int sweep = 0; sweep < kSweeps && any(where); ++sweep) {
    Mask restless = no_lane();
    for (const auto& round : kTournament) {
      Rotations turn[3] = {};
      Mask here = no_lane();
      STILLREACH_UNROLL for (int i = 0; i < 3; ++i) {
        if (round[i][0] >= M || round[i][1] >= M) continue;
        const Pack *P = triangle[round[i][0]], *Q = triangle[round[i][1]];
        turn[i] = rotations(product(P, P), product(Q, Q), product(P, Q), where);
        here |= turn[i].here, restless |= turn[i].large;
      }
      if (!any(here)) continue;
      STILLREACH_UNROLL for (int i = 0; i < 3; ++i) {
        if (round[i][0] >= M || round[i][1] >= M) continue;
        Pack *P = triangle[round[i][0]], *Q = triangle[round[i][1]];
        for (int r = 0; r < M; ++r) {
          const Pack a = P[r], b = Q[r];
          P[r] = madd(turn[i].c, a, -(turn[i].s * b)), Q[r] = madd(turn[i].s, a, turn[i].c * b);
        }
      }
    }
    where &= restless;
  }
}

template <int M>
struct LaneDamping {
  int k;
  int count;     // joints that may be over the limit
  Pack* terms;   // k x M: shapes times beta times limit; the first `count` rows are those joints'
  Pack* shapes;  // k x M
  const Pack* limit;
  Pack beta[M], square[M];
};

// Singular values and left vectors, falling, by odd-even exchange. Ties have no order of their own: those lanes are rejected.
template <int M>
inline Mask sort_spectrum(Pack (*triangle)[M], double threshold, Pack* sigma) {
  for (int j = 0; j < M; ++j) {
    Pack sum = zero_pack();
    for (int r = 0; r < M; ++r) sum = madd(triangle[j][r], triangle[j][r], sum);
    sigma[j] = square_root(sum);
  }
  for (int pass = 0; pass < M; ++pass)
    for (int j = pass % 2; j + 1 < M; j += 2) {
      const Mask swap = sigma[j] < sigma[j + 1];
      if (!any(swap)) continue;
      const Pack high = select(swap, sigma[j + 1], sigma[j]), low = select(swap, sigma[j], sigma[j + 1]);
      sigma[j] = high, sigma[j + 1] = low;
      for (int r = 0; r < M; ++r) {
        const Pack a = triangle[j][r], b = triangle[j + 1][r];
        triangle[j][r] = select(swap, b, a), triangle[j + 1][r] = select(swap, a, b);
      }
    }
  Mask good = sigma[M - 1] > broadcast(threshold) * sigma[0];
  for (int j = 0; j + 1 < M; ++j) good &= sigma[j] > sigma[j + 1];
  for (int j = 0; j < M; ++j) {
    const Pack inverse = broadcast(1.0) / sigma[j];
    for (int r = 0; r < M; ++r) triangle[j][r] *= inverse;
  }
  return good;
}

// safe_step() of damping.hpp; 0 outside `where`.
template <int M>
STILLREACH_INLINE Pack safe_step(Mask where, const Pack* a, const Pack* inverse, Pack limit) {
  const Pack zero = zero_pack();
  Pack p = zero, n = zero, dp = zero, dn = zero, n3 = zero;
  for (int j = 0; j < M; ++j) {
    const Pack t = a[j] * inverse[j], d = t * inverse[j];
    const Mask positive = t > zero;
    p = select(positive, p + t, p), dp = select(positive, dp + d, dp);
    n = select(positive, n, n - t), dn = select(positive, dn, dn - d), n3 = select(positive, n3, n3 - d * inverse[j]);
  }
  const Pack excess = p - n - limit, slope = dp - dn;
  where &= excess > broadcast(4e-16) * (p + n);
  if (!any(where)) return zero;
  const Pack harmonic = p * excess / ((limit + n) * dp);
  const Pack taylor = broadcast(2.0) * excess / (slope + square_root(madd(slope, slope, broadcast(4.0) * n3 * excess)));
  return select(where, select(taylor > harmonic, taylor, harmonic), zero);
}

template <int M>
inline Pack step_inf(LaneDamping<M>& d, Mask where, Pack kappa) {
  const Pack one = broadcast(1.0), zero = zero_pack();
  Pack inverse[M], step = zero;
  for (int j = 0; j < M; ++j) inverse[j] = one / (d.square[j] + kappa);
  int kept = 0;
  for (int i = 0; i < d.count; ++i) {
    const Pack* a = d.terms + M * i;
    Pack u = zero, most = zero;
    STILLREACH_UNROLL for (int j = 0; j < M; ++j) u = madd(a[j], inverse[j], u), most = madd(magnitude(a[j]), inverse[j], most);
    if (!any(where & (most > one))) continue;
    if (kept < i) STILLREACH_LIBRARY(memcpy)(d.terms + M * kept, a, sizeof(Pack) * M);
    ++kept;
    const Mask negative = u < zero;
    const Mask over = where & (magnitude(u) > broadcast(1.0 + 1e-13));
    if (!any(over)) continue;
    Pack b[M];
    for (int j = 0; j < M; ++j) b[j] = select(negative, -a[j], a[j]);
    const Pack s = safe_step<M>(over, b, inverse, one);
    step = select(s > step, s, step);
  }
  d.count = kept;
  return step;
}

// Eq. (10). settled: the lanes that found their factor within the steps allowed.
template <int M>
inline Pack exact_damping(LaneDamping<M>& d, Mask where, Pack& steps, Mask& settled) {
  Pack kappa = zero_pack();
  steps = zero_pack(), settled = no_lane();
  for (int count = 1; count <= kDampingSteps; ++count) {
    const Pack next = kappa + step_inf(d, where, kappa);
    const Mask moved = where & (next > kappa), done = where & ~moved;
    steps = select(done, broadcast(count), steps);
    settled |= done, where = moved;
    if (!any(where)) break;
    kappa = select(where, next, kappa);
  }
  return kappa;
}

// Eq. (16).
template <int M>
inline Pack closed_form_damping(const LaneDamping<M>& d) {
  Pack left = zero_pack(), right = zero_pack(), inverse[M];
  for (int j = 0; j < M; ++j) inverse[j] = broadcast(1.0) / square_root(d.square[j]);
  for (int i = 0; i < d.k; ++i) {
    Pack sum = zero_pack();
    for (int j = 0; j < M; ++j) sum = madd(magnitude(d.shapes[M * i + j]), inverse[j], sum);
    left = larger(left, sum * d.limit[i]);
  }
  for (int j = 0; j < M; ++j) right = larger(right, magnitude(d.beta[j]));
  return broadcast(0.25) * left * left * right * right;
}

// The factor that eq. (10) or (16) asks for in the lanes of `where`, and the damped answer in z; elsewhere both stay.
// Returns the lanes that were answered. shapes, terms: room for k M packs each.
template <int M>
inline Mask choose_damping(bool exact, double rank_tolerance, const Pack* const* column, const Pack* rhs, const Pack* limit, int k,
                           const LaneInner<M>& in, Mask where, Pack* shapes, Pack* terms, Pack* z, Pack& kappa, Pack& steps) {
  where &= in.condition <= broadcast(kPlainCondition);
  if (!any(where)) return where;
  Pack triangle[M][M], sigma[M];
  for (int j = 0; j < M; ++j) {
    const Pack root = broadcast(1.0) / square_root(in.factor.pivot_inverse[j]);
    for (int i = 0; i < M; ++i) triangle[j][i] = i < j ? zero_pack() : i == j ? root : in.factor.lower[i][j] * root;
  }
  jacobi<M>(where, triangle);
  where &= sort_spectrum<M>(triangle, rank_tolerance, sigma);
  LaneDamping<M> d;
  d.k = d.count = k, d.shapes = shapes, d.terms = terms, d.limit = limit;
  for (int j = 0; j < M; ++j) d.beta[j] = dot<M>(triangle[j], rhs), d.square[j] = sigma[j] * sigma[j];
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < M; ++j) {
      const Pack shape = dot<M>(column[i], triangle[j]);
      shapes[i * M + j] = shape, terms[i * M + j] = shape * d.beta[j] * limit[i];
    }
  Pack found;
  Mask settled = where;
  if (exact) {
    found = exact_damping<M>(d, where, steps, settled);
  } else {
    found = closed_form_damping<M>(d);
  }
  where &= settled;
  const Mask damped = where & (found > zero_pack());
  kappa = select(damped, found, kappa);
  Pack weight[M];
  for (int j = 0; j < M; ++j) weight[j] = d.beta[j] / (d.square[j] + found);
  for (int i = 0; i < k; ++i) {
    Pack sum = zero_pack();
    for (int j = 0; j < M; ++j) sum = madd(shapes[i * M + j], weight[j], sum);
    z[i] = select(damped, sum, z[i]);
  }
  return where;
}

STILLREACH_END
