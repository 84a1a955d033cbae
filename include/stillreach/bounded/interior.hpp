// The maximum of one quadratic piece of a priced problem's dual (price.hpp) in the balls of several parts, by a
// primal-dual interior-point method (Mehrotra, 1992), which needs neither a start nor full rank: (A_F A_F' + diag
// kappa) u = c and kappa_g room_g = mu with room_g = (Y_g^2 - |u_g|^2) / 2, mu to 0.
#pragma once

#include "stillreach/bounded/careful_piece.hpp"
#include "stillreach/bounded/trust_region.hpp"

STILLREACH_BEGIN

constexpr int kInteriorSteps = 30;
constexpr double kCentred = 0.01;  // of their mean each product kappa_g room_g keeps so much
constexpr double kBehind = 0.1;    // mu stays above so much of the first equation's error, in the units of mu

template <int M>
struct Interior {
  Rows<M> m;
  CarefulPiece<M>& piece;
  Priced& d;
  double c[kRows], v[kRows];       // c and u in the piece's basis, where small components keep their digits
  double u[kRows], rest[kRows];    // u, and the error of the first equation in the basis
  double own[kParts][kRows];       // u_g in the basis,
  double weighted[kParts][kRows];  // and H^-1 u_g, H = A_F A_F' + diag kappa
  double room[kParts];
  double move[kRows], turn[kRows];       // step of v and of u,
  double change[kParts];                 // and of kappa
  double along[kParts], square[kParts];  // room_g falls by along_g far + square_g far^2 / 2

  inline Interior(Rows<M> rows, CarefulPiece<M>& of, Priced& priced) : m(rows), piece(of), d(priced) {}

  inline void into_basis(const double* rows, double* to) const {
    for (int j = 0; j < m(); ++j) to[j] = dot(m, piece.basis[j], rows);
  }
  inline void into_rows(const double* from, double* rows) const {
    for (int r = 0; r < m(); ++r) rows[r] = 0.0;
    for (int j = 0; j < m(); ++j)
      for (int r = 0; r < m(); ++r) rows[r] = madd(from[j], piece.basis[j][r], rows[r]);
  }
  // sum Y_g |x_g| of x in the basis.
  inline double cost(const double* x) const {
    double rows[kRows], squares[kParts], sum = 0.0;
    into_rows(x, rows);
    part_squares(m, d, rows, squares);
    for (int p = 0; p < d.parts; ++p) sum = madd(d.most[p], square_root(squares[p]), sum);
    return sum;
  }
  inline double product(int p, double far) const {
    return (d.kappa[p] + far * change[p]) * (room[p] - far * (along[p] + 0.5 * far * square[p]));
  }
  inline double mean_product(double far) const {
    double sum = 0.0;
    for (int p = 0; p < d.parts; ++p) sum += product(p, far);
    return sum / d.parts;
  }

  // Both equations at the present u and kappa. Returns how far off they are, as an error of the task.
  inline double evaluate() {
    double rows[kRows], worst = 0.0;
    into_rows(v, u);
    for (int j = 0; j < m(); ++j) rest[j] = madd(-piece.lambda[j], v[j], c[j]);
    for (int p = 0; p < d.parts; ++p) {
      only_part(m, d, p, u, rows);
      into_basis(rows, own[p]);
      for (int j = 0; j < m(); ++j) rest[j] = madd(-d.kappa[p], own[p][j], rest[j]);
      const double size = size_of(m, rows);
      room[p] = 0.5 * (d.most[p] - size) * (d.most[p] + size);
      worst = larger(worst, d.kappa[p] * room[p] / d.most[p]);
      change[p] = along[p] = square[p] = 0.0;
    }
    return larger(worst, size_of(m, rest));
  }

