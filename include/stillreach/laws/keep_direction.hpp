// KeepDirection: the largest fraction of the commanded twist that the bounds allow, in its direction, then the rates
// nearest to the reference.
#pragma once

#include "stillreach/bounded/fraction.hpp"
#include "stillreach/laws/least_error.hpp"

STILLREACH_BEGIN

constexpr double kClose = 1e3;    // times a residual that counts as none, where planes say that there is none
constexpr double kNearly = 1e-9;  // a fraction so little above 1 is 1

// The bounded answer at a fraction, warm. Returns how far from it that is.
template <int M>
inline double solve_fraction(Rows<M> m, const double* fixed, const double* twist, double fraction, Box& b, Inner& in) {
  double rhs[kStride];
  for (int r = 0; r < kStride; ++r) rhs[r] = r < m() ? madd(fraction, twist[r], fixed[r]) : 0.0;
  solve_box(m, rhs, b, in, false);
  if (b.doubtful) settle_box(m, rhs, b, in);
  residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
  return size_of(m, b.residual);
}

// Whether the plane across `normal` shows that the whole twist is out of reach.
template <int M>
inline bool is_beyond(Rows<M> m, const double* fixed, const double* twist, const double* normal, const Box& b) {
  double reach = -dot(m, normal, fixed);
  for (int i = 0; i < b.k; ++i) {
    const double slope = dot(m, normal, b.columns + i * kStride);
    if (slope != 0.0) reach = madd(slope, slope > 0.0 ? b.upper[i] : b.lower[i], reach);
  }
  return reach < dot(m, normal, twist) * (1.0 - kNearly);
}

// Of all z that reach the end of the ray, the one of least norm: columns that leave the plane across y stay at their
// bounds, the others move in it. b.lower and b.upper are w.lower and w.upper.
template <int M>
inline void settle_face(Rows<M> m, const double* fixed, const double* twist, double s, const Ray& ray, Workspace& w,
                        Box& b, Inner& in) {
  const double size = size_of(m, ray.y), across = kLeaves * size, rounding = 2.0 * b.dependent * size;
  int* index = w.index;
  int count = 0;
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] == 0 ||
        !(magnitude(dot(m, ray.y, b.columns + i * kStride)) > larger(across * b.length[i], rounding)))
      index[count++] = i;
  if (count == ray.count) return;
  double rhs[kStride];
  for (int r = 0; r < kStride; ++r) rhs[r] = r < m() ? madd(s, twist[r], fixed[r]) : 0.0;
  for (int i = 0, j = 0; i < b.k; ++i) {
    if (j < count && index[j] == i)
      ++j;
    else
      w.lower[i] = w.upper[i] = b.z[i];
  }
  spectrum(m(), w.columns, index, count, b.threshold, w.work, in.spectrum);
  const Rows<0> rank{reduce_rows(m, in.spectrum, w.columns, b, rhs)};
  for (int i = 0; i < b.k; ++i) {
    w.shapes[i] = b.z[i];
    w.held[i] = b.state[i];
  }
  residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
  const double before = size_of(rank, b.residual), scale = size_of(rank, rhs);
  solve_box(rank, rhs, b, in, false);
  if (b.doubtful) settle_box(rank, rhs, b, in);
  residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
  if (size_of(rank, b.residual) > larger(before, reached(b, scale)))
    for (int i = 0; i < b.k; ++i) {
      b.z[i] = w.shapes[i];
      b.state[i] = w.held[i];
    }
}

// The basis of the last tick's end: the columns between their bounds, where they are few enough.
inline int last_basis(int most, const std::int8_t* active, const Workspace& w, int k, int* column) {
  int count = 0;
  for (int j = 0; j < k; ++j) {
    const std::int8_t a = active[w.joint[j]];
    if (a == 1 || a == -1) continue;
    if (count == most) return 0;
    column[count++] = j;
  }
  return count;
}

