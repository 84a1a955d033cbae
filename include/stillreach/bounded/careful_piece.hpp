// The quadratic piece of a priced problem's dual (price.hpp) by the singular values of its free columns: for several
// parts its matrix, and for one part its maximum.
#pragma once

#include "stillreach/bounded/price.hpp"

STILLREACH_BEGIN

// A_F A_F' + diag kappa in the basis of A_F's left singular vectors, where what is large stands apart from what is
// small: factors of the matrix ordered by its diagonal keep their digits.
template <int M>
struct CarefulPiece {
  Rows<M> m;
  double basis[kRows][kRows] = {}, lambda[kRows] = {};
  double share[kParts][kRows][kRows] = {};     // of kappa_g in the matrix
  double lower[kRows][kRows], inverse[kRows];  // factors, and the inverse pivots
  int order[kRows];

  inline CarefulPiece(Rows<M> rows, const Spectrum& s, const Priced& d) : m(rows) {
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
    for (int r = 0; r < m(); ++r)
      for (int i = 0; i < m(); ++i)
        for (int j = 0; j <= i; ++j) {
          double& sum = share[d.part[r]][i][j];
          sum = madd(basis[i][r], basis[j][r], sum);
        }
  }

  inline void refactor(const Priced& d) {
    double matrix[kRows][kRows];
    for (int i = 0; i < m(); ++i)
      for (int j = 0; j <= i; ++j) {
        double sum = i == j ? lambda[i] : 0.0;
        for (int g = 0; g < d.parts; ++g) sum = madd(d.kappa[g], share[g][i][j], sum);
        matrix[i][j] = matrix[j][i] = sum;
      }
    for (int j = 0; j < m(); ++j) {
      int at = j;
      for (; at > 0 && matrix[order[at - 1]][order[at - 1]] < matrix[j][j]; --at) order[at] = order[at - 1];
      order[at] = j;
    }
    for (int j = 0; j < m(); ++j) {
      const int at = order[j];
      double sum = matrix[at][at], row[kRows];
      for (int k = 0; k < j; ++k) {  // row: the entries of L, each times its pivot
        row[k] = matrix[at][order[k]];
        for (int i = 0; i < k; ++i) row[k] = madd(-row[i], lower[k][i], row[k]);
        lower[j][k] = row[k] * inverse[k];
        sum = madd(-lower[j][k], row[k], sum);
      }
      const double pivot = larger(sum, 1e-16 * matrix[at][at]);
      inverse[j] = pivot > 0.0 ? 1.0 / pivot : 1.0;
    }
  }
  // In the basis; x and y may be the same.
  inline void solve_in_basis(const double* x, double* y) const {
    double z[kRows];
    for (int j = 0; j < m(); ++j) z[j] = x[order[j]];
    solve_ordered(z);
    for (int j = 0; j < m(); ++j) y[order[j]] = z[j];
  }
  inline void solve_ordered(double* z) const {
    for (int j = 0; j < m(); ++j)
      for (int k = 0; k < j; ++k) z[j] = madd(-lower[j][k], z[k], z[j]);
    for (int j = 0; j < m(); ++j) z[j] *= inverse[j];
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

// One part, by singular values: c + outside * rest = (A_F A_F' + kappa) u. From below Newton's steps on 1 / |u| never
// pass the root.
template <int M>
inline void solve_secular(Rows<M> m, const Spectrum& s, const double* c, const double* rest, double outside,
                          double most, double& kappa, double* u) {
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
      square = madd(v, v, square);
      q += v * v / (lambda + kappa);
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

STILLREACH_END
