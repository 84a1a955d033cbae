// A chunk of simulated ticks: the controller in closed loop with an arm that does what it is told, or what its faults,
// drives and encoders make of it.
#pragma once

#include "stillreach/control/controller.hpp"

namespace stillreach {

// Where a chunk writes, one row a tick. Null: not wanted.
struct Record {
  double *q, *measured, *rates, *pose, *command, *residual, *task_error, *damping, *scale, *lower, *upper;
  std::int32_t* status;
  std::int8_t *health, *known, *active;
};

// Calls visit(array, name, count of a row) for each array of a record, in the order of page/src/core.js.
template <class Visit>
inline void each_array(Record& r, int n, Visit&& visit) {
  visit(r.q, "q", n);
  visit(r.measured, "measured", n);
  visit(r.rates, "rates", n);
  visit(r.pose, "pose", 16);
  visit(r.command, "command", 6);
  visit(r.residual, "residual", 6);
  visit(r.task_error, "task_error", 1);
  visit(r.damping, "damping", 1);
  visit(r.scale, "scale", 1);
  visit(r.lower, "lower", n);
  visit(r.upper, "upper", n);
  visit(r.status, "status", 1);
  visit(r.health, "health", n);
  visit(r.known, "known", n);
  visit(r.active, "active", n);
}

// An arm that does not do what it is told: faults that the controller need not know, drives that follow late, encoders
// that are off.
struct Plant {
  const Fault* faults;  // n, the true ones
  double follow;        // part of the way to the rate it is told that a drive goes in a tick; 1: all of it
  double* actual;       // n: rates
  long dead;            // ticks until a rate arrives at the drive
  double* told;         // dead rows of n: rates on their way
  long next;            // the row that arrives next
  double resolution;    // of the encoders, or 0
  const double* noise;  // rows of n: what the encoders are off at each tick, or null
  double* seen;         // n: what they say
};

}  // namespace stillreach

STILLREACH_BEGIN

// The rate of a joint with this fault that is told another, at q. Within a range it stops at its ends.
STILLREACH_INLINE double true_rate(const Fault& fault, double lower, double upper, double q, double period,
                                   double rate) {
  if (fault.health == Health::HEALTHY) return rate;
  const Left left = left_by(fault, lower, upper);
  rate = clamp(rate, left.lower, left.upper);
  if (!has_range(left)) return rate;
  return clamp(rate, smaller(left.range_lower - q, 0.0) / period, larger(left.range_upper - q, 0.0) / period);
}

// What the encoders say of q at tick t of a chunk.
inline const double* measure(const Plant& plant, int n, const double* q, long t) {
  for (int i = 0; i < n; ++i) {
    double at = q[i];
    if (plant.noise) at += plant.noise[t * n + i];
    if (plant.resolution > 0.0) at = plant.resolution * nearest_integer(at / plant.resolution);
    plant.seen[i] = at;
  }
  return plant.seen;
}

// From the rates that the drives are told to those of the joints, in place.
inline void move(const Settings& s, Plant& plant, const double* q, double* rates) {
  const int n = s.arm.n;
  for (int i = 0; i < n; ++i) {
    double rate = rates[i];
    if (plant.dead > 0) {
      double& queued = plant.told[plant.next * n + i];
      rate = queued;
      queued = rates[i];
    }
    rate = plant.follow < 1.0 ? madd(plant.follow, rate - plant.actual[i], plant.actual[i]) : rate;
    rates[i] = plant.actual[i] = true_rate(plant.faults[i], s.rate_lower[i], s.rate_upper[i], q[i], s.period, rate);
  }
  if (plant.dead > 0) plant.next = (plant.next + 1) % plant.dead;
}

