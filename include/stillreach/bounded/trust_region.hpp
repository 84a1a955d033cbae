// The quadratic piece of a priced problem's dual (price.hpp) in its balls: (A_F A_F' + diag kappa) u = c with kappa_g = 0 or |u_g| = Y_g,
// by Newton's method on 1 / |u_g| as a function of kappa (More and Sorensen, 1983), one factorisation a step.
#pragma once

#include "stillreach/bounded/one_price.hpp"

STILLREACH_BEGIN

constexpr int kRegionSteps = 40;

// A_F A_F' + diag kappa by its Gram matrix.
template <int M>
struct GramPiece {
  Rows<M> m;
  Factor& f;
  double diagonal[kRows];
  double trace, condition;
  static constexpr bool careful = false;

  STILLREACH_INLINE GramPiece(Rows<M> rows, Factor& gram) : m(rows), f(gram), trace(0.0), condition(0.0) {
    for (int r = 0; r < m(); ++r) diagonal[r] = f.gram[r][r], trace += diagonal[r];
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

// The same in the basis of A_F's left singular vectors, where what is large stands apart from what is small: factors of the matrix
// ordered by its diagonal keep their digits.
template <int M>
struct CarefulPiece {
  Rows<M> m;
  double basis[kRows][kRows] = {}, lambda[kRows] = {};
  double lower[kRows][kRows], pivot[kRows];
  int order[kRows];
  static constexpr bool careful = true;

  inline CarefulPiece(Rows<M> rows, const Spectrum& s) : m(rows) {
    int count = 0;
    for (; count < s.rank; ++count) {
      lambda[count] = s.sigma[count] * s.sigma[count];
      for (int r = 0; r < m(); ++r) basis[count][r] = s.left[count][r];
    }
    for (int axis = 0; count < m() && axis < m(); ++axis) {  // the rest of the space
      double* v = basis[count];
      for (int r = 0; r < m(); ++r) v[r] = r == axis ? 1.0 : 0.0;
      make_orthogonal(m, basis, count, v);
      const double length = size_of(m, v);
      if (!(length > 0.3)) continue;
      for (int r = 0; r < m(); ++r) v[r] /= length;
      lambda[count++] = 0.0;
    }
  }

  inline bool refactor(const Priced& d) {
    double matrix[kRows][kRows];
    for (int i = 0; i < m(); ++i)
      for (int j = 0; j <= i; ++j) {
        double sum = i == j ? lambda[i] : 0.0;
        for (int r = 0; r < m(); ++r) sum = madd(d.kappa[d.part[r]] * basis[i][r], basis[j][r], sum);
        matrix[i][j] = matrix[j][i] = sum;
      }
    for (int j = 0; j < m(); ++j) {
      int at = j;
      for (; at > 0 && matrix[order[at - 1]][order[at - 1]] < matrix[j][j]; --at) order[at] = order[at - 1];
      order[at] = j;
    }
    for (int j = 0; j < m(); ++j) {
      const int at = order[j];
      double sum = matrix[at][at];
      for (int k = 0; k < j; ++k) {
        double entry = matrix[at][order[k]];
        for (int i = 0; i < k; ++i) entry = madd(-lower[j][i] * pivot[i], lower[k][i], entry);
        lower[j][k] = entry / pivot[k];
        sum = madd(-lower[j][k] * lower[j][k], pivot[k], sum);
      }
      pivot[j] = larger(sum, 1e-16 * matrix[at][at]);
      if (!(pivot[j] > 0.0)) pivot[j] = 1.0;
    }
    return true;
  }
  inline void apply_inverse(const double* x, double* y) const {
    double z[kRows];
    for (int j = 0; j < m(); ++j) z[j] = dot(m, basis[order[j]], x);
    solve_ordered(z);
    for (int r = 0; r < m(); ++r) y[r] = 0.0;
    for (int j = 0; j < m(); ++j)
      for (int r = 0; r < m(); ++r) y[r] = madd(z[j], basis[order[j]][r], y[r]);
  }
  inline void solve_ordered(double* z) const {
    for (int j = 0; j < m(); ++j)
      for (int k = 0; k < j; ++k) z[j] = madd(-lower[j][k], z[k], z[j]);
    for (int j = 0; j < m(); ++j) z[j] /= pivot[j];
    for (int j = m() - 1; j >= 0; --j)
      for (int k = j + 1; k < m(); ++k) z[j] = madd(-lower[k][j], z[k], z[j]);
  }
};

// The unit vector `rest` along what of c no column reaches, and how much that is.
template <int M>
inline double out_of_reach(Rows<M> m, const Spectrum& s, const double* c, double* rest) {
  double length = s.rank < m() ? 1.0 : 0.0;
  for (int r = 0; r < m(); ++r) rest[r] = c[r];
  for (int pass = 0; pass < 2 && length > 0.0; ++pass) {
    make_orthogonal(m, s.left, s.rank, rest);
    const double left = size_of(m, rest);
    length = pass == 0 || left > 0.5 ? length * left : 0.0;  // else it was rounding
    for (int r = 0; r < m() && left > 0.0; ++r) rest[r] /= left;
  }
  return length;
}

// One part, by singular values: c + outside * rest = (A_F A_F' + kappa) u. From below Newton's steps on 1 / |u| never pass the root.
template <int M>
inline void solve_secular(Rows<M> m, const Spectrum& s, const double* c, const double* rest, double outside, double most, double& kappa,
                          double* u) {
  double g[kRows];
  kappa = outside / most;
  for (int j = 0; j < s.rank; ++j) {
    g[j] = dot(m, s.left[j], c);
    kappa = larger(kappa, magnitude(g[j]) / most - s.sigma[j] * s.sigma[j]);
  }
  for (int step = 0; step < 60; ++step) {
    double square = 0.0, q = 0.0;
    const auto add = [&](double length, double lambda) {
      if (length == 0.0) return;
      const double v = length / (lambda + kappa);
      square = madd(v, v, square), q += v * v / (lambda + kappa);
    };
    for (int j = 0; j < s.rank; ++j) add(g[j], s.sigma[j] * s.sigma[j]);
    add(outside, 0.0);
    const double size = square_root(square), next = madd(size / most - 1.0, square / q, kappa);
    if (!(size > most) || !(next > kappa)) break;
    kappa = next;
  }
  for (int r = 0; r < m(); ++r) u[r] = outside > 0.0 ? rest[r] * (outside / kappa) : 0.0;
  for (int j = 0; j < s.rank; ++j)
    for (int r = 0; r < m(); ++r) u[r] = madd(g[j] / madd(s.sigma[j], s.sigma[j], kappa), s.left[j][r], u[r]);
}

// Solves the count x count system in H, positive definite but for factors of its rows, with the right-hand side in its last column.
// False: it is singular.
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

// Newton's step of kappa towards |u_g| = Y_g in the active parts, on 1 / |u_g|, from the multiplier v at the factored kappa. A part whose
// kappa would fall below 0 (or far, while its |u_g| is too large) goes there, and the others are asked again. alone: steps of each
// part by itself, which from below are safe.
template <int M, class Piece>
inline void newton_step(Rows<M> m, const Piece& piece, const Priced& d, const bool* active, const double* size, const double* v,
                        double* step, double* alone) {
  double H[kParts][kParts], right[kParts], own[kRows], w[kRows];
  bool open[kParts];
  for (int g = 0; g < d.parts; ++g) {
    step[g] = alone[g] = 0.0, open[g] = active[g];
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
      const double least = larger(size[g] < d.most[g] * (1.0 - 1e-9) ? 0.0 : 0.2 * d.kappa[g], d.least[g]), kappa = d.kappa[g] + x[a];
      if (kappa < least && (lowest < 0 || kappa - least < below)) lowest = g, below = kappa - least, limit = least;
    }
    if (lowest < 0) return;
    open[lowest] = false, step[lowest] = limit - d.kappa[lowest];
  }
}

// The multiplier of the piece with damping kappa, from u and its residual, and how far each |next_g| is from Y_g. False: singular.
template <int M, class Piece>
inline bool damped_multiplier(Rows<M> m, Piece& piece, Priced& d, const double* c, double* next, double* size, bool* active) {
  double g[kRows] = {};
  const bool regular = piece.refactor(d);
  for (int r = 0; r < m(); ++r) g[r] = Piece::careful ? c[r] : madd(-d.kappa[d.part[r]], d.u[r], d.residual[r]);
  piece.apply_inverse(g, next);
  for (int r = 0; r < m() && !Piece::careful; ++r) next[r] += d.u[r];
  part_squares(m, d, next, size);
  d.excess = 0.0;
  for (int p = 0; p < d.parts; ++p) {
    size[p] = square_root(size[p]);
    const double excess = size[p] / d.most[p] - 1.0;
    active[p] = d.kappa[p] > d.least[p] || excess > kTight;
    if (active[p]) d.excess = larger(d.excess, magnitude(excess));
  }
  return regular;
}

// One part: to the maximum `next` of the piece, |next| right up to `tolerance`. Leaves kappa, and the piece factored with it. Returns
// the number of factorisations.
template <int M, class Piece>
inline int trust_region(Rows<M> m, Piece& piece, Priced& d, double tolerance, double* next) {
  double size[kParts], step[kParts], alone[kParts], above = 0.0, below = infinity();
  bool active[kParts];
  for (int count = 1;; ++count) {
    damped_multiplier(m, piece, d, nullptr, next, size, active);
    if (d.excess <= tolerance || count == kRegionSteps) return count;
    const double old = d.kappa[0];
    (size[0] > d.most[0] ? above : below) = old;
    newton_step(m, piece, d, active, size, next, step, alone);
    double kappa = old + step[0];
    if (above > 0.0 && below < infinity() && !(kappa > above && kappa < below)) kappa = square_root(above) * square_root(below);
    d.kappa[0] = larger(kappa, 0.0);
    if (d.kappa[0] == old) return count;
  }
}

// Several parts: kappa minimises h = c'next / 2 + sum kappa_g Y_g^2 / 2 over kappa >= 0, which is convex. Newton's steps for all parts where
// they lower h, else one part after the other.
template <int M, class Piece>
struct Regions {
  Rows<M> m;
  Piece& piece;
  Priced& d;
  const double* c;
  double* next;
  double size[kParts];
  bool active[kParts];
  bool regular;
  int count;

