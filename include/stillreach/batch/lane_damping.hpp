// The damping laws' factors for all lanes at once: exact_damping.hpp, and eq. (16) from singular values.
#pragma once

#include "stillreach/batch/lane_system.hpp"
#include "stillreach/laws/damping.hpp"

STILLREACH_BEGIN

// jacobi() of spectrum.hpp without the rotations' product, in the lanes of `where`.
template <int M>
inline void jacobi(Lanes where, Wide (*triangle)[kRows]) {
  const auto product = [](const Wide* a, const Wide* b) {  // in the order of the single tick's packs
    Wide part[4];
    for (int r = 0; r < 4; ++r) part[r] = r < M ? a[r] * b[r] : wide(0.0);
    for (int r = 4; r < M; ++r) part[r - 4] = madd(a[r], b[r], part[r - 4]);
    return (part[0] + part[2]) + (part[1] + part[3]);
  };
  static constexpr Tournament pairs = tournament();
  for (int sweep = 0; sweep < kSweeps && any(where); ++sweep) {
    Lanes restless = no_lane();
    for (const auto& round : pairs.rounds)
      for (const auto& pair : round) {
        if (pair[0] >= M || pair[1] >= M) continue;
        Wide *P = triangle[pair[0]], *Q = triangle[pair[1]];
        const auto turn = rotations(product(P, P), product(Q, Q), product(P, Q), where);
        if (!any(turn.here)) continue;
        restless |= turn.large;
        for (int r = 0; r < M; ++r) {
          const Wide a = P[r], b = Q[r];
          P[r] = madd(turn.c, a, -(turn.s * b));
          Q[r] = madd(turn.s, a, turn.c * b);
        }
      }
    where &= restless;
  }
}

// Singular values and left vectors, falling, by odd-even exchange. Ties have no order of their own: those lanes are
// rejected.
template <int M>
inline Lanes sort_spectrum(Wide (*triangle)[kRows], double threshold, Wide* sigma) {
  for (int j = 0; j < M; ++j) {
    Wide sum = wide(0.0);
    for (int r = 0; r < M; ++r) sum = madd(triangle[j][r], triangle[j][r], sum);
    sigma[j] = square_root(sum);
  }
  for (int pass = 0; pass < M; ++pass)
    for (int j = pass % 2; j + 1 < M; j += 2) {
      const Lanes swap = sigma[j] < sigma[j + 1];
      if (!any(swap)) continue;
      const Wide high = select(swap, sigma[j + 1], sigma[j]), low = select(swap, sigma[j], sigma[j + 1]);
      sigma[j] = high;
      sigma[j + 1] = low;
      for (int r = 0; r < M; ++r) {
        const Wide a = triangle[j][r], b = triangle[j + 1][r];
        triangle[j][r] = select(swap, b, a);
        triangle[j + 1][r] = select(swap, a, b);
      }
    }
  Lanes good = sigma[M - 1] > wide(threshold) * sigma[0];
  for (int j = 0; j + 1 < M; ++j) good &= sigma[j] > sigma[j + 1];
  for (int j = 0; j < M; ++j) {
    const Wide inverse = wide(1.0) / sigma[j];
    for (int r = 0; r < M; ++r) triangle[j][r] *= inverse;
  }
  return good;
}

// The factor of eq. (16) and the damped answer in z, in the lanes of `where` that are returned; shapes: room for k M
// packs.
template <int M>
inline Lanes closed_form_damping(double rank_tolerance, const Wide* const* column, int k, const Wide* rhs,
                                 const Wide* limit, Lanes where, const LaneInner<M>& in, Wide* shapes, Wide* z,
                                 Wide& kappa) {
  Wide triangle[kRows][kRows], sigma[kRows], beta[kRows], square[kRows], weight[kRows];
  for (int j = 0; j < M; ++j) {
    const Wide root = wide(1.0) / square_root(in.factor.pivot_inverse[j]);
    for (int i = 0; i < M; ++i) triangle[j][i] = i < j ? wide(0.0) : i == j ? root : in.factor.lower[i][j] * root;
  }
  jacobi<M>(where, triangle);
  where &= sort_spectrum<M>(triangle, rank_tolerance, sigma);
  for (int j = 0; j < M; ++j) {
    beta[j] = dot<M>(triangle[j], rhs);
    square[j] = sigma[j] * sigma[j];
  }
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < M; ++j) shapes[i * M + j] = dot<M>(column[i], triangle[j]);
  kappa = closed_form_damping(M, shapes, M, k, limit, beta, square);
  for (int j = 0; j < M; ++j) weight[j] = beta[j] / (square[j] + kappa);
  for (int i = 0; i < k; ++i) {
    z[i] = wide(0.0);
    for (int j = 0; j < M; ++j) z[i] = madd(shapes[i * M + j], weight[j], z[i]);
  }
  return where;
}

// choose_damping() of singularity_robust.hpp in the lanes of `where`, where the Gram matrix is harmless: the factor and
// the damped answer in z; elsewhere both stay. Returns the lanes that were answered.
template <int M>
inline STILLREACH_NOINLINE Lanes choose_damping(const LawSettings& law, LaneSystem& s, Lanes where, LaneInner<M>& in,
                                                Wide& kappa, Wide& steps) {
  where &= in.condition <= wide(kPlainCondition);
  const bool exact = law.damping == DampingKind::EXACT;
  if (!any(where) || (!exact && law.norm == NormKind::EUCLIDEAN)) return no_lane();
  Wide found, count = wide(1.0);
  for (int j = 0; j < s.k; ++j) s.answer[j] = s.z[j];
  if (exact)
    where = exact_damping(Rows<M>{M}, LaneColumns{s.column}, s.k, s.rhs, s.limit, law.norm, where, in.factor, in.dual,
                          s.answer, found, count);
  else
    where =
        closed_form_damping<M>(law.rank_tolerance, s.column, s.k, s.rhs, s.limit, where, in, s.shapes, s.answer, found);
  const Lanes damped = where & (found > wide(0.0));
  kappa = select(damped, found, kappa);
  steps = select(damped, count, steps);
  for (int j = 0; j < s.k; ++j) s.z[j] = select(damped, s.answer[j], s.z[j]);
  return where;
}

STILLREACH_END
