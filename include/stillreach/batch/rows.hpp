// A batch: what a call is about, what a thread needs for it, and its rows one by one, with the single tick's code.
#pragma once

#include "stillreach/batch/lane_laws.hpp"
#include "stillreach/control/bounds.hpp"
#include "stillreach/control/tracking.hpp"
#include "stillreach/kinematics/coupled.hpp"
#include "stillreach/kinematics/frames.hpp"
#include "stillreach/laws/law.hpp"

namespace stillreach {

// What a batch call is about. Null pointers mean: not given, not asked for. A stride of 0 shares one row with all.
struct Batch {
  ArmView arm;  // n alone where Jacobians are given
  int m;
  int rows[6];               // of [v; w] that the task looks at
  int every_row, tool_axes;  // rows are all six along base axes; along the tool's axes
  LawSettings law;
  Metric metric;
  const double* q;          // rows of n
  const double* jacobians;  // rows of m x n, row-major
  const double* twist;      // rows of 6, or of m with Jacobians
  const double* target;     // rows of 12, poses: the twist is the whole error of the pose. Null: twists are given
  const double* lower;      // rows of n
  const double* upper;
  const double* reference;  // rows of n
  std::ptrdiff_t twist_stride, bounds_stride, reference_stride;
  // limits that depend on where a joint is and how it moved last (see bounds.hpp)
  const double* position_lower;  // n
  const double* position_upper;
  const double* acceleration;  // n
  const double* last;          // rows of n
  double period;
  // answers
  double* rates;         // rows of n
  std::int32_t* status;  // rows
  double* residual;      // rows of m
  double* damping;       // rows, and so on
  double* scale;
  double* task_error;
  double* pose;         // rows of 4 x 4, row-major
  double* jacobian;     // rows of m x n, row-major
  std::int8_t* active;  // rows of n, Reason, negative at the lower bound
  std::int32_t* iterations;
  double* error;  // rows of 6, with targets: the m task rows of the pose error
};

}  // namespace stillreach

STILLREACH_BEGIN

constexpr int kBlock = 256;  // rows that are worked on together

// What one thread needs.
struct BatchMemory {
  Workspace workspace;  // of the single tick
  Wide *q, *jacobian, *task_jacobian, *lower, *upper, *rates, *residual;
  LaneSystem system;
  double typical;      // typical_rate() of shared bounds
  double* single;      // 32 n + 64 numbers for rows that are solved alone
  std::int8_t* bytes;  // 3 n
};

STILLREACH_INLINE std::size_t batch_packs(int n) { return (4 + 12 + 2 * 6 + 16) * to_size(n) + 36; }
STILLREACH_INLINE std::size_t batch_doubles(int n, bool full) {
  return kLanes * batch_packs(n) + 32 * to_size(n) + 64 + workspace_doubles(n, full);
}
STILLREACH_INLINE std::size_t batch_ints(int n) { return workspace_ints(n) + to_size(n); }
STILLREACH_INLINE std::size_t batch_bytes(int n) { return workspace_bytes(n) + 3 * to_size(n); }

// doubles: on a 64-byte boundary.
inline BatchMemory make_batch_memory(int n, bool full, double* doubles, int* ints, std::int8_t* bytes) {
  BatchMemory b;
  Wide* at = static_cast<Wide*>(static_cast<void*>(doubles));
  const auto take = [&at](int count) {
    Wide* p = at;
    at += count;
    return p;
  };
  b.q = take(n);
  b.lower = take(n);
  b.upper = take(n);
  b.rates = take(n);
  b.residual = take(6);
  b.jacobian = take(6 * n);
  b.task_jacobian = take(6 * n);
  LaneSystem& s = b.system;
  s.columns = take(6 * n);
  s.shapes = take(6 * n);
  s.few = take(30);
  s.scale = take(n);
  s.limit = take(n);
  s.z = take(n);
  Wide** const vectors[] = {&s.top,    &s.bottom, &s.lower,    &s.upper, &s.length,
                            &s.answer, &s.trial,  &s.releases, &s.side};
  for (Wide** v : vectors) *v = take(n);
  s.works = static_cast<Lanes*>(static_cast<void*>(take(n)));
  s.outside = static_cast<Lanes*>(static_cast<void*>(take(n)));
  s.column = static_cast<const Wide**>(static_cast<void*>(take(n)));
  s.masked_column = static_cast<const Wide**>(static_cast<void*>(take(n)));
  b.single = doubles + kLanes * batch_packs(n);
  b.workspace = make_workspace(n, full, b.single + 32 * to_size(n) + 64, ints, bytes);
  s.joint = ints + workspace_ints(n);
  b.bytes = bytes + workspace_bytes(n);
  return b;
}

