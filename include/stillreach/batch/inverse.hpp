// Inverse kinematics: configurations that bring the tool to given poses, joints that stand still included. Each row
// takes Gauss-Newton steps, a batch's solution inside the position limits and a trust region, from one start after the
// other. A row that ends makes room for the next. A row's answer depends on nothing but the row.
#pragma once

#include "stillreach/batch/batch.hpp"

namespace stillreach {

// Where a joint is held.
enum class Hold : std::int8_t { FREE, AT_START, AT_VALUE };

// The batch says arm, law, task and metric; the rest of it is set row by row here. Null: not given.
struct Inverse {
  Batch batch;
  const double* target;             // rows of 12, as read_pose() gives them
  const double* start;              // rows of n: where the first search begins, or null: at random
  std::ptrdiff_t start_stride;      // 0: all rows share it
  const double *lower, *upper;      // n: position limits
  const double *low_start, *range;  // n: random starts are low + [0, 1) range
  const double* step;               // n: the largest step of a joint
  const std::int8_t* turns;         // n: 1 where a whole turn leads back to the same pose, and there are no limits
  const Hold* hold;                 // n
  const double* values;             // rows of n: positions of joints that are held at values; start s takes row s
  int choices;                      // rows of values, taken in turns
  const std::int32_t* starts;       // rows: most starts
  int steps;                        // most steps of a start
  int solutions;                    // how many are wanted
  double apart;                     // the least largest difference of two of them
  double tolerance;                 // largest entry of the pose error
  bool nearest;                     // the reached configuration nearest to where its search began
  std::uint64_t seed;
  bool (*stop)(void*);  // asked before each step: true ends early
  void* context;
  // answers
  double* q;            // rows of `solutions` of n: those found; of a row without any, the closest
  double* residual;     // rows of `solutions`: largest entry of the pose error
  std::int32_t* found;  // rows: how many were found
  std::int32_t* used;   // rows: starts
  std::int32_t* taken;  // rows: steps, of all starts
};

constexpr int kInverseSlots = 64;   // rows in work at the same time
constexpr int kMostStalls = 6;      // steps without progress that end a search
constexpr int kNearStalls = 12;     // and those of one that is near its pose:
constexpr double kNear = 1e-2;      // the size of its error was as small as this
constexpr double kProgress = 0.9;   // a step makes progress that leaves at most this part of the error
constexpr double kNarrow = 1e-3;    // the trust region at its smallest, as a part of the largest
constexpr int kNearestSteps = 200;  // steps that seek the nearest configuration,
constexpr int kPolishSteps = 12;    // and steps straight to the pose after them
constexpr double kLeastPull = 1.0 / 64.0;
constexpr double kAtRest = 1e-9;  // a step this small is none
constexpr double kWholeTurn = 6.28318530717958648;

}  // namespace stillreach

STILLREACH_BEGIN

STILLREACH_INLINE std::size_t inverse_doubles(int n) { return kInverseSlots * (7 * to_size(n) + 18); }

// A row in work.
struct Search {
  std::ptrdiff_t row;
  int start, step, stalls;
  double best, last, closest;  // sizes of the error: least of this start, a step ago, least of all starts
  double residual;             // largest entry of the error where it was least
  double radius;               // part of the largest step
  double way, pull;  // the nearest one: squared distance from the start; part of the way back that a step asks for
                     // way back that is asked for
};

// Rows of n each, but target (12), error (6).
struct InverseMemory {
  double *q, *lower, *upper, *rates, *reference, *closest, *origin, *target, *error;
  Search search[kInverseSlots];
  std::int32_t status[kInverseSlots];
};

inline void set_inverse_memory(int n, double* doubles, InverseMemory& w) {
  double** const vectors[] = {&w.q, &w.lower, &w.upper, &w.rates, &w.reference, &w.closest, &w.origin};
  for (double** v : vectors) {
    *v = doubles;
    doubles += kInverseSlots * n;
  }
  w.target = doubles;
  w.error = doubles + 12 * kInverseSlots;
}

// Sebastiano Vigna's splitmix64, 2015: a hash of 64 bits.
STILLREACH_INLINE std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// A row's own seed: its pose, so that neither its place nor its neighbours matter.
inline std::uint64_t row_seed(const Inverse& v, std::ptrdiff_t row) {
  std::uint64_t seed = mixed(v.seed);
  for (int i = 0; i < 12; ++i) {
    std::uint64_t bits;
    const double number = v.target[12 * row + i] + 0.0;  // -0 is 0
    STILLREACH_LIBRARY(memcpy)(&bits, &number, sizeof bits);
    seed = mixed(seed ^ bits);
  }
  return seed;
}

