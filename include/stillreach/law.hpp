// One door to all laws. The answer's rates are finite for any finite problem; inside the bounds for all but Pseudoinverse.
#pragma once

#include "keep_direction.hpp"
#include "least_error.hpp"
#include "singularity_robust.hpp"

STILLREACH_BEGIN

template <int M>
inline void solve_rows(Rows<M> m, const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  switch (law.kind) {
    case PSEUDOINVERSE: return pseudoinverse(m, law, p, w, out);
    case SINGULARITY_ROBUST: return singularity_robust(m, law, p, w, out);
    case KEEP_DIRECTION: return keep_direction(m, law, p, w, out);
    default: return least_error(m, law, p, w, out);
  }
}

// out.active holds the bounds that were active a tick ago (zeros: none) and receives those that are now.
inline void solve_law(const LawSettings& law, const Problem& p, Workspace& w, Answer& out) {
  switch (p.m) {
    case 6: return solve_rows(Rows<6>{6}, law, p, w, out);
    case 3: return solve_rows(Rows<3>{3}, law, p, w, out);
    default: return solve_rows(Rows<0>{p.m}, law, p, w, out);
  }
}

STILLREACH_END
