// What a controller's arm can do now, and what the loss of each joint would cost.
#pragma once

#include "stillreach/control/bounds.hpp"
#include "stillreach/linear/spectrum.hpp"
#include "stillreach/problem/workspace.hpp"

STILLREACH_BEGIN

// Directions count as lost where all joints that work, at their full rates, give less than this [m/s], [rad/s].
constexpr double kLeastSpeed = 1e-3, kLeastTurn = 1.7453292519943296e-3;  // 1 mm/s, 0.1 deg/s

struct Insight {
  int lost;                // directions of the task that the arm has lost
  double direction[6][6];  // each of them: a unit twist along the task's axes, rows that are not asked for 0
  double sigma[3];    // half axes of the ellipsoid of the tool's velocities at full rates [m/s], the longest first,
  double axis[3][3];  // and their directions, base axes
  double* relative;   // n: manipulability without the joint over manipulability with it; of one that failed, 1
  int* costs;         // n: directions that its loss would cost
  double* cost;       // 6 n: the first of them
};

// Directions of m rows, of count columns, in which they all at once give less than 1: unit vectors (kStride apart), the
// weakest first. Returns how many.
inline int weak_directions(int m, const double* columns, int count, double* work, double* weak) {
  Spectrum s;
  s.count = 0;
  if (count > 0) spectrum(m, columns, nullptr, count, 0.0, work, s);
  double basis[kRows][kStride] = {};
  int known = 0, found = 0;
  for (; known < s.count && s.sigma[known] > 1e-300; ++known)
    for (int r = 0; r < m; ++r) basis[known][r] = s.left[known][r];
  for (int made = known; made < m; ++made) {  // what no column reaches: the unit vector that the others leave most of
    double best = -1.0;
    for (int unit = 0; unit < m; ++unit) {
      double v[kStride] = {}, size = 0.0;
      v[unit] = 1.0;
      for (int pass = 0; pass < 2; ++pass)
        for (int j = 0; j < made; ++j) {
          double along = 0.0;
          for (int r = 0; r < m; ++r) along = madd(basis[j][r], v[r], along);
          for (int r = 0; r < m; ++r) v[r] = madd(-along, basis[j][r], v[r]);
        }
      for (int r = 0; r < m; ++r) size = madd(v[r], v[r], size);
      if (!(size > best)) continue;
      best = size;
      for (int r = 0; r < m; ++r) basis[made][r] = v[r] / square_root(size);
    }
  }
  for (int j = m - 1; j >= 0; --j) {
    double gain = 0.0;
    for (int i = 0; i < count && j < known; ++i) {
      double along = 0.0;
      for (int r = 0; r < m; ++r) along = madd(basis[j][r], columns[i * kStride + r], along);
      gain += magnitude(along);
    }
    if (gain < 1.0)
      for (int r = 0, to = kStride * found++; r < m; ++r) weak[to + r] = basis[j][r];
  }
  return found;
}

// From a direction in least speeds to a unit twist. least: 6.
STILLREACH_INLINE void to_twist(const Settings& s, const double* weak, const double* least, double* twist) {
  double size = 0.0;
  for (int r = 0; r < 6; ++r) twist[r] = 0.0;
  for (int r = 0; r < s.m; ++r) {
    twist[s.rows[r]] = weak[r] / least[s.rows[r]];
    size = madd(twist[s.rows[r]], twist[s.rows[r]], size);
  }
  for (int r = 0; r < 6; ++r) twist[r] /= square_root(size);
}