inline void begin_start(const Inverse& v, int slot, InverseMemory& w) {
  const int n = v.batch.arm.n;
  Search& s = w.search[slot];
  double* q = w.q + slot * n;
  const double* own = v.start ? v.start + s.row * v.start_stride : nullptr;
  const std::uint64_t seed = row_seed(v, s.row);
  for (int i = 0; i < n; ++i) {
    const std::uint64_t draw = mixed(seed + static_cast<std::uint64_t>(s.start) * static_cast<std::uint64_t>(n) +
                                     static_cast<std::uint64_t>(i));
    q[i] = own && s.start == 0 ? own[i] : madd(static_cast<double>(draw >> 11) * 0x1p-53, v.range[i], v.low_start[i]);
    q[i] = clamp(q[i], v.lower[i], v.upper[i]);
    switch (v.hold[i]) {
      case Hold::FREE: break;
      case Hold::AT_START: q[i] = own[i]; break;
      case Hold::AT_VALUE: q[i] = v.values[(s.start % v.choices) * n + i]; break;
    }
    w.origin[slot * n + i] = own ? own[i] : q[i];
  }
  ++s.start;
  ++v.used[s.row];
  s.step = s.stalls = 0;
  s.best = s.last = infinity();
  s.radius = s.pull = 1.0;
  s.way = infinity();
}

inline void begin_row(const Inverse& v, std::ptrdiff_t row, int slot, InverseMemory& w) {
  const int n = v.batch.arm.n;
  Search& s = w.search[slot];
  s.row = row;
  s.start = 0;
  s.closest = infinity();
  v.found[row] = v.used[row] = v.taken[row] = 0;
  STILLREACH_LIBRARY(memcpy)(w.target + 12 * slot, v.target + 12 * row, 12 * sizeof(double));
  begin_start(v, slot, w);
  for (int i = 0; i < n; ++i) w.closest[slot * n + i] = w.q[slot * n + i];
}

// The room of the next step, and the rates that lead to where the nearest configuration is sought from.
inline void set_step(const Inverse& v, int slot, InverseMemory& w) {
  const int n = v.batch.arm.n;
  const Search& s = w.search[slot];
  for (int i = 0; i < n; ++i) {
    const int at = slot * n + i;
    const double most = s.radius * v.step[i];
    const bool held = v.hold[i] != Hold::FREE;
    w.lower[at] = held ? 0.0 : larger(v.lower[i] - w.q[at], -most);
    w.upper[at] = held ? 0.0 : smaller(v.upper[i] - w.q[at], most);
    if (v.nearest) w.reference[at] = s.step < kNearestSteps ? s.pull * (w.origin[at] - w.q[at]) : 0.0;
  }
}

// Whether two configurations count as the same.
inline bool alike(const Inverse& v, const double* a, const double* b) {
  double most = 0.0;
  for (int i = 0; i < v.batch.arm.n; ++i) {
    const double off = magnitude(a[i] - b[i]);
    most = larger(most, v.turns[i] ? smaller(off, magnitude(off - kWholeTurn)) : off);
  }
  return most < v.apart;
}

// A found configuration, unless it is one of those before.
inline void keep_solution(const Inverse& v, int slot, double residual, InverseMemory& w) {
  const int n = v.batch.arm.n;
  const std::ptrdiff_t row = w.search[slot].row, first = row * v.solutions;
  double* own = w.q + slot * n;  // the search is over
  for (int i = 0; i < n; ++i) {
    if (!v.turns[i] || v.hold[i] != Hold::FREE) continue;
    const double middle = v.start ? v.start[row * v.start_stride + i] : 0.0;
    own[i] -= kWholeTurn * nearest_integer((own[i] - middle) / kWholeTurn);
  }
  for (int k = 0; k < v.found[row]; ++k)
    if (alike(v, own, v.q + (first + k) * n)) return;
  STILLREACH_LIBRARY(memcpy)(v.q + (first + v.found[row]) * n, own, sizeof(double) * to_size(n));
  v.residual[first + v.found[row]++] = residual;
}

