// LeastError: inside the bounds the least of sum_g Y_g |task error of part g| + |rates - reference|^2 / 2
// (price_search.hpp), or bare the least weighted task error, then the rates nearest to the reference.
#pragma once

#include "stillreach/bounded/price_search.hpp"
#include "stillreach/laws/pseudoinverse.hpp"

STILLREACH_BEGIN

constexpr int kCeilingSteps = 20;            // most prices that are tried for a ceiling,
constexpr double kCeilingTolerance = 1e-12;  // and the relative error that it is met to
constexpr double kLeftOut = 100.0;           // by this factor what is kept exceeds what the rank tolerance leaves out

// Under a full joint weight W fixed joints that are off their reference pull at the others: nearest to the reference is
// then nearest to reference - W_ww^-1 W_wf (rates_f - reference_f).
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
      w.target[j] -= p.metric.joints[std::ptrdiff_t{i} * p.n + f] * off;
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
inline Box make_box(Rows<M> m, const LawSettings& law, const Problem& p, System& s, const double* rates, Workspace& w,
                    double* rhs) {
  for (int r = 0; r < kStride; ++r) rhs[r] = s.rhs[r];
  for (int j = 0; j < s.k; ++j) {
    w.offset[j] = p.reference ? p.reference[w.joint[j]] / w.scale[j] : 0.0;
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
  b.k = s.k;
  b.columns = w.columns;
  b.length = w.length;
  b.lower = w.lower;
  b.upper = w.upper;
  b.kappa = 0.0;
  b.threshold = law.rank_tolerance;
  b.weight = s.full ? w.weight : nullptr;
  b.whitened = w.whitened;
  b.triangle = w.triangle;
  b.z = w.z;
  b.state = w.state;
  b.target = w.target;
  b.work = w.work;
  b.index = w.index;
  b.releases = w.releases;
  b.dependent = b.whole = 0.0;
  b.plain = law.kind == LawKind::LEAST_ERROR && law.parts > 0 ? kPricedCondition : kPlainCondition;
  b.safe = kTwiceCondition;
  b.iterations = 0;
  b.capped = b.doubtful = false;
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
  const double sigma = in.way == InnerWay::SPECTRAL ? in.spectrum.sigma[0] : square_root(in.factor.trace);
  b.threshold = -b.threshold * sigma;
  b.dependent = kDependent * sigma;
  bool all = true;
  for (int j = 0; j < b.k; ++j) all &= b.target[j] <= b.upper[j] && b.target[j] >= b.lower[j];
  return all;
}

// Where the rank is short: columns and right-hand side by their components along the left singular vectors that count.
// What is left out does not change with the rates, and what is left has full rank for every set of free variables that
// spans it. Returns how many rows are left.
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

// From scaled rates relative to the reference to rates inside the bounds; those at a bound get it exactly.
inline void write_rates(const Problem& p, const Box& b, const Workspace& w, double* rates) {
  for (int j = 0; j < b.k; ++j) {
    const int i = w.joint[j];
    const double rate = w.scale[j] * (b.z[j] + w.offset[j]);
    const double bound = b.state[j] > 0 ? p.upper[i] : p.lower[i];
    rates[i] =
        b.state[j] != 0 && is_finite(bound) ? bound : clamp(is_finite(rate) ? rate : 0.0, p.lower[i], p.upper[i]);
  }
}

// Working joints and columns; false where there is nothing to solve, the answer standing already.
template <int M>
inline bool prepare(Rows<M> m, const Problem& p, Workspace& w, Answer& out, System& s) {
  int k;
  out.status = OK;
  out.damping = 0.0;
  out.scale = 1.0;
  out.iterations = 0;
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
inline void least_error_in_box(Rows<M> m, const double* rhs, bool solved, const std::int8_t* active, const Workspace& w,
                               Box& b, Inner& in) {
  const bool warm = warm_states(w, b.k, active, b.state);
  solve_box(m, rhs, b, in, solved && !warm && b.kappa == 0.0);
  if (b.capped && warm) {  // a start from elsewhere can cost more steps than there are
    for (int j = 0; j < b.k; ++j) b.state[j] = 0;
    solve_box(m, rhs, b, in, false);
  }
  if (b.doubtful && b.kappa == 0.0) settle_box(m, rhs, b, in);
}

// The bare optimum; `in` and b.target hold the pseudoinverse, which leaves the bounds.
template <int M>
inline void bare_optimum(Rows<M> m, const System& s, double* rhs, Workspace& w, Box& b, Inner& in, Answer& out) {
  measure_columns(m, s, w);
  if (out.status & SINGULAR) {
    const Rows<0> rank{reduce_rows(m, in.spectrum, w.columns, b, rhs)};
    least_error_in_box(rank, rhs, false, out.active, w, b, in);
  } else {
    least_error_in_box(m, rhs, true, out.active, w, b, in);
  }
}

// The prices in the units of the scaled columns. Where those are extreme, all that is in units of the rates is
// multiplied by a power of two, and of a twist far beyond what the box can do only the direction counts.
template <int M>
inline Priced make_priced(Rows<M> m, const LawSettings& law, const Problem& p, System& s, double* rhs, Workspace& w) {
  Priced d;
  d.parts = law.parts;
  d.part = law.part;
  const double typical = p.typical < 0.0 ? typical_rate(p.n, p.lower, p.upper, p.metric) : p.typical;
  double unit = s.unit_a * s.unit_a / s.unit_b, most = 0.0;
  for (int g = 0; g < d.parts; ++g) most = larger(most, law.price[g] * typical);
  if (most > 0.0 && !(most * unit > 1e-30 && most * unit < 1e30)) {
    const double factor = 1.0 / power_of_two_near(clamp(most * unit, 1e-300, 1e300));
    double size = 0.0;
    for (int r = 0; r < m(); ++r) {
      rhs[r] *= factor;
      size = larger(size, magnitude(rhs[r]));
    }
    for (int r = 0; r < m() && size > 1e60; ++r) rhs[r] *= 1.0 / power_of_two_near(size * 1e-60);
    for (int j = 0; j < s.k; ++j) {
      w.lower[j] *= factor;
      w.upper[j] *= factor;
      w.offset[j] *= factor;
      w.scale[j] /= factor;
    }
    s.unit_b /= factor;
    unit *= factor;
  }
  for (int g = 0; g < d.parts; ++g) {
    d.most[g] = law.price[g] * typical * unit;
    d.kappa[g] = 0.0;
  }
  return d;
}

// Where the search for the multiplier starts: a tick ago, or at 0.
template <int M>
inline void start_price(Rows<M> m, const LawSettings& law, const System& s, const Multiplier* last, Priced& d) {
  const double unit = s.unit_a * s.unit_a / s.unit_b;
  const bool warm = last && last->known;
  for (int r = 0; r < kStride; ++r) d.u[r] = warm && r < m() ? last->u[r] * unit : 0.0;
  for (int g = 0; g < d.parts; ++g) d.kappa[g] = warm ? last->kappa[g] / (s.unit_a * s.unit_a) : 0.0;
  if (warm && law.capped >= 0) d.most[law.capped] *= clamp(last->raised, 1.0, law.beyond / law.price[law.capped]);
  if (warm) afford(m, d, d.u);
}

template <int M>
inline void keep_multiplier(Rows<M> m, const System& s, const Priced& d, const double* u, double raised,
                            Multiplier* to) {
  if (!to) return;
  const double unit = s.unit_b / (s.unit_a * s.unit_a);
  for (int r = 0; r < kRows; ++r) to->u[r] = r < m() ? u[r] * unit : 0.0;
  for (int g = 0; g < kParts; ++g) to->kappa[g] = g < d.parts ? d.kappa[g] * s.unit_a * s.unit_a : 0.0;
  to->raised = raised;
  to->known = 1;
}

// The largest damping whose error is more than rounding, or 0.
template <int M>
inline double damping_that_counts(Rows<M> m, const double* rhs, const Box& b, const Priced& d) {
  double size = size_of(m, rhs), kappa = 0.0;
  for (int j = 0; j < b.k; ++j) size = larger(size, magnitude(b.z[j]) * size_of(m, b.columns + j * kStride));
  for (int g = 0; g < d.parts; ++g)
    if (d.kappa[g] * d.most[g] > kRounding * size) kappa = larger(kappa, d.kappa[g]);
  return kappa;
}

// The search from d.u, and from 0 where that does not settle.
template <int M>
inline void search_from(Rows<M> m, const double* rhs, bool known, const double* first, Box& b, Workspace& w,
                        Priced& d) {
  const bool elsewhere = first || size_of(m, d.u) > 0.0;
  search_price(m, rhs, known, first, b, w, d);
  if (!b.capped || !elsewhere) return;
  for (int r = 0; r < kStride; ++r) d.u[r] = 0.0;
  for (int g = 0; g < d.parts; ++g) d.kappa[g] = 0.0;
  search_price(m, rhs, false, nullptr, b, w, d);
}

// law.ceiling times the typical rate, in the units of the scaled right-hand side.
inline double ceiling_of(const LawSettings& law, const System& s, double most) {
  return law.ceiling * (most / law.price[law.capped]) / (s.unit_a * s.unit_a);
}

// An error of the capped part beyond its ceiling: its price rises until the ceiling holds, at most to `high`. The error
// falls as the price rises, and is continuous in it: Newton's method in a bracket, which is divided where steps do not
// get smaller, and regula falsi (Illinois) where the slope is not known. The search has been made with the present
// price.
template <int M>
inline void keep_ceiling(Rows<M> m, const LawSettings& law, const double* rhs, double ceiling, double low, double high,
                         Box& b, Workspace& w, Priced& d) {
  const int g = law.capped;
  double below = 0.0, above = infinity();  // prices that are too low, and too high,
  double over = 0.0, under = 0.0;          // by so much of an error
  double last = infinity();                // step of the price
  int side = 0;
  for (int step = 0; !b.capped; ++step) {
    double e[kStride], own[kRows];
    residual_of(b.columns, nullptr, b.k, rhs, b.z, e);
    only_part(m, d, g, e, own);
    const double price = d.most[g], excess = size_of(m, own) - ceiling;
    if (magnitude(excess) <= kCeilingTolerance * ceiling || (excess > 0.0 ? price >= high : price <= low)) return;
    b.capped = step == kCeilingSteps;
    if (excess > 0.0) {
      under *= side > 0 ? 0.5 : 1.0;
      below = price;
      over = excess;
      side = 1;
    } else {
      over *= side < 0 ? 0.5 : 1.0;
      above = price;
      under = excess;
      side = -1;
    }
    const bool between = below > 0.0 && above < infinity();
    const double slope = excess > -0.5 * ceiling && gives_way(d, g) ? error_slope(m, g, b, d) : 0.0;
    double next = slope < 0.0    ? price - excess / slope
                  : between      ? above - under * ((above - below) / (under - over))
                  : excess > 0.0 ? high
                                 : low;
    next = clamp(next, low, high);
    if (!(next > below && next < above) || (slope < 0.0 && between && magnitude(next - price) > 0.5 * last))
      next = below > 0.0 ? square_root(below) * square_root(smaller(above, high)) : low;
    if (b.capped || next == price) return;
    last = magnitude(next - price);
    d.most[g] = next;
    afford(m, d, d.u);
    search_from(m, rhs, magnitude(next - price) < 0.1 * price, nullptr, b, w, d);
  }
}

// The ordinary search of one price, in as many rows as the compiler knows. False: that is not enough.
template <int M>
inline bool search_one_price(Rows<M>, const double* rhs, const Inner& in, bool warm, Box& b, Priced& d) {
  if constexpr (M == 0) {
    return false;
  } else {
    if (d.parts != 1 || b.weight || in.way != InnerWay::WIDE) return false;
    double* const more = b.work;
    Variables<M> v{b.k,        b.columns, b.lower,        b.upper,        b.target, more,
                   more + b.k, b.z,       more + 2 * b.k, more + 3 * b.k, b.index};
    OnePrice<M, Variables<M>> search(v, rhs, d.most[0], in.factor.trace);
    search.begin_at(warm ? d.u : in.dual);
    search.kappa = warm ? d.kappa[0] : 0.0;
    const bool found = search.search(true);
    b.iterations += static_cast<int>(search.iterations);
    if (!found) return false;
    for (int i = 0; i < b.k; ++i) b.state[i] = static_cast<std::int8_t>(v.side[i]);
    for (int r = 0; r < M; ++r) d.u[r] = search.u[r];
    d.kappa[0] = search.damping();
    afford(Rows<M>{M}, d, d.u);
    return true;
  }
}

template <int M>
inline void least_error(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  System s;
  if (!prepare(m, p, w, out, s)) {
    if (out.multiplier) *out.multiplier = {};
    return;
  }
  double rhs[kStride];
  Box b = make_box(m, law, p, s, out.rates, w, rhs);
  Priced d;
  if (law.parts > 0) d = make_priced(m, law, p, s, rhs, w);
  Inner in;
  const bool inside_all = solve_unbounded(m, rhs, b, in);
  if (in.rank < (s.k < m() ? s.k : m())) out.status |= SINGULAR;
  const bool plain =
      law.parts == 0 || (size_of(m, in.residual) <= kRounding * size_of(m, rhs) && affordable(m, d, in.dual));
  if (inside_all && plain) {
    for (int j = 0; j < s.k; ++j) b.z[j] = b.target[j];
    if (law.parts > 0) keep_multiplier(m, s, d, in.dual, 1.0, out.multiplier);
  } else if (law.parts == 0) {
    bare_optimum(m, s, rhs, w, b, in, out);
  } else {
    const bool known = out.multiplier && out.multiplier->known;
    const double own = law.capped >= 0 ? d.most[law.capped] : 1.0;
    double kappa;
    start_price(m, law, s, out.multiplier, d);
    if (law.capped < 0 && search_one_price(m, rhs, in, known, b, d)) {
      kappa = d.kappa[0];
    } else {
      search_from(m, rhs, known, !known && in.way == InnerWay::WIDE && affordable(m, d, in.dual) ? in.dual : nullptr, b,
                  w, d);
      if (law.capped >= 0)
        keep_ceiling(m, law, rhs, ceiling_of(law, s, own), own, own * (law.beyond / law.price[law.capped]), b, w, d);
      kappa = damping_that_counts(m, rhs, b, d);
    }
    out.damping = kappa > 0.0 ? kappa * s.unit_a * s.unit_a : 0.0;
    keep_multiplier(m, s, d, d.u, law.capped >= 0 ? d.most[law.capped] / own : 1.0, out.multiplier);
    if (out.damping > 0.0) out.status |= DAMPED;
  }
  if (b.capped) out.status |= ITERATION_LIMIT;
  out.iterations = b.iterations;
  write_rates(p, b, w, out.rates);
  report(m, p, out);
}

STILLREACH_END
