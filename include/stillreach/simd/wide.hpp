// Eight numbers in a register of AVX-512, and choices among them as bits: what a pack and its mask are to four.
#pragma once

#include "stillreach/simd/packs.hpp"

STILLREACH_BEGIN

struct Wide {
  __m512d all;
  STILLREACH_INLINE double& operator[](int i) { return reinterpret_cast<double*>(&all)[i]; }  // the type may alias
  STILLREACH_INLINE double operator[](int i) const { return reinterpret_cast<const double*>(&all)[i]; }
};

struct Lanes {
  __mmask8 bits;
  STILLREACH_INLINE bool operator[](int i) const { return (bits >> i & 1) != 0; }
};

struct Flags {
  __m512i all;
};

template <>
struct Comparison<Wide> {
  using Type = Lanes;
};

template <>
STILLREACH_INLINE Wide fill<Wide>(double a) {
  return {_mm512_set1_pd(a)};
}

#define STILLREACH_ARITHMETIC(op, name)                                                             \
  STILLREACH_INLINE Wide operator op(Wide a, Wide b) { return {_mm512_##name##_pd(a.all, b.all)}; } \
  STILLREACH_INLINE Wide operator op(Wide a, double b) { return a op fill<Wide>(b); }               \
  STILLREACH_INLINE Wide operator op(double a, Wide b) { return fill<Wide>(a) op b; }               \
  STILLREACH_INLINE Wide& operator op## = (Wide & a, Wide b) { return a = a op b; }
STILLREACH_ARITHMETIC(+, add)
STILLREACH_ARITHMETIC(-, sub)
STILLREACH_ARITHMETIC(*, mul)
STILLREACH_ARITHMETIC(/, div)
#undef STILLREACH_ARITHMETIC

#define STILLREACH_COMPARISON(op, kind) \
  STILLREACH_INLINE Lanes operator op(Wide a, Wide b) { return {_mm512_cmp_pd_mask(a.all, b.all, kind)}; }
STILLREACH_COMPARISON(<, _CMP_LT_OQ)
STILLREACH_COMPARISON(<=, _CMP_LE_OQ)
STILLREACH_COMPARISON(>, _CMP_GT_OQ)
STILLREACH_COMPARISON(>=, _CMP_GE_OQ)
STILLREACH_COMPARISON(==, _CMP_EQ_OQ)
STILLREACH_COMPARISON(!=, _CMP_NEQ_UQ)
#undef STILLREACH_COMPARISON

#define STILLREACH_BITS(op)                                                                                   \
  STILLREACH_INLINE Lanes operator op(Lanes a, Lanes b) { return {static_cast<__mmask8>(a.bits op b.bits)}; } \
  STILLREACH_INLINE Lanes& operator op## = (Lanes & a, Lanes b) { return a = a op b; }
STILLREACH_BITS(&)
STILLREACH_BITS(|)
STILLREACH_BITS(^)
#undef STILLREACH_BITS
STILLREACH_INLINE Lanes except(Lanes a, Lanes b) { return {static_cast<__mmask8>(a.bits & ~b.bits)}; }
STILLREACH_INLINE Lanes operator~(Lanes a) { return {static_cast<__mmask8>(~a.bits)}; }

STILLREACH_INLINE Wide operator-(Wide a) { return {_mm512_xor_pd(a.all, _mm512_set1_pd(-0.0))}; }
STILLREACH_INLINE Wide magnitude(Wide a) { return {_mm512_abs_pd(a.all)}; }
STILLREACH_INLINE Wide square_root(Wide a) { return {_mm512_sqrt_pd(a.all)}; }
STILLREACH_INLINE Wide madd(Wide a, Wide b, Wide c) { return {_mm512_fmadd_pd(a.all, b.all, c.all)}; }
STILLREACH_INLINE Wide select(Lanes where, Wide a, Wide b) { return {_mm512_mask_blend_pd(where.bits, b.all, a.all)}; }
STILLREACH_INLINE Wide larger(Wide a, Wide b) { return {_mm512_max_pd(a.all, b.all)}; }  // b where either is NaN
STILLREACH_INLINE Wide smaller(Wide a, Wide b) { return {_mm512_min_pd(a.all, b.all)}; }
STILLREACH_INLINE Lanes is_finite(Wide a) { return a - a == fill<Wide>(0.0); }
STILLREACH_INLINE int bits_of(Lanes where) { return where.bits; }
STILLREACH_INLINE bool any(Lanes where) { return where.bits != 0; }
STILLREACH_INLINE bool all(Lanes where) { return where.bits == 255; }
STILLREACH_INLINE Flags operator|(Flags a, Flags b) { return {_mm512_or_si512(a.all, b.all)}; }
STILLREACH_INLINE Flags& operator|=(Flags& a, Flags b) { return a = a | b; }
STILLREACH_INLINE Flags flag(Lanes where, std::int32_t status) { return {_mm512_maskz_set1_epi64(where.bits, status)}; }

// As of packs: sincos.hpp.
STILLREACH_INLINE void turn_quadrants(Wide shifted, Wide s, Wide c, Wide& sine, Wide& cosine) {
  const __m512i quadrant = _mm512_castpd_si512(shifted.all), two = _mm512_set1_epi64(2);
  const Lanes swap{_mm512_test_epi64_mask(quadrant, _mm512_set1_epi64(1))};
  const __m512i next = _mm512_add_epi64(quadrant, _mm512_set1_epi64(1));
  const auto signed_by = [two](__m512i turns, Wide a) {
    return Wide{_mm512_xor_pd(a.all, _mm512_castsi512_pd(_mm512_slli_epi64(_mm512_and_si512(turns, two), 62)))};
  };
  sine = signed_by(quadrant, select(swap, c, s));
  cosine = signed_by(next, select(swap, s, c));
}

// Four lanes at a time as a pack: those of half 0 or 1.
STILLREACH_INLINE Wide join(const Pack* halves) {
  return {_mm512_insertf64x4(_mm512_castpd256_pd512((__m256d)halves[0]), (__m256d)halves[1], 1)};
}
STILLREACH_INLINE Pack part_of(Wide a, int half) {
  return half == 0 ? (Pack)_mm512_castpd512_pd256(a.all) : (Pack)_mm512_extractf64x4_pd(a.all, 1);
}

// The r-th numbers of eight vectors, one of each lane.
STILLREACH_INLINE Wide pick(const Wide* const* from, int r) {
  return {_mm512_setr_pd(from[0][r][0], from[1][r][1], from[2][r][2], from[3][r][3], from[4][r][4], from[5][r][5],
                         from[6][r][6], from[7][r][7])};
}

STILLREACH_END
