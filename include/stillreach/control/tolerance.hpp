// What is left after the loss of joints, and its gradient: relative manipulability, and the speed in every direction.
#pragma once

#include "stillreach/control/manipulability.hpp"

STILLREACH_BEGIN

constexpr double kHopeless = 1e-3;  // what is left where it says more of the arm than of its posture
constexpr double kNearWorst = 1.8;  // losses up to this much above the worst have a part in the gradient

// The part that a loss has in the gradient of the worst: (worst / its own)^8, so that the gradient does not jump where
// the worst loss changes.
STILLREACH_INLINE double part_of(double worst, double own) {
  if (!(own < kNearWorst * worst)) return 0.0;
  const double two = (worst / own) * (worst / own), four = two * two;
  return four * four;
}

// J = L U' of k columns, which become the rows of U: an orthonormal basis of J's row space, by Gram and Schmidt. At a
// singularity, pivots of L are at least `least`.
template <int M>
inline void orthonormal_rows(Rows<M> m, double* columns, int k, double least, double (*L)[kStride]) {
  for (int s = 0; s < m(); ++s) {
    double square = 0.0;
    for (int j = 0; j < k; ++j) square = madd(columns[j * kStride + s], columns[j * kStride + s], square);
    L[s][s] = larger(square_root(square), least);
    Pack low = {}, high = {};
    for (int j = 0; j < k; ++j) {
      double* u = columns + j * kStride;
      u[s] /= L[s][s];
      low = madd(broadcast(u[s]), load(u), low);
      high = madd(broadcast(u[s]), load(u + 4), high);
    }
    double along[kStride];
    store(along, low);
    store(along + 4, high);
    for (int r = 0; r <= s; ++r) along[r] = 0.0;
    for (int r = s + 1; r < m(); ++r) L[r][s] = along[r];
    low = load(along);
    high = load(along + 4);
    for (int j = 0; j < k; ++j) {
      double* u = columns + j * kStride;
      const Pack own = broadcast(-u[s]);
      store(u, madd(own, low, load(u)));
      store(u + 4, madd(own, high, load(u + 4)));
    }
  }
}

// All sets of `size` of the k joints of U for which det(Q of the set), Q = I - U U', is above `least`; visit(set, its
// Cholesky factor, determinant). The determinant is the square of the relative manipulability without the set.
template <int M, class Visit>
inline void each_set(Rows<M> m, const double* U, int k, int size, double least, const Visit& visit) {
  int at[kMostFailures];
  double L[kMostFailures][kMostFailures], det[kMostFailures + 1];
  int p = 0;
  at[0] = 0;
  det[0] = 1.0;
  while (p >= 0) {
    if (at[p] > k - (size - p)) {
      if (--p >= 0) ++at[p];
      continue;
    }
    const double* u = U + at[p] * kStride;
    double rest = 1.0;
    for (int r = 0; r < m(); ++r) rest = madd(-u[r], u[r], rest);
    for (int s = 0; s < p; ++s) {
      const double* other = U + at[s] * kStride;
      double sum = 0.0;
      for (int r = 0; r < m(); ++r) sum = madd(-u[r], other[r], sum);
      for (int t = 0; t < s; ++t) sum = madd(-L[p][t], L[s][t], sum);
      L[p][s] = sum / L[s][s];
      rest = madd(-L[p][s], L[p][s], rest);
    }
    det[p + 1] = det[p] * larger(rest, 0.0);
    if (!(det[p + 1] > least)) {  // a set that holds these leaves no more
      ++at[p];
      continue;
    }
    L[p][p] = square_root(rest);
    if (p + 1 < size) {
      at[p + 1] = at[p] + 1;
      ++p;
      continue;
    }
    visit(at, L, det[size]);
    ++at[p];
  }
}

