// Faults and limits of one tick as one pair of bounds per joint. Where they contradict each other the order of
// precedence is fault, rate limit, position limit, acceleration limit.
#pragma once

#include "controller_state.hpp"
#include "scalar.hpp"

STILLREACH_BEGIN

// Largest rate towards a position limit `room` away: not past it in one period, and with an acceleration limit not past
// it when braking from there, tick by tick. From v = (k + f) a period, k whole and 0 <= f < 1, that takes
// a period^2 (k (k + 1) / 2 + (k + 1) f); this is its inverse (for period -> 0 the curve sqrt(2 a room)).
STILLREACH_INLINE double approach_rate(double room, double period, double acceleration) {
  if (!(room > 0.0)) return 0.0;
  const double stop = room / period, step = acceleration * period;
  if (!(stop >= 2.2250738585072014e-308)) return 0.0;  // below it numbers lose their digits
  if (!(step < infinity()) || !(stop < infinity())) return stop;
  if (!(step > 0.0)) return 0.0;
  const double x = stop / step;
  if (!(x > 1.0)) return stop;
  if (!(x < 1e15)) return square_root(2.0 * acceleration) * square_root(room);
  const double k = static_cast<double>(static_cast<long long>(0.5 * (square_root(madd(8.0, x, 1.0)) - 1.0)));
  return step * (0.5 * k + x / (k + 1.0));
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
  bool kept = true;
  if (is_finite(q)) {
    const double up = approach_rate(c.position_upper[i] - q, c.period, a);
    const double down = -approach_rate(q - c.position_lower[i], c.period, a);
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
  const double slowest = c.last[i] - a * c.period, fastest = c.last[i] + a * c.period;
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

STILLREACH_END
