// Faults and limits of one tick as one pair of bounds per joint. Where they contradict each other the order of
// precedence is fault, rate limit, position limit, acceleration limit.
#pragma once

#include "stillreach/control/controller_state.hpp"
#include "stillreach/simd/scalar.hpp"

STILLREACH_BEGIN

// Largest rate towards a position limit `room` away: not past it in one period, and with an acceleration limit not past
// it when braking from there, tick by tick. From v = (k + f) a period, k whole and 0 <= f < 1, that takes
// a period^2 (k (k + 1) / 2 + (k + 1) f); this is its inverse (for period -> 0 the curve sqrt(2 a room)). With uneven
// periods later ticks may brake in smaller steps, down to continuously: v period + v^2 / (2 a) is enough for any of them.
STILLREACH_INLINE double approach_rate(double room, double period, double acceleration, bool uneven) {
  if (!(room > 0.0)) return 0.0;
  const double stop = room / period, step = acceleration * period;
  if (!(stop >= 2.2250738585072014e-308)) return 0.0;  // below it numbers lose their digits
  if (!(step < infinity()) || !(stop < infinity())) return stop;
  if (!(step > 0.0)) return 0.0;
  const double x = stop / step;
  if (!(x < 1e15)) return square_root(2.0 * acceleration) * square_root(room);
  if (uneven) return 2.0 * stop / (1.0 + square_root(madd(2.0, x, 1.0)));
  if (!(x > 1.0)) return stop;
  const double k = static_cast<double>(static_cast<long long>(0.5 * (square_root(madd(8.0, x, 1.0)) - 1.0)));
  return step * (0.5 * k + x / (k + 1.0));
}

// A limit that was changed while the loop runs: where the joint is too fast for it, it brakes as hard as its acceleration
// limit allows. False where the limit is kept already.
STILLREACH_INLINE bool close_in(double slowest, double fastest, double& lower, double& upper) {
  const bool closing = upper < slowest || lower > fastest;
  if (upper < slowest) upper = slowest;
  if (lower > fastest) lower = fastest;
  return closing;
}

// Bounds of joint i at position q (a NaN: its position limits cannot be kept). False where a limit had to be given up: the
// position limit for rate limits that leave out 0 (a batch's may), or the acceleration limit.
STILLREACH_INLINE bool joint_bounds(ControllerState& c, int i, double q) {
  double& lower = c.lower[i];
  double& upper = c.upper[i];
  c.lower_reason[i] = c.upper_reason[i] = FAULT;
  if (c.health[i] == LOCKED || c.health[i] == RUNAWAY) {
    lower = upper = c.health[i] == LOCKED ? 0.0 : c.fault_value[i];
    return true;
  }
  lower = c.rate_lower[i], upper = c.rate_upper[i];
  if (c.health[i] == DERATED) {
    lower *= c.fault_value[i], upper *= c.fault_value[i];
    if (c.fault_value[i] == 0.0) lower = upper = 0.0;  // 0 * inf
  } else {
    c.lower_reason[i] = c.upper_reason[i] = RATE;
  }
  const double a = c.acceleration[i];
  const double slowest = c.last[i] - a * c.period, fastest = c.last[i] + a * c.period;
  const int closing = c.closing ? c.closing[i] : 0;
  if ((closing & CLOSING_RATE) && !close_in(slowest, fastest, lower, upper)) c.closing[i] &= ~CLOSING_RATE;
  bool kept = true;
  if (is_finite(q)) {
    double up = approach_rate(c.position_upper[i] - q, c.period, a, c.uneven);
    double down = -approach_rate(q - c.position_lower[i], c.period, a, c.uneven);
    if ((closing & CLOSING_POSITION) && !close_in(slowest, fastest, down, up)) c.closing[i] &= ~CLOSING_POSITION;
    if (up < lower) {
      upper = lower, c.upper_reason[i] = static_cast<std::int8_t>(-c.lower_reason[i]), kept = false;
    } else if (down > upper) {
      lower = upper, c.lower_reason[i] = c.upper_reason[i], kept = false;
    } else {
      if (up < upper) upper = up, c.upper_reason[i] = POSITION;
      if (down > lower) lower = down, c.lower_reason[i] = POSITION;
    }
  }
  if (!(a < infinity())) return kept;
  // A joint that brakes along the curve has one rate left up to rounding, to either side: that is no contradiction, and no room.
  const double slack = 1e-9 * a * c.period;
  if (slowest > upper - slack) {
    lower = upper, c.lower_reason[i] = c.upper_reason[i], kept &= !(slowest > upper + slack);
  } else if (fastest < lower + slack) {
    upper = lower, kept &= !(fastest < lower - slack);
    c.upper_reason[i] = static_cast<std::int8_t>(-c.lower_reason[i]);  // negative: at its lower bound
  } else {
    if (slowest > lower) lower = slowest, c.lower_reason[i] = ACCELERATION;
    if (fastest < upper) upper = fastest, c.upper_reason[i] = ACCELERATION;
  }
  return kept;
}

// joint_bounds(), and what it adds to the tick's status: LIMIT_GIVEN_UP, or SATURATED where limits, and not a fault, leave the
// joint one rate.
STILLREACH_INLINE std::int32_t limit_joint(ControllerState& c, int i, double q) {
  const bool kept = joint_bounds(c, i, q);
  const bool works = c.health[i] == HEALTHY || (c.health[i] == DERATED && c.fault_value[i] > 0.0);
  return (kept ? OK : LIMIT_GIVEN_UP) | (works && !(c.lower[i] < c.upper[i]) ? SATURATED : OK);
}

// The bounds of all joints, and what they add to the tick's status.
inline std::int32_t bounds_of(ControllerState& c, const double* q) {
  std::int32_t status = OK;
  for (int i = 0; i < c.arm.n; ++i) status |= limit_joint(c, i, q[i]);
  return status;
}

// A law's status with what the bounds add: a joint that a limit leaves one rate still works.
STILLREACH_INLINE std::int32_t with_bounds_status(std::int32_t law, std::int32_t bounds) {
  return (bounds & SATURATED ? law & ~NO_WORKING_JOINT : law) | bounds;
}

STILLREACH_END