// Gradient of the logarithm of the worst relative manipulability, w(J without a set of joints) / w(J), over all sets of
// null_failures joints, or of as many as are spare. d ln r = -tr(Q_SS^-1 (J^+ dJ Q)_SS), with Q = I - J^+ J. It is 0
// at first.
template <int M>
inline void relative_gradient(Rows<M> m, const Settings& settings, const ThisTick& now, const double* q, Workspace& w,
                              double* gradient) {
  double* const U = w.columns;
  double* const force = now.scratch;  // 6 n
  double L[kRows][kStride], size;
  const int k = moving_columns(m, settings, now, w, true, size);
  const int failures = k - m() < settings.null_failures ? k - m() : settings.null_failures;
  if (k == 0 || failures < 1 || choices(k, failures) > kMostChoices) return;  // no joint is spare
  orthonormal_rows(m, U, k, 1e-6 * size, L);
  double worst = infinity();
  const double least = kHopeless * kHopeless;
  each_set(m, U, k, failures, least,
           [&](const int*, const double (*)[kMostFailures], double det) { worst = smaller(worst, det); });
  if (!(worst < infinity())) return;
  worst = square_root(worst);
  for (int i = 0; i < 6 * k; ++i) force[i] = 0.0;
  double total = 0.0;
  each_set(m, U, k, failures, least, [&](const int* set, const double (*F)[kMostFailures], double det) {
    const double part = part_of(worst, square_root(det));
    if (part == 0.0) return;
    total += part;
    double x[kMostFailures][kRows];  // Q_SS^-1 U_S
    for (int p = 0; p < failures; ++p)
      for (int r = 0; r < m(); ++r) {
        double sum = U[set[p] * kStride + r];
        for (int t = 0; t < p; ++t) sum = madd(-F[p][t], x[t][r], sum);
        x[p][r] = sum / F[p][p];
      }
    for (int p = failures - 1; p >= 0; --p)
      for (int r = 0; r < m(); ++r) {
        double sum = x[p][r];
        for (int t = p + 1; t < failures; ++t) sum = madd(-F[t][p], x[t][r], sum);
        x[p][r] = sum / F[p][p];
        force[6 * set[p] + r] = madd(part, x[p][r], force[6 * set[p] + r]);
      }
  });
  double T[kRows][kRows] = {};  // U' force
  for (int j = 0; j < k; ++j)
    for (int s = 0; s < m(); ++s)
      for (int r = 0; r < m(); ++r) T[s][r] = madd(U[j * kStride + s], force[6 * j + r], T[s][r]);
  for (int j = 0; j < k; ++j) {
    double y[kRows];
    for (int r = m() - 1; r >= 0; --r) {  // -(Q force)_j L^-1
      double sum = -force[6 * j + r];
      for (int s = 0; s < m(); ++s) sum = madd(U[j * kStride + s], T[s][r], sum);
      sum /= total;
      for (int t = r + 1; t < m(); ++t) sum = madd(-L[t][r], y[t], sum);
      y[r] = sum / L[r][r];
    }
    to_base(m, settings, now.pose, y, settings.metric.columns ? settings.metric.columns[w.joint[j]] : 1.0,
            force + 6 * j);
  }
  along_joints(settings, now, q, w, k, force, gradient);
}

// A facet of the tool's velocities where every joint's rate is in an interval: it is parallel to m - 1 columns.
struct Facet {
  int at[kRows];               // the columns
  double along[kRows][kRows];  // orthonormal directions: Gram and Schmidt's of the columns
  double normal[kRows];
};

// All facets of k columns, one of each two that face each other, but for those whose columns depend on each other.
template <int M, class Visit>
inline void each_facet(Rows<M> m, const double* columns, int k, const Visit& visit) {
  Facet f;
  double free[kRows][kRows][kRows] = {};  // by the number of columns so far: an orthonormal basis of what they leave
  for (int r = 0; r < m(); ++r) free[0][r][r] = 1.0;
  int p = 0;
  f.at[0] = 0;
  while (p >= 0) {
    const int d = m() - p;
    if (d == 1) {
      for (int r = 0; r < m(); ++r) f.normal[r] = free[p][0][r];
      visit(f);
    } else if (f.at[p] <= k - (d - 1)) {
      const double* a = columns + f.at[p] * kStride;
      double y[kRows], square = 0.0, whole = 0.0;
      for (int r = 0; r < m(); ++r) whole = madd(a[r], a[r], whole);
      for (int j = 0; j < d; ++j) {
        y[j] = 0.0;
        for (int r = 0; r < m(); ++r) y[j] = madd(free[p][j][r], a[r], y[j]);
        square = madd(y[j], y[j], square);
      }
      if (!(square > 1e-18 * whole)) {
        ++f.at[p];
        continue;
      }
      // A reflection takes y to the first axis, and its other columns span what is left.
      const double length = square_root(square), head = y[0] < 0.0 ? y[0] - length : y[0] + length;
      const double scale = 1.0 / (length * magnitude(head));
      for (int r = 0; r < m(); ++r) {
        double v = 0.0;
        for (int j = 0; j < d; ++j) v = madd(free[p][j][r], y[j], v);
        f.along[p][r] = v / length;
        v = madd(free[p][0][r], head - y[0], v);
        for (int j = 1; j < d; ++j) free[p + 1][j - 1][r] = madd(-v, y[j] * scale, free[p][j][r]);
      }
      f.at[p + 1] = f.at[p] + 1;
      ++p;
      continue;
    }
    if (--p >= 0) ++f.at[p];
  }
}

