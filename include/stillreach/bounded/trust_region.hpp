// The quadratic piece of a priced problem's dual (price.hpp) in its balls: (A_F A_F' + diag kappa) u = c with kappa_g =
// 0 or |u_g| = Y_g, by Newton's method on 1 / |u_g| as a function of kappa (More and Sorensen, 1983), one factorisation
// a step.
#pragma once

#include "stillreach/bounded/one_price.hpp"

STILLREACH_BEGIN

constexpr int kRegionSteps = 40;
constexpr int kMostLost = 3;  // singular matrices on a piece, before singular values are asked

// A_F A_F' + diag kappa by its Gram matrix.
template <int M>
struct GramPiece {
  Rows<M> m;
  Factor& f;
  double diagonal[kRows];
  double trace, condition;

  STILLREACH_INLINE GramPiece(Rows<M> rows, Factor& gram) : m(rows), f(gram), trace(0.0), condition(0.0) {
    for (int r = 0; r < m(); ++r) {
      diagonal[r] = f.gram[r][r];
      trace += diagonal[r];
    }
  }
  // False where it is singular, or nearly; it has a little more damping then.
  STILLREACH_INLINE bool refactor(const Priced& d) {
    for (int r = 0; r < m(); ++r) f.gram[r][r] = diagonal[r] + d.kappa[d.part[r]];
    condition = factor(m, f);
    if (condition < 1e12) return true;
    const double floor = trace > 0.0 ? 1e-11 * trace : 1.0;
    for (int r = 0; r < m(); ++r) f.gram[r][r] = diagonal[r] + larger(d.kappa[d.part[r]], floor);
    factor(m, f);
    condition = infinity();
    return false;
  }
  STILLREACH_INLINE void apply_inverse(const double* x, double* y) const { solve(m, f, x, y); }
  // c of the piece at the multiplier u.
  inline void target(const Priced& d, double* c) const {
    for (int r = 0; r < m(); ++r) {
      c[r] = madd(diagonal[r], d.u[r], d.residual[r]);
      for (int k = 0; k < m(); ++k)
        if (k != r) c[r] = madd(k < r ? f.gram[r][k] : f.gram[k][r], d.u[k], c[r]);
    }
  }
};

// Solves the count x count system in H, positive definite but for factors of its rows, with the right-hand side in its
// last column. False: it is singular.
inline bool eliminate(int count, double (*H)[kParts + 1], double* x) {
  for (int a = 0; a < count; ++a) {
    if (!(H[a][a] > 0.0)) return false;
    for (int c = a + 1; c < count; ++c) {
      const double factor = H[c][a] / H[a][a];
      for (int r = a; r <= count; ++r) H[c][r] = madd(-factor, H[a][r], H[c][r]);
    }
  }
  for (int a = count - 1; a >= 0; --a) {
    double sum = H[a][count];
    for (int c = a + 1; c < count; ++c) sum = madd(-H[a][c], x[c], sum);
    x[a] = sum / H[a][a];
    if (!is_finite(x[a])) return false;
  }
  return true;
}

// Newton's step of kappa towards |u_g| = Y_g in the active parts, on 1 / |u_g|, from the multiplier v at the factored
// kappa. A part whose kappa would fall below 0 (or far, while its |u_g| is too large) goes there, and the others are
// asked again. alone: steps of each part by itself, which from below are safe.
template <int M>
inline void newton_step(Rows<M> m, const GramPiece<M>& piece, const Priced& d, const bool* active, const double* size,
                        const double* v, double* step, double* alone) {
  double H[kParts][kParts], right[kParts], own[kRows], w[kRows];
  bool open[kParts];
  for (int g = 0; g < d.parts; ++g) {
    step[g] = alone[g] = 0.0;
    open[g] = active[g];
    if (!active[g]) continue;
    only_part(m, d, g, v, own);
    piece.apply_inverse(own, w);
    for (int h = 0; h < d.parts; ++h) {
      only_part(m, d, h, v, own);
      H[h][g] = dot(m, own, w);
    }
    right[g] = size[g] * size[g] * (size[g] / d.most[g] - 1.0);
    alone[g] = right[g] / H[g][g];
  }
  for (int round = 0; round < d.parts; ++round) {
    double system[kParts][kParts + 1], x[kParts];
    double below = 0.0, limit = 0.0;
    int index[kParts], count = 0, lowest = -1;
    for (int g = 0; g < d.parts; ++g)
      if (open[g]) index[count++] = g;
    for (int a = 0; a < count; ++a) {
      system[a][count] = right[index[a]];
      for (int c = 0; c < count; ++c) system[a][c] = H[index[a]][index[c]];
      for (int g = 0; g < d.parts; ++g)
        if (active[g] && !open[g]) system[a][count] = madd(-H[index[a]][g], step[g], system[a][count]);
    }
    if (!eliminate(count, system, x))
      for (int a = 0; a < count; ++a) x[a] = alone[index[a]];
    for (int a = 0; a < count; ++a) {
      step[index[a]] = x[a];
      const int g = index[a];
      const double least = size[g] < d.most[g] * (1.0 - 1e-9) ? 0.0 : 0.2 * d.kappa[g], kappa = d.kappa[g] + x[a];
      if (kappa < least && (lowest < 0 || kappa - least < below)) {
        lowest = g;
        below = kappa - least;
        limit = least;
      }
    }
    if (lowest < 0) return;
    open[lowest] = false;
    step[lowest] = limit - d.kappa[lowest];
  }
}

