// The damping laws' factors for four problems at once: exact_damping.hpp, and eq. (16) from singular values.
#pragma once

#include "damping.hpp"
#include "lane_system.hpp"

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
  static constexpr Tournament pairs = tournament();
  for (int sweep = 0; sweep < kSweeps && any(where); ++sweep) {
    Mask restless = no_lane();
    for (const auto& round : pairs.rounds)
      for (const auto& pair : round) {
        if (pair[0] >= M || pair[1] >= M) continue;
        Pack *P = triangle[pair[0]], *Q = triangle[pair[1]];
        const Rotations turn = rotations(product(P, P), product(Q, Q), product(P, Q), where);
        if (!any(turn.here)) continue;
        restless |= turn.large;
        for (int r = 0; r < M; ++r) {
          const Pack a = P[r], b = Q[r];
          P[r] = madd(turn.c, a, -(turn.s * b)), Q[r] = madd(turn.s, a, turn.c * b);
        }
      }
    where &= restless;
  }
}

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

// furthest() of exact_damping.hpp.
template <int M>
inline Pack furthest(const Pack* const* column, int k, const Pack* limit, int norm, const Pack* z, Pack* w) {
  Pack most = zero_pack(), square = zero_pack(), joint = zero_pack(), weight = zero_pack();
  for (int j = 0; j < k; ++j) {
    const Pack u = magnitude(z[j]) * limit[j];
    const Mask further = u > most;
    most = select(further, u, most), joint = select(further, broadcast(j), joint);
    weight = select(further, select(z[j] < zero_pack(), -limit[j], limit[j]), weight);
    square = madd(u, u, square);
  }
  if (norm == NORM_INF) {
    const Pack* chosen[kLanes];
    for (int l = 0; l < kLanes; ++l) chosen[l] = column[static_cast<int>(joint[l])];
    for (int r = 0; r < M; ++r) w[r] = Pack{chosen[0][r][0], chosen[1][r][1], chosen[2][r][2], chosen[3][r][3]} * weight;
    return most;
  }
  const Pack size = square_root(square);
  for (int r = 0; r < M; ++r) w[r] = zero_pack();
  for (int j = 0; j < k; ++j) {
    weight = z[j] * limit[j] / size * limit[j];
    for (int r = 0; r < M; ++r) w[r] = madd(column[j][r], weight, w[r]);
  }
  return size;
}

// exact_damping() of exact_damping.hpp in the lanes of `where`; in the others kappa is 0. Returns the lanes that were answered.
template <int M>
inline Mask exact_damping(const Pack* const* column, int k, const Pack* rhs, const Pack* limit, int norm, Mask where, LaneInner<M>& in,
                          Pack* z, Pack& kappa, Pack& steps) {
  LaneFactor<M>& f = in.factor;
  Pack diagonal[M], w[M], v[M], t[M];
  Mask settled = no_lane();
  for (int r = 0; r < M; ++r) diagonal[r] = f.gram[r][r];
  kappa = steps = zero_pack();
  for (int step = 1; step <= kDampingSteps; ++step) {
    const Pack u = furthest<M>(column, k, limit, norm, z, w);
    const Mask meets = where & (u <= broadcast(1.0 + kLimitSlack));
    settled |= meets, where &= ~meets;
    steps = select(meets, broadcast(step), steps);
    if (!any(where)) break;
    solve<M>(f, w, v), solve<M>(f, in.dual, t);
    const Pack b[] = {dot<M>(rhs, in.dual), dot<M>(in.dual, in.dual), dot<M>(in.dual, t)};
    const Pack c[] = {dot<M>(w, v), dot<M>(v, v), inverse_norm<M>(f, v)}, g[] = {u, dot<M>(v, in.dual), dot<M>(v, t)};
    const Pack next = kappa + certain_step(u, b, c, g);
    where &= next > kappa;
    kappa = select(where, next, kappa);
    for (int r = 0; r < M; ++r) f.gram[r][r] = diagonal[r] + kappa;
    where &= factor<M>(f) < broadcast(infinity());
    solve<M>(f, rhs, in.dual);
    for (int j = 0; j < k; ++j) z[j] = dot<M>(column[j], in.dual);
  }
  return settled;
}

