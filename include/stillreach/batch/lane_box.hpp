// The bounded search of box.hpp for all lanes at once, from all variables free, where neither a singularity nor
// rounding has a say; lanes that meet either are given up, for the single tick's code to answer.
#pragma once

#include "stillreach/batch/lane_solve.hpp"
#include "stillreach/bounded/box.hpp"

STILLREACH_BEGIN

template <int M>
struct LaneBox {
  int k;
  const Wide* const* column;   // k, zeros in lanes where the joint does not work
  const Lanes* works;          // k
  const Wide* length;          // k
  const Wide* lower;           // k, of z
  const Wide* upper;           // k
  Wide* z;                     // k
  Wide* target;                // k
  Wide* trial;                 // k
  Wide* releases;              // k
  Wide* side;                  // k: -1 at lower, 1 at upper, 0 free
  Lanes* outside;              // k: lanes where it is free, and its target beyond its bounds
  Wide* masked;                // k M: columns of the free variables
  Wide* narrow;                // (M - 1) M: those columns one after the other, where they are fewer than rows
  const Wide** masked_column;  // k
  Wide iterations;
  Wide residual[kRows], dual[kRows], condition;  // of the last solve
};

using LaneObjective = ObjectiveOf<Wide>;

template <int M>
inline LaneObjective objective(const LaneBox<M>& b, const Wide* rhs, const Wide* z) {
  Wide e[kRows];
  residual_of<M>(b.column, b.k, rhs, z, e);
  LaneObjective o{dot<M>(e, e), wide(0.0)};
  for (int i = 0; i < b.k; ++i) o.norm = madd(z[i], z[i], o.norm);
  return o;
}

STILLREACH_INLINE LaneObjective select(Lanes where, const LaneObjective& a, const LaneObjective& b) {
  return {select(where, a.error, b.error), select(where, a.norm, b.norm)};
}

// L D L' of the Gram matrix of up to M - 1 columns; in each lane the first `count` of them are there.
template <int M>
struct NarrowFactor {
  static constexpr int S = M - 1;
  Wide lower[kRows - 1][kRows - 1], inverse[kRows - 1][kRows - 1], pivot_inverse[kRows - 1], condition;
};

template <int M>
inline void factor_narrow(const Wide* columns, Wide count, NarrowFactor<M>& f) {
  constexpr int S = M - 1;
  Wide g[kRows - 1][kRows - 1], w[kRows - 1][kRows - 1], trace = wide(0.0), inverse_trace = wide(0.0);
  Lanes there[kRows - 1], positive = every_lane();
  for (int i = 0; i < S; ++i) {
    there[i] = wide(i) < count;
    for (int j = 0; j <= i; ++j) g[i][j] = dot<M>(columns + i * M, columns + j * M);
    g[i][i] = select(there[i], g[i][i], wide(1.0));
  }
  for (int j = 0; j < S; ++j) {
    trace += select(there[j], g[j][j], wide(0.0));
    for (int i = j; i < S; ++i) {
      Wide sum = g[i][j];
      for (int k = 0; k < j; ++k) sum = madd(-w[i][k], f.lower[j][k], sum);
      w[i][j] = sum;
    }
    positive &= w[j][j] > wide(0.0);
    f.pivot_inverse[j] = wide(1.0) / w[j][j];
    for (int i = j + 1; i < S; ++i) f.lower[i][j] = w[i][j] * f.pivot_inverse[j];
  }
  for (int j = 0; j < S; ++j) {
    Wide sum = f.pivot_inverse[j];
    for (int i = j + 1; i < S; ++i) {
      Wide entry = -f.lower[i][j];
      for (int k = j + 1; k < i; ++k) entry = madd(-f.lower[i][k], f.inverse[k][j], entry);
      f.inverse[i][j] = entry;
      sum = madd(entry * entry, f.pivot_inverse[i], sum);
    }
    inverse_trace += select(there[j], sum, wide(0.0));
  }
  const Wide condition = trace * inverse_trace;
  f.condition = select(positive & (condition < wide(infinity())), condition, wide(infinity()));
}