// The multiplier of the piece with damping kappa, from u and its residual, and how far each |next_g| is from Y_g.
// False: singular.
template <int M>
inline bool damped_multiplier(Rows<M> m, GramPiece<M>& piece, Priced& d, double* next, double* size, bool* active) {
  double g[kRows] = {};
  const bool regular = piece.refactor(d);
  for (int r = 0; r < m(); ++r) g[r] = madd(-d.kappa[d.part[r]], d.u[r], d.residual[r]);
  piece.apply_inverse(g, next);
  for (int r = 0; r < m(); ++r) next[r] += d.u[r];
  part_squares(m, d, next, size);
  d.excess = 0.0;
  for (int p = 0; p < d.parts; ++p) {
    size[p] = square_root(size[p]);
    const double excess = size[p] / d.most[p] - 1.0;
    active[p] = d.kappa[p] > 0.0 || excess > kTight;
    if (active[p]) d.excess = larger(d.excess, magnitude(excess));
  }
  return regular;
}

// One part: to the maximum `next` of the piece, |next| right up to `tolerance`. Leaves kappa, and the piece factored
// with it, or d.excess infinite where the matrix is singular at the kappa that is wanted. Returns the number of
// factorisations.
template <int M>
inline int trust_region(Rows<M> m, GramPiece<M>& piece, Priced& d, double tolerance, double* next) {
  double size[kParts], step[kParts], alone[kParts], above = 0.0, below = infinity();
  bool active[kParts];
  for (int count = 1, lost = 0;; ++count) {
    const bool regular = damped_multiplier(m, piece, d, next, size, active);
    if (d.excess <= tolerance || count == kRegionSteps) return count;
    if (!regular && ++lost > kMostLost) {
      d.excess = infinity();
      return count;
    }
    const double old = d.kappa[0];
    (size[0] > d.most[0] ? above : below) = old;
    newton_step(m, piece, d, active, size, next, step, alone);
    double kappa = old + step[0];
    if (above > 0.0 && below < infinity() && !(kappa > above && kappa < below))
      kappa = square_root(above) * square_root(below);
    d.kappa[0] = larger(kappa, 0.0);
    if (d.kappa[0] == old) return count;
  }
}

// Several parts: Newton's steps of all kappa together, halved where they do not lower h = c'next / 2 + sum kappa_g
// Y_g^2 / 2, which is convex in kappa and least at the maximum. Leaves d.excess infinite where they do not settle.
template <int M>
inline int trust_regions(Rows<M> m, GramPiece<M>& piece, Priced& d, double tolerance, double* next) {
  double size[kParts], step[kParts] = {}, alone[kParts], old[kParts], c[kRows], lowest = infinity(), last = infinity();
  bool active[kParts];
  int count = 1;
  piece.target(d, c);
  for (int halved = 0, lost = 0; count < 30; ++count) {
    const bool regular = damped_multiplier(m, piece, d, next, size, active);
    if (!regular && count == 1) {  // the damping of the present error
      part_squares(m, d, d.residual, size);
      for (int p = 0; p < d.parts; ++p) d.kappa[p] = larger(d.kappa[p], square_root(size[p]) / d.most[p]);
      continue;
    }
    double h = 0.5 * dot(m, c, next);
    for (int p = 0; p < d.parts; ++p) h = madd(0.5 * d.kappa[p], d.most[p] * d.most[p], h);
    if (regular && (d.excess <= tolerance || (d.excess < 1e-8 && d.excess > 0.5 * last))) return count;
    last = d.excess;
    if (regular && h <= lowest + 1e-12 * magnitude(h)) {
      lowest = smaller(h, lowest);
      halved = 0;
      newton_step(m, piece, d, active, size, next, step, alone);
      for (int p = 0; p < d.parts; ++p) old[p] = d.kappa[p];
    } else {
      if (++halved > 5 || (!regular && ++lost > 1) || lowest == infinity()) break;
      for (int p = 0; p < d.parts; ++p) step[p] *= 0.5;
    }
    for (int p = 0; p < d.parts; ++p) d.kappa[p] = larger(old[p] + step[p], 0.0);
  }
  d.excess = infinity();
  return count;
}

STILLREACH_END
