// A full joint weight W2 in the paper's laws, eq. (7) and (8), positive semidefinite: with W2 = L diag(1 .. 1, 0 .. 0)
// L' the rates are x = L^-T (z, y), and the weight is |z|^2. The rates y without weight serve what z leaves of the
// task, y = B^+ (b - A z) with B their columns, so that z sees A and b without what B spans (Elden, 1982).
#pragma once

#include "stillreach/problem/system.hpp"

STILLREACH_BEGIN

constexpr double kWeightless =
    1e-12;  // part of a joint's weight below which the rest, given the other joints', is rounding

// Exchanges two working joints before their columns are weighted.
inline void exchange_joints(int a, int b, int k, int factored, Workspace& w) {
  const auto exchange = [](auto& x, auto& y) {
    const auto kept = x;
    x = y;
    y = kept;
  };
  if (a == b) return;
  exchange(w.joint[a], w.joint[b]);
  exchange(w.scale[a], w.scale[b]);
  exchange(w.target[a], w.target[b]);
  for (int r = 0; r < kStride; ++r) exchange(w.columns[a * kStride + r], w.columns[b * kStride + r]);
  for (int c = 0; c < factored; ++c) exchange(w.triangle[a * k + c], w.triangle[b * k + c]);
}

// w.triangle: L (row-major, k x k), with the identity behind the weighted directions, whose number is returned. The
// working joints are put in the order of the pivots.
inline int factor_joint_weight(const Problem& p, int k, Workspace& w) {
  const auto weight = [&](int i, int j) { return p.metric.joints[std::ptrdiff_t{w.joint[i]} * p.n + w.joint[j]]; };
  double *L = w.triangle, *left = w.target;
  for (int i = 0; i < k; ++i) left[i] = weight(i, i);
  for (int j = 0; j < k; ++j) {
    int pivot = j;
    double most = kWeightless;
    for (int i = j; i < k; ++i) {
      const double part = left[i] / weight(i, i);  // no weight: NaN, which is never the most
      if (part > most) {
        most = part;
        pivot = i;
      }
    }
    if (!(most > kWeightless)) {
      for (int i = j; i < k; ++i)
        for (int c = j; c <= i; ++c) L[i * k + c] = c == i ? 1.0 : 0.0;
      return j;
    }
    exchange_joints(j, pivot, k, j, w);
    L[j * k + j] = square_root(left[j]);
    for (int i = j + 1; i < k; ++i) {
      double sum = weight(i, j);
      for (int c = 0; c < j; ++c) sum = madd(-L[i * k + c], L[j * k + c], sum);
      L[i * k + j] = sum / L[j * k + j];
      left[i] = madd(-L[i * k + j], L[i * k + j], left[i]);
    }
  }
  return k;
}

// Makes `a` orthogonal to the orthogonal columns first .. last - 1, some of which may be 0 (kStride numbers each).
inline void make_orthogonal(const double* columns, int first, int last, double* a) {
  for (int pass = 0; pass < 2; ++pass)
    for (int j = first; j < last; ++j) {
      const double *q = columns + j * kStride, size = dot(Rows<kStride>{}, q, q);
      const double part = size > 0.0 ? dot(Rows<kStride>{}, q, a) / size : 0.0;
      for (int r = 0; r < kStride; ++r) a[r] = madd(-part, q[r], a[r]);
    }
}

// Full joint weight: w.columns become those of z = L' x, which has unit weight, made orthogonal to those of y; and
// w.whitened what they were before. Columns of y that depend on each other are set to 0, with s.idle: their joints stay
// at rest.
inline void whiten(const Problem& p, double rank_tolerance, System& s, Workspace& w) {
  if (!s.full) return;
  s.weighted = factor_joint_weight(p, s.k, w);
  solve_triangle(s.k, w.triangle, false, kStride, w.columns);
  if (s.weighted == s.k) return;
  double largest = 0.0;
  for (int j = 0; j < s.k; ++j) {
    double* a = w.columns + j * kStride;
    for (int r = 0; r < kStride; ++r) w.whitened[j * kStride + r] = a[r];
    largest = larger(largest, dot(Rows<kStride>{}, a, a));
  }
  for (int j = s.weighted; j < s.k; ++j) {
    double* a = w.columns + j * kStride;
    make_orthogonal(w.columns, s.weighted, j, a);
    if (dot(Rows<kStride>{}, a, a) > rank_tolerance * rank_tolerance * largest) continue;
    for (int r = 0; r < kStride; ++r) a[r] = 0.0;
    s.idle = true;
  }
  for (int j = 0; j < s.weighted; ++j) make_orthogonal(w.columns, s.weighted, s.k, w.columns + j * kStride);
}

