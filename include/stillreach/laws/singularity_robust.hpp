// The singularity-robust inverse with failed joints, eq. (5) to (8) of Bedrossian (1994), damped by a number, by eq.
// (16) or by eq. (10). Rates are dq = D u with D the bound on the side that a joint moves to; norm and damping act on
// u.
#pragma once

#include "stillreach/laws/sides.hpp"

STILLREACH_BEGIN

constexpr int kSidePasses = 12;  // under a full joint weight, where no one answer need be the least
constexpr int kFreePasses = 4;   // after these a joint that changes sides keeps the smaller of its two bounds

// The damping factor that a law's settings ask for, given the undamped answer in w.z (scaled rates x) and `in`.
// Writes the damped answer to w.z where the factor is not 0.
template <int M>
inline double choose_damping(Rows<M> m, const LawSettings& law, const System& s, bool offset, Workspace& w, Inner& in,
                             Answer& out) {
  double largest = 0.0, square = 0.0;
  for (int j = 0; j < s.k; ++j) {
    const double u = magnitude(w.z[j]) * w.limit[j];
    largest = larger(largest, u);
    square = madd(u, u, square);
  }
  const double size = law.norm == NormKind::EUCLIDEAN ? square_root(square) : largest;
  if (size <= 1.0 + kLimitSlack) return 0.0;

  bool harmless = in.way == InnerWay::WIDE && in.condition <= kPlainCondition;
  double kappa;
  if (harmless && law.damping == DampingKind::EXACT && !s.full && !offset) {
    for (int j = 0; j < s.k; ++j) w.target[j] = w.z[j];
    double steps;
    harmless = exact_damping(m, StridedColumns{w.columns}, s.k, s.rhs, w.limit, law.norm, true, in.factor, in.dual,
                             w.target, kappa, steps);
    out.iterations = static_cast<int>(steps);
    for (int j = 0; harmless && j < s.k; ++j) w.z[j] = w.target[j];
    if (harmless) return kappa;
  }
  if (harmless)
    spectrum(m(), in.factor, law.rank_tolerance, in.spectrum);
  else if (in.way != InnerWay::SPECTRAL)
    spectrum(m(), w.columns, nullptr, s.k, law.rank_tolerance, w.work, in.spectrum);
  const Spectrum& sp = in.spectrum;
  DampingSearch d;
  d.k = s.k;
  d.rank = sp.rank;
  d.shapes = w.shapes;
  d.terms = w.work;
  d.limit = w.limit;
  d.offset = offset ? w.offset : nullptr;
  for (int j = 0; j < sp.rank; ++j) {
    d.beta[j] = dot(m, sp.left[j], s.rhs);
    d.square[j] = sp.sigma[j] * sp.sigma[j];
  }
  write_shapes(m, sp, s.k, w);
  unwhiten(s, w, 6, w.shapes);
  if (law.damping == DampingKind::EXACT) {
    bool capped;
    kappa = exact_damping(d, law.norm, out.iterations, capped);
    if (capped) out.status |= ITERATION_LIMIT;
  } else {
    kappa = closed_form_damping(d, law.norm);
  }
  if (!(kappa > 0.0)) return 0.0;
  for (int i = 0; i < s.k; ++i) {  // as the search saw them
    w.z[i] = offset ? w.offset[i] : 0.0;
    for (int j = 0; j < sp.rank; ++j) w.z[i] = madd(w.shapes[6 * i + j], d.beta[j] / (d.square[j] + kappa), w.z[i]);
  }
  return kappa;
}

// Whether the columns have full rank, of which a damped answer says nothing where its damping hides the small singular
// values.
template <int M>
inline bool has_full_rank(Rows<M> m, const LawSettings& law, const Problem& p, const System& s, double kappa,
                          const Inner& in, Workspace& w) {
  const int most = full_rank(p, s.k);
  if (!(kappa > 0.0) || in.way == InnerWay::SPECTRAL) return in.rank >= most;
  // 1 / trace of the inverse is at most the smallest eigenvalue
  if (1.0 / in.factor.inverse_trace - kappa > in.factor.trace / kRefinedCondition) return true;
  Inner bare;
  solve_inner(m, w.columns, nullptr, s.k, s.rhs, 0.0, law.rank_tolerance, w.work, w.target, bare);
  return bare.rank >= most;
}

