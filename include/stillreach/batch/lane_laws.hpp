// The laws for all lanes at once. Each function answers the lanes that take the ordinary way through a law and says
// which; the single tick's code answers the others.
#pragma once

#include "stillreach/batch/lane_box.hpp"
#include "stillreach/batch/lane_damping.hpp"
#include "stillreach/batch/lane_price.hpp"
#include "stillreach/batch/lane_system.hpp"
#include "stillreach/laws/law.hpp"

STILLREACH_BEGIN

// The laws that solve_lanes() answers; the single tick answers all others.
STILLREACH_INLINE bool has_lanes(LawKind law) {
  return law == LawKind::PSEUDOINVERSE || law == LawKind::SINGULARITY_ROBUST || law == LawKind::LEAST_ERROR ||
         law == LawKind::KEEP_DIRECTION;
}

// Problems that lanes can answer at all.
STILLREACH_INLINE bool suits_lanes(LawKind law, int n, int m, const Metric& metric) {
  return has_lanes(law) && (m == 6 || m == 3) && n >= m && !metric.joints;
}

template <int M>
inline Lanes finish_pseudoinverse(const LaneProblem& p, const LaneSystem& s, Lanes good, LaneAnswer& out) {
  Lanes over = no_lane();
  Wide doubt = wide(0.0);
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Wide rate = s.scale[j] * s.z[j];
    over |= s.works[j] & ~((rate <= p.upper[i]) & (rate >= p.lower[i]));
    doubt += rate - rate;
    out.rates[i] = select(s.works[j], rate, out.rates[i]);
  }
  good &= doubt == wide(0.0);
  out.status |= flag(over, OVER_LIMIT);
  return good;
}

// full_rank() of singularity_robust.hpp; false also where the Gram matrix alone cannot tell.
template <int M>
inline STILLREACH_NOINLINE Lanes full_rank(const LaneSystem& s, double kappa, const LaneInner<M>& in) {
  const Lanes proven = wide(1.0) / in.factor.inverse_trace - wide(kappa) > in.factor.trace / wide(kRefinedCondition);
  if (!any(~proven)) return proven;
  LaneFactor<M> bare;
  gram<M>(s.column, s.k, wide(0.0), bare);
  return proven | (factor<M, Wide>(bare) <= wide(kRefinedCondition));
}

// deep: also the lanes that need damping chosen.
template <int M>
inline Lanes finish_singularity_robust(const LawSettings& law, const LaneProblem& p, LaneSystem& s, Lanes good,
                                       bool deep, LaneInner<M>& in, LaneAnswer& out) {
  out.damping = wide(0.0);
  if (law.damping == DampingKind::NUMBER) {
    out.damping = wide(law.kappa);
    if (law.kappa > 0.0) good &= full_rank<M>(s, law.kappa, in);
  } else {
    Wide largest = wide(0.0), square = wide(0.0);
    for (int j = 0; j < s.k; ++j) {
      const Wide u = select(s.works[j], magnitude(s.z[j]) * s.limit[j], wide(0.0));
      largest = larger(largest, u);
      square = madd(u, u, square);
    }
    const Wide size = law.norm == NormKind::EUCLIDEAN ? square_root(square) : largest;
    const Lanes damped = ~(size <= wide(1.0 + kLimitSlack)) & good;
    if (s.even && !any(damped)) {  // nothing to clip but rounding, no side to look at
      for (int j = 0; j < s.k; ++j) {
        const int i = s.joint[j];
        const Wide raw = s.scale[j] * s.z[j], rate = select(is_finite(raw), raw, wide(0.0));
        out.rates[i] = select(s.works[j], clamp(rate, p.lower[i], p.upper[i]), out.rates[i]);
      }
      return good;
    }
    if (any(damped)) {
      Lanes chosen = no_lane();
      if (deep) chosen = choose_damping<M>(law, s, damped, in, out.damping, out.iterations);
      good &= ~damped | chosen;
    }
  }
  Lanes clipped = no_lane(), changes = no_lane();
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Wide raw = s.scale[j] * s.z[j], rate = select(is_finite(raw), raw, wide(0.0));
    const Wide inside = clamp(rate, p.lower[i], p.upper[i]);
    clipped |= s.works[j] & (magnitude(inside - rate) > wide(1e-9) * magnitude(rate));
    changes |= s.works[j] & (raw != wide(0.0)) &
               (select(raw > wide(0.0), p.upper[i], -p.lower[i]) != larger(p.upper[i], -p.lower[i]));
    out.rates[i] = select(s.works[j], inside, out.rates[i]);
  }
  good &= ~changes;  // a joint whose side matters
  out.status |= flag(clipped, CLIPPED) | flag(out.damping > wide(0.0), DAMPED);
  return good;
}