// Whether there is a rate within these bounds.
STILLREACH_INLINE bool leaves_room(double low, double high) {
  return low <= high && low < infinity() && high > -infinity();
}

// One row's bounds with position limits and acceleration window, as a controller's tick makes them. to: 2 n numbers.
// bytes: 2 n, which receive the reasons of lower and upper bounds.
struct LimitedStatus {
  std::int32_t bounds;
  bool runaway;
  std::int32_t with(std::int32_t law) const {  // a window that leaves one rate is no fault
    return with_bounds_status(runaway ? law : law & ~FAULT_NOT_COMPENSATED, bounds);
  }
};
inline LimitedStatus limited_bounds(const Batch& b, std::ptrdiff_t row, double* to, std::int8_t* bytes) {
  const int n = b.arm.n;
  const double *low = b.lower + row * b.bounds_stride, *high = b.upper + row * b.bounds_stride;
  Settings s{};
  s.period = b.period;
  s.position_lower = b.position_lower;
  s.position_upper = b.position_upper;
  s.acceleration = b.acceleration;
  s.rate_lower = low;
  s.rate_upper = high;
  LastTick last{};
  last.rates = const_cast<double*>(b.last + row * n);
  const RateBounds bounds{to, to + n, bytes, bytes + n};
  std::int32_t status = OK;
  bool runaway = false;
  for (int i = 0; i < n; ++i) {
    const bool free = low[i] < high[i];
    runaway |= !free && low[i] != 0.0;
    status |= limit_joint(s, free ? Fault{} : Fault{Health::RUNAWAY, {low[i], 0.0}}, last, i, b.q[row * n + i], bounds);
    if (!leaves_room(low[i], high[i])) to[i] = infinity();  // limits may not make an answer of what is no question
  }
  return {status, runaway};
}

// Invalid rows: NaN or infinite inputs, or contradictory bounds.
inline bool answerable(const Batch& b, std::ptrdiff_t row) {
  const int n = b.arm.n;
  double doubt = 0.0;
  if (b.q)
    for (int i = 0; i < n; ++i) doubt += b.q[row * n + i] - b.q[row * n + i];
  else
    for (int i = 0; i < b.m * n; ++i) doubt += b.jacobians[row * b.m * n + i] - b.jacobians[row * b.m * n + i];
  if (!b.target) {
    const double* twist = b.twist + row * b.twist_stride;
    for (int r = 0; r < (b.q ? 6 : b.m); ++r) doubt += twist[r] - twist[r];
  }
  if (b.reference)
    for (int i = 0; i < n; ++i)
      doubt += b.reference[row * b.reference_stride + i] - b.reference[row * b.reference_stride + i];
  if (b.last)
    for (int i = 0; i < n; ++i) doubt += b.last[row * n + i] - b.last[row * n + i];
  const double *low = b.lower + row * b.bounds_stride, *high = b.upper + row * b.bounds_stride;
  bool room = true;
  for (int i = 0; i < n; ++i) room &= leaves_room(low[i], high[i]);
  return doubt == 0.0 && room;
}

inline void write_single(const Batch& b, std::ptrdiff_t row, const Answer& out) {
  const int n = b.arm.n;
  b.status[row] = out.status;
  for (int i = 0; i < n; ++i) b.rates[row * n + i] = out.rates[i];
  if (b.residual)
    for (int r = 0; r < b.m; ++r) b.residual[row * b.m + r] = out.residual[r];
  if (b.damping) b.damping[row] = out.damping;
  if (b.scale) b.scale[row] = out.scale;
  if (b.task_error) b.task_error[row] = out.task_error;
  if (b.active)
    for (int i = 0; i < n; ++i) b.active[row * n + i] = out.active[i];
  if (b.iterations) b.iterations[row] = out.iterations;
}

