// Arithmetic that is the same to the last bit in a scalar and in each lane of a pack: multiply-add is written out
// (the compiler contracts nothing), rounding is by a magic number, choices are masks.
#pragma once

#include "stillreach/config.hpp"

#if defined(STILLREACH_PORTABLE_PACK)
#include "stillreach/simd/portable_pack.hpp"
#elif defined(__AVX2__) && defined(__FMA__)
#if !defined(__clang__)
#pragma GCC diagnostic push  // GCC's own undefined registers of 512 bits
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif
#include <immintrin.h>
#if !defined(__clang__)
#pragma GCC diagnostic pop
#endif
#endif

STILLREACH_BEGIN

#if !defined(STILLREACH_PORTABLE_PACK)
typedef double Pack __attribute__((vector_size(32)));  // four joints, or a 3-vector and a lane that does not matter
typedef long long Mask __attribute__((vector_size(32)));
STILLREACH_INLINE Pack choose(Mask mask, Pack a, Pack b) { return mask ? a : b; }
#endif

STILLREACH_INLINE double madd(double a, double b, double c) {
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA) || defined(__CUDACC__)
  return STILLREACH_LIBRARY(fma)(a, b, c);
#else
  return a * b + c;
#endif
}

STILLREACH_INLINE Pack madd(Pack a, Pack b, Pack c) {
#if defined(STILLREACH_PORTABLE_PACK) || defined(__ARM_FEATURE_FMA)
  return Pack{madd(a[0], b[0], c[0]), madd(a[1], b[1], c[1]), madd(a[2], b[2], c[2]), madd(a[3], b[3], c[3])};
#elif defined(__AVX2__) && defined(__FMA__)
  return (Pack)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#else
  return a * b + c;
#endif
}

STILLREACH_INLINE Pack broadcast(double a) { return Pack{a, a, a, a}; }
STILLREACH_INLINE Pack load(const double* p) {
  Pack v;
  STILLREACH_LIBRARY(memcpy)(&v, p, sizeof v);
  return v;
}
STILLREACH_INLINE void store(double* p, Pack v) { STILLREACH_LIBRARY(memcpy)(p, &v, sizeof v); }

STILLREACH_INLINE bool is_finite(double a) { return a - a == 0.0; }  // also right when the compiler assumes no traps
STILLREACH_INLINE double magnitude(double a) { return STILLREACH_LIBRARY(fabs)(a); }
STILLREACH_INLINE Pack magnitude(Pack a) { return (Pack)((Mask)a & 0x7fffffffffffffffLL); }
STILLREACH_INLINE double larger(double a, double b) { return a > b ? a : b; }  // b where either is NaN
STILLREACH_INLINE double smaller(double a, double b) { return a < b ? a : b; }
STILLREACH_INLINE double clamp(double a, double lower, double upper) { return larger(smaller(a, upper), lower); }
STILLREACH_INLINE double nearest_integer(double a) {  // below 2^51; larger numbers lose bits of no meaning
  const double magic = 0x1.8p52;
  return a + magic - magic;
}
STILLREACH_INLINE double square_root(double a) { return STILLREACH_LIBRARY(sqrt)(a); }
#if defined(__CUDACC_RTC__)
STILLREACH_INLINE double infinity() { return __longlong_as_double(0x7ff0000000000000); }
#else
STILLREACH_INLINE double infinity() { return HUGE_VAL; }
#endif

STILLREACH_END
