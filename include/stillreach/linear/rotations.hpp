// Rotations that make pairs of columns orthogonal (one-sided Jacobi), several pairs at once: those of one matrix in a
// pack, or the same pair of each lane's.
#pragma once

#include "stillreach/simd/packs.hpp"

STILLREACH_BEGIN

constexpr int kSweeps = 30;
// Every pair of six columns once: five rounds of three that do not wait for each other.
struct Tournament {
  signed char rounds[5][3][2];
};
STILLREACH_INLINE constexpr Tournament tournament() {
  return {{{{0, 1}, {2, 3}, {4, 5}},
           {{0, 2}, {1, 4}, {3, 5}},
           {{0, 4}, {1, 3}, {2, 5}},
           {{0, 5}, {1, 2}, {3, 4}},
           {{0, 3}, {1, 5}, {2, 4}}}};
}

template <class P, class M>
struct Rotations {
  M here;   // where the columns are not orthogonal
  M large;  // where other pairs' orthogonality may suffer
  P c, s;   // p becomes c p - s q, q becomes s p + c q
};

// From p'p, q'q and p'q, in the lanes of `where`. Once all cosines of a sweep are below 1e-8 and no rotation mixes
// columns by more than that, relative to the smaller one, what the sweep leaves is their product: below the rounding.
template <class P, class M>
STILLREACH_INLINE Rotations<P, M> rotations(P pp, P qq, P pq, M where) {
  const P square = pq * pq, both = pp * qq, d = qq - pp, twice = pq + pq, zero = fill<P>(0.0);
  Rotations<P, M> turn{};
  turn.here = where & (square > larger(1e-31 * both, fill<P>(1e-290)));
  if (!any(turn.here)) return turn;
  // tan = sign(d) 2 p'q / (|d| + sqrt(d^2 + 4 p'q^2))
  const P below = magnitude(d) + square_root(madd(d, d, twice * twice));
  const P inverse = 1.0 / square_root(madd(below, below, twice * twice));
  const P c = below * inverse, s = select(d < zero, -twice, twice) * inverse;
  const M mixes = s * s * larger(pp, qq) > 1e-16 * smaller(pp, qq);
  turn.large = turn.here & ((square > 1e-16 * both) | mixes);
  turn.c = select(turn.here, c, fill<P>(1.0));
  turn.s = select(turn.here, s, zero);
  return turn;
}

// Sums of the numbers of each pack.
STILLREACH_INLINE Pack sums(Pack (&p)[4]) {
  transpose(p[0], p[1], p[2], p[3]);
  return (p[0] + p[2]) + (p[1] + p[3]);
}

// Turns two columns of kStride numbers.
STILLREACH_INLINE void rotate(Pack c, Pack s, double* p, double* q) {
  for (int r = 0; r < 8; r += 4) {
    const Pack a = load(p + r), b = load(q + r);
    store(p + r, madd(c, a, -(s * b)));
    store(q + r, madd(s, a, c * b));
  }
}

STILLREACH_END
