// Sine and cosine of many angles at once: reduction by pi/2 in three parts (Cody and Waite, 1980), then polynomials.
// Absolute error below 3e-16 up to 8e5 rad; larger angles are reduced one by one.
#pragma once

#include "stillreach/kinematics/large_angles.hpp"

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
  P r = madd(k, fill<P>(-0x1.921fb544p0), x);       // pi/2, first 33 bits,
  r = madd(k, fill<P>(-0x1.0b4611a6p-34), r);       // next 33 bits,
  r = madd(k, fill<P>(-0x1.3198a2e037073p-69), r);  // and the rest
  P s, c;
  sincos_reduced(r, s, c);
  turn_quadrants(shifted, s, c, sine, cosine);
}

// Up to four angles, of any size; of a NaN and of infinity NaN.
STILLREACH_INLINE void sincos_lanes(Pack x, int lanes, Pack& s, Pack& c) {
  sincos(x, s, c);
  const Mask reducible = magnitude(x) <= broadcast(kLargestReducedAngle);
  if ((reducible[0] & reducible[1] & reducible[2] & reducible[3]) != 0) return;
  for (int l = 0; l < lanes; ++l)
    if (!(magnitude(x[l]) <= kLargestReducedAngle)) {
      double sine, cosine;
      sincos_large(x[l], sine, cosine);
      s[l] = sine;
      c[l] = cosine;
    }
}

// q, sine, cosine: count values each.
inline void sincos(const double* q, int count, double* sine, double* cosine) {
  int i = 0;
  Pack s, c;
  for (; i + 4 <= count; i += 4) {
    sincos_lanes(load(q + i), 4, s, c);
    store(sine + i, s);
    store(cosine + i, c);
  }
  if (i == count) return;
  Pack x = {};
  for (int l = 0; l < count - i; ++l) x[l] = q[i + l];
  sincos_lanes(x, count - i, s, c);
  for (int l = 0; l < count - i; ++l) {
    sine[i + l] = s[l];
    cosine[i + l] = c[l];
  }
}

STILLREACH_END