template <int M>
inline void solve(const NarrowFactor<M>& f, const Wide* b, Wide* x) {
  constexpr int S = M - 1;
  Wide y[kRows - 1];
  for (int i = 0; i < S; ++i) {
    Wide sum = b[i];
    for (int k = 0; k < i; ++k) sum = madd(f.inverse[i][k], b[k], sum);
    y[i] = sum * f.pivot_inverse[i];
  }
  for (int j = 0; j < S; ++j) {
    Wide sum = y[j];
    for (int i = j + 1; i < S; ++i) sum = madd(f.inverse[i][j], y[i], sum);
    x[j] = sum;
  }
}

// rhs less what `z` (S numbers) times the columns does.
template <int M>
STILLREACH_INLINE void narrow_residual(const Wide* columns, const Wide* rhs, const Wide* z, Wide* residual) {
  STILLREACH_UNROLL for (int r = 0; r < M; ++r) {
    Wide sum = rhs[r];
    for (int i = 0; i < M - 1; ++i) sum = madd(columns[i * M + r], -z[i], sum);
    residual[r] = sum;
  }
}

// The free variables of the lanes of `where`, fewer than rows: solve_tall() of inner.hpp. Returns the lanes it can be
// trusted in.
template <int M>
inline STILLREACH_NOINLINE Lanes solve_narrow(LaneBox<M>& b, const Wide* rest, Lanes where, Wide count) {
  constexpr int S = M - 1;
  int joint[kLanes][kRows - 1], number[kLanes];
  STILLREACH_UNROLL for (int i = 0; i < S * M; ++i) b.narrow[i] = wide(0.0);
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
  factor_narrow<M>(b.narrow, count, f);
  Wide y[kRows - 1], z[kRows - 1], residual[kRows], dual[kRows];
  for (int i = 0; i < S; ++i) y[i] = dot<M>(b.narrow + i * M, rest);
  solve<M>(f, y, z);
  narrow_residual<M>(b.narrow, rest, z, residual);
  const Lanes trusted = where & (f.condition <= wide(kRefinedCondition));
  const double limits[] = {kPlainCondition, kTwiceCondition};
  for (const double limit : limits) {
    const Lanes again = trusted & (f.condition > wide(limit));
    if (!any(again)) break;
    for (int i = 0; i < S; ++i) y[i] = dot<M>(b.narrow + i * M, residual);
    solve<M>(f, y, y);
    for (int i = 0; i < S; ++i) z[i] = select(again, z[i] + y[i], z[i]);
    narrow_residual<M>(b.narrow, rest, z, residual);
  }
  const Wide zeros[kRows] = {};
  solve<M>(f, z, y);
  for (int i = 0; i < S; ++i) y[i] = -y[i];
  narrow_residual<M>(b.narrow, zeros, y, dual);
  for (int r = 0; r < M; ++r) {
    b.residual[r] = select(trusted, residual[r], b.residual[r]);
    b.dual[r] = select(trusted, dual[r], b.dual[r]);
  }
  b.condition = select(trusted, f.condition, b.condition);
  for (int l = 0; l < kLanes; ++l)
    for (int i = 0; i < number[l]; ++i) b.target[joint[l][i]][l] = z[i][l];
  return trusted;
}

// Solves for the free variables of the lanes of `where`; returns those it can be trusted in.
template <int M>
inline Lanes solve_free(LaneBox<M>& b, const Wide* rhs, Lanes where) {
  const Wide zero = wide(0.0);
  Wide rest[kRows], count = zero;
  for (int r = 0; r < M; ++r) rest[r] = rhs[r];
  for (int i = 0; i < b.k; ++i) {
    const Lanes free = b.works[i] & (b.side[i] == zero);
    const Wide t = select(free, zero, -b.z[i]), *a = b.column[i];
    count += select(free, wide(1.0), zero);
    STILLREACH_UNROLL for (int r = 0; r < M; ++r) {
      rest[r] = madd(a[r], t, rest[r]);
      b.masked[i * M + r] = select(free, a[r], zero);
    }
  }
  const Lanes enough = where & (count >= wide(M)), none = where & (count == zero), narrow = where & ~enough & ~none;
  Lanes trusted = none;
  if (any(enough)) {
    LaneInner<M> in;
    trusted |= enough & solve_wide<M>(b.masked_column, b.k, rest, zero, b.trial, in);
    for (int i = 0; i < b.k; ++i) b.target[i] = select(enough, b.trial[i], b.target[i]);
    for (int r = 0; r < M; ++r) {
      b.residual[r] = select(enough, zero, b.residual[r]);
      b.dual[r] = select(enough, in.dual[r], b.dual[r]);
    }
    b.condition = select(enough, in.condition, b.condition);
  }
  if (any(narrow)) trusted |= solve_narrow<M>(b, rest, narrow, count);
  if (any(none)) {
    for (int r = 0; r < M; ++r) {
      b.residual[r] = select(none, rest[r], b.residual[r]);
      b.dual[r] = select(none, zero, b.dual[r]);
    }
    b.condition = select(none, zero, b.condition);
  }
  b.iterations += select(where & ~none, wide(1.0), zero);
  return trusted;
}

