// Reference rates for what the task leaves free: a posture, the middle of the position limits, away from singularities.
#pragma once

#include "stillreach/control/bounds.hpp"
#include "stillreach/kinematics/coupled.hpp"
#include "stillreach/kinematics/frames.hpp"
#include "stillreach/linear/inner.hpp"
#include "stillreach/problem/system.hpp"

STILLREACH_BEGIN

// Column j of the map from the task rows back to base axes: forces along the task rows become a 6-vector [f; t].
template <int M>
STILLREACH_INLINE void rows_to_base(Rows<M> m, const ControllerState& c, const double* task, double* base) {
  double v[6] = {0, 0, 0, 0, 0, 0};
  for (int r = 0; r < m(); ++r) v[c.rows[r]] = task[r];
  for (int h = 0; h < 6; h += 3)
    for (int i = 0; i < 3; ++i)
      base[h + i] =
          c.tool_axes ? madd(c.pose[i], v[h], madd(c.pose[3 + i], v[h + 1], c.pose[6 + i] * v[h + 2])) : v[h + i];
}

// Factor of J J' of the weighted columns of the joints that can move, which become w.columns and w.joint. without: one
// whose column counts as zero, or -1. Returns how many there are, or 0 where they do not span the task: there det(J J')
// is 0 in every pose.
template <int M>
inline int factor_columns(Rows<M> m, const ControllerState& c, Workspace& w, int without, Factor& f) {
  int k = 0;
  double size = 0.0;
  for (int i = 0; i < c.arm.n; ++i) {
    if (!(c.lower[i] < c.upper[i])) continue;
    double* column = w.columns + k * kStride;
    weighted_column(m, c.metric.rows, c.task_jacobian + i * m(), c.metric.columns ? c.metric.columns[i] : 1.0, column);
    for (int r = 0; r < kStride; ++r) column[r] = i == without ? 0.0 : column[r];
    for (int r = 0; r < kStride; ++r) size = larger(size, magnitude(column[r]));
    w.joint[k++] = i;
  }
  if (k - (without >= 0) < m() || !(size > 0.0 && size < 1e100)) return 0;
  gram(m, w.columns, nullptr, k, 1e-12 * size * size, f);  // at a singularity: a large finite gradient
  return factor(m, f) < infinity() ? k : 0;
}

// Gradient of ln sqrt(det(J J')) of the weighted task Jacobian over the working joints (Yoshikawa, 1985), analytically:
// d ln w / dq_k = sum_j (dJ_j / dq_k) . (J^+)_j, with dJ_j/dq_k = w_k x J_j for k <= j and [w_j x v_k; 0] for k > j, so
// that one suffix and one prefix sum give all n components. without: a joint whose column counts as zero, or -1.
template <int M>
inline void manipulability_gradient(Rows<M> m, const ControllerState& c, const double* q, Workspace& w,
                                    double* gradient, int without = -1) {
  double* force = c.scratch;  // 6 n: row j of J^+ in base axes
  for (int i = 0; i < c.arm.n; ++i) gradient[i] = 0.0;
  Factor f;
  const int k = factor_columns(m, c, w, without, f);
  if (k == 0) return;
  double total[3] = {0, 0, 0}, prefix[3] = {0, 0, 0};
  for (int j = 0; j < k; ++j) {
    const int i = w.joint[j];
    double y[kRows], weighted[kRows] = {0, 0, 0, 0, 0, 0};
    solve(m, f, w.columns + j * kStride, y);
    const double scale = c.metric.columns ? c.metric.columns[i] : 1.0;
    for (int r = 0; r < m(); ++r) {  // R' y, and the joint unit of the column that is differentiated
      if (!c.metric.rows) {
        weighted[r] = y[r] * scale;
        continue;
      }
      for (int s = r; s < m(); ++s) weighted[s] = madd(c.metric.rows[r * m() + s], y[r] * scale, weighted[s]);
    }
    rows_to_base(m, c, weighted, force + 6 * j);
    cross_add(c.jacobian + 6 * i, force + 6 * j, total);
    cross_add(c.jacobian + 6 * i + 3, force + 6 * j + 3, total);
  }
  if (c.arm.coupling) {
    const double none[3] = {0, 0, 0};
    return coupled_gradient(c.arm, q, c.pose + 9, force, w.joint, k, total, c.tool_axes ? total : none, gradient);
  }
  double suffix[3] = {total[0], total[1], total[2]};
  for (int j = 0; j < k; ++j) {  // suffix: over this joint and those after it; prefix: over those before
    const double* column = c.jacobian + 6 * w.joint[j];
    double along = dot3(column + 3, suffix) + dot3(column, prefix);
    if (c.tool_axes) along -= dot3(column + 3, total);
    gradient[w.joint[j]] = along;
    double own[3] = {0, 0, 0};
    cross_add(column, force + 6 * j, own);
    cross_add(column + 3, force + 6 * j + 3, own);
    for (int r = 0; r < 3; ++r) suffix[r] -= own[r];
    cross_add(force + 6 * j, column + 3, prefix);
  }
}

constexpr double kHopeless = 1e-3;  // relative manipulability that says more of the arm than of its posture
constexpr double kNearWorst = 1.8;  // joints up to this much above the worst have a part in the gradient

