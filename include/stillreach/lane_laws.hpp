// The laws for four problems at once. Each function answers the lanes that take the ordinary way through a law and says
// which; the single tick's code answers the others.
#pragma once

#include "lane_damping.hpp"
#include "lane_system.hpp"
#include "law.hpp"

STILLREACH_BEGIN

// Problems that have an ordinary way at all.
STILLREACH_INLINE bool suits_lanes(int n, int m, const Metric& metric) {
  return (m == 6 || m == 3) && n >= m && !metric.joints;
}

template <int M>
inline Mask finish_pseudoinverse(const LaneProblem& p, const LaneSystem& s, Mask good, LaneAnswer& out) {
  Mask over = no_lane();
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Pack rate = s.scale[j] * s.z[j];
    over |= s.works[j] & ~((rate <= p.upper[i]) & (rate >= p.lower[i]));
    good &= is_finite(rate) | ~s.works[j];
    out.rates[i] = select(s.works[j], rate, out.rates[i]);
  }
  out.status |= flag(over, OVER_LIMIT);
  return good;
}

// deep: also the lanes that need damping chosen.
template <int M>
inline Mask finish_singularity_robust(const LawSettings& law, const LaneProblem& p, LaneSystem& s, Mask good, bool deep,
                                      const LaneInner<M>& in, LaneAnswer& out) {
  out.damping = zero_pack();
  if (law.damping == DAMPING_NUMBER) {
    out.damping = broadcast(law.kappa);
  } else {
    Pack largest = zero_pack(), square = zero_pack();
    for (int j = 0; j < s.k; ++j) {
      const Pack u = select(s.works[j], magnitude(s.z[j]) * s.limit[j], zero_pack());
      largest = larger(largest, u), square = madd(u, u, square);
    }
    const Pack size = law.norm == NORM_2 ? square_root(square) : largest;
    const Mask damped = ~(size <= broadcast(1.0 + kLimitSlack)) & good;
    if (any(damped)) {
      Mask chosen = no_lane();
      if (deep && law.norm == NORM_INF)
        chosen = choose_damping<M>(law.damping == DAMPING_EXACT, law.rank_tolerance, s.column, s.rhs, s.limit, s.k, in, damped, s.shapes,
                                   s.terms, s.z, out.damping, out.iterations);
      good &= ~damped | chosen;
    }
  }
  Mask clipped = no_lane(), changes = no_lane();
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Pack raw = s.scale[j] * s.z[j], rate = select(is_finite(raw), raw, zero_pack());
    const Pack inside = clamp(rate, p.lower[i], p.upper[i]);
    clipped |= s.works[j] & (magnitude(inside - rate) > broadcast(1e-9) * magnitude(rate));
    changes |= s.works[j] & (raw != zero_pack()) & (select(raw > zero_pack(), p.upper[i], -p.lower[i]) != larger(p.upper[i], -p.lower[i]));
    out.rates[i] = select(s.works[j], inside, out.rates[i]);
  }
  good &= ~changes;  // a joint whose side matters
  out.status |= flag(clipped, CLIPPED) | flag(out.damping > zero_pack(), DAMPED);
  return good;
}

template <int M>
inline Mask finish_bounded(const LawSettings& law, const LaneProblem& p, LaneSystem& s, Mask good, bool scaled, const LaneInner<M>& in,
                           LaneAnswer& out) {
  Mask inside = every_lane();
  for (int j = 0; j < s.k; ++j) {
    const int i = s.joint[j];
    const Pack lower = scaled ? p.lower[i] / s.scale[j] : p.lower[i], upper = scaled ? p.upper[i] / s.scale[j] : p.upper[i];
    inside &= ((s.z[j] <= upper) & (s.z[j] >= lower)) | ~s.works[j];
    const Pack rate = s.scale[j] * (s.z[j] + zero_pack());
    out.rates[i] = select(s.works[j], clamp(select(is_finite(rate), rate, zero_pack()), p.lower[i], p.upper[i]), out.rates[i]);
  }
  good &= inside;
  if (law.kind == LEAST_ERROR && law.max_gain > 0.0)  // no damping where the gain is below its limit
    good &= broadcast(law.max_gain) / square_root(in.factor.inverse_trace) >= broadcast(1.0);
  return good;
}

// Before solve_lanes(), where the bounds are new.
inline void prepare_lanes(const LawSettings& law, const LaneProblem& p, LaneSystem& s, Pack* rates) {
  find_working_joints(p, s, rates);
  if (law.kind == SINGULARITY_ROBUST) scale_by_extent(p, s);
}

// Answers what it can of four problems that are prepared; returns those lanes.
template <int M>
inline Mask solve_lanes(const LawSettings& law, const LaneProblem& p, bool deep, bool with_residual, LaneSystem& s, LaneAnswer& out) {
  const bool robust = law.kind == SINGULARITY_ROBUST;
  out.status = no_lane(), out.damping = zero_pack(), out.scale = out.iterations = broadcast(1.0), out.task_error = zero_pack();
  Mask good = s.working >= broadcast(M);
  if (!any(good)) return good;
  right_hand_side<M>(p, s);
  const bool scaled = robust || p.metric.columns;
  weigh_columns<M>(p, scaled, s);
  LaneInner<M> in;
  good &= solve_wide<M>(s.column, s.k, s.rhs, broadcast(robust && law.damping == DAMPING_NUMBER ? law.kappa : 0.0), s.z, in);
  good &= ordinary<M>(in.factor.trace, s.rhs);
  if (law.kind == PSEUDOINVERSE)
    good = finish_pseudoinverse<M>(p, s, good, out);
  else if (robust)
    good = finish_singularity_robust<M>(law, p, s, good, deep, in, out);
  else
    good = finish_bounded<M>(law, p, s, good, scaled, in, out);
  if (any(good)) good &= report<M>(p, s, with_residual, out);
  return good;
}

STILLREACH_END