// Whether the twist is less than the rounding of what the columns do: in any case (2), or where they are at their
// bounds (1).
template <int M>
inline int smallness(Rows<M> m, const double* fixed, const double* twist, const Box& b) {
  double least = size_of(m, fixed), most = least;
  for (int i = 0; i < b.k; ++i) {
    const double up = magnitude(b.upper[i]), down = magnitude(b.lower[i]);
    least = larger(least, magnitude(clamp(0.0, b.lower[i], b.upper[i])) * b.length[i]);
    most = larger(most, larger(up < infinity() ? up : 0.0, down < infinity() ? down : 0.0) * b.length[i]);
  }
  const double size = size_of(m, twist);
  return size <= kRounding * least ? 2 : size <= kRounding * most;
}

// The largest fraction in [0, 1] with fixed + fraction * twist in reach, and its answer in b. Negative: none. solved:
// b.target and `in` hold the unbounded answer, whose bounded part shows in most cases where the twist is out of reach.
template <int M>
inline double search_fraction(Rows<M> m, const double* fixed, const double* twist, const std::int8_t* active,
                              bool solved, Workspace& w, Box& b, Inner& in) {
  Ray ray;
  ray.fixed = fixed;
  ray.twist = twist;
  ray.slope = w.shapes;
  ray.change = w.shapes + b.k;
  ray.distance = w.shapes + 4 * b.k;
  ray.count = last_basis(m() - 1, active, w, b.k, ray.column);
  const double scale = size_of(m, twist) + size_of(m, fixed);
  double rhs[kStride];
  for (int r = 0; r < kStride; ++r) rhs[r] = r < m() ? fixed[r] + twist[r] : 0.0;
  if (!solved)
    for (int i = 0; i < b.k; ++i) b.target[i] = 0.0;
  for (int i = 0; i < b.k; ++i) b.z[i] = clamp(b.target[i], b.lower[i], b.upper[i]);
  residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
  const int small = smallness(m, fixed, twist, b);
  if (small == 2) return solve_fraction(m, fixed, twist, 1.0, b, in) <= kClose * reached(b, scale) ? 1.0 : -1.0;
  if (small == 1 || (ray.count == 0 && !is_beyond(m, fixed, twist, b.residual, b))) {
    warm_states(w, b.k, active, b.state);
    if (solve_fraction(m, fixed, twist, 1.0, b, in) <= (small ? kClose : 1.0) * reached(b, scale)) return 1.0;
  }
  const double s = end_of_ray(m, b.residual, w.shapes + 2 * b.k, b, ray);
  if (s >= 1.0 && solve_fraction(m, fixed, twist, 1.0, b, in) <= kClose * reached(b, scale)) return 1.0;
  if (!(s * size_of(m, twist) > ray.noise) || !(s <= 1.0 + kNearly)) return -1.0;
  settle_face(m, fixed, twist, smaller(s, 1.0), ray, w, b, in);
  return smaller(s, 1.0);
}

