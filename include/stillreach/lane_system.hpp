// system.hpp for four problems at once: the working joints' weighted columns and right-hand side, and the report.
#pragma once

#include "lane_solve.hpp"
#include "system.hpp"

STILLREACH_BEGIN

// Four problems of one arm. Column i of a Jacobian is at jacobian + i * M.
struct LaneProblem {
  int n;
  const Pack* jacobian;
  const Pack* twist;  // M
  const Pack* lower;  // n
  const Pack* upper;  // n
  Metric metric;      // without a full joint weight
};

struct LaneAnswer {
  Pack* rates;     // n
  Pack* residual;  // M: twist - J rates
  Pack damping, scale, task_error;
  Mask status;     // Status bits
  Pack iterations;
};

// The joints that work in some lane, in order: k of them.
struct LaneSystem {
  int k;
  bool alike;      // each of them works in every lane
  bool moves;      // some fixed joint moves
  bool even;       // working joints' bounds are the same on both sides (known to the damping laws)
  Pack working;    // how many work, lane by lane
  Mask narrow;     // lanes with a window that is narrow beside the widest
  int* joint;      // k
  Mask* works;     // k
  const Pack** column;  // k: M numbers each, weighted, zeros in lanes where the joint does not work
  Pack* columns;   // k M, where they differ from the Jacobian's
  Pack* scale;     // k
  Pack* limit;     // k: reciprocal of the joint's bound, for the damping laws
  Pack* z;         // k
  Pack* top;       // k: rates from which on a joint counts as at its upper bound,
  Pack* bottom;    // k: and at its lower one
  Pack* lower;     // k: bounds of z
  Pack* upper;     // k
  Pack *length, *answer, *trial, *releases, *side;  // k each, for the bounded search
  const Pack** masked_column;  // k
  Pack* shapes;    // k M
  Pack* few;       // 30: columns of free variables, where they are fewer than rows
  Pack rhs[kRows];
};

STILLREACH_INLINE Mask flag(Mask where, std::int32_t status) { return where & static_cast<long long>(status); }

template <int M>
STILLREACH_INLINE void apply_rows(const double* R, const Pack* x, Pack* y) {
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) {
    if (!R) {
      y[r] = x[r];
      continue;
    }
    Pack sum = broadcast(R[r * M + r]) * x[r];
    for (int c = r + 1; c < M; ++c) sum = madd(broadcast(R[r * M + c]), x[c], sum);
    y[r] = sum;
  }
}

// Working joints; fixed ones get their rate. Where bounds are shared this is done once.
inline void find_working_joints(const LaneProblem& p, LaneSystem& s, Pack* rates) {
  s.k = 0, s.alike = true, s.moves = false;
  for (int i = 0; i < p.n; ++i) {
    const Mask works = p.lower[i] < p.upper[i];
    rates[i] = p.lower[i];
    s.moves |= any(~works & (p.lower[i] != zero_pack()));
    if (!any(works)) continue;
    s.alike &= all(works);
    s.scale[s.k] = broadcast(p.metric.columns ? p.metric.columns[i] : 1.0);
    const Pack small = broadcast(1e-9);
    s.top[s.k] = p.upper[i] - small * magnitude(p.upper[i]), s.bottom[s.k] = p.lower[i] + small * magnitude(p.lower[i]);
    s.joint[s.k] = i, s.works[s.k] = works, ++s.k;
  }
  Pack least = broadcast(infinity()), most = s.working = zero_pack();
  for (int j = 0; j < s.k; ++j) {
    const Pack upper = p.upper[s.joint[j]] / s.scale[j], width = upper - p.lower[s.joint[j]] / s.scale[j];
    s.working += select(s.works[j], broadcast(1.0), zero_pack());
    least = select(s.works[j], smaller(least, width), least), most = select(s.works[j], larger(most, width), most);
  }
  s.narrow = least < broadcast(kNarrow) * most;
}

// The twist less what the fixed joints do, weighted.
template <int M>
STILLREACH_INLINE void right_hand_side(const LaneProblem& p, LaneSystem& s) {
  Pack raw[M];
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) raw[r] = p.twist[r];
  for (int i = 0; s.moves && i < p.n; ++i) {
    const Mask moves = ~(p.lower[i] < p.upper[i]) & (p.lower[i] != zero_pack());
    if (!any(moves)) continue;
    for (int r = 0; r < M; ++r) raw[r] = select(moves, madd(-p.jacobian[i * M + r], p.lower[i], raw[r]), raw[r]);
  }
  apply_rows<M>(p.metric.rows, raw, s.rhs);
}