// LeastError's search in the lanes of `where`, from the pseudoinverse in s.z. Returns the lanes that were answered.
template <int M>
inline STILLREACH_NOINLINE Lanes search_box(const LaneProblem& p, LaneSystem& s, Lanes where, const LaneInner<M>& in,
                                            LaneAnswer& out) {
  LaneBox<M> b;
  b.k = s.k;
  b.column = s.column;
  b.works = s.works;
  b.length = s.length;
  b.lower = s.lower;
  b.upper = s.upper;
  b.z = s.answer;
  b.target = s.z;
  b.trial = s.trial;
  b.releases = s.releases;
  b.side = s.side;
  b.outside = s.outside;
  b.masked = s.shapes;
  b.narrow = s.few;
  b.masked_column = s.masked_column;
  b.iterations = wide(1.0);
  b.condition = in.condition;
  for (int r = 0; r < M; ++r) {
    b.dual[r] = in.dual[r];
    b.residual[r] = wide(0.0) * in.dual[r];
  }
  for (int j = 0; j < s.k; ++j) s.length[j] = square_root(dot<M>(s.column[j], s.column[j]));
  const Lanes found = solve_box<M>(b, s.rhs, where, every_lane());
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Wide rate = s.scale[j] * (b.z[j] + wide(0.0)), bound = select(b.side[j] > wide(0.0), p.upper[i], p.lower[i]);
    const Wide free = clamp(select(is_finite(rate), rate, wide(0.0)), p.lower[i], p.upper[i]);
    const Wide answer = select((b.side[j] != wide(0.0)) & is_finite(bound), bound, free);
    out.rates[i] = select(s.works[j] & found, answer, out.rates[i]);
  }
  out.iterations = select(found, b.iterations, out.iterations);
  return found;
}

// The same with one price.
template <int M>
inline STILLREACH_NOINLINE Lanes search_price(const LaneProblem& p, LaneSystem& s, Lanes where, Wide most,
                                              const LaneInner<M>& in, LaneAnswer& out) {
  LaneVariables<M> v{s.k,      s.column, s.works,    s.lower,  s.upper,        s.z, s.trial, s.length,
                     s.answer, s.side,   s.releases, s.shapes, s.masked_column};
  OnePrice<M, LaneVariables<M>> search(v, s.rhs, most, in.factor.trace);
  search.begin_at(in.dual);
  const Lanes found = search.search(where & (most > wide(1e-30)) & (most < wide(1e30)));
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Wide rate = s.scale[j] * (s.answer[j] + wide(0.0)),
               bound = select(s.side[j] > wide(0.0), p.upper[i], p.lower[i]);
    const Wide free = clamp(select(is_finite(rate), rate, wide(0.0)), p.lower[i], p.upper[i]);
    const Wide answer = select((s.side[j] != wide(0.0)) & is_finite(bound), bound, free);
    out.rates[i] = select(s.works[j] & found, answer, out.rates[i]);
  }
  out.damping = select(found, search.damping(), out.damping);
  out.iterations = select(found, search.iterations + wide(1.0), out.iterations);
  out.status |= flag(found & (out.damping > wide(0.0)), DAMPED);
  return found;
}

