// Which side each joint moves to where its bounds differ. Rates are dq = D u with D the bound on that side, and of all
// that no bound at or beyond zero forbids the answer has the least |x - J D u|^2 + kappa |u|^2. Each joint's part of
// |u|^2 is half a parabola on either side of zero, and both halves are smooth there: strictly convex in the rates for
// kappa > 0, so that there is one answer, which moves continuously with kappa. box.hpp finds it over joints that may
// move to one side only, each turned to its other side where it stops at zero. (Under a full joint weight the halves
// do not fit, and there may be none.)
#pragma once

#include "stillreach/laws/damping.hpp"
#include "stillreach/laws/least_error.hpp"

STILLREACH_BEGIN

constexpr int kMostSolves = 100;  // factorisations, after which a damping on the safe side has to do
constexpr int kSafeHalvings = 6;  // that bring it nearer to the least
constexpr double kSame = 1e-13;   // relative difference of two dampings that is rounding
constexpr double kMostDamping = 1e300;
constexpr double kNoRoom = 1e-100;  // part of the largest bound that counts as none

struct Sides {
  const Problem& p;
  Workspace& w;  // w.extent: the bound on the side that a joint is on, whose sign w.scale has
  Box box;
  Inner in;
  double reference;
  bool capped;  // kMostSolves were not enough
};

inline bool may_go_on(Sides& t) {
  t.capped |= t.box.iterations >= kMostSolves;
  return !t.capped;
}

STILLREACH_INLINE bool has_room(const Sides& t, int i, bool up) {
  const double extent = up ? t.p.upper[i] : -t.p.lower[i];
  return extent > 0.0 && relative_extent(t.p, i, extent, t.reference) > kNoRoom;
}

// Turns working joint j to a side that has room.
inline void turn_to(Sides& t, int j, bool up) {
  const Problem& p = t.p;
  const Workspace& w = t.w;
  const int i = w.joint[j];
  const double extent = up ? p.upper[i] : -p.lower[i], least = up ? p.lower[i] : -p.upper[i];
  const double size = relative_extent(p, i, extent, t.reference) / relative_extent(p, i, w.extent[i], t.reference);
  const double factor = up == (w.scale[j] > 0.0) ? size : -size;
  w.extent[i] = extent;
  w.scale[j] *= factor;
  w.length[j] *= size;
  for (int r = 0; r < kStride; ++r) w.columns[j * kStride + r] *= factor;
  w.limit[j] = extent < infinity() ? magnitude(w.scale[j]) / extent : 0.0;
  w.lower[j] = least > 0.0 ? least / magnitude(w.scale[j]) : 0.0;
  w.upper[j] = infinity();
}

// Joints with one bound for both sides may move either way; the others go to the side that w.z moves them to, or to
// the one that has room.
inline void choose_sides(Sides& t) {
  const Workspace& w = t.w;
  for (int j = 0; j < t.box.k; ++j) {
    const int i = w.joint[j];
    const double upper = t.p.upper[i], lower = t.p.lower[i];
    w.held[i] = 0;
    w.extent[i] = larger(upper, -lower);
    if (upper == -lower) {
      w.lower[j] = -infinity();
      w.upper[j] = infinity();
      continue;
    }
    const bool wanted = w.z[j] > 0.0, up = has_room(t, i, wanted) ? wanted : !wanted;
    if (has_room(t, i, up))
      turn_to(t, j, up);
    else
      w.lower[j] = w.upper[j] = 0.0;
  }
}

// Which way the multiplier of the present answer, for kappa > 0, pulls joint j: below 0 to its other side.
STILLREACH_INLINE double pulled(Rows<0> m, const Sides& t, int j) {
  return dot(m, t.w.columns + j * kStride, t.in.dual);
}

// The answer for one kappa. Joints at rest are turned until none has left its rest on either side.
inline void settle(Rows<0> m, const double* rhs, double kappa, Sides& t) {
  Box& b = t.box;
  const Workspace& w = t.w;
  b.kappa = kappa;
  for (bool first = true;; first = false) {
    solve_box(m, rhs, b, t.in, false);
    if (b.doubtful && kappa == 0.0) settle_box(m, rhs, b, t.in);
    bool moved = first, turned = false;
    for (int j = 0; j < b.k; ++j) moved |= w.held[w.joint[j]] != 0 && b.state[j] == 0;
    for (int j = 0; j < b.k; ++j) {
      const int i = w.joint[j];
      const bool up = w.scale[j] > 0.0, rests = b.state[j] < 0 && w.lower[j] == 0.0 && w.upper[j] > 0.0;
      w.held[i] = moved && rests && has_room(t, i, !up) && !(kappa > 0.0 && pulled(m, t, j) >= 0.0);
      if (!w.held[i]) continue;
      turn_to(t, j, !up);
      turned = true;
    }
    if (!turned) return;
    if (may_go_on(t)) continue;
    for (int j = 0; j < b.k; ++j) w.held[w.joint[j]] = 0;
    return;
  }
}