// The damping laws count rates relative to the bounds (D of dq = D u): scale and limit of each working joint.
inline void scale_by_extent(const LaneProblem& p, LaneSystem& s) {
  const auto in_joint_units = [&](int i, Pack extent) { return p.metric.units ? extent / broadcast(p.metric.units[i]) : extent; };
  Pack reference = zero_pack();
  s.even = true;
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    s.even &= !any(s.works[j] & (p.upper[i] != -p.lower[i]));
    const Pack e = in_joint_units(i, larger(p.upper[i], -p.lower[i]));
    reference = select(s.works[j] & (e < broadcast(infinity())) & (e > reference), e, reference);
  }
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Pack extent = larger(p.upper[i], -p.lower[i]), scale = broadcast(p.metric.columns ? p.metric.columns[i] : 1.0);
    const Mask finite = extent < broadcast(infinity());
    s.scale[j] = select(finite & (reference > zero_pack()), scale * (in_joint_units(i, extent) / reference), scale);
    s.limit[j] = select(finite & s.works[j], s.scale[j] / extent, zero_pack());
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
    Pack* a = s.columns + j * M;
    s.column[j] = a;
    apply_rows<M>(p.metric.rows, p.jacobian + s.joint[j] * M, a);
    if (scaled)
      STILLREACH_UNROLL for (int r = 0; r < M; ++r) a[r] *= s.scale[j];
    if (!s.alike)
      STILLREACH_UNROLL for (int r = 0; r < M; ++r) a[r] = select(s.works[j], a[r], zero_pack());
  }
}

// Lanes whose numbers may be squared and summed as they are; narrower than rescale() of system.hpp, which does the rest.
template <int M>
STILLREACH_INLINE Mask ordinary(const Pack& trace, const Pack* rhs) {
  Pack size = zero_pack();
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) size += magnitude(rhs[r]);
  const Mask small = (size > broadcast(1e-50)) & (size < broadcast(1e50));
  return (trace > broadcast(1e-100)) & (trace < broadcast(1e100)) & (small | (size == zero_pack()));
}

// report() of system.hpp. with_residual: somebody asked for residual or task error. Returns the lanes that it covers.
template <int M>
inline Mask report(const LaneProblem& p, const LaneSystem& s, bool with_residual, LaneAnswer& out) {
  Mask saturated = no_lane(), covered = every_lane();
  for (int j = 0; j < s.k; ++j) {
    const Pack rate = out.rates[s.joint[j]];
    saturated |= s.works[j] & ((rate >= s.top[j]) ^ (rate <= s.bottom[j]));
  }
  out.status |= flag(saturated, SATURATED);
  Pack drift = zero_pack();
  for (int i = 0; s.moves && i < p.n; ++i) {
    const Mask moves = ~(p.lower[i] < p.upper[i]) & (p.lower[i] != zero_pack());
    if (!any(moves)) continue;
    for (int r = 0; r < M; ++r)
      drift = larger(drift, select(moves, magnitude(p.jacobian[i * M + r] * p.lower[i]), zero_pack()));
  }
  const Mask drifts = drift != zero_pack();
  if (!with_residual && !any(drifts)) return covered;
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) out.residual[r] = p.twist[r];
  for (int i = 0; i < p.n; ++i)
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) out.residual[r] = madd(p.jacobian[i * M + r], -out.rates[i], out.residual[r]);
  Pack size = zero_pack(), weighted[M], sum = zero_pack();
  for (int r = 0; r < M; ++r) size = larger(size, magnitude(out.residual[r]));
  covered &= ~(drifts & (size > broadcast(kCompensated) * drift));  // whether the tool could be held still is for the single tick
  apply_rows<M>(p.metric.rows, out.residual, weighted);
  size = zero_pack();
  for (int r = 0; r < M; ++r) size = larger(size, magnitude(weighted[r])), sum = madd(weighted[r], weighted[r], sum);
  out.task_error = square_root(sum);
  return covered & ((size == zero_pack()) | ((size > broadcast(1e-50)) & (size < broadcast(1e50))));
}

STILLREACH_END