// Where the rank is short: what is lost of the twist is served by no fraction but the one that fixed joints serve; the
// rows that are left are searched. none: a length that counts as 0.
template <int M>
inline STILLREACH_NOINLINE double search_reduced(Rows<M> m, double* fixed, double* twist, double none,
                                                 const std::int8_t* active, Workspace& w, Box& b, Inner& in) {
  const Spectrum s = in.spectrum;
  double own_fixed[kStride], own_twist[kStride], rest[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  const Rows<0> rank{reduce_rows(m, s, w.columns, b, rest)};
  for (int r = 0; r < kStride; ++r) {
    own_fixed[r] = r < rank() ? dot(m, s.left[r], fixed) : 0.0;
    own_twist[r] = r < rank() ? dot(m, s.left[r], twist) : 0.0;
  }
  make_orthogonal(m, s.left, rank(), fixed);
  make_orthogonal(m, s.left, rank(), twist);
  const double lost = size_of(m, twist);
  const bool all = lost <= none;
  const double only = all ? 0.0 : clamp(-dot(m, fixed, twist) / (lost * lost), 0.0, 1.0);
  for (int r = 0; r < m(); ++r) rest[r] = madd(only, twist[r], fixed[r]);
  double fraction = size_of(m, rest) <= none ? only : -1.0;
  if (fraction >= 0.0 && all)
    fraction = search_fraction(rank, own_fixed, own_twist, active, false, w, b, in);
  else if (fraction > 0.0 && solve_fraction(rank, own_fixed, own_twist, only, b, in) > none)
    fraction = -1.0;
  return fraction;
}

// What the fixed joints leave of a twist of 0, weighted.
template <int M>
inline void fixed_part(Rows<M> m, const Problem& p, const double* rates, double* fixed) {
  double raw[kRows] = {0, 0, 0, 0, 0, 0};
  for (int i = 0; i < p.n; ++i)
    if (!(p.lower[i] < p.upper[i]) && rates[i] != 0.0)
      for (int r = 0; r < m(); ++r) raw[r] = madd(-p.jacobian[i * m() + r], rates[i], raw[r]);
  for (int r = 0; r < kStride; ++r) fixed[r] = 0.0;
  apply_rows(m, p.metric.rows, raw, fixed);
}

// The fraction of the twist that the fixed joints do, where no others work; 0 where what they do is no fraction of it.
template <int M>
inline double fixed_fraction(Rows<M> m, const Problem& p, const double* rates) {
  double fixed[kStride], twist[kRows], size = 0.0;
  fixed_part(m, p, rates, fixed);
  apply_rows(m, p.metric.rows, p.twist, twist);
  for (int r = 0; r < m(); ++r) size += magnitude(fixed[r]) + magnitude(twist[r]);
  const double unit = scaling_unit(size);
  for (int r = 0; r < m(); ++r) {
    fixed[r] /= unit;
    twist[r] /= unit;
  }
  const double square = dot(m, twist, twist), scale = size_of(m, fixed) + size_of(m, twist);
  const double fraction = square > 0.0 ? clamp(-dot(m, fixed, twist) / square, 0.0, 1.0) : 1.0;
  for (int r = 0; r < m(); ++r) fixed[r] = madd(fraction, twist[r], fixed[r]);
  return size_of(m, fixed) <= kReached * scale ? fraction : 0.0;
}

// The best standstill, nearest to the reference: LeastError's answer for a twist of 0.
template <int M>
inline void stand_still(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  const double still[kRows] = {0, 0, 0, 0, 0, 0};
  LawSettings bare = law;
  bare.kind = LawKind::LEAST_ERROR;
  bare.parts = 0;
  Problem rest = p;
  rest.twist = still;
  least_error(m, bare, rest, w, out);
  out.scale = 0.0;
  out.status |= SCALED;
  report(m, p, out);
}

template <int M>
inline void keep_direction(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  System s;
  if (!prepare(m, p, w, out, s)) {
    out.scale = out.status & INVALID_INPUT ? 0.0 : fixed_fraction(m, p, out.rates);
    if (out.scale < 1.0) out.status |= SCALED;
    return;
  }
  double rhs[kStride], twist[kStride] = {0, 0, 0, 0, 0, 0, 0, 0}, fixed[kStride];
  Box b = make_box(m, law, p, s, out.rates, w, rhs);
  measure_columns(m, s, w);
  Inner in;
  const bool inside_all = solve_unbounded(m, rhs, b, in);
  apply_rows(m, p.metric.rows, p.twist, twist);
  fixed_part(m, p, out.rates, fixed);
  for (int r = 0; r < m(); ++r) {
    twist[r] /= s.unit_b;
    fixed[r] /= s.unit_b;
  }
  for (int j = 0; j < s.k; ++j)
    for (int r = 0; w.offset[j] != 0.0 && r < m(); ++r)
      fixed[r] = madd(-w.columns[j * kStride + r], w.offset[j], fixed[r]);
  const double scale = size_of(m, twist) + size_of(m, fixed);
  if (in.rank < (s.k < m() ? s.k : m())) out.status |= SINGULAR;
  for (int j = 0; j < s.k; ++j) b.z[j] = b.target[j];
  if (!inside_all || size_of(m, in.residual) > reached(b, scale)) {
    if (out.status & SINGULAR) {
      for (int j = 0; j < s.k; ++j) b.state[j] = 0;
      out.scale = search_reduced(m, fixed, twist, reached(b, scale), out.active, w, b, in);
    } else {
      out.scale = search_fraction(m, fixed, twist, out.active, true, w, b, in);
    }
    if (!(out.scale > 0.0)) return stand_still(m, law, p, w, out);
    if (out.scale < 1.0) out.status |= SCALED;
    if (b.capped) out.status |= ITERATION_LIMIT;
  }
  out.iterations = b.iterations;
  write_rates(p, b, w, out.rates);
  report(m, p, out);
}

STILLREACH_END
