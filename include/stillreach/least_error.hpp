// LeastError: the least weighted task error inside the bounds, then the rates nearest to the reference; with max_gain g
// damped by kappa <= 1 / (4 g^2) where the bounds or a singularity are near.
#pragma once

#include "careful.hpp"
#include "pseudoinverse.hpp"

STILLREACH_BEGIN

constexpr double kLeftOut = 100.0;      // by this factor what is kept exceeds what the rank tolerance leaves out
constexpr double kBoundRamp = 0.5;      // damping is full where the pseudoinverse exceeds a bound by this part of the largest

// Under a full joint weight W fixed joints that are off their reference pull at the others: nearest to the reference is then
// nearest to reference - W_ww^-1 W_wf (rates_f - reference_f).
inline void pull_reference(const Problem& p, const System& s, const double* rates, Workspace& w) {
  const double unit = s.unit_b / s.unit_a;
  bool any = false;
  for (int j = 0; j < s.k; ++j) w.target[j] = 0.0;
  for (int f = 0; f < p.n; ++f) {
    if (p.lower[f] < p.upper[f]) continue;
    const double off = (rates[f] - (p.reference ? p.reference[f] : 0.0)) / p.metric.units[f] / unit;
    if (off == 0.0 || !is_finite(off)) continue;
    any = true;
    for (int j = 0; j < s.k; ++j) {
      const int i = w.joint[j];
      w.target[j] -= p.metric.joints[static_cast<std::size_t>(i) * p.n + f] * off;
    }
  }
  if (!any) return;
  factor_weight(s.k, w.weight, nullptr, s.k, w.triangle);
  solve_triangle(s.k, w.triangle, false, 1, w.target);
  solve_triangle(s.k, w.triangle, true, 1, w.target);
  for (int j = 0; j < s.k; ++j) w.offset[j] += w.target[j];
}

// The bounded problem in scaled rates relative to the reference. rhs: right-hand side moved by the reference.
template <int M>
inline Box make_box(Rows<M> m, const LawSettings& law, const Problem& p, System& s, const double* rates, Workspace& w, double* rhs) {
  for (int r = 0; r < kStride; ++r) rhs[r] = s.rhs[r];
  // Damping pulls towards the reference: only the part of it that does not move the tool may do so. (Without damping the
  // rest of it has no say: J dq is settled first.)
  if (p.reference && law.max_gain > 0.0) project_reference(m, p, s, law.rank_tolerance, false, w, w.offset);
  for (int j = 0; j < s.k; ++j) {
    if (!p.reference || !(law.max_gain > 0.0)) w.offset[j] = p.reference ? p.reference[w.joint[j]] / w.scale[j] : 0.0;
    if (!is_finite(w.offset[j])) w.offset[j] = 0.0;
  }
  if (s.full) {
    gather_joint_weight(p, s.k, w);
    pull_reference(p, s, rates, w);
  }
  for (int j = 0; j < s.k; ++j) {
    w.lower[j] = p.lower[w.joint[j]] / w.scale[j] - w.offset[j];
    w.upper[j] = p.upper[w.joint[j]] / w.scale[j] - w.offset[j];
    if (w.offset[j] == 0.0) continue;
    for (int r = 0; r < m(); ++r) rhs[r] = madd(-w.columns[j * kStride + r], w.offset[j], rhs[r]);
  }
  Box b;
  b.k = s.k, b.columns = w.columns, b.length = w.length, b.lower = w.lower, b.upper = w.upper, b.kappa = 0.0, b.threshold = law.rank_tolerance;
  b.weight = s.full ? w.weight : nullptr, b.whitened = w.whitened, b.triangle = w.triangle;
  b.z = w.z, b.state = w.state, b.target = w.target, b.work = w.work, b.index = w.index, b.releases = w.releases;
  b.dependent = b.whole = 0.0, b.safe = kTwiceCondition, b.iterations = 0, b.capped = b.doubtful = false;
  return b;
}

// Needed as soon as a bound bites.
template <int M>
inline void measure_columns(Rows<M> m, const System& s, Workspace& w) {
  for (int j = 0; j < s.k; ++j) w.length[j] = size_of(m, w.columns + j * kStride);
}

// All variables free: the pseudoinverse, in b.target and `in`. Makes the rank threshold absolute. True where it is
// inside the bounds.
template <int M>
inline bool solve_unbounded(Rows<M> m, const double* rhs, Box& b, Inner& in) {
  for (int j = 0; j < b.k; ++j) b.state[j] = 0;
  solve_free(m, b, rhs, in);
  const double sigma = in.way == SPECTRAL ? in.spectrum.sigma[0] : square_root(in.factor.trace);
  b.threshold = -b.threshold * sigma, b.dependent = kDependent * sigma;
  bool all = true;
  for (int j = 0; j < b.k; ++j) all &= b.target[j] <= b.upper[j] && b.target[j] >= b.lower[j];
  return all;
}