// Where each free variable's target is inside its bounds; the others are in b.outside.
template <int M>
inline Lanes all_inside_of(LaneBox<M>& b) {
  const Wide zero = wide(0.0);
  Wide slack = zero;
  for (int i = 0; i < b.k; ++i)
    slack = larger(slack, select(b.works[i] & (b.side[i] == zero), wide(1e-13) * magnitude(b.target[i]), zero));
  Lanes some = no_lane();
  for (int i = 0; i < b.k; ++i) {
    const Wide room = madd(wide(kInside), magnitude(b.target[i]), slack);
    const Lanes inside = (b.target[i] <= b.upper[i] + room) & (b.target[i] >= b.lower[i] - room);
    b.outside[i] = b.works[i] & (b.side[i] == zero) & ~inside;
    some |= b.outside[i];
  }
  return ~some;
}

// advance() of box.hpp in the lanes of `where`.
template <int M>
inline void advance(LaneBox<M>& b, const Wide* rhs, Lanes where, Lanes first, Wide freed, Wide noise,
                    LaneObjective& now) {
  const Wide zero = wide(0.0), one = wide(1.0);
  for (int i = 0; i < b.k; ++i)
    b.trial[i] = select(b.side[i] == zero, clamp(b.target[i], b.lower[i], b.upper[i]), b.z[i]);
  const LaneObjective there = objective<M>(b, rhs, b.trial);
  const Lanes all_the_way = where & (first | lower_than(there, now, noise)), partly = where & ~all_the_way;
  now = select(all_the_way, there, now);
  if (!any(partly)) {
    for (int i = 0; i < b.k; ++i) {
      b.z[i] = select(where & b.works[i], b.trial[i], b.z[i]);
      b.side[i] = select(where & b.outside[i], select(b.target[i] > b.upper[i], one, -one), b.side[i]);
    }
    return;
  }
  Wide part = one, blocking = wide(-1.0);
  for (int i = 0; i < b.k; ++i) {
    const Wide move = b.target[i] - b.z[i], room = (select(move > zero, b.upper[i], b.lower[i]) - b.z[i]) / move;
    const Lanes nearer = b.outside[i] & ((blocking < zero) | (room < part));
    part = select(nearer, larger(room, zero), part);
    blocking = select(nearer, wide(i), blocking);
  }
  for (int i = 0; i < b.k; ++i) {
    const Lanes free = b.works[i] & (b.side[i] == zero), out = b.outside[i];
    const Wide beyond = select(b.target[i] > b.upper[i], one, -one);
    const Lanes blocked = partly & free & (blocking == wide(i));
    Wide z = select(all_the_way, b.trial[i], clamp(madd(part, b.target[i] - b.z[i], b.z[i]), b.lower[i], b.upper[i]));
    z = select(blocked, select(beyond > zero, b.upper[i], b.lower[i]), z);
    b.z[i] = select(where & free, z, b.z[i]);
    b.side[i] = select((all_the_way & out) | blocked, beyond, b.side[i]);
    b.releases[i] = select(blocked & (freed == wide(i)) & (part == zero), wide(kNever), b.releases[i]);
  }
  now = select(partly, objective<M>(b, rhs, b.z), now);
}

