// One control tick: kinematics, task rows, bounds from faults and limits, reference rates, law.
#pragma once

#include "stillreach/control/bounds.hpp"
#include "stillreach/control/null_motion.hpp"
#include "stillreach/control/tracking.hpp"
#include "stillreach/kinematics/frames.hpp"
#include "stillreach/kinematics/kinematics.hpp"
#include "stillreach/laws/law.hpp"

STILLREACH_BEGIN

// A joint fails or is restored. For a while the reference is what was commanded last.
inline void set_fault(ControllerState& c, int joint, const Fault& fault) {
  c.faults[joint] = fault;
  c.bounds_stand = 0;
  bound_correction(c);
  if (c.closing) c.closing[joint] = 0;  // a fault goes before an acceleration limit
  if (!(c.transition_rate > 0.0)) return;
  c.transition = 1.0;
  STILLREACH_LIBRARY(memcpy)(c.anchor, c.last, sizeof(double) * to_size(c.arm.n));
}

// The reference rates: null motion, return from outside the positions allowed, and after a fault the last rates.
inline const double* reference_rates(ControllerState& c, const double* q, Workspace& w) {
  const int n = c.arm.n;
  bool any = c.null_kind != NullMotionKind::NONE || c.transition > 0.0;
  if (c.null_kind == NullMotionKind::NONE)
    for (int i = 0; i < n; ++i) c.reference[i] = 0.0;
  else if (c.m == 6)
    null_motion(Rows<6>{6}, c, q, w, c.reference);
  else
    null_motion(Rows<0>{c.m}, c, q, w, c.reference);
  if (c.return_rate > 0.0)
    for (int i = 0; i < n; ++i) {
      const Range range = range_of(c, i);
      const double out = q[i] > range.upper ? q[i] - range.upper : q[i] < range.lower ? q[i] - range.lower : 0.0;
      if (out == 0.0) continue;
      c.reference[i] = -clamp(out / c.period, -c.return_rate, c.return_rate);
      any = true;
    }
  if (any && c.speed != 1.0)
    for (int i = 0; i < n; ++i) c.reference[i] *= c.speed;
  if (c.transition > 0.0)
    for (int i = 0; i < n; ++i) c.reference[i] = madd(c.transition, c.anchor[i] - c.reference[i], c.reference[i]);
  return any ? c.reference : nullptr;
}

// The scale of the rates: by the limits that faults leave the working joints, not by the bounds of this tick.
inline double typical_rate(const ControllerState& c) {
  TypicalRate typical;
  for (int i = 0; i < c.arm.n; ++i) {
    if (!works(c.faults[i])) continue;
    const double limit = largest_rate(c.faults[i], c.rate_lower[i], c.rate_upper[i]);
    if (limit > 0.0) typical.add(c.metric, c.arm.n, i, limit);
  }
  return typical.value();
}

// Whether some fault's bounds change from tick to tick.
inline bool any_range(const ControllerState& c) {
  bool any = false;
  for (int i = 0; i < c.arm.n; ++i) any |= has_range(left_by(c.faults[i], 0.0, 0.0));
  return any;
}

// NaN from an encoder or a command: brake, within the acceleration limits; failed joints keep their rates.
inline void brake(ControllerState& c, const double* q, Answer& out) {
  out.damping = 0.0;
  out.scale = 0.0;
  out.task_error = 0.0;
  out.iterations = 0;
  out.status = INVALID_INPUT | (bounds_of(c, q) & LIMIT_GIVEN_UP);
  for (int i = 0; i < c.arm.n; ++i) {
    out.rates[i] = clamp(0.0, c.lower[i], c.upper[i]);
    out.active[i] = !(c.lower[i] < c.upper[i]) ? 2 : 0;
  }
  for (int r = 0; r < c.m; ++r) out.residual[r] = 0.0;
}

// The tick without its memory. twist: 6, base axes. target: 12 numbers (rotation by columns, translation) to close the
// loop on, or null.
inline void evaluate(ControllerState& c, const double* q, const double* twist, const double* target, Workspace& w,
                     Answer& out) {
  const int n = c.arm.n;
  double doubt = doubt_in(q, n) + doubt_in(twist, 6) + (target ? doubt_in(target, 12) : 0.0);
  STILLREACH_LIBRARY(memcpy)(out.active, c.active, to_size(n));
  out.multiplier = &c.multiplier;
  if (doubt == 0.0) {
    arm_kinematics(c.arm, q, c.scratch, c.pose, c.jacobian);
    for (int r = 0; r < 6; ++r) c.command[r] = twist[r];
    if (target) {
      add_correction(target, c.pose, c.track_gain, c.track_linear, c.track_angular, c.command);
      doubt = doubt_in(c.command, 6);  // numbers that overflow
    }
    if (c.speed != 1.0)
      for (int r = 0; r < 6; ++r) c.command[r] *= c.speed;
  }
  if (doubt == 0.0) {
    if (!c.bounds_stand) {
      c.bounds_status = bounds_of(c, q);
      if (c.law.parts > 0) c.typical = typical_rate(c);
    }
    c.bounds_stand = c.constant_bounds && !any_range(c);
    if (c.every_row) {
      for (int r = 0; r < 6; ++r) c.twist[r] = c.command[r];
    } else {
      for (int i = 0; i < n; ++i) select_rows(c, c.pose, c.jacobian + 6 * i, c.task_jacobian + c.m * i);
      select_rows(c, c.pose, c.command, c.twist);
    }
    const Problem p{c.m, n, c.task_jacobian, c.twist, c.lower, c.upper, reference_rates(c, q, w), c.metric, c.typical};
    solve_task(c.law, p, w, out);
    out.status = with_bounds_status(out.status, c.bounds_status);
    if (out.status & FAULT_NOT_COMPENSATED) {
      bool runaway = false;
      for (int i = 0; i < n; ++i) runaway |= runs_away(c.faults[i]);
      if (!runaway || can_stand_still(Rows<0>{c.m}, c.law, p, w, out)) out.status &= ~FAULT_NOT_COMPENSATED;
    }
  } else {
    brake(c, q, out);
  }
}

// Remembers what was commanded: the base of acceleration limits, warm starts and transitions.
inline void commit(ControllerState& c, const double* rates, const std::int8_t* active) {
  STILLREACH_LIBRARY(memcpy)(c.last, rates, sizeof(double) * to_size(c.arm.n));
  STILLREACH_LIBRARY(memcpy)(c.active, active, to_size(c.arm.n));
  c.transition = c.transition > 0.0 ? larger(c.transition - c.period * c.transition_rate, 0.0) : 0.0;
}

inline void tick(ControllerState& c, const double* q, const double* twist, const double* target, Workspace& w,
                 Answer& out) {
  evaluate(c, q, twist, target, w, out);
  commit(c, out.rates, out.active);
}

STILLREACH_END
