// What a priced problem is (price_search.hpp solves it): of all z in the box those that minimise sum_g Y_g |(b - A
// z)_g| + |z|^2 / 2, the error of each part g of the rows not squared. Its dual has at most six variables: max over
// |u_g| <= Y_g of d(u) = b'u + min over the box of |z|^2 / 2 - u'A z, with the rates z(u) = A'u cut to the box and the
// gradient b - A z(u).
#pragma once

#include "stillreach/bounded/careful.hpp"
#include "stillreach/linear/rotations.hpp"

STILLREACH_BEGIN

constexpr int kTopSteps = 50;     // most points that are tried along a segment
constexpr double kLevel = 1e-10;  // part of the slope at its start that counts as none

struct Priced {
  int parts;
  const std::int8_t* part;   // of each row
  double most[kParts];       // Y_g
  double kappa[kParts];      // |error of g| / Y_g, the damping
  double u[kStride];         // the multiplier, zeros behind
  double residual[kStride];  // b - A z(u)
  double excess;             // relative error of the |u_g| that should be Y_g
  double rhs_size, longest;  // |b|, and of the columns
  double slack;              // rounding of A'u,
  double noise;              // of the residual of rates that are A'u,
  double rounding;           // and of the residual of any rates
  int rejected;              // answers that the dual does not confirm
};

template <int M>
STILLREACH_INLINE void part_squares(Rows<M> m, const Priced& d, const double* v, double* square) {
  if (d.parts == 1) {
    square[0] = dot(m, v, v);
    return;
  }
  for (int g = 0; g < d.parts; ++g) square[g] = 0.0;
  for (int r = 0; r < m(); ++r) square[d.part[r]] = madd(v[r], v[r], square[d.part[r]]);
}

// Whether |v_g| <= Y_g for every part.
template <int M>
STILLREACH_INLINE bool affordable(Rows<M> m, const Priced& d, const double* v) {
  double square[kParts];
  part_squares(m, d, v, square);
  bool all = true;
  for (int g = 0; g < d.parts; ++g) all &= square[g] <= d.most[g] * d.most[g];
  return all;
}

// Brings each v_g into its ball.
template <int M>
STILLREACH_INLINE void afford(Rows<M> m, const Priced& d, double* v) {
  double square[kParts];
  part_squares(m, d, v, square);
  for (int g = 0; g < d.parts; ++g) {
    if (square[g] <= d.most[g] * d.most[g]) continue;
    const double factor = d.most[g] / square_root(square[g]);
    for (int r = 0; r < m(); ++r)
      if (d.part[r] == g) v[r] *= factor;
  }
}

// Makes |v_g| = Y_g where part g is damped.
template <int M>
STILLREACH_INLINE void spend(Rows<M> m, const Priced& d, double* v) {
  double square[kParts];
  part_squares(m, d, v, square);
  for (int g = 0; g < d.parts; ++g) {
    if (!(d.kappa[g] > 0.0 && square[g] > 0.0)) continue;
    const double factor = d.most[g] / square_root(square[g]);
    for (int r = 0; r < m(); ++r)
      if (d.part[r] == g) v[r] *= factor;
  }
}

// On which side a variable is whose rate A'u would be `target`; what differs from before, `was`, by no more than
// rounding stays.
template <class T>
STILLREACH_INLINE T side_of(T was, T target, T lower, T upper, T slack) {
  const T zero = fill<T>(0.0), over = target - upper, under = lower - target;
  const T off = select(was > zero, -over, select(was < zero, -under, larger(over, under)));
  const T now = select(over > zero, fill<T>(1.0), select(under > zero, fill<T>(-1.0), zero));
  return select(off > slack, now, was);
}

// How far along a segment, 0 to 1, the dual rises, where A'u goes from `target` at `speed` and the slope is `rise` at
// first and negative at the end. It falls, in straight pieces: Newton's method in a bracket, which a step that leaves
// it divides, by orders of magnitude at first. open: the lanes that are asked.
template <class T, class Where>
STILLREACH_INLINE T top_of_segment(int k, const T* target, const T* speed, const T* lower, const T* upper, T rise,
                                   Where open) {
  const T zero = fill<T>(0.0);
  T low = zero, high = fill<T>(1.0), at = zero, slope = rise, curvature = zero;
  for (int i = 0; i < k; ++i) {
    const Where free = (target[i] < upper[i]) & (target[i] > lower[i]);
    curvature = select(free, madd(speed[i], speed[i], curvature), curvature);
  }
  for (int step = 0; step < kTopSteps; ++step) {
    const T newton = at + slope / curvature, far = high * fill<T>(step < 4 ? 0.25 : 1e-8);
    const T between = select(high > 16.0 * low, square_root(low) * square_root(high), 0.5 * (low + high));
    const T other = select(low > zero, between, far);
    at = select(open, select((newton > low) & (newton < high), newton, other), at);
    slope = rise;
    curvature = zero;
    for (int i = 0; i < k; ++i) {
      const T there = madd(at, speed[i], target[i]), z = larger(smaller(there, upper[i]), lower[i]);
      slope = madd(-speed[i], z - larger(smaller(target[i], upper[i]), lower[i]), slope);
      curvature = select(z == there, madd(speed[i], speed[i], curvature), curvature);
    }
    open = except(open, (magnitude(slope) <= kLevel * rise));
    if (!any(open)) break;
    low = select(slope > zero, at, low);
    high = select(slope > zero, high, at);
  }
  return at;
}

// v with the rows of part g alone.
template <int M>
STILLREACH_INLINE void only_part(Rows<M> m, const Priced& d, int g, const double* v, double* part) {
  for (int r = 0; r < m(); ++r) part[r] = d.part[r] == g ? v[r] : 0.0;
}

STILLREACH_END
