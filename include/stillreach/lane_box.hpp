// The bounded search of box.hpp for four problems at once, from all variables free, where neither a singularity nor
// rounding has a say; lanes that meet either are given up, for the single tick's code to answer.
#pragma once

#include "box.hpp"
#include "lane_solve.hpp"

STILLREACH_BEGIN

template <int M>
struct LaneBox {
  int k;
  const Pack* const* column;  // k, zeros in lanes where the joint does not work
  const Mask* works;          // k
  const Pack* length;         // k
  const Pack* lower;          // k, of z
  const Pack* upper;          // k
  Pack kappa;
  Pack* z;                    // k
  Pack* target;               // k
  Pack* trial;                // k
  Pack* releases;             // k
  Pack* side;                 // k: -1 at lower, 1 at upper, 0 free
  Pack* masked;               // k M: columns of the free variables
  Pack* narrow;               // (M - 1) M: those columns one after the other, where they are fewer than rows
  const Pack** masked_column; // k
  Pack iterations;
  Pack residual[M], dual[M], condition;  // of the last solve
};

struct LaneObjective {
  Pack error, norm;
};

template <int M>
inline LaneObjective objective(const LaneBox<M>& b, const Pack* rhs, const Pack* z) {
  Pack e[M];
  residual_of<M>(b.column, b.k, rhs, z, e);
  LaneObjective o{dot<M>(e, e), zero_pack()};
  for (int i = 0; i < b.k; ++i) o.norm = madd(z[i], z[i], o.norm);
  const Mask damped = b.kappa > zero_pack();
  o.error = select(damped, madd(b.kappa, o.norm, o.error), o.error), o.norm = select(damped, zero_pack(), o.norm);
  return o;
}

STILLREACH_INLINE Mask lower_than(const LaneObjective& a, const LaneObjective& b, Pack noise) {
  const Pack slack = broadcast(kDescent) * b.error + noise;
  return (a.error < b.error - slack) | ((a.error <= b.error + slack) & (a.norm < b.norm * broadcast(1.0 - kDescent)));
}

STILLREACH_INLINE LaneObjective select(Mask where, const LaneObjective& a, const LaneObjective& b) {
  return {select(where, a.error, b.error), select(where, a.norm, b.norm)};
}

// L D L' of the Gram matrix of up to M - 1 columns; in each lane the first `count` of them are there.
template <int M>
struct NarrowFactor {
  static constexpr int S = M - 1;
  Pack lower[S][S], inverse[S][S], pivot_inverse[S], condition;
};

template <int M>
inline void factor_narrow(const Pack* columns, Pack count, Pack kappa, NarrowFactor<M>& f) {
  constexpr int S = M - 1;
  Pack g[S][S], w[S][S], trace = zero_pack(), inverse_trace = zero_pack();
  Mask there[S], positive = every_lane();
  for (int i = 0; i < S; ++i) {
    there[i] = broadcast(i) < count;
    for (int j = 0; j <= i; ++j) g[i][j] = dot<M>(columns + i * M, columns + j * M);
    g[i][i] = select(there[i], g[i][i] + kappa, broadcast(1.0));
  }
  for (int j = 0; j < S; ++j) {
    trace += select(there[j], g[j][j], zero_pack());
    for (int i = j; i < S; ++i) {
      Pack sum = g[i][j];
      for (int k = 0; k < j; ++k) sum = madd(-w[i][k], f.lower[j][k], sum);
      w[i][j] = sum;
    }
    positive &= w[j][j] > zero_pack();
    f.pivot_inverse[j] = broadcast(1.0) / w[j][j];
    for (int i = j + 1; i < S; ++i) f.lower[i][j] = w[i][j] * f.pivot_inverse[j];
  }
  for (int j = 0; j < S; ++j) {
    Pack sum = f.pivot_inverse[j];
    for (int i = j + 1; i < S; ++i) {
      Pack entry = -f.lower[i][j];
      for (int k = j + 1; k < i; ++k) entry = madd(-f.lower[i][k], f.inverse[k][j], entry);
      f.inverse[i][j] = entry;
      sum = madd(entry * entry, f.pivot_inverse[i], sum);
    }
    inverse_trace += select(there[j], sum, zero_pack());
  }
  const Pack condition = trace * inverse_trace;
  f.condition = select(positive & (condition < broadcast(infinity())), condition, broadcast(infinity()));
}

