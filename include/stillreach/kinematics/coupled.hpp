// Joints that move together: the chain's joints follow the arm's, and their columns are added to those of the joints
// they follow. An arm without such joints takes one branch more. Written for numbers (double) and for lanes (Wide).
#pragma once

#include "stillreach/kinematics/kinematics.hpp"
#include "stillreach/simd/lanes.hpp"

STILLREACH_BEGIN

STILLREACH_INLINE void sine_cosine(double angle, double& sine, double& cosine) { sincos(&angle, 1, &sine, &cosine); }
STILLREACH_INLINE void sine_cosine(const Wide& angles, Wide& sine, Wide& cosine) {
  double at[kLanes], sines[kLanes], cosines[kLanes];
  for (int l = 0; l < kLanes; ++l) at[l] = angles[l];
  sincos(at, kLanes, sines, cosines);
  for (int l = 0; l < kLanes; ++l) {
    sine[l] = sines[l];
    cosine[l] = cosines[l];
  }
}

// sum += a x b.
template <class T>
STILLREACH_INLINE void cross_add(const T* a, const T* b, T* sum) {
  for (int r = 0; r < 3; ++r) {
    const int s = (r + 1) % 3, t = (r + 2) % 3;
    sum[r] += madd(a[s], b[t], -(a[t] * b[s]));
  }
}

// Goes along the chain; visit(a, factor, at, axis): joint a turns about or slides along `axis` through `at`, `factor`
// times as fast as the joint that it follows. frame: 12 numbers, at the end the tool's rotation by columns, and
// translation.
template <class T, class Visit>
inline void walk_coupled(const ArmView& arm, const T* q, T* frame, Visit visit) {
  const Coupling& c = *arm.coupling;
  for (int r = 0; r < 12; ++r) frame[r] = fill<T>(arm.base[4 * (r / 3) + r % 3]);
  T *x = frame, *y = frame + 3, *z = frame + 6, *p = frame + 9;
  for (int a = 0; a < c.moved; ++a) {
    const Link& link = arm.links[a];
    const T factor = fill<T>(c.factor[a]), position = madd(factor, q[c.leader[a]], fill<T>(c.offset[a]));
    T sine = fill<T>(0.0), cosine = fill<T>(1.0);
    if (link.kind == JointKind::REVOLUTE) sine_cosine(position, sine, cosine);
    add_turn(link, sine, cosine);
    for (int r = 0; r < 3; ++r) {
      if (link.kind != JointKind::REVOLUTE) p[r] = madd(position, z[r], p[r]);
      turn_first(cosine, sine, x[r], y[r]);
    }
    visit(a, factor, p, z);
    for (int r = 0; r < 3; ++r) {
      const double* shift = link.shift;
      p[r] = madd(x[r], fill<T>(shift[0]), madd(y[r], fill<T>(shift[1]), madd(z[r], fill<T>(shift[2]), p[r])));
      turn_second(fill<T>(link.tilt[0]), fill<T>(link.tilt[1]), y[r], z[r]);
    }
  }
  for (int r = 0; r < 3; ++r) turn_first(fill<T>(arm.end[0]), fill<T>(arm.end[1]), x[r], y[r]);
}

// As kinematics(): v = w x (p_tool - p) of all that follow a joint is (sum of w) x p_tool - sum of w x p.
template <class T>
inline STILLREACH_NOINLINE void coupled_kinematics(const ArmView& arm, const T* q, T* pose, T* jacobian) {
  if (!jacobian) return walk_coupled(arm, q, pose, [](int, T, const T*, const T*) {});
  for (int i = 0; i < 6 * arm.n; ++i) jacobian[i] = fill<T>(0.0);
  walk_coupled(arm, q, pose, [&arm, jacobian](int a, T factor, const T* at, const T* axis) {
    T* column = jacobian + 6 * arm.coupling->leader[a];
    const bool turns = arm.links[a].kind == JointKind::REVOLUTE;
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

// The end of manipulability_gradient() where joints are coupled: the same sums, over the chain's joints. tool: its
// position. force: row j of J^+ (6 each) for the k working joints; turned: what tool axes turn with, or zeros.
inline STILLREACH_NOINLINE void coupled_gradient(const ArmView& arm, const double* q, const double* tool,
                                                 const double* force, const int* joint, int k, const double* total,
                                                 const double* turned, double* gradient) {
  double suffix[3] = {total[0], total[1], total[2]}, prefix[3] = {0, 0, 0}, frame[12];
  for (int i = 0; i < arm.n; ++i) gradient[i] = 0.0;
  walk_coupled(arm, q, frame, [&](int a, double factor, const double* at, const double* axis) {
    const int leader = arm.coupling->leader[a];
    const bool turns = arm.links[a].kind == JointKind::REVOLUTE;
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
