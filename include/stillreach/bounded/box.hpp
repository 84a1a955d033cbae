// Bounded least squares by a primal active set (Bjorck, 1996, section 5.2): of all z in the box, those of least
// |b - A z|^2 + kappa |z|^2, and for kappa = 0 among them the one of least norm (or of least z' W z). Starts from the
// bounds that were active a tick ago. Every step lowers the objective or frees a bound, each bound is freed at most
// kMaxReleases times, so the number of steps is bounded by construction.
#pragma once

#include "stillreach/linear/inner.hpp"
#include "stillreach/problem/system.hpp"

STILLREACH_BEGIN

constexpr int kMaxReleases = 4;
constexpr int kNever = 100;           // a release count: freeing this variable led straight back to its bound
constexpr double kInside = 1e-12;     // relative slack of a free variable at its bound
constexpr double kRounding = 4e-15;   // relative error that a residual may have
constexpr double kDependent = 1e-14;  // part of the largest singular value that is rounding of the columns
constexpr double kAlong =
    16.0;  // a residual is known to so many times what it has along free columns, whose sum a column may be
constexpr double kDescent = 1e-13;  // relative change of an objective that counts

struct Box {
  int k;
  const double* columns;  // k columns, kStride apart
  const double* length;   // k: their lengths
  const double* lower;    // k, of z
  const double* upper;    // k
  double kappa;
  double threshold;      // of singular values: relative where >= 0, else absolute (its negative)
  double dependent;      // absolute: below it singular values of free columns are rounding
  double whole;          // length of the right-hand side before rows were left out, with which its rounding comes, or 0
  const double* weight;  // k x k: W, or null for the identity
  double* whitened;      // 6 k and
  double* triangle;      // k x k numbers where there is a weight
  double slack;          // of targets at their bounds
  double* z;             // k: the answer
  std::int8_t* state;    // k: -1 at lower, 1 at upper, 0 free; in: where to start
  double* target;        // k
  double* work;          // 7 k
  int* index;            // k
  int* releases;         // k
  int iterations;        // factorisations
  double plain;          // condition number of a Gram matrix up to which its answer is not refined
  double safe;           // condition number of a Gram matrix up to which rounding decides nothing
  bool capped;           // the bound on the steps was met
  bool doubtful;         // rounding may have decided
  double residual[kStride];  // b - A z
};

// (W z)_i.
STILLREACH_INLINE double weighted(const Box& b, const double* z, int i) {
  if (!b.weight) return z[i];
  double sum = 0.0;
  for (int j = 0; j < b.k; ++j) sum = madd(b.weight[i * b.k + j], z[j], sum);
  return sum;
}

// Value of the objective: first the task error, then the norm (added up where kappa > 0).
template <class T>
struct ObjectiveOf {
  T error, norm;
};
using Objective = ObjectiveOf<double>;

template <int M>
inline Objective objective(Rows<M> m, const Box& b, const double* rhs, const double* z) {
  double e[kStride];
  residual_of(b.columns, nullptr, b.k, rhs, z, e);
  Objective o{dot(m, e, e), 0.0};
  for (int i = 0; i < b.k; ++i) o.norm = madd(z[i], weighted(b, z, i), o.norm);
  if (b.kappa > 0.0) {
    o.error = madd(b.kappa, o.norm, o.error);
    o.norm = 0.0;
  }
  return o;
}

template <class T>
STILLREACH_INLINE Where<T> lower_than(const ObjectiveOf<T>& a, const ObjectiveOf<T>& b, T noise) {
  const T slack = fill<T>(kDescent) * b.error + noise;
  return (a.error < b.error - slack) | ((a.error <= b.error + slack) & (a.norm < b.norm * fill<T>(1.0 - kDescent)));
}

// Careful: by singular values in any case.
template <int M, bool Careful>
STILLREACH_INLINE void solve_columns(Rows<M> m, const double* columns, const int* index, int count, const double* rhs,
                                     const Box& b, double* z, Inner& in) {
  if (Careful)
    solve_spectral(m, columns, index, count, rhs, b.kappa, b.threshold, b.work, z, in);
  else
    solve_inner(m, columns, index, count, rhs, b.kappa, b.threshold, b.work, z, in, b.plain);
}

// The free variables under a full weight: whitened by its Cholesky factor, moved by what the fixed ones pull.
template <int M, bool Careful>
inline void solve_free_weighted(Rows<M> m, Box& b, double* rest, int free, Inner& in) {
  double* pull = b.target;
  factor_weight(b.k, b.weight, b.index, free, b.triangle);
  for (int j = 0; j < free; ++j) {
    const int i = b.index[j];
    for (int r = 0; r < kStride; ++r) b.whitened[j * kStride + r] = b.columns[i * kStride + r];
    pull[j] = 0.0;
    for (int f = 0; f < b.k; ++f)
      if (b.state[f] != 0) pull[j] = madd(-b.weight[i * b.k + f], b.z[f], pull[j]);
  }
  solve_triangle(free, b.triangle, false, kStride, b.whitened);
  solve_triangle(free, b.triangle, false, 1, pull);
  for (int j = 0; j < free; ++j)
    for (int r = 0; r < m(); ++r) rest[r] = madd(-b.whitened[j * kStride + r], pull[j], rest[r]);
  double* z = b.work + kRows * b.k;  // behind what the QR needs
  solve_columns<M, Careful>(m, b.whitened, nullptr, free, rest, b, z, in);
  for (int j = 0; j < free; ++j) b.target[j] = pull[j] + z[j];
  solve_triangle(free, b.triangle, true, 1, b.target);
}