// Gradient of the logarithm of the worst relative manipulability: w(J without a joint) / w(J), of the joint whose loss
// leaves least. Joints that are nearly as bad have a part, by (worst / theirs)^8, so that the gradient does not jump
// where the worst joint changes; those that leave next to nothing in any posture have none.
template <int M>
inline void tolerance_gradient(Rows<M> m, const ControllerState& c, const double* q, Workspace& w, double* gradient) {
  const int n = c.arm.n;
  double *left = c.scratch + 6 * n, *whole = left + n, *one = whole + n;
  for (int i = 0; i < n; ++i) gradient[i] = left[i] = 0.0;
  Factor f;
  const int k = factor_columns(m, c, w, -1, f);
  if (k <= m()) return;  // no joint is spare
  double worst = infinity();
  for (int j = 0; j < k; ++j) {
    const double* column = w.columns + j * kStride;
    double y[kRows], used = 0.0;
    solve(m, f, column, y);
    for (int r = 0; r < m(); ++r) used = madd(column[r], y[r], used);
    const double r = square_root(larger(1.0 - used, 0.0));
    left[w.joint[j]] = r;
    if (r > kHopeless) worst = smaller(worst, r);
  }
  if (!(worst < infinity())) return;
  double total = 0.0;
  for (int i = 0; i < n; ++i) {
    const bool counts = left[i] > kHopeless && left[i] < kNearWorst * worst;
    const double two = (worst / left[i]) * (worst / left[i]), four = two * two;
    left[i] = counts ? four * four : 0.0;
    total += left[i];
  }
  manipulability_gradient(m, c, q, w, whole);
  for (int i = 0; i < n; ++i) {
    if (left[i] == 0.0) continue;
    manipulability_gradient(m, c, q, w, one, i);
    for (int a = 0; a < n; ++a) gradient[a] = madd(left[i] / total, one[a] - whole[a], gradient[a]);
  }
}

// A fixed pattern in [-1, 1] without a symmetry of its own: fractional parts of multiples of the golden ratio.
STILLREACH_INLINE double pattern(int i) {
  const double x = 0.6180339887498949 * (i + 1);
  return 2.0 * (x - static_cast<double>(static_cast<long long>(x))) - 1.0;
}

constexpr double kHalfTurn = 3.141592653589793;
constexpr double kSaddlePush = 1e-2;  // of the largest null rate: leaves exact saddles, where the gradient is 0

// The way of joint i to a posture: the short one where it may turn without end.
STILLREACH_INLINE double way_to(const ControllerState& c, int i, double straight) {
  const Range range = range_of(c, i);
  const bool endless = c.rotary && c.rotary[i] && range.lower == -infinity() && range.upper == infinity();
  return endless && magnitude(straight) > kHalfTurn ? STILLREACH_LIBRARY(remainder)(straight, 2.0 * kHalfTurn)
                                                    : straight;
}

// What the null motion asks of joint i; gradient: of what it climbs.
STILLREACH_INLINE double null_rate(const ControllerState& c, int i, const double* q, const double* gradient) {
  switch (c.null_kind) {
    case NullMotionKind::NONE: return 0.0;
    case NullMotionKind::RATES:
    case NullMotionKind::GRADIENT: return c.null_gain * c.null_vector[i];
    case NullMotionKind::POSTURE: return c.null_gain * way_to(c, i, c.null_vector[i] - q[i]);
    case NullMotionKind::CENTRING: {
      const Range range = range_of(c, i);
      return is_finite(range.lower) && is_finite(range.upper) ? c.null_gain * (0.5 * (range.lower + range.upper) - q[i])
                                                              : 0.0;
    }
    case NullMotionKind::MANIPULABILITY:
    case NullMotionKind::TOLERANCE: return c.null_gain * gradient[i];
  }
  return 0.0;
}

// The rates that the null motion asks for: at most null_largest each, by a common factor.
template <int M>
inline void null_motion(Rows<M> m, const ControllerState& c, const double* q, Workspace& w, double* rates) {
  const int n = c.arm.n;
  const bool tolerance = c.null_kind == NullMotionKind::TOLERANCE;
  const bool climbs = tolerance || c.null_kind == NullMotionKind::MANIPULABILITY;
  if (tolerance) tolerance_gradient(m, c, q, w, rates);
  if (climbs && !tolerance) manipulability_gradient(m, c, q, w, rates);
  for (int i = 0; i < n; ++i) {
    const double v = null_rate(c, i, q, rates);
    rates[i] = is_finite(v) ? v : 0.0;
  }
  if (climbs && c.null_largest < infinity())
    for (int i = 0; i < n; ++i)
      if (c.lower[i] < c.upper[i]) rates[i] += kSaddlePush * c.null_largest * pattern(i);
  double largest = 0.0;
  for (int i = 0; i < n; ++i)
    if (c.lower[i] < c.upper[i]) largest = larger(largest, magnitude(rates[i]));
  if (largest > c.null_largest)
    for (int i = 0; i < n; ++i) rates[i] *= c.null_largest / largest;
}

STILLREACH_END