// Writes behind the z of a vector, whose entries are `step` apart, the y that serves what z leaves of `task` (kStride
// numbers, which change).
inline void serve_without_weight(const System& s, const Workspace& w, double* task, int step, double* x) {
  for (int j = 0; j < s.weighted; ++j)
    for (int r = 0; r < kStride; ++r) task[r] = madd(-w.whitened[j * kStride + r], x[j * step], task[r]);
  for (int j = s.k - 1; j >= s.weighted; --j) {
    const double *q = w.columns + j * kStride, size = dot(Rows<kStride>{}, q, q);
    x[j * step] = size > 0.0 ? dot(Rows<kStride>{}, q, task) / size : 0.0;
    for (int r = 0; r < kStride; ++r) task[r] = madd(-w.whitened[j * kStride + r], x[j * step], task[r]);
  }
}

// From z to x, in place, for `count` interleaved vectors; linear, the offset that weight_offset() writes is not in it.
inline void unwhiten(const System& s, const Workspace& w, int count, double* x) {
  if (!s.full) return;
  if (s.weighted < s.k)
    for (int c = 0; c < count; ++c) {
      double none[kStride] = {};
      serve_without_weight(s, w, none, count, x + c);
    }
  solve_triangle(s.k, w.triangle, true, count, x);
}

// With a full joint weight the least weighted norm may not be at zero: joints fixed at rates other than zero pull by
// -W_ww^-1 W_wf rates_f, and rates without weight serve the task. Writes that offset of the scaled working rates; the
// right-hand side is moved along. False: no offset.
template <int M>
inline bool weight_offset(Rows<M> m, const Problem& p, const double* rates, const std::int8_t* held, System& s,
                          Workspace& w) {
  if (!s.full) return false;
  bool any = s.weighted < s.k;
  const double unit = s.unit_b / s.unit_a;
  for (int j = 0; j < s.k; ++j) w.offset[j] = 0.0;
  for (int f = 0; f < p.n; ++f) {
    if ((p.lower[f] < p.upper[f] && !(held && held[f])) || rates[f] == 0.0) continue;
    any = true;
    for (int j = 0; j < s.k; ++j) {
      const int i = w.joint[j];
      w.offset[j] -= p.metric.joints[std::ptrdiff_t{i} * p.n + f] * (rates[f] / p.metric.units[f] / unit);
    }
  }
  if (!any) return false;
  double task[kStride];
  for (int r = 0; r < kStride; ++r) task[r] = s.rhs[r];
  make_orthogonal(w.columns, s.weighted, s.k, s.rhs);
  solve_triangle(s.k, w.triangle, false, 1, w.offset);  // L^-1 of it is the offset in weighted rates z,
  for (int j = 0; j < s.weighted; ++j)                  // which moves the right-hand side,
    for (int r = 0; r < m(); ++r) s.rhs[r] = madd(-w.columns[j * kStride + r], w.offset[j], s.rhs[r]);
  if (s.weighted < s.k) serve_without_weight(s, w, task, 1, w.offset);
  solve_triangle(s.k, w.triangle, true, 1, w.offset);  // and L^-T of that the offset of x
  return true;
}

// The rank that k columns can have.
STILLREACH_INLINE int full_rank(const Problem& p, int k) {
  const int rows = p.m - p.metric.weightless;
  return k < rows ? k : rows;
}

STILLREACH_END
