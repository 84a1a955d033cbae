// Maximises the dual of a priced problem (price.hpp). Each step takes the quadratic piece at u, that of the variables which are free
// there, goes to its maximum (trust_region.hpp) and searches along the segment between; a concave function of finitely many pieces.
#pragma once

#include "stillreach/bounded/trust_region.hpp"

STILLREACH_BEGIN

constexpr int kPriceSteps = 60;         // most pieces
constexpr int kPatience = 20;           // of which without singular values,
constexpr double kConfirmed = 1e4;      // a gap of so many times what is enough is not rounding
constexpr int kUndisturbed = 8;         // and before the best answer so far may do
constexpr double kLoose = 0.1;          // relative error of |u_g| on a piece that may not be the last
constexpr double kRestRounding = 16.0;  // a right-hand side that no column reaches counts from so many times the rounding

// Under a full weight W the rates of a multiplier are a bounded problem of their own: z = argmin over the box of z'Wz / 2 - t'z for t in
// b.target. w.whole: W's factor. b.state: where its search starts, and the bounds it ends at;
// w.held: what it was.
inline STILLREACH_NOINLINE void cut_weighted(Box& b, Workspace& w) {
  const double nothing[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  double *centre = w.limit, *zeros = w.shapes;
  for (int i = 0; i < kStride * b.k; ++i) zeros[i] = 0.0;
  for (int i = 0; i < b.k; ++i) centre[i] = b.target[i], w.held[i] = b.state[i];
  solve_triangle(b.k, w.whole, false, 1, centre);
  solve_triangle(b.k, w.whole, true, 1, centre);
  Box own = b;
  own.columns = own.length = zeros, own.kappa = 1.0, own.lower = w.other, own.upper = w.extent, own.z = w.second, own.target = w.third;
  for (int i = 0; i < b.k; ++i) w.other[i] = b.lower[i] - centre[i], w.extent[i] = b.upper[i] - centre[i];
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

// Rounding of A'u and of the residual at the present multiplier. longest: of the columns.
template <int M>
inline void measure_rounding(Rows<M> m, double rhs_size, double longest, const Box& b, Priced& d) {
  double most = 0.0;
  for (int i = 0; i < b.k; ++i) most = larger(most, magnitude(b.z[i]));
  d.slack = 1e-15 * longest * size_of(m, d.u), d.rounding = 2e-16 * (rhs_size + longest * most);
  d.noise = madd(longest, d.slack, 20.0 * d.rounding);
}

// The piece at the present multiplier, as states of the variables: what differs from before by no more than rounding stays. Returns
// whether one has changed.
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

// How far along `way` the dual rises from the present multiplier, where its slope is `rise`: from piece to piece, b.state holding the
// one that is reached. A'u is in b.target, A'way comes into b.work.
template <int M>
inline double scan_pieces(Rows<M> m, const double* way, double rise, Box& b) {
  double *speed = b.work, curvature = 0.0, at = 0.0;
  for (int i = 0; i < b.k; ++i) {
    speed[i] = dot(m, b.columns + i * kStride, way);
    if (b.state[i] == 0) curvature = madd(speed[i], speed[i], curvature);
  }
  for (int event = 0; event < 2 * b.k; ++event) {
    int next = -1;
    double nearest = 1.0;
    for (int i = 0; i < b.k; ++i) {
      const int side = speed[i] > 0.0 ? 1 : -1;
      if (b.state[i] == side || speed[i] == 0.0) continue;
      const double bound = (side > 0) == (b.state[i] == 0) ? b.upper[i] : b.lower[i];
      const double there = larger((bound - b.target[i]) / speed[i], at);
      if (there < nearest) nearest = there, next = i;
    }
    const double fall = curvature * (nearest - at);
    if (next < 0 || fall >= rise) return curvature > 0.0 ? smaller(at + rise / curvature, 1.0) : 1.0;
    rise -= fall, at = nearest;
    const bool leaves = b.state[next] == 0;
    curvature = larger(madd(leaves ? -speed[next] : speed[next], speed[next], curvature), 0.0);
    b.state[next] = static_cast<std::int8_t>(leaves ? (speed[next] > 0.0 ? 1 : -1) : 0);
  }
  return at;
}

// The same under a weight, by its slope alone.
template <int M>
inline void bracket_top(Rows<M> m, const double* rhs, const double* from, const double* way, double rise, double fall, Box& b, Workspace& w,
                        Priced& d) {
  const double enough = 0.1 * rise;
  double low = 0.0, high = 1.0;
  for (int step = 0; step < 50; ++step) {
    const double part = step % 2 == 1 ? 0.5 * (low + high) : low + (high - low) * (rise / (rise - fall));
    for (int r = 0; r < m(); ++r) d.u[r] = madd(part, way[r], from[r]);
    rates_of_multiplier(m, rhs, d.u, b, w, d);
    const double slope = dot(m, way, d.residual);
    if (magnitude(slope) <= enough) return;
    if (slope > 0.0)
      low = part, rise = slope;
    else
      high = part, fall = slope;
  }
}

// From u with its rates towards `next`: all the way, or to where the dual is greatest between them, or nowhere because rounding is all
// that is left to gain.
enum Climb { TOP, PARTLY, NOWHERE };

template <int M>
inline Climb climb(Rows<M> m, const double* rhs, const double* next, bool careful, Box& b, Workspace& w, Priced& d) {
  double from[kStride], way[kStride];
  for (int r = 0; r < kStride; ++r) from[r] = d.u[r], way[r] = next[r] - from[r], d.u[r] = next[r];
  const double start = dot(m, way, d.residual), noise = madd(d.noise, size_of(m, way), 1e-15 * size_of(m, next) * size_of(m, d.residual));
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  const double end = dot(m, way, d.residual);
  if (end >= -larger(0.1 * start, noise)) return TOP;
  const bool nowhere = !(start > noise);
  if (nowhere && careful) return TOP;  // its rates come from singular values
  if (b.weight && !nowhere) return bracket_top(m, rhs, from, way, start, end, b, w, d), PARTLY;
  for (int r = 0; r < kStride; ++r) d.u[r] = from[r];
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  if (nowhere) return NOWHERE;
  const double part = scan_pieces(m, way, start, b);
  for (int r = 0; r < m(); ++r) d.u[r] = madd(part, way[r], from[r]);
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  return PARTLY;
}

// The free variables from the multiplier by singular values: z = V diag(sigma) U'u. Where sigma is large it comes from the residual instead,
// because u, which may be large, is rounded.
template <int M>
inline void careful_rates(Rows<M> m, const Spectrum& s, const double* c, const Priced& d, const double* u, int free, Box& b) {
  double y[kStride] = {0, 0, 0, 0, 0, 0, 0, 0}, damped[kRows];
  const double u_size = size_of(m, u), c_size = size_of(m, c);
  for (int r = 0; r < m(); ++r) damped[r] = c[r] - d.kappa[d.part[r]] * u[r];
  for (int j = 0; j < s.rank; ++j) {
    const double* left = s.left[j];
    const double along = u_size * s.sigma[j] * s.sigma[j] > c_size ? dot(m, left, damped) / s.sigma[j] : s.sigma[j] * dot(m, left, u);
    for (int r = 0; r < s.count; ++r) y[r] = madd(along, s.right[j][r], y[r]);
  }
  double* z = b.work + kRows * b.k;
  apply_reflections(s, y, z);
  for (int j = 0; j < free; ++j) b.z[b.index[j]] = clamp(z[j], b.lower[b.index[j]], b.upper[b.index[j]]);
}

// The free variables' columns, whitened where there is a weight. Returns how many; index: null where they lie one behind the other.
inline int free_columns(Box& b, const double*& columns, const int*& index) {
  int free = 0;
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] == 0) b.index[free++] = i;
  columns = b.columns, index = b.index;
  if (!b.weight) return free;
  factor_weight(b.k, b.weight, b.index, free, b.triangle);
  for (int j = 0; j < free; ++j)
    for (int r = 0; r < kStride; ++r) b.whitened[j * kStride + r] = b.columns[b.index[j] * kStride + r];
  solve_triangle(free, b.triangle, false, kStride, b.whitened);
  columns = b.whitened, index = nullptr;
  return free;
}

