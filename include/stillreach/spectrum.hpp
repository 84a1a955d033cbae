// Compact singular value decomposition of an m x k matrix, m <= 6, any k, any rank: Householder QR of its transpose with
// column pivoting, then one-sided Jacobi on the small triangle (Drmac and Veselic, 2008). Keeps small singular values.
#pragma once

#include "factor.hpp"

STILLREACH_BEGIN

struct Spectrum {
  int rank;                  // singular values above the threshold
  int count;                 // min(m, k): those computed
  double sigma[kRows];       // falling
  double left[kRows][kRows]; // left[j]: unit left singular vector of sigma[j]
  double inverse_square_sum; // sum of 1 / sigma^2 over all min(m, k); infinite where one is 0
};

// Reduces the columns of `triangle` (count vectors of length m) to orthogonal ones: sigma_j times the left vectors.
inline void jacobi(int m, int count, double triangle[kRows][kRows]) {
  for (int sweep = 0; sweep < 30; ++sweep) {
    bool rotated = false;
    for (int p = 0; p < count - 1; ++p)
      for (int q = p + 1; q < count; ++q) {
        double pp = 0.0, qq = 0.0, pq = 0.0;
        for (int r = 0; r < m; ++r) {
          pp = madd(triangle[p][r], triangle[p][r], pp);
          qq = madd(triangle[q][r], triangle[q][r], qq);
          pq = madd(triangle[p][r], triangle[q][r], pq);
        }
        if (!(pq * pq > 1e-31 * pp * qq)) continue;  // also where one of the columns is 0
        rotated = true;
        const double zeta = (qq - pp) / (2.0 * pq);
        const double t = (zeta >= 0.0 ? 1.0 : -1.0) / (magnitude(zeta) + square_root(madd(zeta, zeta, 1.0)));
        const double c = 1.0 / square_root(madd(t, t, 1.0)), s = c * t;
        for (int r = 0; r < m; ++r) {
          const double a = triangle[p][r], b = triangle[q][r];
          triangle[p][r] = madd(c, a, -(s * b));
          triangle[q][r] = madd(s, a, c * b);
        }
      }
    if (!rotated) return;
  }
}

// Sorts, splits off the lengths and counts the rank. threshold: relative to the largest, or absolute where negative.
inline void finish_spectrum(int m, int count, double triangle[kRows][kRows], double threshold, Spectrum& s) {
  int order[kRows];
  double length[kRows];
  for (int j = 0; j < count; ++j) {
    double sum = 0.0;
    for (int r = 0; r < m; ++r) sum = madd(triangle[j][r], triangle[j][r], sum);
    length[j] = square_root(sum);
    int at = j;
    for (; at > 0 && length[order[at - 1]] < length[j]; --at) order[at] = order[at - 1];
    order[at] = j;
  }
  const double cut = threshold < 0.0 ? -threshold : threshold * (count > 0 ? length[order[0]] : 0.0);
  s.count = count, s.rank = 0, s.inverse_square_sum = 0.0;
  for (int j = 0; j < count; ++j) {
    const double sigma = length[order[j]];
    s.sigma[j] = sigma;
    s.inverse_square_sum += sigma > cut && sigma > 0.0 ? 1.0 / (sigma * sigma) : infinity();
    for (int r = 0; r < m; ++r) s.left[j][r] = sigma > 0.0 ? triangle[order[j]][r] / sigma : 0.0;
    if (sigma > cut && sigma > 0.0) s.rank = j + 1;
  }
}

// columns: as in gram(). work: m * count numbers. threshold: relative where >= 0, absolute (its negative) otherwise.
// Overflow and underflow are the caller's to avoid (entries within about 1e-100 to 1e100).
inline STILLREACH_NOINLINE void spectrum(int m, const double* columns, const int* index, int count, double threshold,
                                         double* work, Spectrum& s) {
  // work holds the transpose by its columns: row r of the matrix is work[r * count .. ]
  for (int i = 0; i < count; ++i) {
    const double* a = columns + (index ? index[i] : i) * m;
    for (int r = 0; r < m; ++r) work[r * count + i] = a[r];
  }
  const int steps = m < count ? m : count;
  double triangle[kRows][kRows] = {};  // triangle[j]: column j of R', in the task's row order
  int pivot[kRows] = {0, 1, 2, 3, 4, 5};
  for (int j = 0; j < steps; ++j) {
    int best = j;
    double best_norm = -1.0;
    for (int c = j; c < m; ++c) {
      double norm = 0.0;
      for (int i = j; i < count; ++i) norm = madd(work[pivot[c] * count + i], work[pivot[c] * count + i], norm);
      if (norm > best_norm) best_norm = norm, best = c;
    }
    const int swap = pivot[j];
    pivot[j] = pivot[best], pivot[best] = swap;
    double* v = work + pivot[j] * count;
    const double norm = square_root(best_norm);
    if (!(norm > 0.0)) break;
    const double alpha = v[j] > 0.0 ? -norm : norm;
    const double head = v[j] - alpha, scale = 1.0 / (norm * (norm + magnitude(v[j])));
    triangle[j][pivot[j]] = alpha;
    for (int c = j + 1; c < m; ++c) {
      double* w = work + pivot[c] * count;
      double sum = head * w[j];
      for (int i = j + 1; i < count; ++i) sum = madd(v[i], w[i], sum);
      sum *= scale;
      w[j] = madd(-sum, head, w[j]);
      for (int i = j + 1; i < count; ++i) w[i] = madd(-sum, v[i], w[i]);
      triangle[j][pivot[c]] = w[j];
    }
  }
  jacobi(m, steps, triangle);
  finish_spectrum(m, steps, triangle, threshold, s);
}

// The same from a trusted factor of the Gram matrix: its triangle L sqrt(D) has the matrix's singular values.
inline void spectrum(int m, const Factor& f, double threshold, Spectrum& s) {
  double triangle[kRows][kRows] = {};
  for (int j = 0; j < m; ++j) {
    const double root = 1.0 / square_root(f.pivot_inverse[j]);
    triangle[j][j] = root;
    for (int i = j + 1; i < m; ++i) triangle[j][i] = f.lower[i][j] * root;
  }
  jacobi(m, m, triangle);
  finish_spectrum(m, m, triangle, threshold, s);
}

STILLREACH_END
