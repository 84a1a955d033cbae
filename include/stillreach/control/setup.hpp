// A controller as numbers in a row, for a program that is handed one and goes on with it: everything that it was told,
// and what it remembers.
#pragma once

#include "stillreach/control/controller_state.hpp"

namespace stillreach {

// What the sizes of a setup depend on.
struct SetupHead {
  int n, moved, coupled, m;                    // joints; of the chain; whether some follow others; task rows
  int has_rows, has_units, has_columns, full;  // which parts of the metric there are; `full`: a matrix over the joints
};
constexpr int kSetupHead = 8;

STILLREACH_INLINE SetupHead head_of(const Settings& s) {
  return {s.arm.n,
          s.arm.coupling ? s.arm.coupling->moved : s.arm.n,
          s.arm.coupling != nullptr,
          s.m,
          s.metric.rows != nullptr,
          s.metric.units != nullptr,
          s.metric.columns != nullptr,
          s.metric.joints != nullptr};
}

template <class Value, class Visit>
STILLREACH_INLINE void visit_all(const Value* first, int count, Visit& visit) {
  for (int k = 0; k < count; ++k) visit(const_cast<Value&>(first[k]));
}

// Visits every setting, each a number, in the order of a setup. What they are stored in belongs to the owner
// of the settings, and is theirs to change. The end, from the null motion on, has a length that depends on n alone: the
// page combines the null motion of one setup with the rest of another (settings() in panels.js).
template <class Visit>
STILLREACH_INLINE void each_setting(Settings& s, Visit visit) {
  const SetupHead head = head_of(s);
  const auto all = [&visit](const auto* first, int count) { visit_all(first, count, visit); };
  for (int a = 0; a < head.moved; ++a) {
    const Link& link = s.arm.links[a];
    all(link.turn, 2);
    all(link.shift, 3);
    all(link.tilt, 2);
    all(&link.kind, 1);
    all(&link.plain, 1);
  }
  all(s.arm.base, 16);
  all(s.arm.end, 2);
  if (head.coupled) {
    all(s.arm.coupling->leader, head.moved);
    all(s.arm.coupling->factor, head.moved);
    all(s.arm.coupling->offset, head.moved);
  }
  visit(s.law.kind);
  visit(s.law.damping);
  visit(s.law.norm);
  visit(s.law.kappa);
  visit(s.law.rank_tolerance);
  visit(s.law.parts);
  all(s.law.part, 6);
  all(s.law.price, kParts);
  visit(s.law.capped);
  visit(s.law.ceiling);
  visit(s.law.beyond);
  if (head.has_rows) all(s.metric.rows, head.m * head.m);
  if (head.has_units) all(s.metric.units, head.n);
  if (head.has_columns) all(s.metric.columns, head.n);
  if (head.full) all(s.metric.joints, head.n * head.n);
  visit(s.metric.weightless);
  all(s.rows, 6);
  visit(s.tool_axes);
  visit(s.every_row);
  visit(s.constant_bounds);
  visit(s.period);
  visit(s.speed);
  visit(s.return_rate);
  visit(s.transition_rate);
  visit(s.track_gain);
  visit(s.track_linear);
  visit(s.track_angular);
  visit(s.track_automatic);
  visit(s.null_kind);
  visit(s.null_gain);
  visit(s.null_largest);
  visit(s.null_failures);
  all(s.null_vector, head.n);
  all(s.rotary, head.n);
  all(s.rate_lower, head.n);
  all(s.rate_upper, head.n);
  all(s.position_lower, head.n);
  all(s.position_upper, head.n);
  all(s.acceleration, head.n);
}

// Visits what is broken and what the last tick left, arrays each with its length: a controller of the same settings
// that is given these goes on like this one, after bounds_stand = 0 and bound_correction().
template <class Visit>
STILLREACH_INLINE void each_memory(ControllerState& c, Visit visit) {
  const int n = c.settings.arm.n;
  LastTick& last = c.last;
  for (int i = 0; i < n; ++i) {
    visit(&c.faults.of[i].health, 1);
    visit(c.faults.of[i].number, 2);
  }
  visit(last.rates, n);
  visit(last.anchor, n);
  visit(&last.transition, 1);
  visit(last.multiplier.u, 6);
  visit(last.multiplier.kappa, kParts);
  visit(&last.multiplier.raised, 1);
  visit(&last.multiplier.known, 1);
  visit(last.active, n);
  visit(last.closing, n);
}

}  // namespace stillreach
