// The second, careful stage of bounded least squares, where the free columns are nearly dependent: there the residual
// of the first stage is known too poorly to tell whether a bound should be left. Here every solve is by singular
// values, the residual is made orthogonal to the free columns, and a bound is left where the angle between the residual
// and what the free columns leave of the variable's own column says so.
#pragma once

#include "stillreach/bounded/box.hpp"

STILLREACH_BEGIN

constexpr int kCarefulReleases = 12;

// Takes out of v what lies along the `count` orthonormal vectors, twice, because once leaves rounding; sum: how much
// that was of each. All products before all differences: none waits for another.
template <int M, std::size_t Length>
inline void make_orthogonal(Rows<M> m, const double (*vectors)[Length], int count, double* v, double* sum) {
  for (int j = 0; j < count; ++j) sum[j] = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    double along[kRows];
    for (int j = 0; j < count; ++j) {
      along[j] = dot(m, vectors[j], v);
      sum[j] += along[j];
    }
    for (int j = 0; j < count; ++j)
      for (int r = 0; r < m(); ++r) v[r] = madd(-along[j], vectors[j][r], v[r]);
  }
}
template <int M, std::size_t Length>
inline void make_orthogonal(Rows<M> m, const double (*vectors)[Length], int count, double* v) {
  double sum[kRows];
  make_orthogonal(m, vectors, count, v, sum);
}

// As choose_release(), by angles.
template <int M>
inline int choose_release_by_angle(Rows<M> m, const Box& b, Inner& in, int free, double rhs_size, bool& wanted) {
  double size = rhs_size;
  for (int i = 0; i < b.k; ++i) size = larger(size, magnitude(b.z[i]) * b.length[i]);
  const int rank = free > 0 ? in.spectrum.rank : 0;
  make_orthogonal(m, in.spectrum.left, rank, in.residual);
  const double error = size_of(m, in.residual), dual_size = size_of(m, in.dual);
  const bool consistent = !(error > kRounding * size);
  Release first, second;
  wanted = false;
  for (int i = 0; i < b.k; ++i) {
    if (b.state[i] == 0) continue;
    const double* a = b.columns + i * kStride;
    const double side = b.state[i];
    double own[kRows];
    for (int r = 0; r < m(); ++r) own[r] = a[r];
    make_orthogonal(m, in.spectrum.left, rank, own);
    const double length = size_of(m, own);
    if (!consistent && length > larger(kDependent * b.length[i], 2.0 * b.dependent)) {
      const double cosine = -side * dot(m, own, in.residual) / (length * error);
      const double noise = 1e-15 * (b.length[i] / length + size / error);
      if (magnitude(cosine) > noise) {
        if (cosine < 0.0) continue;
        consider(b, i, cosine, noise, kCarefulReleases, first, wanted);
        continue;
      }
    }
    consider_norm(m, b, i, in.dual, dual_size, kCarefulReleases, second, wanted);
  }
  return first.variable >= 0 ? first.variable : second.variable;
}

// A singular value so small that motion through the box, as far as it is used, changes the residual by rounding only.
STILLREACH_INLINE double weakest_that_counts(const Box& b) {
  double used = 0.0, range = 0.0;
  for (int i = 0; i < b.k; ++i) used = larger(used, magnitude(b.z[i]));
  for (int i = 0; i < b.k; ++i) range = larger(range, smaller(b.upper[i] - b.lower[i], 4.0 * used));
  return range > 0.0 ? 1e-16 * b.whole / range : 0.0;
}

// Goes on from where solve_box() ended. Variables without room stay where they are.
template <int M>
inline STILLREACH_NOINLINE void settle_box(Rows<M> m, const double* rhs, Box& b, Inner& in) {
  double size = larger(square_root(dot(m, rhs, rhs)), b.whole);
  for (int i = 0; i < b.k; ++i) {
    b.releases[i] = b.lower[i] < b.upper[i] ? 0 : kNever;
    size = larger(size, magnitude(b.z[i]) * b.length[i]);
  }
  const double threshold = b.threshold, dependent = b.dependent;
  b.dependent = larger(dependent, weakest_that_counts(b));
  b.threshold = -b.dependent;
  Objective now = objective(m, b, rhs, b.z);
  int freed = -1;
  b.capped = false;
  const int most = (kCarefulReleases + 1) * b.k + 2;
  for (int step = 0; step < most; ++step) {
    const int free = solve_free<M, true>(m, b, rhs, in);
    b.slack = 0.0;
    for (int j = 0; j < free; ++j) b.slack = larger(b.slack, 1e-13 * magnitude(b.target[j]));
    bool all_inside = true;
    for (int j = 0; j < free; ++j) all_inside &= inside(b, j);
    if (!all_inside) {
      advance(m, b, rhs, free, false, freed, 1e-15 * size * square_root(now.error), now);
      freed = -1;
      continue;
    }
    for (int j = 0; j < free; ++j) {
      const int i = b.index[j];
      b.z[i] = clamp(b.target[j], b.lower[i], b.upper[i]);
    }
    bool wanted;
    const int release = choose_release_by_angle(m, b, in, free, size, wanted);
    for (int r = 0; r < kStride; ++r) b.residual[r] = in.residual[r];
    if (release < 0) {
      b.capped = wanted;
      b.threshold = threshold;
      b.dependent = dependent;
      return;
    }
    now = objective(m, b, rhs, b.z);
    freed = release;
    ++b.releases[release];
    b.state[release] = 0;
  }
  b.capped = true;
  b.threshold = threshold;
  b.dependent = dependent;
  residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
}

STILLREACH_END