// Where the rank is short: columns and right-hand side by their components along the left singular vectors that count. What
// is left out does not change with the rates, and what is left has full rank for every set of free variables that spans it.
// Returns how many rows are left.
template <int M>
inline int reduce_rows(Rows<M> m, const Spectrum& s, double* columns, Box& b, double* rhs) {
  const int rank = s.rank > 0 ? s.rank : 1;
  b.whole = 10.0 * size_of(m, rhs);  // the components share the rounding of the rows
  double own[kStride];
  for (int j = 0; j <= b.k; ++j) {
    double* a = j < b.k ? columns + j * kStride : rhs;
    for (int r = 0; r < kStride; ++r) own[r] = r < rank ? dot(m, s.left[r], a) : 0.0;
    for (int r = 0; r < kStride; ++r) a[r] = own[r];
  }
  // What was left out counts little only beside singular values well above it.
  if (s.rank < s.count) b.dependent = smaller(larger(b.dependent, kLeftOut * s.sigma[s.rank]), -10.0 * b.threshold);
  return rank;
}

// Part of the largest damping, 1 / (4 g^2), for max_gain g: 0 where the targets are inside the bounds and the gain is below g;
// else rising with the gain, just fast enough to keep the damped gain at g, or with the excess over the bounds. target[j]
// belongs to index[j], or to j where index is null.
STILLREACH_INLINE double damping_part(double g, const Box& b, const int* index, int count, double inverse_square_sum) {
  const double sg = g / square_root(inverse_square_sum);  // g times a smooth lower bound of the smallest singular value
  double part = sg >= 1.0 ? 0.0 : sg <= 0.5 ? 1.0 : 4.0 * sg * (1.0 - sg);
  double largest = 0.0, excess = 0.0;
  for (int j = 0; j < count; ++j) {
    const int i = index ? index[j] : j;
    const double up = magnitude(b.upper[i]), down = magnitude(b.lower[i]);
    if (up < infinity()) largest = larger(largest, up);
    if (down < infinity()) largest = larger(largest, down);
    excess = larger(excess, larger(b.target[j] - b.upper[i], b.lower[i] - b.target[j]));
  }
  if (excess > 0.0) part = larger(part, excess < kBoundRamp * largest ? excess / (kBoundRamp * largest) : 1.0);
  return part;
}

// Whether some window between two bounds is narrow beside the widest. An infinite one is wide.
STILLREACH_INLINE bool any_narrow(const Box& b) {
  if (b.k < 4) {
    double least = infinity(), most = 0.0;
    for (int j = 0; j < b.k; ++j) least = smaller(least, b.upper[j] - b.lower[j]), most = larger(most, b.upper[j] - b.lower[j]);
    return least < kNarrow * most;
  }
  Pack least = load(b.upper) - load(b.lower), most = least;
  for (int next = 4; next < b.k; next += 4) {  // the last four may overlap those before
    const int j = next + 4 <= b.k ? next : b.k - 4;
    const Pack width = load(b.upper + j) - load(b.lower + j);
    least = choose(least < width, least, width), most = choose(most > width, most, width);
  }
  const double low = smaller(smaller(least[0], least[1]), smaller(least[2], least[3]));
  return low < kNarrow * larger(larger(most[0], most[1]), larger(most[2], most[3]));
}

// Joints with narrow windows count the less the narrower these are, so that the damping has no jump where a window closes and
// its joint is one of the fixed. With the shares s1 <= s2 <= ... of the narrow ones, the part is that of all joints, s1 times,
// of all but the first, s2 - s1 times, and so on. all: the part with all joints. Leaves b.state zeros, b.target as it was.
template <int M>
inline STILLREACH_NOINLINE double faded_part(Rows<M> m, double g, const double* rhs, Workspace& w, Box& b, double all) {
  double widest = 0.0, fastest = 0.0, *share = w.shapes, *target = w.shapes + b.k;
  bool endless = false;
  for (int i = 0; i < b.k; ++i) {
    const double width = b.upper[i] - b.lower[i];
    target[i] = b.target[i], fastest = larger(fastest, magnitude(target[i]));
    endless |= width == infinity();
    if (width < infinity()) widest = larger(widest, width);
  }
  if (endless) widest = larger(widest, 2.0 * fastest);
  int narrow = 0, *order = b.releases;
  for (int i = 0; i < b.k; ++i) {
    share[i] = (b.upper[i] - b.lower[i]) / (kNarrow * widest);
    if (!(share[i] < 1.0)) continue;
    int at = narrow++;
    for (; at > 0 && share[order[at - 1]] > share[i]; --at) order[at] = order[at - 1];
    order[at] = i;
  }
  if (narrow == 0) return all;
  double part = share[order[0]] * all;
  Inner in;
  for (int r = 0; r < narrow; ++r) {
    const int i = order[r];
    const double gap = (r + 1 < narrow ? share[order[r + 1]] : 1.0) - share[i];
    b.state[i] = 1, b.z[i] = 0.5 * (b.lower[i] + b.upper[i]);
    if (!(gap > 0.0)) continue;
    const int free = solve_free(m, b, rhs, in);
    part = madd(gap, damping_part(g, b, b.index, free, in.inverse_square_sum), part);
  }
  for (int i = 0; i < b.k; ++i) b.state[i] = 0, b.target[i] = target[i];
  return part;
}

