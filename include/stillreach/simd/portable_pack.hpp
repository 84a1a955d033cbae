// Pack and Mask for compilers without vectors: the same operators lane by lane, and so the same numbers to the last
// bit.
#pragma once

#include "stillreach/config.hpp"

STILLREACH_BEGIN

struct Mask;

struct Pack {
  double lane[4];
  STILLREACH_INLINE double& operator[](int i) { return lane[i]; }
  STILLREACH_INLINE double operator[](int i) const { return lane[i]; }
  STILLREACH_INLINE explicit operator Mask() const;  // the same bits
};

struct Mask {  // of a comparison: all bits of a lane where it holds, none where it does not
  long long lane[4];
  STILLREACH_INLINE long long operator[](int i) const { return lane[i]; }
  STILLREACH_INLINE explicit operator Pack() const;
};

STILLREACH_INLINE Pack::operator Mask() const {
  Mask same;
  STILLREACH_LIBRARY(memcpy)(&same, this, sizeof same);
  return same;
}
STILLREACH_INLINE Mask::operator Pack() const {
  Pack same;
  STILLREACH_LIBRARY(memcpy)(&same, this, sizeof same);
  return same;
}

// A single number is the same in every lane. Masks count without sign, where nothing overflows.
STILLREACH_INLINE double lane_of(double a, int) { return a; }
STILLREACH_INLINE double lane_of(Pack a, int i) { return a.lane[i]; }
STILLREACH_INLINE unsigned long long lane_of(long long a, int) { return static_cast<unsigned long long>(a); }
STILLREACH_INLINE unsigned long long lane_of(Mask a, int i) { return static_cast<unsigned long long>(a.lane[i]); }

#define STILLREACH_LANEWISE(Result, A, op, B, number)                                            \
  STILLREACH_INLINE Result operator op(A a, B b) {                                               \
    Result r;                                                                                    \
    for (int i = 0; i < 4; ++i) r.lane[i] = static_cast<number>(lane_of(a, i) op lane_of(b, i)); \
    return r;                                                                                    \
  }
#define STILLREACH_ARITHMETIC(op)                     \
  STILLREACH_LANEWISE(Pack, Pack, op, Pack, double)   \
  STILLREACH_LANEWISE(Pack, Pack, op, double, double) \
  STILLREACH_LANEWISE(Pack, double, op, Pack, double) \
  STILLREACH_INLINE Pack& operator op## = (Pack & a, Pack b) { return a = a op b; }
#define STILLREACH_BITS(op)                                 \
  STILLREACH_LANEWISE(Mask, Mask, op, Mask, long long)      \
  STILLREACH_LANEWISE(Mask, Mask, op, long long, long long) \
  STILLREACH_INLINE Mask& operator op## = (Mask & a, Mask b) { return a = a op b; }
#define STILLREACH_COMPARISON(op, Kind)                                              \
  STILLREACH_INLINE Mask operator op(Kind a, Kind b) {                               \
    Mask r;                                                                          \
    for (int i = 0; i < 4; ++i) r.lane[i] = lane_of(a, i) op lane_of(b, i) ? -1 : 0; \
    return r;                                                                        \
  }

STILLREACH_ARITHMETIC(+)
STILLREACH_ARITHMETIC(-)
STILLREACH_ARITHMETIC(*)
STILLREACH_ARITHMETIC(/)
STILLREACH_COMPARISON(<, Pack)
STILLREACH_COMPARISON(<=, Pack)
STILLREACH_COMPARISON(>, Pack)
STILLREACH_COMPARISON(>=, Pack)
STILLREACH_COMPARISON(==, Pack)
STILLREACH_COMPARISON(!=, Pack)
STILLREACH_COMPARISON(!=, Mask)
STILLREACH_BITS(&)
STILLREACH_BITS(|)
STILLREACH_BITS(^)
STILLREACH_BITS(+)
STILLREACH_BITS(<<)

#undef STILLREACH_LANEWISE
#undef STILLREACH_ARITHMETIC
#undef STILLREACH_BITS
#undef STILLREACH_COMPARISON

STILLREACH_INLINE Pack operator-(Pack a) { return Pack{-a[0], -a[1], -a[2], -a[3]}; }
STILLREACH_INLINE Mask operator~(Mask a) { return Mask{~a[0], ~a[1], ~a[2], ~a[3]}; }
STILLREACH_INLINE Pack choose(Mask mask, Pack a, Pack b) {
  Pack r;
  for (int i = 0; i < 4; ++i) r.lane[i] = mask[i] ? a[i] : b[i];
  return r;
}

STILLREACH_END
