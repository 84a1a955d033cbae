// Choices, roots and shuffles of packs.
#pragma once

#include "stillreach/simd/scalar.hpp"

STILLREACH_BEGIN

// The same number throughout: a number itself, a pack, or one of each problem of lanes.hpp.
template <class P>
STILLREACH_INLINE P fill(double a);
template <>
STILLREACH_INLINE Pack fill<Pack>(double a) {
  return broadcast(a);
}
template <>
STILLREACH_INLINE double fill<double>(double a) {
  return a;
}

// What a comparison of two of them answers.
template <class P>
struct Comparison;
template <>
struct Comparison<double> {
  using Type = bool;
};
template <>
struct Comparison<Pack> {
  using Type = Mask;
};
template <class P>
using Where = typename Comparison<P>::Type;

STILLREACH_INLINE double select(bool where, double a, double b) { return where ? a : b; }
STILLREACH_INLINE Pack select(Mask where, Pack a, Pack b) { return choose(where, a, b); }

STILLREACH_INLINE int bits_of(Mask mask) {
#if defined(__AVX2__) && !defined(STILLREACH_PORTABLE_PACK)
  return _mm256_movemask_pd((__m256d)mask);
#else
  return static_cast<int>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}
STILLREACH_INLINE bool any(Mask mask) { return bits_of(mask) != 0; }
STILLREACH_INLINE bool all(Mask mask) { return bits_of(mask) == 15; }
STILLREACH_INLINE Mask except(Mask a, Mask b) { return a & ~b; }
STILLREACH_INLINE bool any(bool where) { return where; }
STILLREACH_INLINE bool except(bool a, bool b) { return a && !b; }

// As larger(), smaller() and clamp() of scalar.hpp, NaN included.
STILLREACH_INLINE Pack larger(Pack a, Pack b) { return choose(a > b, a, b); }
STILLREACH_INLINE Pack smaller(Pack a, Pack b) { return choose(a < b, a, b); }
STILLREACH_INLINE Mask is_finite(Pack a) { return a - a == Pack{0, 0, 0, 0}; }

STILLREACH_INLINE Pack square_root(Pack a) {
#if defined(__AVX2__) && !defined(STILLREACH_PORTABLE_PACK)
  return (Pack)_mm256_sqrt_pd((__m256d)a);
#else
  return Pack{square_root(a[0]), square_root(a[1]), square_root(a[2]), square_root(a[3])};
#endif
}

// Numbers of an array four at a time, and those that are left one by one: work(type, i) with a Pack or a double.
template <class P>
STILLREACH_INLINE P get(const double* a);
template <>
STILLREACH_INLINE Pack get<Pack>(const double* a) {
  return load(a);
}
template <>
STILLREACH_INLINE double get<double>(const double* a) {
  return *a;
}
STILLREACH_INLINE void put(double* to, Pack a) { store(to, a); }
STILLREACH_INLINE void put(double* to, double a) { *to = a; }
template <class Work>
STILLREACH_INLINE void in_packs(int count, Work work) {
  int i = 0;
  for (; i + 4 <= count; i += 4) work(Pack{}, i);
  for (; i < count; ++i) work(0.0, i);
}

// 0 where all are numbers, else NaN.
STILLREACH_INLINE double doubt_in(const double* a, int count) {
  double doubt = 0.0;
  int i = 0;
  Pack sum = {0, 0, 0, 0};
  for (; i + 4 <= count; i += 4) sum += load(a + i) - load(a + i);
  for (; i < count; ++i) doubt += a[i] - a[i];
  return doubt + ((sum[0] + sum[2]) + (sum[1] + sum[3]));
}

#if defined(STILLREACH_PORTABLE_PACK)
STILLREACH_INLINE double either(const Pack& a, const Pack& b, int i) { return i < 4 ? a[i] : b[i - 4]; }
#define STILLREACH_SHUFFLE(a, b, i, j, k, l) \
  Pack { either(a, b, i), either(a, b, j), either(a, b, k), either(a, b, l) }
#elif defined(__clang__)
#define STILLREACH_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
#define STILLREACH_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, Mask{i, j, k, l})
#endif

// The first two numbers of a pack alone; read back, the others are 0.
STILLREACH_INLINE void store_pair(double* p, Pack v) {
#if defined(__AVX2__) && !defined(STILLREACH_PORTABLE_PACK)
  _mm_storeu_pd(p, _mm256_castpd256_pd128((__m256d)v));
#else
  p[0] = v[0];
  p[1] = v[1];
#endif
}
STILLREACH_INLINE Pack load_pair(const double* p) {
#if defined(__AVX2__) && !defined(STILLREACH_PORTABLE_PACK)
  return (Pack)_mm256_insertf128_pd(_mm256_setzero_pd(), _mm_loadu_pd(p), 0);
#else
  return Pack{p[0], p[1], 0.0, 0.0};
#endif
}

STILLREACH_INLINE void transpose(Pack& a, Pack& b, Pack& c, Pack& d) {
  const Pack ab = STILLREACH_SHUFFLE(a, b, 0, 4, 2, 6), ba = STILLREACH_SHUFFLE(a, b, 1, 5, 3, 7);
  const Pack cd = STILLREACH_SHUFFLE(c, d, 0, 4, 2, 6), dc = STILLREACH_SHUFFLE(c, d, 1, 5, 3, 7);
  a = STILLREACH_SHUFFLE(ab, cd, 0, 1, 4, 5);
  c = STILLREACH_SHUFFLE(ab, cd, 2, 3, 6, 7);
  b = STILLREACH_SHUFFLE(ba, dc, 0, 1, 4, 5);
  d = STILLREACH_SHUFFLE(ba, dc, 2, 3, 6, 7);
}

STILLREACH_END
