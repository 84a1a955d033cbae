// The data that callers and the core share: plain structs and enums, the same for every instruction set. Its two functions are
// always inlined, so that builds for different instruction sets share no symbol.
// Memory is the caller's: the core allocates nothing.
#pragma once

#include "stillreach/config.hpp"

namespace stillreach {

enum Status : std::int32_t {
  OK = 0,
  SATURATED = 1,
  SCALED = 2,
  DAMPED = 4,
  SINGULAR = 8,
  OVER_LIMIT = 16,
  NO_WORKING_JOINT = 32,
  FAULT_NOT_COMPENSATED = 64,
  CLIPPED = 128,
  LIMIT_GIVEN_UP = 256,
  ITERATION_LIMIT = 512,
  INVALID_INPUT = 1024,
};

// Why a bound is what it is; in Solution.active positive at the upper bound, negative at the lower one.
enum Reason : std::int8_t { FREE = 0, FAULT = 1, RATE = 2, POSITION = 3, ACCELERATION = 4 };

// Why a joint is at its bound, signed: from Answer::active and the reasons of its two bounds.
STILLREACH_INLINE std::int8_t active_reason(std::int8_t active, std::int8_t lower_reason, std::int8_t upper_reason) {
  return active == 0 ? std::int8_t{FREE} : active < 0 ? static_cast<std::int8_t>(-lower_reason) : upper_reason;
}

// The same where nothing but the bounds is known: one rate left is a fault, any other bound a rate limit.
STILLREACH_INLINE std::int8_t bound_reason(std::int8_t active) {
  return active == 2 ? std::int8_t{FAULT} : active_reason(active, RATE, RATE);
}

enum Health : std::int8_t { HEALTHY = 0, LOCKED = 1, DERATED = 2, RUNAWAY = 3 };

enum JointKind : std::int8_t { REVOLUTE = 0, PRISMATIC = 1 };

// Joints of a chain that move together: joint a of the chain is at factor[a] q[leader[a]] + offset[a].
struct Coupling {
  int moved;             // joints of the chain, at least as many as the arm has
  const int* leader;     // moved: index of an arm's joint
  const double* factor;  // moved
  const double* offset;  // moved
};

// A joint of a chain and the way to the next one (from the last one to the tool). Frames lie as Denavit and Hartenberg (1955)
// lay them: the joint moves about or along z, and from one z to the next leads a turn about x; but the translation may be any,
// so that axes that are nearly parallel need no far-away common normal.
struct Link {
  double turn[2];     // cosine and sine of what is added to the joint's angle
  double shift[3];    // then, along the axes of the frame that has moved: translation,
  double tilt[2];     // and cosine and sine of the turn about x
  std::int32_t kind;  // JointKind
  std::int32_t plain; // 1: revolute, and nothing is added to its angle
};

// A serial chain, as align_axes() of arm.hpp makes it of poses and axes.
struct ArmView {
  int n;                // joints of the arm
  const Link* links;    // n
  double base[16];      // the first frame before its joint moves: axes x, y, z and origin, four numbers each, the last one 0
  double end[2];        // cosine and sine of the tool's turn about z behind the last link
  const Coupling* coupling = nullptr;  // or null: each joint moves alone. Otherwise the links are those of the chain
};

enum LawKind : int { PSEUDOINVERSE = 0, SINGULARITY_ROBUST = 1, LEAST_ERROR = 2, KEEP_DIRECTION = 3 };
enum DampingKind : int { DAMPING_NUMBER = 0, DAMPING_CLOSED_FORM = 1, DAMPING_EXACT = 2 };
enum NormKind : int { NORM_INF = 0, NORM_2 = 1 };

constexpr int kParts = 3;  // most parts of a task with prices of their own

struct LawSettings {
  int kind;
  int damping;           // SingularityRobust: DampingKind
  int norm;              // SingularityRobust: NormKind
  double kappa;          // SingularityRobust: the number for DAMPING_NUMBER
  double rank_tolerance; // relative to the largest singular value of the working joints' weighted Jacobian
  int parts;             // LeastError: parts of the task with a price each; 0: the bare optimum
  std::int8_t part[6];   // of each task row
  double price[kParts];  // Y = price times a typical rate of the working joints
  int capped = -1;       // the part whose error beyond `ceiling` times that rate costs the price `beyond`, or -1
  double ceiling = 0.0, beyond = 0.0;
};

// Units and weights of the least-squares problem. Null pointers mean identity.
struct Metric {
  const double* rows;    // m x m upper triangular R, row-major, with e' W1 e = |R e|^2 in the task's units
  const double* units;   // n: joint units
  const double* columns; // n: joint units, each over the root of the joint's weight where that is a vector
  const double* joints;  // n x n: W2 in joint units where it is a full matrix
  int weightless = 0;    // last rows of R that are 0, W1 being singular: a matter of the paper's laws alone
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
  double typical = -1.0;    // typical_rate() of the working joints' rate limits; below 0: of these bounds
};

// What LeastError's search ended at, in weighted units: rates - reference = W2^-1 J'R'u inside the bounds, |u| <= Y for each part.
struct Multiplier {
  double u[6];           // m
  double kappa[kParts];  // of each part: |error| / Y, in the units of J J'
  int known;             // 0: nothing
};

// The answer. Pointers are the caller's memory.
struct Answer {
  double* rates;        // n
  double* residual;     // m: twist - J rates, unweighted
  std::int8_t* active;  // n: -1 at the lower bound, +1 at the upper one, 2 fixed, 0 free (in: warm start of the next tick)
  std::int32_t status;
  int iterations;       // factorisations (LeastError, KeepDirection) or steps of the damping search
  double damping;
  double scale;
  double task_error;    // weighted norm of the residual
  Multiplier* multiplier = nullptr;  // or null: LeastError's (in: warm start of the next tick)
};

}  // namespace stillreach
