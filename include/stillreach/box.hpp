// Bounded least squares by a primal active set (Bjorck, 1996, section 5.2): of all z in the box, those of least
// |b - A z|^2 + kappa |z|^2, and for kappa = 0 among them the one of least norm (or of least z' W z). Starts from the bounds that were active
// a tick ago. Every step lowers the objective or frees a bound, each bound is freed at most kMaxReleases times, so the
// number of steps is bounded by construction.
#pragma once

#include "inner.hpp"
#include "system.hpp"

STILLREACH_BEGIN

constexpr int kMaxReleases = 4;
constexpr int kNever = 100;         // a release count: freeing this variable led nowhere
constexpr double kInside = 1e-12;   // relative slack of a free variable at its bound
constexpr double kRounding = 4e-15; // relative error that a residual may have
constexpr double kDescent = 1e-13;  // relative change of an objective that counts

struct Box {
  int k;
  const double* columns;  // k columns, kStride apart
  const double* length;   // k: their lengths
  const double* lower;    // k, of z
  const double* upper;    // k
  double kappa;
  double threshold;       // of singular values: relative where >= 0, else absolute (its negative)
  const double* weight;   // k x k: W, or null for the identity
  double* whitened;       // 6 k and
  double* triangle;       // k x k numbers where there is a weight
  double* z;              // k: the answer
  std::int8_t* state;     // k: -1 at lower, 1 at upper, 0 free; in: where to start
  double* target;         // k
  double* work;           // 7 k
  int* index;             // k
  int* releases;          // k
  int iterations;         // factorisations
  bool capped;            // the bound on the steps was met
  double residual[kStride]; // b - A z
};

// (W z)_i.
STILLREACH_INLINE double weighted(const Box& b, const double* z, int i) {
  if (!b.weight) return z[i];
  double sum = 0.0;
  for (int j = 0; j < b.k; ++j) sum = madd(b.weight[i * b.k + j], z[j], sum);
  return sum;
}

// Value of the objective: first the task error, then the norm (added up where kappa > 0).
struct Objective {
  double error, norm;
};

template <int M>
inline Objective objective(Rows<M> m, const Box& b, const double* rhs, const double* z) {
  double e[kStride];
  residual_of(b.columns, nullptr, b.k, rhs, z, e);
  Objective o{dot(m, e, e), 0.0};
  for (int i = 0; i < b.k; ++i) o.norm = madd(z[i], weighted(b, z, i), o.norm);
  if (b.kappa > 0.0) o.error = madd(b.kappa, o.norm, o.error), o.norm = 0.0;
  return o;
}

STILLREACH_INLINE bool lower_than(const Objective& a, const Objective& b, double noise) {
  const double slack = kDescent * b.error + noise;
  if (a.error < b.error - slack) return true;
  return a.error <= b.error + slack && a.norm < b.norm * (1.0 - kDescent);
}

// The free variables under a full weight: whitened by its Cholesky factor, moved by what the fixed ones pull.
template <int M>
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
  solve_inner(m, b.whitened, nullptr, free, rest, b.kappa, b.threshold, b.work, z, in);
  for (int j = 0; j < free; ++j) b.target[j] = pull[j] + z[j];
  solve_triangle(free, b.triangle, true, 1, b.target);
}

// Solves for the free variables; target[j] belongs to index[j].
template <int M>
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
      low = madd(load(a), t, low), high = madd(load(a + 4), t, high);
    }
  }
  store(rest, low), store(rest + 4, high);
  if (free > 0) {
    if (b.weight)
      solve_free_weighted(m, b, rest, free, in);
    else
      solve_inner(m, b.columns, b.index, free, rest, b.kappa, b.threshold, b.work, b.target, in);
    ++b.iterations;
  } else {
    for (int r = 0; r < kStride; ++r)
      in.residual[r] = rest[r], in.dual[r] = b.kappa > 0.0 ? rest[r] / b.kappa : 0.0;
  }
  return free;
}

STILLREACH_INLINE bool inside(double z, double lower, double upper) {
  const double slack = kInside * magnitude(z);
  return z <= upper + slack && z >= lower - slack;
}

