// Maximises the dual of a priced problem (price.hpp). Each step takes the quadratic piece at u, that of the variables
// which are free there, goes to its maximum (trust_region.hpp) and searches along the segment between; a concave
// function of finitely many pieces.
#pragma once

#include "stillreach/bounded/climb.hpp"
#include "stillreach/bounded/interior.hpp"

STILLREACH_BEGIN

constexpr int kPriceSteps = 20;     // most pieces, beside one a joint; half of them without singular values,
constexpr double kConfirmed = 4.0;  // a gap of so many times what is enough is not rounding
constexpr int kUndisturbed = 8;     // and before the best answer so far may do
constexpr double kLoose = 0.02;     // relative error of |u_g| on a piece that may not be the last
constexpr double kRestRounding =
    16.0;  // a right-hand side that no column reaches counts from so many times the rounding

// The free variables from the multiplier by singular values: z = V diag(sigma) U'u. Where sigma is large it comes from
// the residual instead, because u, which may be large, is rounded.
template <int M>
inline void careful_rates(Rows<M> m, const Spectrum& s, const double* c, const Priced& d, const double* u, int free,
                          Box& b) {
  double y[kStride] = {0, 0, 0, 0, 0, 0, 0, 0}, damped[kRows];
  const double u_size = size_of(m, u), c_size = size_of(m, c);
  for (int r = 0; r < m(); ++r) damped[r] = c[r] - d.kappa[d.part[r]] * u[r];
  for (int j = 0; j < s.rank; ++j) {
    const double* left = s.left[j];
    const double along =
        u_size * s.sigma[j] * s.sigma[j] > c_size ? dot(m, left, damped) / s.sigma[j] : s.sigma[j] * dot(m, left, u);
    for (int r = 0; r < s.count; ++r) y[r] = madd(along, s.right[j][r], y[r]);
  }
  double* z = b.work + kRows * b.k;
  apply_reflections(s, y, z);
  for (int j = 0; j < free; ++j) b.z[b.index[j]] = clamp(z[j], b.lower[b.index[j]], b.upper[b.index[j]]);
}

// The free variables' columns, whitened where there is a weight. Returns how many; index: null where they lie one
// behind the other.
inline int free_columns(Box& b, const double*& columns, const int*& index) {
  int free = 0;
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] == 0) b.index[free++] = i;
  columns = b.columns;
  index = b.index;
  if (!b.weight) return free;
  factor_weight(b.k, b.weight, b.index, free, b.triangle);
  for (int j = 0; j < free; ++j)
    for (int r = 0; r < kStride; ++r) b.whitened[j * kStride + r] = b.columns[b.index[j] * kStride + r];
  solve_triangle(free, b.triangle, false, kStride, b.whitened);
  columns = b.whitened;
  index = nullptr;
  return free;
}

// c of the piece: what the fixed variables leave of rhs; under a weight, where they pull at the free ones, by way of
// the multiplier.
template <int M>
inline void piece_target(Rows<M> m, const double* rhs, const double* columns, int free, const Box& b, const Priced& d,
                         double* c) {
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

// Variables that are fixed in the piece are at their bounds, where A'u is inside by no more than rounding too.
inline void hold_fixed(Box& b) {
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] != 0) b.z[i] = b.state[i] > 0 ? b.upper[i] : b.lower[i];
}

// The best multiplier so far: the primal objective of its rates is above the dual's by `gap`, which proves how good
// they are.
struct Best {
  double gap, enough, u[kStride], kappa[kParts];
};

template <int M>
inline void remember(Rows<M> m, const Priced& d, Best& best) {
  double square[kParts], gap = -dot(m, d.u, d.residual), enough = 0.0;
  part_squares(m, d, d.residual, square);
  for (int g = 0; g < d.parts; ++g) {
    const double cost = d.most[g] * square_root(square[g]);
    gap += cost;
    enough += 1e-14 * cost + 8.0 * d.most[g] * d.rounding;
  }
  if (!(gap < best.gap)) return;
  best.gap = gap;
  best.enough = enough;
  for (int r = 0; r < kStride; ++r) best.u[r] = d.u[r];
  for (int g = 0; g < d.parts; ++g) best.kappa[g] = d.kappa[g];
}