  // The step that brings the first equation's error `left` to 0 and adds goal_g to each product.
  inline void solve_step(const double* goal, const double* left) {
    double system[kParts][kParts + 1];
    piece.solve_in_basis(left, move);
    for (int p = 0; p < d.parts; ++p) {
      for (int q = 0; q < d.parts; ++q) system[p][q] = dot(m, own[p], weighted[q]);
      system[p][p] += room[p] / d.kappa[p];
      system[p][d.parts] = dot(m, own[p], move) + goal[p] / d.kappa[p];
    }
    if (!eliminate(d.parts, system, change))
      for (int p = 0; p < d.parts; ++p) change[p] = 0.0;
    for (int p = 0; p < d.parts; ++p)
      for (int j = 0; j < m(); ++j) move[j] = madd(-change[p], weighted[p][j], move[j]);
    into_rows(move, turn);
    part_squares(m, d, turn, square);
    for (int p = 0; p < d.parts; ++p) along[p] = 0.0;
    for (int r = 0; r < m(); ++r) along[d.part[r]] = madd(u[r], turn[r], along[d.part[r]]);
  }

  // How far along the step kappa > 0 and room > 0, at most 1.
  inline double longest() const {
    double far = 1.0;
    for (int p = 0; p < d.parts; ++p) {
      if (change[p] < 0.0) far = smaller(far, -d.kappa[p] / change[p]);
      const double twice = 2.0 * larger(room[p], 0.0), root = square_root(madd(along[p], along[p], square[p] * twice));
      far = smaller(far, along[p] > 0.0    ? twice / (root + along[p])
                         : square[p] > 0.0 ? (root - along[p]) / square[p]
                                           : 1.0);
    }
    return far;
  }

  // Predictor, corrector, and a step after which the products are still alike. start: the first mean product.
  inline void advance(double start) {
    double goal[kParts], left[kRows], rows[kRows], turned[kRows];
    piece.refactor(d);
    for (int p = 0; p < d.parts; ++p) {
      piece.solve_in_basis(own[p], weighted[p]);
      goal[p] = -product(p, 0.0);
    }
    const double mean = mean_product(0.0);
    solve_step(goal, rest);
    const double share = mean_product(longest()) / mean;
    const double centre = larger(share * share * share * mean, kBehind * cost(rest));
    for (int j = 0; j < m(); ++j) left[j] = rest[j];
    for (int p = 0; p < d.parts; ++p) {
      goal[p] += centre + 0.5 * d.kappa[p] * square[p] + change[p] * along[p];
      only_part(m, d, p, turn, rows);
      into_basis(rows, turned);
      for (int j = 0; j < m(); ++j) left[j] = madd(-change[p], turned[j], left[j]);
    }
    solve_step(goal, left);
    double far = smaller(1.0, larger(0.9, 1.0 - mean / start) * longest());
    const auto apart = [&] {
      double least = infinity();
      for (int p = 0; p < d.parts; ++p) least = smaller(least, product(p, far));
      return !(least >= kCentred * mean_product(far));
    };
    for (int half = 0; half < 6 && apart(); ++half) far *= 0.5;
    for (int j = 0; j < m(); ++j) v[j] = madd(far, move[j], v[j]);
    for (int p = 0; p < d.parts; ++p) d.kappa[p] = madd(far, change[p], d.kappa[p]);
  }

  // To u in `next`; leaves kappa. Returns the number of factorisations.
  inline int solve(const double* right, double* next) {
    int step = 1;
    into_basis(right, c);
    for (int r = 0; r < m(); ++r) next[r] = 0.0;
    const double start = 2.0 * cost(c);
    for (int p = 0; p < d.parts; ++p)
      d.kappa[p] = start / (d.most[p] * d.most[p]);  // then |u_g| <= Y_g / 2, and the products are alike
    if (!(start > 0.0)) return step;
    piece.refactor(d);
    piece.solve_in_basis(c, v);
    for (double last = infinity(); step <= kInteriorSteps; ++step) {
      const double off = evaluate();
      if (off <= d.rounding || (off <= 20.0 * d.rounding && off > 0.5 * last)) break;
      last = off;
      advance(start);
    }
    into_rows(v, next);
    return step;
  }
};

STILLREACH_END