// One pass with the sides and held joints as they are. Returns false where there was nothing to solve.
template <int M>
inline bool damped_pass(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out, System& s) {
  int k;
  out.status = OK;
  out.damping = 0.0;
  out.iterations = 1;
  find_working_joints(p, w.held, w, k, out.rates);
  s.k = k;
  if (k == 0) return false;
  s = assemble(m, p, out.rates, w.held, k, w.extent, w);
  if (!s.finite) {
    rest(p, out.rates);
    out.status |= INVALID_INPUT;
    return false;
  }
  whiten(p, law.rank_tolerance, s, w);
  const bool offset = weight_offset(m, p, out.rates, w.held, s, w);
  for (int j = 0; j < k; ++j) {
    const double extent = w.extent[w.joint[j]];
    w.limit[j] = extent < infinity() ? w.scale[j] / extent : 0.0;
  }
  const double kappa = law.damping == DampingKind::NUMBER ? law.kappa / s.unit_a / s.unit_a : 0.0;
  Inner in;
  solve_inner(m, w.columns, nullptr, k, s.rhs, kappa, law.rank_tolerance, w.work, w.z, in);
  unwhiten(s, w, 1, w.z);
  if (offset)
    for (int j = 0; j < k; ++j) w.z[j] += w.offset[j];
  if (!has_full_rank(m, law, p, s, kappa, in, w) || s.idle) out.status |= SINGULAR;
  out.damping = law.damping == DampingKind::NUMBER
                    ? law.kappa
                    : choose_damping(m, law, s, offset, w, in, out) * s.unit_a * s.unit_a;
  for (int j = 0; j < k; ++j) out.rates[w.joint[j]] = w.scale[j] * w.z[j];
  return true;
}

// Joints pushed against a bound at or beyond zero are held there; those that moved to the side with another bound get
// it. True where something changed: the sides are not yet those that the joints move to.
inline bool review_sides(const Problem& p, int k, int pass, Workspace& w, double* rates) {
  bool changed = false;
  for (int j = 0; j < k; ++j) {
    const int i = w.joint[j];
    if (rates[i] == 0.0) continue;
    const bool up = rates[i] > 0.0;
    double extent = up ? p.upper[i] : -p.lower[i];
    if (pass >= kFreePasses && extent > w.extent[i]) extent = w.extent[i];
    if (!(extent > 0.0)) {
      w.held[i] = 1;
      rates[i] = up ? p.upper[i] : p.lower[i];
      changed = true;
    } else if (extent != w.extent[i]) {
      w.extent[i] = extent;
      changed = true;
    }
  }
  return changed;
}

// Adds the largest part, at most all, of the projected reference rate that leaves every working joint inside its
// bounds.
template <int M>
inline void add_null_motion(Rows<M> m, const LawSettings& law, const Problem& p, const System& s, Workspace& w,
                            double* rates) {
  project_reference(m, p, s, law.rank_tolerance, s.full, w, w.limit);
  double part = 1.0;
  for (int j = 0; j < s.k; ++j) {
    const int i = w.joint[j];
    const double move = w.scale[j] * w.limit[j];
    if (move == 0.0) continue;
    const double room = ((move > 0.0 ? p.upper[i] : p.lower[i]) - rates[i]) / move;
    if (room < part) part = larger(room, 0.0);
  }
  for (int j = 0; j < s.k; ++j) {
    const double move = w.scale[j] * w.limit[j];
    if (part > 0.0 && is_finite(move)) rates[w.joint[j]] = madd(part, move, rates[w.joint[j]]);
  }
}

template <int M>
inline void singularity_robust(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  out.scale = 1.0;
  for (int i = 0; i < p.n; ++i) {
    w.held[i] = 0;
    w.extent[i] = larger(p.upper[i], -p.lower[i]);
  }
  System s;
  bool solved = false;
  for (int pass = 0; pass < kSidePasses; ++pass) {
    solved = damped_pass(m, law, p, w, out, s);
    if (!solved || !review_sides(p, s.k, pass, w, out.rates)) break;
    if (s.full) continue;
    settle_sides(Rows<0>{m()}, law, p, s, w, out);
    break;
  }
  if (!solved && s.k == 0) out.status |= NO_WORKING_JOINT;
  if (solved && s.k > 0 && p.reference) add_null_motion(m, law, p, s, w, out.rates);
  if (out.damping > 0.0) out.status |= DAMPED;
  for (int i = 0; i < p.n; ++i) {
    if (!(p.lower[i] < p.upper[i])) {
      out.rates[i] = p.lower[i];
      continue;
    }
    const double rate = is_finite(out.rates[i]) ? out.rates[i] : 0.0, inside = clamp(rate, p.lower[i], p.upper[i]);
    if (magnitude(inside - rate) > 1e-9 * magnitude(rate)) out.status |= CLIPPED;
    out.rates[i] = inside;
  }
  report(m, p, out);
}

STILLREACH_END
