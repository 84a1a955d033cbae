// Damping factors for the singularity-robust law, from singular values. Joint rates relative to their limits are
// u_i(kappa) = limit_i (offset_i + sum_j shape_ij beta_j / (sigma_j^2 + kappa)), with limit_i the reciprocal of the
// joint's bound (0: none): everything here is a function of the shapes (k x rank, row-major, 6 apart), beta, sigma^2,
// limits, offsets.
#pragma once

#include "stillreach/laws/exact_damping.hpp"
#include "stillreach/problem/workspace.hpp"

STILLREACH_BEGIN

struct DampingSearch {
  int k, rank;
  int count;      // joints that may be over the limit (norm inf)
  double* terms;  // k x 7: shapes times beta times limit, offset times limit; the first `count` rows are those joints'
  const double* shapes;  // k x 6
  const double* limit;   // k
  const double* offset;  // k or null
  double beta[kRows], square[kRows];
};

// One rational function sum_j a_j / (x_j + kappa) that exceeds `limit` > 0 at kappa: a step towards its first crossing
// that never passes it. Two bounds of the function from below, the larger step counts: the positive terms bounded
// through their concave reciprocal (as Newton's method on 1 / norm does), and a Taylor expansion whose second
// derivative is bounded by the negative terms (their third powers only fall); near the crossing the latter is Newton's
// step.
STILLREACH_INLINE double safe_step(int rank, const double* a, const double* inverse, double limit) {
  double p = 0.0, n = 0.0, dp = 0.0, dn = 0.0, n3 = 0.0;
  for (int j = 0; j < rank; ++j) {
    const double t = a[j] * inverse[j], d = t * inverse[j];
    if (t > 0.0) {
      p += t;
      dp += d;
    } else {
      n -= t;
      dn -= d;
      n3 -= d * inverse[j];
    }
  }
  const double excess = p - n - limit, slope = dp - dn;
  if (!(excess > 4e-16 * (p + n))) return 0.0;
  const double harmonic = p * excess / ((limit + n) * dp);
  const double taylor = 2.0 * excess / (slope + square_root(madd(slope, slope, 4.0 * n3 * excess)));
  return taylor > harmonic ? taylor : harmonic;  // a NaN in either leaves the other, or ends the search
}

// w.shapes: the part of each singular direction in each joint's column, zeros from the rank on. Rows are 6 apart.
template <int M>
inline void write_shapes(Rows<M> m, const Spectrum& sp, int k, Workspace& w) {
  if (sp.columns > 0) {
    for (int j = 0; j < kRows; ++j) {
      if (j < sp.rank) apply_reflections(sp, sp.right[j], w.target);
      for (int i = 0; i < k; ++i) w.shapes[6 * i + j] = j < sp.rank ? w.target[i] * sp.sigma[j] : 0.0;
    }
    return;
  }
  double across[kRows][kStride] = {};  // left singular vectors, by rows
  for (int j = 0; j < sp.rank; ++j)
    for (int r = 0; r < m(); ++r) across[r][j] = sp.left[j][r];
  for (int i = 0; i < k; ++i) {
    Pack low = {}, high = {};
    for (int r = 0; r < m(); ++r) {
      const Pack a = broadcast(w.columns[i * kStride + r]);
      low = madd(a, load(across[r]), low);
      high = madd(a, load(across[r] + 4), high);
    }
    store(w.shapes + 6 * i, low);
    store(w.shapes + 6 * i + 4, high);  // the next row overwrites the last two
  }
}

STILLREACH_INLINE void reciprocals(const DampingSearch& d, double kappa, double* inverse) {
  for (int j = 0; j < d.rank; ++j) inverse[j] = 1.0 / (d.square[j] + kappa);
}

inline void gather_terms(DampingSearch& d) {
  d.count = d.k;
  for (int i = 0; i < d.k; ++i) {
    double* a = d.terms + 7 * i;
    for (int j = 0; j < d.rank; ++j) a[j] = d.shapes[6 * i + j] * d.beta[j] * d.limit[i];
    a[6] = d.offset ? d.offset[i] * d.limit[i] : 0.0;
  }
}

// Step of the largest |u_i| (norm inf): no joint over its limit can come back under it before its own step. A joint
// whose terms without signs are below the limit is never over it at a larger kappa, and looked at no more.
inline double step_inf(DampingSearch& d, double kappa) {
  double inverse[kRows], step = 0.0;
  reciprocals(d, kappa, inverse);
  int kept = 0;
  for (int i = 0; i < d.count; ++i) {
    const double* term = d.terms + 7 * i;
    double a[kRows], u = 0.0, most = 0.0;
    for (int j = 0; j < d.rank; ++j) {
      u = madd(term[j], inverse[j], u);
      most = madd(magnitude(term[j]), inverse[j], most);
    }
    const double offset = term[6], sign = u + offset < 0.0 ? -1.0 : 1.0, limit = 1.0 - sign * offset;
    if (most + magnitude(offset) <= 1.0) continue;
    for (int j = 0; j < d.rank; ++j) a[j] = sign * term[j];
    if (kept < i) STILLREACH_LIBRARY(memcpy)(d.terms + 7 * kept, term, 7 * sizeof(double));
    ++kept;
    if (!(sign * u > limit * (1.0 + kLimitSlack)) || !(limit > 0.0)) continue;
    const double s = safe_step(d.rank, a, inverse, limit);
    if (s > step) step = s;
  }
  d.count = kept;
  return step;
}

