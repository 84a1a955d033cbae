// The data that callers and the core share: plain structs and enums, no functions, the same for every instruction set.
// Memory is the caller's: the core allocates nothing.
#pragma once

#include "config.hpp"

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

enum Health : std::int8_t { HEALTHY = 0, LOCKED = 1, DERATED = 2, RUNAWAY = 3 };

enum JointKind : std::int8_t { REVOLUTE = 0, PRISMATIC = 1 };

// Joints of a chain that move together: joint a of the chain is at factor[a] q[leader[a]] + offset[a].
struct Coupling {
  int moved;             // joints of the chain, at least as many as the arm has
  const int* leader;     // moved: index of an arm's joint
  const double* factor;  // moved
  const double* offset;  // moved
};

// A serial chain whose joint axes are all z (see arm.hpp, which brings any chain into this form).
struct ArmView {
  int n;                     // joints of the arm
  const double* placements;  // n + 1 blocks of 12: rotation by columns, then translation; the last one is the tool
  const std::int8_t* kinds;  // n
  const Coupling* coupling = nullptr;  // or null: each joint moves alone. Otherwise placements and kinds are those of the chain
};

enum LawKind : int { PSEUDOINVERSE = 0, SINGULARITY_ROBUST = 1, LEAST_ERROR = 2, KEEP_DIRECTION = 3 };
enum DampingKind : int { DAMPING_NUMBER = 0, DAMPING_CLOSED_FORM = 1, DAMPING_EXACT = 2 };
enum NormKind : int { NORM_INF = 0, NORM_2 = 1 };

struct LawSettings {
  int kind;
  int damping;           // SingularityRobust: DampingKind
  int norm;              // SingularityRobust: NormKind
  double kappa;          // SingularityRobust: the number for DAMPING_NUMBER
  double rank_tolerance; // relative to the largest singular value of the working joints' weighted Jacobian
  double max_gain;       // LeastError: largest gain from twist to rates, weighted units; <= 0 means none
};

// Units and weights of the least-squares problem. Null pointers mean identity.
struct Metric {
  const double* rows;    // m x m upper triangular R, row-major, with e' W1 e = |R e|^2 in the task's units
  const double* units;   // n: joint units
  const double* columns; // n: joint units, each over the root of the joint's weight where that is a vector
  const double* joints;  // n x n: W2 in joint units where it is a full matrix
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
};

// The answer. Pointers are the caller's memory.
struct Answer {
  double* rates;        // n
  double* residual;     // m: twist - J rates, unweighted
  std::int8_t* active;  // n: -1 at the lower bound, +1 at the upper one, 2 fixed, 0 free (in: warm start of the next tick)
  double* plane;        // m, or null: KeepDirection's last supporting plane, weighted (in: warm start of the next tick)
  std::int32_t status;
  int iterations;       // factorisations (LeastError, KeepDirection) or steps of the damping search
  double damping;
  double scale;
  double task_error;    // weighted norm of the residual
};

}  // namespace stillreach