// Solves for the free variables; target[j] belongs to index[j].
template <int M, bool Careful = false>
inline int solve_free(Rows<M> m, Box& b, const double* rhs, Inner& in) {
  double rest[kStride];
  int free = 0;
  Pack low = load(rhs), high = load(rhs + 4);
  for (int i = 0; i < b.k; ++i) {
    if (b.state[i] == 0) {
      b.index[free++] = i;
    } else if (b.z[i] != 0.0) {
      const double* a = b.columns + i * kStride;
      const Pack t = broadcast(-b.z[i]);
      low = madd(load(a), t, low);
      high = madd(load(a + 4), t, high);
    }
  }
  store(rest, low);
  store(rest + 4, high);
  if (free > 0) {
    if (b.weight)
      solve_free_weighted<M, Careful>(m, b, rest, free, in);
    else
      solve_columns<M, Careful>(m, b.columns, b.index, free, rest, b, b.target, in);
    ++b.iterations;
  } else {
    for (int r = 0; r < kStride; ++r) {
      in.residual[r] = rest[r];
      in.dual[r] = b.kappa > 0.0 ? rest[r] / b.kappa : 0.0;
    }
  }
  return free;
}

// Whether target[j] is inside its bounds, up to rounding of it and of the largest one.
STILLREACH_INLINE bool inside(const Box& b, int j) {
  const int i = b.index[j];
  const double slack = madd(kInside, magnitude(b.target[j]), b.slack);
  return b.target[j] <= b.upper[i] + slack && b.target[j] >= b.lower[i] - slack;
}

// Moves the free variables towards their targets: all the way with the ones that leave the box stopped at it where that
// lowers the objective, else up to the first bound that is met. Stopped variables become fixed. freed: the variable
// freed last, or -1; where its own bound is the one met, at once, what freed it was rounding.
template <int M>
inline void advance(Rows<M> m, Box& b, const double* rhs, int free, bool first, int freed, double noise,
                    Objective& now) {
  if (first) {
    for (int j = 0; j < free; ++j) {
      const int i = b.index[j];
      b.state[i] = inside(b, j) ? 0 : b.target[j] > b.upper[i] ? 1 : -1;
      b.z[i] = clamp(b.target[j], b.lower[i], b.upper[i]);
    }
    now = objective(m, b, rhs, b.z);
    return;
  }
  double* trial = b.work;  // free again: solve_inner is done with it
  for (int i = 0; i < b.k; ++i) trial[i] = b.z[i];
  for (int j = 0; j < free; ++j) trial[b.index[j]] = clamp(b.target[j], b.lower[b.index[j]], b.upper[b.index[j]]);
  const Objective there = objective(m, b, rhs, trial);
  if (lower_than(there, now, noise)) {
    for (int j = 0; j < free; ++j) {
      const int i = b.index[j];
      if (!inside(b, j)) b.state[i] = b.target[j] > b.upper[i] ? 1 : -1;
      b.z[i] = trial[i];
    }
    now = there;
    return;
  }
  double part = 1.0;
  int blocking = -1;
  for (int j = 0; j < free; ++j) {
    const int i = b.index[j];
    if (inside(b, j)) continue;
    const double move = b.target[j] - b.z[i];
    const double room = ((move > 0.0 ? b.upper[i] : b.lower[i]) - b.z[i]) / move;
    if (blocking < 0 || room < part) {
      part = larger(room, 0.0);
      blocking = j;
    }
  }
  for (int j = 0; j < free; ++j) {
    const int i = b.index[j];
    b.z[i] = clamp(madd(part, b.target[j] - b.z[i], b.z[i]), b.lower[i], b.upper[i]);
  }
  if (blocking >= 0) {
    const int i = b.index[blocking];
    if (i == freed && part == 0.0) b.releases[i] = kNever;
    b.state[i] = b.target[blocking] > b.upper[i] ? 1 : -1;
    b.z[i] = b.state[i] > 0 ? b.upper[i] : b.lower[i];
  }
  now = objective(m, b, rhs, b.z);
}

struct Release {
  int variable = -1;
  double gain = 0.0;
};

// Fixed variable i, whose release gains something beyond `noise`, if it was not released `most` times. wanted: it was.
STILLREACH_INLINE void consider(const Box& b, int i, double gain, double noise, int most, Release& best, bool& wanted) {
  if (b.releases[i] >= most)
    wanted |= b.releases[i] != kNever && gain > 100.0 * noise;
  else if (gain > best.gain) {
    best.variable = i;
    best.gain = gain;
  }
}