// Norm of the rates relative to their bounds.
inline double relative_size(NormKind norm, const Sides& t) {
  double largest = 0.0, square = 0.0;
  for (int j = 0; j < t.box.k; ++j) {
    const double u = t.box.state[j] == 0 ? magnitude(t.box.z[j]) * t.w.limit[j] : 0.0;
    largest = larger(largest, u);
    square = madd(u, u, square);
  }
  return norm == NormKind::EUCLIDEAN ? square_root(square) : largest;
}

STILLREACH_INLINE std::int8_t side(const Sides& t, int j) {
  return static_cast<std::int8_t>(t.box.state[j] != 0 ? 0 : t.w.scale[j] > 0.0 ? 1 : 2);
}
// The side of each joint that moves, or 0, to compare with later.
inline void remember_sides(Sides& t) {
  for (int j = 0; j < t.box.k; ++j) t.w.other_active[j] = side(t, j);
}
inline bool same_sides(const Sides& t) {
  for (int j = 0; j < t.box.k; ++j)
    if (t.w.other_active[j] != side(t, j)) return false;
  return true;
}

// The search over dampings on the present sides.
inline void decompose(Rows<0> m, const double* rhs, Sides& t, DampingSearch& d) {
  Workspace& w = t.w;
  const Box& b = t.box;
  Spectrum& sp = t.in.spectrum;
  double left[kStride], *limit = w.offset;
  for (int r = 0; r < kStride; ++r) left[r] = rhs[r];
  d.k = 0;
  for (int j = 0; j < b.k; ++j) {
    if (b.state[j] == 0) {
      limit[d.k] = w.limit[j];
      w.index[d.k++] = j;
    } else {
      for (int r = 0; r < kStride; ++r) left[r] = madd(-w.columns[j * kStride + r], b.z[j], left[r]);
    }
  }
  spectrum(m(), w.columns, w.index, d.k, b.threshold, w.work, sp);
  d.rank = sp.rank;
  d.terms = w.work;
  d.shapes = w.shapes;
  d.limit = limit;
  d.offset = nullptr;
  for (int j = 0; j < sp.rank; ++j) {
    d.beta[j] = dot(m, sp.left[j], left);
    d.square[j] = sp.sigma[j] * sp.sigma[j];
  }
  write_shapes(m, sp, d.k, w);
}

// Where between a kappa that is too small, `above` the limit by so much, and one that is large enough the limit is met,
// while joints change sides: regula falsi (Illinois; Dowell and Jarratt, 1971).
inline double crossing(Rows<0> m, NormKind norm, const double* rhs, double low, double above, double high, double below,
                       Sides& t) {
  int last = 0;
  while (high - low > 1e-15 * high && may_go_on(t)) {
    double kappa = high - below * ((high - low) / (below - above));
    if (!(kappa > low && kappa < high)) kappa = 0.5 * (low + high);
    settle(m, rhs, kappa, t);
    const double off = relative_size(norm, t) - 1.0;
    if (off > kLimitSlack) {
      low = kappa;
      above = off;
      if (last < 0) below *= 0.5;
      last = -1;
    } else {
      high = kappa;
      below = off;
      if (off >= -kLimitSlack) return high;
      if (last > 0) above *= 0.5;
      last = 1;
    }
  }
  settle(m, rhs, high, t);
  return high;
}

// On whatever sides, a kappa that meets the limit, brought nearer to `low`, which does not.
inline double safe_on_sides(Rows<0> m, NormKind norm, const double* rhs, double low, Sides& t) {
  double most = 0.0, sum = 0.0;  // |u_i| <= limit_i |a_i| |rhs| / kappa
  for (int j = 0; j < t.box.k; ++j) {
    const double u = t.w.limit[j] * t.w.length[j];
    most = larger(most, u);
    sum = madd(u, u, sum);
  }
  double high = larger((norm == NormKind::EUCLIDEAN ? square_root(sum) : most) * size_of(m, rhs), low);
  if (!(high < kMostDamping)) high = kMostDamping;
  for (int half = 0; half < kSafeHalvings; ++half) {
    const double kappa = square_root(larger(low, 1e-16 * high)) * square_root(high);
    settle(m, rhs, kappa, t);
    (relative_size(norm, t) <= 1.0 ? high : low) = kappa;
  }
  settle(m, rhs, high, t);
  return high;
}

