// Sine and cosine of many angles at once: reduction by pi/2 in three parts (Cody and Waite, 1980), then polynomials
// that err least on [-pi/4, pi/4] (by Remez's exchange; 2e-18 and 5e-20, with these coefficients). Absolute error below 3e-16
// up to 8e5 rad; larger angles go to the C library.
#pragma once

#include "stillreach/simd/packs.hpp"

STILLREACH_BEGIN

constexpr double kLargestReducedAngle = 8.0e5;

// sine and cosine of an angle from those of the reduced one; the low bits of the shifted sum count the quadrants.
STILLREACH_INLINE void turn_quadrants(Pack shifted, Pack s, Pack c, Pack& sine, Pack& cosine) {
  const Mask odd = (Mask)shifted << 63, half = (Mask)shifted << 62, sign = (Mask)broadcast(-0.0);
  const Mask swap = ((Mask)s ^ (Mask)c) & (odd != Mask{0, 0, 0, 0});
  sine = (Pack)((Mask)s ^ swap ^ (half & sign));
  cosine = (Pack)((Mask)c ^ swap ^ ((odd ^ half) & sign));
}

template <class P>
STILLREACH_INLINE void sincos(P x, P& sine, P& cosine) {
  const P magic = fill<P>(0x1.8p52);
  const P shifted = madd(x, fill<P>(0.63661977236758134308), magic);  // 2 / pi
  const P k = shifted - magic;
  P r = madd(k, fill<P>(-0x1.921fb544p0), x);   // pi/2, first 33 bits,
  r = madd(k, fill<P>(-0x1.0b4611a6p-34), r);      // next 33 bits,
  r = madd(k, fill<P>(-0x1.3198a2e037073p-69), r); // and the rest
  const P z = r * r;
  P s = fill<P>(0x1.5d61cfddebb1ep-33);
  s = madd(s, z, fill<P>(-0x1.ae5da9ea151d7p-26));
  s = madd(s, z, fill<P>(0x1.71de346756cccp-19));
  s = madd(s, z, fill<P>(-0x1.a01a019aa3718p-13));
  s = madd(s, z, fill<P>(0x1.111111110ea87p-7));
  s = madd(s, z, fill<P>(-0x1.555555555553dp-3));
  s = madd(s * z, r, r);
  P c = fill<P>(-0x1.8fb10a1078b0bp-37);
  c = madd(c, z, fill<P>(0x1.1ee9f11088993p-29));
  c = madd(c, z, fill<P>(-0x1.27e4f81265312p-22));
  c = madd(c, z, fill<P>(0x1.a01a019cbf0d4p-16));
  c = madd(c, z, fill<P>(-0x1.6c16c16c1521dp-10));
  c = madd(c, z, fill<P>(0x1.555555555554cp-5));
  c = madd(c * z, z, madd(z, fill<P>(-0.5), fill<P>(1.0)));
  turn_quadrants(shifted, s, c, sine, cosine);
}

// Up to four angles. Those outside the reduction's range, and NaN, go to the C library.
STILLREACH_INLINE void sincos_lanes(Pack x, int lanes, Pack& s, Pack& c) {
  sincos(x, s, c);
  const Mask reducible = magnitude(x) <= broadcast(kLargestReducedAngle);
  if ((reducible[0] & reducible[1] & reducible[2] & reducible[3]) != 0) return;
  for (int l = 0; l < lanes; ++l)
    if (!(magnitude(x[l]) <= kLargestReducedAngle)) s[l] = STILLREACH_LIBRARY(sin)(x[l]), c[l] = STILLREACH_LIBRARY(cos)(x[l]);
}

// q, sine, cosine: count values each.
inline void sincos(const double* q, int count, double* sine, double* cosine) {
  int i = 0;
  Pack s, c;
  for (; i + 4 <= count; i += 4) {
    sincos_lanes(load(q + i), 4, s, c);
    store(sine + i, s), store(cosine + i, c);
  }
  if (i == count) return;
  Pack x = {};
  for (int l = 0; l < count - i; ++l) x[l] = q[i + l];
  sincos_lanes(x, count - i, s, c);
  for (int l = 0; l < count - i; ++l) sine[i + l] = s[l], cosine[i + l] = c[l];
}

STILLREACH_END