  inline double evaluate() {
    ++count;
    regular = damped_multiplier(m, piece, d, c, next, size, active);
    double h = 0.5 * dot(m, c, next);
    for (int p = 0; p < d.parts; ++p) h = madd(0.5 * d.kappa[p], d.most[p] * d.most[p], h);
    return h;
  }

  // Whether the damping is rounding. Then only the ratios of kappa matter, and |next_g| <= Y_g is all that is asked of them.
  inline bool negligible() const {
    bool all = Piece::careful;
    for (int p = 0; p < d.parts; ++p) all &= d.kappa[p] * d.most[p] <= d.rounding;
    return all;
  }
  inline bool within() const {
    bool all = true;
    for (int p = 0; p < d.parts; ++p) all &= size[p] <= d.most[p];
    return all;
  }

  // |next_g| = Y_g by kappa_g alone, from the present point. |next_g| falls with kappa_g, and 1 / |next_g| is concave: from below
  // Newton's steps do not pass the root.
  inline double settle_part(int g, double h, bool negligible) {
    double above = 0.0, below = infinity(), step[kParts], alone[kParts];
    for (int round = 0; round < 20 && regular; ++round) {
      const double old = d.kappa[g], ratio = size[g] / d.most[g];
      if ((magnitude(ratio - 1.0) <= 1e-3 && !negligible) || (ratio <= 1.0 && (negligible || !(old > d.least[g])))) return h;
      (ratio > 1.0 ? above : below) = old;
      active[g] = true;
      newton_step(m, piece, d, active, size, next, step, alone);
      double kappa = negligible ? 1.05 * (old + alone[g]) : old + alone[g];
      if (!(kappa > above && kappa < below)) kappa = above > 0.0 && below < infinity() ? square_root(above) * square_root(below) : d.least[g];
      d.kappa[g] = larger(kappa, d.least[g]);
      if (d.kappa[g] == old) return h;
      h = evaluate();
    }
    return h;
  }

