// KeepDirection: the largest fraction of the commanded twist that the bounds allow, in its direction, then the rates
// nearest to the reference. The reachable twists are a polytope; a bounded least-squares solve at an unreachable fraction
// gives its nearest point and with it a supporting plane, and the next fraction is where the commanded ray meets that
// plane: Newton's method on the distance, which is convex and piecewise smooth, so it ends in a few steps on the facet.
#pragma once

#include "fraction.hpp"
#include "least_error.hpp"

STILLREACH_BEGIN

constexpr double kSafe = 1e9;       // condition number of a Gram matrix whose planes hold
constexpr double kShort = 1e-5;     // relative residual whose direction needs care,
constexpr double kGrazing = 0.02;   // as does a plane that the twist meets at a smaller angle
constexpr double kUnsure = 1e-11;   // relative residual from which on the end of the search is in doubt
constexpr double kNothing = 1e-14;  // a fraction that counts as none

// What rounding may have decided: a plane, or where it is about all or nothing, that.
struct Doubt {
  bool any, little;
};

// The unit normal of the plane that the residual of b stands on. Where the residual is short its direction is rounded, and
// where the twist is nearly along the plane that matters: it is made orthogonal to the free columns again, which span the
// plane. False: they leave nothing of it, and the residual is what the bounds cut off by rounding.
template <int M>
inline bool plane_normal(Rows<M> m, const double* twist, double twist_size, Box& b, Inner& in, double error, double scale,
                         double* normal) {
  for (int r = 0; r < kStride; ++r) normal[r] = r < m() ? b.residual[r] / error : 0.0;
  int free = 0;
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] == 0) b.index[free++] = i;
  if (free == 0 || (error > kShort * scale && dot(m, normal, twist) > kGrazing * twist_size)) return true;
  solve_inner(m, b.columns, b.index, free, normal, 0.0, b.threshold, b.work, b.target, in);
  const double length = size_of(m, in.residual);
  if (!(length > 0.5)) return false;
  for (int r = 0; r < m(); ++r) normal[r] = in.residual[r] / length;
  return true;
}

// Largest fraction in [0, 1] with fixed + fraction * twist reachable; b holds the bounded solution there. Negative: none.
// plane: the last supporting plane, in and out, or null.
template <int M>
inline double largest_fraction(Rows<M> m, const double* fixed, const double* twist, Box& b, Inner& in, bool solved, double* plane,
                               bool& capped, Doubt& doubt) {
  const double twist_size = size_of(m, twist), fixed_size = size_of(m, fixed);
  double fraction = plane ? plane_fraction(m, fixed, twist, b, plane, false) : 1.0;
  if (!(fraction >= 0.0 && fraction < 1.0)) fraction = 1.0;
  solved = solved && fraction == 1.0;
  double rhs[kStride] = {0, 0, 0, 0, 0, 0, 0, 0}, normal[kStride];
  for (int step = 0; step < kFractionSteps; ++step) {
    for (int r = 0; r < m(); ++r) rhs[r] = madd(fraction, twist[r], fixed[r]);
    solve_box(m, rhs, b, in, solved);
    solved = false;
    capped = b.capped;
    doubt.any |= b.doubtful, doubt.little |= in.way == SPECTRAL || in.condition > kTwiceCondition;
    if (capped) return fraction;
    residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
    const double error = size_of(m, b.residual), scale = madd(fraction, twist_size, fixed_size);
    if (error <= reached(b, scale)) return fraction;
    const bool unsure = error > kUnsure * scale, nearly = error <= kNearly * scale;  // where nearly, the plane may be noise
    if (!plane_normal(m, twist, twist_size, b, in, error, scale, normal)) {
      doubt.any |= unsure;
      return fraction;
    }
    if (plane)
      for (int r = 0; r < m(); ++r) plane[r] = normal[r];
    const double next = plane_fraction(m, fixed, twist, b, normal, true);
    const bool none = fraction == 0.0 || next < -kNearly;
    if (none && !nearly) return -1.0;
    if (none || !(next < fraction)) {
      doubt.any |= unsure;
      return fraction;
    }
    fraction = next > kNothing ? next : 0.0;
  }
  capped = true;
  return fraction;
}

