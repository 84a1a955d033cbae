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
  LastTick& last = c.last;
  c.faults.of[joint] = fault;
  last.bounds_stand = 0;
  bound_correction(c.settings, c.faults, c.now.scratch);
  if (last.closing) last.closing[joint] = 0;  // a fault goes before an acceleration limit
  if (!(c.settings.transition_rate > 0.0)) return;
  last.transition = 1.0;
  STILLREACH_LIBRARY(memcpy)(last.anchor, last.rates, sizeof(double) * to_size(c.settings.arm.n));
}

// The reference rates: null motion, return from outside the positions allowed, and after a fault the last rates.
inline const double* reference_rates(ControllerState& c, const double* q, Workspace& w) {
  const Settings& s = c.settings;
  const int n = s.arm.n;
  const double transition = c.last.transition;
  double* const reference = c.now.reference;
  bool any = s.null_kind != NullMotionKind::NONE || transition > 0.0;
  if (s.null_kind == NullMotionKind::NONE)
    for (int i = 0; i < n; ++i) reference[i] = 0.0;
  else if (s.m == 6)
    null_motion(Rows<6>{6}, s, c.faults, c.now, q, w, reference);
  else
    null_motion(Rows<0>{s.m}, s, c.faults, c.now, q, w, reference);
  if (s.return_rate > 0.0)
    for (int i = 0; i < n; ++i) {
      const Range range = range_of(s, c.faults.of[i], i);
      const double out = q[i] > range.upper ? q[i] - range.upper : q[i] < range.lower ? q[i] - range.lower : 0.0;
      if (out == 0.0) continue;
      reference[i] = -clamp(out / s.period, -s.return_rate, s.return_rate);
      any = true;
    }
  if (any && s.speed != 1.0)
    for (int i = 0; i < n; ++i) reference[i] *= s.speed;
  if (transition > 0.0)
    for (int i = 0; i < n; ++i) reference[i] = madd(transition, c.last.anchor[i] - reference[i], reference[i]);
  return any ? reference : nullptr;
}

// The scale of the rates: by the limits that faults leave the working joints, not by the bounds of this tick.
inline double typical_rate(const Settings& s, const Faults& faults) {
  TypicalRate typical;
  for (int i = 0; i < s.arm.n; ++i) {
    if (!works(faults.of[i])) continue;
    const double limit = largest_rate(faults.of[i], s.rate_lower[i], s.rate_upper[i]);
    if (limit > 0.0) typical.add(s.metric, s.arm.n, i, limit);
  }
  return typical.value();
}

// Whether the fault of one of n joints has bounds that change from tick to tick.
inline bool any_range(const Faults& faults, int n) {
  bool any = false;
  for (int i = 0; i < n; ++i) any |= has_range(left_by(faults.of[i], 0.0, 0.0));
  return any;
}

// NaN from an encoder or a command: brake, within the acceleration limits; failed joints keep their rates.
inline void brake(ControllerState& c, const double* q, Answer& out) {
  const Settings& s = c.settings;
  const RateBounds& b = c.now.bounds;
  out.damping = 0.0;
  out.scale = 0.0;
  out.task_error = 0.0;
  out.iterations = 0;
  out.status = INVALID_INPUT | (bounds_of(s, c.faults, c.last, q, b) & LIMIT_GIVEN_UP);
  for (int i = 0; i < s.arm.n; ++i) {
    out.rates[i] = clamp(0.0, b.lower[i], b.upper[i]);
    out.active[i] = !(b.lower[i] < b.upper[i]) ? 2 : 0;
  }
  for (int r = 0; r < s.m; ++r) out.residual[r] = 0.0;
}

// The tick without its memory. twist: 6, base axes. target: 12 numbers (rotation by columns, translation) to close the
// loop on, or null.
inline void evaluate(ControllerState& c, const double* q, const double* twist, const double* target, Workspace& w,
                     Answer& out) {
  const Settings& s = c.settings;
  LastTick& last = c.last;
  ThisTick& now = c.now;
  const int n = s.arm.n;
  double doubt = doubt_in(q, n) + doubt_in(twist, 6) + (target ? doubt_in(target, 12) : 0.0);
  STILLREACH_LIBRARY(memcpy)(out.active, last.active, to_size(n));
  out.multiplier = &last.multiplier;
  if (doubt == 0.0) {
    arm_kinematics(s.arm, q, now.scratch, now.pose, now.jacobian);
    for (int r = 0; r < 6; ++r) now.command[r] = twist[r];
    if (target) {
      add_correction(target, now.pose, s.track_gain, s.track_linear, s.track_angular, now.command);
      doubt = doubt_in(now.command, 6);  // numbers that overflow
    }
    if (s.speed != 1.0)
      for (int r = 0; r < 6; ++r) now.command[r] *= s.speed;
  }
  if (doubt == 0.0) {
    if (!last.bounds_stand) {
      last.bounds_status = bounds_of(s, c.faults, last, q, now.bounds);
      if (s.law.parts > 0) last.typical = typical_rate(s, c.faults);
    }
    last.bounds_stand = s.constant_bounds && !any_range(c.faults, n);
    if (s.every_row) {
      for (int r = 0; r < 6; ++r) now.twist[r] = now.command[r];
    } else {
      for (int i = 0; i < n; ++i) select_rows(s, now.pose, now.jacobian + 6 * i, now.selected + s.m * i);
      select_rows(s, now.pose, now.command, now.twist);
    }
    const Problem p{s.m,
                    n,
                    task_jacobian(s, now),
                    now.twist,
                    now.bounds.lower,
                    now.bounds.upper,
                    reference_rates(c, q, w),
                    s.metric,
                    last.typical};
    solve_task(s.law, p, w, out);
    out.status = with_bounds_status(out.status, last.bounds_status);
    if (out.status & FAULT_NOT_COMPENSATED) {
      bool runaway = false;
      for (int i = 0; i < n; ++i) runaway |= runs_away(c.faults.of[i]);
      if (!runaway || can_stand_still(Rows<0>{s.m}, s.law, p, w, out)) out.status &= ~FAULT_NOT_COMPENSATED;
    }
  } else {
    brake(c, q, out);
  }
}

// Remembers what was commanded: the base of acceleration limits, warm starts and transitions.
inline void commit(const Settings& s, LastTick& last, const double* rates, const std::int8_t* active) {
  STILLREACH_LIBRARY(memcpy)(last.rates, rates, sizeof(double) * to_size(s.arm.n));
  STILLREACH_LIBRARY(memcpy)(last.active, active, to_size(s.arm.n));
  last.transition = last.transition > 0.0 ? larger(last.transition - s.period * s.transition_rate, 0.0) : 0.0;
}

inline void tick(ControllerState& c, const double* q, const double* twist, const double* target, Workspace& w,
                 Answer& out) {
  evaluate(c, q, twist, target, w, out);
  commit(c.settings, c.last, out.rates, out.active);
}

STILLREACH_END