  // Ends with d.excess infinite where a Gram matrix is singular.
  inline void solve(double tolerance) {
    double step[kParts], alone[kParts], last = infinity();
    for (int p = 0; p < d.parts; ++p) d.kappa[p] = larger(d.kappa[p], d.least[p]);
    double h = evaluate();
    if (!regular) {  // plenty of damping
      for (int p = 0; p < d.parts; ++p) {
        double own[kRows];
        only_part(m, d, p, d.residual, own);
        d.kappa[p] = larger(d.kappa[p], size_of(m, own) / d.most[p]);
      }
      h = evaluate();
    }
    for (int round = 0; round < (Piece::careful ? 30 : 10) && regular; ++round) {
      if (d.excess <= tolerance || (d.excess < 1e-8 && d.excess > 0.5 * last) || (negligible() && within())) return;
      last = d.excess;
      if (negligible()) {
        for (int p = 0; p < d.parts; ++p) h = settle_part(p, h, true);
        continue;
      }
      double old[kParts];
      bool moved = false;
      newton_step(m, piece, d, active, size, next, step, alone);
      for (int p = 0; p < d.parts; ++p) {
        old[p] = d.kappa[p], d.kappa[p] = larger(old[p] + step[p], d.least[p]);
        moved |= d.kappa[p] != old[p];
      }
      if (!moved) return;
      const double there = evaluate();
      if (!regular) break;
      if (there <= h + (d.excess < 0.5 * last ? 1e-9 : 1e-14) * magnitude(h)) {
        h = there;
        continue;
      }
      for (int p = 0; p < d.parts; ++p) d.kappa[p] = old[p];
      h = evaluate();
      for (int p = 0; p < d.parts; ++p) h = settle_part(p, h, false);
      last = infinity();
    }
    if (!regular || !Piece::careful) d.excess = infinity();
  }
};

template <int M, class Piece>
inline int trust_regions(Rows<M> m, Piece& piece, Priced& d, const double* c, double tolerance, double* next) {
  Regions<M, Piece> regions{m, piece, d, c, next, {}, {}, true, 0};
  regions.solve(tolerance);
  return regions.count;
}

STILLREACH_END