// Gradient of the logarithm of the guaranteed speed after the worst loss of a joint: the speed that the rates of the
// others reach in every direction, the distance to the nearest facet. It changes as the velocity J x of least size on
// the facet does with J, x kept. It is 0 at first.
template <int M>
inline void speed_gradient(Rows<M> m, const Settings& settings, const Faults& faults, const ThisTick& now,
                           const double* q, Workspace& w, double* gradient) {
  const int n = settings.arm.n;
  double* const force = now.scratch;  // 6 n
  double *const lower = force + 6 * n, *const upper = lower + n, *const left = upper + n, *const rate = left + n;
  double *const share = w.z, *const push = w.target;  // n each: what a joint adds to a distance, at its rate, and at 1
  double size;
  const int k = moving_columns(m, settings, now, w, false, size);
  if (k <= m() || choices(k, m() - 1) > kMostChoices) return;  // no joint is spare
  for (int j = 0; j < k; ++j) {
    const int i = w.joint[j];
    const double back = settings.rate_lower[i] > -infinity() ? settings.rate_lower[i] : -kFullRate;
    const Left rates =
        left_by(faults.of[i], back, settings.rate_upper[i] < infinity() ? settings.rate_upper[i] : kFullRate);
    lower[j] = smaller(rates.lower, 0.0);
    upper[j] = larger(rates.upper, 0.0);
    left[j] = infinity();
  }
  // The distance of a facet, or of the one that faces it. The joints of its columns, whose rates do not change it, get
  // the share -1.
  const auto pushed = [&](const Facet& facet) {
    for (int j = 0; j < k; ++j) {
      push[j] = 0.0;
      for (int r = 0; r < m(); ++r) push[j] = madd(facet.normal[r], w.columns[j * kStride + r], push[j]);
    }
    for (int p = 0; p < m() - 1; ++p) push[facet.at[p]] = 0.0;  // but for a rounding error
  };
  const auto distance = [&](const Facet& facet, double sign) {
    double sum = 0.0;
    for (int j = 0; j < k; ++j) {
      rate[j] = sign * push[j] > 0.0 ? upper[j] : lower[j];
      share[j] = sign * rate[j] * push[j];
      sum += share[j];
    }
    for (int p = 0; p < m() - 1; ++p) share[facet.at[p]] = -1.0;
    return sum;
  };
  double whole = infinity();
  each_facet(m, w.columns, k, [&](const Facet& facet) {
    pushed(facet);
    for (double sign = 1.0; sign > -2.0; sign -= 2.0) {
      const double all = distance(facet, sign);
      whole = smaller(whole, all);
      for (int j = 0; j < k; ++j)
        if (share[j] >= 0.0) left[j] = smaller(left[j], all - share[j]);
    }
  });
  double worst = infinity();
  for (int j = 0; j < k; ++j) {
    if (left[j] > kHopeless * whole)
      worst = smaller(worst, left[j]);
    else
      left[j] = 0.0;
  }
  if (!(worst < infinity())) return;
  for (int i = 0; i < 6 * k; ++i) force[i] = 0.0;
  double total = 0.0;
  each_facet(m, w.columns, k, [&](const Facet& facet) {
    pushed(facet);
    for (double sign = 1.0; sign > -2.0; sign -= 2.0) {
      const double all = distance(facet, sign);
      double every = 0.0;
      for (int j = 0; j < k; ++j) {
        if (share[j] < 0.0) continue;
        const double part = left[j] > 0.0 ? part_of(worst, all - share[j]) : 0.0;
        share[j] = part > 0.0 ? part / (all - share[j]) : 0.0;
        total += part;
        every += share[j];
      }
      if (every == 0.0) continue;
      double point[kRows] = {0, 0, 0, 0, 0, 0};  // of the facet: that of these rates
      for (int j = 0; j < k; ++j) {
        if (share[j] < 0.0) continue;
        rate[j] *= every - share[j];
        for (int r = 0; r < m(); ++r) point[r] = madd(rate[j], w.columns[j * kStride + r], point[r]);
      }
      for (int p = m() - 2; p >= 0; --p) {  // the rates along the facet bring it to where the facet is nearest
        const double* column = w.columns + facet.at[p] * kStride;
        double along = 0.0, own = 0.0;
        for (int r = 0; r < m(); ++r) {
          along = madd(facet.along[p][r], point[r], along);
          own = madd(facet.along[p][r], column[r], own);
        }
        rate[facet.at[p]] = -along / own;
        for (int r = 0; r < m(); ++r) point[r] = madd(rate[facet.at[p]], column[r], point[r]);
      }
      for (int j = 0; j < k; ++j)
        for (int r = 0; r < m(); ++r) force[6 * j + r] = madd(sign * rate[j], facet.normal[r], force[6 * j + r]);
    }
  });
  for (int j = 0; j < k; ++j) {
    double y[kRows] = {0, 0, 0, 0, 0, 0};
    for (int r = 0; r < m(); ++r) y[r] = force[6 * j + r] / total;
    to_base(m, settings, now.pose, y, 1.0, force + 6 * j);
  }
  along_joints(settings, now, q, w, k, force, gradient);
}

STILLREACH_END