// The first kappa that meets the limit, along steps that do not pass it while the sides stay. size: at kappa = 0.
inline double exact_on_sides(Rows<0> m, NormKind norm, const double* rhs, double size, Sides& t) {
  DampingSearch d;
  double kappa = 0.0;
  for (bool changed = true; may_go_on(t);) {
    if (changed) decompose(m, rhs, t, d);
    if (norm == NormKind::MAXIMUM) gather_terms(d);
    const double next = kappa + (norm == NormKind::EUCLIDEAN ? step_2(d, kappa) : step_inf(d, kappa));
    if (!(next > kappa)) return kappa;
    settle(m, rhs, next, t);
    changed = !same_sides(t);
    remember_sides(t);
    const double now = relative_size(norm, t);
    if (now <= 1.0 + kLimitSlack) return changed ? crossing(m, norm, rhs, kappa, size - 1.0, next, now - 1.0, t) : next;
    kappa = next;
    size = now;
  }
  return safe_on_sides(m, norm, rhs, kappa, t);
}

// The kappa of eq. (16) on its own answer's sides; where it jumps past itself, one that it does not raise.
inline double closed_form_on_sides(Rows<0> m, NormKind norm, const double* rhs, Sides& t) {
  DampingSearch d;
  double kappa = 0.0, high = kMostDamping;
  for (bool changed = true; may_go_on(t);) {
    if (changed) decompose(m, rhs, t, d);
    const double own = closed_form_damping(d, norm);
    if (!(own < kMostDamping)) break;
    if (magnitude(own - kappa) <= kSame * kappa) return kappa;
    if (own < kappa)
      high = kappa;
    else if (high < kMostDamping)
      break;
    kappa = own;
    settle(m, rhs, kappa, t);
    changed = !same_sides(t);
    remember_sides(t);
  }
  if (!(high < kMostDamping)) return safe_on_sides(m, norm, rhs, kappa, t);
  settle(m, rhs, high, t);
  return high;
}

// The kappa that the law asks for, and the answer for it in the box.
inline double damping_on_sides(Rows<0> m, const LawSettings& law, const double* rhs, Sides& t) {
  settle(m, rhs, 0.0, t);
  remember_sides(t);
  const double size = relative_size(law.norm, t);
  if (size <= 1.0 + kLimitSlack) return 0.0;
  return law.damping == DampingKind::EXACT ? exact_on_sides(m, law.norm, rhs, size, t)
                                           : closed_form_on_sides(m, law.norm, rhs, t);
}

// From a first answer in w.z, whose joints do not all move to the sides that it was asked on, to the one that agrees
// with its own sides: rates, damping, and the system of the joints that move.
inline STILLREACH_NOINLINE void settle_sides(Rows<0> m, const LawSettings& law, const Problem& p, System& s,
                                             Workspace& w, Answer& out) {
  double rhs[kStride];
  Problem plain = p;
  plain.reference = nullptr;
  Sides t{p, w, make_box(m, law, plain, s, out.rates, w, rhs), {}, reference_extent(p), false};
  Box& b = t.box;
  measure_columns(m, s, w);
  choose_sides(t);
  double kappa = law.damping == DampingKind::NUMBER ? law.kappa / s.unit_a / s.unit_a : 0.0;
  if (!(kappa > 0.0)) {
    (void)solve_unbounded(m, rhs, b, t.in);
    if (t.in.rank < (s.k < m() ? s.k : m())) m.value = reduce_rows(m, t.in.spectrum, w.columns, b, rhs);
  }
  for (int j = 0; j < s.k; ++j) b.state[j] = 0;
  if (law.damping == DampingKind::NUMBER)
    settle(m, rhs, kappa, t);
  else
    kappa = damping_on_sides(m, law, rhs, t);
  for (int j = 0; j < s.k; ++j) {
    const int i = w.joint[j];
    w.held[i] = b.state[j] != 0;
    out.rates[i] = w.held[i] ? clamp(0.0, p.lower[i], p.upper[i]) : w.scale[j] * b.z[j];
  }
  out.status = t.capped ? ITERATION_LIMIT : OK;
  out.damping = law.damping == DampingKind::NUMBER ? law.kappa : kappa * s.unit_a * s.unit_a;
  out.iterations += b.iterations;
  find_working_joints(p, w.held, w, s.k, out.rates);
  s = assemble(Rows<0>{p.m}, p, out.rates, w.held, s.k, w.extent, w);
  if (s.k == 0) return;
  solve_inner(Rows<0>{p.m}, w.columns, nullptr, s.k, s.rhs, 0.0, law.rank_tolerance, w.work, w.target, t.in);
  if (t.in.rank < full_rank(p, s.k)) out.status |= SINGULAR;
}

STILLREACH_END