// c of the piece: what the fixed variables leave of rhs; under a weight, where they pull at the free ones, by way of the multiplier.
template <int M>
inline void piece_target(Rows<M> m, const double* rhs, const double* columns, int free, const Box& b, const Priced& d, double* c) {
  for (int r = 0; r < kStride; ++r) c[r] = b.weight ? d.residual[r] : rhs[r];
  if (b.weight)
    for (int j = 0; j < free; ++j) {
      const double* a = columns + j * kStride;
      const double along = dot(m, a, d.u);
      for (int r = 0; r < m(); ++r) c[r] = madd(along, a[r], c[r]);
    }
  else
    for (int i = 0; i < b.k; ++i)
      if (b.state[i] != 0)
        for (int r = 0; r < m(); ++r) c[r] = madd(-b.columns[i * kStride + r], b.z[i], c[r]);
}

// The best multiplier so far: the primal objective of its rates is above the dual's by `gap`, which proves how good they are.
struct Best {
  double gap, enough, u[kStride], kappa[kParts];
};

template <int M>
inline void remember(Rows<M> m, const Priced& d, Best& best) {
  double square[kParts], gap = -dot(m, d.u, d.residual), enough = 0.0;
  part_squares(m, d, d.residual, square);
  for (int g = 0; g < d.parts; ++g) {
    const double cost = d.most[g] * square_root(square[g]);
    gap += cost, enough += 1e-14 * cost + 8.0 * d.most[g] * d.rounding;
  }
  if (!(gap < best.gap)) return;
  best.gap = gap, best.enough = enough;
  for (int r = 0; r < kStride; ++r) best.u[r] = d.u[r];
  for (int g = 0; g < d.parts; ++g) best.kappa[g] = d.kappa[g];
}

