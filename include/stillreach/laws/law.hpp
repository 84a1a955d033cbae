// One door to all laws. The answer's rates are finite for any finite problem; inside the bounds for all but
// Pseudoinverse.
#pragma once

#include "stillreach/laws/keep_direction.hpp"
#include "stillreach/laws/least_error.hpp"
#include "stillreach/laws/singularity_robust.hpp"

STILLREACH_BEGIN

template <int M>
inline void solve_rows(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  switch (law.kind) {
    case LawKind::PSEUDOINVERSE: return pseudoinverse(m, law, p, w, out);
    case LawKind::SINGULARITY_ROBUST: return singularity_robust(m, law, p, w, out);
    case LawKind::LEAST_ERROR: return least_error(m, law, p, w, out);
    case LawKind::KEEP_DIRECTION: return keep_direction(m, law, p, w, out);
  }
  rest(p, out.rates);  // a number that is not a LawKind
  out.status = INVALID_INPUT;
  out.damping = out.scale = 0.0;
  out.iterations = 0;
  report(m, p, out);
}

// Whether the working joints could hold the tool still, inside their bounds, against those that move at one rate. What
// their best answer without bounds leaves no other one undoes. answer: the law's.
template <int M>
inline bool can_stand_still(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, const Answer& answer) {
  const double still[kRows] = {0, 0, 0, 0, 0, 0};
  double residual[kRows], rhs[kStride];
  LawSettings bare = law;
  bare.kind = LawKind::LEAST_ERROR;
  bare.parts = 0;
  Problem stand = p;
  stand.twist = still;
  stand.reference = nullptr;
  Answer out = answer;
  out.residual = residual;
  if (law.kind == LawKind::KEEP_DIRECTION && answer.scale == 0.0) {  // it is at rest, as nearly as can be
    task_residual(m, stand, answer.rates, residual);
    return !fault_not_compensated(m, stand, out);
  }
  out.rates = w.other;
  out.active = w.other_active;
  out.multiplier = nullptr;
  for (int i = 0; i < p.n; ++i) out.active[i] = 0;
  System s;
  if (!prepare(m, stand, w, out, s)) return !(out.status & FAULT_NOT_COMPENSATED);
  Box b = make_box(m, bare, stand, s, out.rates, w, rhs);
  Inner in;
  if (solve_unbounded(m, rhs, b, in)) {
    for (int j = 0; j < s.k; ++j) b.z[j] = b.target[j];
  } else {
    double size = m();  // of the weights, so that this is surely more than rounding
    for (int r = 0; p.metric.rows && r < m() * m(); ++r) size = madd(p.metric.rows[r], p.metric.rows[r], size);
    const double least = size_of(m, in.residual) * s.unit_b / square_root(m() * size);
    if (least > kCompensated * drift_of<double>(m, stand)) return false;
    if (in.rank < (s.k < m() ? s.k : m())) out.status |= SINGULAR;
    bare_optimum(m, s, rhs, w, b, in, out);
  }
  write_rates(stand, b, w, out.rates);
  task_residual(m, stand, out.rates, residual);
  return !fault_not_compensated(m, stand, out);
}

// solve_law(), whose FAULT_NOT_COMPENSATED only says that a fixed joint moves and the task is not met.
inline void solve_task(const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  switch (p.m) {
    case 6: solve_rows(Rows<6>{6}, law, p, w, out); break;
    case 3: solve_rows(Rows<3>{3}, law, p, w, out); break;
    default: solve_rows(Rows<0>{p.m}, law, p, w, out);
  }
}

// out.active holds the bounds that were active a tick ago (zeros: none) and receives those that are now.
inline void solve_law(const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  solve_task(law, p, w, out);
  if ((out.status & FAULT_NOT_COMPENSATED) && can_stand_still(Rows<0>{p.m}, law, p, w, out))
    out.status &= ~FAULT_NOT_COMPENSATED;
}

STILLREACH_END
