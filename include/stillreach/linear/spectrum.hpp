// Compact singular value decomposition of an m x k matrix, m <= 6, any k, any rank: Householder QR of its transpose
// with column pivoting, then one-sided Jacobi on the small triangle (Drmac and Veselic, 2008). Keeps small singular
// values.
#pragma once

#include "stillreach/linear/factor.hpp"
#include "stillreach/linear/rotations.hpp"

STILLREACH_BEGIN

struct Spectrum {
  int rank;                      // singular values above the threshold
  int count;                     // min(m, k): those computed
  double sigma[kRows];           // falling
  double left[kRows][kRows];     // left[j]: unit left singular vector of sigma[j]
  double right[kRows][kStride];  // Q right[j]: its right singular vector, Q the product of the reflections
  // The reflections I - factor v v' of the QR; v is head_j, then the rest of column pivot[j] of `reflections` from j +
  // 1 on.
  int columns;  // k
  int pivot[kRows];
  double head[kRows], factor[kRows];
  const double* reflections;
};

// Reduces the columns of `triangle` (count vectors, zeros behind their m entries; zeros behind the count) to orthogonal
// ones: sigma_j times the left singular vectors. right, unless null: receives the product of the rotations, by columns.
inline void jacobi(double (*triangle)[kStride], double (*right)[kStride]) {
  if (right)
    for (int j = 0; j < kRows; ++j)
      for (int r = 0; r < kStride; ++r) right[j][r] = r == j ? 1.0 : 0.0;
  static constexpr Tournament pairs = tournament();
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    Mask restless = {};
    for (const auto& round : pairs.rounds) {  // its three pairs of columns in the lanes of a pack
      Pack pp[4] = {}, qq[4] = {}, pq[4] = {};
      for (int i = 0; i < 3; ++i) {
        const double *P = triangle[round[i][0]], *Q = triangle[round[i][1]];
        const Pack a0 = load(P), a1 = load(P + 4), b0 = load(Q), b1 = load(Q + 4);
        pp[i] = madd(a1, a1, a0 * a0);
        qq[i] = madd(b1, b1, b0 * b0);
        pq[i] = madd(a1, b1, a0 * b0);
      }
      const auto turn = rotations(sums(pp), sums(qq), sums(pq), ~Mask{});
      if (!any(turn.here)) continue;
      restless |= turn.large;
      for (int i = 0; i < 3; ++i) {
        const Pack c = broadcast(turn.c[i]), s = broadcast(turn.s[i]);
        rotate(c, s, triangle[round[i][0]], triangle[round[i][1]]);
        if (right) rotate(c, s, right[round[i][0]], right[round[i][1]]);
      }
    }
    if (!any(restless)) return;
  }
}

// Sorts, splits off the lengths and counts the rank. threshold: relative to the largest, or absolute where negative.
inline void finish_spectrum(int m, int count, double (*triangle)[kStride], const double (*right)[kStride],
                            double threshold, Spectrum& s) {
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
  s.count = count;
  s.rank = 0;
  for (int j = 0; j < count; ++j) {
    const double sigma = length[order[j]];
    s.sigma[j] = sigma;
    const double inverse = sigma > 1e-300 ? 1.0 / sigma : 0.0;
    for (int r = 0; r < m; ++r) s.left[j][r] = triangle[order[j]][r] * inverse;
    if (right)
      for (int r = 0; r < kStride; ++r) s.right[j][r] = right[order[j]][r];
    if (sigma > cut && sigma > 0.0) s.rank = j + 1;
  }
}

STILLREACH_INLINE double dot(int first, int count, const double* a, const double* b) {
  Pack sum = {}, next = {};
  int i = first;
  for (; i + 8 <= count; i += 8) {
    sum = madd(load(a + i), load(b + i), sum);
    next = madd(load(a + i + 4), load(b + i + 4), next);
  }
  sum += next;
  double rest = (sum[0] + sum[2]) + (sum[1] + sum[3]);
  for (; i < count; ++i) rest = madd(a[i], b[i], rest);
  return rest;
}

// b += factor a
STILLREACH_INLINE void add(int first, int count, double factor, const double* a, double* b) {
  int i = first;
  for (const Pack f = broadcast(factor); i + 4 <= count; i += 4) store(b + i, madd(f, load(a + i), load(b + i)));
  for (; i < count; ++i) b[i] = madd(factor, a[i], b[i]);
}

constexpr double kNoLength = 1e-150;  // of a row: its square has no inverse any more

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
  for (int j = 0; j < kRows; ++j) {
    pivot[j] = j;
    s.head[j] = s.factor[j] = 0.0;
  }
  s.columns = count;
  s.reflections = work;
  for (int j = 0; j < steps; ++j) {
    int best = j;
    double best_norm = -1.0;
    for (int c = j; c < m; ++c) {
      const double norm = dot(j, count, work + pivot[c] * count, work + pivot[c] * count);
      if (norm > best_norm) {
        best_norm = norm;
        best = c;
      }
    }
    const int swap = pivot[j];
    pivot[j] = pivot[best];
    pivot[best] = swap;
    double* v = work + pivot[j] * count;
    const double norm = square_root(best_norm);
    if (!(norm > kNoLength)) break;
    const double alpha = v[j] > 0.0 ? -norm : norm;
    const double head = v[j] - alpha, scale = 1.0 / (norm * (norm + magnitude(v[j])));
    triangle[j][pivot[j]] = alpha;
    s.head[j] = head;
    s.factor[j] = scale;
    for (int c = j + 1; c < m; ++c) {
      double* w = work + pivot[c] * count;
      const double part = madd(head, w[j], dot(j + 1, count, v, w)) * scale;
      w[j] = madd(-part, head, w[j]);
      add(j + 1, count, -part, v, w);
      triangle[j][pivot[c]] = w[j];
    }
  }
  double right[kRows][kStride];
  jacobi(triangle, right);
  finish_spectrum(m, steps, triangle, right, threshold, s);
}

// z = Q y: `y` holds min(m, k) numbers, z receives k. With y = right[j] the right singular vector of sigma[j].
inline void apply_reflections(const Spectrum& s, const double* y, double* z) {
  for (int i = 0; i < s.columns; ++i) z[i] = i < s.count ? y[i] : 0.0;
  for (int j = s.count - 1; j >= 0; --j) {
    if (s.factor[j] == 0.0) continue;
    const double* v = s.reflections + s.pivot[j] * s.columns;
    const double part = madd(s.head[j], z[j], dot(j + 1, s.columns, v, z)) * s.factor[j];
    z[j] = madd(-part, s.head[j], z[j]);
    add(j + 1, s.columns, -part, v, z);
  }
}

// The same, without right singular vectors, from a trusted factor of the Gram matrix: its triangle L sqrt(D) has the
// matrix's singular values.
inline void spectrum(int m, const Factor& f, double threshold, Spectrum& s) {
  double triangle[kRows][kStride] = {};
  for (int j = 0; j < m; ++j) {
    const double root = 1.0 / square_root(f.pivot_inverse[j]);
    triangle[j][j] = root;
    for (int i = j + 1; i < m; ++i) triangle[j][i] = f.lower[i][j] * root;
  }
  jacobi(triangle, nullptr);
  finish_spectrum(m, m, triangle, nullptr, threshold, s);
  s.columns = 0;
}

STILLREACH_END
