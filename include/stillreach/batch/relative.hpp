// Relative manipulability: w(J without some joints) / w(J), of every set of joints up to a size.
//
// With Z an orthonormal basis of the null space of J, a row a joint, it is the volume that the rows of the set span.
// One depth-first pass over the sets gives all: each step takes a row out, which multiplies the volume by its length,
// and reflects the rows after it so that they lose the coordinate along it. Reflections keep small volumes to the
// rounding of the rows, where a Gram matrix would lose half of the digits.
#pragma once

#include "stillreach/batch/losses.hpp"

STILLREACH_BEGIN

constexpr double kDependentRow = 1e-10;  // what the rows of J before a row leave of it, relative

// Z (n rows of n - m numbers) by reflections of J' from the front; J by columns of m numbers. Returns the lanes whose J
// has rank m. work: n m numbers and m more.
inline Lanes null_rows(int n, int m, const Wide* columns, Wide* work, Wide* basis) {
  const int d = n - m;
  const Wide zero = wide(0.0);
  Wide* factor = work + n * m;
  Lanes regular = every_lane();
  for (int k = 0; k < m; ++k) {
    Wide whole = zero;
    for (int i = 0; i < n; ++i) {
      work[k * n + i] = columns[i * m + k];
      whole = madd(columns[i * m + k], columns[i * m + k], whole);
    }
    factor[k] = square_root(whole);  // for now
  }
  for (int k = 0; k < m; ++k) {
    Wide *v = work + k * n, left = zero;
    for (int i = k; i < n; ++i) left = madd(v[i], v[i], left);
    left = square_root(left);
    regular &= left > kDependentRow * factor[k];
    const Wide end = v[k], scale = left * (left + magnitude(end));
    v[k] = end + select(end < zero, -left, left);
    factor[k] = select(scale > zero, wide(1.0) / scale, zero);
    for (int c = k + 1; c < m; ++c) {
      Wide *a = work + c * n, t = zero;
      for (int i = k; i < n; ++i) t = madd(v[i], a[i], t);
      t = t * factor[k];
      for (int i = k; i < n; ++i) a[i] = madd(-t, v[i], a[i]);
    }
  }
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < d; ++c) basis[i * d + c] = wide(i == m + c ? 1.0 : 0.0);
  for (int k = m - 1; k >= 0; --k) {
    const Wide* v = work + k * n;
    for (int c = 0; c < d; ++c) {
      Wide t = zero;
      for (int i = k; i < n; ++i) t = madd(v[i], basis[i * d + c], t);
      t = t * factor[k];
      for (int i = k; i < n; ++i) basis[i * d + c] = madd(-t, v[i], basis[i * d + c]);
    }
  }
  return regular;
}

// The pass over the sets: how many of each size were met.
struct LossPass {
  int n, sizes;
  const LossMemory* memory;
  std::ptrdiff_t* met;          // of each size
  const std::ptrdiff_t* begin;  // of each size in `every`
  bool all;
};

// Adds each joint from `first` on to a set of `size` joints. rows: of all joints, d numbers each. D: d, 0 if unknown.
template <int D>
inline void lose_more(const LossPass& p, int dims, int size, int first, Wide product, const Wide* rows, Wide* more) {
  const int d = D > 0 ? D : dims;
  const LossMemory& w = *p.memory;
  for (int i = first; i < p.n; ++i) {
    const Wide *row = rows + i * d, length = length_of<D>(d, row), left = product * length;
    const std::ptrdiff_t place = p.met[size]++;
    if (size == 0) w.joint[i] = left;
    if (p.all) w.every[p.begin[size] + place] = left;
    const Lanes less = left < w.worst[size];
    w.worst[size] = select(less, left, w.worst[size]);
    w.which[size] = select(less, wide(static_cast<double>(place)), w.which[size]);
    if constexpr (D != 1) {
      if (size + 1 == p.sizes || d == 1) continue;
      Wide v[kRows];
      Wide* axis = D > 0 ? v : more;
      for (int c = 0; c < d; ++c) axis[c] = row[c];
      const Wide factor = mirror<D>(d, length, axis);
      Wide* below = more + (D > 0 ? 0 : d);
      for (int j = i + 1; j < p.n; ++j) reflect<D>(d, axis, factor, rows + j * d, below + j * (d - 1));
      Wide* next = below + p.n * (d - 1);
      if constexpr (D > 1)
        lose_more<D - 1>(p, d - 1, size + 1, i + 1, left, below, next);
      else if (d - 1 == 6)
        lose_more<6>(p, 6, size + 1, i + 1, left, below, next);
      else
        lose_more<0>(p, d - 1, size + 1, i + 1, left, below, next);
    }
  }
}

inline void lose_any(const LossPass& p, int d, const Wide* rows, Wide* more) {
  const Wide one = wide(1.0);
  switch (d) {
    case 1: return lose_more<1>(p, 1, 0, 0, one, rows, more);
    case 2: return lose_more<2>(p, 2, 0, 0, one, rows, more);
    case 3: return lose_more<3>(p, 3, 0, 0, one, rows, more);
    case 4: return lose_more<4>(p, 4, 0, 0, one, rows, more);
    case 5: return lose_more<5>(p, 5, 0, 0, one, rows, more);
    case 6: return lose_more<6>(p, 6, 0, 0, one, rows, more);
    default: return lose_more<0>(p, d, 0, 0, one, rows, more);
  }
}

constexpr int kMostLosses = 32;  // joints that fail together

// Rows first to last - 1. A configuration whose J has not rank m gets NaN.
inline void relative_rows(const LossBatch& b, std::ptrdiff_t first, std::ptrdiff_t last, double* doubles) {
  const int n = b.arm.n, m = b.m, d = n - m;
  std::ptrdiff_t begin[kMostLosses + 1] = {0}, met[kMostLosses], sets = 1;
  for (int s = 0; s < b.sizes; ++s) {
    sets = sets * (n - s) / (s + 1);
    begin[s + 1] = begin[s] + sets;
  }
  each_loss_row(b, first, last, doubles, [&](const LossMemory& w) {
    const Wide none = wide(__builtin_nan(""));
    for (int s = 0; s < b.sizes; ++s) {
      met[s] = 0;
      w.worst[s] = wide(s < d ? infinity() : 0.0);
      w.which[s] = wide(0.0);
    }
    for (int i = 0; i < n; ++i) w.joint[i] = wide(0.0);
    for (std::ptrdiff_t f = 0; b.every && f < b.count; ++f) w.every[f] = wide(0.0);
    for (int i = 0; i < n; ++i)
      for (int r = 0; b.rates[i] == 0.0 && r < m; ++r) w.columns[i * m + r] = wide(0.0);
    Lanes regular = no_lane();
    if (d >= 0) {
      Wide* basis = w.more + (n + 1) * m;
      regular = null_rows(n, m, w.columns, w.more, basis);
      if (d > 0) lose_any({n, b.sizes, &w, met, begin, b.every != nullptr}, d, basis, basis + n * d);
    }
    if (!all(regular)) {
      for (int i = 0; i < n; ++i) w.joint[i] = select(regular, w.joint[i], none);
      for (int s = 0; s < b.sizes; ++s) w.worst[s] = select(regular, w.worst[s], none);
      for (std::ptrdiff_t f = 0; b.every && f < b.count; ++f) w.every[f] = select(regular, w.every[f], none);
    }
    return wide(0.0);
  });
}

STILLREACH_END
