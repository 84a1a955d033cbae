// KeepDirection: the largest fraction of the commanded twist that the bounds allow, in its direction, then the rates
// nearest to the reference. The reachable twists are a polytope; a bounded least-squares solve at an unreachable fraction
// gives its nearest point and with it a supporting plane, and the next fraction is where the commanded ray meets that
// plane: Newton's method on the distance, which is convex and piecewise smooth, so it ends in a few steps on the facet.
#pragma once

#include "least_error.hpp"

STILLREACH_BEGIN

constexpr int kFractionSteps = 60;
constexpr double kReached = 1e-13;  // relative residual that counts as none,
constexpr double kNearly = 1e-9;    // and one that may be none, where the search cannot tell

template <int M>
inline double size_of(Rows<M> m, const double* a) {
  return square_root(dot(m, a, a));
}

// The residual that counts as none: rounding of the twist, and of the sum of what the joints contribute.
STILLREACH_INLINE double reached(const Box& b, double scale) {
  double largest = 0.0;
  for (int i = 0; i < b.k; ++i) largest = larger(largest, magnitude(b.z[i]) * b.length[i]);
  return kReached * scale + kRounding * largest;
}

// The box lies on one side of any plane: fixed + fraction * twist . normal <= its largest value over the box. An upper
// bound of the fraction from a normal that was good a tick ago; 1 where it says nothing.
template <int M>
inline double plane_fraction(Rows<M> m, const double* fixed, const double* twist, const Box& b, const double* normal) {
  const double along = dot(m, normal, twist);
  if (!(along > 0.0)) return 1.0;
  double support = -dot(m, normal, fixed);
  for (int i = 0; i < b.k; ++i) {
    const double slope = dot(m, normal, b.columns + i * kStride);
    if (slope != 0.0) support = madd(slope, slope > 0.0 ? b.upper[i] : b.lower[i], support);
  }
  const double fraction = support / along;
  return fraction >= 0.0 && fraction < 1.0 ? fraction : 1.0;
}

// Largest fraction in [0, 1] with fixed + fraction * twist reachable; b holds the bounded solution there. Negative: none.
template <int M>
inline double largest_fraction(Rows<M> m, const double* fixed, const double* twist, double scale, Box& b, Inner& in, bool solved,
                               double* plane, bool& capped) {
  double fraction = plane ? plane_fraction(m, fixed, twist, b, plane) : 1.0;
  solved = solved && fraction == 1.0;
  double rhs[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  for (int step = 0; step < kFractionSteps; ++step) {
    for (int r = 0; r < m(); ++r) rhs[r] = madd(fraction, twist[r], fixed[r]);
    solve_box(m, rhs, b, in, solved);
    solved = false;
    capped |= b.capped;
    residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
    const double error = size_of(m, b.residual);
    if (error <= reached(b, scale)) return fraction;
    const double along = dot(m, b.residual, twist);
    const bool nearly = error <= kNearly * scale;  // then the direction of the residual may be noise
    if (!(along > 0.0) || fraction == 0.0) return nearly ? fraction : -1.0;
    if (plane)
      for (int r = 0; r < m(); ++r) plane[r] = b.residual[r] / error;
    double next = fraction - error / (along / error);
    if (!(next < fraction)) return fraction;
    if (next < -kNearly) return nearly ? fraction : -1.0;
    fraction = larger(next, 0.0);
  }
  capped = true;
  return fraction;
}

template <int M>
inline void keep_direction(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  System s;
  if (!prepare(m, p, w, out, s)) return;
  double rhs[kStride], twist[kRows], fixed[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  Box b = make_box(m, law, p, s, out.rates, w, rhs);
  Inner in;
  const bool inside_all = solve_unbounded(m, rhs, b, in);
  apply_rows(m, p.metric.rows, p.twist, twist);
  for (int r = 0; r < m(); ++r) twist[r] /= s.unit_b, fixed[r] = rhs[r] - twist[r];
  const double scale = size_of(m, twist) + size_of(m, fixed);
  if (in.rank < (s.k < m() ? s.k : m())) out.status |= SINGULAR;
  for (int j = 0; j < s.k; ++j) b.z[j] = b.target[j];
  if (!inside_all || size_of(m, in.residual) > reached(b, scale)) {
    const bool warm = warm_states(w, s.k, out.active, b.state);
    bool capped = false;
    out.scale = largest_fraction(m, fixed, twist, scale, b, in, !warm, out.plane, capped);
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
