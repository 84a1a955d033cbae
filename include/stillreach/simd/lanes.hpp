// Independent problems at once, kLanes of them: a Wide holds a number of each, Lanes say which of them. Lane code does,
// in each lane, the operations of the single tick in their order, so that both give the same bits; where a lane needs
// what only the single tick does, it is left to it.
#pragma once

#if defined(STILLREACH_WIDE)
#include "stillreach/simd/wide.hpp"
#else
#include "stillreach/simd/packs.hpp"
#endif

STILLREACH_BEGIN

#if defined(STILLREACH_WIDE)
constexpr int kLanes = 8;
STILLREACH_INLINE Lanes no_lane() { return {0}; }
#else
constexpr int kLanes = 4;
using Wide = Pack;
using Lanes = Mask;
using Flags = Mask;  // a status of each problem
STILLREACH_INLINE Lanes no_lane() { return Lanes{0, 0, 0, 0}; }
STILLREACH_INLINE Flags flag(Lanes where, std::int32_t status) { return where & static_cast<long long>(status); }
STILLREACH_INLINE Wide join(const Pack* part) { return *part; }
STILLREACH_INLINE Pack part_of(Wide a, int) { return a; }
STILLREACH_INLINE Wide pick(const Wide* const* from, int r) {
  return Wide{from[0][r][0], from[1][r][1], from[2][r][2], from[3][r][3]};
}
#endif

STILLREACH_INLINE Wide wide(double a) { return fill<Wide>(a); }
STILLREACH_INLINE Lanes every_lane() { return ~no_lane(); }
STILLREACH_INLINE Flags no_flag() { return flag(no_lane(), 0); }
STILLREACH_INLINE Wide clamp(Wide a, Wide lower, Wide upper) { return larger(smaller(a, upper), lower); }

// to[i] = the i-th numbers of the lanes' vectors of `count`. Four numbers each at a time; the last four may overlap
// those before.
inline void load_lanes(const double* const* from, int count, Wide* to) {
  if (count < 4) {
    for (int i = 0; i < count; ++i)
      for (int l = 0; l < kLanes; ++l) to[i][l] = from[l][i];
    return;
  }
  for (int next = 0; next < count; next += 4) {
    const int i = next + 4 <= count ? next : count - 4;
    Pack part[4][kLanes / 4];
    for (int h = 0; h < kLanes / 4; ++h) {
      Pack a = load(from[4 * h] + i), b = load(from[4 * h + 1] + i), c = load(from[4 * h + 2] + i),
           d = load(from[4 * h + 3] + i);
      transpose(a, b, c, d);
      part[0][h] = a;
      part[1][h] = b;
      part[2][h] = c;
      part[3][h] = d;
    }
    for (int r = 0; r < 4; ++r) to[i + r] = join(part[r]);
  }
}

// The other way round, into the vectors of the lanes whose bit is set.
inline void store_lanes(const Wide* from, int count, int lanes, double* const* to) {
  if (count < 4) {
    for (int l = 0; l < kLanes; ++l)
      for (int i = 0; i < count && (lanes & 1 << l); ++i) to[l][i] = from[i][l];
    return;
  }
  for (int next = 0; next < count; next += 4) {
    const int i = next + 4 <= count ? next : count - 4;
    for (int h = 0; h < kLanes / 4; ++h) {
      Pack p[4] = {part_of(from[i], h), part_of(from[i + 1], h), part_of(from[i + 2], h), part_of(from[i + 3], h)};
      transpose(p[0], p[1], p[2], p[3]);
      for (int l = 0; l < 4; ++l)
        if (lanes & 1 << (4 * h + l)) store(to[4 * h + l] + i, p[l]);
    }
  }
}

STILLREACH_END
