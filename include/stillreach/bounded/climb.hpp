// The rates of a multiplier of a priced problem (price.hpp), the piece of the dual that it is on, and the way along a
// segment to the dual's greatest value.
#pragma once

#include "stillreach/bounded/price.hpp"

STILLREACH_BEGIN

constexpr double kEpsilon = 2e-16;

// Under a full weight W the rates of a multiplier are a bounded problem of their own: z = argmin over the box of z'Wz /
// 2 - t'z for t in b.target. w.whole: W's factor. b.state: where its search starts, and the bounds it ends at; w.held:
// what it was.
inline STILLREACH_NOINLINE void cut_weighted(Box& b, Workspace& w) {
  const double nothing[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  double *centre = w.limit, *zeros = w.shapes;
  for (int i = 0; i < kStride * b.k; ++i) zeros[i] = 0.0;
  for (int i = 0; i < b.k; ++i) {
    centre[i] = b.target[i];
    w.held[i] = b.state[i];
  }
  solve_triangle(b.k, w.whole, false, 1, centre);
  solve_triangle(b.k, w.whole, true, 1, centre);
  Box own = b;
  own.columns = own.length = zeros;
  own.kappa = 1.0;
  own.lower = w.other;
  own.upper = w.extent;
  own.z = w.second;
  own.target = w.third;
  for (int i = 0; i < b.k; ++i) {
    w.other[i] = b.lower[i] - centre[i];
    w.extent[i] = b.upper[i] - centre[i];
  }
  Inner in;
  solve_box(Rows<0>{1}, nothing, own, in, false);
  b.iterations = own.iterations;
  for (int i = 0; i < b.k; ++i) {
    const double bound = b.state[i] > 0 ? b.upper[i] : b.lower[i];
    b.z[i] = b.state[i] != 0 ? bound : clamp(centre[i] + own.z[i], b.lower[i], b.upper[i]);
  }
}

// A'u of every variable into b.target, cut to the box into b.z, and what that leaves of rhs into d.residual.
template <int M>
inline void rates_of_multiplier(Rows<M>, const double* rhs, const double* u, Box& b, Workspace& w, Priced& d) {
  multiply_columns(b.columns, b.k, u, b.target);
  if (b.weight)
    cut_weighted(b, w);
  else
    for (int i = 0; i < b.k; ++i) b.z[i] = clamp(b.target[i], b.lower[i], b.upper[i]);
  residual_of(b.columns, nullptr, b.k, rhs, b.z, d.residual);
}

template <int M>
inline double longest_column(Rows<M> m, const Box& b) {
  double square = 0.0;
  for (int i = 0; i < b.k; ++i) square = larger(square, dot(m, b.columns + i * kStride, b.columns + i * kStride));
  return square_root(square);
}

// Rounding of A'u and of the residual at the present multiplier.
template <int M>
inline void measure_rounding(Rows<M> m, const Box& b, Priced& d) {
  double most = 0.0;
  for (int i = 0; i < b.k; ++i) most = larger(most, magnitude(b.z[i]));
  d.slack = 1e-15 * d.longest * size_of(m, d.u);
  d.rounding = kEpsilon * madd(d.longest, most, d.rhs_size);
  d.noise = madd(d.longest, d.slack, 20.0 * d.rounding);
}

// The piece at the present multiplier, as states of the variables: what differs from before by no more than rounding
// stays. Returns whether one has changed.
inline bool classify(Box& b, const Workspace& w, double slack) {
  bool changed = false;
  for (int i = 0; i < b.k; ++i) {
    const std::int8_t was = b.weight ? w.held[i] : b.state[i];
    if (!b.weight) {
      const double over = b.target[i] - b.upper[i], under = b.lower[i] - b.target[i];
      const double off = was > 0 ? -over : was < 0 ? -under : larger(over, under);
      if (off > slack) b.state[i] = over > 0.0 ? 1 : under > 0.0 ? -1 : 0;
    }
    changed |= b.state[i] != was;
  }
  return changed;
}

// Along `way` under a weight to where the dual is greatest, by its slope alone.
template <int M>
inline void bracket_top(Rows<M> m, const double* rhs, const double* from, const double* way, double rise, double fall,
                        Box& b, Workspace& w, Priced& d) {
  const double enough = 0.1 * rise;
  double low = 0.0, high = 1.0;
  for (int step = 0; step < 50; ++step) {
    const double part = step % 2 == 1 ? 0.5 * (low + high) : low + (high - low) * (rise / (rise - fall));
    for (int r = 0; r < m(); ++r) d.u[r] = madd(part, way[r], from[r]);
    rates_of_multiplier(m, rhs, d.u, b, w, d);
    const double slope = dot(m, way, d.residual);
    if (magnitude(slope) <= enough) return;
    if (slope > 0.0) {
      low = part;
      rise = slope;
    } else {
      high = part;
      fall = slope;
    }
  }
}

// From u with its rates towards `next`: all the way, or to where the dual is greatest between them, or nowhere because
// rounding is all that is left to gain.
enum class Climb { TOP, PARTLY, NOWHERE };

template <int M>
inline Climb climb(Rows<M> m, const double* rhs, const double* next, bool careful, Box& b, Workspace& w, Priced& d) {
  double from[kStride], way[kStride];
  for (int r = 0; r < kStride; ++r) {
    from[r] = d.u[r];
    way[r] = next[r] - from[r];
    d.u[r] = next[r];
  }
  const double start = dot(m, way, d.residual),
               noise = madd(d.noise, size_of(m, way), 1e-15 * size_of(m, next) * size_of(m, d.residual));
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  const double end = dot(m, way, d.residual);
  if (end >= -larger(0.1 * start, noise)) return Climb::TOP;
  const bool nowhere = !(start > noise);
  if (nowhere && careful) return Climb::TOP;  // its rates come from singular values
  if (b.weight && !nowhere) return bracket_top(m, rhs, from, way, start, end, b, w, d), Climb::PARTLY;
  for (int r = 0; r < kStride; ++r) d.u[r] = from[r];
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  if (nowhere) return Climb::NOWHERE;
  double* const speed = b.work;
  multiply_columns(b.columns, b.k, way, speed);
  const double part = top_of_segment(b.k, b.target, speed, b.lower, b.upper, start, true);
  for (int i = 0; i < b.k; ++i) {
    const double was = b.state[i], there = madd(part, speed[i], b.target[i]);
    b.state[i] = static_cast<std::int8_t>(side_of(was, there, b.lower[i], b.upper[i], 0.0));
  }
  for (int r = 0; r < m(); ++r) d.u[r] = madd(part, way[r], from[r]);
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  return Climb::PARTLY;
}

STILLREACH_END
