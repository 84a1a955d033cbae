// The careful stage of KeepDirection, where the free columns are nearly dependent and Newton's planes are rounded: a primal
// search from a reachable fraction upwards. Of all motions that joints at their bounds can still make, the one nearest to the
// twist either is the twist, and then all joints move along it until the first meets a bound, or leaves a residual, and that
// is the normal of the plane that ends the search.
#pragma once

#include "careful.hpp"

STILLREACH_BEGIN

constexpr double kLeaves = 1e-9;      // part of a column across a plane that is not rounding
constexpr double kReached = 1e-13;    // relative residual that counts as none,
constexpr double kNearly = 1e-9;      // and one that may be none, where the search cannot tell
constexpr double kGolden = 0.381966;  // part of an interval that a search by golden sections tries next (Kiefer, 1953)
constexpr int kFractionSteps = 60;

// The residual that counts as none: rounding of the twist, and of the sum of what the joints contribute.
STILLREACH_INLINE double reached(const Box& b, double scale) {
  double largest = 0.0;
  for (int i = 0; i < b.k; ++i) largest = larger(largest, magnitude(b.z[i]) * b.length[i]);
  return kReached * scale + kRounding * largest;
}

// The box lies on one side of any plane: (fixed + fraction * twist) . normal <= its largest value over the box. Returns that value
// less what `fixed` has of it. touching: b.z lies on the plane, so that free variables, and those without a bound on the side that
// rounding points to, move along it.
template <int M>
inline double plane_support(Rows<M> m, const double* fixed, const Box& b, const double* normal, bool touching) {
  double support = -dot(m, normal, fixed);
  for (int i = 0; i < b.k; ++i) {
    const double slope = dot(m, normal, b.columns + i * kStride);
    double at = slope > 0.0 ? b.upper[i] : b.lower[i];
    if (touching && (b.state[i] == 0 || magnitude(at) == infinity())) at = b.z[i];
    if (slope != 0.0) support = madd(slope, at, support);
  }
  return support;
}

// An upper bound of the fraction; more than 1 where the plane says nothing, negative where it allows none.
template <int M>
inline double plane_fraction(Rows<M> m, const double* fixed, const double* twist, const Box& b, const double* normal, bool touching) {
  const double along = dot(m, normal, twist), support = plane_support(m, fixed, b, normal, touching);
  if (along > 0.0) return support / along;
  return support < 0.0 ? -1.0 : 2.0;
}

// The motion nearest to the twist that is left to variables at their bounds (b.state): c.z, with what it leaves in
// c.residual. Uses w.shapes and w.held.
template <int M>
inline void nearest_motion(Rows<M> m, const double* twist, const Box& b, Workspace& w, Inner& in, Box& c) {
  c = b;
  double *lower = w.shapes, *upper = w.shapes + b.k;
  c.lower = lower, c.upper = upper, c.z = w.shapes + 2 * b.k, c.state = w.held, c.weight = nullptr;
  for (int i = 0; i < b.k; ++i) {
    lower[i] = b.state[i] < 0 ? 0.0 : -infinity(), upper[i] = b.state[i] > 0 ? 0.0 : infinity();
    c.state[i] = b.state[i];
  }
  solve_box(m, twist, c, in, false);
  settle_box(m, twist, c, in);
}

// How far b.z can move along `direction`, `most` at most; moves it, with what meets its bound put there.
inline double move_along(const double* direction, double most, Box& b) {
  double part = most;
  for (int i = 0; i < b.k; ++i) {
    const double move = direction[i];
    if (move == 0.0) continue;
    part = smaller(part, larger(((move > 0.0 ? b.upper[i] : b.lower[i]) - b.z[i]) / move, 0.0));
  }
  for (int i = 0; i < b.k; ++i) {
    const double move = direction[i], bound = move > 0.0 ? b.upper[i] : b.lower[i];
    if (move == 0.0) continue;
    b.z[i] = clamp(madd(part, move, b.z[i]), b.lower[i], b.upper[i]);
    const bool met = (bound - b.z[i]) / move <= 1e-14 * part || b.z[i] == bound;
    b.state[i] = !met ? 0 : move > 0.0 ? 1 : -1;
    if (met) b.z[i] = bound;
  }
  return part;
}

// On the plane where the search ended, variables whose columns leave it have one place to be: b.lower = b.upper there.
template <int M>
inline void pin_variables(Rows<M> m, const double* normal, double* lower, double* upper, const Box& b) {
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] != 0 && b.state[i] * dot(m, normal, b.columns + i * kStride) > kLeaves * b.length[i]) lower[i] = upper[i] = b.z[i];
}

