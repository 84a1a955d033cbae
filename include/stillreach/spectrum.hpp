// Compact singular value decomposition of an m x k matrix, m <= 6, any k, any rank: Householder QR of its transpose with
// column pivoting, then one-sided Jacobi on the small triangle (Drmac and Veselic, 2008). Keeps small singular values.
#pragma once

#include "factor.hpp"

STILLREACH_BEGIN

struct Spectrum {
  int rank;                     // singular values above the threshold
  int count;                    // min(m, k): those computed
  double sigma[kRows];          // falling
  double left[kRows][kRows];    // left[j]: unit left singular vector of sigma[j]
  double right[kRows][kStride]; // Q right[j]: its right singular vector, Q the product of the reflections
  // The reflections I - factor v v' of the QR; v is head_j, then the rest of column pivot[j] of `reflections` from j + 1 on.
  int columns;                  // k
  int pivot[kRows];
  double head[kRows], factor[kRows];
  const double* reflections;
};

// Reduces the columns of `triangle` (count vectors, zeros behind their m entries) to orthogonal ones: sigma_j times the
// left singular vectors. In the order of a tournament, so that neighbouring rotations do not wait for each other.
// right, unless null: receives the product of the rotations, by columns.
inline void jacobi(int count, double (*triangle)[kStride], double (*right)[kStride]) {
  if (right)
    for (int j = 0; j < kRows; ++j)
      for (int r = 0; r < kStride; ++r) right[j][r] = r == j ? 1.0 : 0.0;
  static const signed char pairs[15][2] = {{0, 1}, {2, 3}, {4, 5}, {0, 2}, {1, 4}, {3, 5}, {0, 4}, {1, 3},
                                           {2, 5}, {0, 5}, {1, 2}, {3, 4}, {0, 3}, {1, 5}, {2, 4}};
  for (int sweep = 0; sweep < 30; ++sweep) {
    bool rotated = false;
    for (const auto& pair : pairs) {
      const int p = pair[0], q = pair[1];
      if (p >= count || q >= count) continue;
      double *P = triangle[p], *Q = triangle[q];
      const Pack a0 = load(P), a1 = load(P + 4), b0 = load(Q), b1 = load(Q + 4);
      const Pack aa = madd(a1, a1, a0 * a0), bb = madd(b1, b1, b0 * b0), ab = madd(a1, b1, a0 * b0);
      const double pp = (aa[0] + aa[2]) + (aa[1] + aa[3]), qq = (bb[0] + bb[2]) + (bb[1] + bb[3]);
      const double pq = (ab[0] + ab[2]) + (ab[1] + ab[3]);
      if (!(pq * pq > 1e-31 * pp * qq)) continue;  // also where one of the columns is 0
      rotated = true;
      // t = sign(d) 2 pq / (|d| + sqrt(d^2 + 4 pq^2)), d = qq - pp
      const double d = qq - pp, twice = 2.0 * pq, h = square_root(madd(d, d, twice * twice));
      const double t = (d < 0.0 ? -twice : twice) / (magnitude(d) + h);
      const double c = 1.0 / square_root(madd(t, t, 1.0)), s = c * t;
      const Pack C = broadcast(c), S = broadcast(s);
      store(P, madd(C, a0, -(S * b0))), store(P + 4, madd(C, a1, -(S * b1)));
      store(Q, madd(S, a0, C * b0)), store(Q + 4, madd(S, a1, C * b1));
      if (!right) continue;
      const Pack r0 = load(right[p]), r1 = load(right[p] + 4), t0 = load(right[q]), t1 = load(right[q] + 4);
      store(right[p], madd(C, r0, -(S * t0))), store(right[p] + 4, madd(C, r1, -(S * t1)));
      store(right[q], madd(S, r0, C * t0)), store(right[q] + 4, madd(S, r1, C * t1));
    }
    if (!rotated) return;
  }
}

// Sorts, splits off the lengths and counts the rank. threshold: relative to the largest, or absolute where negative.
inline void finish_spectrum(int m, int count, double (*triangle)[kStride], const double (*right)[kStride], double threshold,
                            Spectrum& s) {
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
  s.count = count, s.rank = 0;
  for (int j = 0; j < count; ++j) {
    const double sigma = length[order[j]];
    s.sigma[j] = sigma;
    for (int r = 0; r < m; ++r) s.left[j][r] = sigma > 0.0 ? triangle[order[j]][r] / sigma : 0.0;
    if (right)
      for (int r = 0; r < kStride; ++r) s.right[j][r] = right[order[j]][r];
    if (sigma > cut && sigma > 0.0) s.rank = j + 1;
  }
}

// columns: as in gram(). work: m * count numbers. threshold: relative where >= 0, absolute (its negative) otherwise.
// Overflow and underflow are the caller's to avoid (entries within about 1e-100 to 1e100).
inline STILLREACH_NOINLINE void spectrum(int m, const double* columns, const int* index, int count, double threshold,
                                         double* work, Spectrum& s) {
  // work holds the transpose by its columns: row r of the matrix is work[r * count .. ]
  for (int i = 0; i < count; ++i) {
    const double* a = columns + (index ? index[i] : i) * kStride;
    for (int r = 0; r < m; ++r) work[r * count + i] = a[r];
  }
  const int steps = m < count ? m : count;
  double triangle[kRows][kStride] = {};  // triangle[j]: column j of R', in the task's row order
  int* pivot = s.pivot;
  for (int j = 0; j < kRows; ++j) pivot[j] = j, s.head[j] = s.factor[j] = 0.0;
  s.columns = count, s.reflections = work;
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
    s.head[j] = head, s.factor[j] = scale;
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
  double right[kRows][kStride];
  jacobi(steps, triangle, right);
  finish_spectrum(m, steps, triangle, right, threshold, s);
}

// z = Q y: `y` holds min(m, k) numbers, z receives k. With y = right[j] the right singular vector of sigma[j].
inline void apply_reflections(const Spectrum& s, const double* y, double* z) {
  for (int i = 0; i < s.columns; ++i) z[i] = i < s.count ? y[i] : 0.0;
  for (int j = s.count - 1; j >= 0; --j) {
    if (s.factor[j] == 0.0) continue;
    const double* v = s.reflections + s.pivot[j] * s.columns;
    double sum = s.head[j] * z[j];
    for (int i = j + 1; i < s.columns; ++i) sum = madd(v[i], z[i], sum);
    sum *= s.factor[j];
    z[j] = madd(-sum, s.head[j], z[j]);
    for (int i = j + 1; i < s.columns; ++i) z[i] = madd(-sum, v[i], z[i]);
  }
}

// The same, without right singular vectors, from a trusted factor of the Gram matrix: its triangle L sqrt(D) has the matrix's
// singular values.
inline void spectrum(int m, const Factor& f, double threshold, Spectrum& s) {
  double triangle[kRows][kStride] = {};
  for (int j = 0; j < m; ++j) {
    const double root = 1.0 / square_root(f.pivot_inverse[j]);
    triangle[j][j] = root;
    for (int i = j + 1; i < m; ++i) triangle[j][i] = f.lower[i][j] * root;
  }
  jacobi(m, triangle, nullptr);
  finish_spectrum(m, m, triangle, nullptr, threshold, s);
  s.columns = 0;
}

STILLREACH_END
