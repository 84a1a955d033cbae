// Reference rates for what the task leaves free: a posture, the middle of the position limits, away from singularities.
#pragma once

#include "stillreach/control/tolerance.hpp"

STILLREACH_BEGIN

// A fixed pattern in [-1, 1] without a symmetry of its own: fractional parts of multiples of the golden ratio.
STILLREACH_INLINE double pattern(int i) {
  const double x = 0.6180339887498949 * (i + 1);
  return 2.0 * (x - static_cast<double>(static_cast<long long>(x))) - 1.0;
}

constexpr double kHalfTurn = 3.141592653589793;
constexpr double kSaddlePush = 1e-2;  // of the largest null rate: leaves exact saddles, where the gradient is 0

// The way of joint i to a posture: the short one where it may turn without end.
STILLREACH_INLINE double way_to(const Settings& s, const Fault& fault, int i, double straight) {
  const Range range = range_of(s, fault, i);
  const bool endless = s.rotary && s.rotary[i] && range.lower == -infinity() && range.upper == infinity();
  return endless && magnitude(straight) > kHalfTurn ? STILLREACH_LIBRARY(remainder)(straight, 2.0 * kHalfTurn)
                                                    : straight;
}

// What the null motion asks of joint i; gradient: of what it climbs.
STILLREACH_INLINE double null_rate(const Settings& s, const Fault& fault, int i, const double* q,
                                   const double* gradient) {
  switch (s.null_kind) {
    case NullMotionKind::NONE: return 0.0;
    case NullMotionKind::RATES:
    case NullMotionKind::GRADIENT: return s.null_gain * s.null_vector[i];
    case NullMotionKind::POSTURE: return s.null_gain * way_to(s, fault, i, s.null_vector[i] - q[i]);
    case NullMotionKind::CENTRING: {
      const Range range = range_of(s, fault, i);
      return is_finite(range.lower) && is_finite(range.upper) ? s.null_gain * (0.5 * (range.lower + range.upper) - q[i])
                                                              : 0.0;
    }
    case NullMotionKind::MANIPULABILITY:
    case NullMotionKind::TOLERANCE:
    case NullMotionKind::GUARANTEED_SPEED: return s.null_gain * gradient[i];
  }
  return 0.0;
}

// The rates that the null motion asks for: at most null_largest each, by a common factor.
template <int M>
inline void null_motion(Rows<M> m, const Settings& s, const Faults& faults, const ThisTick& now, const double* q,
                        Workspace& w, double* rates) {
  const int n = s.arm.n;
  const bool climbs = climbing(s.null_kind);
  for (int i = 0; i < n; ++i) rates[i] = 0.0;
  if (s.null_kind == NullMotionKind::MANIPULABILITY) manipulability_gradient(m, s, now, q, w, rates);
  if (s.null_kind == NullMotionKind::TOLERANCE) relative_gradient(m, s, now, q, w, rates);
  if (s.null_kind == NullMotionKind::GUARANTEED_SPEED) speed_gradient(m, s, faults, now, q, w, rates);
  for (int i = 0; i < n; ++i) {
    const double v = null_rate(s, faults.of[i], i, q, rates);
    rates[i] = is_finite(v) ? v : 0.0;
  }
  if (climbs && s.null_largest < infinity())
    for (int i = 0; i < n; ++i)
      if (now.bounds.lower[i] < now.bounds.upper[i]) rates[i] += kSaddlePush * s.null_largest * pattern(i);
  double largest = 0.0;
  for (int i = 0; i < n; ++i)
    if (now.bounds.lower[i] < now.bounds.upper[i]) largest = larger(largest, magnitude(rates[i]));
  if (largest > s.null_largest)
    for (int i = 0; i < n; ++i) rates[i] *= s.null_largest / largest;
}

STILLREACH_END
