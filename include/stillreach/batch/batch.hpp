// Many problems of one arm: N rows of configurations (or Jacobians), twists and bounds. Rows are taken kLanes at a
// time; those that need more than the ordinary way are gathered, kLanes of them again, and what still remains
// is solved alone. A row's answer depends on nothing but the row.
#pragma once

#include "stillreach/batch/lane_laws.hpp"
#include "stillreach/batch/rows.hpp"
#include "stillreach/kinematics/coupled.hpp"
#include "stillreach/kinematics/lane_kinematics.hpp"

STILLREACH_BEGIN

inline void write_poses(const Wide* pose, int lanes, const std::ptrdiff_t* row, double* to) {
  for (int l = 0; l < kLanes; ++l) {
    if (!(lanes & 1 << l)) continue;
    double one[12];
    for (int r = 0; r < 12; ++r) one[r] = pose[r][l];
    write_pose(one, to + 16 * row[l]);
  }
}

// What is asked for more rarely.
template <int M>
inline void write_more(const Batch& b, const std::ptrdiff_t* row, int lanes, const LaneProblem& p,
                       const LaneAnswer& out, BatchMemory& w) {
  const int n = p.n;
  for (int l = 0; l < kLanes; ++l) {
    if (!(lanes & 1 << l)) continue;
    if (b.active && b.acceleration) limited_bounds(b, row[l], w.single, w.bytes);  // again, for the reasons
    if (b.iterations) b.iterations[row[l]] = static_cast<std::int32_t>(out.iterations[l]);
    for (int i = 0; i < n; ++i) {
      if (b.jacobian)
        for (int r = 0; r < M; ++r) b.jacobian[(row[l] * M + r) * n + i] = p.jacobian[M * i + r][l];
      if (!b.active) continue;
      const double rate = out.rates[i][l], lower = p.lower[i][l], upper = p.upper[i][l];
      const std::int8_t met = bound_code(rate, lower, upper);
      b.active[row[l] * n + i] = b.acceleration ? active_reason(met, w.bytes[i], w.bytes[n + i]) : bound_reason(met);
    }
  }
}

// The twists of rows with targets.
template <int M>
inline void lane_errors(const Batch& b, const std::ptrdiff_t* row, const Wide* pose, Wide* twist) {
  for (int l = 0; l < kLanes; ++l) {
    double at[12], error[6];
    for (int r = 0; r < 12; ++r) at[r] = pose[r][l];
    pose_error(b.target + 12 * row[l], at, error);
    for (int r = 0; r < 6; ++r) twist[r][l] = error[r];
    for (int r = 0; r < M; ++r) b.error[6 * row[l] + r] = error[b.rows[r]];
  }
}

// One row a lane; lanes: bits of those that are wanted. Returns the bits of those that were answered.
template <int M>
inline int lane_pass(const Batch& b, const std::ptrdiff_t* row, int lanes, bool deep, BatchMemory& w) {
  const int n = b.arm.n;
  const double *from[kLanes], *low[kLanes], *high[kLanes];
  Wide twist[6], pose[12], doubt = wide(0.0);
  const auto point = [&](const double* base, std::ptrdiff_t stride) {
    for (int l = 0; l < kLanes; ++l) from[l] = base + row[l] * stride;
  };
  if (!b.target) {
    point(b.twist, b.twist_stride);
    load_lanes(from, b.q ? 6 : M, twist);
    for (int r = 0; r < (b.q ? 6 : M); ++r) doubt += twist[r] - twist[r];
  }
  LaneProblem p{n, w.jacobian, twist, w.lower, w.upper, b.metric};
  if (b.law.parts > 0) {
    p.typical = wide(w.typical);
    for (int l = 0; b.bounds_stride != 0 && l < kLanes; ++l) p.typical[l] = row_typical(b, row[l]);
  }
  if (b.q) {
    point(b.q, n);
    load_lanes(from, n, w.q);
    arm_kinematics(b.arm, static_cast<const Wide*>(w.q), w.system.shapes, pose, w.jacobian);  // shapes: free until then
    for (int r = 9; r < 12; ++r) doubt += pose[r] - pose[r];                                  // a NaN in q ends up here
    if (b.target) lane_errors<M>(b, row, pose, twist);
    if (!b.every_row) {
      for (int i = 0; i < n; ++i)
        for (int r = 0; r < M; ++r) w.task_jacobian[M * i + r] = w.jacobian[6 * i + b.rows[r]];
      p.jacobian = w.task_jacobian;
      Wide all[6];
      for (int r = 0; r < 6; ++r) all[r] = twist[r];
      for (int r = 0; r < M; ++r) twist[r] = all[b.rows[r]];
    }
  } else {
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < M; ++r) {
        for (int l = 0; l < kLanes; ++l) w.jacobian[M * i + r][l] = b.jacobians[(row[l] * M + r) * n + i];
        doubt += w.jacobian[M * i + r] - w.jacobian[M * i + r];
      }
  }
  LimitedStatus limited[kLanes];
  if (b.acceleration) {
    for (int l = 0; l < kLanes; ++l) {
      double* to = w.single + 2 * n * l;
      low[l] = to;
      high[l] = to + n;
      limited[l] = limited_bounds(b, row[l], to, w.bytes);
      for (int i = 0; i < n; ++i) doubt[l] += b.last[row[l] * n + i] - b.last[row[l] * n + i];
    }
  } else if (b.bounds_stride != 0) {
    for (int l = 0; l < kLanes; ++l) {
      low[l] = b.lower + row[l] * b.bounds_stride;
      high[l] = b.upper + row[l] * b.bounds_stride;
    }
  }
  Lanes good = doubt == wide(0.0);
  if (b.acceleration || b.bounds_stride != 0) {
    load_lanes(low, n, w.lower);
    load_lanes(high, n, w.upper);
    for (int i = 0; i < n; ++i)
      good &= (w.lower[i] <= w.upper[i]) & (w.lower[i] < wide(infinity())) & (w.upper[i] > wide(-infinity()));
    prepare_lanes(b.law, p, w.system, w.rates);
  }
  LaneAnswer out;
  out.rates = w.rates;
  out.residual = w.residual;
  good &= solve_lanes<M>(b.law, p, deep, b.residual || b.task_error, w.system, out);
  const int answered = bits_of(good) & lanes;
  if (!answered) return 0;
  double* to[kLanes];
  const auto write = [&](double* base, int count, const Wide* values) {
    for (int l = 0; l < kLanes; ++l) to[l] = base + row[l] * count;
    store_lanes(values, count, answered, to);
  };
  write(b.rates, n, out.rates);
  alignas(64) long long status[kLanes];
  __builtin_memcpy(status, &out.status, sizeof status);
  for (int l = 0; l < kLanes; ++l)
    if (answered & 1 << l) {
      const std::int32_t own = static_cast<std::int32_t>(status[l]);
      b.status[row[l]] = b.acceleration ? limited[l].with(own) : own;
    }
  if (b.residual) write(b.residual, M, out.residual);
  if (b.damping) write(b.damping, 1, &out.damping);
  if (b.scale) write(b.scale, 1, &out.scale);
  if (b.task_error) write(b.task_error, 1, &out.task_error);
  if (b.pose) write_poses(pose, answered, row, b.pose);
  if (b.jacobian || b.active || b.iterations) write_more<M>(b, row, answered, p, out, w);
  return answered;
}