template <int M>
inline void solve(const NarrowFactor<M>& f, const Pack* b, Pack* x) {
  constexpr int S = M - 1;
  Pack y[S];
  for (int i = 0; i < S; ++i) {
    Pack sum = b[i];
    for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    y[i] = sum * f.pivot_inverse[i];
  }
  for (int j = 0; j < S; ++j) {
    Pack sum = y[j];
    for (int i = j + 1; i < S; ++i) sum = madd(f.inverse[i][j], y[i], sum);
    x[j] = sum;
  }
}

// rhs less what `z` (S numbers) times the columns does.
template <int M>
STILLREACH_INLINE void narrow_residual(const Pack* columns, const Pack* rhs, const Pack* z, Pack* residual) {
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) {
    Pack sum = rhs[r];
    for (int i = 0; i < M - 1; ++i) sum = madd(columns[i * M + r], -z[i], sum);
    residual[r] = sum;
  }
}

// The free variables of the lanes of `where`, fewer than rows: solve_tall() of inner.hpp. Returns the lanes it can be trusted in.
template <int M>
inline STILLREACH_NOINLINE Mask solve_narrow(LaneBox<M>& b, const Pack* rest, Mask where, Pack count) {
  constexpr int S = M - 1;
  int joint[kLanes][S], number[kLanes];
  for (int i = 0; i < S * M; ++i) b.narrow[i] = zero_pack();
  for (int l = 0; l < kLanes; ++l) {
    number[l] = 0;
    if (!where[l]) continue;
    for (int j = 0; j < b.k; ++j) {
      if (!b.works[j][l] || b.side[j][l] != 0.0) continue;
      for (int r = 0; r < M; ++r) b.narrow[number[l] * M + r][l] = b.column[j][r][l];
      joint[l][number[l]++] = j;
    }
  }
  NarrowFactor<M> f;
  factor_narrow<M>(b.narrow, count, b.kappa, f);
  Pack y[S], z[S], residual[M], dual[M];
  for (int i = 0; i < S; ++i) y[i] = dot<M>(b.narrow + i * M, rest);
  solve<M>(f, y, z);
  narrow_residual<M>(b.narrow, rest, z, residual);
  const Mask trusted = where & (f.condition <= broadcast(kRefinedCondition));
  const double limits[] = {kPlainCondition, kTwiceCondition};
  for (const double limit : limits) {
    const Mask again = trusted & (f.condition > broadcast(limit));
    if (!any(again)) break;
    for (int i = 0; i < S; ++i) y[i] = madd(-b.kappa, z[i], dot<M>(b.narrow + i * M, residual));
    solve<M>(f, y, y);
    for (int i = 0; i < S; ++i) z[i] = select(again, z[i] + y[i], z[i]);
    narrow_residual<M>(b.narrow, rest, z, residual);
  }
  const Pack zeros[M] = {};
  solve<M>(f, z, y);
  for (int i = 0; i < S; ++i) y[i] = -y[i];
  narrow_residual<M>(b.narrow, zeros, y, dual);
  const Mask damped = b.kappa > zero_pack();
  for (int r = 0; r < M; ++r) {
    b.residual[r] = select(trusted, residual[r], b.residual[r]);
    b.dual[r] = select(trusted, select(damped, residual[r] / b.kappa, dual[r]), b.dual[r]);
  }
  b.condition = select(trusted, f.condition, b.condition);
  for (int l = 0; l < kLanes; ++l)
    for (int i = 0; i < number[l]; ++i) b.target[joint[l][i]][l] = z[i][l];
  return trusted;
}

