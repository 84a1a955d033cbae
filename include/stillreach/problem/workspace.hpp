// The memory that one solve needs, cut from one block that the caller owns.
#pragma once

#include "stillreach/linear/factor.hpp"
#include "stillreach/types.hpp"

namespace stillreach {

struct Memory {  // as make_workspace() wants it
  double* doubles;
  int* ints;
  std::int8_t* bytes;
};

}  // namespace stillreach

STILLREACH_BEGIN

struct Workspace {
  int n;
  double* columns;            // 8 n: weighted Jacobian of the working joints
  double* work;               // 7 n: QR, and n more
  double* shapes;             // 8 n: rate of each working joint per unit of each singular direction
  double* scale;              // n
  double* limit;              // n
  double* lower;              // n
  double* upper;              // n
  double* z;                  // n
  double* target;             // n
  double* offset;             // n
  double* extent;             // n
  double* length;             // n: of the columns
  double* other;              // n: rates of another answer
  double* whitened;           // 8 n where a full joint weight is used, else null
  double* triangle;           // n * n, likewise
  double* weight;             // n * n, likewise: the joint weight seen by the scaled working joints
  double* whole;              // n * n, likewise: Cholesky factor of that weight
  double* second;             // n, likewise
  double* third;              // n, likewise
  int* joint;                 // n: the working joints
  int* index;                 // n
  int* releases;              // n
  std::int8_t* state;         // n
  std::int8_t* held;          // n
  std::int8_t* other_active;  // n
};

STILLREACH_INLINE std::size_t workspace_doubles(int n, bool full_joint_weight) {
  return 33 * to_size(n) + (full_joint_weight ? (3 * to_size(n) + 10) * to_size(n) : 0);
}
STILLREACH_INLINE std::size_t workspace_ints(int n) { return 3 * to_size(n); }
STILLREACH_INLINE std::size_t workspace_bytes(int n) { return 3 * to_size(n); }

STILLREACH_INLINE Workspace make_workspace(int n, bool full_joint_weight, double* doubles, int* ints,
                                           std::int8_t* bytes) {
  Workspace w;
  w.n = n;
  w.columns = doubles;
  w.shapes = doubles + 8 * n;
  w.work = doubles + 16 * n;
  double* rest = doubles + 23 * n;
  double** vectors[] = {&w.scale,  &w.limit,  &w.lower,  &w.upper,  &w.z,
                        &w.target, &w.offset, &w.extent, &w.length, &w.other};
  for (double** v : vectors) {
    *v = rest;
    rest += n;
  }
  w.whitened = w.triangle = w.weight = w.whole = w.second = w.third = nullptr;
  if (full_joint_weight) {
    w.whitened = rest;
    w.second = rest + 8 * n;
    w.third = w.second + n;
    w.triangle = w.third + n;
    w.weight = w.triangle + std::ptrdiff_t{n} * n;
    w.whole = w.weight + std::ptrdiff_t{n} * n;
  }
  w.joint = ints;
  w.index = ints + n;
  w.releases = ints + 2 * n;
  w.state = bytes;
  w.held = bytes + n;
  w.other_active = bytes + 2 * n;
  return w;
}
STILLREACH_INLINE Workspace make_workspace(int n, bool full_joint_weight, const Memory& memory) {
  return make_workspace(n, full_joint_weight, memory.doubles, memory.ints, memory.bytes);
}

STILLREACH_END