// The result of an invalid row: rates of 0, or the nearest values inside the bounds.
inline void write_invalid(const Batch& b, std::ptrdiff_t row, double* rates, std::int8_t* active) {
  const int n = b.arm.n;
  const double *low = b.lower + row * b.bounds_stride, *high = b.upper + row * b.bounds_stride;
  double residual[kRows] = {0, 0, 0, 0, 0, 0};
  for (int i = 0; i < n; ++i) {
    const bool room = leaves_room(low[i], high[i]);
    rates[i] = room ? clamp(0.0, low[i], high[i]) : 0.0;
    active[i] = code(room && low[i] == high[i] ? Reason::FAULT : Reason::FREE);
  }
  write_single(b, row, Answer{rates, residual, active, INVALID_INPUT, 0, 0.0, 0.0, 0.0});
  const double nothing[12] = {};
  if (b.pose) {
    write_pose(nothing, b.pose + 16 * row);
    b.pose[16 * row + 15] = 0.0;
  }
  if (b.jacobian)
    for (int i = 0; i < b.m * n; ++i) b.jacobian[row * b.m * n + i] = 0.0;
}

// What the rates of a row are worth: by its bounds, before position and acceleration limits narrow them.
inline double row_typical(const Batch& b, std::ptrdiff_t row) {
  return typical_rate(b.arm.n, b.lower + row * b.bounds_stride, b.upper + row * b.bounds_stride, b.metric);
}

// A row with the single tick's code.
inline STILLREACH_NOINLINE void solve_alone(const Batch& b, std::ptrdiff_t row, BatchMemory& w) {
  const int n = b.arm.n, m = b.m;
  double *rates = w.single, *bounds = rates + n, *scratch = bounds + 2 * n, *jacobian = scratch + 10 * n,
         *task = jacobian + 6 * n;
  double *twist = task + 6 * n, *residual = twist + 6, *pose = residual + 6;
  std::int8_t* active = w.bytes;
  if (!answerable(b, row)) return write_invalid(b, row, rates, active);
  const double* asked = b.twist + row * b.twist_stride;
  double error[6];
  if (b.q) {
    arm_kinematics(b.arm, b.q + row * n, scratch, pose, jacobian);
    if (b.target) {
      pose_error(b.target + 12 * row, pose, error);
      asked = error;
    }
    if (b.every_row) {
      task = jacobian;
      for (int r = 0; r < 6; ++r) twist[r] = asked[r];
    } else {
      for (int i = 0; i < n; ++i) select_rows(b, pose, jacobian + 6 * i, task + m * i);
      select_rows(b, pose, asked, twist);
    }
    if (b.pose) write_pose(pose, b.pose + 16 * row);
    if (b.target)
      for (int r = 0; r < m; ++r) b.error[6 * row + r] = twist[r];
  } else {
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < m; ++r) task[m * i + r] = b.jacobians[(row * m + r) * n + i];
    for (int r = 0; r < m; ++r) twist[r] = asked[r];
  }
  if (b.jacobian)
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < m; ++r) b.jacobian[(row * m + r) * n + i] = task[m * i + r];
  const double *low = b.lower + row * b.bounds_stride, *high = b.upper + row * b.bounds_stride;
  LimitedStatus limited{OK, true};
  if (b.acceleration) {
    limited = limited_bounds(b, row, bounds, w.bytes + n);
    low = bounds;
    high = bounds + n;
  }
  for (int i = 0; i < n; ++i) active[i] = 0;
  const Problem p{m,
                  n,
                  task,
                  twist,
                  low,
                  high,
                  b.reference ? b.reference + row * b.reference_stride : nullptr,
                  b.metric,
                  row_typical(b, row)};
  Answer out{rates, residual, active, OK, 0, 0.0, 1.0, 0.0};
  solve_law(b.law, p, w.workspace, out);
  out.status = limited.with(out.status);
  for (int i = 0; i < n; ++i)
    active[i] = b.acceleration ? active_reason(active[i], w.bytes[n + i], w.bytes[2 * n + i]) : bound_reason(active[i]);
  write_single(b, row, out);
}

STILLREACH_END