// The rows that are left, kLanes at a time, then alone.
template <int M>
inline void solve_left(const Batch& b, std::ptrdiff_t* left, int count, BatchMemory& w) {
  for (int at = 0; at < count; at += kLanes) {
    const int here = count - at < kLanes ? count - at : kLanes;
    if (here == 1) return solve_alone(b, left[at], w);
    std::ptrdiff_t row[kLanes];
    for (int l = 0; l < kLanes; ++l) row[l] = left[at + (l < here ? l : 0)];
    const int answered = lane_pass<M>(b, row, (1 << here) - 1, true, w);
    for (int l = 0; l < here; ++l)
      if (!(answered & 1 << l)) solve_alone(b, row[l], w);
  }
}

template <int M>
inline void solve_lane_rows(const Batch& b, std::ptrdiff_t first, std::ptrdiff_t last, BatchMemory& w) {
  std::ptrdiff_t left[kBlock];
  int count = 0;
  for (std::ptrdiff_t at = first; at < last; at += kLanes) {
    const int here = last - at < kLanes ? static_cast<int>(last - at) : kLanes;
    if (here == 1) {  // sooner than in lanes that are empty
      solve_alone(b, at, w);
      break;
    }
    std::ptrdiff_t row[kLanes];
    for (int l = 0; l < kLanes; ++l) row[l] = at + (l < here ? l : 0);
    const int answered = lane_pass<M>(b, row, (1 << here) - 1, false, w);
    for (int l = 0; l < here; ++l)
      if (!(answered & 1 << l)) left[count++] = row[l];
    if (count > kBlock - kLanes) solve_left<M>(b, left, count, w), count = 0;
  }
  solve_left<M>(b, left, count, w);
}

inline bool bounds_leave_room(const Batch& b) {
  for (int i = 0; i < b.arm.n; ++i)
    if (!leaves_room(b.lower[i], b.upper[i])) return false;
  return true;
}

// Rows first to last - 1.
inline void solve_rows(const Batch& b, std::ptrdiff_t first, std::ptrdiff_t last, BatchMemory& w) {
  const bool shared = b.bounds_stride == 0;
  if (shared && b.law.parts > 0) w.typical = row_typical(b, 0);
  if (suits_lanes(b.law.kind, b.arm.n, b.m, b.metric) && !b.tool_axes && !b.reference &&
      (!shared || bounds_leave_room(b))) {
    if (shared && !b.acceleration) {
      for (int i = 0; i < b.arm.n; ++i) {
        w.lower[i] = wide(b.lower[i]);
        w.upper[i] = wide(b.upper[i]);
      }
      prepare_lanes(b.law, LaneProblem{b.arm.n, nullptr, nullptr, w.lower, w.upper, b.metric}, w.system, w.rates);
    }
    return b.m == 6 ? solve_lane_rows<6>(b, first, last, w) : solve_lane_rows<3>(b, first, last, w);
  }
  for (std::ptrdiff_t row = first; row < last; ++row) solve_alone(b, row, w);
}

STILLREACH_END