// Whether the error of part g is more than rounding.
STILLREACH_INLINE bool gives_way(const Priced& d, int g) { return d.kappa[g] * d.most[g] > kRestRounding * d.rounding; }

// The piece's maxima are `next` and all that no free column and no damped part sees a difference to. Takes the one
// nearest to the present multiplier, which is likeliest to be on the piece.
template <int M>
inline void keep_unseen(Rows<M> m, const Spectrum& s, const Priced& d, double* next) {
  double seen[kRows][kRows], way[kRows];
  bool damped[kParts];
  int count = 0;
  for (int g = 0; g < d.parts; ++g) damped[g] = gives_way(d, g);
  for (int r = 0; r < m(); ++r) way[r] = damped[d.part[r]] ? 0.0 : d.u[r] - next[r];
  for (int j = 0; j < s.rank; ++j) {
    double* v = seen[count];
    for (int r = 0; r < m(); ++r) v[r] = damped[d.part[r]] ? 0.0 : s.left[j][r];
    make_orthogonal(m, seen, count, v);
    const double length = size_of(m, v);
    if (!(length > 1e-12)) continue;
    for (int r = 0; r < m(); ++r) v[r] /= length;
    ++count;
  }
  make_orthogonal(m, seen, count, way);
  double square[kParts], along[kParts] = {}, turn[kParts], far = 1.0;
  part_squares(m, d, next, square);
  part_squares(m, d, way, turn);
  for (int r = 0; r < m(); ++r) along[d.part[r]] = madd(next[r], way[r], along[d.part[r]]);
  for (int g = 0; g < d.parts; ++g) {
    const double room = larger(d.most[g] * d.most[g] - square[g], 0.0);
    if (damped[g] || !(turn[g] > 0.0)) continue;
    const double root = square_root(madd(along[g], along[g], turn[g] * room));
    far = smaller(far, along[g] > 0.0 ? room / (root + along[g]) : (root - along[g]) / turn[g]);
  }
  for (int r = 0; r < m(); ++r) next[r] = madd(far, way[r], next[r]);
}

// One step with singular values. True where its maximum is on the same piece, and the answer.
template <int M>
inline STILLREACH_NOINLINE bool careful_step(Rows<M> m, const double* rhs, Box& b, Workspace& w, Priced& d) {
  const double* columns;
  const int* index;
  const int free = free_columns(b, columns, index);
  double c[kStride], next[kStride] = {0, 0, 0, 0, 0, 0, 0, 0};
  if (!b.weight) hold_fixed(b);
  piece_target(m, rhs, columns, free, b, d, c);
  double most = 0.0;
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] != 0) most = larger(most, magnitude(b.z[i]));
  d.rounding = kEpsilon * (madd(d.longest, most, d.rhs_size) + size_of(m, c));
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
    CarefulPiece<M> piece(m, s, d);
    b.iterations += Interior<M>(m, piece, d).solve(c, next);
  }
  keep_unseen(m, s, d, next);
  afford(m, d, next);
  if (climb(m, rhs, next, true, b, w, d) == Climb::PARTLY) return false;
  const bool same = !classify(b, w, d.slack);
  if (same && !b.weight) {
    hold_fixed(b);
    careful_rates(m, s, c, d, next, free, b);
  }
  if (same && d.parts == 1) return true;
  if (same) residual_of(b.columns, nullptr, b.k, rhs, b.z, d.residual);
  measure_rounding(m, b, d);
  Best now{infinity(), 0.0, {}, {}};
  remember(m, d, now);
  if (same && now.gap <= kConfirmed * now.enough) return true;
  d.rejected += same || now.gap <= now.enough;
  if (same) rates_of_multiplier(m, rhs, d.u, b, w, d);
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