// From scaled rates relative to the reference to rates inside the bounds; those at a bound get it exactly.
inline void write_rates(const Problem& p, const Box& b, const Workspace& w, double* rates) {
  for (int j = 0; j < b.k; ++j) {
    const int i = w.joint[j];
    const double rate = w.scale[j] * (b.z[j] + w.offset[j]);
    const double bound = b.state[j] > 0 ? p.upper[i] : p.lower[i];
    rates[i] = b.state[j] != 0 && is_finite(bound) ? bound : clamp(is_finite(rate) ? rate : 0.0, p.lower[i], p.upper[i]);
  }
}

// Working joints and columns; false where there is nothing to solve, the answer standing already.
template <int M>
inline bool prepare(Rows<M> m, const Problem& p, Workspace& w, Answer& out, System& s) {
  int k;
  out.status = OK, out.damping = 0.0, out.scale = 1.0, out.iterations = 0;
  find_working_joints(p, nullptr, w, k, out.rates);
  if (k > 0) {
    s = assemble(m, p, out.rates, nullptr, k, nullptr, w);
    if (s.finite) return true;
    out.status |= INVALID_INPUT;
  } else {
    out.status |= NO_WORKING_JOINT;
  }
  rest(p, out.rates);
  report(m, p, out);
  return false;
}

// Starting states from the bounds that were active a tick ago. True where there were any.
inline bool warm_states(const Workspace& w, int k, const std::int8_t* active, std::int8_t* state) {
  bool any = false;
  for (int j = 0; j < k; ++j) {
    const std::int8_t a = active[w.joint[j]];
    state[j] = a == 1 || a == -1 ? a : 0;
    any |= state[j] != 0;
  }
  return any;
}

// The bounded search in the rows that count: m of them, and below m the leading left singular vectors.
template <int M>
inline void least_error_in_box(Rows<M> m, const double* rhs, bool solved, const std::int8_t* active, const Workspace& w, Box& b,
                               Inner& in) {
  const bool warm = warm_states(w, b.k, active, b.state);
  solve_box(m, rhs, b, in, solved && !warm && b.kappa == 0.0);
  if (b.capped && warm) {  // a start from elsewhere can cost more steps than there are
    for (int j = 0; j < b.k; ++j) b.state[j] = 0;
    solve_box(m, rhs, b, in, false);
  }
  if (b.doubtful && b.kappa == 0.0) settle_box(m, rhs, b, in);
}

template <int M>
inline void least_error(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  System s;
  if (!prepare(m, p, w, out, s)) return;
  double rhs[kStride];
  Box b = make_box(m, law, p, s, out.rates, w, rhs);
  Inner in;
  const bool inside_all = solve_unbounded(m, rhs, b, in);
  if (in.rank < (s.k < m() ? s.k : m())) out.status |= SINGULAR;
  if (law.max_gain > 0.0) {
    const double g = law.max_gain * s.unit_a;
    double part = damping_part(g, b, nullptr, s.k, in.inverse_square_sum);
    if (any_narrow(b)) part = faded_part(m, g, rhs, w, b, part);
    b.kappa = part / (4.0 * g * g);
  }
  if (inside_all && b.kappa == 0.0) {
    for (int j = 0; j < s.k; ++j) b.z[j] = b.target[j];
  } else {
    measure_columns(m, s, w);
    if (out.status & SINGULAR) {
      const Rows<0> rank{reduce_rows(m, in.spectrum, w.columns, b, rhs)};
      least_error_in_box(rank, rhs, false, out.active, w, b, in);
    } else {
      least_error_in_box(m, rhs, true, out.active, w, b, in);
    }
    if (b.capped) out.status |= ITERATION_LIMIT;
  }
  out.iterations = b.iterations;
  out.damping = b.kappa * s.unit_a * s.unit_a;
  if (b.kappa > 0.0) out.status |= DAMPED;
  write_rates(p, b, w, out.rates);
  report(m, p, out);
}

STILLREACH_END
