// KeepDirection: the largest fraction of the commanded twist that the bounds allow, in its direction, then the rates
// nearest to the reference. The reachable twists are a polytope; a bounded least-squares solve at an unreachable fraction
// gives its nearest point and with it a supporting plane, and the next fraction is where the commanded ray meets that
// plane: Newton's method on the distance, which is convex and piecewise smooth, so it ends in a few steps on the facet.
#pragma once

#include "least_error.hpp"

STILLREACH_BEGIN

constexpr int kFractionSteps = 60;
constexpr double kReached = 1e-13;  // relative residual that counts as none

template <int M>
inline double size_of(Rows<M> m, const double* a) {
  return square_root(dot(m, a, a));
}

// Largest fraction in [0, 1] with fixed + fraction * twist reachable; b holds the bounded solution there. Negative: none.
template <int M>
inline double largest_fraction(Rows<M> m, const double* fixed, const double* twist, double scale, Box& b, Inner& in, bool solved,
                               bool& capped) {
  double fraction = 1.0, rhs[kRows];
  for (int step = 0; step < kFractionSteps; ++step) {
    for (int r = 0; r < m(); ++r) rhs[r] = madd(fraction, twist[r], fixed[r]);
    solve_box(m, rhs, b, in, solved);
    solved = false;
    capped |= b.capped;
    residual_of(m, b.columns, nullptr, b.k, rhs, b.z, b.residual);
    const double error = size_of(m, b.residual);
    if (error <= kReached * scale) return fraction;
    const double along = dot(m, b.residual, twist);
    if (!(along > 0.0) || (fraction == 0.0)) return -1.0;
    double next = fraction - error / (along / error);
    if (!(next < fraction)) return fraction;
    if (next < 0.0) next = next > -1e-12 ? 0.0 : -1.0;
    if (next < 0.0) return -1.0;
    fraction = next;
  }
  capped = true;
  return fraction;
}

template <int M>
inline void keep_direction(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  System s;
  if (!prepare(m, p, w, out, s)) return;
  double rhs[kRows], twist[kRows], fixed[kRows];
  Box b = make_box(m, law, p, s, w, rhs);
  Inner in;
  const bool inside_all = solve_unbounded(m, rhs, b, in);
  apply_rows(m, p.metric.rows, p.twist, twist);
  for (int r = 0; r < m(); ++r) twist[r] /= s.unit_b, fixed[r] = rhs[r] - twist[r];
  double scale = size_of(m, twist) + size_of(m, fixed);
  for (int j = 0; j < s.k; ++j) scale = larger(scale, magnitude(b.target[j]) * 1e-3 * size_of(m, b.columns + j * m()));
  if (in.rank < (s.k < m() ? s.k : m())) out.status |= SINGULAR;
  if (inside_all && size_of(m, in.residual) <= kReached * scale) {
    for (int j = 0; j < s.k; ++j) b.z[j] = b.target[j];
  } else {
    const bool warm = warm_states(w, s.k, out.active, b.state);
    bool capped = false;
    out.scale = largest_fraction(m, fixed, twist, scale, b, in, !warm, capped);
    if (out.scale < 0.0) {
      out.scale = 0.0;
      solve_box(m, fixed, b, in, false);
      capped |= b.capped;
    }
    if (out.scale < 1.0) out.status |= SCALED;
    if (capped) out.status |= ITERATION_LIMIT;
  }
  out.iterations = b.iterations;
  write_rates(p, b, w, out.rates);
  report(m, p, out);
  if (out.scale == 0.0 && fault_not_compensated(m, p, out)) out.status |= FAULT_NOT_COMPENSATED;
}

STILLREACH_END