// choose_release() of box.hpp in the lanes of `where`: the number of the variable to free, or -1. barred: lanes where
// one was wanted that may not move again. Overwrites b.trial.
template <int M>
inline Wide choose_release(const LaneBox<M>& b, Wide size, Lanes where, Lanes& barred) {
  const Wide zero = wide(0.0);
  Wide along = zero, longest = zero;
  for (int i = 0; i < b.k; ++i) {
    const Lanes free = b.works[i] & (b.side[i] == zero);
    b.trial[i] = dot<M>(b.column[i], b.residual);
    size = larger(size, select(b.works[i], magnitude(b.z[i]) * b.length[i], zero));
    along = larger(along, select(free, magnitude(b.trial[i]), zero));
    longest = larger(longest, select(free, b.length[i], zero));
  }
  const Wide floor = larger(wide(1e-16) * size, select(longest > zero, kAlong * along / longest, zero));
  const Lanes settled = dot<M>(b.residual, b.residual) <= wide(kRounding * kRounding) * size * size;
  const Wide dual_size = square_root(dot<M>(b.dual, b.dual));
  Wide first = wide(-1.0), second = wide(-1.0), first_gain = zero, second_gain = zero;
  barred = no_lane();
  for (int i = 0; i < b.k; ++i) {
    const Lanes fixed = where & b.works[i] & (b.side[i] != zero), spent = b.releases[i] >= wide(kMaxReleases);
    if (!any(fixed)) continue;
    const Wide side = b.side[i], length = b.length[i], number = wide(i);
    const Wide primary = select(settled, zero, -side * b.trial[i]);
    const Lanes counts = fixed & (magnitude(primary) > length * floor);
    const Lanes pays = counts & (primary >= zero), better = pays & ~spent & (primary > first_gain * length);
    barred |= pays & spent;
    first = select(better, number, first);
    first_gain = select(better, primary / length, first_gain);
    if (!any(fixed & ~counts)) continue;
    const Wide z = b.z[i], secondary = side * (z - dot<M>(b.column[i], b.dual));
    const Lanes nearer = fixed & ~counts & (secondary > wide(1e-12) * (magnitude(z) + length * dual_size));
    barred |= nearer & spent;
    const Lanes nearest = nearer & ~spent & (secondary > second_gain);
    second = select(nearest, number, second);
    second_gain = select(nearest, secondary, second_gain);
  }
  return select(first >= zero, first, second);
}

// From all variables free, in the lanes of `live`; those of `solved` hold the answer to that already, in target,
// residual and dual. Returns the lanes that found their optimum.
template <int M>
inline Lanes solve_box(LaneBox<M>& b, const Wide* rhs, Lanes live, Lanes solved) {
  const Wide zero = wide(0.0), size = square_root(dot<M>(rhs, rhs));
  Wide working = zero, freed = wide(-1.0);
  for (int i = 0; i < b.k; ++i) {
    b.releases[i] = b.side[i] = zero;
    b.z[i] = clamp(zero, b.lower[i], b.upper[i]);
    b.masked_column[i] = b.masked + i * M;
    working += select(b.works[i], wide(1.0), zero);
  }
  const Wide noise = wide(1e-28) * size * size, most = madd(wide(kMaxReleases + 1), working, wide(2.0));
  LaneObjective now{wide(infinity()), wide(infinity())};
  Lanes first = every_lane(), found = no_lane();
  for (int step = 0; any(live); ++step) {
    live &= wide(step) < most;
    const Lanes open = step == 0 ? live & ~solved : live;
    if (any(open)) live &= solve_free<M>(b, rhs, open) | ~open;
    const Lanes all_inside = live & all_inside_of(b), outside = live & ~all_inside;
    if (any(outside)) {
      advance<M>(b, rhs, outside, first, freed, noise, now);
      first &= ~outside;
      freed = select(outside, wide(-1.0), freed);
    }
    if (!any(all_inside)) continue;
    for (int i = 0; i < b.k; ++i)
      b.z[i] = select(all_inside & (b.side[i] == zero), clamp(b.target[i], b.lower[i], b.upper[i]), b.z[i]);
    Lanes barred;
    const Wide release = choose_release<M>(b, size, live & all_inside, barred);
    live &= ~(all_inside & barred);
    const Lanes releasing = live & all_inside & (release >= zero), done = live & all_inside & ~releasing;
    // An answer from a nearly singular set of columns gets a second, careful stage in the single tick.
    found |= done & (b.condition <= wide(kTwiceCondition));
    live &= ~done;
    if (!any(releasing)) continue;
    now = select(releasing, objective<M>(b, rhs, b.z), now);
    first &= ~releasing;
    freed = select(releasing, release, freed);
    for (int i = 0; i < b.k; ++i) {
      const Lanes here = releasing & (release == wide(i));
      b.releases[i] = select(here, b.releases[i] + wide(1.0), b.releases[i]);
      b.side[i] = select(here, zero, b.side[i]);
    }
  }
  return found;
}

STILLREACH_END
