// KeepDirection: the largest fraction of the commanded twist that the bounds allow, in its direction, then the rates
// nearest to the reference. The reachable twists are a polytope; a bounded least-squares solve at an unreachable fraction
// gives its nearest point and with it a supporting plane, and the next fraction is where the commanded ray meets that
// plane: Newton's method on the distance, which is convex and piecewise smooth, so it ends in a few steps on the facet.
#pragma once

#include "least_error.hpp"

STILLREACH_BEGIN

constexpr int kFractionSteps = 60;
constexpr double kReached = 1e-13;  // relative residual that counts as none,
constexpr double kNearly = 1e-9;    // one that may be none, where the search cannot tell,
constexpr double kShort = 1e-5;     // and one whose direction needs care,
constexpr double kNothing = 1e-14;  // a fraction that counts as none
constexpr double kGrazing = 0.02;   // as does a plane that the twist meets at a smaller angle

// The residual that counts as none: rounding of the twist, and of the sum of what the joints contribute.
STILLREACH_INLINE double reached(const Box& b, double scale) {
  double largest = 0.0;
  for (int i = 0; i < b.k; ++i) largest = larger(largest, magnitude(b.z[i]) * b.length[i]);
  return kReached * scale + kRounding * largest;
}

// The box lies on one side of any plane: (fixed + fraction * twist) . normal <= its largest value over the box. An upper
// bound of the fraction; more than 1 where the plane says nothing, negative where it allows none. touching: b.z lies on the
// plane, so that free variables, and those without a bound on the side that rounding points to, move along it.
template <int M>
inline double plane_fraction(Rows<M> m, const double* fixed, const double* twist, const Box& b, const double* normal, bool touching) {
  const double along = dot(m, normal, twist);
  double support = -dot(m, normal, fixed);
  for (int i = 0; i < b.k; ++i) {
    const double slope = dot(m, normal, b.columns + i * kStride);
    double at = slope > 0.0 ? b.upper[i] : b.lower[i];
    if (touching && (b.state[i] == 0 || magnitude(at) == infinity())) at = b.z[i];
    if (slope != 0.0) support = madd(slope, at, support);
  }
  if (along > 0.0) return support / along;
  return support < 0.0 ? -1.0 : 2.0;
}

// The unit normal of the plane that the residual of b stands on. Where the residual is short its direction is rounded, and
// where the twist is nearly along the plane that matters: it is made orthogonal to the free columns again, which span the
// plane.
template <int M>
inline void plane_normal(Rows<M> m, const double* twist, double twist_size, Box& b, Inner& in, double error, double scale,
                         double* normal) {
  for (int r = 0; r < kStride; ++r) normal[r] = r < m() ? b.residual[r] / error : 0.0;
  int free = 0;
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] == 0) b.index[free++] = i;
  if (free == 0 || (error > kShort * scale && dot(m, normal, twist) > kGrazing * twist_size)) return;
  solve_inner(m, b.columns, b.index, free, normal, 0.0, b.threshold, b.work, b.target, in);
  const double length = size_of(m, in.residual);
  if (!(length > 0.5)) return;  // then the residual was noise altogether
  for (int r = 0; r < m(); ++r) normal[r] = in.residual[r] / length;
}

// Largest fraction in [0, 1] with fixed + fraction * twist reachable; b holds the bounded solution there. Negative: none.
// plane: the last supporting plane, in and out, or null.
template <int M>
inline double largest_fraction(Rows<M> m, const double* fixed, const double* twist, Box& b, Inner& in, bool solved, double* plane,
                               bool& capped) {
  const double twist_size = size_of(m, twist), fixed_size = size_of(m, fixed);
  double fraction = plane ? plane_fraction(m, fixed, twist, b, plane, false) : 1.0;
  if (!(fraction >= 0.0 && fraction < 1.0)) fraction = 1.0;
  solved = solved && fraction == 1.0;
  double rhs[kStride] = {0, 0, 0, 0, 0, 0, 0, 0}, normal[kStride];
  for (int step = 0; step < kFractionSteps; ++step) {
    for (int r = 0; r < m(); ++r) rhs[r] = madd(fraction, twist[r], fixed[r]);
    solve_box(m, rhs, b, in, solved);
    solved = false;
    if (b.capped) {  // a start from elsewhere can cost more steps than there are
      for (int i = 0; i < b.k; ++i) b.state[i] = 0;
      solve_box(m, rhs, b, in, false);
    }
    capped = b.capped;
    residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
    const double error = size_of(m, b.residual), scale = madd(fraction, twist_size, fixed_size);
    if (error <= reached(b, scale)) return fraction;
    plane_normal(m, twist, twist_size, b, in, error, scale, normal);
    if (plane)
      for (int r = 0; r < m(); ++r) plane[r] = normal[r];
    const double next = plane_fraction(m, fixed, twist, b, normal, true);
    const bool nearly = error <= kNearly * scale;  // then the plane may be noise
    if (fraction == 0.0 || next < -kNearly) return nearly ? fraction : -1.0;
    if (!(next < fraction)) return fraction;
    fraction = next > kNothing ? next : 0.0;
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
    out.scale = largest_fraction(m, fixed, twist, b, in, !warm, out.plane, capped);
    if (out.scale < 0.0) {
      out.scale = 0.0;
      solve_box(m, fixed, b, in, false);
      capped = b.capped;
    }
    if (out.scale < 1.0) out.status |= SCALED;
    if (capped) out.status |= ITERATION_LIMIT;
  }
  out.iterations = b.iterations;
  write_rates(p, b, w, out.rates);
  report(m, p, out);
}

STILLREACH_END