inline void record_tick(const ControllerState& c, const double* q, const double* seen, const Fault* truth,
                        const Answer& a, long row, const Record& to) {
  const int n = c.settings.arm.n;
  const ThisTick& now = c.now;
  const auto copy = [](const double* from, int count, long tick, double* where) {
    if (where) STILLREACH_LIBRARY(memcpy)(where + tick * count, from, sizeof(double) * to_size(count));
  };
  copy(q, n, row, to.q);
  copy(seen, n, row, to.measured);
  copy(a.rates, n, row, to.rates);
  copy(now.bounds.lower, n, row, to.lower);
  copy(now.bounds.upper, n, row, to.upper);
  copy(now.command, 6, row, to.command);
  copy(&a.task_error, 1, row, to.task_error);
  copy(&a.damping, 1, row, to.damping);
  copy(&a.scale, 1, row, to.scale);
  if (to.status) to.status[row] = a.status;
  for (int i = 0; to.health && i < n; ++i) to.health[row * n + i] = static_cast<std::int8_t>(truth[i].health);
  for (int i = 0; to.known && i < n; ++i) to.known[row * n + i] = static_cast<std::int8_t>(c.faults.of[i].health);
  for (int i = 0; to.active && i < n; ++i)
    to.active[row * n + i] = active_reason(a.active[i], now.bounds.lower_reason[i], now.bounds.upper_reason[i]);
  for (int r = 0; to.residual && r < 6; ++r) {
    double e = now.command[r];
    for (int i = 0; i < n; ++i) e = madd(-now.jacobian[6 * i + r], a.rates[i], e);
    to.residual[row * 6 + r] = e;
  }
  if (!to.pose) return;
  double pose[12];
  bool exact = true;
  for (int i = 0; i < n; ++i) exact &= seen[i] == q[i];
  const bool elsewhere = !exact && doubt_in(q, n) == 0.0;  // the tool is where the joints are, not where they are said
  if (elsewhere) arm_kinematics(c.settings.arm, q, now.scratch, pose, static_cast<double*>(nullptr));
  write_pose(elsewhere ? pose : now.pose, to.pose + row * 16);
}

// Rates of the later stages of fourth-order Runge-Kutta, added up into the mean rate over the tick. stage: 3 n numbers.
inline void runge_kutta(ControllerState& c, const double* q, const double* twists, const double* targets, Workspace& w,
                        Answer& a, double* stage, double* mean) {
  const int n = c.settings.arm.n;
  double *at = stage, *rates = stage + n;
  double* answer = a.rates;
  for (int i = 0; i < n; ++i) {
    rates[i] = a.rates[i];
    mean[i] = a.rates[i] / 6.0;
  }
  a.rates = rates;
  for (int s = 1; s < 4; ++s) {
    const int half = s < 3 ? 1 : 2;
    for (int i = 0; i < n; ++i) at[i] = madd(s < 3 ? 0.5 * c.settings.period : c.settings.period, rates[i], q[i]);
    evaluate(c, at, twists + 6 * half, targets ? targets + 12 * half : nullptr, w, a);
    for (int i = 0; i < n; ++i) mean[i] = madd(s < 3 ? 1.0 / 3.0 : 1.0 / 6.0, rates[i], mean[i]);
  }
  a.rates = answer;
}

// steps ticks from q (n, moved along). stages 1: Euler, one command and one target a tick; 2: fourth-order Runge-Kutta
// with rates from the law at each of its stages, commands and targets at every half tick (2 steps + 1 of them).
// targets: 12 numbers each, or null. advance: false records and remembers, and leaves q where it is. scratch: 4 n
// numbers, scratch_active: n. plant: null where the arm does what it is told.
inline void rollout(ControllerState& c, double* q, const double* twists, const double* targets, long steps, int stages,
                    bool advance, Plant* plant, Workspace& w, Answer& a, double* scratch, std::int8_t* scratch_active,
                    const Record& to) {
  const int n = c.settings.arm.n;
  double* mean = scratch;
  for (long t = 0; t < steps; ++t) {
    const double* twist = twists + 6 * stages * t;
    const double* target = targets ? targets + 12 * stages * t : nullptr;
    const double* seen = plant ? measure(*plant, n, q, t) : q;
    evaluate(c, seen, twist, target, w, a);
    record_tick(c, q, seen, plant ? plant->faults : c.faults.of, a, t, to);
    for (int i = 0; i < n; ++i) mean[i] = a.rates[i];
    if (stages == 2 && advance) {
      std::int8_t* active = a.active;
      a.active = scratch_active;
      runge_kutta(c, seen, twist, target, w, a, scratch + n, mean);
      a.active = active;
    }
    commit(c.settings, c.last, a.rates, a.active);
    if (!advance) continue;
    if (plant) move(c.settings, *plant, q, mean);
    for (int i = 0; i < n; ++i) q[i] = madd(c.settings.period, mean[i], q[i]);
  }
}

STILLREACH_END
