// Targets: poses that are rigid up to rounding, made exact; and from a pose error to a twist: geodesic in orientation,
// bounded, right through a half turn.
#pragma once

#include "stillreach/control/bounds.hpp"
#include "stillreach/kinematics/arctangent.hpp"
#include "stillreach/kinematics/frames.hpp"

namespace stillreach {

constexpr double kRigid =
    1e-5;  // how far an entry may be from the nearest rigid transform's: float32, or five decimals

}  // namespace stillreach

STILLREACH_BEGIN

constexpr double kSmallTurn = 4e-3;  // of 4 sin^2 of an angle: up to here (1.8 deg) a short series is exact

// E = R'R - 1 (9 numbers), R by columns. Returns the sum of its entries' sizes: 0 for a rotation.
inline double off_rotation(const double* R, double* E) {
  double off = 0.0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      E[3 * a + b] = dot3(R + 3 * a, R + 3 * b) - (a == b ? 1.0 : 0.0);
      off += magnitude(E[3 * a + b]);
    }
  return off;
}

// The rotation nearest to R (by columns), in place: R (3 - R'R) / 2 squares the distance (Bjorck and Bowie, 1971).
// Leaves alone what is a rotation up to rounding. False, with R as it was: no rotation is within kRigid of it.
inline bool nearest_rotation(double* R) {
  double E[9], near[9];
  const double off = off_rotation(R, E);
  const double det =
      R[0] * (R[4] * R[8] - R[5] * R[7]) - R[3] * (R[1] * R[8] - R[2] * R[7]) + R[6] * (R[1] * R[5] - R[2] * R[4]);
  if (!(off <= 36.0 * kRigid) || !(det > 0.0)) return false;  // 9 entries of at most 4 kRigid
  if (off <= 1e-12) return true;
  for (int k = 0; k < 9; ++k) near[k] = R[k];
  for (int step = 0; step < 2; ++step) {
    double next[9];
    for (int a = 0; a < 3; ++a)
      for (int r = 0; r < 3; ++r)
        next[3 * a + r] = near[3 * a + r] - 0.5 * (E[a] * near[r] + E[3 + a] * near[3 + r] + E[6 + a] * near[6 + r]);
    for (int k = 0; k < 9; ++k) near[k] = next[k];
    off_rotation(near, E);
  }
  for (int k = 0; k < 9; ++k)
    if (!(magnitude(near[k] - R[k]) <= kRigid)) return false;
  for (int k = 0; k < 9; ++k) R[k] = near[k];
  return true;
}

// A row-major 4 x 4 matrix as a pose (12 numbers: rotation by columns, translation), with the nearest rotation. False:
// it is not finite, or no rigid transform is within kRigid of it.
inline bool read_pose(const double* T, double* pose) {
  bool right = true;
  for (int c = 0; c < 4; ++c) {
    right &= magnitude(T[12 + c] - (c == 3 ? 1.0 : 0.0)) <= kRigid;
    for (int r = 0; r < 3; ++r) {
      pose[3 * c + r] = T[4 * r + c];
      right &= is_finite(T[4 * r + c]);
    }
  }
  return right && nearest_rotation(pose);
}