// Step of |u| (norm 2): its component along today's direction bounds it from below and touches it here.
inline double step_2(const DampingSearch& d, double kappa) {
  double inverse[kRows], a[kRows] = {0, 0, 0, 0, 0, 0}, square = 0.0, offset = 0.0;
  reciprocals(d, kappa, inverse);
  for (int i = 0; i < d.k; ++i) {
    const double* row = d.shapes + 6 * i;
    const double fixed = d.offset ? d.offset[i] * d.limit[i] : 0.0;
    double u = fixed;
    for (int j = 0; j < d.rank; ++j) u = madd(row[j] * d.beta[j] * d.limit[i], inverse[j], u);
    square = madd(u, u, square);
    offset = madd(u, fixed, offset);
    for (int j = 0; j < d.rank; ++j) a[j] = madd(u, row[j] * d.beta[j] * d.limit[i], a[j]);
  }
  const double norm = square_root(square);
  if (!(norm > 1.0 + kLimitSlack)) return 0.0;
  for (int j = 0; j < d.rank; ++j) a[j] /= norm;
  const double limit = 1.0 - offset / norm;
  return limit > 0.0 ? safe_step(d.rank, a, inverse, limit) : 0.0;
}

// A damping factor that meets the limits for certain: the terms without their signs fall with kappa.
inline double safe_side(const DampingSearch& d, NormKind norm, double kappa) {
  for (int step = 0; step < 2000; ++step) {
    double worst = 0.0, sum = 0.0;
    for (int i = 0; i < d.k; ++i) {
      double u = 0.0;
      for (int j = 0; j < d.rank; ++j)
        u += magnitude(d.shapes[6 * i + j] * d.beta[j]) * d.limit[i] / (d.square[j] + kappa);
      const double room = larger(1.0 - (d.offset ? magnitude(d.offset[i]) * d.limit[i] : 0.0), 1e-3);
      worst = larger(worst, u / room);
      sum = madd(u / room, u / room, sum);
    }
    if ((norm == NormKind::EUCLIDEAN ? square_root(sum) : worst) <= 1.0) break;
    kappa = larger(kappa * 1.5, 1e-12 * d.square[0]);
  }
  return kappa;
}

// Eq. (10): the smallest kappa >= 0 that meets the limit. steps: how many it took; capped: the safe side was taken.
inline double exact_damping(DampingSearch& d, NormKind norm, int& steps, bool& capped) {
  double kappa = 0.0;
  capped = false;
  if (norm == NormKind::MAXIMUM) gather_terms(d);
  for (steps = 1; steps <= kDampingSteps; ++steps) {
    const double step = norm == NormKind::EUCLIDEAN ? step_2(d, kappa) : step_inf(d, kappa);
    const double next = kappa + step;
    if (!(next > kappa)) return kappa;
    kappa = next;
  }
  capped = true;
  return safe_side(d, norm, kappa);
}

// Eq. (16): kappa = [|V| |U' twist| / 2 dq_max]^2 with both norms inf, or both 2. `square` holds sigma^2.
inline double closed_form_damping(const DampingSearch& d, NormKind norm) {
  if (norm == NormKind::MAXIMUM) return closed_form_damping(d.rank, d.shapes, 6, d.k, d.limit, d.beta, d.square);
  double left = 0.0, right = 0.0, inverse[kRows];
  for (int j = 0; j < d.rank; ++j) inverse[j] = 1.0 / square_root(d.square[j]);
  double product[kRows][kStride] = {};  // (shapes / sigma)' (shapes / sigma); its largest eigenvalue is |V|_2^2
  for (int i = 0; i < d.k; ++i) {
    double row[kRows];
    for (int a = 0; a < d.rank; ++a) row[a] = d.shapes[6 * i + a] * inverse[a] * d.limit[i];
    for (int a = 0; a < d.rank; ++a)
      for (int b = 0; b < d.rank; ++b) product[a][b] = madd(row[a], row[b], product[a][b]);
  }
  jacobi(product, nullptr);  // symmetric: its singular values are its eigenvalues
  for (int a = 0; a < d.rank; ++a) {
    double sum = 0.0;
    for (int b = 0; b < d.rank; ++b) sum = madd(product[a][b], product[a][b], sum);
    left = larger(left, square_root(sum));
  }
  for (int j = 0; j < d.rank; ++j) right = madd(d.beta[j], d.beta[j], right);
  return 0.25 * left * right;
}

STILLREACH_END