// Eq. (16), from the shapes (k x M), beta and sigma^2 of damping.hpp.
template <int M>
inline Pack closed_form_damping(const Pack* shapes, int k, const Pack* limit, const Pack* beta, const Pack* square) {
  Pack left = zero_pack(), right = zero_pack(), inverse[M];
  for (int j = 0; j < M; ++j) inverse[j] = broadcast(1.0) / square_root(square[j]);
  for (int i = 0; i < k; ++i) {
    Pack sum = zero_pack();
    for (int j = 0; j < M; ++j) sum = madd(magnitude(shapes[M * i + j]), inverse[j], sum);
    left = larger(left, sum * limit[i]);
  }
  for (int j = 0; j < M; ++j) right = larger(right, magnitude(beta[j]));
  return broadcast(0.25) * left * left * right * right;
}

// The factor of eq. (16) and the damped answer in z, in the lanes of `where` that are returned; shapes: room for k M packs.
template <int M>
inline Mask closed_form_damping(double rank_tolerance, const Pack* const* column, int k, const Pack* rhs, const Pack* limit, Mask where,
                                const LaneInner<M>& in, Pack* shapes, Pack* z, Pack& kappa) {
  Pack triangle[M][M], sigma[M], beta[M], square[M], weight[M];
  for (int j = 0; j < M; ++j) {
    const Pack root = broadcast(1.0) / square_root(in.factor.pivot_inverse[j]);
    for (int i = 0; i < M; ++i) triangle[j][i] = i < j ? zero_pack() : i == j ? root : in.factor.lower[i][j] * root;
  }
  jacobi<M>(where, triangle);
  where &= sort_spectrum<M>(triangle, rank_tolerance, sigma);
  for (int j = 0; j < M; ++j) beta[j] = dot<M>(triangle[j], rhs), square[j] = sigma[j] * sigma[j];
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < M; ++j) shapes[i * M + j] = dot<M>(column[i], triangle[j]);
  kappa = closed_form_damping<M>(shapes, k, limit, beta, square);
  for (int j = 0; j < M; ++j) weight[j] = beta[j] / (square[j] + kappa);
  for (int i = 0; i < k; ++i) {
    z[i] = zero_pack();
    for (int j = 0; j < M; ++j) z[i] = madd(shapes[i * M + j], weight[j], z[i]);
  }
  return where;
}

// choose_damping() of singularity_robust.hpp in the lanes of `where`, where the Gram matrix is harmless: the factor and the
// damped answer in z; elsewhere both stay. Returns the lanes that were answered.
template <int M>
inline STILLREACH_NOINLINE Mask choose_damping(const LawSettings& law, LaneSystem& s, Mask where, LaneInner<M>& in, Pack& kappa,
                                               Pack& steps) {
  where &= in.condition <= broadcast(kPlainCondition);
  const bool exact = law.damping == DAMPING_EXACT;
  if (!any(where) || (!exact && law.norm == NORM_2)) return no_lane();
  Pack found, count = broadcast(1.0);
  for (int j = 0; j < s.k; ++j) s.answer[j] = s.z[j];
  if (exact)
    where = exact_damping<M>(s.column, s.k, s.rhs, s.limit, law.norm, where, in, s.answer, found, count);
  else
    where = closed_form_damping<M>(law.rank_tolerance, s.column, s.k, s.rhs, s.limit, where, in, s.shapes, s.answer, found);
  const Mask damped = where & (found > zero_pack());
  kappa = select(damped, found, kappa), steps = select(damped, count, steps);
  for (int j = 0; j < s.k; ++j) s.z[j] = select(damped, s.answer[j], s.z[j]);
  return where;
}

STILLREACH_END
