// The memory of a controller: what it was told once, what is broken, and what it did a tick ago. No functions.
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
  return kind == NullMotionKind::MANIPULABILITY || kind == NullMotionKind::TOLERANCE ||
         kind == NullMotionKind::GUARANTEED_SPEED;
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

struct ControllerState {
  // told once
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

  // what is broken
  Fault* faults;                   // n
  std::int8_t* closing = nullptr;  // n, Closing; or null: the limits do not change

  // what happened
  double* last;                // n: last commanded rates
  double* anchor;              // n: those when a joint last failed or was restored
  std::int8_t* active;         // n: bounds active a tick ago, as in Answer::active
  int bounds_stand;            // with constant_bounds: they are computed and no fault came since
  std::int32_t bounds_status;  // what the bounds add to the tick's status: see bounds_of()
  Multiplier multiplier;       // LeastError's a tick ago
  double typical;              // typical_rate() of the working joints' rate limits
  double transition;           // 1 just after a fault, falls to 0

  // this tick
  double* jacobian;           // 6 n, all rows, base axes
  double* task_jacobian;      // m n: the selected rows (the same memory as `jacobian` when every_row)
  double* lower;              // n
  double* upper;              // n
  std::int8_t* lower_reason;  // n, Reason
  std::int8_t* upper_reason;  // n
  double* reference;          // n
  double* scratch;            // 10 n
  double pose[12];            // rotation by columns, translation
  double command[6];          // the twist asked for, corrections included, base axes
  double twist[6];            // its m task rows
};

// Memory of a state: n numbers and n bytes, so many times.
constexpr int kStateNumbers = 33, kStateBytes = 5;

// Points a state, of n joints and with every_row told, into memory of that size, zeros at first. The first numbers are
// the limits, in the order of their names above; the last bytes may become `rotary`, which is returned.
STILLREACH_INLINE std::int8_t* point_into(ControllerState& s, double* numbers, std::int8_t* bytes) {
  const int n = s.arm.n;
  const auto take = [&numbers, n](int times) {
    double* const here = numbers;
    numbers += times * n;
    return here;
  };
  s.rate_lower = take(1);
  s.rate_upper = take(1);
  s.position_lower = take(1);
  s.position_upper = take(1);
  s.acceleration = take(1);
  s.null_vector = take(1);
  s.last = take(1);
  s.anchor = take(1);
  s.lower = take(1);
  s.upper = take(1);
  s.reference = take(1);
  s.jacobian = take(6);
  s.scratch = take(10);
  s.task_jacobian = s.every_row ? s.jacobian : take(6);
  s.active = bytes;
  s.lower_reason = bytes + n;
  s.upper_reason = bytes + 2 * n;
  s.closing = bytes + 3 * n;
  return bytes + 4 * n;
}

}  // namespace stillreach