// After a tick, of its Jacobian. rates: n, full rates of the joints.
inline void look_into(const Settings& settings, const Faults& faults, const ThisTick& now, const double* rates,
                      Workspace& w, Insight& to) {
  const int m = settings.m, n = settings.arm.n;
  const double* const J = task_jacobian(settings, now);
  const double least[6] = {kLeastSpeed, kLeastSpeed, kLeastSpeed, kLeastTurn, kLeastTurn, kLeastTurn};
  int k = 0;
  for (int i = 0; i < n; ++i) {
    to.relative[i] = 1.0;
    to.costs[i] = 0;
    for (int r = 0; r < 6; ++r) to.cost[6 * i + r] = 0.0;
    if (works(faults.of[i]) && rates[i] > 0.0) w.joint[k++] = i;
  }
  Spectrum s;
  for (int j = 0; j < k; ++j)
    for (int r = 0; r < kStride; ++r)
      w.columns[j * kStride + r] = r < 3 ? now.jacobian[6 * w.joint[j] + r] * rates[w.joint[j]] : 0.0;
  for (int a = 0; a < 3; ++a) {
    to.sigma[a] = 0.0;
    for (int r = 0; r < 3; ++r) to.axis[a][r] = a == r ? 1.0 : 0.0;
  }
  if (k > 0) {
    spectrum(3, w.columns, nullptr, k, 0.0, w.work, s);
    for (int a = 0; a < s.count; ++a) {
      to.sigma[a] = s.sigma[a];
      if (s.sigma[a] > 0.0)
        for (int r = 0; r < 3; ++r) to.axis[a][r] = s.left[a][r];
    }
  }
  for (int j = 0; j < k; ++j)
    for (int r = 0; r < kStride; ++r)
      w.columns[j * kStride + r] = r < m ? J[m * w.joint[j] + r] * rates[w.joint[j]] / least[settings.rows[r]] : 0.0;
  double weak[kRows * kStride];
  to.lost = weak_directions(m, w.columns, k, w.work, weak);
  for (int d = 0; d < to.lost; ++d) to_twist(settings, weak + kStride * d, least, to.direction[d]);
  for (int d = 0; d < to.lost; ++d)  // what is lost already is no matter of a joint any more
    for (int j = 0; j < k; ++j) {
      double along = 0.0;
      for (int r = 0; r < m; ++r) along = madd(weak[kStride * d + r], w.columns[j * kStride + r], along);
      for (int r = 0; r < m; ++r)
        w.columns[j * kStride + r] = madd(-along, weak[kStride * d + r], w.columns[j * kStride + r]);
    }
  for (int without = 0; without < k; ++without) {
    double own[kStride], others[kRows * kStride];
    for (int r = 0; r < kStride; ++r) {
      own[r] = w.columns[without * kStride + r];
      w.columns[without * kStride + r] = 0.0;
    }
    const int i = w.joint[without], found = weak_directions(m, w.columns, k, w.work, others);
    to.costs[i] = found > to.lost ? found - to.lost : 0;
    double best = 0.0;
    for (int d = 0; d < found && to.costs[i] > 0; ++d) {  // the one of them that the joint itself serves most
      double along = 0.0;
      for (int r = 0; r < m; ++r) along = madd(others[kStride * d + r], own[r], along);
      if (magnitude(along) <= best) continue;
      best = magnitude(along);
      to_twist(settings, others + kStride * d, least, to.cost + 6 * i);
    }
    for (int r = 0; r < kStride; ++r) w.columns[without * kStride + r] = own[r];
  }
  for (int j = 0; j < k; ++j)  // without rates: what the joints are worth does not depend on how fast they are
    for (int r = 0; r < kStride; ++r) w.columns[j * kStride + r] /= rates[w.joint[j]];
  if (k == 0) return;
  spectrum(m, w.columns, nullptr, k, 1e-10, w.work, s);
  for (int j = 0; j < k; ++j) w.other[j] = 0.0;
  for (int d = 0; d < s.rank; ++d) {
    apply_reflections(s, s.right[d], w.z);
    for (int j = 0; j < k; ++j) w.other[j] = madd(w.z[j], w.z[j], w.other[j]);
  }
  for (int j = 0; j < k; ++j) to.relative[w.joint[j]] = square_root(larger(1.0 - w.other[j], 0.0));
}

STILLREACH_END
