// Four independent problems at once, one in each lane of a pack. Lane code does, in each lane, the operations of the
// single tick in their order, so that both give the same bits; where a lane needs what only the single tick does, it is
// left to it.
#pragma once

#include "scalar.hpp"

STILLREACH_BEGIN

constexpr int kLanes = 4;

STILLREACH_INLINE Mask no_lane() { return Mask{0, 0, 0, 0}; }
STILLREACH_INLINE Mask every_lane() { return Mask{-1, -1, -1, -1}; }
STILLREACH_INLINE Pack zero_pack() { return Pack{0, 0, 0, 0}; }
STILLREACH_INLINE Pack select(Mask where, Pack a, Pack b) { return choose(where, a, b); }

STILLREACH_INLINE int lane_bits(Mask mask) {
#if defined(__AVX2__) && !defined(STILLREACH_PORTABLE_PACK)
  return _mm256_movemask_pd((__m256d)mask);
#else
  return static_cast<int>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}
STILLREACH_INLINE bool any(Mask mask) { return lane_bits(mask) != 0; }
STILLREACH_INLINE bool all(Mask mask) { return lane_bits(mask) == 15; }

// As larger(), smaller() and clamp() of scalar.hpp, NaN included.
STILLREACH_INLINE Pack larger(Pack a, Pack b) { return choose(a > b, a, b); }
STILLREACH_INLINE Pack smaller(Pack a, Pack b) { return choose(a < b, a, b); }
STILLREACH_INLINE Pack clamp(Pack a, Pack lower, Pack upper) { return larger(smaller(a, upper), lower); }
STILLREACH_INLINE Mask is_finite(Pack a) { return a - a == zero_pack(); }

STILLREACH_INLINE Pack square_root(Pack a) {
#if defined(__AVX2__) && !defined(STILLREACH_PORTABLE_PACK)
  return (Pack)_mm256_sqrt_pd((__m256d)a);
#else
  return Pack{square_root(a[0]), square_root(a[1]), square_root(a[2]), square_root(a[3])};
#endif
}

#if defined(STILLREACH_PORTABLE_PACK)
STILLREACH_INLINE double either(const Pack& a, const Pack& b, int i) { return i < 4 ? a[i] : b[i - 4]; }
#define STILLREACH_SHUFFLE(a, b, i, j, k, l) Pack{either(a, b, i), either(a, b, j), either(a, b, k), either(a, b, l)}
#elif defined(__clang__)
#define STILLREACH_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
#define STILLREACH_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, Mask{i, j, k, l})
#endif

STILLREACH_INLINE void transpose(Pack& a, Pack& b, Pack& c, Pack& d) {
  const Pack ab = STILLREACH_SHUFFLE(a, b, 0, 4, 2, 6), ba = STILLREACH_SHUFFLE(a, b, 1, 5, 3, 7);
  const Pack cd = STILLREACH_SHUFFLE(c, d, 0, 4, 2, 6), dc = STILLREACH_SHUFFLE(c, d, 1, 5, 3, 7);
  a = STILLREACH_SHUFFLE(ab, cd, 0, 1, 4, 5), c = STILLREACH_SHUFFLE(ab, cd, 2, 3, 6, 7);
  b = STILLREACH_SHUFFLE(ba, dc, 0, 1, 4, 5), d = STILLREACH_SHUFFLE(ba, dc, 2, 3, 6, 7);
}

// to[i] = the i-th numbers of four vectors of `count`. Four numbers each at a time; the last four may overlap those before.
inline void load_lanes(const double* const* from, int count, Pack* to) {
  if (count < 4) {
    for (int i = 0; i < count; ++i) to[i] = Pack{from[0][i], from[1][i], from[2][i], from[3][i]};
    return;
  }
  for (int next = 0; next < count; next += 4) {
    const int i = next + 4 <= count ? next : count - 4;
    Pack a = load(from[0] + i), b = load(from[1] + i), c = load(from[2] + i), d = load(from[3] + i);
    transpose(a, b, c, d);
    to[i] = a, to[i + 1] = b, to[i + 2] = c, to[i + 3] = d;
  }
}

// The other way round, into the vectors of the lanes whose bit is set.
inline void store_lanes(const Pack* from, int count, int lanes, double* const* to) {
  if (count < 4) {
    for (int l = 0; l < kLanes; ++l)
      for (int i = 0; i < count && (lanes & 1 << l); ++i) to[l][i] = from[i][l];
    return;
  }
  for (int next = 0; next < count; next += 4) {
    const int i = next + 4 <= count ? next : count - 4;
    Pack p[4] = {from[i], from[i + 1], from[i + 2], from[i + 3]};
    transpose(p[0], p[1], p[2], p[3]);
    for (int l = 0; l < kLanes; ++l)
      if (lanes & 1 << l) store(to[l] + i, p[l]);
  }
}

STILLREACH_END