// Rotation vector of E = target R' (both rotations by columns), along base axes; its length is at most pi.
inline void rotation_error(const double* target, const double* R, double* vector) {
  double E[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      E[i][j] = madd(target[i], R[j], madd(target[3 + i], R[3 + j], target[6 + i] * R[6 + j]));
  const double turn[3] = {E[2][1] - E[1][2], E[0][2] - E[2][0], E[1][0] - E[0][1]};  // 2 sin(angle) axis
  const double s4 = madd(turn[0], turn[0], madd(turn[1], turn[1], turn[2] * turn[2]));
  if (s4 < kSmallTurn && E[0][0] + E[1][1] + E[2][2] > 1.0) {
    const double s2 = 0.25 * s4;  // angle / sin(angle), by the series of the arcsine
    const double series =
        madd(s2, madd(s2, madd(s2, madd(s2, 35.0 / 1152.0, 5.0 / 112.0), 3.0 / 40.0), 1.0 / 6.0), 1.0);
    for (int i = 0; i < 3; ++i) vector[i] = 0.5 * series * turn[i];
    return;
  }
  // quaternion by its largest component (Shepperd, 1978), so that no angle loses digits
  const double trace = E[0][0] + E[1][1] + E[2][2];
  double w, v[3];
  int big = E[0][0] > E[1][1] ? (E[0][0] > E[2][2] ? 0 : 2) : (E[1][1] > E[2][2] ? 1 : 2);
  if (trace > E[big][big]) {
    w = 0.5 * square_root(larger(1.0 + trace, 0.0));
    for (int i = 0; i < 3; ++i) v[i] = (E[(i + 2) % 3][(i + 1) % 3] - E[(i + 1) % 3][(i + 2) % 3]) / (4.0 * w);
  } else {
    const int a = big, b = (a + 1) % 3, c = (a + 2) % 3;
    v[a] = 0.5 * square_root(larger(1.0 + E[a][a] - E[b][b] - E[c][c], 0.0));
    v[b] = (E[a][b] + E[b][a]) / (4.0 * v[a]);
    v[c] = (E[a][c] + E[c][a]) / (4.0 * v[a]);
    w = (E[c][b] - E[b][c]) / (4.0 * v[a]);
  }
  if (w < 0.0) {
    w = -w;
    for (int i = 0; i < 3; ++i) v[i] = -v[i];
  }
  const double s = square_root(madd(v[0], v[0], madd(v[1], v[1], v[2] * v[2])));
  const double gain = s > 1e-8 ? 2.0 * first_quadrant_angle(s, w) / s : 2.0;
  for (int i = 0; i < 3; ++i) vector[i] = gain * v[i];
}

// The twist that leads from a pose to a target in unit time. pose, target: 12 numbers.
inline void pose_error(const double* target, const double* pose, double* twist) {
  for (int i = 0; i < 3; ++i) twist[i] = target[9 + i] - pose[9 + i];
  rotation_error(target, pose, twist + 3);
}

// How far count poses (rows of 16) are from those that are wanted: rows of distance and angle, of the twist that leads
// there, in the components that are asked for (6, 0 or 1), along the axes of the pose or of the base. NaN where one of
// the two is no pose.
inline void pose_distances(const double* actual, const double* wanted, long count, const double* asked, bool along_pose,
                           double* off) {
  for (long t = 0; t < count; ++t) {
    double pose[12], target[12], twist[6];
    if (!read_pose(actual + 16 * t, pose) || !read_pose(wanted + 16 * t, target)) {
      off[t] = off[count + t] = infinity() - infinity();
      continue;
    }
    pose_error(target, pose, twist);
    for (int part = 0; part < 2; ++part) {
      const double* v = twist + 3 * part;
      double sum = 0.0;
      for (int i = 0; i < 3; ++i) {
        const double* axis = pose + 3 * i;
        const double along = along_pose ? madd(axis[0], v[0], madd(axis[1], v[1], axis[2] * v[2])) : v[i];
        if (asked[3 * part + i] != 0.0) sum = madd(along, along, sum);
      }
      off[part * count + t] = square_root(sum);
    }
  }
}

STILLREACH_INLINE void bound_length(double* v, double largest) {
  const double length = square_root(madd(v[0], v[0], madd(v[1], v[1], v[2] * v[2])));
  if (length > largest)
    for (int i = 0; i < 3; ++i) v[i] *= largest / length;
}

// twist += gain * pose error, its linear and angular parts each at most as long as told. pose, target: 12 numbers.
inline void add_correction(const double* target, const double* pose, double gain, double linear, double angular,
                           double* twist) {
  double v[3], w[3];
  rotation_error(target, pose, w);
  for (int i = 0; i < 3; ++i) {
    v[i] = gain * (target[9 + i] - pose[9 + i]);
    w[i] *= gain;
  }
  bound_length(v, linear);
  bound_length(w, angular);
  for (int i = 0; i < 3; ++i) {
    twist[i] += v[i];
    twist[3 + i] += w[i];
  }
}

// A product in which nothing times no limit is nothing.
STILLREACH_INLINE double product(double a, double b) { return a == 0.0 || b == 0.0 ? 0.0 : a * b; }

// The largest correction, where the controller chooses it: the fastest that one joint alone, at the rate limit that its
// fault leaves it, can move the tool, and turn it, in any pose. A joint turns the tool at its rate, and moves it at
// most at that rate times the length of the links behind it. Where no joint does, there is no bound. scratch: 2 n
// numbers.
inline void bound_correction(Settings& s, const Faults& faults, double* scratch) {
  if (!s.track_automatic) return;
  const Coupling* const coupling = s.arm.coupling;
  const int moved = coupling ? coupling->moved : s.arm.n;
  double *linear = scratch, *angular = scratch + s.arm.n, reach = 0.0;
  for (int i = 0; i < s.arm.n; ++i) linear[i] = angular[i] = 0.0;
  for (int a = moved - 1; a >= 0; --a) {
    const int i = coupling ? coupling->leader[a] : a;
    const double factor = coupling ? magnitude(coupling->factor[a]) : 1.0;
    double rate = larger(-s.rate_lower[i], s.rate_upper[i]);  // the speed multiplies the correction itself
    if (s.speed != 1.0) rate = s.speed > 0.0 ? rate / s.speed : 0.0;
    rate = works(faults.of[i]) ? largest_rate(faults.of[i], -rate, rate) : 0.0;
    const double* shift = s.arm.links[a].shift;
    reach += square_root(madd(shift[0], shift[0], madd(shift[1], shift[1], shift[2] * shift[2])));
    if (s.arm.links[a].kind == JointKind::REVOLUTE) {
      linear[i] += product(factor * reach, rate);
      angular[i] += product(factor, rate);
    } else {
      linear[i] += product(factor, rate);
      const double end = larger(magnitude(s.position_lower[i]), magnitude(s.position_upper[i]));
      reach += product(factor, end) + (coupling ? magnitude(coupling->offset[a]) : 0.0);
    }
  }
  s.track_linear = s.track_angular = 0.0;
  for (int i = 0; i < s.arm.n; ++i) {
    s.track_linear = larger(s.track_linear, linear[i]);
    s.track_angular = larger(s.track_angular, angular[i]);
  }
  if (s.track_linear == 0.0) s.track_linear = infinity();
  if (s.track_angular == 0.0) s.track_angular = infinity();
}

STILLREACH_END
