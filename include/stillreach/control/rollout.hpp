// A chunk of simulated ticks: the controller in closed loop with an arm that does what it is told.
#pragma once

#include "stillreach/control/controller.hpp"

namespace stillreach {

// Where a chunk writes, one row a tick. Null: not wanted.
struct Record {
  double *q, *rates, *pose, *command, *residual, *task_error, *damping, *scale, *lower, *upper;
  std::int32_t* status;
  std::int8_t *health, *active;
};

}  // namespace stillreach

STILLREACH_BEGIN

inline void record_tick(const ControllerState& c, const double* q, const Answer& a, long row, const Record& to) {
  const int n = c.arm.n;
  for (int i = 0; i < n; ++i) {
    to.q[row * n + i] = q[i];
    to.rates[row * n + i] = a.rates[i];
    to.lower[row * n + i] = c.lower[i];
    to.upper[row * n + i] = c.upper[i];
    to.health[row * n + i] = static_cast<std::int8_t>(c.faults[i].health);
    to.active[row * n + i] = active_reason(a.active[i], c.lower_reason[i], c.upper_reason[i]);
  }
  write_pose(c.pose, to.pose + row * 16);
  for (int r = 0; r < 6; ++r) {
    double e = c.command[r];
    for (int i = 0; i < n; ++i) e = madd(-c.jacobian[6 * i + r], a.rates[i], e);
    to.command[row * 6 + r] = c.command[r];
    to.residual[row * 6 + r] = e;
  }
  to.task_error[row] = a.task_error;
  to.damping[row] = a.damping;
  to.scale[row] = a.scale;
  to.status[row] = a.status;
}

// Rates of the later stages of fourth-order Runge-Kutta, added up into the mean rate over the tick. stage: 3 n numbers.
inline void runge_kutta(ControllerState& c, const double* q, const double* twists, const double* targets, Workspace& w,
                        Answer& a, double* stage, double* mean) {
  const int n = c.arm.n;
  double *at = stage, *rates = stage + n;
  double* answer = a.rates;
  for (int i = 0; i < n; ++i) {
    rates[i] = a.rates[i];
    mean[i] = a.rates[i] / 6.0;
  }
  a.rates = rates;
  for (int s = 1; s < 4; ++s) {
    const int half = s < 3 ? 1 : 2;
    for (int i = 0; i < n; ++i) at[i] = madd(s < 3 ? 0.5 * c.period : c.period, rates[i], q[i]);
    evaluate(c, at, twists + 6 * half, targets ? targets + 12 * half : nullptr, w, a);
    for (int i = 0; i < n; ++i) mean[i] = madd(s < 3 ? 1.0 / 3.0 : 1.0 / 6.0, rates[i], mean[i]);
  }
  a.rates = answer;
}

// steps ticks from q (n, moved along). stages 1: Euler, one command and one target a tick; 2: fourth-order Runge-Kutta
// with rates from the law at each of its stages, commands and targets at every half tick (2 steps + 1 of them).
// targets: 12 numbers each, or null. advance: false records and remembers, and leaves q where it is. scratch: 4 n
// numbers, scratch_active: n.
inline void rollout(ControllerState& c, double* q, const double* twists, const double* targets, long steps, int stages,
                    bool advance, Workspace& w, Answer& a, double* scratch, std::int8_t* scratch_active,
                    const Record& to) {
  const int n = c.arm.n;
  double* mean = scratch;
  for (long t = 0; t < steps; ++t) {
    const double* twist = twists + 6 * stages * t;
    const double* target = targets ? targets + 12 * stages * t : nullptr;
    evaluate(c, q, twist, target, w, a);
    record_tick(c, q, a, t, to);
    for (int i = 0; i < n; ++i) mean[i] = a.rates[i];
    if (stages == 2 && advance) {
      std::int8_t* active = a.active;
      a.active = scratch_active;
      runge_kutta(c, q, twist, target, w, a, scratch + n, mean);
      a.active = active;
    }
    commit(c, a.rates, a.active);
    if (!advance) continue;
    for (int i = 0; i < n; ++i) q[i] = madd(c.period, mean[i], q[i]);
  }
}

STILLREACH_END