// One step with singular values. True where its maximum is on the same piece, and the answer.
template <int M>
inline STILLREACH_NOINLINE bool careful_step(Rows<M> m, const double* rhs, Box& b, Workspace& w, Priced& d) {
  const double* columns;
  const int* index;
  const int free = free_columns(b, columns, index);
  double c[kStride], next[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  piece_target(m, rhs, columns, free, b, d, c);
  Spectrum s;
  spectrum(m(), columns, index, free, 0.0, b.work, s);
  double rest[kRows];
  double outside = out_of_reach(m, s, c, rest);
  if (outside <= kRestRounding * d.rounding) {
    for (int r = 0; r < m(); ++r) c[r] = madd(-outside, rest[r], c[r]);
    outside = 0.0;
  }
  if (d.parts == 1) {
    solve_secular(m, s, c, rest, outside, d.most[0], d.kappa[0], next);
    ++b.iterations;
  } else {
    CarefulPiece<M> piece(m, s);
    for (int g = 0; g < d.parts; ++g) {
      d.least[g] = 1e-9 * d.rounding / d.most[g];
      if (outside == 0.0 && s.rank < m()) d.kappa[g] = 0.0;  // the task can be done: whether at these prices, ratios of kappa tell
    }
    b.iterations += trust_regions(m, piece, d, c, kTight, next);
    for (int g = 0; g < d.parts; ++g) d.least[g] = 0.0;
  }
  afford(m, d, next);
  if (climb(m, rhs, next, true, b, w, d) == PARTLY || classify(b, w, d.slack)) return false;
  if (!b.weight) careful_rates(m, s, c, d, next, free, b);
  if (d.parts == 1) return true;
  residual_of(b.columns, nullptr, b.k, rhs, b.z, d.residual);
  Best now{infinity(), 0.0, {}, {}};
  remember(m, d, now);
  if (now.gap <= kConfirmed * now.enough) return true;
  ++d.rejected;
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  return false;
}

// One more step on the last piece, added to the rates: they keep digits that A'u, of a large u, does not have.
template <int M>
inline void polish(Rows<M> m, const double* rhs, const Factor& f, int free, Box& b, Workspace& w, Priced& d) {
  double g[kRows] = {}, change[kRows];
  for (int r = 0; r < m(); ++r) g[r] = madd(-d.kappa[d.part[r]], d.u[r], d.residual[r]);
  solve(m, f, g, change);
  for (int r = 0; r < m(); ++r) d.u[r] += change[r];
  spend(m, d, d.u);
  if (b.weight) return rates_of_multiplier(m, rhs, d.u, b, w, d);
  for (int j = 0; j < free; ++j) {
    const int i = b.index[j];
    b.z[i] = clamp(b.z[i] + dot(m, b.columns + i * kStride, change), b.lower[i], b.upper[i]);
  }
}

// From the multiplier in d.u, which is in its balls, with d.kappa nearby, to the answer in b.z. known: it may be on the last piece
// already. b.capped: too many pieces.
template <int M>
inline void search_price(Rows<M> m, const double* rhs, bool known, Box& b, Workspace& w, Priced& d) {
  bool careful = false, settled = false;
  for (int i = 0; i < b.k; ++i) b.state[i] = 0;
  b.capped = false, d.rejected = 0;
  Best best{infinity(), 0.0, {}, {}};
  if (b.weight) factor_weight(b.k, b.weight, nullptr, b.k, w.whole);
  const double rhs_size = size_of(m, rhs), longest = longest_column(m, b);
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  classify(b, w, 0.0);
  for (int step = 0; step < kPriceSteps; ++step) {
    measure_rounding(m, rhs_size, longest, b, d);
    if (step > kUndisturbed || d.rejected > 0) {
      remember(m, d, best);
      if (best.gap <= best.enough || d.rejected > 3) break;
    }
    if (careful || step > kPatience) {
      if (careful_step(m, rhs, b, w, d)) return;
      continue;
    }
    const double* columns;
    const int* index;
    const int free = free_columns(b, columns, index);
    double next[kStride];
    Factor f;
    gram(m, columns, index, free, 0.0, f);
    GramPiece<M> piece(m, f);
    const double tolerance = known ? kTight : kLoose;
    for (int r = m(); r < kStride; ++r) next[r] = 0.0;
    if (d.parts == 1) {
      b.iterations += trust_region(m, piece, d, tolerance, next);
    } else {
      double c[kRows];
      piece.target(d, c);
      b.iterations += trust_regions(m, piece, d, c, tolerance, next);
    }
    afford(m, d, next);
    const Climb climbed = climb(m, rhs, next, false, b, w, d);
    careful = climbed == NOWHERE || d.excess > kLoose;
    const bool same = climbed == TOP && !classify(b, w, d.slack), tight = same && d.excess <= kTight;
    if (tight && (settled || piece.condition < kPlainCondition)) return polish(m, rhs, f, free, b, w, d);
    careful |= tight && !(piece.condition < kPieceCondition);
    known = same, settled = tight;
  }
  // Pieces that rounding chooses, one after the other.
  for (int r = 0; r < kStride; ++r) d.u[r] = best.u[r];
  for (int g = 0; g < d.parts; ++g) d.kappa[g] = best.kappa[g];
  for (int i = 0; i < b.k; ++i) b.state[i] = 0;
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  classify(b, w, 0.0);
  b.capped = !(best.gap <= best.enough);
}

STILLREACH_END
