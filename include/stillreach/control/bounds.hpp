// Faults and limits of one tick as one pair of bounds per joint. Where they contradict each other the order of
// precedence is fault, rate limit, position limit, acceleration limit.
#pragma once

#include "stillreach/control/controller_state.hpp"
#include "stillreach/simd/scalar.hpp"

STILLREACH_BEGIN

// Largest rate towards a position limit `room` away: not past it in one period, and with an acceleration limit not past
// it when braking from there, tick by tick. From v = (k + f) a period, k whole and 0 <= f < 1, that takes
// a period^2 (k (k + 1) / 2 + (k + 1) f); this is its inverse (for period -> 0 the curve sqrt(2 a room)). With uneven
// periods later ticks may brake in smaller steps, down to continuously: v period + v^2 / (2 a) is enough for any of
// them.
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

// Whether a position limit `room` away is too far to matter to a rate of at most `rate` towards it: from there the
// joint could brake at leisure. Then approach_rate() is above the rate; this is cheaper.
STILLREACH_INLINE bool out_of_mind(double room, double rate, double period, double acceleration) {
  const double enough = 2.0 * acceleration * madd(-rate, period, 0.999 * room);
  return rate >= 0.0 && enough > 1e-290 && rate * rate <= enough;  // smaller numbers have lost digits
}

// A limit that was changed while the loop runs: where the joint is too fast for it, it brakes as hard as its
// acceleration limit allows. False where the limit is kept already.
STILLREACH_INLINE bool close_in(double slowest, double fastest, double& lower, double& upper) {
  const bool closing = upper < slowest || lower > fastest;
  if (upper < slowest) upper = slowest;
  if (lower > fastest) lower = fastest;
  return closing;
}

// What a fault leaves of a joint's interval of rates, and of its positions. A new kind of fault has its case here.
struct Left {
  double lower, upper;              // rates
  double range_lower, range_upper;  // positions
};

STILLREACH_INLINE Left left_by(const Fault& fault, double lower, double upper) {
  Left left{lower, upper, -infinity(), infinity()};
  const double first = fault.number[0];
  switch (fault.health) {
    case Health::HEALTHY: break;
    case Health::LOCKED:
    case Health::FREE_SWINGING: left.lower = left.upper = 0.0; break;
    case Health::DERATED:
      left.lower = first > 0.0 ? first * lower : 0.0;  // not 0 * inf
      left.upper = first > 0.0 ? first * upper : 0.0;
      break;
    case Health::RUNAWAY: left.lower = left.upper = first; break;
    case Health::CONFINED:
      left.range_lower = first;
      left.range_upper = fault.number[1];
      break;
    case Health::ONE_WAY: (first > 0.0 ? left.lower : left.upper) = 0.0; break;
  }
  return left;
}

// Whether there is a fault with these numbers.
STILLREACH_INLINE bool possible(const Fault& fault) {
  const double first = fault.number[0], second = fault.number[1];
  if (!(first == first && second == second)) return false;
  switch (fault.health) {
    case Health::HEALTHY:
    case Health::LOCKED:
    case Health::FREE_SWINGING: return true;
    case Health::DERATED: return first >= 0.0 && first <= 1.0;
    case Health::RUNAWAY: return is_finite(first);
    case Health::CONFINED: return first <= second;
    case Health::ONE_WAY: return magnitude(first) == 1.0;
  }
  return false;
}

// How texts write the kinds of faults: a word and its numbers.
struct FaultForm {
  const char* word;
  Health health;
  int numbers;
  const char* example;
};
constexpr FaultForm kFaultForms[] = {{"locked", Health::LOCKED, 0, "locked"},
                                     {"derated", Health::DERATED, 1, "'derated SHARE' (0 to 1)"},
                                     {"runaway", Health::RUNAWAY, 1, "'runaway RATE'"},
                                     {"confined", Health::CONFINED, 2, "'confined LOWER UPPER'"},
                                     {"one-way", Health::ONE_WAY, 1, "'one-way 1' or 'one-way -1'"},
                                     {"free-swinging", Health::FREE_SWINGING, 0, "free-swinging"}};

// Whether a fault's bounds change with the joint's position.
STILLREACH_INLINE bool has_range(const Left& left) {
  return left.range_lower > -infinity() || left.range_upper < infinity();
}

// Whether a joint works: its fault leaves it a choice, whatever its limits.
STILLREACH_INLINE bool works(const Fault& fault) {
  const Left left = left_by(fault, -1.0, 1.0);
  return left.lower < left.upper;
}

// The positions that a joint may take by its limits and its fault; `lower` is above `upper` where they exclude each
// other.
struct Range {
  double lower, upper;
};
STILLREACH_INLINE Range range_of(const Settings& s, const Fault& fault, int i) {
  const Left left = left_by(fault, 0.0, 0.0);
  return {larger(s.position_lower[i], left.range_lower), smaller(s.position_upper[i], left.range_upper)};
}

// The largest rate to either side that a fault leaves of rate limits.
STILLREACH_INLINE double largest_rate(const Fault& fault, double lower, double upper) {
  const Left left = left_by(fault, lower, upper);
  return larger(-left.lower, left.upper);
}

// Whether a fault moves its joint at a rate that nobody chooses.
STILLREACH_INLINE bool runs_away(const Fault& fault) { return !works(fault) && left_by(fault, -1.0, 1.0).lower != 0.0; }