// What its release gains in the norm.
template <int M>
STILLREACH_INLINE void consider_norm(Rows<M> m, const Box& b, int i, const double* dual, double dual_size, int most,
                                     Release& best, bool& wanted) {
  const double z = weighted(b, b.z, i), gain = b.state[i] * (z - dot(m, b.columns + i * kStride, dual));
  const double slack = 1e-12 * (magnitude(z) + b.length[i] * dual_size);
  if (gain > slack) consider(b, i, gain, slack, most, best, wanted);
}

// The fixed variable whose release lowers the objective most, or -1. wanted: one was wanted that may not move again.
template <int M>
inline int choose_release(Rows<M> m, Box& b, const Inner& in, double rhs_size, bool& wanted) {
  bool settled = b.kappa > 0.0;  // the task error has no say
  double floor = 0.0;
  if (!settled) {
    double size = rhs_size;  // residuals are known to a rounding error of this
    for (int i = 0; i < b.k; ++i) size = larger(size, magnitude(b.z[i]) * b.length[i]);
    settled = dot(m, in.residual, in.residual) <= kRounding * kRounding * size * size;
    floor = 1e-16 * size;
  }
  if (!settled) {  // how far the residual is from orthogonal to the free columns is how well it is known
    double along = 0.0, longest = 0.0;
    for (int i = 0; i < b.k; ++i) {
      if (b.state[i] != 0) continue;
      along = larger(along, magnitude(dot(m, b.columns + i * kStride, in.residual)));
      longest = larger(longest, b.length[i]);
    }
    if (longest > 0.0) floor = larger(floor, kAlong * along / longest);
  }
  const double dual_size = square_root(dot(m, in.dual, in.dual));
  int first = -1;
  double first_gain = 0.0;
  Release second;
  wanted = false;
  for (int i = 0; i < b.k; ++i) {
    if (b.state[i] == 0) continue;
    const double* a = b.columns + i * kStride;
    const double side = b.state[i];
    // Moving off the bound, into the box, pays where this is above 0: in the task error, unless that has no say here,
    const double primary = settled ? 0.0 : -side * dot(m, a, in.residual);
    const double length = b.length[i], noise = length * floor;
    if (magnitude(primary) > noise) {
      if (primary < 0.0) continue;
      if (b.releases[i] >= kMaxReleases) {
        b.doubtful = true;
        wanted |= b.releases[i] != kNever && primary > 100.0 * noise;
      } else if (primary > first_gain * length) {
        first = i;
        first_gain = primary / length;
      }
      continue;
    }
    // or in the norm (with damping in the sum of both, which has the same form).
    consider_norm(m, b, i, in.dual, dual_size, kMaxReleases, second, wanted);
  }
  return first >= 0 ? first : second.variable;
}

// solved: b.target and `in` already hold the answer for all variables free.
template <int M>
inline void solve_box(Rows<M> m, const double* rhs, Box& b, Inner& in, bool solved) {
  double size = larger(square_root(dot(m, rhs, rhs)), b.whole);
  for (int i = 0; i < b.k; ++i) {
    b.releases[i] = b.lower[i] < b.upper[i] ? 0 : kNever;
    if (b.state[i] > 0 && !(b.upper[i] < infinity())) b.state[i] = 0;
    if (b.state[i] < 0 && !(b.lower[i] > -infinity())) b.state[i] = 0;
    b.z[i] = b.state[i] > 0 ? b.upper[i] : b.state[i] < 0 ? b.lower[i] : clamp(0.0, b.lower[i], b.upper[i]);
    if (b.state[i] != 0) size = larger(size, magnitude(b.z[i]) * b.length[i]);
  }
  const double noise = 1e-28 * size * size;
  Objective now{infinity(), infinity()};
  bool first = true;
  int freed = -1;
  b.capped = b.doubtful = false;
  const int most = (kMaxReleases + 1) * b.k + 2;
  for (int step = 0; step < most; ++step) {
    const int free = solved && step == 0 ? b.k : solve_free(m, b, rhs, in);
    b.slack = 0.0;
    for (int j = 0; j < free; ++j) b.slack = larger(b.slack, 1e-13 * magnitude(b.target[j]));
    bool all_inside = true;
    for (int j = 0; j < free; ++j) all_inside &= inside(b, j);
    if (!all_inside) {
      advance(m, b, rhs, free, first, freed, noise, now);
      first = false;
      freed = -1;
      continue;
    }
    for (int j = 0; j < free; ++j) {
      const int i = b.index[j];
      b.z[i] = clamp(b.target[j], b.lower[i], b.upper[i]);
    }
    for (int r = 0; r < kStride; ++r) b.residual[r] = in.residual[r];
    bool wanted;
    const int release = choose_release(m, b, in, size, wanted);
    if (release < 0) {
      b.capped = wanted;
      b.doubtful |= wanted || (free > 0 && (in.way == InnerWay::SPECTRAL || in.condition > b.safe));
      return;
    }
    now = objective(m, b, rhs, b.z);
    first = false;
    freed = release;
    ++b.releases[release];
    b.state[release] = 0;
  }
  b.capped = b.doubtful = true;
  residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
}

STILLREACH_END
