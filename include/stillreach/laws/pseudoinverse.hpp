// Eq. (3) of Bedrossian (1994): dq = B J' (J B J')^-1 twist, B = I - A'(AA')^-1 A; with weights the weighted
// pseudoinverse.
#pragma once

#include "stillreach/linear/inner.hpp"
#include "stillreach/problem/joint_weight.hpp"

STILLREACH_BEGIN

// The part of the reference rate that does not move the tool: nu + J^+ (J nu fixed at its value) on the working joints,
// that is, (B - B J'(J B J')^+ J B) nu (after eq. (1)). Writes scaled rates to `null_rates` (k). whitened: w.columns
// are, by the full joint weight.
template <int M>
inline void project_reference(Rows<M> m, const Problem& p, const System& s, double threshold, bool whitened,
                              Workspace& w, double* null_rates) {
  double b[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  for (int j = 0; j < s.k; ++j) {
    null_rates[j] = p.reference[w.joint[j]] / w.scale[j];
    if (!is_finite(null_rates[j])) null_rates[j] = 0.0;
  }
  if (whitened) {  // to weighted rates: z = L' x
    for (int i = 0; i < s.k; ++i) {
      double sum = 0.0;
      for (int j = i; i < s.weighted && j < s.k; ++j) sum = madd(w.triangle[j * s.k + i], null_rates[j], sum);
      null_rates[i] = sum;
    }
  }
  for (int j = 0; j < s.k; ++j)
    for (int r = 0; r < m(); ++r) b[r] = madd(w.columns[j * kStride + r], null_rates[j], b[r]);
  Inner in;
  solve_inner(m, w.columns, nullptr, s.k, b, 0.0, threshold, w.work, w.target, in);
  for (int j = 0; j < s.k; ++j) null_rates[j] -= w.target[j];
  if (whitened) unwhiten(s, w, 1, null_rates);
}

// All working joints at rest, clamped: the answer where there is no problem to solve.
inline void rest(const Problem& p, double* rates) {
  for (int i = 0; i < p.n; ++i) rates[i] = p.lower[i] < p.upper[i] ? clamp(0.0, p.lower[i], p.upper[i]) : p.lower[i];
}

template <int M>
inline void pseudoinverse(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  int k;
  out.status = OK;
  out.damping = 0.0;
  out.scale = 1.0;
  out.iterations = 0;
  find_working_joints(p, nullptr, w, k, out.rates);
  if (k == 0) {
    out.status |= NO_WORKING_JOINT;
    return report(m, p, out);
  }
  System s = assemble(m, p, out.rates, nullptr, k, nullptr, w);
  if (!s.finite) {
    rest(p, out.rates);
    out.status |= INVALID_INPUT;
    return report(m, p, out);
  }
  whiten(p, law.rank_tolerance, s, w);
  const bool offset = weight_offset(m, p, out.rates, nullptr, s, w);
  Inner in;
  solve_inner(m, w.columns, nullptr, k, s.rhs, 0.0, law.rank_tolerance, w.work, w.z, in);
  out.iterations = 1;
  if (in.rank < full_rank(p, k) || s.idle) out.status |= SINGULAR;
  unwhiten(s, w, 1, w.z);
  if (offset)
    for (int j = 0; j < k; ++j) w.z[j] += w.offset[j];
  if (p.reference) {
    project_reference(m, p, s, law.rank_tolerance, s.full, w, w.limit);
    for (int j = 0; j < k; ++j) w.z[j] += w.limit[j];
  }
  for (int j = 0; j < k; ++j) {
    const int i = w.joint[j];
    out.rates[i] = w.scale[j] * w.z[j];
    if (!(out.rates[i] <= p.upper[i] && out.rates[i] >= p.lower[i])) out.status |= OVER_LIMIT;
    if (!is_finite(out.rates[i])) {
      out.rates[i] = clamp(0.0, p.lower[i], p.upper[i]);
      out.status |= INVALID_INPUT;
    }
  }
  report(m, p, out);
}

STILLREACH_END