// affordable() of price.hpp.
template <int M>
inline Lanes affordable(const LawSettings& law, Wide typical, const Wide* dual) {
  Wide square[kParts] = {wide(0.0), wide(0.0), wide(0.0)};
  for (int r = 0; r < M; ++r) square[law.part[r]] = madd(dual[r], dual[r], square[law.part[r]]);
  Lanes all = every_lane();
  for (int g = 0; g < law.parts; ++g) {
    const Wide most = wide(law.price[g]) * typical;
    all &= square[g] <= most * most;
  }
  return all;
}

// deep: also the lanes whose bounds bite, or which cost more than their price.
template <int M>
inline Lanes finish_bounded(const LawSettings& law, const LaneProblem& p, LaneSystem& s, Lanes good, bool deep,
                            const LaneInner<M>& in, LaneAnswer& out) {
  Lanes inside = every_lane();
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    inside &= ((s.z[j] <= s.upper[j]) & (s.z[j] >= s.lower[j])) | ~s.works[j];
    const Wide rate = s.scale[j] * (s.z[j] + wide(0.0));
    out.rates[i] =
        select(s.works[j], clamp(select(is_finite(rate), rate, wide(0.0)), p.lower[i], p.upper[i]), out.rates[i]);
  }
  if (law.kind == LawKind::LEAST_ERROR && law.parts > 0) {
    const Lanes exact = good & inside & affordable<M>(law, p.typical, in.dual), left = except(good, exact);
    if (!deep || law.parts > 1 || law.capped >= 0 || !any(left)) return exact;
    return exact | search_price<M>(p, s, left, wide(law.price[0]) * p.typical, in, out);
  }
  const Lanes search = good & ~inside;
  if (!any(search)) return good;
  good &= inside;
  if (!deep || law.kind != LawKind::LEAST_ERROR) return good;
  return good | search_box<M>(p, s, search, in, out);
}

// Before solve_lanes(), where the bounds are new.
inline void prepare_lanes(const LawSettings& law, const LaneProblem& p, LaneSystem& s, Wide* rates) {
  find_working_joints(p, s, rates);
  if (law.kind == LawKind::SINGULARITY_ROBUST) return scale_by_extent(p, s);
  for (int j = 0; j < s.k; ++j) {
    s.lower[j] = p.lower[s.joint[j]] / s.scale[j];
    s.upper[j] = p.upper[s.joint[j]] / s.scale[j];
  }
}

// Answers what it can of problems that are prepared; returns those lanes.
template <int M>
inline Lanes solve_lanes(const LawSettings& law, const LaneProblem& p, bool deep, bool with_residual, LaneSystem& s,
                         LaneAnswer& out) {
  const bool robust = law.kind == LawKind::SINGULARITY_ROBUST;
  out.status = no_flag();
  out.damping = wide(0.0);
  out.scale = out.iterations = wide(1.0);
  out.task_error = wide(0.0);
  Lanes good = s.working >= wide(M);
  if (!any(good)) return good;
  right_hand_side<M>(p, s);
  const bool scaled = robust || p.metric.columns;
  weigh_columns<M>(p, scaled, s);
  LaneInner<M> in;
  good &= solve_wide<M>(s.column, s.k, s.rhs, wide(robust && law.damping == DampingKind::NUMBER ? law.kappa : 0.0), s.z,
                        in, law.kind == LawKind::LEAST_ERROR && law.parts > 0 ? kPricedCondition : kPlainCondition);
  good &= ordinary<M>(in.factor.trace, s.rhs);
  if (law.kind == LawKind::PSEUDOINVERSE)
    good = finish_pseudoinverse<M>(p, s, good, out);
  else if (robust)
    good = finish_singularity_robust<M>(law, p, s, good, deep, in, out);
  else
    good = finish_bounded<M>(law, p, s, good, deep, in, out);
  if (any(good)) good &= report<M>(p, s, with_residual, out);
  return good;
}

STILLREACH_END
