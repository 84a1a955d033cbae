// Joints that move together: the chain's joints follow the arm's, and their columns are added to those of the joints they
// follow. An arm without such joints takes one branch more. Written for numbers (double) and for lanes (Wide).
#pragma once

#include "kinematics.hpp"
#include "lanes.hpp"

STILLREACH_BEGIN

STILLREACH_INLINE void lift(double value, double& to) { to = value; }
STILLREACH_INLINE void lift(double value, Wide& to) { to = wide(value); }

STILLREACH_INLINE void sine_cosine(double angle, double& sine, double& cosine) { sincos(&angle, 1, &sine, &cosine); }
STILLREACH_INLINE void sine_cosine(const Wide& angles, Wide& sine, Wide& cosine) {
  double at[kLanes], sines[kLanes], cosines[kLanes];
  for (int l = 0; l < kLanes; ++l) at[l] = angles[l];
  sincos(at, kLanes, sines, cosines);
  for (int l = 0; l < kLanes; ++l) sine[l] = sines[l], cosine[l] = cosines[l];
}

// sum += a x b.
template <class T>
STILLREACH_INLINE void cross_add(const T* a, const T* b, T* sum) {
  for (int r = 0; r < 3; ++r) {
    const int s = (r + 1) % 3, t = (r + 2) % 3;
    sum[r] += madd(a[s], b[t], -(a[t] * b[s]));
  }
}

// Goes along the chain; visit(a, factor, at, axis): joint a turns about or slides along `axis` through `at`, `factor` times
// as fast as the joint that it follows. frame: 12 numbers, at the end the tool's rotation by columns, and translation.
template <class T, class Visit>
inline void walk_coupled(const ArmView& arm, const T* q, T* frame, Visit visit) {
  const Coupling& c = *arm.coupling;
  for (int r = 0; r < 12; ++r) lift(r == 0 || r == 4 || r == 8 ? 1.0 : 0.0, frame[r]);
  for (int a = 0; a <= c.moved; ++a) {
    const double* placement = arm.placements + 12 * a;
    T next[12];
    for (int j = 0; j < 4; ++j)
      for (int r = 0; r < 3; ++r) {
        if (j == 3)
          next[9 + r] = frame[9 + r];
        else
          lift(0.0, next[3 * j + r]);
        for (int k = 0; k < 3; ++k) {
          T entry;
          lift(placement[3 * j + k], entry);
          next[3 * j + r] = madd(frame[3 * k + r], entry, next[3 * j + r]);
        }
      }
    for (int r = 0; r < 12; ++r) frame[r] = next[r];
    if (a == c.moved) return;
    T factor, position, sine, cosine;
    lift(c.factor[a], factor);
    lift(c.offset[a], position);
    position = madd(factor, q[c.leader[a]], position);
    if (arm.kinds[a] == REVOLUTE) {
      sine_cosine(position, sine, cosine);
      for (int r = 0; r < 3; ++r) {
        frame[r] = madd(cosine, next[r], sine * next[3 + r]);
        frame[3 + r] = madd(cosine, next[3 + r], -(sine * next[r]));
      }
    } else {
      for (int r = 0; r < 3; ++r) frame[9 + r] = madd(position, frame[6 + r], frame[9 + r]);
    }
    visit(a, factor, frame + 9, frame + 6);
  }
}

// As kinematics(): v = w x (p_tool - p) of all that follow a joint is (sum of w) x p_tool - sum of w x p.
template <class T>
inline STILLREACH_NOINLINE void coupled_kinematics(const ArmView& arm, const T* q, T* pose, T* jacobian) {
  if (!jacobian) return walk_coupled(arm, q, pose, [](int, T, const T*, const T*) {});
  for (int i = 0; i < 6 * arm.n; ++i) lift(0.0, jacobian[i]);
  walk_coupled(arm, q, pose, [&arm, jacobian](int a, T factor, const T* at, const T* axis) {
    T* column = jacobian + 6 * arm.coupling->leader[a];
    const bool turns = arm.kinds[a] == REVOLUTE;
    T along[3];
    for (int r = 0; r < 3; ++r) along[r] = factor * axis[r];
    if (turns) cross_add(at, along, column);
    for (int r = 0; r < 3; ++r) column[turns ? 3 + r : r] += along[r];
  });
  for (int i = 0; i < arm.n; ++i) cross_add(jacobian + 6 * i + 3, pose + 9, jacobian + 6 * i);
}

// kinematics() of any arm.
template <class T>
STILLREACH_INLINE void arm_kinematics(const ArmView& arm, const T* q, T* scratch, T* pose, T* jacobian) {
  if (__builtin_expect(arm.coupling != nullptr, 0))
    coupled_kinematics(arm, q, pose, jacobian);
  else
    kinematics(arm, q, scratch, pose, jacobian);
}

// The end of manipulability_gradient() where joints are coupled: the same sums, over the chain's joints. tool: its position.
// force: row j of J^+ (6 each) for the k working joints; turned: what tool axes turn with, or zeros.
inline STILLREACH_NOINLINE void coupled_gradient(const ArmView& arm, const double* q, const double* tool, const double* force,
                                                 const int* joint, int k, const double* total, const double* turned, double* gradient) {
  double suffix[3] = {total[0], total[1], total[2]}, prefix[3] = {0, 0, 0}, frame[12];
  for (int i = 0; i < arm.n; ++i) gradient[i] = 0.0;
  walk_coupled(arm, q, frame, [&](int a, double factor, const double* at, const double* axis) {
    const int leader = arm.coupling->leader[a];
    const bool turns = arm.kinds[a] == REVOLUTE;
    double column[6] = {0, 0, 0, 0, 0, 0}, forces[6] = {0, 0, 0, 0, 0, 0};
    for (int r = 0; r < 3; ++r) column[turns ? 3 + r : r] = axis[r];
    if (turns) {
      const double arm_to_tool[3] = {tool[0] - at[0], tool[1] - at[1], tool[2] - at[2]};
      cross_add(axis, arm_to_tool, column);
    }
    bool works = false;
    for (int j = 0; j < k; ++j)
      if (joint[j] == leader) {
        works = true;
        for (int r = 0; r < 6; ++r) forces[r] = factor * force[6 * j + r];
      }
    double along = 0.0, own[3] = {0, 0, 0};
    for (int r = 0; r < 3; ++r)
      along = madd(column[3 + r], suffix[r], madd(column[r], prefix[r], madd(-column[3 + r], turned[r], along)));
    if (works) gradient[leader] = madd(factor, along, gradient[leader]);
    cross_add(column, forces, own);
    cross_add(column + 3, forces + 3, own);
    for (int r = 0; r < 3; ++r) suffix[r] -= own[r];
    cross_add(forces, column + 3, prefix);
  });
}

STILLREACH_END
