// The data that callers and the core share: plain structs and enums, the same for every instruction set. Its functions
// are always inlined, so that builds for different instruction sets share no symbol. Memory is the caller's: the core
// allocates nothing.
#pragma once

#include "stillreach/config.hpp"

namespace stillreach {

// A number that is not negative, as sizes of memory count.
STILLREACH_INLINE constexpr std::size_t to_size(std::ptrdiff_t count) { return static_cast<std::size_t>(count); }

// Closed sets, as lists of name and meaning: the enumerations here and those that Python sees are made of them.
// A switch over such a set names every member and has no default, so that the compiler reports what was forgotten.
#define STILLREACH_MEMBER(name, ...) name,

// What happened in a tick; a set of flags. stillreach/status.py explains them.
#define STILLREACH_STATUS(X)   \
  X(OK, 0)                     \
  X(SATURATED, 1)              \
  X(SCALED, 2)                 \
  X(DAMPED, 4)                 \
  X(SINGULAR, 8)               \
  X(OVER_LIMIT, 16)            \
  X(NO_WORKING_JOINT, 32)      \
  X(FAULT_NOT_COMPENSATED, 64) \
  X(CLIPPED, 128)              \
  X(LIMIT_GIVEN_UP, 256)       \
  X(ITERATION_LIMIT, 512)      \
  X(INVALID_INPUT, 1024)
#define STILLREACH_FLAG(name, value) name = value,
enum Status : std::int32_t { STILLREACH_STATUS(STILLREACH_FLAG) };
#undef STILLREACH_FLAG

#define STILLREACH_REASON(X)       \
  X(FREE, "No bound is met.")      \
  X(FAULT, "The joint's fault.")   \
  X(RATE, "The rate limit.")       \
  X(POSITION, "A position limit.") \
  X(ACCELERATION, "The acceleration limit.")
enum class Reason : std::int8_t { STILLREACH_REASON(STILLREACH_MEMBER) };

// Reasons are stored with a sign: positive at the upper bound, negative at the lower one.
STILLREACH_INLINE constexpr std::int8_t code(Reason reason) { return static_cast<std::int8_t>(reason); }

// Why a joint is at its bound, signed: from Answer::active and the reasons of its two bounds.
STILLREACH_INLINE std::int8_t active_reason(std::int8_t active, std::int8_t lower_reason, std::int8_t upper_reason) {
  return active == 0 ? code(Reason::FREE) : active < 0 ? static_cast<std::int8_t>(-lower_reason) : upper_reason;
}

// The same where only the bounds are given: one rate left is a fault, any other bound a rate limit.
STILLREACH_INLINE std::int8_t bound_reason(std::int8_t active) {
  return active == 2 ? code(Reason::FAULT) : active_reason(active, code(Reason::RATE), code(Reason::RATE));
}

// State of a joint. The two numbers of its Fault, 0 where none is named: DERATED the fraction left; RUNAWAY the rate;
// CONFINED the lower and the upper end of the range; ONE_WAY the direction, 1 or -1.
#define STILLREACH_HEALTH(X)                                      \
  X(HEALTHY, "Nothing is wrong.")                                 \
  X(LOCKED, "The joint stands where it is.")                      \
  X(DERATED, "It moves at most at a fraction of its rate limit.") \
  X(RUNAWAY, "It moves at a rate that nobody commands.")          \
  X(CONFINED, "Its range of positions is reduced.")               \
  X(ONE_WAY, "It moves to one side only.")                        \
  X(FREE_SWINGING, "It has no drive, and moves as forces move it.")
enum class Health : std::int8_t { STILLREACH_HEALTH(STILLREACH_MEMBER) };

struct Fault {
  Health health = Health::HEALTHY;
  double number[2] = {0.0, 0.0};  // by health, see there
};

#define STILLREACH_JOINT_KIND(X)       \
  X(REVOLUTE, "Turns about its axis.") \
  X(PRISMATIC, "Moves along its axis.")
enum class JointKind : std::int32_t { STILLREACH_JOINT_KIND(STILLREACH_MEMBER) };

// Joints of a chain that move together: joint a of the chain is at factor[a] q[leader[a]] + offset[a].
struct Coupling {
  int moved;             // joints of the chain, at least as many as the arm has
  const int* leader;     // moved: index of an arm's joint
  const double* factor;  // moved
  const double* offset;  // moved
};

// A joint of a chain and the way to the next one (from the last one to the tool). Frames lie as Denavit and Hartenberg
// (1955) lay them: the joint moves about or along z, and from one z to the next leads a turn about x; but the
// translation may be any, so that axes that are nearly parallel need no far-away common normal.
struct Link {
  double turn[2];   // cosine and sine of what is added to the joint's angle
  double shift[3];  // then, along the axes of the frame that has moved: translation,
  double tilt[2];   // and cosine and sine of the turn about x
  JointKind kind;
  std::int32_t plain;  // 1: revolute, and nothing is added to its angle
};

// A serial chain, as align_axes() of arm.hpp makes it of poses and axes.
struct ArmView {
  int n;              // joints of the arm
  const Link* links;  // n
  double
      base[16];   // the first frame before its joint moves: axes x, y, z and origin, four numbers each, the last one 0
  double end[2];  // cosine and sine of the tool's turn about z behind the last link
  const Coupling* coupling = nullptr;  // or null: each joint moves alone. Otherwise the links are those of the chain
};

#define STILLREACH_LAW_KIND(X)                                        \
  X(PSEUDOINVERSE, "Eq. (3) of Bedrossian (1994).")                   \
  X(SINGULARITY_ROBUST, "Eq. (5) to (8).")                            \
  X(LEAST_ERROR, "Least task error inside the bounds, with a price.") \
  X(KEEP_DIRECTION, "The largest fraction of the twist inside the bounds.")
enum class LawKind : int { STILLREACH_LAW_KIND(STILLREACH_MEMBER) };

#define STILLREACH_DAMPING_KIND(X) \
  X(NUMBER, "A given kappa.")      \
  X(CLOSED_FORM, "Eq. (16).")      \
  X(EXACT, "Eq. (10).")
enum class DampingKind : int { STILLREACH_DAMPING_KIND(STILLREACH_MEMBER) };

#define STILLREACH_NORM_KIND(X)   \
  X(MAXIMUM, "The largest rate.") \
  X(EUCLIDEAN, "The Euclidean norm of the rates.")
enum class NormKind : int { STILLREACH_NORM_KIND(STILLREACH_MEMBER) };

constexpr int kParts = 3;  // most parts of a task with prices of their own

struct LawSettings {
  LawKind kind;
  DampingKind damping;    // SingularityRobust
  NormKind norm;          // SingularityRobust
  double kappa;           // SingularityRobust: the number for DAMPING_NUMBER
  double rank_tolerance;  // relative to the largest singular value of the working joints' weighted Jacobian
  int parts;              // LeastError: parts of the task with a price each; 0: the bare optimum
  std::int8_t part[6];    // of each task row
  double price[kParts];   // Y = price times a typical rate of the working joints
  int capped = -1;        // the part whose error beyond `ceiling` times that rate costs the price `beyond`, or -1
  double ceiling = 0.0, beyond = 0.0;
};

// Units and weights of the least-squares problem. Null pointers mean identity.
struct Metric {
  const double* rows;     // m x m upper triangular R, row-major, with e' W1 e = |R e|^2 in the task's units
  const double* units;    // n: joint units
  const double* columns;  // n: joint units, each over the root of the joint's weight where that is a vector
  const double* joints;   // n x n: W2 in joint units where it is a full matrix
  int weightless = 0;     // last rows of R that are 0, W1 being singular: a matter of the paper's laws alone
};

// One tick's question to a law. Column i of the Jacobian is at jacobian + i * m.
struct Problem {
  int m;
  int n;
  const double* jacobian;
  const double* twist;      // m
  const double* lower;      // n
  const double* upper;      // n
  const double* reference;  // n or null: the rates to stay near
  Metric metric;
  double typical = -1.0;  // typical_rate() of the working joints' rate limits; below 0: of these bounds
};

// What LeastError's search ended at, in weighted units: rates - reference = W2^-1 J'R'u inside the bounds, |u| <= Y for
// each part.
struct Multiplier {
  double u[6];           // m
  double kappa[kParts];  // of each part: |error| / Y, in the units of J J'
  double raised;         // by this factor a ceiling raised the price of its part
  int known;             // 0: nothing
};

// The answer. Pointers are the caller's memory.
struct Answer {
  double* rates;     // n
  double* residual;  // m: twist - J rates, unweighted
  std::int8_t*
      active;  // n: -1 at the lower bound, +1 at the upper one, 2 fixed, 0 free (in: warm start of the next tick)
  std::int32_t status;
  int iterations;  // factorisations (LeastError, KeepDirection) or steps of the damping search
  double damping;
  double scale;
  double task_error;                 // weighted norm of the residual
  Multiplier* multiplier = nullptr;  // or null: LeastError's (in: warm start of the next tick)
};

}  // namespace stillreach