// How the error of damped part g changes with its price, at the answer: from |u_h| = Y_h in the damped parts. 0: not
// known.
template <int M>
inline double error_slope(Rows<M> m, int g, Box& b, const Priced& d) {
  const double* columns;
  const int* index;
  const int free = free_columns(b, columns, index);
  Factor f;
  gram(m, columns, index, free, 0.0, f);
  GramPiece<M> piece(m, f);
  if (!piece.refactor(d)) return 0.0;
  double system[kParts][kParts + 1], x[kParts], own[kRows], w[kRows];
  int damped[kParts], count = 0, at = 0;
  for (int p = 0; p < d.parts; ++p)
    if (gives_way(d, p)) {
      at = p == g ? count : at;
      damped[count++] = p;
    }
  for (int c = 0; c < count; ++c) {
    only_part(m, d, damped[c], d.u, own);
    piece.apply_inverse(own, w);
    for (int a = 0; a < count; ++a) {
      only_part(m, d, damped[a], d.u, own);
      system[a][c] = dot(m, own, w);
    }
    system[c][count] = c == at ? -d.most[g] : 0.0;
  }
  return eliminate(count, system, x) ? madd(d.most[g], x[at], d.kappa[g]) : 0.0;
}

// From the multiplier in d.u, which is in its balls, with d.kappa nearby, to the answer in b.z. known: it may be on the
// last piece already. first: null, or where the first step goes. b.capped: too many pieces.
template <int M>
inline void search_price(Rows<M> m, const double* rhs, bool known, const double* first, Box& b, Workspace& w,
                         Priced& d) {
  bool careful = false, settled = false;
  for (int i = 0; i < b.k; ++i) b.state[i] = 0;
  b.capped = false;
  d.rejected = 0;
  Best best{infinity(), 0.0, {}, {}};
  if (b.weight) factor_weight(b.k, b.weight, nullptr, b.k, w.whole);
  d.rhs_size = size_of(m, rhs);
  d.longest = longest_column(m, b);
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  classify(b, w, 0.0);
  const int most = kPriceSteps + b.k;
  for (int step = 0; step < most; ++step) {
    measure_rounding(m, b, d);
    if (step == 0 && first) {
      climb(m, rhs, first, false, b, w, d);
      classify(b, w, d.slack);
      continue;
    }
    if ((step > kUndisturbed && !known) || d.rejected > 0) {
      remember(m, d, best);
      if ((best.gap <= best.enough && d.rejected != 1) || d.rejected > 3) break;
    }
    if (careful || 2 * step > most) {
      remember(m, d, best);
      if (best.gap <= best.enough) break;  // proven without
      if (careful_step(m, rhs, b, w, d)) return;
      careful = known = settled = false;
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
      b.iterations += trust_regions(m, piece, d, tolerance, next);
    }
    afford(m, d, next);
    const Climb climbed = climb(m, rhs, next, false, b, w, d);
    careful = d.excess > kLoose || (climbed == Climb::NOWHERE && known);
    const bool same = climbed == Climb::TOP && !classify(b, w, d.slack), tight = same && d.excess <= kTight;
    if (tight && (settled || piece.condition < kPlainCondition)) return polish(m, rhs, f, free, b, w, d);
    careful |= tight && !(piece.condition < kPieceCondition);
    known = same || climbed == Climb::NOWHERE;
    settled = tight;
  }
  // Pieces that rounding chooses, one after the other.
  for (int r = 0; r < kStride; ++r) d.u[r] = best.u[r];
  for (int g = 0; g < d.parts; ++g) d.kappa[g] = best.kappa[g];
  for (int i = 0; i < b.k; ++i) b.state[i] = 0;
  rates_of_multiplier(m, rhs, d.u, b, w, d);
  classify(b, w, 0.0);
  b.capped = !(best.gap <= kConfirmed * best.enough);
}

STILLREACH_END