// b.z reaches fixed + fraction * twist. Returns the largest fraction. b.lower and b.upper are w.lower and w.upper.
template <int M>
inline double raise_fraction(Rows<M> m, const double* fixed, const double* twist, double fraction, Workspace& w, Inner& in, Box& b) {
  double aim[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  for (int r = 0; r < m(); ++r) aim[r] = twist[r];
  const double size = size_of(m, aim);
  const int most = 4 * b.k + 8;
  for (int step = 0; step < most && fraction < 1.0; ++step) {
    Box c;
    nearest_motion(m, aim, b, w, in, c);
    b.iterations = c.iterations;
    const double error = size_of(m, c.residual);
    if (error > reached(c, size)) {  // no motion passes this plane
      for (int r = 0; r < m(); ++r) c.residual[r] /= error;
      const double at = plane_fraction(m, fixed, twist, b, c.residual, true);
      pin_variables(m, c.residual, w.lower, w.upper, b);
      return at >= 0.0 && at <= 1.0 ? at : fraction;
    }
    fraction += move_along(c.z, 1.0 - fraction, b);
  }
  return fraction;
}

// How far b.z is from a fraction, with the residual in b; rhs receives what it aims at.
template <int M>
inline double distance_at(Rows<M> m, const double* fixed, const double* twist, double fraction, Box& b, double* rhs) {
  for (int r = 0; r < kStride; ++r) rhs[r] = r < m() ? madd(fraction, twist[r], fixed[r]) : 0.0;
  residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
  return size_of(m, b.residual);
}

// The bounded answer at a fraction, warm; careful: by the second stage in any case. Returns how far from it that is.
template <int M>
inline double solve_fraction(Rows<M> m, const double* fixed, const double* twist, double fraction, bool careful, Box& b, Inner& in) {
  double rhs[kStride];
  distance_at(m, fixed, twist, fraction, b, rhs);
  solve_box(m, rhs, b, in, false);
  if (careful || b.doubtful) settle_box(m, rhs, b, in);
  return distance_at(m, fixed, twist, fraction, b, rhs);
}

// The smallest fraction that b.z can reach, from 0 upwards: bounds may leave no rest, and some fractions all the same. Newton's
// method on the distance, as from above; near its end, where planes are rounded, steps that grow, and once one went past the
// place, parts of what is around the shortest distance: the distance is convex, and changes by the twist's length at most.
// Negative: none.
template <int M>
inline double smallest_fraction(Rows<M> m, const double* fixed, const double* twist, double scale, Inner& in, Box& b) {
  const double size = size_of(m, twist);
  double fraction = 0.0, push = 1e-12, low = 0.0, nearest = 0.0, shortest = infinity(), high = infinity();
  for (int step = 0; step < kFractionSteps && fraction <= 1.0; ++step) {
    const double error = solve_fraction(m, fixed, twist, fraction, true, b, in);
    if (error <= reached(b, scale)) return fraction;
    const bool shorter = error < shortest;
    const double farther = shorter ? nearest : fraction;
    if (shorter) nearest = fraction, shortest = error;
    if (farther < nearest) low = farther;
    if (farther > nearest) high = farther;
    if (high < infinity()) {
      const double above = high - nearest, below = nearest - low;
      if (shortest > size * larger(above, below) + reached(b, scale)) return -1.0;
      fraction = above > below ? nearest + kGolden * above : nearest - kGolden * below;
      continue;
    }
    double normal[kStride];
    for (int r = 0; r < kStride; ++r) normal[r] = b.residual[r] / error;
    const double along = dot(m, normal, twist);
    double next = along < 0.0 ? plane_support(m, fixed, b, normal, true) / along : fraction;
    if (!(next > fraction + push)) {
      if (error > kNearly * scale) return -1.0;
      next = fraction + push, push *= 4.0;
    }
    fraction = error <= kNearly * scale && fraction < 1.0 ? smaller(next, 1.0) : next;
  }
  return -1.0;
}

// Where rounding may have decided: from the fraction found, if b.z reaches it, else from the smallest one, as far up as it goes.
// Negative: no fraction is reachable.
template <int M>
inline STILLREACH_NOINLINE double settle_fraction(Rows<M> m, const double* fixed, const double* twist, double scale, double fraction,
                                                  Workspace& w, Inner& in, Box& b, bool& capped) {
  double rhs[kStride];
  if (!(fraction >= 0.0 && distance_at(m, fixed, twist, fraction, b, rhs) <= reached(b, scale))) {
    const double found = fraction;
    fraction = smallest_fraction(m, fixed, twist, scale, in, b);
    capped = b.capped;
    if (fraction < 0.0) {
      const bool nearly = found > 0.0 && solve_fraction(m, fixed, twist, found, true, b, in) <= kNearly * scale;
      capped = b.capped;
      return nearly ? found : -1.0;
    }
  }
  fraction = raise_fraction(m, fixed, twist, fraction, w, in, b);
  for (int i = 0; i < b.k; ++i) w.shapes[i] = b.z[i], w.held[i] = b.state[i];
  const double before = distance_at(m, fixed, twist, fraction, b, rhs);
  settle_box(m, rhs, b, in);
  capped = b.capped;
  if (distance_at(m, fixed, twist, fraction, b, rhs) > larger(before, reached(b, scale)))
    for (int i = 0; i < b.k; ++i) b.z[i] = w.shapes[i], b.state[i] = w.held[i];
  return fraction;
}

STILLREACH_END
