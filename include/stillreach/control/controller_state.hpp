// The memory of a controller in four parts: what it was told once, what is broken, what the last tick left, and what
// this one works with. Plain data.
#pragma once

#include "stillreach/types.hpp"

namespace stillreach {

// Which limits of a joint were changed while the loop runs: they close in within its acceleration limit.
enum Closing : std::int8_t { CLOSING_RATE = 1, CLOSING_POSITION = 2 };

#define STILLREACH_NULL_MOTION_KIND(X)                                         \
  X(NONE, "No reference rates.")                                               \
  X(RATES, "The given rates.")                                                 \
  X(POSTURE, "Towards a posture.")                                             \
  X(CENTRING, "Towards the middle of the position limits.")                    \
  X(MANIPULABILITY, "Away from singularities.")                                \
  X(TOLERANCE, "Towards postures that can lose any joint, or several.")        \
  X(GUARANTEED_SPEED, "Towards postures that are fast without any one joint.") \
  X(GRADIENT, "Along a given gradient.")
enum class NullMotionKind : int { STILLREACH_NULL_MOTION_KIND(STILLREACH_MEMBER) };

// Whether a null motion climbs a function of the posture that has saddles, and no bound near singularities.
STILLREACH_INLINE bool climbing(NullMotionKind kind) {
  switch (kind) {
    case NullMotionKind::NONE:
    case NullMotionKind::RATES:
    case NullMotionKind::GRADIENT:
    case NullMotionKind::POSTURE:
    case NullMotionKind::CENTRING: return false;
    case NullMotionKind::MANIPULABILITY:
    case NullMotionKind::TOLERANCE:
    case NullMotionKind::GUARANTEED_SPEED: return true;
  }
  return false;
}

constexpr double kFullRate = 1.0;        // [rad/s, m/s] of a joint without a limit, where speeds are compared
constexpr int kMostFailures = 8;         // of one set, of TOLERANCE
constexpr double kMostChoices = 5000.0;  // sets, or facets, that a tick looks at

// How many sets of so many things there are of n.
STILLREACH_INLINE double choices(int n, int size) {
  double count = 1.0;
  for (int i = 0; i < size; ++i) count = count * (n - i) / (i + 1);
  return count;
}

// Told once: arm, law, task, limits, and what is done with what the task leaves free.
struct Settings {
  ArmView arm;  // with the task's tool
  LawSettings law;
  Metric metric;  // of the m task rows
  int m;
  int rows[6];               // which of [v; w]
  int tool_axes;             // rows are taken along the tool's axes instead of the base's
  int every_row;             // six rows along base axes: no selection needed
  int constant_bounds;       // no position or acceleration limits: bounds change with faults only
  double period;             // [s] for which the rates are held
  int uneven = 0;            // 1: later periods may be shorter than this one
  const double* rate_lower;  // n each
  const double* rate_upper;
  const double* position_lower;
  const double* position_upper;
  const double* acceleration;
  double speed = 1.0;  // fraction of the command and of the reference rates; the rate limits already contain it
  const std::int8_t* rotary = nullptr;  // n: 1 where a whole turn leads back to the same pose; or null: no joint
  double return_rate;       // [rad/s or m/s] at which joints outside their position limits are asked back; 0: not asked
  double transition_rate;   // [1/s] at which the reference returns from the last rates to the null motion after a fault
  double track_gain;        // [1/s]
  double track_linear;      // largest correction [m/s]
  double track_angular;     // and [rad/s]
  int track_automatic = 0;  // 1: these two follow the joints that work, see bound_correction()
  NullMotionKind null_kind;
  double null_gain;
  double null_largest;        // largest rate that a null motion asks for
  int null_failures = 1;      // of TOLERANCE: how many joints are lost at once
  const double* null_vector;  // n: rates, posture or gradient, by kind
};

// What is broken.
struct Faults {
  Fault* of;  // n
};

// What the last tick left for the next one.
struct LastTick {
  double* rates;                   // n: last commanded rates
  double* anchor;                  // n: those when a joint last failed or was restored
  std::int8_t* active;             // n: bounds active a tick ago, as in Answer::active
  std::int8_t* closing = nullptr;  // n, Closing: of limits that are not kept yet; or null: the limits do not change
  int bounds_stand;                // with constant_bounds: they are computed and no fault came since
  std::int32_t bounds_status;      // what the bounds add to the tick's status: see bounds_of()
  Multiplier multiplier;           // LeastError's a tick ago
  double typical;                  // typical_rate() of the working joints' rate limits
  double transition;               // 1 just after a fault, falls to 0
};

// An interval of rates for each joint, and why it ends there.
struct RateBounds {
  double* lower;  // n each
  double* upper;
  std::int8_t* lower_reason;  // Reason
  std::int8_t* upper_reason;
};

// What a tick works with, and leaves behind to be read.
struct ThisTick {
  double* jacobian;  // 6 n, all rows, base axes
  double* selected;  // m n: the selected rows, unused with every_row; see task_jacobian()
  RateBounds bounds;
  double* reference;  // n
  double* scratch;    // 10 n
  double pose[12];    // rotation by columns, translation
  double command[6];  // the twist asked for, corrections included, base axes
  double twist[6];    // its m task rows
};

struct ControllerState {
  Settings settings;
  Faults faults;
  LastTick last;
  ThisTick now;
};

// The task's rows of the Jacobian, m n.
STILLREACH_INLINE const double* task_jacobian(const Settings& s, const ThisTick& now) {
  return s.every_row ? now.jacobian : now.selected;
}

// Visits every array that a state of n joints points to, each with its length: whoever owns the memory points them into
// it, zeros at first. What arm and metric point to is not among them.
template <class Visit>
STILLREACH_INLINE void each_array(ControllerState& c, int n, Visit visit) {
  Settings& s = c.settings;
  visit(s.rate_lower, n);
  visit(s.rate_upper, n);
  visit(s.position_lower, n);
  visit(s.position_upper, n);
  visit(s.acceleration, n);
  visit(s.null_vector, n);
  visit(s.rotary, n);
  visit(c.faults.of, n);
  visit(c.last.rates, n);
  visit(c.last.anchor, n);
  visit(c.last.active, n);
  visit(c.last.closing, n);
  visit(c.now.jacobian, 6 * n);
  visit(c.now.selected, 6 * n);
  visit(c.now.bounds.lower, n);
  visit(c.now.bounds.upper, n);
  visit(c.now.bounds.lower_reason, n);
  visit(c.now.bounds.upper_reason, n);
  visit(c.now.reference, n);
  visit(c.now.scratch, 10 * n);
}

}  // namespace stillreach