// The search in the m rows that count. Negative: no fraction. solved: b.target and `in` hold the unbounded answer.
template <int M>
inline double search_fraction(Rows<M> m, const double* fixed, const double* twist, bool solved, Workspace& w, Box& b, Inner& in,
                              double* plane, bool& capped) {
  Doubt doubt = {false, false};
  const double fraction = largest_fraction(m, fixed, twist, b, in, solved, plane, capped, doubt);
  if (!doubt.any && (fraction > 0.0 || !doubt.little)) return fraction;
  return settle_fraction(m, fixed, twist, size_of(m, twist) + size_of(m, fixed), fraction, w, in, b, capped);
}

// Where the rank is short: what is lost of the twist is served by no fraction but the one that fixed joints serve; the rows
// that are left are searched. none: a length that counts as 0.
template <int M>
inline STILLREACH_NOINLINE double search_reduced(Rows<M> m, double* fixed, double* twist, double none, Workspace& w, Box& b, Inner& in,
                                                 double* plane, bool& capped) {
  const Spectrum s = in.spectrum;
  double own_fixed[kStride], own_twist[kStride], own_plane[kStride], rest[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  const Rows<0> rank{reduce_rows(m, s, w.columns, b, rest)};
  for (int r = 0; r < kStride; ++r) {
    own_fixed[r] = r < rank() ? dot(m, s.left[r], fixed) : 0.0;
    own_twist[r] = r < rank() ? dot(m, s.left[r], twist) : 0.0;
    own_plane[r] = plane && r < rank() ? dot(m, s.left[r], plane) : 0.0;
  }
  make_orthogonal(m, s.left, rank(), fixed), make_orthogonal(m, s.left, rank(), twist);
  const double lost = size_of(m, twist);
  const bool all = lost <= none;
  const double only = all ? 0.0 : clamp(-dot(m, fixed, twist) / (lost * lost), 0.0, 1.0);
  for (int r = 0; r < m(); ++r) rest[r] = madd(only, twist[r], fixed[r]);
  double fraction = size_of(m, rest) <= none ? only : -1.0;
  if (fraction >= 0.0 && all)
    fraction = search_fraction(rank, own_fixed, own_twist, false, w, b, in, plane ? own_plane : nullptr, capped);
  else if (fraction > 0.0 && solve_fraction(rank, own_fixed, own_twist, only, false, b, in) > none)
    fraction = -1.0;
  else
    capped = b.capped;
  if (!(fraction > 0.0)) solve_fraction(rank, own_fixed, own_twist, 0.0, false, b, in), capped = b.capped;
  for (int r = 0; plane && r < m(); ++r) {
    plane[r] = 0.0;
    for (int j = 0; j < rank(); ++j) plane[r] = madd(own_plane[j], s.left[j][r], plane[r]);
  }
  return fraction;
}

template <int M>
inline void keep_direction(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  System s;
  if (!prepare(m, p, w, out, s)) return;
  double rhs[kStride], twist[kRows], fixed[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  Box b = make_box(m, law, p, s, out.rates, w, rhs);
  measure_columns(m, s, w);
  b.safe = kSafe;
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
    if (out.status & SINGULAR) {
      out.scale = search_reduced(m, fixed, twist, reached(b, scale), w, b, in, out.plane, capped);
    } else {
      out.scale = search_fraction(m, fixed, twist, !warm, w, b, in, out.plane, capped);
      if (out.scale < 0.0) solve_fraction(m, fixed, twist, 0.0, false, b, in), capped = b.capped;
    }
    out.scale = larger(out.scale, 0.0);
    if (out.scale < 1.0) out.status |= SCALED;
    if (capped) out.status |= ITERATION_LIMIT;
  }
  out.iterations = b.iterations;
  write_rates(p, b, w, out.rates);
  report(m, p, out);
}

STILLREACH_END