// Narrows the bounds of joint i to `down` and `up`. False where there is no rate in both: then the bounds stand, and
// the joint takes the one that is nearer.
STILLREACH_INLINE bool narrow(const RateBounds& b, int i, double down, double up, Reason reason) {
  if (up < b.lower[i]) {
    b.upper[i] = b.lower[i];
    b.upper_reason[i] = static_cast<std::int8_t>(-b.lower_reason[i]);  // negative: at its lower bound
    return false;
  }
  if (down > b.upper[i]) {
    b.lower[i] = b.upper[i];
    b.lower_reason[i] = b.upper_reason[i];
    return false;
  }
  if (up < b.upper[i]) {
    b.upper[i] = up;
    b.upper_reason[i] = code(reason);
  }
  if (down > b.lower[i]) {
    b.lower[i] = down;
    b.lower_reason[i] = code(reason);
  }
  return true;
}

// Narrows the bounds of joint i to the acceleration window around its last rate. False where there is no rate in both:
// the bounds stand.
STILLREACH_INLINE bool narrow_to_window(const RateBounds& b, int i, double slowest, double fastest, double step) {
  // A joint that brakes along the curve has one rate left up to rounding, to either side: that counts as neither a
  // contradiction nor room.
  const double slack = 1e-9 * step;
  if (slowest > b.upper[i] - slack) {
    b.lower[i] = b.upper[i];
    b.lower_reason[i] = b.upper_reason[i];
    return !(slowest > b.upper[i] + slack);
  }
  if (fastest < b.lower[i] + slack) {
    b.upper[i] = b.lower[i];
    b.upper_reason[i] = static_cast<std::int8_t>(-b.lower_reason[i]);
    return !(fastest < b.lower[i] - slack);
  }
  return narrow(b, i, slowest, fastest, Reason::ACCELERATION);
}

// Bounds of joint i at position q (a NaN: its position limits cannot be kept), written to `b`. False where a limit had
// to be given up: the position limit for rate limits that leave out 0 (a batch's may), or the acceleration limit.
STILLREACH_INLINE bool joint_bounds(const Settings& s, const Fault& fault, LastTick& last, int i, double q,
                                    const RateBounds& b) {
  const Left left = left_by(fault, s.rate_lower[i], s.rate_upper[i]);
  double& lower = b.lower[i];
  double& upper = b.upper[i];
  lower = left.lower;
  upper = left.upper;
  b.lower_reason[i] = b.upper_reason[i] = code(Reason::FAULT);
  if (!works(fault)) return true;
  if (lower == s.rate_lower[i]) b.lower_reason[i] = code(Reason::RATE);
  if (upper == s.rate_upper[i]) b.upper_reason[i] = code(Reason::RATE);
  const double a = s.acceleration[i], step = a * s.period;
  const double slowest = last.rates[i] - step, fastest = last.rates[i] + step;
  const int closing = last.closing ? last.closing[i] : 0;
  if (closing & CLOSING_RATE) {
    if (!close_in(slowest, fastest, lower, upper)) last.closing[i] &= ~CLOSING_RATE;
    const Left always = left_by(fault, -infinity(), infinity());  // a fault goes before an acceleration limit
    lower = larger(lower, always.lower);
    upper = smaller(upper, always.upper);
  }
  bool kept = true;
  if (is_finite(q)) {
    if (has_range(left)) {
      const double down = -approach_rate(q - left.range_lower, s.period, a, s.uneven);
      kept = narrow(b, i, down, approach_rate(left.range_upper - q, s.period, a, s.uneven), Reason::FAULT);
    }
    const double ahead = s.position_upper[i] - q, behind = q - s.position_lower[i];
    if (closing || !out_of_mind(ahead, upper, s.period, a) || !out_of_mind(behind, -lower, s.period, a)) {
      double up = approach_rate(ahead, s.period, a, s.uneven), down = -approach_rate(behind, s.period, a, s.uneven);
      if ((closing & CLOSING_POSITION) && !close_in(slowest, fastest, down, up)) last.closing[i] &= ~CLOSING_POSITION;
      kept &= narrow(b, i, down, up, Reason::POSITION);
    }
  }
  if (a < infinity()) kept &= narrow_to_window(b, i, slowest, fastest, step);
  return kept;
}

// joint_bounds(), and what it adds to the tick's status: LIMIT_GIVEN_UP, or SATURATED where limits, and not a fault,
// leave the joint one rate.
STILLREACH_INLINE std::int32_t limit_joint(const Settings& s, const Fault& fault, LastTick& last, int i, double q,
                                           const RateBounds& b) {
  const bool kept = joint_bounds(s, fault, last, i, q, b);
  return (kept ? OK : LIMIT_GIVEN_UP) | (!(b.lower[i] < b.upper[i]) && works(fault) ? SATURATED : OK);
}

// The bounds of all joints, and what they add to the tick's status.
inline std::int32_t bounds_of(const Settings& s, const Faults& faults, LastTick& last, const double* q,
                              const RateBounds& b) {
  std::int32_t status = OK;
  for (int i = 0; i < s.arm.n; ++i) status |= limit_joint(s, faults.of[i], last, i, q[i], b);
  return status;
}

// A law's status with what the bounds add: a joint that a limit leaves one rate still works.
STILLREACH_INLINE std::int32_t with_bounds_status(std::int32_t law, std::int32_t bounds) {
  return (bounds & SATURATED ? law & ~NO_WORKING_JOINT : law) | bounds;
}

STILLREACH_END
