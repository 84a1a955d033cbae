// Forward kinematics and Jacobian of a chain in one pass.
#pragma once

#include "stillreach/kinematics/sincos.hpp"
#include "stillreach/types.hpp"

STILLREACH_BEGIN

// Cyclic permutations of a 3-vector; the lane that does not matter holds what comes first in `yzx` again.
STILLREACH_INLINE Pack yzx(Pack a) { return STILLREACH_SHUFFLE(a, a, 1, 2, 0, 0); }
STILLREACH_INLINE Pack zxy(Pack a) { return STILLREACH_SHUFFLE(a, a, 2, 0, 1, 3); }

STILLREACH_INLINE Pack cross(Pack a, Pack b) { return madd(yzx(a), zxy(b), -(zxy(a) * yzx(b))); }

// Two axes of a frame turn in their plane: a becomes c a + s b, and b becomes c b - s a. Of a frame's axes y comes last
// to either turn, as b to the first and as a to the second, and waits for one multiply-add: eight cycles from a joint's
// axes to the next's.
template <class P>
STILLREACH_INLINE void turn_first(P c, P s, P& a, P& b) {
  const P old = b;
  b = madd(old, c, -(a * s));
  a = madd(old, s, a * c);
}
template <class P>
STILLREACH_INLINE void turn_second(P c, P s, P& a, P& b) {
  const P old = a;
  a = madd(old, c, b * s);
  b = madd(-old, s, b * c);
}

// Sine and cosine of a joint that is not plain: of its angle with what is added; of a prismatic one's constant angle.
template <class T>
STILLREACH_INLINE void add_turn(const Link& link, T& sine, T& cosine) {
  const T c = fill<T>(link.turn[0]), s = fill<T>(link.turn[1]), turned = madd(cosine, c, -(sine * s));
  const bool turns = link.kind == JointKind::REVOLUTE;
  sine = turns ? madd(sine, c, cosine * s) : s;
  cosine = turns ? turned : c;
}

// Pose of the tool (12 numbers: rotation by columns, translation) and, unless null, the Jacobian: column i at
// jacobian + 6 i is [v; w] of the tool point along base axes (Whitney, 1969). scratch: 10 n numbers.
inline void kinematics(const ArmView& arm, const double* q, double* scratch, double* pose, double* jacobian) {
  double *sine = scratch, *cosine = scratch + arm.n;
  double *at = scratch + 2 * arm.n, *axis = at + 4 * arm.n;  // of each joint, four numbers apart
  sincos(q, arm.n, sine, cosine);
  Pack x = load(arm.base), y = load(arm.base + 4), z = load(arm.base + 8), p = load(arm.base + 12);
  for (int i = 0; i < arm.n; ++i) {
    const Link& link = arm.links[i];
    if (!link.plain) {
      add_turn(link, sine[i], cosine[i]);
      if (link.kind != JointKind::REVOLUTE) p = madd(broadcast(q[i]), z, p);
    }
    store(at + 4 * i, p);
    store(axis + 4 * i, z);
    turn_first(broadcast(cosine[i]), broadcast(sine[i]), x, y);
    p = madd(x, broadcast(link.shift[0]), madd(y, broadcast(link.shift[1]), madd(z, broadcast(link.shift[2]), p)));
    turn_second(broadcast(link.tilt[0]), broadcast(link.tilt[1]), y, z);
  }
  turn_first(broadcast(arm.end[0]), broadcast(arm.end[1]), x, y);
  double frame[16];
  store(frame, x);
  store(frame + 3, y);
  store(frame + 6, z);
  store(frame + 9, p);
  for (int r = 0; r < 12; ++r) pose[r] = frame[r];
  if (!jacobian) return;
  for (int i = 0; i < arm.n; ++i) {
    double* column = jacobian + 6 * i;
    const Pack w = load(axis + 4 * i), turned = yzx(w);
    if (arm.links[i].kind == JointKind::REVOLUTE) {  // four and two numbers, as weighted_column() reads them
      store(column, STILLREACH_SHUFFLE(cross(w, p - load(at + 4 * i)), turned, 0, 1, 2, 7));
      store_pair(column + 4, turned);
    } else {
      const Pack zero = {0, 0, 0, 0};
      store(column, STILLREACH_SHUFFLE(w, zero, 0, 1, 2, 7));
      store_pair(column + 4, zero);
    }
  }
}

STILLREACH_END
