// system.hpp for all lanes at once: the working joints' weighted columns and right-hand side, and the report.
#pragma once

#include "stillreach/batch/lane_solve.hpp"
#include "stillreach/problem/system.hpp"

STILLREACH_BEGIN

// Problems of one arm. Column i of a Jacobian is at jacobian + i * M.
struct LaneProblem {
  int n;
  const Wide* jacobian;
  const Wide* twist;      // M
  const Wide* lower;      // n
  const Wide* upper;      // n
  Metric metric;          // without a full joint weight
  Wide typical = Wide{};  // typical_rate()
};

struct LaneAnswer {
  Wide* rates;     // n
  Wide* residual;  // M: twist - J rates
  Wide damping, scale, task_error;
  Flags status;  // Status bits
  Wide iterations;
};

// The joints that work in some lane, in order: k of them.
struct LaneSystem {
  int k;
  bool alike;           // each of them works in every lane
  bool moves;           // some fixed joint moves
  bool even;            // working joints' bounds are the same on both sides (known to the damping laws)
  Wide working;         // how many work, lane by lane
  int* joint;           // k
  Lanes* works;         // k
  const Wide** column;  // k: M numbers each, weighted, zeros in lanes where the joint does not work
  Wide* columns;        // k M, where they differ from the Jacobian's
  Wide* scale;          // k
  Wide* limit;          // k: reciprocal of the joint's bound, for the damping laws
  Wide* z;              // k
  Wide* top;            // k: rates from which on a joint counts as at its upper bound,
  Wide* bottom;         // k: and at its lower one
  Wide* lower;          // k: bounds of z
  Wide* upper;          // k
  Wide *length, *answer, *trial, *releases, *side;  // k each, for the bounded search
  Lanes* outside;                                   // k
  const Wide** masked_column;                       // k
  Wide* shapes;                                     // k M
  Wide* few;                                        // 30: columns of free variables, where they are fewer than rows
  Wide rhs[kRows];
};

// Working joints; fixed ones get their rate. Where bounds are shared this is done once.
inline void find_working_joints(const LaneProblem& p, LaneSystem& s, Wide* rates) {
  s.k = 0;
  s.alike = true;
  s.moves = false;
  for (int i = 0; i < p.n; ++i) {
    const Lanes works = p.lower[i] < p.upper[i];
    rates[i] = p.lower[i];
    s.moves |= any(moves_fixed(p.lower[i], p.upper[i]));
    if (!any(works)) continue;
    s.alike &= all(works);
    s.scale[s.k] = wide(p.metric.columns ? p.metric.columns[i] : 1.0);
    const Wide small = wide(1e-9);
    s.top[s.k] = p.upper[i] - small * magnitude(p.upper[i]);
    s.bottom[s.k] = p.lower[i] + small * magnitude(p.lower[i]);
    s.joint[s.k] = i;
    s.works[s.k] = works;
    ++s.k;
  }
  s.working = wide(0.0);
  for (int j = 0; j < s.k; ++j) s.working += select(s.works[j], wide(1.0), wide(0.0));
}

// The twist less what the fixed joints do, weighted.
template <int M>
STILLREACH_INLINE void right_hand_side(const LaneProblem& p, LaneSystem& s) {
  Wide raw[kRows];
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) raw[r] = p.twist[r];
  for (int i = 0; s.moves && i < p.n; ++i) {
    const Lanes moves = moves_fixed(p.lower[i], p.upper[i]);
    if (!any(moves)) continue;
    for (int r = 0; r < M; ++r) raw[r] = select(moves, madd(-p.jacobian[i * M + r], p.lower[i], raw[r]), raw[r]);
  }
  apply_rows(Rows<M>{M}, p.metric.rows, raw, s.rhs);
}

// The damping laws count rates relative to the bounds (D of dq = D u): scale and limit of each working joint.
inline void scale_by_extent(const LaneProblem& p, LaneSystem& s) {
  const auto in_joint_units = [&](int i, Wide extent) {
    return p.metric.units ? extent / wide(p.metric.units[i]) : extent;
  };
  Wide reference = wide(0.0);
  s.even = true;
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    s.even &= !any(s.works[j] & (p.upper[i] != -p.lower[i]));
    const Wide e = in_joint_units(i, larger(p.upper[i], -p.lower[i]));
    reference = select(s.works[j] & (e < wide(infinity())) & (e > reference), e, reference);
  }
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Wide extent = larger(p.upper[i], -p.lower[i]), scale = wide(p.metric.columns ? p.metric.columns[i] : 1.0);
    const Lanes finite = extent < wide(infinity());
    s.scale[j] = select(finite & (reference > wide(0.0)), scale * (in_joint_units(i, extent) / reference), scale);
    s.limit[j] = select(finite & s.works[j], s.scale[j] / extent, wide(0.0));
  }
}

// Columns a = scale R J_i; scaled: s.scale is not 1 throughout.
template <int M>
STILLREACH_INLINE void weigh_columns(const LaneProblem& p, bool scaled, LaneSystem& s) {
  if (!scaled && s.alike && !p.metric.rows) {
    for (int j = 0; j < s.k; ++j) s.column[j] = p.jacobian + s.joint[j] * M;
    return;
  }
  for (int j = 0; j < s.k; ++j) {
    Wide* a = s.columns + j * M;
    s.column[j] = a;
    apply_rows(Rows<M>{M}, p.metric.rows, p.jacobian + s.joint[j] * M, a);
    if (scaled) STILLREACH_UNROLL for (int r = 0; r < M; ++r) a[r] *= s.scale[j];
    if (!s.alike) STILLREACH_UNROLL for (int r = 0; r < M; ++r) a[r] = select(s.works[j], a[r], wide(0.0));
  }
}

// Lanes whose numbers may be squared and summed as they are; narrower than rescale() of system.hpp, which does the
// rest.
template <int M>
STILLREACH_INLINE Lanes ordinary(const Wide& trace, const Wide* rhs) {
  Wide size = wide(0.0);
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) size += magnitude(rhs[r]);
  const Lanes small = (size > wide(1e-50)) & (size < wide(1e50));
  return (trace > wide(1e-100)) & (trace < wide(1e100)) & (small | (size == wide(0.0)));
}

// report() of system.hpp. with_residual: somebody asked for residual or task error. Returns the lanes that it covers.
template <int M>
inline Lanes report(const LaneProblem& p, const LaneSystem& s, bool with_residual, LaneAnswer& out) {
  Lanes saturated = no_lane(), covered = every_lane();
  for (int j = 0; j < s.k; ++j) {
    const Wide rate = out.rates[s.joint[j]];
    saturated |= s.works[j] & ((rate >= s.top[j]) ^ (rate <= s.bottom[j]));
  }
  out.status |= flag(saturated, SATURATED);
  const Wide drift = s.moves ? drift_of<Wide>(Rows<M>{M}, p) : wide(0.0);
  const Lanes drifts = drift != wide(0.0);
  if (!with_residual && !any(drifts)) return covered;
  const Rows<M> m{M};
  residual_by_rows(m, p, out.rates, out.residual);
  covered = except(covered, drifts & (largest_of(m, out.residual) >
                                      wide(kCompensated) * drift));  // for the single tick: can it stand still?
  Wide weighted[kRows];
  apply_rows(m, p.metric.rows, out.residual, weighted);
  const Wide size = largest_of(m, weighted), sum = dot(m, weighted, weighted);
  out.task_error = square_root(sum);
  return covered & (((size == wide(0.0)) & (sum == size)) | ((size > wide(1e-50)) & (size < wide(1e50))));
}

STILLREACH_END