// Writes a trial point: the free variables at `part` of the way to their targets, stopped at their bounds.
STILLREACH_INLINE void try_step(const Box& b, int free, double part, double* trial) {
  for (int i = 0; i < b.k; ++i) trial[i] = b.z[i];
  for (int j = 0; j < free; ++j) {
    const int i = b.index[j];
    trial[i] = clamp(madd(part, b.target[j] - b.z[i], b.z[i]), b.lower[i], b.upper[i]);
  }
}

// The first bound that the free variables meet on their way to the targets, as an index into b.index; -1: none.
STILLREACH_INLINE int first_bound(const Box& b, int free, double& part) {
  int blocking = -1;
  part = 1.0;
  for (int j = 0; j < free; ++j) {
    const int i = b.index[j];
    if (inside(b.target[j], b.lower[i], b.upper[i])) continue;
    const double move = b.target[j] - b.z[i];
    const double room = ((move > 0.0 ? b.upper[i] : b.lower[i]) - b.z[i]) / move;
    if (blocking < 0 || room < part) part = larger(room, 0.0), blocking = j;
  }
  return blocking;
}

STILLREACH_INLINE void stop_at_bound(Box& b, int j) {
  const int i = b.index[j];
  b.state[i] = b.target[j] > b.upper[i] ? 1 : -1;
  b.z[i] = b.state[i] > 0 ? b.upper[i] : b.lower[i];
}

// Where to start from: the targets stopped at the bounds.
template <int M>
inline void begin(Rows<M> m, Box& b, const double* rhs, int free, Objective& now) {
  for (int j = 0; j < free; ++j) {
    const int i = b.index[j];
    b.z[i] = clamp(b.target[j], b.lower[i], b.upper[i]);
    if (!inside(b.target[j], b.lower[i], b.upper[i])) stop_at_bound(b, j);
  }
  now = objective(m, b, rhs, b.z);
}

// Moves the free variables towards their targets: all the way with the ones that leave the box stopped at it where that
// lowers the objective, else up to the first bound that is met. False, with nothing moved, where the objective would
// rise: then the solve was rounding (or truncated at the rank tolerance), and so was what freed the last variable.
template <int M>
inline bool advance(Rows<M> m, Box& b, const double* rhs, int free, bool all_inside, double noise, Objective& now) {
  double* trial = b.work;  // free again: solve_inner is done with it
  try_step(b, free, 1.0, trial);
  Objective there = objective(m, b, rhs, trial);
  const bool whole = all_inside ? !lower_than(now, there, noise) : lower_than(there, now, noise);
  if (whole) {
    for (int j = 0; j < free; ++j) {
      const int i = b.index[j];
      b.z[i] = trial[i];
      if (!inside(b.target[j], b.lower[i], b.upper[i])) stop_at_bound(b, j);
    }
    now = there;
    return true;
  }
  if (all_inside) return false;
  double part;
  const int blocking = first_bound(b, free, part);
  try_step(b, free, part, trial);
  there = objective(m, b, rhs, trial);
  if (lower_than(now, there, noise)) return false;
  for (int j = 0; j < free; ++j) b.z[b.index[j]] = trial[b.index[j]];
  if (blocking >= 0) stop_at_bound(b, blocking);
  now = there;
  return true;
}

