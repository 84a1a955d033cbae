// Manipulability of the joints that can move, and its gradient: the derivative of the Jacobian, applied.
#pragma once

#include "stillreach/control/bounds.hpp"
#include "stillreach/kinematics/coupled.hpp"
#include "stillreach/kinematics/frames.hpp"
#include "stillreach/linear/inner.hpp"
#include "stillreach/problem/system.hpp"

STILLREACH_BEGIN

// Columns R J_i, in the joints' units where `units` says so, of the joints that can move: they become w.columns and
// w.joint, and `size` their largest entry. Returns how many there are, or 0 where they do not span the task in any
// pose.
template <int M>
inline int moving_columns(Rows<M> m, const Settings& settings, const ThisTick& now, Workspace& w, bool units,
                          double& size) {
  const double* const J = task_jacobian(settings, now);
  int k = 0;
  size = 0.0;
  for (int i = 0; i < settings.arm.n; ++i) {
    if (!(now.bounds.lower[i] < now.bounds.upper[i])) continue;
    double* column = w.columns + k * kStride;
    const double unit = units && settings.metric.columns ? settings.metric.columns[i] : 1.0;
    weighted_column(m, settings.metric.rows, J + i * m(), unit, column);
    for (int r = 0; r < kStride; ++r) size = larger(size, magnitude(column[r]));
    w.joint[k++] = i;
  }
  return k >= m() && size > 0.0 && size < 1e100 ? k : 0;
}

// What a column of the task Jacobian is multiplied with where the weighted one, R times it, is multiplied with `y`: a
// 6-vector [f; t] along base axes.
template <int M>
STILLREACH_INLINE void to_base(Rows<M> m, const Settings& settings, const double* pose, const double* y, double scale,
                               double* base) {
  double weighted[kRows] = {0, 0, 0, 0, 0, 0}, v[6] = {0, 0, 0, 0, 0, 0};
  for (int r = 0; r < m(); ++r) {  // R' y
    if (!settings.metric.rows) {
      weighted[r] = y[r] * scale;
      continue;
    }
    for (int s = r; s < m(); ++s) weighted[s] = madd(settings.metric.rows[r * m() + s], y[r] * scale, weighted[s]);
  }
  for (int r = 0; r < m(); ++r) v[settings.rows[r]] = weighted[r];
  for (int h = 0; h < 6; h += 3)
    for (int i = 0; i < 3; ++i)
      base[h + i] =
          settings.tool_axes ? madd(pose[i], v[h], madd(pose[3 + i], v[h + 1], pose[6 + i] * v[h + 2])) : v[h + i];
}

// The derivatives along all q of a number of which `force` (6 each, base axes) are those along the columns J_j of the k
// joints w.joint: dJ_j/dq_i = w_i x J_j for i <= j and [w_j x v_i; 0] for i > j, so that one suffix and one prefix sum
// give all n.
inline void along_joints(const Settings& settings, const ThisTick& now, const double* q, const Workspace& w, int k,
                         const double* force, double* gradient) {
  double total[3] = {0, 0, 0}, prefix[3] = {0, 0, 0};
  for (int j = 0; j < k; ++j) {
    cross_add(now.jacobian + 6 * w.joint[j], force + 6 * j, total);
    cross_add(now.jacobian + 6 * w.joint[j] + 3, force + 6 * j + 3, total);
  }
  if (settings.arm.coupling) {
    const double none[3] = {0, 0, 0};
    return coupled_gradient(settings.arm, q, now.pose + 9, force, w.joint, k, total, settings.tool_axes ? total : none,
                            gradient);
  }
  double suffix[3] = {total[0], total[1], total[2]};
  for (int j = 0; j < k; ++j) {  // suffix: over this joint and those after it; prefix: over those before
    const double* column = now.jacobian + 6 * w.joint[j];
    double along = dot3(column + 3, suffix) + dot3(column, prefix);
    if (settings.tool_axes) along -= dot3(column + 3, total);
    gradient[w.joint[j]] = along;
    double own[3] = {0, 0, 0};
    cross_add(column, force + 6 * j, own);
    cross_add(column + 3, force + 6 * j + 3, own);
    for (int r = 0; r < 3; ++r) suffix[r] -= own[r];
    cross_add(force + 6 * j, column + 3, prefix);
  }
}

// Gradient of ln sqrt(det(J J')) of the weighted task Jacobian over the working joints (Yoshikawa, 1985), analytically:
// d ln w / dq_i = sum_j (dJ_j / dq_i) . (J^+)_j. It is 0 at first.
template <int M>
inline void manipulability_gradient(Rows<M> m, const Settings& settings, const ThisTick& now, const double* q,
                                    Workspace& w, double* gradient) {
  double* force = now.scratch;  // 6 n: row j of J^+ in base axes
  double size;
  const int k = moving_columns(m, settings, now, w, true, size);
  if (k == 0) return;
  Factor f;
  gram(m, w.columns, nullptr, k, 1e-12 * size * size, f);  // at a singularity: a large finite gradient
  if (!(factor(m, f) < infinity())) return;
  for (int j = 0; j < k; ++j) {
    double y[kRows];
    solve(m, f, w.columns + j * kStride, y);
    to_base(m, settings, now.pose, y, settings.metric.columns ? settings.metric.columns[w.joint[j]] : 1.0,
            force + 6 * j);
  }
  along_joints(settings, now, q, w, k, force, gradient);
}

STILLREACH_END