// Solves for the free variables of the lanes of `where`; returns those it can be trusted in.
template <int M>
inline Mask solve_free(LaneBox<M>& b, const Pack* rhs, Mask where) {
  const Pack zero = zero_pack();
  Pack rest[M], count = zero;
  for (int r = 0; r < M; ++r) rest[r] = rhs[r];
  for (int i = 0; i < b.k; ++i) {
    const Mask free = b.works[i] & (b.side[i] == zero);
    const Pack t = select(free, zero, -b.z[i]), *a = b.column[i];
    count += select(free, broadcast(1.0), zero);
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) {
      rest[r] = madd(a[r], t, rest[r]);
      b.masked[i * M + r] = select(free, a[r], zero);
    }
  }
  const Mask wide = where & (count >= broadcast(M)), none = where & (count == zero), narrow = where & ~wide & ~none;
  Mask trusted = none;
  if (any(wide)) {
    LaneInner<M> in;
    trusted |= wide & solve_wide<M>(b.masked_column, b.k, rest, b.kappa, b.trial, in);
    for (int i = 0; i < b.k; ++i) b.target[i] = select(wide, b.trial[i], b.target[i]);
    for (int r = 0; r < M; ++r) {
      b.residual[r] = select(wide, b.kappa * in.dual[r], b.residual[r]);
      b.dual[r] = select(wide, in.dual[r], b.dual[r]);
    }
    b.condition = select(wide, in.condition, b.condition);
  }
  if (any(narrow)) trusted |= solve_narrow<M>(b, rest, narrow, count);
  if (any(none)) {
    const Mask damped = b.kappa > zero;
    for (int r = 0; r < M; ++r) {
      b.residual[r] = select(none, rest[r], b.residual[r]);
      b.dual[r] = select(none, select(damped, rest[r] / b.kappa, zero), b.dual[r]);
    }
    b.condition = select(none, zero, b.condition);
  }
  b.iterations += select(where & ~none, broadcast(1.0), zero);
  return trusted;
}

template <int M>
STILLREACH_INLINE Mask inside(const LaneBox<M>& b, int i, Pack slack) {
  const Pack room = madd(broadcast(kInside), magnitude(b.target[i]), slack);
  return (b.target[i] <= b.upper[i] + room) & (b.target[i] >= b.lower[i] - room);
}

// advance() of box.hpp in the lanes of `where`.
template <int M>
inline void advance(LaneBox<M>& b, const Pack* rhs, Mask where, Mask first, Pack slack, Pack freed, Pack noise, LaneObjective& now) {
  const Pack zero = zero_pack(), one = broadcast(1.0);
  for (int i = 0; i < b.k; ++i)
    b.trial[i] = select(b.side[i] == zero, clamp(b.target[i], b.lower[i], b.upper[i]), b.z[i]);
  const LaneObjective there = objective<M>(b, rhs, b.trial);
  const Mask all_the_way = where & (first | lower_than(there, now, noise)), partly = where & ~all_the_way;
  Pack part = one, blocking = broadcast(-1.0);
  if (any(partly))
    for (int i = 0; i < b.k; ++i) {
      const Mask out = b.works[i] & (b.side[i] == zero) & ~inside(b, i, slack);
      const Pack move = b.target[i] - b.z[i], room = (select(move > zero, b.upper[i], b.lower[i]) - b.z[i]) / move;
      const Mask nearer = out & ((blocking < zero) | (room < part));
      part = select(nearer, larger(room, zero), part), blocking = select(nearer, broadcast(i), blocking);
    }
  for (int i = 0; i < b.k; ++i) {
    const Mask free = b.works[i] & (b.side[i] == zero), out = free & ~inside(b, i, slack);
    const Pack beyond = select(b.target[i] > b.upper[i], one, -one);
    const Mask blocked = partly & free & (blocking == broadcast(i));
    Pack z = select(all_the_way, b.trial[i], clamp(madd(part, b.target[i] - b.z[i], b.z[i]), b.lower[i], b.upper[i]));
    z = select(blocked, select(beyond > zero, b.upper[i], b.lower[i]), z);
    b.z[i] = select(where & free, z, b.z[i]);
    b.side[i] = select((all_the_way & out) | blocked, beyond, b.side[i]);
    b.releases[i] = select(blocked & (freed == broadcast(i)) & (part == zero), broadcast(kNever), b.releases[i]);
  }
  now = select(all_the_way, there, now);
  if (any(partly)) now = select(partly, objective<M>(b, rhs, b.z), now);
}