// The fixed variable whose release lowers the objective most, or -1. wanted: one was wanted that may not move again.
template <int M>
inline int choose_release(Rows<M> m, const Box& b, const Inner& in, double rhs_size, bool& wanted) {
  double size = rhs_size;  // residuals are known to a rounding error of this
  for (int i = 0; i < b.k; ++i) size = larger(size, magnitude(b.z[i]) * b.length[i]);
  // How orthogonal the residual came out to the free columns tells how well it is known.
  double floor = 1e-16 * size;
  for (int i = 0; i < b.k; ++i)
    if (b.state[i] == 0 && b.length[i] > 0.0)
      floor = larger(floor, 4.0 * magnitude(dot(m, b.columns + i * kStride, in.residual)) / b.length[i]);
  const bool damped = b.kappa > 0.0, consistent = dot(m, in.residual, in.residual) <= kRounding * kRounding * size * size;
  const double dual_size = square_root(dot(m, in.dual, in.dual));
  int first = -1, second = -1;
  double first_gain = 0.0, second_gain = 0.0;
  wanted = false;
  for (int i = 0; i < b.k; ++i) {
    if (b.state[i] == 0) continue;
    const double* a = b.columns + i * kStride;
    const double side = b.state[i];
    // Moving off the bound, into the box, pays where this is above 0: in the task error, unless that has no say here,
    const double primary = damped || consistent ? 0.0 : -side * dot(m, a, in.residual);
    const double length = b.length[i], noise = length * floor;
    if (magnitude(primary) > noise) {
      if (primary < 0.0) continue;
      if (b.releases[i] >= kMaxReleases)
        wanted |= b.releases[i] != kNever && primary > 100.0 * noise;
      else if (primary > first_gain * length)
        first = i, first_gain = primary / length;
      continue;
    }
    // or in the norm (with damping in the sum of both, which has the same form).
    const double z = weighted(b, b.z, i), secondary = side * (z - dot(m, a, in.dual));
    const double slack = 1e-12 * (magnitude(z) + length * dual_size);
    if (!(secondary > slack)) continue;
    if (b.releases[i] >= kMaxReleases)
      wanted |= b.releases[i] != kNever && secondary > 100.0 * slack;
    else if (secondary > second_gain)
      second = i, second_gain = secondary;
  }
  return first >= 0 ? first : second;
}

// solved: b.target and `in` already hold the answer for all variables free.
template <int M>
inline void solve_box(Rows<M> m, const double* rhs, Box& b, Inner& in, bool solved) {
  const double rhs_size = size_of(m, rhs);
  double size = rhs_size;
  for (int i = 0; i < b.k; ++i) {
    b.releases[i] = 0;
    if (b.state[i] > 0 && !(b.upper[i] < infinity())) b.state[i] = 0;
    if (b.state[i] < 0 && !(b.lower[i] > -infinity())) b.state[i] = 0;
    b.z[i] = b.state[i] > 0 ? b.upper[i] : b.state[i] < 0 ? b.lower[i] : clamp(0.0, b.lower[i], b.upper[i]);
    if (b.state[i] != 0) size = larger(size, magnitude(b.z[i]) * b.length[i]);
  }
  Objective now{infinity(), infinity()};
  bool first = true;
  int freed = -1, freed_from = 0;  // the variable freed last, and the bound it was at
  b.capped = false;
  const int most = (kMaxReleases + 2) * b.k + 2;
  for (int step = 0; step < most; ++step) {
    const int free = solved && step == 0 ? b.k : solve_free(m, b, rhs, in);
    bool all_inside = true;
    for (int j = 0; j < free; ++j) all_inside &= inside(b.target[j], b.lower[b.index[j]], b.upper[b.index[j]]);
    for (int j = 0; j < free; ++j) size = larger(size, magnitude(b.z[b.index[j]]) * b.length[b.index[j]]);
    const double noise = 1e-28 * size * size;
    if (first) {
      begin(m, b, rhs, free, now);
    } else if (!advance(m, b, rhs, free, all_inside, noise, now)) {
      if (freed < 0) break;
      b.state[freed] = static_cast<std::int8_t>(freed_from), b.releases[freed] = kNever;
      freed = -1;
      continue;
    }
    if (freed >= 0 && b.state[freed] == freed_from && !first) b.releases[freed] = kNever;  // back at once: it was rounding
    first = false, freed = -1;
    if (!all_inside) continue;
    bool wanted;
    const int release = choose_release(m, b, in, rhs_size, wanted);
    if (release < 0) {
      b.capped = wanted;
      break;
    }
    ++b.releases[release];
    freed = release, freed_from = b.state[release];
    b.state[release] = 0;
  }
  residual_of(b.columns, nullptr, b.k, rhs, b.z, b.residual);
}

STILLREACH_END
