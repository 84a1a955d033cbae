// Kinematics of many configurations of one arm: poses and Jacobians, kLanes at a time, and the singular
// values of a task's Jacobian, each row by itself. A row's answer depends on nothing but the row.
#pragma once

#include "stillreach/kinematics/coupled.hpp"
#include "stillreach/kinematics/frames.hpp"
#include "stillreach/kinematics/lane_kinematics.hpp"
#include "stillreach/linear/spectrum.hpp"
#include "stillreach/problem/system.hpp"

namespace stillreach {

// What a call is about. Null pointers mean: not asked for.
struct KinematicsBatch {
  ArmView arm;
  const double* q;          // rows of n
  double* pose;             // rows of 4 x 4, row-major
  double* jacobian;         // rows of 6 x n, row-major
  double* singular_values;  // rows of min(m, count), falling
  double* manipulability;   // rows: their product; 0 where count < m
  // of which Jacobian the singular values are
  Metric metric;  // of m rows and n joints
  int m;
  int rows[6];        // of [v; w]
  int tool_axes;      // along the tool's axes
  const int* joints;  // those that count, `count` of them
  int count;
};

}  // namespace stillreach

STILLREACH_BEGIN

// What one thread needs; doubles on a 64-byte boundary.
STILLREACH_INLINE std::size_t kinematics_doubles(int n, int count, bool full) {
  const std::size_t k = to_size(count);
  return kLanes * (15 * to_size(n) + 16) + (kStride + kRows) * k + (full ? k * k : 0);
}

// Singular values of the weighted columns, and their product. columns: (kStride + kRows) count numbers, and behind them
// the factor of a full joint weight.
inline void singular_values(const KinematicsBatch& b, double* columns, double* sigma, double& product) {
  const int k = b.count, most = b.m < k ? b.m : k;
  double *work = columns + kStride * k, total = 0.0;
  const double* weight = work + kRows * k;
  if (b.metric.joints) solve_triangle(k, weight, false, kStride, columns);
  for (int j = 0; j < kStride * k; ++j) total += magnitude(columns[j]);
  const double unit = is_finite(total) ? scaling_unit(total) : 1.0;
  if (unit != 1.0)
    for (int j = 0; j < kStride * k; ++j) columns[j] /= unit;
  Spectrum s;
  spectrum(b.m, columns, nullptr, k, 0.0, work, s);
  product = k < b.m ? 0.0 : 1.0;
  for (int j = 0; j < most; ++j) {
    sigma[j] = is_finite(total) ? s.sigma[j] * unit : __builtin_nan("");
    product *= sigma[j];
  }
}

// The columns of lane l's Jacobian as the task sees them.
inline void task_columns(const KinematicsBatch& b, const Wide* pose, const Wide* jacobian, int l, double* columns) {
  double frame[12], base[6], task[kRows];
  for (int r = 0; r < 12; ++r) frame[r] = pose[r][l];
  for (int j = 0; j < b.count; ++j) {
    const int i = b.joints[j];
    for (int r = 0; r < 6; ++r) base[r] = jacobian[6 * i + r][l];
    select_rows(b, frame, base, task);
    weighted_column(Rows<0>{b.m}, b.metric.rows, task, b.metric.columns ? b.metric.columns[i] : 1.0,
                    columns + kStride * j);
  }
}

// Rows first to last - 1.
inline void kinematics_rows(const KinematicsBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles) {
  const int n = b.arm.n, most = b.m < b.count ? b.m : b.count;
  Wide* q = static_cast<Wide*>(static_cast<void*>(doubles));
  Wide *jacobian = q + n, *scratch = jacobian + 6 * n, *ordered = scratch + 2 * n, pose[12];
  double *columns = doubles + kLanes * (15 * to_size(n) + 16), sigma[kRows], product, *to[kLanes];
  const bool spectra = b.singular_values || b.manipulability;
  if (spectra && b.metric.joints)
    factor_weight(n, b.metric.joints, b.joints, b.count, columns + (kStride + kRows) * b.count);
  for (std::ptrdiff_t at = first; at < last; at += kLanes) {
    const int here = last - at < kLanes ? static_cast<int>(last - at) : kLanes;
    const double* from[kLanes];
    for (int l = 0; l < kLanes; ++l) from[l] = b.q + (at + (l < here ? l : 0)) * n;
    load_lanes(from, n, q);
    arm_kinematics(b.arm, static_cast<const Wide*>(q), scratch, pose, b.jacobian || spectra ? jacobian : nullptr);
    const auto write = [&](double* base, int length) {
      for (int l = 0; l < kLanes; ++l) to[l] = base + (at + (l < here ? l : 0)) * length;
      store_lanes(ordered, length, (1 << here) - 1, to);
    };
    if (b.pose) {
      for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) ordered[4 * r + c] = r < 3 ? pose[3 * c + r] : wide(c == 3 ? 1.0 : 0.0);
      write(b.pose, 16);
    }
    if (b.jacobian) {
      for (int r = 0; r < 6; ++r)
        for (int i = 0; i < n; ++i) ordered[r * n + i] = jacobian[6 * i + r];
      write(b.jacobian, 6 * n);
    }
    for (int l = 0; spectra && l < here; ++l) {
      task_columns(b, pose, jacobian, l, columns);
      singular_values(b, columns, sigma, product);
      for (int j = 0; b.singular_values && j < most; ++j) b.singular_values[(at + l) * most + j] = sigma[j];
      if (b.manipulability) b.manipulability[at + l] = product;
    }
  }
}

STILLREACH_END