// choose_release() of box.hpp: the number of the variable to free, or -1. barred: lanes where one was wanted that may not
// move again.
template <int M>
inline Pack choose_release(const LaneBox<M>& b, Pack size, Mask& barred) {
  const Pack zero = zero_pack();
  Pack along = zero, longest = zero;
  for (int i = 0; i < b.k; ++i) {
    const Mask free = b.works[i] & (b.side[i] == zero);
    size = larger(size, select(b.works[i], magnitude(b.z[i]) * b.length[i], zero));
    along = larger(along, select(free, magnitude(dot<M>(b.column[i], b.residual)), zero));
    longest = larger(longest, select(free, b.length[i], zero));
  }
  const Pack floor = larger(broadcast(1e-16) * size, select(longest > zero, broadcast(4.0) * along / longest, zero));
  const Mask settled = (b.kappa > zero) | (dot<M>(b.residual, b.residual) <= broadcast(kRounding * kRounding) * size * size);
  const Pack dual_size = square_root(dot<M>(b.dual, b.dual));
  Pack first = broadcast(-1.0), second = broadcast(-1.0), first_gain = zero, second_gain = zero;
  barred = no_lane();
  for (int i = 0; i < b.k; ++i) {
    const Mask fixed = b.works[i] & (b.side[i] != zero), spent = b.releases[i] >= broadcast(kMaxReleases);
    if (!any(fixed)) continue;
    const Pack *a = b.column[i], side = b.side[i], length = b.length[i], number = broadcast(i);
    const Pack primary = select(settled, zero, -side * dot<M>(a, b.residual));
    const Mask counts = fixed & (magnitude(primary) > length * floor), pays = counts & (primary >= zero);
    barred |= pays & spent;
    const Mask better = pays & ~spent & (primary > first_gain * length);
    first = select(better, number, first), first_gain = select(better, primary / length, first_gain);
    const Pack z = b.z[i], secondary = side * (z - dot<M>(a, b.dual));
    const Mask nearer = fixed & ~counts & (secondary > broadcast(1e-12) * (magnitude(z) + length * dual_size));
    barred |= nearer & spent;
    const Mask nearest = nearer & ~spent & (secondary > second_gain);
    second = select(nearest, number, second), second_gain = select(nearest, secondary, second_gain);
  }
  return select(first >= zero, first, second);
}

// From all variables free, in the lanes of `live`; those of `solved` hold the answer to that already, in target, residual
// and dual. Returns the lanes that found their optimum.
template <int M>
inline Mask solve_box(LaneBox<M>& b, const Pack* rhs, Mask live, Mask solved) {
  const Pack zero = zero_pack(), size = square_root(dot<M>(rhs, rhs));
  Pack working = zero, freed = broadcast(-1.0);
  for (int i = 0; i < b.k; ++i) {
    b.releases[i] = b.side[i] = zero, b.z[i] = clamp(zero, b.lower[i], b.upper[i]), b.masked_column[i] = b.masked + i * M;
    working += select(b.works[i], broadcast(1.0), zero);
  }
  const Pack noise = broadcast(1e-28) * size * size, most = madd(broadcast(kMaxReleases + 1), working, broadcast(2.0));
  LaneObjective now{broadcast(infinity()), broadcast(infinity())};
  Mask first = every_lane(), found = no_lane();
  for (int step = 0; any(live); ++step) {
    live &= broadcast(step) < most;
    const Mask open = step == 0 ? live & ~solved : live;
    if (any(open)) live &= solve_free<M>(b, rhs, open) | ~open;
    Pack slack = zero;
    for (int i = 0; i < b.k; ++i)
      slack = larger(slack, select(b.works[i] & (b.side[i] == zero), broadcast(1e-13) * magnitude(b.target[i]), zero));
    Mask all_inside = live;
    for (int i = 0; i < b.k; ++i) all_inside &= inside(b, i, slack) | (b.side[i] != zero) | ~b.works[i];
    const Mask outside = live & ~all_inside;
    if (any(outside)) {
      advance<M>(b, rhs, outside, first, slack, freed, noise, now);
      first &= ~outside, freed = select(outside, broadcast(-1.0), freed);
    }
    if (!any(all_inside)) continue;
    for (int i = 0; i < b.k; ++i)
      b.z[i] = select(all_inside & (b.side[i] == zero), clamp(b.target[i], b.lower[i], b.upper[i]), b.z[i]);
    Mask barred;
    const Pack release = choose_release<M>(b, size, barred);
    live &= ~(all_inside & barred);
    const Mask releasing = live & all_inside & (release >= zero), done = live & all_inside & ~releasing;
    // An undamped answer from a nearly singular set of columns gets a second, careful stage in the single tick.
    found |= done & ((b.kappa > zero) | (b.condition <= broadcast(kTwiceCondition)));
    live &= ~done;
    if (!any(releasing)) continue;
    now = select(releasing, objective<M>(b, rhs, b.z), now), first &= ~releasing;
    freed = select(releasing, release, freed);
    for (int i = 0; i < b.k; ++i) {
      const Mask here = releasing & (release == broadcast(i));
      b.releases[i] = select(here, b.releases[i] + broadcast(1.0), b.releases[i]), b.side[i] = select(here, zero, b.side[i]);
    }
  }
  return found;
}

STILLREACH_END
