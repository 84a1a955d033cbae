// Many scenarios of one arm advanced together: each step a batch, and the joints moved along by what it answered.
#pragma once

#include "stillreach/batch/batch.hpp"

namespace stillreach {

// The batch says arm, law, task, bounds and limits; its q, twist, last and answers are set row block by row block here.
struct BatchRollout {
  Batch batch;
  const double* start;  // rows of n
  const double* twist;  // 6, per row and step as the strides say (0: the same for all)
  std::ptrdiff_t twist_row, twist_step;
  const double* last;  // rows of n: rates before the first step, or null for rest
  long steps;
  long every;  // record each so many steps
  double period;
  int runge_kutta;      // fourth order, the command held over a step; else Euler
  bool (*stop)(void*);  // asked before each step: true ends early
  void* context;
  // answers; null: not wanted. Records have steps / every (rounded up) entries a row, made before each recorded step
  double* q;                 // rows of records of n
  double* rates;             // rows of records of n
  double* task_error;        // rows of records
  std::int32_t* status;      // rows of records
  double* final_q;           // rows of n: after the last step
  double* final_rates;       // rows of n: of the last step
  double* worst_error;       // rows: largest task error on the way
  std::int32_t* any_status;  // rows: every bit that was up on the way
};

constexpr int kRolloutBlock = 64;

}  // namespace stillreach

STILLREACH_BEGIN

STILLREACH_INLINE std::size_t rollout_doubles(int n) { return kRolloutBlock * (6 * to_size(n) + 7); }

// The memory of one block: rows of n each, but twist (6) and error (1).
struct RolloutMemory {
  double *q, *rates, *last, *at, *mean, *stage, *twist, *error;
  std::int32_t status[kRolloutBlock];
};

inline RolloutMemory make_rollout_memory(int n, double* doubles) {
  RolloutMemory w;
  double** const vectors[] = {&w.q, &w.rates, &w.last, &w.at, &w.mean, &w.stage};
  for (double** v : vectors) {
    *v = doubles;
    doubles += kRolloutBlock * n;
  }
  w.twist = doubles;
  w.error = doubles + 6 * kRolloutBlock;
  return w;
}

inline void record_step(const BatchRollout& r, std::ptrdiff_t first, int count, long step, const RolloutMemory& w) {
  const int n = r.batch.arm.n;
  const long records = (r.steps + r.every - 1) / r.every, place = step / r.every;
  for (int row = 0; row < count; ++row) {
    const std::ptrdiff_t to = (first + row) * records + place;
    for (int i = 0; i < n; ++i) {
      if (r.q) r.q[to * n + i] = w.q[row * n + i];
      if (r.rates) r.rates[to * n + i] = w.rates[row * n + i];
    }
    if (r.task_error) r.task_error[to] = w.error[row];
    if (r.status) r.status[to] = w.status[row];
  }
}

// The later stages of fourth-order Runge-Kutta; w.mean receives the mean rates over the step.
inline void runge_kutta(const BatchRollout& r, Batch b, int count, BatchMemory& memory, RolloutMemory& w) {
  const int numbers = count * r.batch.arm.n;
  for (int i = 0; i < numbers; ++i) {
    w.stage[i] = w.rates[i];
    w.mean[i] = w.rates[i] / 6.0;
  }
  std::int32_t status[kRolloutBlock];
  b.q = w.at;
  b.rates = w.stage;
  b.status = status;
  b.task_error = nullptr;
  for (int s = 1; s < 4; ++s) {
    const double reach = s < 3 ? 0.5 * r.period : r.period, share = s < 3 ? 1.0 / 3.0 : 1.0 / 6.0;
    for (int i = 0; i < numbers; ++i) w.at[i] = madd(reach, w.stage[i], w.q[i]);
    solve_rows(b, 0, count, memory);
    for (int i = 0; i < numbers; ++i) w.mean[i] = madd(share, w.stage[i], w.mean[i]);
  }
}

// Rows first to last - 1, at most kRolloutBlock of them.
inline void rollout_rows(const BatchRollout& r, std::ptrdiff_t first, std::ptrdiff_t last, BatchMemory& memory,
                         RolloutMemory& w) {
  const int n = r.batch.arm.n, count = static_cast<int>(last - first);
  Batch b = r.batch;
  b.q = w.q;
  b.twist = w.twist;
  b.twist_stride = 6;
  b.rates = w.rates;
  b.status = w.status;
  b.task_error = w.error;
  b.lower += first * b.bounds_stride;
  b.upper += first * b.bounds_stride;
  if (b.acceleration) b.last = w.last;
  const std::size_t bytes = sizeof(double) * to_size(count * n);
  __builtin_memcpy(w.q, r.start + first * n, bytes);
  for (int i = 0; i < count * n; ++i) w.last[i] = r.last ? r.last[first * n + i] : 0.0;
  for (int row = 0; row < count; ++row) {
    if (r.worst_error) r.worst_error[first + row] = 0.0;
    if (r.any_status) r.any_status[first + row] = OK;
  }
  for (long step = 0; step < r.steps && !r.stop(r.context); ++step) {
    for (int row = 0; row < count; ++row)
      for (int i = 0; i < 6; ++i) w.twist[6 * row + i] = r.twist[(first + row) * r.twist_row + step * r.twist_step + i];
    solve_rows(b, 0, count, memory);
    if (step % r.every == 0) record_step(r, first, count, step, w);
    for (int row = 0; row < count; ++row) {
      if (r.worst_error && w.error[row] > r.worst_error[first + row]) r.worst_error[first + row] = w.error[row];
      if (r.any_status) r.any_status[first + row] |= w.status[row];
    }
    const double* mean = w.rates;
    if (r.runge_kutta) {
      runge_kutta(r, b, count, memory, w);
      mean = w.mean;
    }
    for (int i = 0; i < count * n; ++i) w.q[i] = madd(r.period, mean[i], w.q[i]);
    __builtin_memcpy(w.last, w.rates, bytes);
  }
  if (r.final_q) __builtin_memcpy(r.final_q + first * n, w.q, bytes);
  if (r.final_rates) __builtin_memcpy(r.final_rates + first * n, w.last, bytes);
}

STILLREACH_END