// What a solved step means: whether the row is done.
template <int M>
inline bool take_step(Rows<M> m, const Inverse& v, int slot, InverseMemory& w) {
  const int n = v.batch.arm.n;
  Search& s = w.search[slot];
  double *q = w.q + slot * n, *rates = w.rates + slot * n, *error = w.error + 6 * slot, weighted[kRows];
  const double residual = largest_of(m, error);
  apply_rows(m, v.batch.metric.rows, error, weighted);
  const double size = square_root(dot(m, weighted, weighted));
  ++v.taken[s.row];
  if (size < s.closest) {
    s.closest = size;
    s.residual = residual;
    STILLREACH_LIBRARY(memcpy)(w.closest + slot * n, q, sizeof(double) * to_size(n));
  }
  double move = 0.0;
  for (int i = 0; i < n; ++i) move = larger(move, magnitude(rates[i]));
  const bool nearing = v.nearest && s.step < kNearestSteps && move > kAtRest * s.pull;
  bool over = false;
  if (residual <= v.tolerance && !nearing) {
    keep_solution(v, slot, residual, w);
    if (v.found[s.row] == v.solutions) return true;
    over = true;
  }
  if (nearing) {
    double way = 0.0;
    for (int i = 0; i < n; ++i) way = madd(q[i] - w.origin[slot * n + i], q[i] - w.origin[slot * n + i], way);
    s.pull = way <= s.way ? smaller(1.2 * s.pull, 1.0) : larger(0.5 * s.pull, kLeastPull);
    s.way = way;
  }
  const bool worse = size > s.last && !(nearing && size < kNear);
  if (!nearing && !(size <= kProgress * s.best)) ++s.stalls;
  s.best = smaller(s.best, size);
  s.last = size;
  ++s.step;
  const bool near = s.best < kNear;
  if (over || s.stalls >= (near ? kNearStalls : kMostStalls) ||
      s.step > (v.nearest ? kNearestSteps + kPolishSteps : v.steps)) {
    if (s.start >= v.starts[s.row]) return true;
    begin_start(v, slot, w);
    return false;
  }
  const double part = worse ? 0.5 : 1.0;
  s.radius = worse ? larger((near ? 0.3 : 0.5) * s.radius, kNarrow) : smaller(1.6 * s.radius, 1.0);
  for (int i = 0; i < n; ++i)
    if (v.hold[i] == Hold::FREE) q[i] = clamp(madd(part, rates[i], q[i]), v.lower[i], v.upper[i]);
  return false;
}

// The row of a slot is done. Of one that was not reached the closest configuration is stored.
inline void end_row(const Inverse& v, int slot, InverseMemory& w) {
  const int n = v.batch.arm.n;
  const Search& s = w.search[slot];
  if (v.found[s.row] > 0) return;
  STILLREACH_LIBRARY(memcpy)(v.q + s.row * v.solutions * n, w.closest + slot * n, sizeof(double) * to_size(n));
  v.residual[s.row * v.solutions] = s.residual;
}

inline void move_slot(int n, int from, int to, InverseMemory& w) {
  double* const vectors[] = {w.q, w.closest, w.origin};
  for (double* x : vectors) STILLREACH_LIBRARY(memcpy)(x + to * n, x + from * n, sizeof(double) * to_size(n));
  STILLREACH_LIBRARY(memcpy)(w.target + 12 * to, w.target + 12 * from, 12 * sizeof(double));
  w.search[to] = w.search[from];
}

template <int M>
inline void inverse_rows(Rows<M> m, const Inverse& v, std::ptrdiff_t first, std::ptrdiff_t last, BatchMemory& memory,
                         InverseMemory& w) {
  const int n = v.batch.arm.n;
  Batch b = v.batch;
  b.q = w.q;
  b.target = w.target;
  b.error = w.error;
  b.lower = w.lower;
  b.upper = w.upper;
  b.bounds_stride = b.reference_stride = n;
  b.reference = v.nearest ? w.reference : nullptr;
  b.rates = w.rates;
  b.status = w.status;
  std::ptrdiff_t next = first;
  int live = 0;
  while (live < kInverseSlots && next < last) begin_row(v, next++, live++, w);
  while (live > 0 && !v.stop(v.context)) {
    for (int slot = 0; slot < live; ++slot) set_step(v, slot, w);
    solve_rows(b, 0, live, memory);
    for (int slot = 0; slot < live; ++slot) {
      if (!take_step(m, v, slot, w)) continue;
      end_row(v, slot, w);
      if (next < last)
        begin_row(v, next++, slot, w);
      else
        w.search[slot].row = -1;
    }
    int kept = 0;
    for (int slot = 0; slot < live; ++slot) {
      if (w.search[slot].row < 0) continue;
      if (kept < slot) move_slot(n, slot, kept, w);
      ++kept;
    }
    live = kept;
  }
}

// Rows first to last - 1.
inline void inverse_rows(const Inverse& v, std::ptrdiff_t first, std::ptrdiff_t last, BatchMemory& memory,
                         InverseMemory& w) {
  switch (v.batch.m) {
    case 6: return inverse_rows(Rows<6>{6}, v, first, last, memory, w);
    case 3: return inverse_rows(Rows<3>{3}, v, first, last, memory, w);
    default: return inverse_rows(Rows<0>{v.batch.m}, v, first, last, memory, w);
  }
}

STILLREACH_END
