// What rows of configurations keep after each loss of joints: what relative.hpp and guaranteed.hpp share.
#pragma once

#include "stillreach/kinematics/coupled.hpp"
#include "stillreach/kinematics/frames.hpp"
#include "stillreach/linear/factor.hpp"

namespace stillreach {

// What a call is about. Null pointers mean: not wanted. Sets of joints are in the order of size, and lexicographic in
// each size.
struct LossBatch {
  ArmView arm;
  const double* q;  // rows of n
  int m;
  int rows[6];           // of [v; w]
  int tool_axes;         // along the tool's axes
  const double* rates;   // n: full rates; a joint with 0 does not count
  const double* scales;  // m: what one unit of each row counts (guaranteed speeds)
  int sizes;             // joints that fail together, at most
  const int* sets;       // (count, sizes) joints of the sets of `every`, -1 where fewer fail (guaranteed speeds)
  std::ptrdiff_t count;  // sets of `every`
  double* whole;         // rows: with all joints (guaranteed speeds)
  double* joint;         // rows of n: without each joint
  double* worst;         // rows of `sizes`: the least of all sets of each size
  std::int32_t* which;   // rows of `sizes`: the place of that set among those of its size (relative manipulability)
  double* every;         // rows of `count`
};

}  // namespace stillreach

STILLREACH_BEGIN

// The columns of the task's Jacobian in lanes, m numbers each.
inline void loss_columns(const LossBatch& b, const Wide* pose, const Wide* jacobian, Wide* columns) {
  for (int i = 0; i < b.arm.n; ++i)
    for (int r = 0; r < b.m; ++r) {
      const int row = b.rows[r], half = row < 3 ? 0 : 3;
      const Wide* base = jacobian + 6 * i + half;
      const Wide* axis = pose + 3 * (row - half);
      columns[i * b.m + r] =
          b.tool_axes ? madd(axis[0], base[0], madd(axis[1], base[1], axis[2] * base[2])) : base[row - half];
    }
}

// x becomes the mirror vector of the reflection that leaves of x its last coordinate alone; size: |x|. Returns what
// t of reflect() is multiplied by: 0 where x is 0.
template <int D>
STILLREACH_INLINE Wide mirror(int d, Wide size, Wide* x) {
  const int last = (D > 0 ? D : d) - 1;
  const Wide end = x[last], zero = wide(0.0), scale = size * (size + magnitude(end));
  x[last] = end + select(end < zero, -size, size);
  return select(scale > zero, wide(1.0) / scale, zero);
}

// The first d - 1 coordinates of y after that reflection.
template <int D>
STILLREACH_INLINE void reflect(int dims, const Wide* mirror, Wide factor, const Wide* y, Wide* to) {
  const int d = D > 0 ? D : dims;
  Wide t = mirror[0] * y[0];
  STILLREACH_UNROLL for (int c = 1; c < d; ++c) t = madd(mirror[c], y[c], t);
  t = t * factor;
  STILLREACH_UNROLL for (int c = 0; c < d - 1; ++c) to[c] = madd(-t, mirror[c], y[c]);
}

template <int D>
STILLREACH_INLINE Wide length_of(int dims, const Wide* x) {
  const int d = D > 0 ? D : dims;
  if (d == 1) return magnitude(x[0]);
  Wide sum = x[0] * x[0];
  STILLREACH_UNROLL for (int c = 1; c < d; ++c) sum = madd(x[c], x[c], sum);
  return square_root(sum);
}

// Memory for one group of lanes, in their numbers.
struct LossMemory {
  Wide *q, *jacobian, *scratch, *columns, *joint, *worst, *which, *every, *more;
};

STILLREACH_INLINE std::size_t loss_doubles(int n, int sizes, std::ptrdiff_t count) {
  const std::size_t size = to_size(n), k = to_size(sizes);
  return kLanes * (size * (16 + size) + 2 * k + 16 + static_cast<std::size_t>(count) + (k + 6) * size * (size + 6));
}

inline LossMemory make_loss_memory(const LossBatch& b, double* doubles) {
  Wide* next = static_cast<Wide*>(static_cast<void*>(doubles));
  const auto take = [&next](std::ptrdiff_t count) {
    Wide* taken = next;
    next += count;
    return taken;
  };
  const int n = b.arm.n;
  LossMemory w;
  w.q = take(n);
  w.jacobian = take(6 * n);
  w.scratch = take(2 * n);
  w.columns = take(6 * n);
  w.joint = take(n);
  w.worst = take(b.sizes);
  w.which = take(b.sizes);
  w.every = take(b.every ? b.count : 0);
  w.more = next;
  return w;
}

// Rows first to last - 1: work(memory) has the columns of a group of lanes, and fills joint, worst, which and every;
// it returns `whole`.
template <class Work>
STILLREACH_INLINE void each_loss_row(const LossBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles,
                                     Work work) {
  const int n = b.arm.n;
  const LossMemory w = make_loss_memory(b, doubles);
  Wide pose[12];
  double* to[kLanes];
  for (std::ptrdiff_t at = first; at < last; at += kLanes) {
    const int here = last - at < kLanes ? static_cast<int>(last - at) : kLanes;
    const double* from[kLanes];
    for (int l = 0; l < kLanes; ++l) from[l] = b.q + (at + (l < here ? l : 0)) * n;
    load_lanes(from, n, w.q);
    arm_kinematics(b.arm, static_cast<const Wide*>(w.q), w.scratch, pose, w.jacobian);
    loss_columns(b, pose, w.jacobian, w.columns);
    const Wide whole = work(w);
    const auto write = [&](const Wide* values, double* base, std::ptrdiff_t length) {
      if (!base) return;
      for (int l = 0; l < kLanes; ++l) to[l] = base + (at + (l < here ? l : 0)) * length;
      store_lanes(values, static_cast<int>(length), (1 << here) - 1, to);
    };
    write(&whole, b.whole, 1);
    write(w.joint, b.joint, n);
    write(w.worst, b.worst, b.sizes);
    write(w.every, b.every, b.count);
    for (int l = 0; b.which && l < here; ++l)
      for (int s = 0; s < b.sizes; ++s) b.which[(at + l) * b.sizes + s] = static_cast<std::int32_t>(w.which[s][l]);
  }
}

STILLREACH_END
