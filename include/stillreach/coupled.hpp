// Joints that move together: the chain's joints follow the arm's, its columns are added to theirs. An arm without such
// joints takes one branch more.
#pragma once

#include "kinematics.hpp"

STILLREACH_BEGIN

STILLREACH_INLINE void cross_add(const double* a, const double* b, double* sum) {
  for (int r = 0; r < 3; ++r) {
    const int s = (r + 1) % 3, t = (r + 2) % 3;
    sum[r] += madd(a[s], b[t], -(a[t] * b[s]));
  }
}

STILLREACH_INLINE double dot3(const double* a, const double* b) { return madd(a[0], b[0], madd(a[1], b[1], a[2] * b[2])); }

// Numbers of scratch for an arm with coupled joints: 6 moved to compute in, 6 moved + 2 for the chain's Jacobian, which the
// gradient needs, and 6 moved for its forces.
STILLREACH_INLINE std::size_t coupled_scratch(int moved) { return 18 * static_cast<std::size_t>(moved) + 2; }

// As kinematics(), of the chain's joints at the places that q gives them.
STILLREACH_NOINLINE inline void coupled_kinematics(const ArmView& arm, const double* q, double* scratch, double* pose, double* jacobian) {
  const Coupling& c = *arm.coupling;
  double *positions = scratch, *columns = scratch + 6 * c.moved;
  for (int a = 0; a < c.moved; ++a) positions[a] = madd(c.factor[a], q[c.leader[a]], c.offset[a]);
  const ArmView chain{c.moved, arm.placements, arm.kinds};
  kinematics(chain, positions, scratch + c.moved, pose, jacobian ? columns : nullptr);
  if (!jacobian) return;
  for (int i = 0; i < 6 * arm.n; ++i) jacobian[i] = 0.0;
  for (int a = 0; a < c.moved; ++a)
    for (int r = 0; r < 6; ++r) {
      double& sum = jacobian[6 * c.leader[a] + r];
      sum = madd(c.factor[a], columns[6 * a + r], sum);
    }
}

// kinematics() of any arm. scratch: 2 n numbers, or coupled_scratch() where joints are coupled.
STILLREACH_INLINE void arm_kinematics(const ArmView& arm, const double* q, double* scratch, double* pose, double* jacobian) {
  if (__builtin_expect(arm.coupling != nullptr, 0))
    coupled_kinematics(arm, q, scratch, pose, jacobian);
  else
    kinematics(arm, q, scratch, pose, jacobian);
}

// The end of manipulability_gradient() where joints are coupled: the same sums, over the chain's joints.
// scratch: as coupled_kinematics() left it. force: row j of J^+ (6 each) for the k working joints; turned: what tool axes
// turn with, or zeros.
STILLREACH_NOINLINE inline void coupled_gradient(const ArmView& arm, double* scratch, const double* force, const int* joint, int k,
                                                 const double* total, const double* turned, double* gradient) {
  const Coupling& c = *arm.coupling;
  const double* columns = scratch + 6 * c.moved;
  double* forces = scratch + 12 * c.moved + 2;
  for (int i = 0; i < 6 * c.moved; ++i) forces[i] = 0.0;
  for (int j = 0; j < k; ++j)
    for (int a = 0; a < c.moved; ++a)
      if (c.leader[a] == joint[j])
        for (int r = 0; r < 6; ++r) forces[6 * a + r] = c.factor[a] * force[6 * j + r];
  double suffix[3] = {total[0], total[1], total[2]}, prefix[3] = {0, 0, 0};
  for (int a = 0; a < c.moved; ++a) {
    const double* column = columns + 6 * a;
    const double along = dot3(column + 3, suffix) + dot3(column, prefix) - dot3(column + 3, turned);
    gradient[c.leader[a]] += c.factor[a] * along;
    double own[3] = {0, 0, 0};
    cross_add(column, forces + 6 * a, own);
    cross_add(column + 3, forces + 6 * a + 3, own);
    for (int r = 0; r < 3; ++r) suffix[r] -= own[r];
    cross_add(forces + 6 * a, column + 3, prefix);
  }
  for (int i = 0, j = 0; i < arm.n; ++i) {
    if (j < k && joint[j] == i)
      ++j;
    else
      gradient[i] = 0.0;
  }
}

STILLREACH_END
